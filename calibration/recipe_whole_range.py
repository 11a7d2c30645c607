"""How to fit `contactlaws.whole_range`: nothing is free where the material is known; a measured curve gives modulus and yield stress."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from calibration.recipes import Parameter, Recipe, Values, plastic_curves, recipe_for, register
from calibration.recipes_rivals import body_and_material
from contactlaws.curve import Curve
from contactlaws.material import Material
from contactlaws.whole_range import whole_range


def _constants(curves: Sequence[Curve], given: Values) -> Values:
    known = dict(body_and_material(curves, given))
    known.pop("reduced_modulus", None)
    material = curves[0].material
    return known if material is None else {**known, "youngs_modulus": material.youngs_modulus}


def _start(curves: Sequence[Curve], known: Values) -> Values:
    """As for MDR, which follows from the same three constants."""
    return recipe_for("mdr").start(curves, known)


def _build(curves: Sequence[Curve], values: Values) -> Any:
    material = Material(float(values["youngs_modulus"]), float(values["poissons_ratio"]), float(values["yield_stress"]))
    return whole_range(material, float(values["radius"]))


PARAMETERS = (Parameter("youngs_modulus"), Parameter("poissons_ratio", None), Parameter("yield_stress"))
register(Recipe("whole_range", PARAMETERS, plastic_curves, _constants, _start, _build))
