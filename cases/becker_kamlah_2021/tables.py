"""The tables of the case, as rows with the same keys; numbers, not texts."""

from __future__ import annotations

import math
from typing import Any

from cases.becker_kamlah_2021.data import Key
from cases.becker_kamlah_2021.facts import Facts
from cases.becker_kamlah_2021.joint_fit import NAMES
from cases.becker_kamlah_2021.shape_fit import Read, published

Row = dict[str, Any]
#: of Eq. 52, by quantity
CONSTANTS = {"pressure_ratio": ("m", "o", "p"), "radius_ratio": ("s", "t", "u")}
TERMS = ("1", "L", "L^2", "nu")


def bodies(facts: Facts) -> list[Row]:
    """One row for each body that yields early enough: all readings."""
    return [_body(key, row) for key, found in facts.read_of.items() for row in found]


def _body(key: Key, row: Read) -> Row:
    body, onset, plateau = row.body, row.body.curve.yield_overlap, row.plateau
    return {
        "modulus_over_yield_stress": key[0],
        "poissons_ratio": key[1],
        "aspect": body.aspect,
        "relative_radius": body.relative,
        "yield_overlap_over_mean_radius": body.yield_overlap / body.mean_radius,
        "finite_element_yield_over_that": None if onset is None else onset / body.yield_overlap,
        "lambda_max": row.force.told,
        "lambda_max_fit": row.force.pressure_ratio,
        "lambda_max_error": row.force.pressure_error,
        "epsilon_max": row.force.radius_ratio if row.force.seen else None,
        "epsilon_max_error": row.force.radius_error if row.force.seen else None,
        "misfit": row.force.misfit,
        "condition": row.force.condition,
        "lambda_at_end": row.force.level,
        "free_lambda_max": row.free.pressure_ratio,
        "free_epsilon_max": row.free.radius_ratio,
        "free_exponent": row.free.exponent,
        "free_exponent_error": row.free.exponent_error,
        "free_misfit": row.free.misfit,
        "free_condition": row.free.condition,
        "largest_lambda": None if plateau is None else plateau.pressure_ratio,
        "largest_lambda_at": None if plateau is None else plateau.radius_ratio,
        "lambda_at_end_over_largest": None if plateau is None else plateau.at_end,
        "published_lambda_max": float(published("pressure_ratio", body.relative)[0]),
        "published_epsilon_max": float(published("radius_ratio", body.relative)[0]),
    }


def constants(facts: Facts) -> list[Row]:
    """Eq. 52 of every material that has enough shapes: value, standard error."""
    rows = []
    for (key, reading, quantity), shape in facts.shapes.items():
        for name, value, error in zip(CONSTANTS[quantity], shape.constants, shape.errors, strict=True):
            rows.append(
                {
                    "modulus_over_yield_stress": key[0],
                    "poissons_ratio": key[1],
                    "reading": reading,
                    "constant": name,
                    "value": value,
                    "standard_error": error,
                    "largest_relative_difference": shape.largest,
                    "bodies": shape.bodies,
                }
            )
    return rows


def joint(facts: Facts) -> list[Row]:
    """All seven constants of every material, from the forces of all its shapes at once; an empty error: the constant does nothing."""
    return [
        {
            "modulus_over_yield_stress": key[0],
            "poissons_ratio": key[1],
            **dict(zip(NAMES, found.constants, strict=True)),
            **{f"standard_error_{name}": _finite(error) for name, error in zip(NAMES, found.errors, strict=True)},
            "misfit": found.misfit,
            "condition": _finite(found.condition),
            "bodies": found.bodies,
        }
        for key, found in facts.joint.items()
    ]


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def together(facts: Facts) -> list[Row]:
    """The constants of Eq. 52 as functions of the material, L = ln(E/Y), as `shape_fit` has them."""
    rows = []
    for (reading, quantity), found in facts.together.items():
        for i, name in enumerate(CONSTANTS[quantity]):
            for j, term in enumerate(TERMS):
                rows.append(
                    {
                        "reading": reading,
                        "quantity": "lambda_max" if quantity == "pressure_ratio" else "ln(epsilon_max)",
                        "constant": name,
                        "term": term,
                        "coefficient": float(found.coefficients[i, j]),
                        "standard_error": float(found.errors[i, j]),
                        "typical_relative_difference": found.typical,
                        "largest_relative_difference": found.largest,
                        "bodies": found.bodies,
                    }
                )
    return rows
