"""The command that makes the atlas: `python -m calibration.atlas_build FOLDER [--compute] [--jobs 2] [--out FILE]`.

FOLDER holds one curve per material, as Parquet, among them one without yield stress for each Poisson's ratio; other curves are passed over.
With --compute the missing ones are computed there first, by `fem.press` in separate processes; interrupted, the command goes on from what
is there. --list says which materials the atlas is made of.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import numpy.typing as npt

from calibration import atlas as atlas_file
from calibration.atlas import Atlas
from calibration.atlas_columns import columns, elastic_columns, starts_of
from calibration.atlas_errors import leave_out
from contactlaws.curve import QUANTITIES, Curve
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.errors import InputError, Problem, require
from contactlaws.material import Material
from contactlaws.version import code_version

FloatArray = npt.NDArray[np.float64]

#: E/Y and Poisson's ratios of the atlas: each modulus about 1.4 times the one before where first yield passes through the overlaps of
#: interest, twice where it lies far below them
MODULUS_RATIOS: tuple[float, ...] = (
    1.0,
    1.25,
    1.75,
    2.5,
    3.5,
    4.5,
    6.0,
    8.5,
    12.0,
    17.0,
    24.0,
    35.0,
    50.0,
    85.0,
    120.0,
    200.0,
    400.0,
    900.0,
)
MODULUS_RATIOS += (2000.0, 4500.0, 10000.0)
POISSONS_RATIOS = (0.0, 0.15, 0.3, 0.45, 0.49)
#: overlaps over the radius to unload from; the smallest and the largest are the range of the atlas
STARTS = (0.001, 0.0015, 0.0025, 0.004, 0.006, 0.01, 0.015, 0.02, 0.03, 0.04, 0.05, 0.07, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
#: rows of the loading beside the starts: each overlap over the one before
GROWTH = 1.15
#: a row nearer than this (in the logarithm) to a start is left out
APART = 0.05


def materials() -> Iterator[Material]:
    """All materials of the shipped atlas; yield stress 1, the elastic ones with Young's modulus 1."""
    for nu in POISSONS_RATIOS:
        yield Material(1.0, nu)
        yield from (Material(ratio, nu, 1.0) for ratio in MODULUS_RATIOS)


def file_name(material: Material) -> str:
    """The name of a material's curve in the folder.

    >>> file_name(Material(50.0, 0.3, 1.0)), file_name(Material(1.0, 0.3))
    ('E50_nu0.3.parquet', 'elastic_nu0.3.parquet')
    """
    start = "elastic" if material.yield_stress is None else f"E{material.youngs_modulus / material.yield_stress:g}"
    return f"{start}_nu{material.poissons_ratio:g}.parquet"


def compute(folder: Path, jobs: int) -> None:
    """Compute every curve that is not there yet, in `jobs` processes; each file appears when it is complete."""
    folder.mkdir(parents=True, exist_ok=True)
    missing = [material for material in materials() if not (folder / file_name(material)).exists()]
    # stiff and nearly incompressible bodies take longest: first, so that no process is left alone with one at the end
    missing.sort(key=lambda material: (material.poissons_ratio, material.youngs_modulus), reverse=True)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(compute_one, material, folder) for material in missing]
        for number, future in enumerate(as_completed(futures), 1):
            print(f"{number}/{len(missing)} {future.result()}", flush=True)


def compute_one(material: Material, folder: Path) -> str:
    """One curve, into its file; the elastic one is unloaded once, so that it is resolved from the same overlap on."""
    import fem

    starts = STARTS if material.yield_stress is not None else STARTS[:1]
    curve = fem.press(material, unload_from=starts, max_overlap=STARTS[-1])
    path = write_curve(curve, folder / file_name(material))
    return f"{path.name} {curve.provenance['cpu_seconds']:.1f} CPU s{'' if curve.stopped is None else f', stopped: {curve.stopped}'}"


def build(curves: Sequence[Curve]) -> Atlas:
    """The atlas of curves that make a tensor of E/Y and Poisson's ratios, with one elastic curve for each Poisson's ratio.

    Raises `InputError` naming what is missing, ends early, or was unloaded from other overlaps than the rest.
    """
    elastic = {key[1]: curve for curve in curves if (key := _key(curve))[0] is None}
    plastic = {key: curve for curve in curves if (key := _key(curve))[0] is not None}
    require(_problems(plastic, elastic))
    ratios, nus = (sorted({float(key[k] or 0.0) for key in plastic}) for k in (0, 1))
    starts = starts_of(next(iter(plastic.values())))
    depths = _depths(starts)
    bodies = [elastic_columns(elastic[nu], depths, starts) for nu in nus]
    table = [[columns(plastic[ratio, nu], body, depths, starts) for nu, body in zip(nus, bodies, strict=True)] for ratio in ratios]
    used = [plastic[ratio, nu] for ratio in ratios for nu in nus] + [elastic[nu] for nu in nus]

    def tensor(name: str) -> FloatArray:
        return np.array([[getattr(cell, name) for cell in row] for row in table])

    first = Atlas(
        np.array(ratios),
        np.array(nus),
        depths,
        starts,
        tensor("yield_depth"),
        tensor("loading"),
        tensor("unloading"),
        np.array([body[0] for body in bodies]),
        np.array([body[1] for body in bodies]),
        tensor("errors"),
        np.zeros((2, len(ratios), len(nus), starts.size, len(QUANTITIES))),
        tuple(curve.content_hash for curve in used),
        {"code": code_version(), "curves_code": sorted({str(curve.provenance.get("code")) for curve in used})},
    )
    return replace(first, leave_out=leave_out(first))


def _depths(starts: FloatArray) -> FloatArray:
    fill = np.geomspace(starts[0], starts[-1], int(np.log(starts[-1] / starts[0]) / np.log(GROWTH)) + 1)
    return np.union1d(starts, fill[abs(np.log(fill[:, None] / starts)).min(axis=1) > APART])


def _key(curve: Curve) -> tuple[float | None, float]:
    assert curve.material is not None
    material = curve.material
    return None if material.yield_stress is None else material.youngs_modulus / material.yield_stress, material.poissons_ratio


def _problems(plastic: Mapping[tuple[float | None, float], Curve], elastic: Mapping[float, Curve]) -> Iterator[Problem]:
    ratios, nus = (sorted({key[k] for key in plastic}, key=float) for k in (0, 1))  # type: ignore[arg-type]
    if len(ratios) < 4 or len(nus) < 3:
        yield Problem("curves", (len(ratios), len(nus)), "an atlas needs at least 4 moduli and 3 Poisson's ratios", "compute more")
        return
    for nu in nus:
        if nu not in elastic:
            yield Problem("elastic curve", nu, "there is none of this Poisson's ratio", "compute it, or use --compute")
        for ratio in ratios:
            if (ratio, nu) not in plastic:
                yield Problem("curve", (ratio, nu), "of this E/Y and Poisson's ratio is missing", "compute it, or use --compute")
    for (ratio, nu), curve in [*plastic.items(), *(((None, nu), curve) for nu, curve in elastic.items())]:
        if curve.stopped is not None:
            yield Problem("curve", (ratio, nu), f"ends early: {curve.stopped}", "leave its modulus or Poisson's ratio out")


def read_folder(folder: Path, wanted: Sequence[str] | None) -> list[Curve]:
    """The curves in a folder: those of the files `wanted`, or all spheres with a material."""
    if wanted is not None:
        missing = [name for name in wanted if not (folder / name).exists()]
        require(Problem(str(folder / name), None, "is not there", "compute it, or use --compute") for name in missing)
    paths = sorted(folder.glob("*.parquet")) if wanted is None else [folder / name for name in wanted]
    curves = [read_curve(path) for path in paths]
    return [curve for curve in curves if curve.material is not None and curve.aspect == 1.0]


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry of the command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m calibration.atlas_build", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder of curves (.parquet)")
    parser.add_argument("--out", type=Path, default=atlas_file.SHIPPED, help="the atlas; default: the one that this package ships")
    parser.add_argument("--compute", action="store_true", help="compute the curves that are missing")
    parser.add_argument("--jobs", type=int, default=2, help="processes that compute; default 2")
    parser.add_argument("--all", action="store_true", help="make it of all curves in the folder, whatever their materials")
    parser.add_argument("--list", action="store_true", help="only say which curves are needed, and which are missing")
    asked = parser.parse_args(arguments)
    names = [file_name(material) for material in materials()]
    if asked.list:
        print("\n".join(f"{name}{'' if (asked.folder / name).exists() else '  missing'}" for name in names))
        return 0
    try:
        if asked.compute:
            compute(asked.folder, asked.jobs)
        atlas = build(read_folder(asked.folder, None if asked.all else names))
        asked.out.parent.mkdir(parents=True, exist_ok=True)
        atlas_file.write(atlas, asked.out)
    except InputError as error:
        print("\n".join(map(str, error.problems)), file=sys.stderr)
        return 2
    print(summary(atlas, asked.out))
    return 0


def summary(atlas: Atlas, path: Path) -> str:
    """What was written, and how much leaving out a modulus changes (each material between its neighbours)."""
    lines = [f"{path}: {path.stat().st_size / 1e6:.2f} MB, {len(atlas.hashes)} curves, hash {atlas.content_hash}"]
    for axis, name in enumerate(("E/Y", "Poisson's ratio")):
        inner = atlas.leave_out[axis][1:-1] if axis == 0 else atlas.leave_out[axis][:, 1:-1]
        for k, quantity in enumerate(QUANTITIES):
            percentiles = 100.0 * np.percentile(inner[..., k], [50, 75, 90, 100])
            lines.append(f"  without its {name}: {quantity:20s} {' / '.join(f'{p:.2f}' for p in percentiles)} % (50/75/90/100)")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
