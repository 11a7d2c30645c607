"""From curves to one law, with its errors: least squares on force, contact radius and unloading together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from calibration import recipes_viscoelastic
from calibration.fit_record import Fit, problems_with_bodies, stops
from calibration.recipes import IN_TIME, Recipe, free_names, recipe_for
from calibration.residuals import WEIGHTS, Block, blocks, error_product, measures, residual_vector
from calibration.trust import Trust, doubts, trust
from contactlaws.curve import Curve
from contactlaws.errors import Problem, require
from contactlaws.fitted import FittedLaw

FloatArray = npt.NDArray[np.float64]
Difference = Callable[[FloatArray], FloatArray]
__all__ = ["Fit", "fit"]


def fit(
    curves: Curve | Sequence[Curve],
    law: str = "thornton",
    fixed: Mapping[str, float] | None = None,
    weights: Mapping[str, float] | None = None,
    free: Iterable[str] = (),
    terms: int | None = None,
) -> Fit:
    """Fit the registered law named `law` to one body's curves.

    Parameters that follow from the curves' material are taken from it; `fixed` gives or overrides values, `free` names some to be fitted
    all the same. `weights` of force, contact_radius and unloading multiply the squares (each branch counts as one datum with the curve's
    own error). Measured curves (no material, no contact radius) are fitted the same way, with more parameters free.

    Curves in time and the viscoelastic laws belong together (`calibration.recipes_viscoelastic`): `fixed` may give poissons_ratio, and
    `terms` the number of relaxation times, which is chosen otherwise.

    Raises `InputError` for curves of different bodies or materials, unknown names, or a parameter that must be given.
    """
    given = (curves,) if isinstance(curves, Curve) else tuple(curves)
    if law in IN_TIME:
        return recipes_viscoelastic.fit_viscoelastic(given, law, fixed or {}, weights or {}, tuple(free), terms)
    recipe, chosen, held = recipe_for(law), {**WEIGHTS, **(weights or {})}, dict(fixed or {})
    require(_problems_with_time(given, law, terms))
    require(_problems(given, recipe, chosen, held, tuple(free)))
    known = {**recipe.constants(given, held), **held}
    selected = recipe.select(given)
    require(_problems_with_force(selected))
    unknown = free_names(recipe, known, free)
    start = {**recipe.start(selected, known), **known}
    parts = blocks(selected, chosen)

    def record(inner: FloatArray) -> Any:
        values = {parameter.name: parameter.outer(float(z)) for parameter, z in zip(unknown, inner, strict=True)}
        return recipe.build(selected, {**start, **values})

    inner = np.array([parameter.inner(start[parameter.name]) for parameter in unknown])
    parts = [part for part in parts if np.isfinite(residual_vector(record(inner), selected, [part])).all()]
    inner, found, evaluations, failed = _solve(lambda z: residual_vector(record(z), selected, parts), inner, parts)
    outcome = record(inner)
    errors = {
        parameter.name: float(error * parameter.slope(z)) if math.isfinite(error) else None
        for parameter, z, error in zip(unknown, inner, found.errors, strict=True)
    }
    names = tuple(parameter.name for parameter in unknown)
    fitted = FittedLaw(
        law=outcome,
        max_overlap=max(float(curve.overlap.max()) for curve in selected),
        material=selected[0].material,
        curve_hashes=tuple(curve.content_hash for curve in given),
        standard_errors=errors,
    )
    remarks = (*recipe.remarks(given, {*held, *names}), *stops(selected))
    warnings = (*failed, *doubts(found, names, [parameter.above for parameter in unknown]), *remarks)
    return Fit(fitted, names, found.correlation, found.condition_number, found.misfit, measures(outcome, selected), warnings, evaluations)


def _solve(difference: Difference, inner: FloatArray, parts: Sequence[Block]) -> tuple[FloatArray, Trust, int, tuple[str, ...]]:
    data = float(sum(part.share.sum() for part in parts))
    if inner.size == 0:
        rows = difference(inner)
        return inner, trust(np.zeros((rows.size, 0)), rows, partial(error_product, parts), data), 1, ()
    result = least_squares(difference, inner, method="trf", x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=500)
    failed = () if result.success else (f"the least squares stopped early: {result.message}",)
    return result.x, trust(result.jac, result.fun, partial(error_product, parts), data), int(result.nfev), failed


def _problems_with_time(curves: Sequence[Curve], law: str, terms: int | None) -> Iterator[Problem]:
    remedy = f"fit one of {', '.join(IN_TIME)}"
    for number, curve in enumerate(curves):
        if curve.in_time:
            yield Problem(f"curves[{number}]", "a curve in time", f"its force depends on time, of which {law} knows nothing", remedy)
    if terms is not None:
        yield Problem("terms", terms, f"{law} has no relaxation times", f"leave it out, or {remedy}")


def _problems(
    curves: Sequence[Curve], recipe: Recipe, weights: Mapping[str, float], fixed: Mapping[str, float], free: tuple[str, ...]
) -> Iterator[Problem]:
    if not curves:
        yield Problem("curves", 0, "a fit needs at least one", "give a curve")
        return
    names = [parameter.name for parameter in recipe.parameters]
    for name, value in fixed.items():
        if name not in names:
            yield Problem(f"fixed[{name}]", value, f"{recipe.law} has {', '.join(names)}", "rename or drop it")
        elif isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            yield Problem(f"fixed[{name}]", value, "must be a finite number", "give it in SI units")
    for parameter in recipe.parameters:
        value = fixed.get(parameter.name, math.inf)
        if parameter.above is not None and not value > parameter.above:
            yield Problem(f"fixed[{parameter.name}]", value, f"must be above {parameter.above}", "give it in SI units")
    for name in free:
        if name not in names or name in fixed:
            yield Problem(f"free[{name}]", name, f"must be one of {', '.join(names)} that is not fixed", "rename or drop it")
    for name, weight in weights.items():
        if name not in WEIGHTS or not (math.isfinite(weight) and weight >= 0.0):
            yield Problem(f"weights[{name}]", weight, f"must be a number from 0 for one of {', '.join(WEIGHTS)}", "correct it")
    yield from _problems_with_force(curves)
    if curves[0].aspect != 1.0 and not recipe.spheroids:
        bound = f"must be 1: {recipe.law} describes a sphere, and this is a curve of a spheroid"
        yield Problem("aspect", curves[0].aspect, bound, "fit 'hertz' for small overlaps, or 'tabulated' for this very body")
    yield from problems_with_bodies(curves)


def _problems_with_force(curves: Sequence[Curve]) -> Iterator[Problem]:
    for number, curve in enumerate(curves):
        last = float(curve.force[curve.rows(0)][-1])
        if last <= 0.0:
            bound = "must be positive at the end of the loading"
            yield Problem(f"curves[{number}]: force", last, bound, "check its sign and zero: compression is positive")
