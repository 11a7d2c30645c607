"""Fit what the shape of a body changes in the whole-range law, to curves of pressed spheroids, and write the constants.

    python -m calibration.whole_range_shape_fit FOLDER [--dry]

One after the other, since each builds on those before: elastic force and area (linear least squares), the loading (least squares of the
logarithm of the force, with first yield), and then, with the loading as it is, contact area, residual overlap and the power of the
unloading (linear). FOLDER is made by `calibration.spheroid_curves`. Run again it gives the same digits; another order of the sums of the
linear algebra (other threads, another machine) shows in the fourth digit of constants that make up for each other, and in 1e-4 of forces.
"""

from __future__ import annotations

import argparse
import hashlib
import math
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from calibration.whole_range_shape_data import Pressed, read_folder
from calibration.whole_range_shape_errors import report
from contactlaws.compiled import kernel
from contactlaws.sources import ROOT
from contactlaws.whole_range_shape import (
    EXTENTS,
    constants_of,
    root_of_size,
    shaped_area,
    shaped_loading,
    shaped_recovered,
    shaped_terms,
    shaped_yield_gap,
)
from contactlaws.whole_range_unloading import shape

FloatArray = npt.NDArray[np.float64]
Table = dict[str, FloatArray]  # of each correction its constants, the last axis for powers of Poisson's ratio

#: how many powers of Poisson's ratio each correction gets, from 0 on
POWERS_OF_NU = {
    "FORCE": 3, "AREA": 3, "YIELD": 2, "LIMIT": 2, "BEND": 1, "LAG": 2, "ONSET": 1, "SPREAD": 2, "RESIDUAL": 2, "ROUND": 2, "SATURATION": 1,
}  # fmt: skip
#: rows pressed less far say nothing of the shape, but feel the mesh: root of the overlap over the mean radius
SHALLOWEST = 0.02
#: weights of what pulls constants to nothing, over that of a relative error
PULL = 1e-4


def empty() -> Table:
    """No correction at all."""
    table = {name: np.zeros((*extent, POWERS_OF_NU[name])) for name, extent in EXTENTS.items()}
    table["SATURATION"][...] = 0.6
    return table


def powers(extent: tuple[int, ...], nus: int, values: Sequence[FloatArray], nu: float) -> FloatArray:
    """The terms of a polynomial in the order of its constants, one row per point."""
    m, s, *phi = (np.asarray(value, dtype=float) for value in values)
    terms: FloatArray = m[:, None] ** np.arange(1.0, extent[0] + 1)
    terms = terms[:, :, None] * np.broadcast_to(s, m.shape)[:, None, None] ** np.arange(1.0, extent[1] + 1)
    if phi:
        terms = terms[..., None] * phi[0][:, None, None, None] ** np.arange(float(extent[2]))
    return (terms[..., None] * nu ** np.arange(nus)).reshape(len(m), -1)


def linear(matrix: FloatArray, wanted: FloatArray, weight: FloatArray, pull: float) -> FloatArray:
    """Least squares with columns of one length and a pull to nothing."""
    matrix, wanted = matrix * weight[:, None], wanted * weight
    length = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    system = np.vstack([matrix / length, pull * np.eye(len(length))])
    return np.linalg.lstsq(system, np.append(wanted, np.zeros(len(length))), rcond=None)[0] / length


def fit_elastic(bodies: Sequence[Pressed], name: str) -> FloatArray:
    """FORCE or AREA from the elastic curves."""
    matrix, wanted, weight = [], [], []
    for body in bodies:
        if not body.elastic:
            continue
        t, law, s = body.t, body.law, body.local[2]
        if name == "FORCE":
            factor, own = body.load / (law.stiffness * body.depth**1.5), (law.force_1, law.force_2, law.force_3)
        else:
            factor, own = body.area / body.depth, (law.area_1, law.area_2, law.area_3)
        orders = np.stack([t, t**2, t**6], axis=1)
        terms = orders[:, :, None, None] * (s ** np.arange(1, 5))[:, None] * law.poissons_ratio ** np.arange(POWERS_OF_NU[name])
        matrix.append(terms.reshape(len(t), -1))
        wanted.append(factor - 1.0 - orders @ np.array(own))
        weight.append(1.0 / factor)
    found = linear(np.vstack(matrix), np.concatenate(wanted), np.concatenate(weight), 1e-5)
    return found.reshape(*EXTENTS[name], POWERS_OF_NU[name])


@kernel
def loads(law, c, local, depth):  # type: ignore[no-untyped-def]
    """Force and phi at each depth of the loading."""
    found = np.empty((2, len(depth)))
    for i in range(len(depth)):
        found[0, i], found[1, i] = shaped_loading(law, c, local, depth[i])
    return found


def fit_loading(bodies: Sequence[Pressed], table: Table) -> None:
    """YIELD, LIMIT, BEND, LAG, ONSET and SATURATION, into `table`."""
    names = ("YIELD", "LIMIT", "BEND", "LAG", "ONSET", "SATURATION")
    sizes = [table[name].size for name in names]
    plastic = [body for body in bodies if not body.elastic]

    def unpack(x: FloatArray) -> Table:
        parts = np.split(x, np.cumsum(sizes)[:-1])
        return table | {name: part.reshape(table[name].shape) for name, part in zip(names, parts, strict=True)}

    def misses(x: FloatArray) -> FloatArray:
        trial, found = unpack(x), []
        constants = {nu: constants_of(trial, nu) for nu in {body.law.poissons_ratio for body in plastic}}
        for body in plastic:
            c, keep = constants[body.law.poissons_ratio], body.t > SHALLOWEST
            got = loads(body.law, c, body.local, body.depth[keep])[0]
            found.append(np.log(np.maximum(got, 1e-12) / body.load[keep]))
            if body.yield_depth is not None:
                found.append(np.array([0.3 * shaped_yield_gap(body.law, c, body.local, body.yield_depth)]))
        return np.concatenate([*found, PULL * x])

    start = np.concatenate([table[name].ravel() for name in names])
    solution = least_squares(misses, start, x_scale="jac", max_nfev=25, verbose=0)
    table |= unpack(solution.x)


def fit_rest(bodies: Sequence[Pressed], table: Table) -> None:
    """SPREAD, RESIDUAL and ROUND, into `table`."""
    plastic = [body for body in bodies if not body.elastic]
    _fit(plastic, table, "SPREAD", _area_rows)
    _fit(plastic, table, "RESIDUAL", _residual_rows)
    _fit(plastic, table, "ROUND", _round_rows)


Rows = tuple[FloatArray, FloatArray, FloatArray, FloatArray]  # m, phi, what the polynomial should be, weight


def _fit(bodies: Sequence[Pressed], table: Table, name: str, rows: Callable[[Pressed, FloatArray], Rows]) -> None:
    matrix, wanted, weight = [], [], []
    for body in bodies:
        c = constants_of(table, body.law.poissons_ratio)
        m, phi, target, weights = rows(body, c)
        matrix.append(powers(EXTENTS[name], POWERS_OF_NU[name], (m, np.array(body.local[2]), phi), body.law.poissons_ratio))
        wanted.append(target)
        weight.append(weights)
    found = linear(np.vstack(matrix), np.concatenate(wanted), np.concatenate(weight), 1e-2)
    table[name] = table[name] + found.reshape(table[name].shape)


def _sizes(body: Pressed, c: FloatArray, depth: FloatArray) -> FloatArray:
    return np.array([root_of_size(c, body.local, math.sqrt(d * body.local[1])) for d in depth])


def _area_rows(body: Pressed, c: FloatArray) -> Rows:
    keep = body.t > 2.5 * SHALLOWEST
    depth, phi = body.depth[keep], loads(body.law, c, body.local, body.depth[keep])[1]
    found = np.array([shaped_area(body.law, c, body.local, d, p) for d, p in zip(depth, phi, strict=True)])
    beyond = np.maximum(1.0 - phi, 1e-9)
    return _sizes(body, c, depth), phi, np.log(body.area[keep] / found) / beyond, np.where(phi < 1.0, beyond, 0.0)


def _residual_rows(body: Pressed, c: FloatArray) -> Rows:
    """Weighted with what it does to the recovered overlap, relative; one that is a small part of the overlap may be off by more."""
    depth = np.array([one.depth for one in body.unloadings])
    phi = loads(body.law, c, body.local, depth)[1]
    target, weight = np.zeros(len(depth)), np.zeros(len(depth))
    for i, one in enumerate(body.unloadings):
        area = shaped_area(body.law, c, body.local, one.depth, phi[i])
        recovered = shaped_recovered(body.law, c, body.local, one.depth, one.load, phi[i], area)
        residual, own = one.depth - one.recovered, one.depth - recovered
        if min(residual, own) > 1e-3 * one.depth and phi[i] < 1.0:
            target[i] = math.log(residual / one.recovered * recovered / own)
            weight[i] = residual / one.depth
    return _sizes(body, c, depth), phi, target, weight


def _round_rows(body: Pressed, c: FloatArray) -> Rows:
    """One Gauss step: how the shape misses, over how it changes with the power."""
    depth = np.array([one.depth for one in body.unloadings])
    phi = loads(body.law, c, body.local, depth)[1]
    target, weight = np.zeros(len(depth)), np.zeros(len(depth))
    for i, one in enumerate(body.unloadings):
        terms = shaped_terms(body.law, c, body.local, one.depth, phi[i])
        more = (*terms[:4], terms[4] + 1e-4, terms[5])
        own = np.array([shape(terms, s) for s in one.left])
        slope = (np.array([shape(more, s) for s in one.left]) - own) / 1e-4
        if phi[i] < 0.98:
            target[i] = float(slope @ (one.share - own) / max(slope @ slope, 1e-12)) / (1.0 - phi[i])
            weight[i] = math.sqrt(slope @ slope / len(slope)) * (1.0 - phi[i])
    return _sizes(body, c, depth), phi, target, weight


def fit(bodies: Sequence[Pressed]) -> Table:
    """All constants."""
    table = empty()
    for name in ("FORCE", "AREA"):
        table[name] = fit_elastic(bodies, name)
    fit_loading(bodies, table)
    fit_rest(bodies, table)
    return table


def written(table: Table, bodies: Sequence[Pressed]) -> str:
    """The module of constants."""
    digest = hashlib.sha256(b"".join(body.load.tobytes() for body in bodies)).hexdigest()[:16]
    lines = [
        '"""Constants of what the shape changes in the whole-range law. GENERATED by the command below: do not edit.',
        "",
        "The last axis is for powers of Poisson's ratio, the others as in `contactlaws.whole_range_shape`.",
        '"""',
        "",
        "import numpy as np",
        "",
        'COMMAND = "python -m calibration.whole_range_shape_fit FOLDER"',
        f'CURVES = "{digest}"  # hash of the loadings that they were fitted to',
        "",
    ]
    for name, values in table.items():
        rows = textwrap.wrap(", ".join(f"{value:.6g}" for value in values.ravel()), 132)
        lines += ["# fmt: off", f"{name} = np.array([", *(f"    {row}" for row in rows), f"]).reshape({values.shape})", "# fmt: on"]
    return "\n".join(lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """See the module."""
    parser = argparse.ArgumentParser(prog="python -m calibration.whole_range_shape_fit", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dry", action="store_true", help="do not write the constants")
    options = parser.parse_args(arguments)
    bodies = list(read_folder(options.folder))
    table = fit(bodies)
    print(report(table, bodies))
    if not options.dry:
        path = ROOT / "contactlaws" / "whole_range_shape_constants.py"
        path.write_text(written(table, bodies), encoding="utf-8")
        print(f"written: {path}; format it with ruff")


if __name__ == "__main__":
    main()
