"""A case file or a study from the file to its results: what `fe2dem run` does, for Python."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from cases.batch import results, runner, store, tables
from cases.batch.local import LocalProcesses
from cases.batch.plan import plan
from cases.batch.store import Record
from cases.batch.task import Task
from cases.batch.worker import Make
from cases.casefile.reading import ask_first, read_case
from cases.casefile.schema import Case, ToleranceOption
from cases.casefile.validation import validated
from cases.progress import Progress
from contactlaws.errors import InputError, Problem
from contactlaws.version import code_version


def run_study(
    study: str | Path,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    accept: Callable[[int], bool] = ask_first,
    take_over: bool = False,
    tolerance: float | str | None = None,
) -> Mapping[str, Record]:
    """Compute everything that a case file or a study declares; what is in the folder `out` already is reused.

    out: without it results/STUDY. jobs: processes, without it one for each core. scheduler: address of a Dask cluster in place of them.
    accept: asked with the number of tasks if they are more than 10 000; without it they are refused. take_over: use the folder even if it
    holds the results of another study. tolerance: of every finite-element curve, in place of what the file says. Returns the record of
    each task by its name, such as "curves.press-E10-nu0.3"; failures are among them. Tables of curves, unloadings and laws stand in the
    folder afterwards.

    Raises `InputError` with all that is wrong before anything is computed.
    """
    source = Path(study).resolve()
    case = read_case(source, accept) if tolerance is None else with_tolerance(read_case(source, accept), tolerance)
    tasks = plan(case, source.parent)
    return run_tasks(case.title, source, tasks, Path(out or Path("results") / source.stem), jobs, scheduler, take_over)


def with_tolerance(case: Case, tolerance: float | str) -> Case:
    """The same case with another tolerance of all its curves; raises `InputError` for one that is not on offer."""
    value = validated(ToleranceOption, {"tolerance": tolerance}).tolerance
    curves = {name: table.model_copy(update={"tolerance": value}) for name, table in case.curves.items()}
    return case.model_copy(update={"curves": curves})


def run_tasks(
    title: str,
    source: Path,
    tasks: Sequence[Task],
    out: Path,
    jobs: int | None = None,
    scheduler: str | None = None,
    take_over: bool = False,
    make: Make | None = None,
) -> Mapping[str, Record]:
    """`run_study` for tasks that are planned already; `source` is the file that they are from.

    make: what does the work, if not the module of a task's kind in `cases.batch.work`.
    """
    folder = out.resolve()
    if not take_over:
        results.require_own(folder, source, tasks)
    store.prepare(folder, Counter(task.kind for task in tasks if not store.record_path(folder, task.id, task.key).exists()))
    with _workers(tasks, folder, jobs or cores(), scheduler) as workers, Progress(tasks, workers.jobs, folder) as progress:
        results.declare(folder, title, source, code_version(), tasks)
        records = runner.run(tasks, folder, workers, progress, make)
    progress.summarise(records.values())
    written = tables.write(folder, tasks, records)
    if written:
        print(f"tables: {', '.join(path.name for path in written)} in {folder}")
    return records


def _workers(tasks: Sequence[Task], folder: Path, jobs: int, scheduler: str | None) -> runner.Workers:
    if scheduler is None:
        return LocalProcesses(min(jobs, max(len(tasks), 1)), sorted({task.kind for task in tasks}))
    from cases.batch.cluster import DaskCluster

    return DaskCluster(scheduler, folder)


def one_of(jobs: int | None, scheduler: str | None) -> None:
    """Raise `InputError` if processes of this machine are asked for and a cluster too."""
    if jobs is not None and scheduler is not None:
        bound = "is for processes of this machine"
        raise InputError(Problem("--jobs", jobs, bound, "leave out one of --jobs and --scheduler"))


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
