"""Linear viscoelasticity by Prony series: relaxation and creep of one modulus, and of an isotropic material.

A relaxation modulus M(t) = M_0 (1 - sum g_i (1 - exp(-t/tau_i))) and a creep compliance J(t) = J_0 + sum J_i (1 - exp(-t/lambda_i)) say the
same of one material: their s-multiplied transforms are each other's reciprocals, rational functions whose poles and zeros alternate on the
negative axis. So either follows from the other exactly, by one root in each interval between neighbouring times (Gross 1953; Ferry 1980).
Springs in series add their compliances: that makes one modulus of several.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import InputError, Problem, require
from contactlaws.material import Material, problems_with

FloatArray = npt.NDArray[np.float64]

#: fractions below are round-off and left out; times closer than this (relative) are one
NEGLIGIBLE, SAME_TIME = 1e-13, 1e-9
#: no zero is as near its pole, over the pole: about the smallest fraction times the smallest relative distance of two times
NEAREST = 1e-30


class Relaxation(NamedTuple):
    """A relaxation modulus M(t) = M_0 (1 - sum g_i (1 - exp(-t/tau_i))).

    >>> modulus = Relaxation(2.0, (0.5,), (3.0,))
    >>> modulus.long_term, modulus.creep().times
    (1.0, (6.0,))
    """

    instantaneous: float  # M_0
    fractions: tuple[float, ...] = ()  # g_i, of M_0
    times: tuple[float, ...] = ()  # tau_i in s, rising

    @property
    def long_term(self) -> float:
        """M(infinity)."""
        return self.instantaneous * (1.0 - math.fsum(self.fractions))

    def at(self, time: npt.ArrayLike) -> FloatArray:
        """M at times (s) since a jump of the strain."""
        past = np.asarray(time, dtype=np.float64)[..., None] / np.array(self.times)
        return np.asarray(self.instantaneous * (1.0 + (np.array(self.fractions) * np.expm1(-past)).sum(axis=-1)))

    def creep(self) -> Creep:
        """The compliance of the same material; terms of no size are left out. Raises `InputError`."""
        require(problems_with_modulus(self))
        kept = [(self.instantaneous * g, t) for g, t in zip(self.fractions, self.times, strict=True) if g > 0.0]
        m, tau = np.array(kept).reshape(-1, 2).T

        def rising(t: float, beyond: FloatArray) -> float:
            return self.long_term - float((m * tau / beyond).sum())

        ends = [*tau[1:].tolist(), 2.0 * float(tau.max(initial=0.0) + (m * tau).sum() / self.long_term)]
        jumps, times = _terms(rising, m * tau, tau, list(zip(tau.tolist(), ends[: tau.size], strict=True)))
        return Creep(1.0 / self.instantaneous, jumps, times)

    def scaled(self, factor: float) -> Relaxation:
        """This modulus times a number."""
        return self._replace(instantaneous=self.instantaneous * factor)


class Creep(NamedTuple):
    """A creep compliance J(t) = J_0 + sum J_i (1 - exp(-t/lambda_i))."""

    instantaneous: float  # J_0
    jumps: tuple[float, ...] = ()  # J_i
    times: tuple[float, ...] = ()  # lambda_i in s, rising

    def at(self, time: npt.ArrayLike) -> FloatArray:
        """J at times (s) since a jump of the stress."""
        past = np.asarray(time, dtype=np.float64)[..., None] / np.array(self.times)
        return self.instantaneous - np.asarray((np.array(self.jumps) * np.expm1(-past)).sum(axis=-1))

    def relaxation(self) -> Relaxation:
        """The modulus of the same material."""
        kept = [(jump, t) for jump, t in zip(self.jumps, self.times, strict=True) if jump > 0.0]
        j, late = np.array(kept).reshape(-1, 2).T

        def rising(t: float, beyond: FloatArray) -> float:
            return -t * float((j / beyond).sum()) - self.instantaneous

        first = 0.5 * float(late.min(initial=1.0)) * self.instantaneous / (self.instantaneous + math.fsum(self.jumps))
        moduli, times = _terms(rising, j * late, late, list(zip([first, *late[:-1].tolist()], late.tolist(), strict=False)))
        return series(1.0 / self.instantaneous, [m * self.instantaneous for m in moduli], times)

    def scaled(self, factor: float) -> Creep:
        """This compliance times a number."""
        return Creep(self.instantaneous * factor, tuple(factor * jump for jump in self.jumps), self.times)

    def __add__(self, other: object) -> Creep:  # type: ignore[override]
        """Two compliances in series."""
        if not isinstance(other, Creep):
            return NotImplemented
        jumps, times = _merged([*self.jumps, *other.jumps], [*self.times, *other.times])
        return Creep(self.instantaneous + other.instantaneous, jumps, times)


def _terms(
    rising: Callable[[float, FloatArray], float], weights: FloatArray, poles: FloatArray, intervals: Sequence[tuple[float, float]]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Sizes and times of the reciprocal's terms: one zero in each interval. `rising` has the slope sum weights/(t - poles)^2."""
    sizes, times = [], []
    for low, high in intervals:
        time, beyond = _zero(rising, poles, low, high)
        times.append(time)
        sizes.append(1.0 / (time * float((weights / beyond**2).sum())))
    return tuple(sizes), tuple(times)


def _zero(rising: Callable[[float, FloatArray], float], poles: FloatArray, low: float, high: float) -> tuple[float, FloatArray]:
    """The zero between two poles (or a bound and a pole), and how far it lies beyond each pole.

    A small term's zero is so near its pole that their difference would be lost: the distance from the nearer one is what is sought.
    """
    from scipy.optimize import brentq  # takes a tenth of a second, which a curve without a history need not wait for

    middle = 0.5 * (low + high)
    end, side = (low, 1.0) if rising(middle, middle - poles) > 0.0 else (high, -1.0)

    def place(x: float) -> tuple[float, FloatArray]:
        away = side * math.exp(x)
        return end + away, (end - poles) + away

    first, last = math.log(NEAREST * end), math.log(0.75 * (high - low))  # beyond the middle, which round-off moves
    return place(float(brentq(lambda x: rising(*place(x)), first, last, xtol=1e-13, rtol=1e-14)))


def _merged(sizes: Sequence[float], times: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Terms in the order of their times, those of one time added."""
    size: list[float] = []
    time: list[float] = []
    for t, g in sorted(zip(times, sizes, strict=True)):
        if time and t - time[-1] <= SAME_TIME * t:
            size[-1] += g
        else:
            size.append(g)
            time.append(t)
    return tuple(size), tuple(time)


def series(instantaneous: float, fractions: Sequence[float], times: Sequence[float]) -> Relaxation:
    """A `Relaxation` with its terms in order, those of one time added and those of no size left out."""
    kept = [(float(g), float(t)) for g, t in zip(*_merged(fractions, times), strict=True) if g > NEGLIGIBLE]
    return Relaxation(instantaneous, tuple(g for g, _ in kept), tuple(t for _, t in kept))


class PronyViscoelastic(NamedTuple):
    """Isotropic linear viscoelastic material: instantaneous constants, and by how much and when shear and bulk modulus relax.

    bulk_fractions None: both relax together, so Poisson's ratio stays as it is. A bulk modulus that stays has fractions 0.

    >>> pvdf = uniaxial(Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,)), 0.4314, constant_bulk=True)
    >>> round(pvdf.shear.instantaneous / 1e6, 2), round(pvdf.shear_fractions[0], 4), round(pvdf.relaxation_times[0], 4)
    (618.45, 0.2369, 1.7805)
    """

    youngs_modulus: float  # Pa, instantaneous
    poissons_ratio: float  # -, instantaneous
    relaxation_times: tuple[float, ...]  # s, rising
    shear_fractions: tuple[float, ...]  # of the instantaneous shear modulus
    bulk_fractions: tuple[float, ...] | None = None  # of the instantaneous bulk modulus

    @property
    def instantaneous(self) -> Material:
        """What an infinitely fast press meets."""
        return Material(self.youngs_modulus, self.poissons_ratio)

    @property
    def long_term(self) -> Material:
        """What an infinitely slow press meets."""
        bulk, shear = self.bulk.long_term, self.shear.long_term
        return Material(9.0 * bulk * shear / (3.0 * bulk + shear), (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear))

    @property
    def shear(self) -> Relaxation:
        """G(t) in Pa."""
        return Relaxation(0.5 * self.youngs_modulus / (1.0 + self.poissons_ratio), self.shear_fractions, self.relaxation_times)

    @property
    def bulk(self) -> Relaxation:
        """K(t) in Pa."""
        fractions = self.shear_fractions if self.bulk_fractions is None else self.bulk_fractions
        return Relaxation(self.youngs_modulus / (3.0 - 6.0 * self.poissons_ratio), fractions, self.relaxation_times)

    @property
    def reduced(self) -> Relaxation:
        """E/(1 - nu^2) as a function of time, in Pa: all that a flat contact of a half-space knows of the material.

        4/E* = 1/G + 3/(3 K + G) holds between operators too, so it is compliances that add.
        """
        if self.bulk_fractions is None:
            return Relaxation(self.instantaneous.reduced_modulus, self.shear_fractions, self.relaxation_times)
        shear, bulk = self.shear, self.bulk
        total = 3.0 * bulk.instantaneous + shear.instantaneous
        mixed = [
            (3.0 * bulk.instantaneous * k + shear.instantaneous * g) / total for k, g in zip(bulk.fractions, shear.fractions, strict=True)
        ]
        other = series(total, mixed, self.relaxation_times)
        own = series(shear.instantaneous, shear.fractions, shear.times)
        return (own.creep().scaled(0.25) + other.creep().scaled(0.75)).relaxation()


def uniaxial(modulus: Relaxation, poissons_ratio: float, constant_bulk: bool = False) -> PronyViscoelastic:
    """The material whose Young's modulus relaxes as `modulus`; poissons_ratio: the instantaneous one.

    constant_bulk: the bulk modulus stays and Poisson's ratio rises; else Poisson's ratio stays. 3/E = 1/G + 1/(3 K) between operators.
    Raises `InputError`.
    """
    made = PronyViscoelastic(modulus.instantaneous, poissons_ratio, modulus.times, modulus.fractions)
    require(problems_with_series(made))
    if not constant_bulk:
        return made
    creep = modulus.creep().scaled(3.0)
    shear = creep._replace(instantaneous=creep.instantaneous - 1.0 / (3.0 * made.bulk.instantaneous)).relaxation()
    return made._replace(relaxation_times=shear.times, shear_fractions=shear.fractions, bulk_fractions=(0.0,) * len(shear.times))


def together(one: Relaxation, two: Relaxation) -> Relaxation:
    """The reduced modulus in Pa of two bodies in contact: 1/E* = 1/E1* + 1/E2* between operators, so their compliances add.

    Raises `InputError`.
    """
    return (one.creep() + two.creep()).relaxation()


def problems_with_series(material: PronyViscoelastic) -> Iterator[Problem]:
    """Yield one `Problem` for everything that makes the constants unusable."""
    yield from problems_with(material.instantaneous)
    yield from problems_with_times(material.relaxation_times)
    for name in ("shear_fractions", "bulk_fractions"):
        fractions = getattr(material, name)
        if fractions is not None:
            yield from problems_with_fractions(name, fractions, len(material.relaxation_times))


def problems_with_modulus(modulus: Relaxation) -> Iterator[Problem]:
    """A modulus must be positive, now and in the end."""
    if not (math.isfinite(modulus.instantaneous) and modulus.instantaneous > 0.0):
        yield Problem("modulus", modulus.instantaneous, "must be a positive number of Pa", "give the instantaneous one")
    yield from problems_with_times(modulus.times)
    yield from problems_with_fractions("fractions", modulus.fractions, len(modulus.times))


def problems_with_times(times: Sequence[float]) -> Iterator[Problem]:
    """Relaxation times must be positive, and no two the same."""
    for number, time in enumerate(times, 1):
        if not (math.isfinite(time) and time > 0.0):
            yield Problem(f"relaxation_times[{number}]", time, "must be a positive number of seconds", "leave the term out, or repair it")
            return
    for number, (before, after) in enumerate(zip(times[:-1], times[1:], strict=True), 2):
        if abs(after - before) <= SAME_TIME * after:
            yield Problem(f"relaxation_times[{number}]", after, "stands there twice", "add the fractions of the two terms")
        elif after < before:
            yield Problem(f"relaxation_times[{number}]", after, f"must rise, and comes after {before:g}", "sort the terms by their times")


def problems_with_fractions(name: str, fractions: Sequence[float], terms: int) -> Iterator[Problem]:
    """Fractions must be numbers from 0 on whose sum leaves something of the modulus, one for each time."""
    if len(fractions) != terms:
        yield Problem(name, len(fractions), f"must be {terms}, one for each relaxation time", "give every term its fraction")
    for number, fraction in enumerate(fractions, 1):
        if not (math.isfinite(fraction) and 0.0 <= fraction < 1.0):
            yield Problem(f"{name}[{number}]", fraction, "must lie in [0, 1)", "it is the share of the instantaneous modulus that relaxes")
            return
    if math.fsum(fractions) >= 1.0:
        bound = "must be below 1 in sum: nothing would be left of the modulus in the end"
        yield Problem(name, math.fsum(fractions), bound, "reduce the fractions; a fluid has no long-term modulus and is not covered")


def checked_series(material: PronyViscoelastic) -> PronyViscoelastic:
    """Return `material` unchanged; raise `InputError` naming all its problems if it has any."""
    problems = list(problems_with_series(material))
    if problems:
        raise InputError(problems)
    return material
