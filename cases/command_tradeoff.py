"""The commands that compare laws by measurement: `fe2dem tournament`, and `fe2dem tradeoff`, what accuracy costs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cases.arguments import option

FAILED = 3

tradeoff = typer.Typer(
    no_args_is_help=True, help="What accuracy costs, measured: error against time, and the choice that a tolerance makes."
)


def tournament(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Results of fe2dem run, or curves (.parquet, .csv).", show_default=False)
    ],
    laws: Annotated[list[str] | None, option("A B ...: laws, as listed by `fe2dem laws`; default: all that can be fitted.")] = None,
    out: Annotated[Path | None, option("Folder for tables, pictures and report.html; default: results/tournament.")] = None,
) -> None:
    """Fit every law to every curve and score each for force, contact area, unloading, energy and cost."""
    from cases.tournament.run import tournament as play

    page, played = play(folder, laws, out or Path("results") / "tournament")
    print(f"report: {page}")
    if any(fit.law is None for fit in played.fits):
        raise typer.Exit(FAILED)


@tradeoff.command("law")
def tradeoff_law(
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="What fe2dem tournament wrote; none with --in-time.", show_default=False)
    ] = None,
    in_time: Annotated[
        bool, typer.Option("--in-time", help="Viscoelastic laws: terms and Ting's retreat, measured now, in two minutes.")
    ] = False,
    quantity: Annotated[str | None, option("One of the scores, such as force; default: all.")] = None,
    tolerance: Annotated[float | None, option("Largest relative error: names the cheapest law that keeps it (0.01 is 1 %).")] = None,
    max_overlap: Annotated[float | None, option("Only overlaps over the radius up to this.")] = None,
    out: Annotated[Path | None, option("PICTURE.png of error against cost.")] = None,
    save_scores: Annotated[
        Path | None, option("SCORES.parquet: what --tolerance of `fit` and `predict` goes by (calibration/data/tradeoff_law.parquet).")
    ] = None,
) -> None:
    """Error of the laws against nanoseconds per contact, from the scores of a tournament; with --in-time of the viscoelastic ones."""
    from contactlaws.errors import InputError, Problem

    given = {"quantity": quantity, "tolerance": tolerance, "max_overlap": max_overlap, "save_scores": save_scores, "FOLDER": folder}
    if in_time:
        for name, value in given.items():
            if value is not None:
                option_name = name if name == "FOLDER" else f"--{name.replace('_', '-')}"
                raise InputError(Problem(option_name, str(value), "is for the scores of a tournament", "leave it or --in-time out"))
        from cases.tradeoff.law_in_time import tradeoff_in_time

        tradeoff_in_time(out)
        return
    if folder is None:
        raise InputError(Problem("FOLDER", None, "is needed", "make one with `fe2dem tournament`, or give --in-time"))
    from cases.tradeoff.law import tradeoff_law as show

    show(folder, quantity, tolerance, max_overlap, out)
    if save_scores is not None:
        from cases.tradeoff.law_scores import save_scores as save

        print(f"written: {save(folder, save_scores)}")


@tradeoff.command("fe")
def tradeoff_fe(
    out: Annotated[Path | None, option("Folder for tables, pictures and report.html; default: results/tradeoff-fe.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Two bodies and coarse meshes: a look, in a minute.")] = False,
    finest: Annotated[int | None, option("Even number of divisions of the mesh that the others are measured against.")] = None,
) -> None:
    """Error of the finite-element curves against CPU time: mesh, steps, smoothing, element, levels of tolerance; about five CPU minutes."""
    from cases.tradeoff.fe import tradeoff_fe as measure

    if finest is not None and (finest % 2 or not 12 <= finest <= 64):
        from contactlaws.errors import InputError, Problem

        raise InputError(Problem("--finest", finest, "must be an even number from 12 to 64", "20 takes minutes, 32 takes hours"))
    print(f"report: {measure(out or Path('results') / 'tradeoff-fe', quick, finest)}")


@tradeoff.command("dem")
def tradeoff_dem(
    out: Annotated[Path | None, option("Folder for tables, pictures and report.html; default: results/tradeoff-dem.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Few settings and packings: a look, in a minute.")] = False,
) -> None:
    """Error of the stress in packings against CPU time, beside the scatter between packings: step, law, friction, rate, size, number."""
    from cases.tradeoff.dem import tradeoff_dem as measure

    print(f"report: {measure(out or Path('results') / 'tradeoff-dem', quick)}")
