"""Particle simulations far from everyday use: finite and right, or refused with one clear error, never NaN.

Each row of the table is a command. What is "right" comes from closed forms (Hertz's collision, momentum and energy, lattice sums), from
brute force over all images, or from the same state reached another way; `dem_extreme_steps` has the rows about the time step.

    python -m cases.verification.dem_extremes [ROW ...] [--out FOLDER]

Exit code 1 if a trial misses its bound, gives NaN, or stops without saying why.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from cases.verification import rows
from cases.verification.dem_extreme_scenes import BODIES, BOXES, MOTION
from cases.verification.dem_extreme_steps import STEPS
from cases.verification.dem_extreme_trial import Trial
from contactlaws.files import write_text

#: what can be asked for by name
ROWS: dict[str, Callable[[], list[Trial]]] = {**STEPS, **BODIES, **MOTION, **BOXES}
HEADER = ("row", "what was done", "measured", "bound", "verdict")


def trials(row: Callable[[], list[Trial]]) -> list[Trial]:
    """Of a row; a crash is one that failed."""
    try:
        return row()
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


def run(chosen: Mapping[str, Callable[[], list[Trial]]], out: Path | None) -> int:
    """Print each trial as it comes, and write table.md if there is a folder for it; 0, or 1 if a trial is not as it should be."""
    table: list[tuple[str, Trial]] = []
    for name, row in chosen.items():
        for trial in trials(row):
            table.append((name, trial))
            print(f"{'' if trial.sound else 'BEYOND ITS BOUND: '}{'; '.join(cells(name, trial))}", flush=True)
    print(summary(table))
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        write_text(out / "table.md", markdown(table))
    return 0 if all(trial.sound for _, trial in table) else 1


def main(arguments: list[str] | None = None) -> int:
    """Run the rows asked for, or all; 0, or 1 if one is not as it should be."""
    parser = rows.parser_of("dem_extremes", __doc__, ROWS)
    parser.add_argument("--out", type=Path, help="folder for table.md; none if left out")
    given = rows.asked(parser, ROWS, arguments)
    return run({name: ROWS[name] for name in given.row}, given.out)


if __name__ == "__main__":
    sys.exit(main())
