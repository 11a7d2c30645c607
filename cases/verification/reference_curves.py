"""Curves of the continuum solver against those of an independent code, one CSV file each; exit code 1 if a bound is broken.

    python -m cases.verification.reference_curves FOLDER        or FOLDER in the environment as FE2DEM_REFERENCE

A file is named E<Young's modulus over yield stress>_nu<Poisson's ratio>_d<largest overlap over radius>.csv, perhaps with `_something`
before the dot. Columns: `delta` overlap over radius; `F` force over (pi R^2 times the yield stress); `stage` load or unload; and, if the
other code gives it, a bracket of the contact radius over R: `a_lo`, `a_hi`.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline, PchipInterpolator

import fem
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem
from contactlaws.material import Material
from fem.readout import exponent

FloatArray = npt.NDArray[np.float64]

FORCE_BOUND, STIFFNESS_BOUND, EXPONENT_BOUND, RADIUS_BOUND = 0.007, 0.01, 0.02, 0.01
#: the first part of a loading path is left out: there the other code has few nodes in contact
FROM_SHARE = 0.2
#: rows of an unloading from which the other code's zero of force is extrapolated
LAST_ROWS = 3
NAME = re.compile(r"E(?P<ratio>[\d.e+]+)_nu(?P<nu>[\d.]+)_d(?P<overlap>[\d.]+\d)(_\w+)?\.csv")


class Reference(NamedTuple):
    """The other code's curve; lengths over the radius, force over (pi R^2 times the yield stress)."""

    name: str
    material: Material  # in units of the yield stress
    overlap: FloatArray
    force: FloatArray
    bracket: tuple[FloatArray, FloatArray] | None  # of the contact radius
    unloading_overlap: FloatArray  # first row: the last of the loading
    unloading_force: FloatArray
    unloading_bracket: tuple[FloatArray, FloatArray] | None  # without that first row


class Comparison(NamedTuple):
    """How far this project's curve is from the other one."""

    force_by_work: float  # work of one over that of the other, minus 1
    force_pointwise: float  # mean of the ratio of forces, minus 1
    stiffness: float | None  # 1/(d_max - d_0), ratio minus 1; None: the other code did not unload
    exponent: float | None  # difference
    inside: float | None  # share of contact radii within the bracket
    outside_by: float | None  # farthest from the bracket, over the radius of contact
    unloading_outside: float | None  # mean distance from the bracket along the unloading, over the largest radius
    radius_error: float  # the curve's own estimate for its contact radius
    cpu_seconds: float

    def broken(self) -> list[str]:
        """The bounds that do not hold."""
        rows = (
            ("force", max(self.force_by_work, self.force_pointwise, key=abs), FORCE_BOUND),
            ("unloading stiffness", self.stiffness, STIFFNESS_BOUND),
            ("unloading exponent", self.exponent, EXPONENT_BOUND),
            ("contact radius outside its bracket", self.outside_by, self.radius_error),
            ("contact radius outside its bracket on unloading", self.unloading_outside, RADIUS_BOUND),
        )
        return [f"{name} {value:+.4f} (bound {bound})" for name, value, bound in rows if value is not None and not abs(value) <= bound]


def read(file: Path) -> Reference:
    """Read one file; raises `InputError` if it is not of the form described above."""
    match = NAME.fullmatch(file.name)
    if match is None:
        raise InputError(Problem("file", file.name, "must be named E<ratio>_nu<nu>_d<overlap>.csv", "rename it"))
    rows = np.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding="utf-8")
    columns = set(rows.dtype.names or ())
    missing = {"delta", "F", "stage"} - columns
    if missing:
        raise InputError(Problem("columns", sorted(missing), f"missing in {file.name}", "write delta, F and stage"))
    load = rows["stage"] == "load"
    last = np.flatnonzero(load)[-1:]
    unload = np.concatenate([last, np.flatnonzero(~load)])
    bracket, back = ((rows["a_lo"][part], rows["a_hi"][part]) if {"a_lo", "a_hi"} <= columns else None for part in (load, ~load))
    material = Material(float(match["ratio"]), float(match["nu"]), 1.0)
    return Reference(file.stem, material, rows["delta"][load], rows["F"][load], bracket, rows["delta"][unload], rows["F"][unload], back)


def separation(overlap: FloatArray, force: FloatArray) -> float:
    """Overlap at which the force of an unloading vanishes: its last rows follow (d - d_0)^p, p being the exponent of the whole branch."""
    pressed = force > 0.0
    x, f = overlap[pressed], force[pressed]
    zero, power = float(x[-1]), 1.3
    for _ in range(20):
        zero = float(np.polyfit(f[-LAST_ROWS:] ** (1.0 / power), x[-LAST_ROWS:], 1)[1])
        power = _exponent(x, f, zero)
    return zero


def _exponent(overlap: FloatArray, force: FloatArray, zero: float) -> float:
    """Least-squares exponent of an unloading that ends at `zero`."""
    return exponent(np.append(overlap, zero), np.append(force, 0.0))


def _unloading(curve: Curve, reference: Reference) -> tuple[float, float, float | None] | tuple[None, None, None]:
    """Relative difference of 1/(d_max - d_0); on the same shares of the recovery, difference of the exponents, and `unloading_outside`."""
    x, f = reference.unloading_overlap, reference.unloading_force
    if np.count_nonzero(f > 0.0) <= LAST_ROWS:
        return None, None, None
    zero = separation(x, f)
    rows = curve.rows(1)
    own_x, own_f, own_a = curve.overlap[rows], curve.force[rows], curve.contact_radius[rows]  # type: ignore[index]
    pressed = f > 0.0
    x, f = x[pressed], f[pressed]
    share = (x - zero) / (x[0] - zero)
    at = own_x[-1] + share * (own_x[0] - own_x[-1])
    own_at = PchipInterpolator(own_x[::-1], own_f[::-1])(at)
    stiffness = (x[0] - zero) / (own_x[0] - own_x[-1]) - 1.0
    outside = None
    if reference.unloading_bracket is not None:
        low, high = (side[pressed[1:]] for side in reference.unloading_bracket)
        outside = float((_distance(np.interp(at[1:], own_x[::-1], own_a[::-1]), low, high) / own_a[0]).mean())
    return float(stiffness), _exponent(at, own_at, float(own_x[-1])) - _exponent(x, f, zero), outside


def _distance(value: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """From the bracket, 0 inside."""
    return np.maximum(np.maximum(low - value, value - high), 0.0)


def compare(curve: Curve, reference: Reference) -> Comparison:
    """Compare on the rows of the other code's loading beyond its first fifth, and on those of its unloading."""
    rows = curve.rows(0)
    overlap, force, radius = curve.overlap[rows][1:], curve.force[rows][1:] / np.pi, curve.contact_radius[rows][1:]  # type: ignore[index]
    beyond = reference.overlap >= FROM_SHARE * reference.overlap[-1]
    x, f = reference.overlap[beyond], reference.force[beyond]
    own = np.exp(CubicSpline(np.log(overlap), np.log(force))(np.log(x)))
    inside = outside_by = None
    if reference.bracket is not None:
        low, high = (side[beyond] for side in reference.bracket)
        a = np.exp(np.interp(np.log(x), np.log(overlap), np.log(radius)))
        outside = _distance(a, low, high) / a
        inside, outside_by = float((outside == 0.0).mean()), float(outside.max())
    by_work = float(np.trapezoid(own, x) / np.trapezoid(f, x) - 1.0)
    stiffness, shift, back = _unloading(curve, reference)
    cost, radius_error = float(curve.provenance["cpu_seconds"]), curve.errors.get("contact_radius", 0.0)
    return Comparison(by_work, float((own / f - 1.0).mean()), stiffness, shift, inside, outside_by, back, radius_error, cost)


def compute(reference: Reference, tolerance: float) -> Curve:
    """The solver's curve along the same path."""
    return fem.press(reference.material, unload_from=[float(reference.overlap[-1])], tolerance=tolerance)


def _lines(name: str, found: Comparison) -> Iterator[str]:
    def text(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    force = f"{found.force_by_work:+11.2%}{found.force_pointwise:+11.2%}"
    back = f"{text(found.stiffness, '+.2%'):>12s}{text(found.exponent, '+.4f'):>11s}"
    radius = f"{text(found.inside, '.1%'):>9s}{text(found.outside_by, '.2%'):>9s}{text(found.unloading_outside, '.2%'):>9s}"
    yield f"{name:28s}{force}{back}{radius}{found.cpu_seconds:8.2f}"
    for broken in found.broken():
        yield f"    BROKEN: {broken}"


def main(arguments: list[str] | None = None) -> int:
    """Compare all files of a folder and return the exit code: 0, 1 if a bound is broken, 2 if there is nothing to compare with."""
    parser = argparse.ArgumentParser(prog="python -m cases.verification.reference_curves", description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("folder", nargs="?", default=os.environ.get("FE2DEM_REFERENCE"), help="default: $FE2DEM_REFERENCE")
    parser.add_argument("--tolerance", type=float, default=0.01, help="of the solver; default 0.01")
    given = parser.parse_args(arguments)
    files = sorted(Path(given.folder).glob("*.csv")) if given.folder else []
    usable = [file for file in files if NAME.fullmatch(file.name)]
    if not usable:
        where = given.folder or "(no folder given, FE2DEM_REFERENCE not set)"
        print(f"no file E<ratio>_nu<nu>_d<overlap>.csv in {where}", file=sys.stderr)
        return 2
    fem.press(Material(100.0, 0.3, 1.0), unload_from=[1e-3], tolerance=0.01)  # compiles; not counted below
    print(f"{'':28s}{'force':>22s}{'':>12s}{'':>11s}{'contact radius':>27s}")
    heads = {
        "curve": -28,
        "by work": 11,
        "pointwise": 11,
        "stiffness": 12,
        "exponent": 11,
        "inside": 9,
        "off by": 9,
        "back by": 9,
        "CPU s": 8,
    }
    print("".join(head.ljust(-width) if width < 0 else head.rjust(width) for head, width in heads.items()))
    held = True
    for file in usable:
        reference = read(file)
        found = compare(compute(reference, given.tolerance), reference)
        held &= not found.broken()
        print("\n".join(_lines(reference.name, found)), flush=True)
    print(
        f"bounds: force {FORCE_BOUND:.1%}, 1/(d_max - d_0) {STIFFNESS_BOUND:.0%}, exponent {EXPONENT_BOUND}, "
        f"radius on the way back {RADIUS_BOUND:.0%}: {'held' if held else 'BROKEN'}"
    )
    for file in sorted(set(files) - set(usable)):
        print(f"not compared, the name says nothing of the material: {file.name}")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
