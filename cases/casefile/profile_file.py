"""The meridian of a body of revolution as a CSV file: the header `r,z`, one point a row, in metres, from the pole to the mid-plane."""

from __future__ import annotations

import csv
from pathlib import Path

from contactlaws.errors import InputError, Problem
from contactlaws.files import read_text

HEADER = ["r", "z"]


def read_profile(path: Path) -> tuple[list[tuple[float, float]], list[Problem]]:
    """The points of a profile, and what is wrong with the file or with the shape."""
    try:
        lines = [line for line in read_text(path).splitlines() if line.strip() and not line.startswith("#")]
    except InputError as error:
        return [], list(error.problems)
    header = [name.strip() for name in lines[0].split(",")] if lines else []
    if header != HEADER:
        remedy = "write the line 'r,z' and below it one point a row, in metres, the pole first"
        return [], [Problem(f"{path}: header", ",".join(header), "must be r,z", remedy)]
    points: list[tuple[float, float]] = []
    problems: list[Problem] = []
    for number, row in enumerate(csv.reader(lines[1:]), 1):
        try:
            r, z = map(float, row)
        except ValueError:
            problems.append(Problem(f"{path}: point {number}", ",".join(row), "must be two numbers", "give r,z in metres"))
        else:
            points.append((r, z))
    return points, problems or _shape_problems(points, path)


def _shape_problems(points: list[tuple[float, float]], path: Path) -> list[Problem]:
    from fem.profile import meridian

    try:
        meridian(points)
    except InputError as error:
        return [problem._replace(name=f"{path}: {problem.name}") for problem in error.problems]
    return []
