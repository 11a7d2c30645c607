"""`fe2dem uncertainty`: bands of stress against strain from the errors of a law and the chance of a packing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cases.arguments import option

FAILED = 3


def uncertainty(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="A case file with a fit and a scene on it.", show_default=False)],
    scene: Annotated[str | None, option("The scene's name; may be left out if there is but one.")] = None,
    draws: Annotated[int, typer.Option("--draws", help="Laws drawn from the errors of the fit.")] = 12,
    packings: Annotated[int, typer.Option("--packings", help="Packings, of seeds from the scene's own on; every law runs on each.")] = 8,
    out: Annotated[Path | None, option("Folder for results; default: results/CASE-SCENE.")] = None,
    jobs: Annotated[int | None, typer.Option("--jobs", min=1, help="Processes to use; default: the number of cores.")] = None,
    scheduler: Annotated[str | None, option("ADDRESS of a Dask scheduler, in place of --jobs.")] = None,
    take_over: Annotated[bool, typer.Option("--take-over", help="Use --out even if it holds the results of another study.")] = False,
) -> None:
    """Propagate a fitted law's errors and the packing's chance to bands of stress, and say whose share is which."""
    from cases.study import one_of
    from cases.uncertainty.run import Layout, propagate

    one_of(jobs, scheduler)
    page, records = propagate(case, scene, Layout(draws, packings), out, jobs=jobs, scheduler=scheduler, take_over=take_over)
    print(f"report: {page}")
    if any(record.state != "done" for record in records.values()):
        raise typer.Exit(FAILED)
