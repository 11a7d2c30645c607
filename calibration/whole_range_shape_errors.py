"""How far the whole-range law of ellipsoids is from curves of pressed spheroids.

    python -m calibration.whole_range_shape_errors FOLDER

Of each body and unloading up to an overlap of .15 of the mean radius: the mean error of the force along load, unload and reload over the
largest force, in equal steps of the overlap, also averaged over the unloadings of a body; the residual overlap over the largest; the
contact area where the unloading begins, and its mean error along the unloading over the area there.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration.whole_range_shape_data import Pressed, Unloading, read_folder
from contactlaws import whole_range_shape_constants
from contactlaws.whole_range_shape import constants_of, shaped_area, shaped_area_left, shaped_loading, shaped_recovered, shaped_terms
from contactlaws.whole_range_unloading import shape

FloatArray = npt.NDArray[np.float64]
DEEPEST = 0.15
STEPS = 100


class Errors(NamedTuple):
    """Of one unloading, each as a share."""

    force: float  # mean along the path over the largest
    loading: float  # mean of the loading over the largest
    residual: float  # overlap, law less curve, over the largest overlap
    area: float  # at the last row of the loading up to there, over the area
    retreat: float  # of the area, mean along the unloading over the largest
    name: str
    depth: float  # over the mean radius


def errors(body: Pressed, c: FloatArray, one: Unloading) -> Errors:
    """Of one unloading of a body, c the constants of its material."""
    law, local = body.law, body.local
    load, phi = shaped_loading(law, c, local, one.depth)
    area = shaped_area(law, c, local, one.depth, phi)
    recovered = shaped_recovered(law, c, local, one.depth, load, phi, area)
    terms = shaped_terms(law, c, local, one.depth, phi)
    up = np.linspace(0.0, one.depth, STEPS + 1)[1:]
    loading = abs(np.array([shaped_loading(law, c, local, d)[0] for d in up]) - _between(body, up)) / one.load
    first = one.depth - max(recovered, one.recovered)
    back = np.linspace(first, one.depth, STEPS + 1)
    left = np.maximum(0.0, 1.0 - (one.depth - back) / recovered)
    own = load * np.array([shape(terms, s) for s in left])
    rows = one.depth - one.recovered * (1.0 - one.left[::-1])
    curve = one.load * np.interp(back, rows, one.share[::-1], left=0.0)
    unloading = abs(own - curve) / one.load
    # load once, unload and reload on one line: each in proportion to its way
    way = (one.depth - first) / one.depth
    mean = (loading.mean() + 2.0 * way * unloading.mean()) / (1.0 + 2.0 * way)
    keep = (body.depth <= one.depth) & (body.t > 0.05)
    found = np.array([shaped_area(law, c, local, d, shaped_loading(law, c, local, d)[1]) for d in body.depth[keep][-1:]])
    difference = abs(found / body.area[keep][-1:] - 1.0).max(initial=0.0)
    rests = area * np.array([shaped_area_left(law, c, local, one.depth, load, phi, area, recovered, terms, s) for s in left])
    rested = one.area * np.interp(back, rows, one.area_share[::-1], left=0.0)
    retreat = abs(rests - rested).mean() / one.area
    return Errors(mean, loading.mean(), (one.recovered - recovered) / one.depth, difference, retreat, body.name, one.depth * local[1])


def _between(body: Pressed, depth: FloatArray) -> FloatArray:
    """The force of the curve between its rows: over Hertz's it is smooth."""
    ratio = np.interp(np.sqrt(depth), np.sqrt(body.depth), body.load / body.depth**1.5)
    return ratio * depth**1.5


def all_errors(table: Mapping[str, FloatArray], bodies: Sequence[Pressed]) -> list[Errors]:
    """Of all unloadings up to `DEEPEST`."""
    found = []
    for body in bodies:
        if not body.elastic:
            c = constants_of(table, body.law.poissons_ratio)
            found += [errors(body, c, one) for one in body.unloadings if one.depth * body.local[1] <= DEEPEST * 1.001]
    return found


def report(table: Mapping[str, FloatArray], bodies: Sequence[Pressed]) -> str:
    """Percentiles and the worst, as text."""
    found = all_errors(table, bodies)
    lines = [f"{len(found)} unloadings up to {DEEPEST} of the mean radius; errors in % at the 50/75/90/100th percentile"]
    for name in ("force", "loading", "residual", "area", "retreat"):
        values = np.array([100.0 * abs(getattr(one, name)) for one in found])
        text = "/".join(f"{value:.2f}" for value in np.percentile(values, (50, 75, 90, 100)))
        worst = found[int(values.argmax())]
        lines.append(f"{name:10s} {text}   worst: {worst.name}, overlap {worst.depth:.3g}")
    for name, limit in (("force", 0.01), ("residual", 0.02), ("area", 0.03)):
        beyond = sum(abs(getattr(one, name)) > limit for one in found)
        lines.append(f"{name} beyond {100 * limit:g} %: {beyond} of {len(found)}")
    lines.append(_worst_body(found))
    return "\n".join(lines)


def _worst_body(found: Sequence[Errors]) -> str:
    """Errors of the force averaged over the unloadings of each body, the largest of all bodies, as text."""
    forces: dict[str, list[float]] = {}
    for one in found:
        forces.setdefault(one.name, []).append(one.force)
    largest, name = max((float(np.mean(values)), name) for name, values in forces.items())
    return f"force, mean over the unloadings of a body: at most {100.0 * largest:.2f} % of {len(forces)} bodies, {name}"


def main(arguments: Sequence[str] | None = None) -> None:
    """See the module."""
    parser = argparse.ArgumentParser(prog="python -m calibration.whole_range_shape_errors", description=__doc__)
    parser.add_argument("folder", type=Path)
    options = parser.parse_args(arguments)
    print(report(vars(whole_range_shape_constants), list(read_folder(options.folder))))


if __name__ == "__main__":
    main()
