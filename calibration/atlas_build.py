"""The command that makes the atlas: `python -m calibration.atlas_build FOLDER ... [--compute] [--jobs 2] [--out FILE]`.

The folders hold curves as Parquet, among them one of each material that --list names; others are passed over, and of two of one material
the first is taken. Curves of the study of Edmans & Sinka 2020 are part of it. With --compute the missing ones are computed by
`fem.press` in separate processes, into the first folder; interrupted, the command goes on from what is there.
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
Key = tuple[float | None, float]

#: E/Y and Poisson's ratios of the atlas: those of Edmans & Sinka 2020, closer where first yield passes through the overlaps of interest,
#: and beyond them to nearly incompressible and to very weak bodies
MODULUS_RATIOS: tuple[float, ...] = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 20.0, 30.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
MODULUS_RATIOS += (3000.0, 10000.0)
POISSONS_RATIOS = (0.0, 0.15, 0.3, 0.45, 0.49)
#: overlaps over the radius to unload from, theirs too; below the smallest, small strains leave only one parameter
STARTS = (0.01, 0.02, 0.03, 0.04, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
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


def compute(folder: Path, missing: Sequence[Material], jobs: int) -> None:
    """Compute the curves of `missing` in `jobs` processes; each file appears when it is complete."""
    # stiff and nearly incompressible bodies take longest: first, so that no process is left alone with one at the end
    ordered = sorted(missing, key=lambda material: (material.poissons_ratio, material.youngs_modulus), reverse=True)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(compute_one, material, folder) for material in ordered]
        for number, future in enumerate(as_completed(futures), 1):
            print(f"{number}/{len(ordered)} {future.result()}", flush=True)


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


def key_of(material: Material) -> Key:
    """E/Y, to nine digits, and Poisson's ratio."""
    ratio = None if material.yield_stress is None else float(f"{material.youngs_modulus / material.yield_stress:.9g}")
    return ratio, material.poissons_ratio


def _key(curve: Curve) -> Key:
    assert curve.material is not None
    return key_of(curve.material)


def _problems(plastic: Mapping[Key, Curve], elastic: Mapping[float, Curve]) -> Iterator[Problem]:
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


def require_folders(folders: Sequence[Path], create: bool) -> None:
    """Raise `InputError` for folders that are not there; with `create` the first one, where curves are to be written, is made."""
    try:
        if create:
            folders[0].mkdir(parents=True, exist_ok=True)
    except OSError as error:
        name = error.strerror or str(error)
        raise InputError(Problem("FOLDER", str(folders[0]), f"cannot be created ({name})", "choose another folder")) from error
    remedy = "give a folder of curves, or --compute to make them there"
    require(Problem("FOLDER", str(folder), "is no folder", remedy) for folder in folders if not folder.is_dir())


def read_folders(folders: Sequence[Path]) -> dict[Key, Curve]:
    """The curves of whole spheres in some folders, by E/Y (None: elastic) and Poisson's ratio; the first of each material."""
    found: dict[Key, Curve] = {}
    for path in (path for folder in folders for path in sorted(folder.glob("*.parquet"))):
        curve = read_curve(path)
        if curve.material is not None and curve.aspect == 1.0:
            found.setdefault(key_of(curve.material), curve)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry of the command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m calibration.atlas_build", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER", help="folders of curves (.parquet)")
    parser.add_argument("--out", type=Path, default=atlas_file.SHIPPED, help="the atlas; default: the one that this package ships")
    parser.add_argument("--compute", action="store_true", help="compute the curves that are missing, into the first folder")
    parser.add_argument("--jobs", type=int, default=2, help="processes that compute; default 2")
    parser.add_argument("--list", action="store_true", help="only say which curves are needed, and which are missing")
    asked = parser.parse_args(arguments)
    try:
        require_folders(asked.folders, asked.compute)
        found = read_folders(asked.folders)
        missing = [material for material in materials() if key_of(material) not in found]
        if asked.list:
            print("\n".join(f"{file_name(material)}{'  missing' if material in missing else ''}" for material in materials()))
            return 0
        if asked.compute and missing:
            compute(asked.folders[0], missing, asked.jobs)
            found = read_folders(asked.folders)
        wanted = [key_of(material) for material in materials()]
        atlas = build([found[key] for key in wanted if key in found])
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
