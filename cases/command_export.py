"""`fe2dem export`: a fitted law for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cases.arguments import option

ENDINGS = {"csv": ".csv", "lammps": ".lmp"}


def export(
    law: Annotated[Path | None, typer.Argument(metavar="LAW.json", help="A fitted law.", show_default=False)] = None,
    curves: Annotated[
        list[Path] | None, typer.Argument(metavar="CURVE ...", help="For lammps: fit to these, in place of the law.", show_default=False)
    ] = None,
    to: Annotated[str | None, option("csv: a table; lammps: the nearest law that LAMMPS has without compiling.")] = None,
    out: Annotated[Path | None, option("Where to write; default: LAW.csv or LAW.lmp beside the law.")] = None,
    lmp: Annotated[str | None, option("The program lmp that replays the law; default: the one that is found.")] = None,
) -> None:
    """Write a fitted law for other programs; for LAMMPS its nearest native law, with its error beside ours, and replayed."""
    from cases.options import problems_with_output
    from contactlaws import fitted
    from contactlaws.curve_files import read_curve
    from contactlaws.errors import InputError, Problem

    problems: list[Problem] = []
    if to not in ENDINGS:
        problems.append(Problem("--to", to, "must be csv or lammps", "nothing else was ever run"))
    if law is None:
        problems.append(Problem("LAW.json", None, "is needed", "make one with `fe2dem fit CURVE --law NAME --out LAW.json`"))
    if curves and to == "csv":
        problems.append(Problem("CURVE", str(curves[0]), "is for --to lammps", "leave it out"))
    record, found = None, []
    try:
        record = None if law is None else fitted.load(law)
        found = [read_curve(path) for path in curves or []]
    except InputError as error:
        problems += error.problems
    place = out
    if law is not None and to in ENDINGS:
        place = out or law.with_suffix(ENDINGS[to])
        problems += problems_with_output("--out", place, (ENDINGS[to],), needed=True)
    if problems or record is None or place is None:
        raise InputError(problems)

    from cases.export import words, write_lammps, write_table

    if to == "csv":
        write_table(record, place)
    else:
        print("\n".join(words(write_lammps(record, found, place, lmp))))
    print(f"saved: {place}")
