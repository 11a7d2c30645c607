"""Runs of the continuum solver, counted in the processes that do them: each leaves its lines in a folder, also one that is killed.

    dask worker ADDRESS --nthreads 1 --preload cases.verification.solver_runs        # a worker that counts
    python -m cases.verification.solver_runs run STUDY.toml --jobs 2 --out FOLDER    # `fe2dem`, its processes counting

FE2DEM_SOLVER_RUNS names the folder; a body whose Poisson's ratio is FE2DEM_LETHAL kills the process that presses it.
"""

from __future__ import annotations

import functools
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from contactlaws.material import Material

FOLDER, LETHAL = "FE2DEM_SOLVER_RUNS", "FE2DEM_LETHAL"


class Line(NamedTuple):
    """One line of a log: a run of the solver begins or ends."""

    what: str  # begin or end
    process: int
    time: float  # s since the epoch


def name_of(material: Material) -> str:
    """What the log of a body is called."""
    return f"E{material.youngs_modulus:g}-nu{material.poissons_ratio:g}"


def counted(press: Callable[..., Any]) -> Callable[..., Any]:
    """The solver, leaving a line when it begins and one when it ends."""

    @functools.wraps(press)
    def counting(material: Material, **values: Any) -> Any:
        log = Path(os.environ[FOLDER]) / name_of(material)
        _leave(log, "begin")
        if os.environ.get(LETHAL) == f"{material.poissons_ratio:g}":
            os.kill(os.getpid(), signal.SIGKILL)
        curve = press(material, **values)
        _leave(log, "end")
        return curve

    return counting


def _leave(log: Path, what: str) -> None:
    """One line by one system call: lines of several processes do not mix."""
    handle = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
    os.write(handle, f"{what} {os.getpid()} {time.time():.6f}\n".encode("ascii"))
    os.close(handle)


def lines(folder: Path) -> dict[str, list[Line]]:
    """What has been left there, by body."""
    return {log.name: [_line(text) for text in log.read_text(encoding="ascii").splitlines()] for log in sorted(folder.iterdir())}


def _line(text: str) -> Line:
    what, process, moment = text.split()
    return Line(what, int(process), float(moment))


def count_here() -> None:
    """From now on, the solver counts in this process and in those forked from it."""
    from cases.batch.work import curves

    curves.press = counted(curves.press)  # type: ignore[assignment]


def dask_setup(worker: Any) -> None:
    """What a Dask worker calls that is started with --preload."""
    count_here()


def main() -> None:
    """`fe2dem` with processes forked from this one, so that they count."""
    from cases import study
    from cases.batch.local import LocalProcesses
    from cases.command import execute

    count_here()
    study.LocalProcesses = functools.partial(LocalProcesses, method="fork")  # type: ignore[assignment, misc]
    sys.exit(execute(sys.argv[1:]))


if __name__ == "__main__":
    main()
