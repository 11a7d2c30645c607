"""How to fit `contactlaws.edmans_sinka`: the elastic factor from elastic curves, the rest from the plastic ones."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

from calibration.recipes import (
    MODULUS,
    Parameter,
    Recipe,
    Values,
    is_elastic,
    modulus_from_force,
    plastic_curves,
    recipe_for,
    record_of,
    register,
)
from contactlaws.curve import Curve
from contactlaws.edmans_sinka import FIRST_YIELD, PUBLISHED
from contactlaws.elastic import HertzFiniteSize
from contactlaws.errors import InputError, Problem

ELASTIC = HertzFiniteSize._fields[2:]
YIELD = ("yield_factor", "yield_factor_slope", "yield_power")
GAMMAS = tuple(f"gamma_{i}" for i in range(1, 6))
#: the shape of the loading branch and of the contact area, about as a sphere with E/Y = 100 has it
SHAPE = {
    "flow": 0.25,
    "flow_decay": 0.0,
    "flow_decay_2": 0.0,
    "flow_sharpness": 1.5,
    "plastic_area": 2.8,
    "plastic_area_decay": 1.0,
    "area_onset": 1.0,
}
UNLOADING = {"exponent": 1.42, "exponent_decay": 2.5}
#: overlap over radius from which the whole body flows, and curves can show more than one coefficient of it
BULK = 0.15

PARAMETERS = (
    MODULUS,
    Parameter("poissons_ratio", None),
    Parameter("yield_stress"),
    *(Parameter(name, None) for name in ELASTIC),
    Parameter("flow"),
    Parameter("flow_decay", None),
    Parameter("flow_decay_2", None),
    Parameter("flow_sharpness", 1.0),
    Parameter("plastic_area"),
    Parameter("plastic_area_decay", None),
    Parameter("area_onset"),
    Parameter("exponent", 1.0),
    Parameter("exponent_decay", None),
    *(Parameter(name, None) for name in YIELD),
    *(Parameter(name) for name in GAMMAS),
)


def constants(curves: Sequence[Curve], given: Values) -> Values:
    """Material, published constants, elastic factor; and defaults for what these curves cannot show (area, how the exponent falls)."""
    first = curves[0]
    known: dict[str, Any] = {"radius": first.radius, **dict(zip(YIELD, FIRST_YIELD["corrected"], strict=True))}
    known |= dict(zip(GAMMAS, PUBLISHED, strict=True))
    plastic = plastic_curves(curves)
    material = plastic[0].material
    if material is not None and material.yield_stress is not None:
        known |= {
            "reduced_modulus": material.reduced_modulus,
            "poissons_ratio": material.poissons_ratio,
            "yield_stress": material.yield_stress,
        }
    elif material is not None:
        raise InputError(
            Problem("curves", material, "are all elastic: nothing to see of the yield stress", "add a curve of the material that yields")
        )
    elif "poissons_ratio" not in given:
        raise InputError(
            Problem(
                "poissons_ratio",
                None,
                "the curve names no material and cannot show it",
                "give it, as fixed={'poissons_ratio': 0.3}, or the material (--youngs-modulus, --poissons-ratio and --yield-stress)",
            )
        )
    known |= elastic_factor([curve for curve in curves if is_elastic(curve)], known)
    if all(curve.contact_radius is None for curve in plastic):
        known |= {name: SHAPE[name] for name in ("plastic_area", "plastic_area_decay", "area_onset")}
    deepest = max(float(curve.overlap.max()) for curve in plastic)
    known |= {} if deepest > BULK * first.radius else {"flow_decay_2": 0.0}
    unloadings = sum(len(curve.unloadings) for curve in plastic)
    known |= {} if unloadings else UNLOADING
    known |= {"exponent_decay": UNLOADING["exponent_decay"]} if unloadings == 1 else {}
    return known


def elastic_factor(elastic: Sequence[Curve], known: Values) -> Values:
    """The coefficients of `hertz_finite_size` fitted to elastic curves."""
    from calibration.fit import fit

    if not elastic:
        return dict.fromkeys(ELASTIC, 0.0)
    law = fit(elastic, "hertz_finite_size").law
    return {name: getattr(law, name) for name in ELASTIC}


def start(curves: Sequence[Curve], known: Values) -> Values:
    """Shapes of a middling material; a modulus and a yield stress that are not known come from the curve as for Thornton's law."""
    found = {**SHAPE, **UNLOADING, "reduced_modulus": 2.0 * modulus_from_force(curves[0])}
    pressure = recipe_for("thornton").start(curves, known)["yield_pressure"]
    return {**found, "yield_stress": pressure / 2.0}


def remarks(curves: Sequence[Curve], named: Collection[str]) -> Iterator[str]:
    """What stands for the elastic factor where no curve shows it."""
    missing = [name for name in ELASTIC if name not in named]
    if missing and not any(map(is_elastic, curves)):
        yield (
            f"no elastic curve was given: {', '.join(missing)} are 0, as in plain Hertz, which misses the force by 5 % from an overlap "
            "of a hundredth of the radius on; add a curve of the same body and material without yield stress"
        )


register(Recipe("edmans_sinka", PARAMETERS, plastic_curves, constants, start, record_of("edmans_sinka"), remarks=remarks))
