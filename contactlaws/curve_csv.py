"""The CSV form of a curve: a block of `# key: value` lines, a header, one row per state in path order."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contactlaws.csv_rows import cells as cells_of
from contactlaws.curve import Curve, branches_in_time
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text, write_text
from contactlaws.json_input import parsed

HEADER = ("branch", "time", "overlap", "force", "contact_radius")
#: columns that may stand in a file; overlap and force must
KNOWN = Curve.COLUMNS
FACTS = ("radius", "aspect", "material", "yield_overlap", "yield_place", "errors", "in_time", "series", "stopped", "provenance")


def write(curve: Curve, facts: Mapping[str, Any], path: str | Path) -> Path:
    """Write header, facts as JSON in comments, and rows with as many digits as a float has; a contact radius that is not known stays
    empty.
    """
    lines = ["# format: fe2dem curve", "# units: SI (s, m, N); branch 0 is the loading, k the k-th unloading"]
    lines += [f"# {name}: {json.dumps(value, allow_nan=False)}" for name, value in facts.items() if value not in (None, {}, False)]
    lines.append(",".join(HEADER))
    radius = [""] * curve.overlap.size if curve.contact_radius is None else map(repr, curve.contact_radius.tolist())
    rows = zip(curve.branch.tolist(), curve.time.tolist(), curve.overlap.tolist(), curve.force.tolist(), radius, strict=True)
    lines += [f"{branch},{time!r},{overlap!r},{force!r},{a}" for branch, time, overlap, force, a in rows]
    return write_text(path, "\n".join(lines) + "\n")


def read(path: str | Path, in_time: bool = False) -> tuple[dict[str, Any], dict[str, Any]]:
    """Columns and facts of a CSV file.

    `# key: value` lines whose key is one of `FACTS` are facts; other comment lines are passed over. Without a branch column the largest
    overlap is where the loading ends and the one unloading begins. A path in time (which a file says, or `in_time`) is cut at its turns.
    """
    lines = read_text(path).splitlines()
    facts = _facts(path, lines)
    if in_time:
        facts["in_time"] = True
    body = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not body:
        raise InputError(Problem(str(path), "no rows", "a curve file needs a header and rows", "check that the right file was given"))
    header = [name.strip() for name in cells_of(path, *body[0])]
    require(_problems_with_header(path, header))
    columns = _columns(path, header, body[1:])
    rows = [number for number, _ in body[1:]]
    if facts.get("in_time"):
        require(_problems_with_time(path, columns, rows))
        columns.setdefault("branch", branches_in_time(columns["overlap"]))
        columns["branch"] = columns["branch"].astype(np.int64)
    elif "branch" in columns:
        require(_problems_with_order(path, columns, rows))
        columns["branch"] = columns["branch"].astype(np.int64)
    else:
        columns = _with_branches(path, columns, rows)
    columns.setdefault("time", np.arange(columns["overlap"].size, dtype=np.float64))
    return columns, facts


def _facts(path: str | Path, lines: list[str]) -> dict[str, Any]:
    facts: dict[str, Any] = {}
    for number, line in enumerate(lines, 1):
        key, colon, value = line.lstrip().removeprefix("#").partition(":")
        if not (line.lstrip().startswith("#") and colon and key.strip() in FACTS):
            continue
        try:
            facts[key.strip()] = parsed(value)
        except ValueError as error:
            remedy = "give numbers in SI units, others as JSON"
            raise InputError(Problem(f"{path} line {number}: {key.strip()}", value.strip(), "cannot be understood", remedy)) from error
    return facts


def _problems_with_header(path: str | Path, header: list[str]) -> Iterator[Problem]:
    for name in ("overlap", "force"):
        if name not in header:
            yield Problem(
                f"{path}: column {name}",
                None,
                f"the header is {','.join(header)!r}",
                "name the columns at least 'overlap,force', in m and N",
            )
    for name in header:
        if name not in KNOWN or header.count(name) > 1:
            yield Problem(f"{path}: column", name, f"each of {', '.join(KNOWN)} may stand there once", "rename or remove the column")


def _columns(path: str | Path, header: list[str], body: list[tuple[int, str]]) -> dict[str, Any]:
    problems: list[Problem] = []
    values: list[list[float]] = []
    for number, line in body:
        cells = cells_of(path, number, line)
        if len(cells) != len(header):
            problems.append(
                Problem(f"{path} line {number}", ",".join(cells), f"must have {len(header)} values", "complete or remove the line")
            )
            continue
        values.append([_number(path, number, name, cell, problems) for name, cell in zip(header, cells, strict=True)])
    if not problems and len(values) < 3:
        problems.append(Problem(str(path), f"{len(values)} rows", "a curve needs at least 3", "measure or compute more states"))
    require(problems[:10])
    table = np.array(values)
    columns = {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(header)}
    for name in [name for name in header if np.isnan(columns[name]).any()]:
        row = int(np.flatnonzero(np.isnan(columns[name]))[0])
        if name in ("overlap", "force", "branch", "time") or not np.isnan(columns[name]).all():
            raise InputError(Problem(f"{path} line {body[row][0]}: {name}", None, "has no value", "fill in or remove the line"))
        del columns[name]
    return columns


def _number(path: str | Path, line: int, name: str, cell: str, problems: list[Problem]) -> float:
    """The number in a cell; NaN for an empty cell; anything else is a problem."""
    if not cell.strip():
        return float("nan")
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value) or (name == "branch" and value != int(value)):
        problems.append(Problem(f"{path} line {line}: {name}", cell.strip(), "must be a finite number", "repair or remove the line"))
    return value


def _problems_with_order(path: str | Path, columns: Mapping[str, Any], lines: list[int]) -> Iterator[Problem]:
    branch, overlap = columns["branch"], columns["overlap"]
    for row in np.flatnonzero(~np.isin(np.diff(branch, prepend=branch[:1]), (0, 1)) | (np.arange(branch.size) == 0) & (branch != 0))[:3]:
        yield Problem(
            f"{path} line {lines[row]}: branch",
            branch[row],
            "must start at 0 and go up by 0 or 1",
            "keep the rows in the order of the path",
        )
    same = np.diff(branch) == 0
    step = np.diff(overlap)
    for row in np.flatnonzero(same & (branch[1:] == 0) & (step <= 0))[:3] + 1:
        yield Problem(
            f"{path} line {lines[row]}: overlap", overlap[row], "must increase along the loading", "keep the rows in the order of the path"
        )
    for row in np.flatnonzero(same & (branch[1:] > 0) & (step >= 0))[:3] + 1:
        yield Problem(
            f"{path} line {lines[row]}: overlap", overlap[row], "must decrease along an unloading", "keep the rows in the order of the path"
        )


def _problems_with_time(path: str | Path, columns: Mapping[str, Any], lines: list[int]) -> Iterator[Problem]:
    if "time" not in columns:
        yield Problem(f"{path}: column time", None, "is needed where the force depends on it", "add the time of each row, in s")
        return
    for row in np.flatnonzero(np.diff(columns["time"]) < 0.0)[:3] + 1:
        bound = f"must not fall below {columns['time'][row - 1]:g} s"
        yield Problem(f"{path} line {lines[row]}: time", columns["time"][row], bound, "keep the rows in their order in time")


def _with_branches(path: str | Path, columns: Mapping[str, Any], lines: list[int]) -> dict[str, Any]:
    """One loading up to the largest overlap and, if rows follow, one unloading that starts from it (its row then stands in both)."""
    overlap = columns["overlap"]
    turn = int(np.argmax(overlap))
    wrong = np.flatnonzero((np.diff(overlap) <= 0) != (np.arange(overlap.size - 1) >= turn))
    if wrong.size:
        row = int(wrong[0]) + 1
        bound = f"must rise to the largest overlap (line {lines[turn]}) and fall from there"
        raise InputError(Problem(f"{path} line {lines[row]}: overlap", overlap[row], bound, "order the rows, or add a branch column"))
    rows = np.arange(overlap.size)
    branch = np.zeros(overlap.size, dtype=np.int64)
    if turn < overlap.size - 1:
        rows = np.concatenate((rows[: turn + 1], rows[turn:]))
        branch = (np.arange(rows.size) > turn).astype(np.int64)
    return {**{name: values[rows] for name, values in columns.items()}, "branch": branch}
