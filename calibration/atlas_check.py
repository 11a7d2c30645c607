"""How well the atlas foretells curves that it is not made of: `python -m calibration.atlas_check FOLDER ... [--compute]`.

Every sphere in the folders whose curve is no part of the atlas is compared, unloading by unloading. With --compute random materials
between the atlas's nodes (always the same ones) are computed first, into the first folder.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from calibration import atlas as atlas_file
from calibration.atlas import Atlas
from calibration.atlas_build import compute, key_of, read_folders, require_folders
from calibration.atlas_errors import expected, measured
from calibration.predict import interpolator, modulus_ratio
from calibration.unloadings import unloading
from contactlaws.curve import Curve
from contactlaws.errors import InputError
from contactlaws.material import Material

RANDOM_MATERIALS, SEED = 10, 2020
PERCENTILES = (50, 75, 90, 100)
COLUMNS = ("force", "contact_radius", "unloading_stiffness", "unloading_exponent", "recovered_energy", "unloading_force")


class Difference(NamedTuple):
    """One unloading: the atlas over the finite elements less 1; the last is the largest difference of the force over that at the start."""

    modulus_ratio: float
    poissons_ratio: float
    start: float  # overlap over radius
    force: float
    contact_radius: float
    unloading_stiffness: float
    unloading_exponent: float
    recovered_energy: float
    unloading_force: float


def random_materials() -> list[Material]:
    """Evenly spread over ln E/Y and Poisson's ratio, rounded so that their file names say all."""
    draw = np.random.default_rng(SEED)
    ratios = np.exp(draw.uniform(0.0, np.log(1e4), RANDOM_MATERIALS))
    return [
        Material(float(f"{ratio:.3g}"), round(float(nu), 3), 1.0)
        for ratio, nu in zip(ratios, draw.uniform(0.0, 0.49, RANDOM_MATERIALS), strict=True)
    ]


def differences(atlas: Atlas, curve: Curve) -> Iterator[Difference]:
    """One per unloading of a plastic body's curve."""
    assert curve.material is not None
    ratio, nu = modulus_ratio(curve.material), curve.material.poissons_ratio
    assert ratio is not None
    response = interpolator(atlas)(ratio, nu)
    scale = curve.material.youngs_modulus * curve.radius**2
    for branch in curve.unloadings:
        found = unloading(curve, branch)
        if found is None or beyond(atlas, found.overlap / curve.radius):
            continue
        start = found.overlap / curve.radius
        truth = (found.force, found.contact_radius or np.nan, found.stiffness, found.exponent, found.recovered_energy)
        units = np.array([scale, curve.radius, 1.0, 1.0, scale * curve.radius])
        values = measured(response, np.array([start]))[0] * units
        rows = curve.rows(branch)
        share = (curve.overlap[rows] - curve.overlap[rows][-1]) / (curve.overlap[rows][0] - curve.overlap[rows][-1])
        shape = response.shape(start, share) - curve.force[rows] / curve.force[rows][0]
        relative = (values / truth - 1.0).tolist()
        yield Difference._make((ratio, nu, start, *relative, float(abs(shape).max())))


def beyond(atlas: Atlas, start: float) -> bool:
    """Whether an overlap over the radius is beyond the atlas."""
    return start > float(atlas.starts[-1]) * (1.0 + 1e-6)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry of the command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m calibration.atlas_check", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER", help="folders of curves (.parquet)")
    parser.add_argument("--atlas", type=Path, default=atlas_file.SHIPPED, help="default: the one that this package ships")
    parser.add_argument("--compute", action="store_true", help="compute random materials first")
    parser.add_argument("--materials", type=int, default=RANDOM_MATERIALS, help=f"how many of them; default {RANDOM_MATERIALS}, the most")
    parser.add_argument("--jobs", type=int, default=2, help="processes that compute; default 2")
    asked = parser.parse_args(arguments)
    try:
        atlas = atlas_file.read(asked.atlas)
        require_folders(asked.folders, asked.compute)
        found = read_folders(asked.folders)
        if asked.compute:
            compute(asked.folders[0], [one for one in random_materials()[: asked.materials] if key_of(one) not in found], asked.jobs)
            found = read_folders(asked.folders)
        print(report(atlas, [curve for key, curve in found.items() if key[0] is not None and curve.content_hash not in atlas.hashes]))
    except InputError as error:
        print("\n".join(map(str, error.problems)), file=sys.stderr)
        return 2
    return 0


def report(atlas: Atlas, curves: Sequence[Curve]) -> str:
    """One line per quantity over all unloadings inside the atlas, then how often the stated interpolation error holds."""
    low, high = float(atlas.modulus_ratios[0]), float(atlas.modulus_ratios[-1])
    inside = [curve for curve in curves if low <= (modulus_ratio(curve.material) or 0.0) <= high]  # type: ignore[arg-type]
    rows = [row for curve in inside for row in differences(atlas, curve)]
    if not rows:
        return "no curve in these folders is inside the atlas and no part of it"
    table = abs(np.array(rows)[:, 3:])
    lines = [
        f"{len(inside)} materials that are no part of the atlas {atlas.content_hash}, {len(rows)} unloadings; % (50/75/90/100th percentile)"
    ]
    for k, name in enumerate(COLUMNS):
        worst = rows[int(np.argmax(table[:, k]))]
        values = " / ".join(f"{value:.2f}" for value in 100.0 * np.percentile(table[:, k], PERCENTILES))
        lines.append(
            f"  {name:20s} {values}   largest at E/Y = {worst.modulus_ratio:g}, nu = {worst.poissons_ratio:g}, d = {worst.start:.3g} R"
        )
    lines.append(f"  within the stated error: {100.0 * held(atlas, rows):.1f} % of all these numbers")
    return "\n".join(lines)


def held(atlas: Atlas, rows: Sequence[Difference]) -> float:
    """Share of the first five columns within what `calibration.predict` states for the whole curve: interpolation and finite elements."""
    within = []
    for row in rows:
        stated = expected(atlas, row.modulus_ratio, row.poissons_ratio, row.start).total
        relative = {**stated, "unloading_exponent": stated["unloading_exponent"] / 1.4}  # stated absolute
        within += [abs(getattr(row, name)) <= relative[name] for name in COLUMNS[:5]]
    return float(np.mean(within))


if __name__ == "__main__":
    sys.exit(main())
