"""A programme in time as a CSV file: columns time, overlap, force (s, m, N), one knot a row, the overlap or the force left empty."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import TYPE_CHECKING

from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text

if TYPE_CHECKING:
    from fem.programme import Programme

COLUMNS = ("time", "overlap", "force")


def read_programme(path: Path) -> Programme:
    """The knots of a file, the start (time 0, overlap 0) put in front where it is missing. Raises `InputError` naming line and value.

    Between knots the overlap, or the force, goes straight. What does not make a programme is said by `fem.programme`.
    """
    from fem.programme import START, Knot

    lines = [(n, line) for n, line in enumerate(read_text(path).splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")]
    header = [name.strip() for name in lines[0][1].split(",")] if lines else []
    if "time" not in header or not set(header) <= set(COLUMNS) or len(header) < 2 or len(set(header)) != len(header):
        remedy = "write the line 'time,overlap' or 'time,overlap,force', in s, m and N"
        raise InputError(Problem(f"{path}: header", ",".join(header), f"must name time and of {', '.join(COLUMNS)} no other", remedy))
    problems: list[Problem] = []
    knots = []
    for number, line in lines[1:]:
        cells = next(csv.reader([line]))
        if len(cells) != len(header):
            problems.append(Problem(f"{path} line {number}", line, f"must have {len(header)} values", "complete or remove the line"))
            continue
        values = {name: _number(path, number, name, cell, problems) for name, cell in zip(header, cells, strict=True)}
        if values.get("time") is None:
            problems.append(Problem(f"{path} line {number}: time", None, "has no value", "fill it in, in s"))
            continue
        knots.append(Knot(values["time"], values.get("overlap"), values.get("force")))  # type: ignore[arg-type]
    require(problems[:10])
    return (*(() if knots and knots[0].time == 0.0 else (START,)), *knots)


def _number(path: Path, line: int, name: str, cell: str, problems: list[Problem]) -> float | None:
    if not cell.strip():
        return None
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        problems.append(Problem(f"{path} line {line}: {name}", cell.strip(), "must be a finite number", "repair or remove the line"))
        return 0.0
    return value
