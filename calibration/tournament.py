"""The tournament of laws: every entrant fitted to every curve and scored apart for each thing that a contact law says.

Each law is fitted to the loading, from the shallowest unloading on, and to every second unloading (counted from the deepest); what it says
of an unloading is scored on all of them and, apart, on those it has not seen. The scores of one unloading of one curve:

    force, contact_radius     at the state that the unloading leaves, relative
    unloading_stiffness       of rho = R/(d_max - d_0), relative
    unloading_shape           largest |F/F_max - that of the curve| at the same s = (d - d_0)/(d_max - d_0), each with its own d_0, F_max
    residual_overlap          (d_0 - that of the curve)/R
    recovered_energy          work given back, relative
    restitution               e = sqrt(recovered/work of the loading), the difference
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from calibration.fit import fit
from calibration.residuals import separation_overlap
from calibration.tournament_entrants import Entrant, constants_of
from calibration.unloadings import Unloading, unloading
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem
from contactlaws.path import scan, trace

FloatArray = npt.NDArray[np.float64]

#: what is scored, in the order of the table
SCORED = (
    "force",
    "contact_radius",
    "unloading_stiffness",
    "unloading_shape",
    "residual_overlap",
    "recovered_energy",
    "restitution",
)
#: fewer unloadings than this are all used in the fit
ENOUGH = 4
PERCENTILES = (50, 75, 90, 100)


class Score(NamedTuple):
    """One entrant at one unloading of one curve; None: the law or the curve does not say."""

    entrant: str
    law: str
    curve: str  # content hash
    modulus_over_yield_stress: float | None
    poissons_ratio: float | None
    overlap_over_radius: float
    plastic: bool
    inside: bool  # the range that the authors claim
    unseen: bool  # the unloading was not used in the fit
    force: float | None
    contact_radius: float | None
    unloading_stiffness: float | None
    unloading_shape: float | None
    residual_overlap: float | None
    recovered_energy: float | None
    restitution: float | None


class Fitted(NamedTuple):
    """What became of one entrant on one curve."""

    entrant: str
    curve: str
    law: Any  # the record; None if it could not be fitted
    constants: int | None  # that belong to this material
    reason: str | None  # why there is no law, or no score


@dataclass(frozen=True)
class Tournament:
    """All of it."""

    entrants: tuple[Entrant, ...]
    fits: tuple[Fitted, ...]
    scores: tuple[Score, ...]


def play(
    curves: Sequence[Curve], entrants: Iterable[Entrant], progress: Callable[[float, str], None] = lambda fraction, text: None
) -> Tournament:
    """Fit and score; a law that cannot be fitted to a curve is a result with its reason.

    Curves without unloadings are not scored, but lend their elasticity. Raises `InputError` without any unloading.
    """
    field = tuple(entrants)
    measured = [(curve, measurements(curve)) for curve in curves]
    if not any(found for _, found in measured):
        remedy = "give curves that unload to separation (--unload-from)"
        raise InputError(Problem("curves", len(curves), "hold no unloading that ends in separation: nothing to score", remedy))
    fits, scores = [], []
    scored = [(curve, found) for curve, found in measured if found]
    for number, (curve, found) in enumerate(scored):
        companion = elastic_companion(curve, curves)
        for entrant in field:
            progress(number / len(scored), f"{entrant.name}, curve {number + 1} of {len(scored)}")
            one = fitted(entrant, curve, companion)
            try:
                scores += [] if one.law is None else list(_scores(entrant, one.law, curve, found))
            except (ArithmeticError, ValueError) as error:
                one = one._replace(reason=str(error))
            fits.append(one)
    return Tournament(field, tuple(fits), tuple(scores))


def fitted(entrant: Entrant, curve: Curve, companion: Curve | None) -> Fitted:
    """The entrant's law for one curve; `companion` shows the same material's elasticity."""
    try:
        taken = training(curve)
        taken = taken if entrant.deepest is None else up_to(taken, entrant.deepest * curve.radius)
        given = [taken, companion] if entrant.law == "edmans_sinka" and companion is not None else [taken]
        with np.errstate(invalid="ignore"):  # a constant that a curve says nothing about has no error
            found = fit(given, entrant.law, fixed=entrant.fixed, weights=entrant.weights, free=entrant.free)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        return Fitted(entrant.name, curve.content_hash, None, None, str(error))
    return Fitted(entrant.name, curve.content_hash, found.law, constants_of(found.law, len(found.free)), None)


def training(curve: Curve) -> Curve:
    """The loading from the shallowest unloading on, over the overlaps that are scored, and every second unloading from the deepest."""
    starts = [float(curve.overlap[curve.rows(branch)][0]) for branch in curve.unloadings]
    return _with(curve, seen(curve), np.inf, min(starts, default=0.0) * (1.0 - 1e-9))


def seen(curve: Curve) -> list[int]:
    """Numbers of the unloadings that are used in the fit."""
    order = sorted(curve.unloadings, key=lambda branch: -curve.overlap[curve.rows(branch)][0])
    return sorted(order if len(order) < ENOUGH else order[::2])


def up_to(curve: Curve, deepest: float) -> Curve:
    """The part of a curve up to an overlap (m)."""
    deepest *= 1.0 + 1e-9
    return _with(curve, [branch for branch in curve.unloadings if curve.overlap[curve.rows(branch)][0] <= deepest], deepest)


def _with(curve: Curve, branches: Sequence[int], deepest: float, shallowest: float = 0.0) -> Curve:
    """The loading between two overlaps (m; all of it where that leaves fewer than 3 rows) and some unloadings, numbered anew."""
    loading = np.flatnonzero((curve.branch == 0) & (curve.overlap >= shallowest) & (curve.overlap <= deepest))
    loading = loading if loading.size > 2 else np.flatnonzero(curve.branch == 0)
    rows = np.concatenate([loading, *(np.arange(curve.rows(branch).start, curve.rows(branch).stop) for branch in branches)]).astype(int)
    numbers = np.concatenate([np.zeros(loading.size), *(np.full(_size(curve, branch), k) for k, branch in enumerate(branches, 1))])
    columns = {name: value[rows] for name in Curve.COLUMNS if name != "branch" and (value := getattr(curve, name)) is not None}
    rest = ("radius", "aspect", "material", "yield_overlap", "yield_place", "errors", "stopped", "provenance")
    return Curve(**columns, branch=numbers.astype(np.int64), **{name: getattr(curve, name) for name in rest})


def _size(curve: Curve, branch: int) -> int:
    return curve.rows(branch).stop - curve.rows(branch).start


def elastic_companion(curve: Curve, curves: Iterable[Curve]) -> Curve | None:
    """The elastic loading of the same shape and Poisson's ratio with the modulus of `curve`: forces go with it.

    From the curve that stays elastic deepest, up to its first yield; None if none does so for three rows.
    """
    material = curve.material
    if material is None:
        return None
    alike = [other for other in curves if other.material is not None and other.aspect == curve.aspect]
    alike = [other for other in alike if other.material and abs(other.material.poissons_ratio - material.poissons_ratio) < 1e-12]
    source = max(alike, key=_elastic_depth, default=None)
    if source is None or source.material is None:
        return None
    scale = curve.radius / source.radius
    factor = material.youngs_modulus / source.material.youngs_modulus * scale**2
    keep = (source.branch == 0) & (source.overlap <= _elastic_depth(source) * source.radius)
    if np.count_nonzero(keep) < 3:
        return None
    return Curve(
        time=source.time[keep],
        overlap=scale * source.overlap[keep],
        force=factor * source.force[keep],
        branch=source.branch[keep],
        radius=curve.radius,
        contact_radius=None if source.contact_radius is None else scale * source.contact_radius[keep],
        aspect=curve.aspect,
        material=material.elastic,
        errors=source.errors,
    )


def _elastic_depth(curve: Curve) -> float:
    """Overlap over radius up to which the body stayed elastic."""
    largest = float(curve.overlap[curve.rows(0)][-1])
    return (largest if curve.yield_overlap is None else min(largest, curve.yield_overlap)) / curve.radius


class Measurement(NamedTuple):
    """An unloading with what a score needs besides."""

    unloading: Unloading
    restitution: float
    s: FloatArray
    ratio: FloatArray  # F/F_max at s
    unseen: bool


def measurements(curve: Curve) -> list[Measurement]:
    """All unloadings of a curve that end in separation."""
    used = set(seen(curve))
    loading = work_of_loading(curve)
    found = []
    for branch in curve.unloadings:
        one = unloading(curve, branch)
        if one is None:
            continue
        part = curve.rows(branch)
        s = (curve.overlap[part] - one.separation_overlap) / (one.overlap - one.separation_overlap)
        e = float(np.sqrt(one.recovered_energy / loading(one.overlap)))
        found.append(Measurement(one, e, s, curve.force[part] / one.force, branch not in used))
    return found


def work_of_loading(curve: Curve) -> Callable[[float], float]:
    """Work in J up to an overlap (m): a cubic through the rows, and up to the first of them a power of the overlap."""
    rows = curve.rows(0)
    pressed = (curve.overlap[rows] > 0.0) & (curve.force[rows] > 0.0)
    overlap, force = curve.overlap[rows][pressed], curve.force[rows][pressed]
    power = np.log(force[1] / force[0]) / np.log(overlap[1] / overlap[0])
    before = force[0] * overlap[0] / (np.clip(power, 1.0, 1.5) + 1.0)
    integrand = PchipInterpolator(overlap, force)
    return lambda top: float(before + integrand.integrate(overlap[0], top))


def _scores(entrant: Entrant, law: Any, curve: Curve, found: Sequence[Measurement]) -> Iterator[Score]:
    material = curve.material
    strength = None if material is None else material.yield_stress
    stiffness = None if material is None or strength is None else material.youngs_modulus / strength
    for one in found:
        overlap = one.unloading.overlap
        yield Score(
            entrant.name,
            entrant.law,
            curve.content_hash,
            stiffness,
            None if material is None else material.poissons_ratio,
            overlap / curve.radius,
            bool(one.unloading.plastic),
            entrant.inside(law, curve, overlap),
            one.unseen,
            *differences(law, curve, one),
        )


def differences(law: Any, curve: Curve, one: Measurement) -> tuple[float | None, ...]:
    """The scores of a law at one unloading, in the order of `SCORED`."""
    curve_says, top = one.unloading, one.unloading.overlap
    at = scan(law, [top])
    radius = float(at.contact_radius[0])
    separation = separation_overlap(law, top)
    path = np.concatenate(([top], np.maximum(separation + one.s * (top - separation), 1e-300)))
    ratio = trace(law, path).force[1:] / at.force[0]
    stored, dissipated = float(at.stored_energy[0]), float(at.dissipated_energy[0])
    values = (
        float(at.force[0]) / curve_says.force - 1.0,
        None if curve_says.contact_radius is None else radius / curve_says.contact_radius - 1.0,
        (top - curve_says.separation_overlap) / (top - separation) - 1.0 if separation < top else None,
        float(np.max(abs(ratio - one.ratio))),
        (separation - curve_says.separation_overlap) / curve.radius,
        stored / curve_says.recovered_energy - 1.0,
        float(np.sqrt(max(0.0, stored / (stored + dissipated)))) - one.restitution if stored + dissipated > 0.0 else None,
    )
    return tuple(None if value is None or not np.isfinite(value) else value for value in values)


class Standing(NamedTuple):
    """How good one entrant is in one quantity over some of the scores: percentiles of the absolute error."""

    entrant: str
    law: str
    quantity: str
    points: int
    percentiles: tuple[float, ...] | None  # at PERCENTILES; None without a score


def standings(
    scores: Iterable[Score], entrants: Sequence[str], keep: Callable[[Score], bool] = lambda score: True
) -> dict[tuple[str, str], Standing]:
    """By entrant and quantity, over the scores that `keep` lets pass."""
    kept: dict[str, list[Score]] = {name: [] for name in entrants}
    for score in scores:
        if score.entrant in kept and keep(score):
            kept[score.entrant].append(score)
    return {(name, quantity): _standing(name, quantity, rows) for name, rows in kept.items() for quantity in SCORED}


def _standing(name: str, quantity: str, rows: Sequence[Score]) -> Standing:
    values = [abs(value) for row in rows if (value := getattr(row, quantity)) is not None]
    found = tuple(float(value) for value in np.percentile(values, PERCENTILES)) if values else None
    return Standing(name, rows[0].law if rows else "", quantity, len(values), found)


class Choice(NamedTuple):
    """A law that is good enough, and what it costs."""

    entrant: str
    error: float
    nanoseconds: float


def cheapest_law(
    tolerance: float,
    quantity: str,
    scores: Iterable[Score],
    nanoseconds: Mapping[str, float],
    largest_overlap: float = np.inf,
    percentile: float = 100.0,
) -> Choice:
    """The entrant of least cost per contact (`nanoseconds`, by name) whose error in `quantity` is at most `tolerance`.

    The error is the `percentile` of the scores up to `largest_overlap` (over the radius): at 100, the default, the worst. Raises
    `InputError` for an unknown quantity, or if no entrant is that good; it then names the best.
    """
    if quantity not in SCORED:
        raise InputError(Problem("quantity", quantity, f"must be one of {', '.join(SCORED)}", "choose one"))
    if not tolerance > 0.0:
        raise InputError(Problem("tolerance", tolerance, "must be above 0", "0.01 is 1 %"))
    errors: dict[str, list[float]] = {}
    for score in scores:
        value = getattr(score, quantity)
        if score.entrant in nanoseconds and score.overlap_over_radius <= largest_overlap * (1.0 + 1e-9):
            errors.setdefault(score.entrant, []).append(np.inf if value is None else abs(value))
    found = [Choice(name, float(np.percentile(values, percentile, method="higher")), nanoseconds[name]) for name, values in errors.items()]
    good = [choice for choice in found if choice.error <= tolerance]
    if not good:
        best = min(found, key=lambda choice: choice.error, default=None)
        said = f"no law is that good in {quantity}: the best, {best.entrant}, is at {best.error:.3g}" if best else "no curve was scored"
        raise InputError(Problem("tolerance", tolerance, said, "ask for less, or for smaller overlaps"))
    return min(good, key=lambda choice: choice.nanoseconds)
