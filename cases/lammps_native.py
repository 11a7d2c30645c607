"""The law of LAMMPS's own that comes nearest to a fitted one: its constants by least squares, and how far it stays away.

Two candidates, both run by the tests: `hertz/material` for what gives back all the work it took, `mdr` for what does not. Their forces are
computed by our own records of them; `cases.lammps_replay` asks LAMMPS itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cases.benchmarks.lammps_input import Styles, granular_hertz, granular_mdr
from contactlaws.curve import Curve
from contactlaws.dispatch import law_of
from contactlaws.elastic import Hertz
from contactlaws.errors import Problem, require
from contactlaws.fitted import FittedLaw
from contactlaws.material import Material
from contactlaws.path import scan, trace
from contactlaws.rivals.mdr import mdr_of

FloatArray = npt.NDArray[np.float64]

#: overlaps from which a law is unloaded, over its largest
PEAKS = (0.25, 0.5, 0.75, 1.0)
ROWS = 40
#: dissipated over stored energy at the largest overlap, from which a law is no longer elastic: far above round-off
PLASTIC = 1e-6
#: E/Y to which a fit may go: below, a sphere yields nowhere in the range of `mdr`; above, nothing elastic is left to see
MODULUS_OVER_YIELD = (2.0, 1e6)


class Branch(NamedTuple):
    """A loading (peak None), or an unloading from `peak`."""

    overlap: FloatArray  # m, of one body
    force: FloatArray  # N
    peak: float | None  # m


class Misfit(NamedTuple):
    """Differences of force over the largest force of their branch."""

    mean: float  # root mean square
    worst: float


class Native(NamedTuple):
    """A law that LAMMPS has, for one material."""

    record: Any  # the same law as a record of ours
    material: Material
    styles: Styles  # for LAMMPS


def branches_of(law: object, max_overlap: float, peaks: Iterable[float] = PEAKS) -> tuple[Branch, ...]:
    """Loading of a law up to `max_overlap` (m), and unloadings from `peaks` times that down to overlap 0."""
    down = np.linspace(1.0, 0.0, ROWS)
    loading = Branch(max_overlap * np.linspace(0.0, 1.0, ROWS), np.zeros(ROWS), None)
    paths = (loading, *(Branch(peak * max_overlap * down, np.zeros(ROWS), peak * max_overlap) for peak in peaks))
    return tuple(path._replace(force=force_along(law, path)) for path in paths)


def branches_of_curve(curve: Curve) -> tuple[Branch, ...]:
    """Loading and unloadings of a computed or measured curve."""
    found = []
    for number in range(int(curve.branch.max()) + 1):
        rows = curve.branch == number
        overlap = curve.overlap[rows]
        found.append(Branch(overlap, curve.force[rows], float(overlap[0]) if number else None))
    return tuple(found)


def force_along(law: object, branch: Branch) -> FloatArray:
    """Force in N of a law along the path of a branch."""
    if branch.peak is None:
        return trace(law, branch.overlap).force
    return trace(law, np.concatenate([[branch.peak], branch.overlap])).force[1:]


def misfit(law: object, branches: Sequence[Branch]) -> Misfit:
    """How far a law is from branches."""
    away = np.concatenate([_away(law, branch) for branch in branches])
    return Misfit(float(np.sqrt(np.mean(away**2))), float(np.abs(away).max()))


def _away(law: object, branch: Branch) -> FloatArray:
    return (force_along(law, branch) - branch.force) / branch.force.max()


def is_plastic(law: object, max_overlap: float) -> bool:
    """Whether the law keeps some of the work of a loading to `max_overlap` (m)."""
    energy = scan(law, np.array([0.5, 1.0]) * max_overlap)
    return float(energy.dissipated_energy[-1]) > PLASTIC * float(energy.stored_energy[-1])


def nearest(fitted: FittedLaw, branches: Sequence[Branch]) -> Native:
    """The law of LAMMPS's own that is nearest to `branches`; raises `InputError` if none can be."""
    require(problems_with(fitted))
    radius, nu = fitted.law.radius, _poissons_ratio(fitted)
    assert nu is not None
    modulus = _hertz_modulus(branches[0], radius)
    if not is_plastic(fitted.law, fitted.max_overlap):
        material = Material(modulus * (1.0 - nu * nu), nu)
        return Native(Hertz(radius, modulus), material, granular_hertz(material))
    material = _plastic(branches, radius, nu, _beginning(fitted, branches, modulus, nu))
    assert material.yield_stress is not None
    return Native(mdr_of(radius, material.youngs_modulus, nu, material.yield_stress), material, granular_mdr(material))


def problems_with(fitted: FittedLaw) -> Iterator[Problem]:
    """Why there is no law of LAMMPS's own for one of ours."""
    if law_of(fitted.law).in_time:
        yield Problem("law", fitted.name, "depends on time, and LAMMPS has no such law that was tried", "export a law of rest")
    elif _poissons_ratio(fitted) is None:
        yield Problem("material", None, "is not in the law's file, and LAMMPS asks for Poisson's ratio", "fit again with --poissons-ratio")


def _poissons_ratio(fitted: FittedLaw) -> float | None:
    if fitted.material is not None:
        return fitted.material.poissons_ratio
    return getattr(fitted.law, "poissons_ratio", None)


def _hertz_modulus(loading: Branch, radius: float) -> float:
    """E/(1 - nu^2) in Pa of the Hertz law nearest to a loading: linear least squares."""
    unit = 4.0 / 3.0 * math.sqrt(radius) * loading.overlap**1.5
    return float(unit @ loading.force / (unit @ unit))


def _beginning(fitted: FittedLaw, branches: Sequence[Branch], modulus: float, nu: float) -> tuple[float, float]:
    """E and Y in Pa to start from: the material's own; else Y from the pressure at the largest overlap, where it is about 2.8 Y."""
    material, loading = fitted.material, branches[0]
    if material is not None and material.yield_stress is not None:
        return material.youngs_modulus, material.yield_stress
    area = 2.0 * math.pi * fitted.law.radius * loading.overlap[-1]
    return 10.0 * modulus * (1.0 - nu * nu), float(loading.force[-1]) / (2.8 * area)


def _plastic(branches: Sequence[Branch], radius: float, nu: float, start: tuple[float, float]) -> Material:
    """E and Y of `mdr` nearest to the branches, each of which counts alike."""
    from scipy.optimize import least_squares  # takes as long to load as all laws together

    def away(logarithms: FloatArray) -> FloatArray:
        strength, ratio = np.exp(logarithms)
        law = mdr_of(radius, float(strength * ratio), nu, float(strength))
        return np.concatenate([_away(law, branch) / math.sqrt(branch.overlap.size) for branch in branches])

    low, high = np.log(MODULUS_OVER_YIELD)
    first = math.log(start[0] / start[1])
    found = least_squares(
        away, (math.log(start[1]), min(max(first, low + 0.1), high - 0.1)), bounds=((-np.inf, low), (np.inf, high)), diff_step=1e-4
    )
    strength, ratio = (float(value) for value in np.exp(found.x))
    return Material(strength * ratio, nu, strength)
