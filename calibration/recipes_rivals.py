"""How to fit the laws of `contactlaws.rivals`: most follow from the material alone, some have constants that only a curve can give."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from calibration.recipes import (
    MODULUS,
    Parameter,
    Recipe,
    Values,
    body_and_modulus,
    plastic_curves,
    recipe_for,
    record_of,
    register,
)
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem
from contactlaws.rivals.becker_kamlah import FIRST, PUBLISHED
from contactlaws.rivals.mdr import mdr_of

NU, YIELD = Parameter("poissons_ratio", None), Parameter("yield_stress")


def body_and_material(curves: Sequence[Curve], given: Values) -> Values:
    """Radius, modulus, Poisson's ratio and yield stress; without a material Poisson's ratio must be given, curves cannot show it."""
    known = dict(body_and_modulus(curves, given))
    material = plastic_curves(curves)[0].material
    if material is not None and material.yield_stress is not None:
        return {**known, "poissons_ratio": material.poissons_ratio, "yield_stress": material.yield_stress}
    if material is not None:
        raise InputError(
            Problem("curves", material, "are all elastic: nothing to see of the yield stress", "add a curve of the material that yields")
        )
    if "poissons_ratio" not in given:
        remedy = "give it, as fixed={'poissons_ratio': 0.3}, or the material"
        raise InputError(Problem("poissons_ratio", None, "the curve names no material and cannot show it", remedy))
    return known


def _modulus_and_yield(curves: Sequence[Curve], known: Values) -> Values:
    """As for Thornton's law, whose pressure is about twice the yield stress."""
    start = recipe_for("thornton").start(curves, known)
    return {"reduced_modulus": start["reduced_modulus"], "yield_stress": 0.5 * start["yield_pressure"]}


for _name in ("kogut_etsion", "etsion", "jackson_green"):
    register(Recipe(_name, (MODULUS, NU, YIELD), plastic_curves, body_and_material, _modulus_and_yield, record_of(_name)))


# Becker & Kamlah: the three constants of the transition are free, as they depend on E/Y; `fixed` holds them at the published ones


def _without_poissons_ratio(curves: Sequence[Curve], given: Values) -> Values:
    known = dict(body_and_material(curves, {**given, "poissons_ratio": 0.3}))
    known.pop("poissons_ratio", None)
    return known


def _becker_kamlah_start(curves: Sequence[Curve], known: Values) -> Values:
    """Constants that grow with E/Y: lambda about 0.95 ln(E/Y), epsilon about 0.83 sqrt(E/Y)."""
    found = {**_modulus_and_yield(curves, known), **known}
    stiffness = found["reduced_modulus"] / found["yield_stress"]
    return {
        **found,
        "pressure_ratio": max(PUBLISHED["pressure_ratio"], 0.95 * math.log(stiffness)),
        "radius_ratio": max(PUBLISHED["radius_ratio"], 0.83 * math.sqrt(stiffness)),
        "exponent": PUBLISHED["exponent"],
    }


register(
    Recipe(
        "becker_kamlah",
        (MODULUS, YIELD, Parameter("pressure_ratio", FIRST), Parameter("radius_ratio", 1.0), Parameter("exponent", 1.0)),
        plastic_curves,
        _without_poissons_ratio,
        _becker_kamlah_start,
        record_of("becker_kamlah"),
    )
)


# MDR wants Young's modulus


def _mdr_constants(curves: Sequence[Curve], given: Values) -> Values:
    known = dict(body_and_material(curves, given))
    material = curves[0].material
    known.pop("reduced_modulus", None)
    return known if material is None else {**known, "youngs_modulus": material.youngs_modulus}


def _mdr_start(curves: Sequence[Curve], known: Values) -> Values:
    found = _modulus_and_yield(curves, known)
    return {"youngs_modulus": found["reduced_modulus"] * (1.0 - known["poissons_ratio"] ** 2), "yield_stress": found["yield_stress"]}


def _mdr(curves: Sequence[Curve], values: Values) -> Any:
    return mdr_of(*(float(values[name]) for name in ("radius", "youngs_modulus", "poissons_ratio", "yield_stress")))


register(Recipe("mdr", (Parameter("youngs_modulus"), NU, YIELD), plastic_curves, _mdr_constants, _mdr_start, _mdr))


# laws whose constants follow from no material


def _body(curves: Sequence[Curve], given: Values) -> Values:
    """Where the curve does not unload, it says nothing of the unloading: then these constants must be given."""
    return {"radius": curves[0].radius}


def _secants(curves: Sequence[Curve]) -> tuple[float, float]:
    """Of the loading, and over it the middle one of the unloadings (2 where there is none)."""
    curve = plastic_curves(curves)[0]
    last = curve.rows(0).stop - 1
    loading = max(float(curve.force[last] / curve.overlap[last]), 1e-300)
    ratios = []
    for branch in curve.unloadings:
        rows = curve.rows(branch)
        recovered = float(curve.overlap[rows][0] - curve.overlap[rows][-1])
        if recovered > 0.0:
            ratios.append(float(curve.force[rows][0]) / recovered / loading)
    return loading, max(2.0, float(np.median(ratios))) if ratios else 2.0


def _walton_braun_start(curves: Sequence[Curve], known: Values) -> Values:
    stiffness, ratio = _secants(curves)
    return {
        "loading_stiffness": stiffness,
        "stiffness_ratio": 1.0 + 0.2 * (ratio - 1.0),
        "stiffening": (ratio - 1.0) / float(curves[0].overlap.max()),
    }


def _luding_start(curves: Sequence[Curve], known: Values) -> Values:
    stiffness, ratio = _secants(curves)
    return {"loading_stiffness": stiffness, "stiffness_ratio": 2.0 * ratio, "saturation_overlap": float(curves[0].overlap.max())}


def _eepa_start(curves: Sequence[Curve], known: Values) -> Values:
    stiffness, ratio = _secants(curves)
    return {"force_at_radius": stiffness * curves[0].radius, "stiffness_ratio": ratio, "exponent": 1.1}


register(
    Recipe(
        "walton_braun",
        (Parameter("loading_stiffness"), Parameter("stiffness_ratio", 1.0), Parameter("stiffening")),
        plastic_curves,
        _body,
        _walton_braun_start,
        record_of("walton_braun"),
    )
)
register(
    Recipe(
        "luding",
        (Parameter("loading_stiffness"), Parameter("stiffness_ratio", 1.0), Parameter("saturation_overlap")),
        plastic_curves,
        _body,
        _luding_start,
        record_of("luding"),
    )
)
register(
    Recipe(
        "eepa",
        (Parameter("force_at_radius"), Parameter("stiffness_ratio", 1.0), Parameter("exponent", 1.0)),
        plastic_curves,
        _body,
        _eepa_start,
        record_of("eepa"),
    )
)
