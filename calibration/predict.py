"""Curve, law and error of any material in the range of the atlas, in milliseconds; finite elements run only if they are asked for."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from calibration import atlas_errors
from calibration.atlas import Atlas, shipped
from calibration.atlas_columns import starts_of
from calibration.atlas_errors import SHARES
from calibration.atlas_response import Interpolator, Response
from calibration.fit import fit
from calibration.recipes import recipe_for
from calibration.residuals import follow
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem, require
from contactlaws.fitted import FittedLaw
from contactlaws.material import Material, problems_with
from contactlaws.tabulate import from_curve
from contactlaws.version import code_version
from contactlaws.whole_range import whole_range

FloatArray = npt.NDArray[np.float64]

DEFAULT_LAW = "tabulated"
#: its constants are its own: it takes nothing from the atlas but its error
CLOSED_LAW = "whole_range"
#: rows of a predicted loading: each overlap over the one before
ROW_GROWTH = 1.1
#: a tabulated law has an unloading at each THIN-th row of a response below the atlas's own
THIN = 3
#: times first yield from which on unloadings are stored: nearer, the little that is dissipated is lost in the errors of the shapes
SAFE = 1.5
#: where finite elements are unloaded from if the user does not say
DEFAULT_STARTS = (0.01, 0.02, 0.03, 0.04, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
#: overlaps over the radius below are lost in the round-off of coordinates in any use of the curve
SMALLEST_OVERLAP = 1e-7


@dataclass(frozen=True)
class Prediction:
    """What the atlas says about one material. Errors are relative, of the exponent absolute; named as in `contactlaws.curve.QUANTITIES`."""

    curve: Curve  # loading and the unloadings asked for; its `errors` are those below
    law: FittedLaw
    errors: Mapping[str, float]  # the largest to be expected in the asked range: interpolation and finite elements together
    interpolation: Mapping[str, float]  # from what leaving out neighbours in the atlas changes
    finite_elements: Mapping[str, float]  # the curves' own estimates
    law_errors: Mapping[str, float]  # largest difference of the law from this curve: force, contact radius, force on unloading over F_max
    atlas: str | None  # content hash of the atlas; None: finite elements were run for this very material


def predict(
    material: Material,
    *,
    radius: float = 1.0,
    unload_from: Sequence[float] | None = None,
    max_overlap: float | None = None,
    law: str = DEFAULT_LAW,
    atlas: Atlas | None = None,
    compute: bool = False,
    progress: Callable[[float, str], None] | None = None,
) -> Prediction:
    """Curve and law of a sphere of `material` (SI) and `radius` (m), from the shipped atlas or another one.

    unload_from: overlaps over the radius; without it those of the atlas up to `max_overlap`. max_overlap: overlap over the radius; without
    it the largest of `unload_from`, else of the atlas. law: one that can be fitted; "tabulated" is exact on the curve.
    Raises `InputError` outside the atlas's range, saying what that is; with `compute` finite elements are run there instead, which takes
    seconds: `progress` is told how far they are. They may end early, and then `curve.stopped` says why.

    >>> steel = Material(youngs_modulus=210e9, poissons_ratio=0.3, yield_stress=420e6)
    >>> found = predict(steel, radius=1e-3, unload_from=[0.05])
    >>> 370.0 < float(found.curve.force.max()) < 390.0, found.errors["force"] < 0.01
    (True, True)
    """
    require([*problems_with(material), *_problems_with_options(radius, unload_from, max_overlap, law)])
    source = shipped() if atlas is None else atlas
    outside = list(problems_outside(source, material, unload_from, max_overlap))
    if outside and compute:
        return _computed(material, radius, unload_from, max_overlap, law, progress)
    require(outside)
    deepest, starts = _asked(source, unload_from, max_overlap)
    ratio = modulus_ratio(material)
    response = interpolator(source)(ratio, material.poissons_ratio)
    expected = atlas_errors.expected(source, ratio, material.poissons_ratio, deepest)
    facts = {
        "source": "atlas",
        "atlas": source.content_hash,
        "code": code_version(),
        "errors": {"interpolation": dict(expected.interpolation), "finite_elements": dict(expected.finite_elements)},
    }
    curve = curve_of(response, material, radius, starts, deepest, expected.total, facts)
    made = _law(law, curve, response, material, facts)
    parts = (expected.total, expected.interpolation, expected.finite_elements)
    return Prediction(curve, made, *parts, law_errors(made.law, curve), source.content_hash)


def modulus_ratio(material: Material) -> float | None:
    """E/Y; None for a material that never yields."""
    return None if material.yield_stress is None else material.youngs_modulus / material.yield_stress


@functools.lru_cache(maxsize=4)
def _interpolator(atlas_id: int) -> list[Interpolator]:
    return []


def interpolator(atlas: Atlas) -> Interpolator:
    """The interpolator of an atlas, made once."""
    kept = _interpolator(id(atlas))
    if not kept or kept[0].atlas is not atlas:
        kept[:] = [Interpolator(atlas)]
    return kept[0]


def problems_outside(atlas: Atlas, material: Material, unload_from: Sequence[float] | None, max_overlap: float | None) -> Iterator[Problem]:
    """What of a material and a programme lies outside an atlas."""
    remedy = "ask for finite elements (compute=True, on the command line --compute)"
    ratio, ratios, nus = modulus_ratio(material), atlas.modulus_ratios, atlas.poissons_ratios
    if ratio is not None and not ratios[0] * (1.0 - 1e-9) <= ratio <= ratios[-1] * (1.0 + 1e-9):
        yield Problem("youngs_modulus / yield_stress", ratio, f"the atlas holds {ratios[0]:g} to {ratios[-1]:g}", remedy)
    if not nus[0] <= material.poissons_ratio <= nus[-1]:
        yield Problem("poissons_ratio", material.poissons_ratio, f"the atlas holds {nus[0]:g} to {nus[-1]:g}", remedy)
    for name, overlaps in (("unload_from", unload_from or ()), ("max_overlap", () if max_overlap is None else (max_overlap,))):
        for value in overlaps:
            if value > atlas.depths[-1] * (1.0 + 1e-9):
                yield Problem(name, value, f"the atlas ends at an overlap of {atlas.depths[-1]:g} of the radius", remedy)


def _problems_with_options(radius: float, unload_from: Sequence[float] | None, max_overlap: float | None, law: str) -> Iterator[Problem]:
    if not (math.isfinite(radius) and radius > 0.0):
        yield Problem("radius", radius, "must be a positive length", "give metres")
    for name, overlaps in (("unload_from", unload_from or ()), ("max_overlap", () if max_overlap is None else (max_overlap,))):
        for value in overlaps:
            if not SMALLEST_OVERLAP <= value < 1.0:
                yield Problem(
                    name, value, f"overlap over radius must lie in [{SMALLEST_OVERLAP:g}, 1)", "runs from 1e-5 to 0.5 are verified"
                )
    if law != CLOSED_LAW:
        try:
            recipe_for(law)
        except InputError as error:
            yield from error.problems


def deepest_asked(unload_from: Sequence[float] | None, max_overlap: float | None, otherwise: float = DEFAULT_STARTS[-1]) -> float:
    """The deepest of all overlaps asked for, over the radius; `otherwise` if there are none."""
    return max([*(unload_from or ()), *(() if max_overlap is None else (max_overlap,))], default=otherwise)


def _asked(atlas: Atlas, unload_from: Sequence[float] | None, max_overlap: float | None) -> tuple[float, FloatArray]:
    """The deepest overlap and the starts of unloadings, over the radius."""
    deepest = deepest_asked(unload_from, max_overlap, float(atlas.depths[-1]))
    starts = np.unique(unload_from) if unload_from is not None and len(unload_from) else atlas.starts[atlas.starts <= deepest]
    return float(min(deepest, atlas.depths[-1])), np.minimum(starts, atlas.depths[-1])


def curve_of(
    response: Response,
    material: Material,
    radius: float,
    starts: FloatArray,
    deepest: float,
    errors: Mapping[str, float],
    facts: Mapping[str, Any],
) -> Curve:
    """The curve of a response: rows evenly spread over the logarithm of the overlap, from well before first yield, with the `starts`."""
    first = min(float(response.depths[0]), 0.1 * float(min(starts, default=deepest)), 0.1 * deepest)
    count = math.ceil(math.log(deepest / first) / math.log(ROW_GROWTH)) + 1
    own = np.geomspace(first, deepest, count)
    apart = abs(np.log(own[:, None] / starts)).min(axis=1) > 0.2 * math.log(ROW_GROWTH) if starts.size else np.ones(count, dtype=bool)
    depths = np.union1d(np.append(own[apart], deepest), starts)
    depths = depths[np.append(np.diff(depths) > 1e-9 * deepest, True)]
    scale = material.youngs_modulus * radius**2
    recovered, at_start = response.recovered(starts)[:, None], (response.force(starts)[:, None], response.area(starts)[:, None])
    overlap = np.concatenate(([0.0], depths, (starts[:, None] - recovered * (1.0 - SHARES)).ravel()))
    force = np.concatenate(([0.0], response.force(depths), (at_start[0] * response.shape(starts, SHARES)).ravel()))
    area = np.concatenate(([0.0], response.area(depths), (at_start[1] * response.edge(starts, SHARES)).ravel()))
    travelled = np.append(0.0, np.cumsum(abs(np.diff(overlap))))
    plastic = material.yield_stress is not None and response.yield_depth is not None and response.yield_depth < deepest
    return Curve(
        time=travelled / deepest,
        overlap=np.maximum(overlap, 0.0) * radius,
        force=force * scale,
        branch=np.repeat(np.arange(starts.size + 1), [depths.size + 1] + [SHARES.size] * starts.size),
        radius=radius,
        contact_radius=np.sqrt(area) * radius,
        material=material,
        yield_overlap=response.yield_depth * radius if plastic and response.yield_depth is not None else None,
        errors=errors,
        provenance=facts,
    )


def _law(name: str, curve: Curve, response: Response, material: Material, facts: Mapping[str, Any]) -> FittedLaw:
    """The law of the predicted curve; a closed one is fitted to it and to the curve of the same body without yield stress."""
    deepest = float(curve.overlap.max()) / curve.radius
    if name == CLOSED_LAW:
        return FittedLaw(whole_range(material, curve.radius), float(curve.overlap.max()), material, (curve.content_hash,), origin=facts)
    if name != DEFAULT_LAW:
        elastic = curve_of(response.elastic, material.elastic, curve.radius, np.zeros(0), deepest, curve.errors, facts)
        return replace(fit([curve, elastic], law=name).fitted, origin=facts)
    starts = np.union1d(_stored(response, deepest), starts_of(curve))
    starts = starts[np.append(np.diff(np.log(starts)) > 1e-6, True)]
    whole = curve_of(response, material, curve.radius, starts, deepest, curve.errors, facts)
    return FittedLaw(from_curve(whole), float(whole.overlap.max()), material, (curve.content_hash,), origin=facts)


def _stored(response: Response, deepest: float) -> FloatArray:
    """Where a tabulated law needs unloadings: at the atlas's own overlaps, and below them down to first yield."""
    if response.yield_depth is None:
        return np.zeros(0)
    starts = np.concatenate((response.below[::-1][2::THIN][::-1], response.starts[response.below.size :]))
    return starts[(starts > SAFE * response.yield_depth) & (starts <= deepest)]


def law_errors(law: Any, curve: Curve) -> dict[str, float]:
    """Largest relative difference of force and contact radius along the loading, of the force on unloading over that at its start."""
    assert curve.contact_radius is not None
    rows, found = slice(2, curve.rows(0).stop), follow(law, curve, 0)
    errors = {
        "force": float(abs(found.force[rows] / curve.force[rows] - 1.0).max()),
        "contact_radius": float(abs(found.contact_radius[rows] / curve.contact_radius[rows] - 1.0).max()),
    }
    unloading = []
    for branch in curve.unloadings:
        force = curve.force[curve.rows(branch)]
        unloading.append(abs(follow(law, curve, branch).force - force).max() / force[0])
    return errors | ({"unloading_force": float(max(unloading))} if unloading else {})


def _computed(
    material: Material,
    radius: float,
    unload_from: Sequence[float] | None,
    max_overlap: float | None,
    law: str,
    progress: Callable[[float, str], None] | None,
) -> Prediction:
    """The same by finite elements, for what is outside the atlas."""
    deepest = deepest_asked(unload_from, max_overlap)
    starts = tuple(unload_from or ()) or tuple(start for start in DEFAULT_STARTS if start <= deepest) or (deepest,)
    curve = _pressed(material, radius, starts, deepest, progress)
    curves = [curve]
    if law != DEFAULT_LAW:
        curves.append(_pressed(material.elastic, radius, (), float(curve.overlap.max()) / radius, progress))
    facts = {"source": "finite elements", "code": code_version(), "errors": {"finite_elements": dict(curve.errors)}}
    facts |= {"stopped": curve.stopped} if curve.stopped else {}
    made = replace(fit(curves, law=law).fitted, origin=facts)
    return Prediction(curve, made, curve.errors, {}, curve.errors, law_errors(made.law, curve), None)


@functools.lru_cache(maxsize=4)
def _pressed(
    material: Material, radius: float, starts: tuple[float, ...], deepest: float, progress: Callable[[float, str], None] | None
) -> Curve:
    """One curve by finite elements; kept, since one law after another may be wanted of it."""
    import fem

    return fem.press(material, radius=radius, unload_from=starts, max_overlap=deepest, progress=progress)
