"""`fe2dem slurm`: scripts that run a study on a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cases.arguments import option


def slurm(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="A case file or a study.", show_default=False)],
    workers: Annotated[int, typer.Option("--workers", help="Cores to ask for, each of them one worker.")] = 20,
    memory: Annotated[str, typer.Option("--memory", help="Of each worker.")] = "4 GB",
    time: Annotated[str, typer.Option("--time", help="After which Slurm ends a worker; what was finished is kept.")] = "04:00:00",
    queue: Annotated[str | None, option("Slurm's partition.")] = None,
    account: Annotated[str | None, option("Whose time it is.")] = None,
    setup: Annotated[str | None, option("Shell command that makes fe2dem known, such as 'source /home/me/.venv/bin/activate'.")] = None,
    out: Annotated[Path | None, option("Folder for results, seen by all machines; default: results/CASE.")] = None,
    to: Annotated[Path | None, option("Folder for the scripts, seen by all machines; default: slurm-CASE.")] = None,
) -> None:
    """Write the scripts that run a case or a study on a cluster under Slurm; they were never run on one."""
    from cases.slurm import NEVER_RUN, Request, write_scripts

    request = Request(workers, memory, time, queue, account, setup)
    run, submitted = write_scripts(case, request, out or Path("results") / case.stem, to or Path(f"slurm-{case.stem}"))
    print(f"written: {run} and {submitted}; {NEVER_RUN}")
    print(f"then: bash {run}")
