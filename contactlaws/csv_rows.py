"""Small CSV files of numbers that people write by hand: `# key: value` lines, a header, rows without a gap; read strictly."""

from __future__ import annotations

import csv
import math
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text

#: of more problems in one file only these are said
MOST_PROBLEMS = 10


class Rows(NamedTuple):
    """What stands in a file."""

    columns: dict[str, list[float]]  # by the names in the header, in its order; all finite
    lines: list[int]  # the line in the file, from 1, of each row
    facts: dict[str, str]  # what stands behind the colon in `# key: value`


def read_rows(path: str | Path, columns: Collection[str], facts: Collection[str]) -> Rows:
    """Read a file whose columns are some of `columns`. Comment lines whose key is one of `facts` are facts; others are passed over.

    Raises `InputError` for a file that cannot be read or has no header, an unknown or repeated column, a row with more or fewer cells than
    the header, a cell that is no finite number, and a fact that stands there twice.
    """
    numbered = list(enumerate(read_text(path).splitlines(), 1))
    comments = [(number, line) for number, line in numbered if line.lstrip().startswith("#")]
    body = [(number, line) for number, line in numbered if line.strip() and not line.lstrip().startswith("#")]
    stated = _facts(path, comments, facts)
    if not body:
        raise InputError(Problem(str(path), "no header", f"its columns must be some of {', '.join(columns)}", "give the right file"))
    header = [name.strip() for name in cells(path, *body[0])]
    require(_problems_with_header(f"{path} line {body[0][0]}: column", header, columns))
    values, problems = [], []
    for number, line in body[1:]:
        row, wrong = _row(f"{path} line {number}", header, cells(path, number, line))
        values.append(row)
        problems += wrong
    require(problems[:MOST_PROBLEMS])
    return Rows({name: [row[i] for row in values] for i, name in enumerate(header)}, [number for number, _ in body[1:]], stated)


def _facts(path: str | Path, comments: list[tuple[int, str]], names: Collection[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for number, line in comments:
        key, colon, value = line.lstrip().lstrip("#").partition(":")
        if not colon or key.strip() not in names:
            continue
        if key.strip() in found:
            raise InputError(
                Problem(f"{path} line {number}: {key.strip()}", value.strip(), "stands there twice", "remove one of the lines")
            )
        found[key.strip()] = value.strip()
    return found


def _problems_with_header(place: str, header: list[str], known: Collection[str]) -> Iterator[Problem]:
    for name in dict.fromkeys(header):
        if name not in known or header.count(name) > 1:
            yield Problem(place, name, f"each of {', '.join(known)} may stand there once", "rename or remove the column")


def cells(path: str | Path, number: int, line: str) -> list[str]:
    """The cells of one line; no cell goes on in the next line."""
    try:
        return next(csv.reader([line], strict=True))
    except csv.Error as error:
        bound = f"is no line of a CSV file ({error})"
        raise InputError(Problem(f"{path} line {number}", line.strip()[:80], bound, "remove the stray quotation mark")) from error


def _row(place: str, header: list[str], values: list[str]) -> tuple[list[float], list[Problem]]:
    if len(values) != len(header):
        return [], [Problem(place, ",".join(values), f"must have {len(header)} values", "complete or remove the line")]
    row = [finite(cell) for cell in values]
    wrong = [
        Problem(f"{place}: {name}", cell.strip() or None, "must be a finite number", "repair or remove the line")
        for name, cell, value in zip(header, values, row, strict=True)
        if value is None
    ]
    return [value for value in row if value is not None], wrong


def finite(text: str) -> float | None:
    """The number that a text says, or None.

    >>> finite(" 1e3"), finite("nan"), finite("1_000"), finite("two")
    (1000.0, None, None, None)
    """
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None
