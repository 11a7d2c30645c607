"""A list of materials as a CSV file: one material a row, the columns named like the keys of [materials.NAME], and perhaps `name`.

A column may carry its unit in the header, `youngs_modulus [GPa]`, or in every cell, `142 GPa`; without any, it is in SI units.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.casefile.grid import Raw
from cases.casefile.units import is_bare
from cases.casefile.validation import suggestion
from contactlaws.errors import InputError, Problem
from contactlaws.files import read_text

NAME = "name"


def read_materials(path: Path, columns: Sequence[str], common: Mapping[str, Any], place: str) -> tuple[list[Raw], list[Problem]]:
    """A grid of one point for each row; `common` holds what the table in the case file says for all of them.

    A row's `name`, if the file has that column, stands under the key "name". `place` is what problems are called by.
    """
    try:
        lines = [(number, line) for number, line in enumerate(read_text(path).splitlines(), 1) if line.strip() and line[0] != "#"]
    except InputError as error:
        return [], [problem._replace(name=f"{place}file: {problem.name}") for problem in error.problems]
    if len(lines) < 2:
        return [], [Problem(f"{place}file", str(path), "lists no material", "give a header line and one row for each material")]
    header = [_split(cell) for cell in next(csv.reader([lines[0][1]]))]
    problems = list(_header_problems(header, columns, common, f"{path} line {lines[0][0]}"))
    rows = []
    for number, line in lines[1:]:
        cells = [cell.strip() for cell in next(csv.reader([line]))]
        if len(cells) != len(header):
            bound = f"has {len(cells)} cells where the header has {len(header)}"
            problems.append(Problem(f"{path} line {number}", line, bound, "give one cell for each column; an empty one is left out"))
        else:
            rows.append((number, cells))
    for index, (name, unit) in enumerate(header):
        problems += _unit_problems(f"{path}: {name}", unit, [cells[index] for _, cells in rows])
    if problems:
        return [], problems
    return [Raw(f"{path} line {number}: ", {**common, **dict(_values(header, cells))}) for number, cells in rows], []


def _split(cell: str) -> tuple[str, str]:
    """Name and unit of a header cell.

    >>> _split("youngs_modulus [GPa]"), _split(" name")
    (('youngs_modulus', 'GPa'), ('name', ''))
    """
    name, unit = re.fullmatch(r"\s*([^\[(]*?)\s*(?:[\[(](.*)[\])])?\s*", cell).groups()  # type: ignore[union-attr]
    return name, (unit or "").strip()


def _header_problems(header: Sequence[tuple[str, str]], columns: Sequence[str], common: Mapping[str, Any], place: str) -> Iterator[Problem]:
    names = [name for name, _ in header]
    for name in names:
        if name not in (*columns, NAME):
            yield Problem(f"{place}: header", name, "is not a known column", suggestion(name, (*columns, NAME)))
        elif name in common:
            yield Problem(f"{place}: header", name, "stands in the case file too", "give it in one of the two places")
    for name in {name for name in names if names.count(name) > 1}:
        yield Problem(f"{place}: header", name, "stands there twice", "remove one of the columns")


def _unit_problems(name: str, unit: str, cells: Sequence[str]) -> Iterator[Problem]:
    """A column has one unit: in its header, or in every cell, or nowhere."""
    own = [cell for cell in cells if cell and not is_bare(cell)]
    bare = [cell for cell in cells if cell and is_bare(cell)]
    if name.endswith(f": {NAME}"):
        return
    if unit and own:
        yield Problem(name, own[0], f"carries a unit, and so does the header ({unit})", "write the unit in one of the two places")
    elif own and bare:
        remedy = "write all of them with a unit, or all of them bare, or the unit in the header"
        yield Problem(name, f"{own[0]!r} and {bare[0]!r}", "mixes numbers with and without a unit in one column", remedy)


def _values(header: Sequence[tuple[str, str]], cells: Sequence[str]) -> Iterator[tuple[str, Any]]:
    for (name, unit), cell in zip(header, cells, strict=True):
        if cell and name == NAME:
            yield name, cell
        elif cell:
            yield name, float(cell) if is_bare(cell) and not unit else f"{cell} {unit}".strip()
