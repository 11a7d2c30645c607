"""What fitting a law needs beyond the law itself: which parameters may be free, how they are scaled, where to start."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from contactlaws import dispatch
from contactlaws.curve import Curve
from contactlaws.elastic import HertzFiniteSize
from contactlaws.errors import InputError, Problem
from contactlaws.tabulate import from_curve

Values = Mapping[str, float]


class Parameter(NamedTuple):
    """A parameter that a fit may change; `above` is a bound that it stays above by a logarithmic transform, None for any real number."""

    name: str
    above: float | None = 0.0

    def inner(self, value: float) -> float:
        """The unbounded number that the least squares work on; raises `InputError` for a start outside the bound."""
        if self.above is None:
            return value
        if not value > self.above:
            raise InputError(Problem(self.name, value, f"must be above {self.above}", "give another starting or fixed value"))
        return math.log(value - self.above)

    def outer(self, inner: float) -> float:
        """The parameter's value."""
        return inner if self.above is None else self.above + math.exp(min(inner, 700.0))

    def slope(self, inner: float) -> float:
        """Derivative of `outer`."""
        return 1.0 if self.above is None else math.exp(min(inner, 700.0))


class Recipe(NamedTuple):
    """How to fit one law."""

    law: str
    parameters: tuple[Parameter, ...]  # those that may be free
    select: Callable[[Sequence[Curve]], Sequence[Curve]]  # the curves, or the parts of them, that this law can describe
    constants: Callable[
        [Sequence[Curve], Values], Values
    ]  # what is known from all curves given, before the fit; second argument: given by the user
    start: Callable[[Sequence[Curve], Values], Values]  # starting values from the selected curves and what is known
    build: Callable[[Sequence[Curve], Values], Any]  # the record; curves are the selected ones
    spheroids: bool = False  # it can describe a body whose aspect is not 1; otherwise such curves are refused
    #: what the user must know about a fit to all curves given; second argument: names that the user gave or freed
    remarks: Callable[[Sequence[Curve], Collection[str]], Iterable[str]] = lambda curves, named: ()


_RECIPES: dict[str, Recipe] = {}
#: viscoelastic laws, which are fitted to curves in time in a way of their own (`calibration.recipes_viscoelastic`)
IN_TIME = ("maxwell_zener", "maxwell_zener_ting")


def register(recipe: Recipe) -> None:
    """Make a law fittable; a recipe of the same name is replaced."""
    _RECIPES[recipe.law] = recipe


def recipe_for(law: str) -> Recipe:
    """The recipe of a registered law; raises `InputError` naming the known ones."""
    if law not in _RECIPES:
        bound = f"no recipe to fit it; known are {', '.join([*_RECIPES, *IN_TIME])}"
        raise InputError(Problem("law", law, bound, "choose one, or calibration.recipes.register yours"))
    return _RECIPES[law]


def record_of(law: str) -> Callable[[Sequence[Curve], Values], Any]:
    """A builder for laws whose record is made of nothing but its values."""
    return lambda curves, values: dispatch.laws()[law].record(**values)


def is_elastic(curve: Curve) -> bool:
    """The material of the curve is known to have no yield stress."""
    return curve.material is not None and curve.material.yield_stress is None


def plastic_curves(curves: Sequence[Curve]) -> Sequence[Curve]:
    """Those that yield, if any do."""
    return [curve for curve in curves if not is_elastic(curve)] or curves


def elastic_parts(curves: Sequence[Curve]) -> Sequence[Curve]:
    """The elastic curves, if any; else the loadings up to first yield; curves of unknown material whole."""
    return (
        [curve for curve in curves if is_elastic(curve)]
        or [part for curve in curves if (part := _before_yield(curve)) is not None]
        or curves
    )


def _before_yield(curve: Curve) -> Curve | None:
    if curve.material is None or curve.yield_overlap is None:
        return curve
    keep = (curve.branch == 0) & (curve.overlap <= curve.yield_overlap)
    if np.count_nonzero(keep) < 3:
        return None
    return curve.part(keep)


def pole_radius(curve: Curve) -> float:
    """Radius of curvature in m where the body touches the flat: (equatorial semi-axis)^2 / (polar semi-axis)."""
    return curve.aspect**2 * curve.radius


def body_and_modulus(curves: Sequence[Curve], given: Values) -> Values:
    """The radius at the pole, and E/(1 - nu^2) where the material is known."""
    known = {"radius": pole_radius(curves[0])}
    material = curves[0].material
    return known if material is None else {**known, "reduced_modulus": material.reduced_modulus}


def modulus_from_force(curve: Curve) -> float:
    """Hertz's reduced modulus in Pa from a state in the first fifth of the loading."""
    rows = curve.rows(0)
    overlap, force = curve.overlap[rows], curve.force[rows]
    row = int(np.searchsorted(overlap, 0.2 * overlap[-1]))
    while row < overlap.size - 1 and force[row] <= 0.0:
        row += 1
    return max(float(0.75 * force[row] / (math.sqrt(pole_radius(curve)) * overlap[row] ** 1.5)), 1e-300)


def _hertz_start(curves: Sequence[Curve], known: Values) -> Values:
    return {"reduced_modulus": modulus_from_force(curves[0])}


def _finite_size_start(curves: Sequence[Curve], known: Values) -> Values:
    return {**_hertz_start(curves, known), **dict.fromkeys(HertzFiniteSize._fields[2:], 0.0)}


def _thornton_start(curves: Sequence[Curve], known: Values) -> Values:
    """The end of the loading has the slope pi p_Y R; the modulus is that at which the line meets Hertz's curve there."""
    curve = curves[0]
    rows = curve.rows(0)
    overlap, force = curve.overlap[rows], curve.force[rows]
    half = int(np.searchsorted(overlap, 0.5 * overlap[-1]))
    slope = (force[-1] - force[half]) / (overlap[-1] - overlap[half]) if half < overlap.size - 1 else force[-1] / overlap[-1]
    pressure = max(0.5 * slope, 0.05 * force[-1] / overlap[-1]) / (math.pi * curve.radius)
    return {"yield_pressure": max(float(pressure), 1e-300), "reduced_modulus": 2.0 * modulus_from_force(curve)}


def free_names(recipe: Recipe, known: Iterable[str], free: Iterable[str]) -> list[Parameter]:
    """The parameters that are not known, or are to be free all the same."""
    known, free = set(known), set(free)
    return [parameter for parameter in recipe.parameters if parameter.name not in known or parameter.name in free]


def _pole_only(curves: Sequence[Curve], named: Collection[str]) -> Iterator[str]:
    curve = curves[0]
    if curve.aspect != 1.0:
        yield (
            f"the radius of this law, {pole_radius(curve):.6g} m, is that of curvature at the pole of a spheroid of aspect "
            f"{curve.aspect:g}; it holds for overlaps that are small against it"
        )


def _no_sphere(curves: Sequence[Curve], named: Collection[str]) -> Iterator[str]:
    curve = curves[0]
    if curve.aspect != 1.0:
        yield (
            f"THIS LAW IS NOT ONE OF SPHERES: it belongs to a spheroid of aspect {curve.aspect:g} and half height {curve.radius:.6g} m "
            "pressed at its poles; impacts and particle simulations, which take every body for a sphere, would be wrong with it"
        )


MODULUS = Parameter("reduced_modulus")
register(Recipe("hertz", (MODULUS,), elastic_parts, body_and_modulus, _hertz_start, record_of("hertz"), True, _pole_only))
register(
    Recipe(
        "hertz_finite_size",
        (MODULUS, *(Parameter(name, None) for name in HertzFiniteSize._fields[2:])),
        elastic_parts,
        body_and_modulus,
        _finite_size_start,
        record_of("hertz_finite_size"),
    )
)
register(
    Recipe("thornton", (MODULUS, Parameter("yield_pressure")), plastic_curves, body_and_modulus, _thornton_start, record_of("thornton"))
)
register(
    Recipe(
        "tabulated",
        (),
        plastic_curves,
        lambda curves, given: {"radius": curves[0].radius},
        lambda curves, known: {},
        lambda curves, values: _table(curves),
        True,
        _no_sphere,
    )
)


def _table(curves: Sequence[Curve]) -> Any:
    if len(curves) > 1:
        raise InputError(Problem("curves", len(curves), "a tabulated law is made from one curve", "put all unloadings into one curve"))
    return from_curve(curves[0])
