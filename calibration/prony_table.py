"""Measured tables that a Prony series can be fitted to: relaxation, creep, or storage and loss modulus against frequency (DMA), from CSV.

    # modulus: shear
    time,modulus
    0.01,6.1e8
    ...

The header says what it is; units are s, Pa, 1/Pa, Hz and rad/s. Without the comment the modulus is Young's.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.csv_rows import Rows, read_rows
from contactlaws.errors import InputError, Problem, require

FloatArray = npt.NDArray[np.float64]
Kind = Literal["relaxation", "creep", "dynamic"]


class Columns(NamedTuple):
    """What one kind of table consists of."""

    kind: Kind
    place: str
    values: tuple[str, ...]
    errors: tuple[str, ...]  # may be left out, all together


LAYOUTS = (
    Columns("relaxation", "time", ("modulus",), ("error",)),
    Columns("creep", "time", ("compliance",), ("error",)),
    Columns("dynamic", "frequency", ("storage", "loss"), ("storage_error", "loss_error")),
    Columns("dynamic", "angular_frequency", ("storage", "loss"), ("storage_error", "loss_error")),
)
KNOWN = tuple(dict.fromkeys(name for one in LAYOUTS for name in (one.place, *one.values, *one.errors)))
MODULI = ("uniaxial", "shear")
#: numbers in a table: one term has three unknowns, and its scatter must show
FEWEST = 5


@dataclass(frozen=True)
class PronyTable:
    """A measured table. Of a dynamic one, the storage moduli come first in `values` and the loss moduli behind them."""

    kind: Kind
    place: FloatArray  # rising: time in s since the jump, or angular frequency in rad/s
    values: FloatArray  # Pa, or 1/Pa
    errors: FloatArray | None = None  # standard error of each of `values`
    shear: bool = False  # it is the shear modulus, else Young's
    name: str = "table"
    sha256: str | None = None  # of the file

    @property
    def window(self) -> tuple[float, float]:
        """The relaxation times in s that the table can see: from its first to its last time, or those of its frequencies."""
        first, last = float(self.place[0]), float(self.place[-1])
        return (1.0 / last, 1.0 / first) if self.kind == "dynamic" else (first, last)


def read_table(path: str | Path) -> PronyTable:
    """Read a table with the columns time,modulus or time,compliance (either with error) or frequency,storage,loss (with storage_error,
    loss_error; angular_frequency in place of frequency). Raises `InputError` naming file, line, value and remedy.
    """
    rows = read_rows(path, KNOWN, ("modulus",))
    layout = _layout(path, rows)
    modulus = rows.facts.get("modulus", MODULI[0])
    require([*_problems_with_modulus(path, modulus), *_problems_with_rows(path, rows, layout)])
    place = np.array(rows.columns[layout.place])
    errors = _joined(rows, layout.errors) if layout.errors[0] in rows.columns else None
    return PronyTable(
        layout.kind,
        2.0 * np.pi * place if layout.place == "frequency" else place,
        _joined(rows, layout.values),
        errors,
        modulus == "shear",
        Path(path).name,
        hashlib.sha256(Path(path).read_bytes()).hexdigest(),
    )


def _joined(rows: Rows, names: tuple[str, ...]) -> FloatArray:
    return np.concatenate([rows.columns[name] for name in names])


def _layout(path: str | Path, rows: Rows) -> Columns:
    header = set(rows.columns)
    for one in LAYOUTS:
        needed = {one.place, *one.values}
        if header in (needed, needed | set(one.errors)):
            return one
    bound = "is no table that a Prony series can be fitted to"
    remedy = "name the columns 'time,modulus', 'time,compliance' (s, Pa; both with 'error' if known) or 'frequency,storage,loss' (Hz, Pa)"
    raise InputError(Problem(f"{path}: header", ",".join(rows.columns), bound, remedy))


def _problems_with_modulus(path: str | Path, modulus: str) -> Iterator[Problem]:
    if modulus not in MODULI:
        yield Problem(f"{path}: modulus", modulus, f"must be one of {', '.join(MODULI)}", "say which modulus was measured")


def _problems_with_rows(path: str | Path, rows: Rows, layout: Columns) -> Iterator[Problem]:
    place = rows.columns[layout.place]
    fewest = -(-FEWEST // len(layout.values))
    if len(place) < fewest:
        yield Problem(str(path), f"{len(place)} rows", f"a series needs at least {fewest}", "measure more of them")
        return
    positive = [layout.place, *layout.errors, *layout.values]
    if layout.errors[0] in rows.columns:  # a loss modulus near zero may scatter below it, if it is known how far
        positive = [name for name in positive if name != "loss"]
    for name in (name for name in positive if name in rows.columns):
        yield from _first(path, rows, name, [value <= 0.0 for value in rows.columns[name]], "must be positive", "repair or remove the line")
    falling = [False, *(after <= before for before, after in zip(place[:-1], place[1:], strict=True))]
    yield from _first(path, rows, layout.place, falling, "must rise from line to line", "sort the lines, and keep one of each")


def _first(path: str | Path, rows: Rows, name: str, wrong: list[bool], bound: str, remedy: str) -> Iterator[Problem]:
    """The first line of a column that is wrong."""
    if any(wrong):
        row = wrong.index(True)
        yield Problem(f"{path} line {rows.lines[row]}: {name}", rows.columns[name][row], bound, remedy)
