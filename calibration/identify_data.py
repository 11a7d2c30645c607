"""A measured force-overlap curve of one particle: noisy, its zero and the machine's compliance perhaps unknown."""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text

FloatArray = npt.NDArray[np.float64]

COLUMNS = ("overlap", "force")
#: columns of a curve file that say nothing here
PASSED_OVER = ("time", "contact_radius", "raw_force", "stored_energy", "dissipated_energy")
#: a force below zero by a larger share of the largest one is no noise
NEGATIVE = 0.05
FEWEST_ROWS = 5


@dataclass(frozen=True)
class Measured:
    """Rows in the order they were taken. SI units.

    Branch 0 is the loading, branch k >= 1 an unloading from the overlap of its first row; both may scatter. `overlap` is the approach of
    one contact: half of the platens' when a particle is pressed between two of them.
    """

    overlap: FloatArray  # m; from a zero that may be unknown, with the machine's own deflection in it if that is not taken off
    force: FloatArray  # N; compression is positive
    branch: npt.NDArray[np.int64]
    radius: float  # m

    def __post_init__(self) -> None:
        require(_problems(self))

    @property
    def content_hash(self) -> str:
        """Sixteen hexadecimal digits of the rows and the radius."""
        digest = hashlib.sha256(repr(self.radius).encode())
        for column in (self.overlap, self.force, self.branch):
            digest.update(np.ascontiguousarray(column).tobytes())
        return digest.hexdigest()[:16]

    def rows(self, branch: int) -> npt.NDArray[np.int64]:
        """The rows of one branch."""
        return np.flatnonzero(self.branch == branch)

    @property
    def unloadings(self) -> range:
        """The numbers of the unloading branches."""
        return range(1, int(self.branch.max(initial=0)) + 1)


def from_curve(curve: Curve) -> Measured:
    """A curve as if it had been measured."""
    return Measured(np.array(curve.overlap), np.array(curve.force), np.array(curve.branch), float(curve.radius))


def read_measured(path: str | Path, radius: float | None = None) -> Measured:
    """Read a CSV file with a header that names at least `overlap` and `force` (SI units).

    A column `branch` counts 0 for the loading and k for the k-th unloading; without it the largest overlap is where the only unloading
    begins. A line `# radius: 5e-6` may stand for `radius` (m). Raises `InputError` naming line, value and remedy.
    """
    lines = read_text(path).splitlines()
    stated = _stated_radius(path, lines)
    if radius is None and stated is None:
        raise InputError(
            Problem("radius", None, f"{path} does not say how large the particle is", "give it, or add the line '# radius: 5e-6' (m)")
        )
    if radius is not None and stated is not None and not math.isclose(radius, stated, rel_tol=1e-9):
        raise InputError(Problem("radius", radius, f"contradicts {path}, which says {stated!r} m", "leave it out"))
    body = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not body:
        raise InputError(Problem(str(path), "no rows", "a measured curve needs a header and rows", "check that the right file was given"))
    header = [cell.strip() for cell in body[0][1].split(",")]
    require(_problems_with_header(path, header))
    overlap, force, branch = _columns(path, header, body[1:])
    if branch is None:
        turn = int(np.argmax(overlap))
        branch = (np.arange(overlap.size) > turn).astype(np.float64)
    return Measured(overlap, force, branch.astype(np.int64), float(radius if radius is not None else stated or 0.0))


def _stated_radius(path: str | Path, lines: list[str]) -> float | None:
    for number, line in enumerate(lines, 1):
        key, colon, value = line.lstrip().removeprefix("#").partition(":")
        if line.lstrip().startswith("#") and colon and key.strip() == "radius":
            try:
                return float(value)
            except ValueError as error:
                raise InputError(Problem(f"{path} line {number}: radius", value.strip(), "is no number", "give it in m")) from error
    return None


def _problems_with_header(path: str | Path, header: list[str]) -> Iterator[Problem]:
    for name in COLUMNS:
        if header.count(name) != 1:
            yield Problem(
                f"{path}: column {name}", None, f"the header is {','.join(header)!r}", "name the columns 'overlap,force', in m and N"
            )
    for name in header:
        if name not in (*COLUMNS, "branch", *PASSED_OVER):
            yield Problem(f"{path}: column", name, f"known are {', '.join((*COLUMNS, 'branch'))}", "rename or remove it")


def _columns(path: str | Path, header: list[str], body: list[tuple[int, str]]) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    problems: list[Problem] = []
    rows: list[list[float]] = []
    wanted = [header.index(name) for name in (*COLUMNS, "branch") if name in header]
    for number, line in body:
        cells = next(csv.reader([line]))
        if len(cells) != len(header):
            problems.append(Problem(f"{path} line {number}", line[:60], f"must have {len(header)} values", "complete or remove the line"))
            continue
        values = [_number(path, number, header[k], cells[k], problems) for k in wanted]
        rows.append(values)
    require(problems[:10])
    table = np.array(rows).reshape(len(rows), len(wanted))
    return table[:, 0], table[:, 1], table[:, 2] if len(wanted) > 2 else None


def _number(path: str | Path, line: int, name: str, cell: str, problems: list[Problem]) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (name == "branch" and (value != int(value) or value < 0)):
        problems.append(Problem(f"{path} line {line}: {name}", cell.strip(), "must be a finite number", "repair or remove the line"))
    return value


def _problems(measured: Measured) -> Iterator[Problem]:
    size = measured.overlap.size
    if not (math.isfinite(measured.radius) and measured.radius > 0.0):
        yield Problem("radius", measured.radius, "must be a positive length", "give metres")
    if size < FEWEST_ROWS:
        yield Problem("rows", size, f"a measured curve needs at least {FEWEST_ROWS}", "measure more states")
        return
    if not (measured.force.shape == measured.branch.shape == (size,)):
        yield Problem("columns", (measured.force.shape, measured.branch.shape), f"must have {size} rows like overlap", "give equal lengths")
        return
    for name, values in (("overlap", measured.overlap), ("force", measured.force)):
        if not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            yield Problem(f"{name}[row {row}]", float(values[row]), "must be finite", "remove or repair the row")
            return
    if measured.branch[0] != 0 or not np.isin(np.diff(measured.branch), (0, 1)).all():
        yield Problem("branch", measured.branch[:8].tolist(), "must start at 0 and go up by 0 or 1", "order the rows along the path")
    largest = float(measured.force.max())
    if largest <= 0.0:
        yield Problem("force", largest, "is never positive", "check its sign: compression is positive")
    elif measured.force.min() < -NEGATIVE * largest:
        row = int(np.argmin(measured.force))
        bound = f"must not fall below zero by more than noise ({NEGATIVE:.0%} of the largest force)"
        yield Problem(f"force[row {row}]", float(measured.force[row]), bound, "compression is positive; adhesion is not described")
    if np.ptp(measured.overlap) <= 0.0:
        yield Problem("overlap", float(measured.overlap[0]), "never changes", "check the column")
    elif float(measured.overlap.max()) >= measured.radius:
        yield Problem("overlap", float(measured.overlap.max()), f"must stay below the radius {measured.radius!r} m", "check the units")
