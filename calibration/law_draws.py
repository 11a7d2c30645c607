"""Laws drawn from the errors of a fit: what else the curves allow, to see what that changes in a simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from calibration.recipes import Parameter, Recipe, recipe_for
from contactlaws.errors import InputError, Problem, require
from contactlaws.fitted import FittedLaw

FloatArray = npt.NDArray[np.float64]

#: so often a draw that is no law (one that pulls, say) is drawn again
TRIES = 100


def draw(fitted: FittedLaw, free: Sequence[str], correlation: FloatArray, seed: int) -> FittedLaw:
    """One law from the joint normal distribution of the fitted parameters, as the fit states it.

    free, correlation: of the fit, in the same order. Parameters with a lower bound are normal in the logarithm of their distance from it,
    as in the fit, with its standard error and correlation to first order. What is no law is drawn again, which cuts the distribution there;
    `origin` says how often. A fit without free parameters gives the fitted law itself.

    Raises `InputError` where the errors are not known, or the law cannot be made from other values of these parameters.
    """
    recipe = recipe_for(fitted.name)
    known = {parameter.name: parameter for parameter in recipe.parameters}
    require(_problems(fitted, free, correlation, recipe))
    parameters = [known[name] for name in free]
    values: dict[str, Any] = fitted.law._asdict()
    centre = np.array([parameter.inner(values[parameter.name]) for parameter in parameters])
    errors = np.array([_inner_error(parameter, z, fitted.standard_errors) for parameter, z in zip(parameters, centre, strict=True)])
    root = _root(np.asarray(correlation, dtype=np.float64).reshape(len(free), len(free)))
    chance = np.random.default_rng(seed)
    for tried in range(1, TRIES + 1):
        inner = centre + errors * (root @ chance.standard_normal(len(free)))
        outer = {parameter.name: parameter.outer(float(z)) for parameter, z in zip(parameters, inner, strict=True)}
        try:
            law = recipe.build((), {**values, **outer})
            return replace(fitted, law=law, standard_errors={}, origin={**fitted.origin, "drawn": {"seed": seed, "tried": tried}})
        except (InputError, ArithmeticError):
            continue
    bound = f"none of {TRIES} draws from its errors is a law"
    raise InputError(Problem(f"law {fitted.name}", dict(fitted.standard_errors), bound, "give curves that say more about its parameters"))


def _inner_error(parameter: Parameter, inner: float, errors: Mapping[str, float | None]) -> float:
    return float(errors[parameter.name] or 0.0) / parameter.slope(inner)


def _root(correlation: FloatArray) -> FloatArray:
    """A matrix whose square is the correlation, also where that is singular."""
    if correlation.size == 0:
        return correlation
    values, directions = np.linalg.eigh(correlation)
    return np.asarray(directions * np.sqrt(np.maximum(values, 0.0)))


def _problems(fitted: FittedLaw, free: Sequence[str], correlation: FloatArray, recipe: Recipe) -> Iterator[Problem]:
    names = [parameter.name for parameter in recipe.parameters]
    for name in free:
        if name not in names:
            yield Problem(name, None, f"is no parameter that a fit of {recipe.law} finds", f"name some of {', '.join(names)}")
        elif fitted.standard_errors.get(name) is None:
            bound = "has no standard error: the curves say nothing about it"
            yield Problem(name, None, bound, "give curves that show it, or fit a law that does not have it")
    if not np.isfinite(np.asarray(correlation, dtype=np.float64)).all():
        yield Problem("correlation", None, "is not known", "give curves that show all parameters")
    if not _same(fitted.law, recipe):
        bound = "cannot be made from its free parameters alone"
        yield Problem("law", fitted.name, bound, "fit a law such as edmans_sinka, thornton, hertz or becker_kamlah")


def _same(law: Any, recipe: Recipe) -> bool:
    """Whether the recipe makes a law from its record's own values."""
    if not recipe.parameters:
        return True
    try:
        again = recipe.build((), law._asdict())
    except (InputError, TypeError, LookupError):
        return False
    return type(again) is type(law) and all(np.allclose(a, b, rtol=1e-12, atol=0.0) for a, b in zip(again, law, strict=True))
