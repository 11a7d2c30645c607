"""The tables of the study, as rows with the same keys; numbers, not texts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Points, Study, force_unit
from cases.edmans_sinka_2020.refit import READINGS, Refit, percentiles, relative_errors
from contactlaws.edmans_sinka import FIRST_YIELD

Row = dict[str, Any]


def materials(study: Study) -> list[Row]:
    """One row for each material."""
    rows = []
    for modulus, nu in study.keys:
        curve, points = study.curves[modulus, nu], study.of(modulus, nu)
        onset = None if curve.yield_overlap is None else curve.yield_overlap / curve.radius
        place = (None, None) if curve.yield_place is None else tuple(value / curve.radius for value in curve.yield_place)
        rows.append(
            {
                "modulus_over_yield_stress": modulus,
                "poissons_ratio": nu,
                "yield_overlap_over_radius": onset,
                **{f"yield_overlap_{reading}": float(paper.yield_depth(modulus, nu, reading)) for reading in FIRST_YIELD},
                "yield_distance_from_axis_over_radius": place[0],
                "yield_distance_from_midplane_over_radius": place[1],
                "unloadings": points.depth.size,
                "largest_force_over_pi_R2_Y": float(curve.force.max() / force_unit(curve)),
                "least_stiffness": float(points.stiffness.min()),
                "stiffness_last_over_least": float(points.stiffness[-1] / points.stiffness.min()),
                "exponent_first": float(points.exponent[0]),
                "exponent_last": float(points.exponent[-1]),
                "least_r2": float(points.exponent_r2.min()),
                "estimated_error_of_force": curve.errors.get("force"),
                "estimated_error_of_stiffness": curve.errors.get("unloading_stiffness"),
                "stopped": curve.stopped,
            }
        )
    return rows


def errors_of_equation_3(sets: Mapping[str, Points], refits: Sequence[Refit]) -> list[Row]:
    """Percentiles of the absolute relative error of rho, for the paper's constants and the refits, on each set of unloadings."""
    rows = []
    for name, points in sets.items():
        if points.depth.size == 0:
            continue
        for reading in READINGS:
            rows.append(_row(name, points, reading, "paper", relative_errors(points, reading)))
            rows += [_row(name, points, reading, found.measure, found.errors(points)) for found in refits if found.reading == reading]
    return rows


def _row(name: str, points: Points, reading: str, constants: str, errors: Any) -> Row:
    shares = {f"error_{p}th_percentile": value for p, value in zip(paper.PERCENTILES, percentiles(errors), strict=True)}
    return {"unloadings": name, "count": points.depth.size, "first_yield": reading, "constants": constants, **shares}


def constants(refits: Sequence[Refit]) -> list[Row]:
    """gamma_1 to gamma_5 with standard errors."""
    return [
        {
            "first_yield": found.reading,
            "made_small": found.measure,
            **{f"gamma_{i}": value for i, value in enumerate(found.gammas, 1)},
            **{f"standard_error_{i}": value for i, value in enumerate(found.standard_errors, 1)},
        }
        for found in refits
    ]
