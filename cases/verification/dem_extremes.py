"""Particle simulations far from everyday use: finite and right, or refused with one clear error, never NaN.

Each row of the table is a command. What is "right" comes from closed forms (Hertz's collision, momentum and energy, lattice sums), from
brute force over all images, or from the same state reached another way; `dem_extreme_steps` has the rows about the time step.

    python -m cases.verification.dem_extremes [ROW ...] [--out FOLDER]

Exit code 1 if a trial misses its bound, gives NaN, or stops without saying why.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from cases.verification.dem_extreme_scenes import BODIES, BOXES, MOTION
from cases.verification.dem_extreme_steps import STEPS
from cases.verification.dem_extreme_trial import Trial
from contactlaws.files import write_text

#: what can be asked for by name
ROWS: dict[str, Callable[[], list[Trial]]] = {**STEPS, **BODIES, **MOTION, **BOXES}
HEADER = ("row", "what was done", "measured", "bound", "verdict")


def trials(row: str) -> list[Trial]:
    """Of a row; a crash is one that failed."""
    try:
        return ROWS[row]()
    except Exception as crash:  # what a table of extremes is there to find
        return [Trial("all of it", repr(crash), "no crash", False, "CRASH")]


def cells(row: str, trial: Trial) -> list[str]:
    """As shown."""
    return [row, trial.done, trial.measured, trial.bound, trial.verdict]


def markdown(table: list[tuple[str, Trial]]) -> str:
    """The table and one sentence."""
    lines = ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
    lines += ["| " + " | ".join(cells(row, trial)) + " |" for row, trial in table]
    return "\n".join([*lines, "", summary(table), ""])


def summary(table: list[tuple[str, Trial]]) -> str:
    """How many of them were as they should be."""
    missed = [f"{row} ({trial.done})" for row, trial in table if not trial.sound]
    return f"{len(table)} trials, {len(missed)} beyond a bound{': ' if missed else ''}{'; '.join(missed)}."


def main(arguments: list[str] | None = None) -> int:
    """Run the rows asked for, or all; 0, or 1 if one is not as it should be."""
    description = (__doc__ or "").splitlines()[0]
    parser = argparse.ArgumentParser(prog="python -m cases.verification.dem_extremes", description=description)
    parser.add_argument("row", nargs="*", metavar="ROW", help=f"of {', '.join(ROWS)}; all if none is named")
    parser.add_argument("--out", type=Path, help="folder for table.md; none if left out")
    given = parser.parse_args(arguments)
    unknown = [row for row in given.row if row not in ROWS]
    if unknown:
        parser.error(f"no row is named {', '.join(unknown)}: choose from {', '.join(ROWS)}")
    table: list[tuple[str, Trial]] = []
    for row in given.row or ROWS:
        for trial in trials(row):
            table.append((row, trial))
            print(f"{'' if trial.sound else 'BEYOND ITS BOUND: '}{'; '.join(cells(row, trial))}", flush=True)
    print(summary(table))
    if given.out is not None:
        given.out.mkdir(parents=True, exist_ok=True)
        write_text(given.out / "table.md", markdown(table))
    return 0 if all(trial.sound for _, trial in table) else 1


if __name__ == "__main__":
    sys.exit(main())
