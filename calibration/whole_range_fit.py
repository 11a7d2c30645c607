"""Fit the global constants of the whole-range law to a folder of curves, all quantities jointly, and write them.

    python -m calibration.whole_range_fit FOLDER [FOLDER ...] [--unseen FOLDER] [--dry]

The elastic factors come first, from what the curves say before yield (linear least squares); then everything else together by least
squares, then by the least sum of 2.5th powers (so that the worst points count more), from the constants in place. The compact law likewise,
with fourth powers. FOLDER of --unseen is only judged.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from calibration.whole_range_data import Targets, evaluate, read_folder, targets
from calibration.whole_range_errors import report
from contactlaws import whole_range_constants
from contactlaws.curve import Curve
from contactlaws.sources import ROOT
from contactlaws.whole_range_record import Constants, hertz_yield_root

FloatArray = npt.NDArray[np.float64]

#: what the residuals are measured in: the relative errors aimed at, about the 75th percentile
UNITS = {"load": 0.008, "contact_radius": 0.010, "recovered": 0.014, "exponent": 0.010, "energy": 0.02, "shape": 0.0035, "area": 0.07}
QUANTITIES = tuple(UNITS)
#: below this overlap over the radius, residuals count as this share of themselves
SHALLOW, SHALLOW_WEIGHT = 0.0099, 0.5
#: residuals beyond this many units count no more: a start far away, or a point where the law is not defined
CAP = 50.0
#: the states at which the law must not give energy away, and must load with a growing force
GUARD_MODULUS, GUARD_DEPTH = np.geomspace(1.0, 1e5, 16), np.geomspace(1e-5, 0.6, 40)
GUARD_NU = (0.0, 0.25, 0.4999)
ELASTIC = tuple(name for name in Constants._fields if name.startswith(("force_", "area_")))
YIELD = ("yield_1", "yield_2")
POWERS = (1, 2, 6)  # of sqrt(D), in the elastic factors
#: the compact law: 20 constants for loading and unloading stiffness, one turn for all that turns; unloading goes from s^1.5 to a bar's s
COMPACT_FREE = (
    "force_1_nu", "force_2", "force_3", "force_3_nu", "yield_1", "yield_2",
    "limit_over_2", "limit_under_2", "limit_under_3", "turn", "lag_upset", "lag_upset_yield", "lag_root", "spread_2", "spread_3",
    "recovery_depth", "recovery_upset", "dip_upset", "fading", "fading_power",
)  # fmt: skip
COMPACT_FIXED = dict.fromkeys(("growth", "recovery", "share", "mix", "mix_power", "round_upset"), 1.0) | {
    "round": 1.5,
    "round_elastic": 1.5,
}
COMPACT_TURNS = ("growth_turn", "recovery_turn", "fading_turn", "shape_turn")
COMPACT_START = {
    "limit_over_2": 10.0, "limit_under_2": 13.0, "limit_under_3": 150.0, "turn": 0.09, "lag_upset": 0.7, "lag_upset_yield": -1.2,
    "lag_root": 0.5, "spread_2": 18.0, "spread_3": 55.0, "recovery_depth": 0.5, "recovery_upset": 0.73, "dip_upset": -1.0,
    "fading": 4.9, "fading_power": 0.96,
}  # fmt: skip


def elastic_constants(curves: Sequence[Curve], names: Sequence[str] = ELASTIC) -> dict[str, float]:
    """The elastic factors of these names: linear least squares, reweighted towards the largest relative error being least."""
    found: dict[str, float] = {}
    for quantity in ("force", "area"):
        terms = [name for name in names if name.startswith(quantity)]
        if not terms:
            continue
        t, nu, ratio = _elastic_ratios(curves, quantity)
        matrix = np.stack([t ** POWERS[_order(term)] * nu ** _degree(term) for term in terms], axis=1) / ratio[:, None]
        weight = np.ones(ratio.size)
        for _ in range(60):
            solution = np.linalg.lstsq(matrix * weight[:, None], (1.0 - 1.0 / ratio) * weight, rcond=None)[0]
            miss = abs(matrix @ solution - (1.0 - 1.0 / ratio))
            weight = np.sqrt(miss / max(float(miss.mean()), 1e-300) + 0.1)
        found |= dict(zip(terms, solution.tolist(), strict=True))
    return found


def _order(term: str) -> int:
    """Place in `POWERS` of an elastic constant, by the number in its name."""
    return int(term.split("_")[1]) - 1


def _degree(term: str) -> int:
    """The power of nu that an elastic constant multiplies, by the end of its name."""
    return 2 if term.endswith("_nu2") else 1 if term.endswith("_nu") else 0


def yield_constants(wanted: Targets) -> dict[str, float]:
    """The two of first yield: least squares of the relative errors, over the materials that yield."""
    rows = np.unique(np.stack((wanted.modulus, wanted.poissons_ratio)), axis=1, return_index=True)[1]
    rows = rows[np.isfinite(wanted.yield_depth[rows])]
    root = np.array([hertz_yield_root(1.0 / wanted.modulus[row], wanted.poissons_ratio[row]) for row in rows])

    def difference(values: FloatArray) -> FloatArray:
        return np.log(wanted.yield_depth[rows] * (1.0 / root**2 + values[1] / root + values[0]))

    found = least_squares(difference, (1.7, 0.6)).x
    return {"yield_1": float(found[0]), "yield_2": float(found[1])}


def _elastic_ratios(curves: Sequence[Curve], quantity: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """sqrt(D), nu, and the force over Hertz's or the area over R d, of the states before yield that are not too shallow for the mesh."""
    columns = []
    for curve in curves:
        material, rows = curve.material, curve.rows(0)
        assert material is not None
        assert material.yield_stress is not None
        assert curve.contact_radius is not None
        depth = curve.overlap[rows] / curve.radius
        keep = (depth > 0.008) & (curve.overlap[rows] <= (curve.yield_overlap or np.inf))
        # of stiff materials this is a fraction of what soft ones show, again
        if material.youngs_modulus > 5.5 * material.yield_stress or not keep.any():
            continue
        depth = depth[keep]
        hertz = 4.0 / 3.0 * material.reduced_modulus * curve.radius**2 * depth**1.5
        values = curve.force[rows][keep] / hertz if quantity == "force" else (curve.contact_radius[rows][keep] / curve.radius) ** 2 / depth
        columns.append((np.sqrt(depth), np.full(depth.size, material.poissons_ratio), values))
    t, nu, ratio = (np.concatenate(column) for column in zip(*columns, strict=True))
    return t, nu, ratio


def residuals(constants: Constants, wanted: Targets, power: float, quantities: Sequence[str] = QUANTITIES) -> FloatArray:
    """All residuals in `UNITS`, so that their squares are the `power`-th powers of the errors; and those of `guards`."""
    with np.errstate(all="ignore"):
        found = evaluate(constants, wanted.modulus, wanted.poissons_ratio, wanted.depth, wanted.s)
        difference = found.shape - wanted.shape
        slope = wanted.s ** wanted.exponent[:, None] * np.log(wanted.s)
        parts = {name: np.log(getattr(found, name) / getattr(wanted, name)) for name in ("load", "contact_radius", "recovered", "energy")}
        # the best exponent, to first order in the difference of the shapes
        parts["exponent"] = (difference * slope).sum(axis=1) / (slope * slope).sum(axis=1) / wanted.exponent
        parts["shape"] = difference / np.sqrt(wanted.s.shape[1])
        parts["area"] = (found.area - wanted.area) / np.sqrt(wanted.s.shape[1])
        weight = np.where(wanted.depth < SHALLOW, SHALLOW_WEIGHT, 1.0)
        rows = [(parts[name].T / unit * weight).ravel() for name, unit in UNITS.items() if name in quantities] + [guards(constants)]
        values = np.nan_to_num(np.concatenate(rows), nan=CAP, posinf=CAP, neginf=-CAP).clip(-CAP, CAP)
    return np.sign(values) * abs(values) ** (0.5 * power)


def guards(constants: Constants) -> FloatArray:
    """What the law must never do, zero where it does not: force that falls along the loading, recovered energy that grows faster than the
    work of the loading, recovered overlap beyond the overlap, force that rises along the unloading.
    """
    modulus, nu, depth = (grid.ravel() for grid in np.meshgrid(GUARD_MODULUS, GUARD_NU, GUARD_DEPTH, indexing="ij"))
    step = 1e-4
    s = np.broadcast_to(np.linspace(0.02, 1.0, 8), (depth.size, 8))
    here, next_ = (evaluate(constants, modulus, nu, depth * factor, s) for factor in (1.0 - 0.5 * step, 1.0 + 0.5 * step))
    growth = np.log(next_.load / here.load) / step
    gain = (next_.energy - here.energy) / (0.5 * step * depth * (here.load + next_.load))
    rise = np.diff(np.concatenate((np.zeros((depth.size, 1)), here.shape), axis=1), axis=1).min(axis=1)
    parts = (
        20.0 * np.maximum(0.02 - growth, 0.0),
        20.0 * np.maximum(gain - 1.0 - 1e-6, 0.0),
        50.0 * np.maximum(here.recovered / depth - 1.0, 0.0),
        200.0 * np.maximum(-rise, 0.0),
    )
    return np.concatenate(parts)


def fit(
    constants: dict[str, float],
    free: Sequence[str],
    wanted: Targets,
    power: float,
    evaluations: int,
    quantities: Sequence[str] = QUANTITIES,
    tied: Sequence[str] = (),
) -> dict[str, float]:
    """Least squares over the constants named in `free`, from those given; those `tied` have the value of `turn`."""

    def completed(values: FloatArray) -> dict[str, float]:
        found = constants | dict(zip(free, values.tolist(), strict=True))
        return found | dict.fromkeys(tied, found["turn"])

    def difference(values: FloatArray) -> FloatArray:
        return residuals(Constants(**completed(values)), wanted, power, quantities)

    start = np.array([constants[name] for name in free])
    found = least_squares(difference, start, x_scale=np.maximum(abs(start), 0.1), max_nfev=evaluations, ftol=1e-7, xtol=1e-7)
    return completed(found.x)


def fitted(curves: Sequence[Curve], wanted: Targets, evaluations: int) -> dict[str, float]:
    """The constants of the whole law: what is elastic and first yield on their own, then all others together."""
    constants = dict(whole_range_constants.WHOLE) | elastic_constants(curves) | yield_constants(wanted)
    free = [name for name in Constants._fields if name not in (*ELASTIC, *YIELD)]
    for power in (2.0, 2.5):
        constants = fit(constants, free, wanted, power, evaluations)
    return constants


def fitted_compact(curves: Sequence[Curve], wanted: Targets, evaluations: int) -> dict[str, float]:
    """The constants of the compact law, for loading and unloading stiffness: `COMPACT_FREE`, all others as in `COMPACT_FIXED`."""
    elastic = [name for name in COMPACT_FREE if name in ELASTIC]
    constants = dict.fromkeys(Constants._fields, 0.0) | COMPACT_FIXED | COMPACT_START
    constants |= elastic_constants(curves, elastic) | yield_constants(wanted)
    free = [name for name in COMPACT_FREE if name not in (*elastic, *YIELD)]
    for power in (2.0, 4.0):
        constants = fit(constants, free, wanted, power, evaluations, ("load", "contact_radius", "recovered"), COMPACT_TURNS)
    return constants


def main() -> None:
    """Fit, print the errors, write the constants."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path, nargs="+")
    parser.add_argument("--unseen", type=Path)
    parser.add_argument("--evaluations", type=int, default=60)
    parser.add_argument("--dry", action="store_true", help="print, but do not write")
    options = parser.parse_args()
    curves = [curve for folder in options.folder for curve in read_folder(folder)]
    wanted, began = targets(curves), time.process_time()
    unseen = None if options.unseen is None else targets(read_folder(options.unseen))
    whole = fitted(curves, wanted, options.evaluations)
    print(f"whole law, {len(whole)} constants\n{report(whole, wanted, unseen)}", flush=True)
    compact = fitted_compact(curves, wanted, options.evaluations)
    print(f"compact law, {len(COMPACT_FREE)} constants\n{report(compact, wanted, unseen)}")
    print(f"{time.process_time() - began:.0f} CPU s")
    if not options.dry:
        write(whole, compact, wanted.hash, f"python -m calibration.whole_range_fit {' '.join(folder.name for folder in options.folder)}")


def write(whole: dict[str, float], compact: dict[str, float], curves: str, command: str) -> Path:
    """The generated file."""
    lines = [
        '"""Global constants of the whole-range law. GENERATED by the command below: do not edit."""',
        "",
        f'COMMAND = "{command}"',
        f'CURVES = "{curves}"  # hash of the curves that they were fitted to',
        "",
        "WHOLE = {",
        *(f'    "{name}": {float(f"{whole[name]:.6g}")!r},' for name in Constants._fields),
        "}",
        "COMPACT = {",
        *(f'    "{name}": {float(f"{compact[name]:.6g}")!r},' for name in Constants._fields),
        "}",
    ]
    path = ROOT / "contactlaws" / "whole_range_constants.py"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


if __name__ == "__main__":
    main()
