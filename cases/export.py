"""A fitted law for other programs: as a table, and as the nearest law that LAMMPS has without compiling anything."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cases import lammps_table
from cases.benchmarks.lammps_input import Programs, installed
from cases.lammps_native import PEAKS, Branch, Misfit, Native, branches_of, branches_of_curve, is_plastic, misfit, nearest
from cases.lammps_replay import PAIR, ROW, replay, steps_for
from contactlaws.curve import Curve
from contactlaws.dispatch import law_of
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import write_text
from contactlaws.fitted import FittedLaw
from contactlaws.path import scan, trace
from contactlaws.version import code_version

#: rows of the loading in a table
ROWS = 101
#: r.m.s. over the largest force, from which an elastic law is not Hertz's: far above round-off
NOT_HERTZ = 1e-6


class Exported(NamedTuple):
    """What was written for LAMMPS, and how far it is from what it stands for."""

    native: Native
    theirs: Misfit  # of LAMMPS's law, computed by ours
    ours: Misfit | None  # of the fitted law itself, from the same curves; None: there were none, and the law itself is what is matched
    replayed: tuple[Misfit, Misfit] | None  # in LAMMPS, from the fitted law: in a row and alone as a pair; None: it is not installed
    table: Path | None = None  # the file with the law itself, which takes the native law's place; None: the native law stands


def problems_with_table(fitted: FittedLaw) -> Iterator[Problem]:
    """Why a law is no table of overlap and force."""
    if law_of(fitted.law).in_time:
        yield Problem("law", fitted.name, "depends on time: no table holds all its paths", "tabulate one by contactlaws.path.scan")


def write_table(fitted: FittedLaw, path: Path) -> Path:
    """The law as CSV, in the layout of a curve, so that `fe2dem fit` reads it too; raises `InputError` before writing."""
    require(problems_with_table(fitted))
    return write_text(path, "\n".join([*_head(fitted, "# "), *_rows(fitted)]) + "\n")


def _head(fitted: FittedLaw, mark: str) -> Iterator[str]:
    law = fitted.law
    yield f"{mark}law {fitted.name}: {fitted.source}"
    yield f"{mark}written by {code_version()}, from a law made by {fitted.code_version}"
    yield f"{mark}made from curves: {' '.join(fitted.curve_hashes) or 'none'}"
    constants = {name: np.asarray(value).tolist() for name, value in zip(law._fields, law, strict=True)}
    yield f"{mark}its constants, SI: {json.dumps(constants)}"
    yield f"{mark}good up to an overlap of {fitted.max_overlap!r} m of one body, {fitted.max_overlap / law.radius:.4g} of its radius"


def _rows(fitted: FittedLaw) -> Iterator[str]:
    law, material = fitted.law, fitted.material
    yield "# one body on a rigid flat: `overlap` is half the approach of two equal spheres; forces of the pair are the same, energies twice"
    yield "# units: m, N, m, J, J; branch 0 is the loading, k the k-th unloading from the first row of its branch"
    yield f"# another radius: lengths go with it, forces with its square, energies with its cube\n# radius: {law.radius!r}"
    if material is not None:
        yield f"# material: {json.dumps({name: value for name, value in material._asdict().items() if value is not None})}"
    yield "branch,overlap,force,contact_radius,stored_energy,dissipated_energy"
    for number, overlap in enumerate(_paths(fitted)):
        found = scan(law, overlap if number == 0 else np.concatenate([[overlap[0]], overlap]))
        columns = (overlap, *(column[-overlap.size :] for column in found[:4]))
        yield from (f"{number},{','.join(map(repr, row))}" for row in zip(*(column.tolist() for column in columns), strict=True))


def _paths(fitted: FittedLaw) -> Iterator[np.ndarray]:
    """Overlaps in m of the loading, denser where it begins, and of the unloadings, down to the first without force."""
    yield fitted.max_overlap * np.linspace(0.0, 1.0, ROWS) ** 2
    for peak in PEAKS:
        down = peak * fitted.max_overlap * np.linspace(1.0, 0.0, ROWS)
        pushing = np.flatnonzero(trace(fitted.law, np.concatenate([down[:1], down])).force[1:] > 0.0)
        yield down[: pushing[-1] + 2]


def write_lammps(fitted: FittedLaw, curves: Sequence[Curve], path: Path, lmp: str | None = None) -> Exported:
    """Fit the nearest law of LAMMPS's own to `curves`, or to the law itself if there are none, replay it, and write it to be included.

    An elastic law that is not Hertz's is written as a table beside `path`, which takes the place of the nearest. Raises `InputError`,
    before anything is computed, for a law that LAMMPS has nothing like.
    """
    mimicked = branches_of(fitted.law, fitted.max_overlap)
    branches = tuple(branch for curve in curves for branch in branches_of_curve(curve)) or mimicked
    native = nearest(fitted, branches)
    programs = installed(lmp)
    file, styles = None, native.styles
    if not is_plastic(fitted.law, fitted.max_overlap) and misfit(native.record, mimicked).mean > NOT_HERTZ:
        file = write_text(path.with_suffix(".table"), lammps_table.table(fitted))
        styles = lammps_table.styles(file.resolve())
    exported = Exported(
        native,
        misfit(native.record, branches),
        misfit(fitted.law, branches) if curves else None,
        None if programs is None else _replayed(programs, fitted, native._replace(styles=styles)),
        file,
    )
    active = native.styles if file is None else lammps_table.styles(Path(file.name))
    write_text(path, "\n".join([*_head(fitted, "# "), *_limits(fitted, exported), active.pair]) + "\n")
    return exported


def _replayed(programs: Programs, fitted: FittedLaw, native: Native) -> tuple[Misfit, Misfit]:
    """How far LAMMPS is from the fitted law, loaded to each of `PEAKS` and unloaded: in a row, and as a pair alone."""
    steps, peaks = steps_for(native.material), [peak * fitted.max_overlap for peak in PEAKS]

    def found(arrangement: int) -> Misfit:
        paths = [replay(programs, native.styles, fitted.law.radius, peak, arrangement, steps) for peak in peaks]
        return misfit(fitted.law, [Branch(path.overlap, path.force, None) for path in paths])

    try:
        return found(ROW), found(PAIR)
    except RuntimeError as error:
        last = str(error).strip().splitlines()[-2:]
        refusal = f"LAMMPS does not run its nearest law, {native.styles.name}: {' '.join(last)}"
        raise InputError(Problem("law", fitted.name, refusal, "take --to csv, or a law of a smaller range")) from error


def _limits(fitted: FittedLaw, exported: Exported) -> Iterator[str]:
    """What a reader must know before including the file."""
    native = exported.native
    if exported.table is None:
        yield f"# what follows is not this law but the nearest of LAMMPS's own, `{native.styles.name}`, and it does without compiling"
    else:
        yield f"# what follows is this law as a table, `{exported.table.name}`, which must lie in the folder that LAMMPS is run in."
        yield f"# It is for spheres of radius {fitted.law.radius!r} m alone, and LAMMPS stops where two come closer than it goes."
        yield f"# For other radii take the nearest of LAMMPS's own, `{native.styles.name}`, with the constants below"
    yield from (f"# {line}" for line in words(exported))
    yield "# units si, atom_style sphere; include after read_data or create_atoms, before run"
    if exported.table is not None:
        yield "# no friction, adhesion or damping"
        return
    if native.material.yield_stress is not None:
        yield "# needs `newton off` before the box is made, and:\ncomm_modify mode single vel yes"
        yield "# mdr lets a sphere grow by what all its contacts displace, and stiffens where less than half of its surface is free"
        yield "# (.5 below); its force is summed up by increments, so it depends on the time step"
    yield "# no friction, adhesion or damping: add them to the line of pair_coeff"


def words(exported: Exported) -> Iterator[str]:
    """The errors as sentences."""
    if exported.table is not None:
        yield f"the law itself, of equal spheres of its radius: {exported.table.name}"
    material = exported.native.material
    constants = f"E = {material.youngs_modulus:.6g} Pa, nu = {material.poissons_ratio:g}"
    if material.yield_stress is not None:
        constants += f", Y = {material.yield_stress:.6g} Pa"
    whose = "the fit" if exported.table is None else "the nearest law"
    yield f"constants of {whose}, not of the material: {constants}"
    matched = "the law" if exported.ours is None else "the curves"
    nearest_law = "it" if exported.table is None else f"the nearest law, `{exported.native.styles.name}`,"
    yield f"{nearest_law} differs from {matched}, loading and unloadings, by {_percent(exported.theirs)} of the largest force"
    if exported.ours is not None:
        yield f"the fitted law itself differs from the curves by {_percent(exported.ours)}"
    if exported.replayed is None:
        yield "not replayed: LAMMPS is not installed here (pip install lammps mpich)"
        return
    for found, what in zip(exported.replayed, ("spheres pressed from both sides, in a row", "two spheres alone"), strict=True):
        yield f"replayed in LAMMPS, {what}: {_percent(found)} from the law, over whole cycles"


def _percent(found: Misfit) -> str:
    return f"{100.0 * found.mean:.2g} % (root mean square; at worst {100.0 * found.worst:.2g} %)"
