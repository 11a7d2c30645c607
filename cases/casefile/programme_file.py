"""A programme in time as a CSV file: columns time, overlap, force (s, m, N), one knot a row, the overlap or the force left empty."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from contactlaws.csv_rows import finite
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text

if TYPE_CHECKING:
    from fem.programme import Knot, Programme

COLUMNS = ("time", "overlap", "force")
#: of more problems in one file only these are said
MOST_PROBLEMS = 10


class ProgrammeFile(NamedTuple):
    """What stands in a file."""

    knots: Programme
    lines: tuple[int, ...]  # of the file, from 1, for each knot; 0 for a start that does not stand there
    path: Path

    def placed(self, problem: Problem) -> Problem:
        """A problem of the programme, named by file and line."""
        knot = re.match(r"programme\[(\d+)\]", problem.name)
        line = self.lines[int(knot[1]) - 1] if knot else 0
        rest = problem.name[knot.end() if knot else len("programme") :]
        return problem._replace(name=f"{self.path}{f' line {line}' if line else ''}{rest}")


def read_programme(path: Path) -> ProgrammeFile:
    """The knots of a file, the start (time 0, overlap 0) put in front where it is missing. Raises `InputError` naming line and value.

    Between knots the overlap, or the force, goes straight. What does not make a programme is said by `fem.programme`.
    """
    from fem.programme import START

    body = [(n, line) for n, line in enumerate(read_text(path).splitlines(), 1) if line.strip() and not line.lstrip().startswith("#")]
    header = [name.strip() for name in body[0][1].split(",")] if body else []
    if "time" not in header or not set(header) <= set(COLUMNS) or len(header) < 2 or len(set(header)) != len(header):
        remedy = "write the line 'time,overlap' or 'time,overlap,force', in s, m and N"
        bound = f"must name time and, of {', '.join(COLUMNS[1:])}, at least one"
        raise InputError(Problem(f"{path}: header", ",".join(header) or None, bound, remedy))
    problems: list[Problem] = []
    found = [(_knot(f"{path} line {number}", header, line, problems), number) for number, line in body[1:]]
    require(problems[:MOST_PROBLEMS])
    knots = [(knot, number) for knot, number in found if knot is not None]
    if not knots or knots[0][0].time != 0.0:
        knots.insert(0, (START, 0))
    return ProgrammeFile(tuple(knot for knot, _ in knots), tuple(number for _, number in knots), path)


def _knot(place: str, header: list[str], line: str, problems: list[Problem]) -> Knot | None:
    """The knot of one line; what is wrong with it is added to `problems`."""
    from fem.programme import Knot

    try:
        cells = next(csv.reader([line], strict=True))
    except csv.Error as error:
        bound = f"is no line of a CSV file ({error})"
        problems.append(Problem(place, line.strip()[:80], bound, "remove the stray quotation mark"))
        return None
    if len(cells) != len(header):
        problems.append(Problem(place, line, f"must have {len(header)} values", "complete or remove the line"))
        return None
    values = {name: finite(cell) for name, cell in zip(header, cells, strict=True)}
    wrong = [
        Problem(f"{place}: {name}", cell.strip() or None, "must be a finite number", "repair or remove the line")
        for name, cell in zip(header, cells, strict=True)
        if values[name] is None and (cell.strip() or name == "time")
    ]
    problems += wrong
    time = values["time"]
    return None if wrong or time is None else Knot(time, values.get("overlap"), values.get("force"))
