"""Packings from files: LAMMPS data and dump text, CSV, and (extended) XYZ; and to LAMMPS data."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from contactlaws.csv_rows import MOST_PROBLEMS, finite, read_rows
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text, write_text
from dem.box import Box
from dem.packing import Packing, volume_of
from dem.packing_cells import worst_overlap

FloatArray = npt.NDArray[np.float64]

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9}
#: m; beyond, volumes are no longer numbers
SMALLEST, LARGEST = 1e-30, 1e30
#: lengths in radii of the largest sphere; beyond, round-off is larger than overlaps
WIDEST = 1e9
#: names of the columns for a radius, with what makes a radius of the number
SIZES = {"radius": 1.0, "diameter": 0.5}


class _Frame(NamedTuple):
    """What a file says, in its own unit."""

    columns: dict[str, list[float]]  # x, y, z or the like, radius or diameter, id
    lines: Sequence[int]  # of each row, in the file
    low: tuple[float, ...]  # corner of the box
    lengths: tuple[float, ...] | None  # None: the file has no box
    periodic: tuple[bool, ...] = (True, True, True)
    unit: str | None = None  # None: the file doesn't say


def read_packing(
    path: str | Path, radius: float | None = None, box: Box | None = None, unit: str | None = None, frame: int = -1
) -> Packing:
    """The spheres in a file, of whichever of these kinds its content shows it to be, with their worst overlap as measured.

    LAMMPS data: atom_style sphere (id type diameter density x y z); it says nothing of open axes: all are periodic. LAMMPS dump text:
    columns x y z, xu yu zu, xs ys zs or xsu ysu zsu, and radius or diameter; axes that aren't pp are open. XYZ: species, x, y, z and
    maybe a radius, or as `Properties` says, with Lattice="..." and pbc="T T F". CSV: a header with x, y, z and radius or diameter; above
    it, `# box: 10 10 20`, `# periodic: 1 1 0` and `# unit: um` where they apply. Spheres are ordered by id where there is one.

    radius: m, for files without one. box: replaces the file's own; its corner stays where the file's is, at 0 if it has none. unit: of
    lengths in the file, m unless the file says otherwise. frame: which, of a dump or XYZ file; -1 is the last. Raises `InputError`, naming
    the line, for what cannot be used: a file that is cut off, numbers that are none, a box that is tilted, centres outside an open axis.
    """
    text = read_text(path)
    lines = text.splitlines()
    if text.startswith("ITEM:"):
        found = _dump(path, lines, frame)
    elif any(re.match(r"\s*\d+\s+atoms\s*(#|$)", line) for line in lines[:100]):
        found = _data(path, lines)
    elif lines and re.fullmatch(r"\s*\d+\s*", lines[0]):
        found = _xyz(path, lines, frame)
    else:
        found = _csv(path)
    return _packing(path, found, radius, box, unit)


def write_packing(packing: Packing, path: str | Path, density: float) -> Path:
    """A LAMMPS data file (atom_style sphere, units si) that `read_packing` reads back to the last digit; density in kg/m3.

    A data file does not say which axes are open. Raises `InputError` if it cannot be written there.
    """
    radii = np.broadcast_to(packing.radius, (len(packing.position),)).tolist()
    bounds = "".join(f"0.0 {length!r} {axis}lo {axis}hi\n" for axis, length in zip("xyz", packing.box.lengths, strict=True))
    rows = zip(radii, packing.position.tolist(), strict=True)
    atoms = "".join(f"{i} 1 {2.0 * r!r} {float(density)!r} {x!r} {y!r} {z!r}\n" for i, (r, (x, y, z)) in enumerate(rows, 1))
    return write_text(path, f"spheres, units si\n\n{len(radii)} atoms\n1 atom types\n\n{bounds}\nAtoms # sphere\n\n{atoms}")


def _packing(path: str | Path, found: _Frame, radius: float | None, box: Box | None, unit: str | None) -> Packing:
    """In m, from the corner of the box, checked."""
    unit = unit or found.unit or "m"
    if unit not in UNITS:
        _refuse(path, None, "unit", unit, f"must be one of {', '.join(UNITS)}", "convert the file")
    metre, number = UNITS[unit], len(found.lines)
    if number == 0:
        _refuse(path, None, "spheres", 0, "there must be some", "give the right file")
    size = next((name for name in SIZES if name in found.columns), None)
    if size is None and radius is None:
        _refuse(path, None, "radius", None, "the file has no column for it", "add one, or give the radius of all spheres")
    if box is None and found.lengths is None:
        _refuse(path, None, "box", None, "the file doesn't give one", "add it to the file, or give it")
    radii = np.full(number, radius, dtype=float) if size is None else np.array(found.columns[size]) * SIZES[size] * metre
    if box is None:
        (x, y, z), (along_x, along_y, along_z) = (length * metre for length in found.lengths or ()), found.periodic
        box = Box((x, y, z), (along_x, along_y, along_z))
    position = (np.stack([found.columns[axis] for axis in "xyz"], axis=1) - found.low) * metre
    require(_problems_with_lengths(path, box))
    require(list(_problems_with_radii(path, found, radii))[:MOST_PROBLEMS])
    require(list(_problems_with_rows(path, found, position, radii, box))[:MOST_PROBLEMS])
    if "id" in found.columns:
        order = np.argsort(found.columns["id"], kind="stable")
        position, radii = position[order], radii[order]
    one = float(radii[0]) if np.ptp(radii) == 0.0 else radii
    return Packing(position, one, box, volume_of(radii) / box.volume, worst_overlap(position, radii, box))


def _problems_with_radii(path: str | Path, found: _Frame, radii: FloatArray) -> Iterator[Problem]:
    bound = f"must lie in [{SMALLEST:g}, {LARGEST:g}] m"
    for k in np.flatnonzero(~((radii >= SMALLEST) & (radii <= LARGEST))):
        yield _problem(path, found.lines[int(k)], "radius", float(radii[k]), bound, "repair or remove it")


def _problems_with_rows(path: str | Path, found: _Frame, position: FloatArray, radii: FloatArray, box: Box) -> Iterator[Problem]:
    for k in np.flatnonzero(~((radii >= SMALLEST) & (radii <= LARGEST))):
        yield _problem(
            path, found.lines[int(k)], "radius", float(radii[k]), f"must lie in [{SMALLEST:g}, {LARGEST:g}] m", "repair or remove it"
        )
    for k, axis in np.argwhere(~(np.abs(position) <= WIDEST * radii.max())):
        bound = f"must be within {WIDEST:g} radii of the box"
        yield _problem(path, found.lines[int(k)], "xyz"[axis], float(position[k, axis]), bound, "repair or remove it")
    for axis, length in enumerate(box.lengths):
        if length > WIDEST * radii.max():
            yield _problem(path, None, f"box length {'xyz'[axis]}", length, f"must be at most {WIDEST:g} radii", "correct the unit")
        if not box.periodic[axis]:
            for k in np.flatnonzero((position[:, axis] < 0.0) | (position[:, axis] > length)):
                bound = f"must lie within the open axis, from 0 to {length:g} m"
                yield _problem(path, found.lines[int(k)], "xyz"[axis], float(position[k, axis]), bound, "remove it, or give a larger box")
    if "id" in found.columns:
        _, first, times = np.unique(found.columns["id"], return_index=True, return_counts=True)
        for k in first[times > 1]:
            yield _problem(path, found.lines[int(k)], "id", found.columns["id"][k], "stands there twice", "remove one of the two spheres")


def _problems_with_lengths(path: str | Path, box: Box) -> Iterator[Problem]:
    for axis, length in zip("xyz", box.lengths, strict=True):
        if not SMALLEST <= length <= LARGEST:
            yield _problem(path, None, f"box length {axis}", length, f"must lie in [{SMALLEST:g}, {LARGEST:g}] m", "repair the bounds")


def _csv(path: str | Path) -> _Frame:
    rows = read_rows(path, ("x", "y", "z", *SIZES), ("box", "periodic", "unit"))
    for axis in "xyz":
        if axis not in rows.columns:
            _refuse(path, None, f"column {axis}", None, "the columns must include x, y and z", "add it")
    lengths = _numbers(path, None, "box", rows.facts["box"].split(), 3) if "box" in rows.facts else None
    periodic = _numbers(path, None, "periodic", rows.facts.get("periodic", "1 1 1").split(), 3)
    return _Frame(rows.columns, rows.lines, (0.0, 0.0, 0.0), lengths, tuple(value != 0.0 for value in periodic), rows.facts.get("unit"))


def _data(path: str | Path, lines: list[str]) -> _Frame:
    bare = [line.split("#")[0].split() for line in lines]
    start = next((k for k, words in enumerate(bare) if words[:1] == ["Atoms"]), None)
    if start is None:
        _refuse(path, None, "Atoms", None, "the file has no such section", "write it with write_data")
    style = lines[start].partition("#")[2].strip() or "sphere"
    if style != "sphere":
        _refuse(path, start + 1, "atom style", style, "must be sphere, which has diameters", "write the file with atom_style sphere")
    header = {" ".join(word for word in words if finite(word) is None): (k + 1, words) for k, words in enumerate(bare[1:start], 1) if words}
    bounds = []
    for axis in "xyz":
        line, words = header.get(f"{axis}lo {axis}hi", (None, []))
        bounds.append(_numbers(path, line, f"{axis}lo {axis}hi", words[:2], 2))
    line, words = header.get("xy xz yz", (None, []))
    if any(_numbers(path, line, "xy xz yz", words[:3], 3)) if words else False:
        _refuse(path, line, "tilt", " ".join(words[:3]), "boxes must be cuboids", "write the packing in a box without tilt")
    line, words = header.get("atoms", (None, []))
    number, first = _count(path, line, words[:1]), start + 1
    while first < len(bare) and not bare[first]:
        first += 1
    names = ["id", "type", "diameter", "density", "x", "y", "z"]
    columns = _table(path, bare[first : first + number], first + 1, number, names, ("id", "diameter", "x", "y", "z"))
    return _Frame(columns, range(first + 1, first + number + 1), tuple(b[0] for b in bounds), tuple(b[1] - b[0] for b in bounds))


def _dump(path: str | Path, lines: list[str], frame: int) -> _Frame:
    starts = [k for k, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP")]
    begin = _chosen(path, starts, frame)
    needed, items = ("NUMBER OF ATOMS", "BOX BOUNDS", "ATOMS"), dict[str, int]()
    for k in range(begin, len(lines)):
        if lines[k].startswith("ITEM:"):
            items.setdefault(next((name for name in needed if lines[k].startswith(f"ITEM: {name}")), ""), k)
            if lines[k].startswith("ITEM: ATOMS"):
                break
    for name in needed:
        if name not in items:
            _refuse(path, begin + 1, f"ITEM: {name}", None, "the frame has no such line", "the file may be cut off: give a whole one")
    at = items["BOX BOUNDS"]
    faces = lines[at].split()[3:]
    if any(word not in ("pp", "ff", "fs", "fm", "sf", "ss", "sm", "mf", "ms", "mm") for word in faces) or len(faces) not in (0, 3):
        _refuse(path, at + 1, "BOX BOUNDS", " ".join(faces), "boxes must be cuboids", "write the packing in a box without tilt")
    bounds = [_numbers(path, k + 1, "bounds", (lines[k].split() if k < len(lines) else []), 2) for k in range(at + 1, at + 4)]
    at = items["NUMBER OF ATOMS"] + 1
    number, names, first = _count(path, at + 1, lines[at].split()), lines[items["ATOMS"]].split()[2:], items["ATOMS"] + 1
    kind = next((kind for kind in ("", "u", "s", "su") if all(axis + kind in names for axis in "xyz")), None)
    if kind is None:
        _refuse(path, first, "columns", " ".join(names), "must include x y z, xu yu zu, xs ys zs or xsu ysu zsu", "dump them")
    wanted = [*(axis + kind for axis in "xyz"), *(name for name in ("id", *SIZES) if name in names)]
    columns = _table(path, [line.split() for line in lines[first : first + number]], first + 1, number, names, wanted)
    for axis, (low, high) in zip("xyz", bounds, strict=True):
        values = columns[axis + kind]
        columns[axis] = [low + (high - low) * value for value in values] if kind.startswith("s") else values
    periodic = tuple(face == "pp" for face in faces) or (True, True, True)
    return _Frame(columns, range(first + 1, first + number + 1), tuple(b[0] for b in bounds), tuple(b[1] - b[0] for b in bounds), periodic)


def _xyz(path: str | Path, lines: list[str], frame: int) -> _Frame:
    starts, k = [], 0
    while k < len(lines) and lines[k].strip():
        starts.append(k)
        k += _count(path, k + 1, lines[k].split()) + 2
    begin = _chosen(path, starts, frame)
    number, comment = int(lines[begin]), lines[begin + 1] if begin + 1 < len(lines) else ""
    facts = {key.lower(): quoted or bare for key, quoted, bare in re.findall(r'(\w+)=(?:"([^"]*)"|(\S+))', comment)}
    names = ["species", "x", "y", "z", "radius"]
    if "properties" in facts:
        fields = facts["properties"].split(":")
        wide = [(name.lower(), finite(width)) for name, width in zip(fields[::3], fields[2::3], strict=False)]
        names = [f"{name}{i}" if width != 1 else name for name, width in wide for i in range(int(min(max(width or 1, 1), 100)))]
        names = [{"pos0": "x", "pos1": "y", "pos2": "z"}.get(name, name) for name in names]
    elif len(lines) <= begin + 2 or len(lines[begin + 2].split()) < 5:
        names = names[:4]
    wanted = ["x", "y", "z", *(name for name in SIZES if name in names)]
    if not {"x", "y", "z"} <= set(names):
        _refuse(path, begin + 2, "Properties", facts["properties"], "must include pos:R:3", "write the positions")
    columns = _table(path, [line.split() for line in lines[begin + 2 : begin + 2 + number]], begin + 3, number, names, wanted)
    lengths = None
    if "lattice" in facts:
        cell = np.array(_numbers(path, begin + 2, "Lattice", facts["lattice"].split(), 9)).reshape(3, 3)
        if np.any(cell != np.diag(np.diag(cell))):
            _refuse(path, begin + 2, "Lattice", facts["lattice"], "boxes must be cuboids along the axes", "write the packing in such a box")
        lengths = tuple(np.diag(cell).tolist())
    low = _numbers(path, begin + 2, "Origin", facts.get("origin", "0 0 0").split(), 3)
    periodic = tuple(word.upper() in ("T", "1", "TRUE") for word in facts.get("pbc", "T T T").split())
    if len(periodic) != 3:
        _refuse(path, begin + 2, "pbc", facts["pbc"], "must say T or F for each axis", 'write pbc="T T F"')
    return _Frame(columns, range(begin + 3, begin + 3 + number), low, lengths, periodic)


def _table(
    path: str | Path, rows: list[list[str]], first: int, number: int, names: list[str], wanted: Sequence[str]
) -> dict[str, list[float]]:
    """The wanted columns of `number` rows, of which the first stands in this line."""
    if len(rows) < number:
        bound = f"the file says {number} spheres, but ends after {len(rows)}"
        _refuse(path, first + len(rows), "row", None, bound, "it is cut off: give a whole file")
    index, columns, problems = [names.index(name) for name in wanted], {name: [0.0] * number for name in wanted}, []
    for k, row in enumerate(rows):
        for name, i in zip(wanted, index, strict=True):
            value = finite(row[i]) if i < len(row) else None
            if value is None:
                problems.append(
                    _problem(path, first + k, name, row[i] if i < len(row) else None, "must be a finite number", "repair the line")
                )
            else:
                columns[name][k] = value
        if len(problems) >= MOST_PROBLEMS:
            break
    require(problems)
    return columns


def _chosen(path: str | Path, starts: list[int], frame: int) -> int:
    if not -len(starts) <= frame < len(starts):
        _refuse(path, None, "frame", frame, f"the file has {len(starts)} frames", "0 is the first, -1 the last")
    return starts[frame]


def _count(path: str | Path, line: int | None, words: list[str]) -> int:
    if len(words) != 1 or not words[0].isdecimal():
        _refuse(path, line, "number of atoms", " ".join(words) or None, "must be a whole number", "repair the line")
    return int(words[0]) if len(words[0]) < 16 else 10**16


def _numbers(path: str | Path, line: int | None, name: str, words: list[str], number: int) -> tuple[float, ...]:
    values = tuple(value for word in words if (value := finite(word)) is not None)
    if len(values) != number or len(words) != number:
        _refuse(path, line, name, " ".join(words) or None, f"must be {number} finite numbers", "repair the line")
    return values


def _problem(path: str | Path, line: int | None, name: str, value: object, bound: str, remedy: str) -> Problem:
    return Problem(f"{path}{'' if line is None else f' line {line}'}: {name}", value, bound, remedy)


def _refuse(path: str | Path, line: int | None, name: str, value: object, bound: str, remedy: str) -> NoReturn:
    raise InputError(_problem(path, line, name, value, bound, remedy))
