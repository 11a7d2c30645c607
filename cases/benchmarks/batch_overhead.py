"""What the batches themselves cost: time per task where the tasks cost nothing, and a folder of very many results.

    python -m cases.benchmarks.batch_overhead tasks [--count 10000] [--jobs 2] [--scheduler ADDRESS | --dask]
    python -m cases.benchmarks.batch_overhead folder [--count 100000] [--unloadings 1] [--in FOLDER]

`tasks` runs a study of so many curves, each of them by Hertz's formula in place of finite elements, from the TOML file to the tables, and
then once more, with everything reused. --dask starts a scheduler with so many workers as --jobs says. `folder` fills a folder with the
results of such a study (or takes the one that --in names), and times `fe2dem status`, the tables and the report on it, each in a new
process: first (a folder just filled is as a run leaves it, killed or not); again; after a hundredth of the results has changed; and
without the notes that processes leave of what they made, as in a folder of an older release.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases import study
from cases.batch import results, shards, store, unloading_rows
from cases.batch.plan import plan
from cases.batch.store import Record
from cases.batch.task import Task
from cases.batch.work.place import Outcome, Report, place, relative
from cases.batch.worker import Job, perform
from cases.casefile.reading import read_case
from contactlaws import files
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.elastic import Hertz
from contactlaws.material import Material
from contactlaws.path import scan
from contactlaws.version import code_version

GOAL_TASK, GOAL_FOLDER = 0.020, 10.0  # s per task of 10 000; s for status or tables of 100 000
STATES = 12  # of the loading, and of each unloading
DEEPEST = 0.05  # overlap over the radius


def study_text(count: int, unloadings: int = 1) -> str:
    """A study of so many elastic curves (a multiple of ten), each with so many unloadings."""
    starts = [round(DEEPEST * number / unloadings, 6) for number in range(1, unloadings + 1)]
    return f"""
title = "{count} curves that cost nothing"
[materials.m]
youngs_modulus = {{ from = "1 GPa", to = "100 GPa", count = {count // 10}, spacing = "log" }}
poissons_ratio = {{ from = 0.0, to = 0.45, count = 10 }}
[curves.press]
material = "m"
radius = "5 um"
elastic = true
unload_from = {starts}
tolerance = 0.05
"""


def formula(task: Task, folder: Path, made: Mapping[str, Record], report: Report) -> Outcome:
    """Hertz's curve with its unloadings, written and recorded like one by finite elements."""
    material = Material(**task.values["material"])
    law = Hertz(task.values["radius"], material.reduced_modulus)
    starts = [overlap * law.radius for overlap in task.values["unload_from"]]
    way = np.concatenate([np.linspace(0.0, starts[-1], STATES), *(np.linspace(start, 0.0, STATES) for start in starts)])
    branch = np.repeat(np.arange(1 + len(starts), dtype=np.int64), STATES)
    force, radius = scan(law, way).force, np.sqrt(law.radius * way)
    curve = Curve(np.arange(float(way.size)), way, force, branch, contact_radius=radius, radius=law.radius, material=material)
    file = place(folder, task, ".parquet")
    write_curve(curve, file)
    summary = {
        "hash": curve.content_hash,
        "errors": {},
        "cost": 0.0,
        "states": way.size,
        "unloadings": len(starts),
        "max_overlap": starts[-1],
        "max_force": float(force[STATES - 1]),
        "yield_overlap": None,
        "yield_place": None,
        "process": os.getpid(),
        "process_cpu": time.process_time(),
    }
    return {"curve": relative(file, folder)}, summary, None


def written(folder: Path, count: int, unloadings: int = 1) -> Path:
    """The study's file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "many.toml"
    path.write_text(study_text(count, unloadings), encoding="utf-8")
    return path


def time_tasks(folder: Path, count: int, jobs: int, scheduler: str | None) -> None:
    """A study of tasks that cost nothing, twice."""
    source, out = written(folder, count), folder / "results"
    for turn in ("computed", "reused"):
        began, cpu = time.perf_counter(), time.process_time()
        case = read_case(source, lambda tasks: True)
        tasks = plan(case, folder)
        planned = time.process_time() - cpu
        records = study.run_tasks(case.title, source, tasks, out, jobs, scheduler, make=formula)
        wall = time.perf_counter() - began
        cpu = time.process_time() - cpu
        at_work = {record.summary["process"]: 0.0 for record in records.values()} if turn == "computed" else {}
        for record in records.values() if turn == "computed" else ():
            at_work[record.summary["process"]] = max(at_work[record.summary["process"]], record.summary["process_cpu"])
        inside = sum(record.cpu_seconds for record in records.values()) if turn == "computed" else 0.0
        overhead = (cpu + sum(at_work.values()) - inside) / count
        print(
            f"{turn}: {count:,} tasks in {wall:.1f} s, {1e3 * wall / count:.2f} ms each; overhead {1e3 * overhead:.2f} CPU ms a task (goal "
            f"{1e3 * GOAL_TASK:.0f}). CPU s: reading and planning {planned:.1f}, client in all {cpu:.1f}, workers "
            f"{sum(at_work.values()):.1f}, of which inside the tasks {inside:.1f}"
        )


def fill(folder: Path, count: int, unloadings: int) -> None:
    """The results of a study: records as workers write them, all with copies of the same curve, and none waited for to reach the disk."""
    source = written(folder, count, unloadings)
    tasks = plan(read_case(source, lambda tasks: True), folder)
    out = folder / "results"
    store.prepare(out, Counter(task.kind for task in tasks))
    results.declare(out, f"{count} results", source, code_version(), tasks)
    first = perform(Job(tasks[0], str(out), {}, formula))
    content, rows = (out / first.files["curve"]).read_bytes(), unloading_rows.text_of(out, first)
    files._to_disk = store._sync_folder = lambda path: None  # type: ignore[assignment]
    for task in tasks[1:]:
        path = place(out, task, ".parquet")
        path.write_bytes(content)
        made = replace(first, task=task.id, key=task.key, input=task.input, files={"curve": relative(path, out)})
        shards.add(out, unloading_rows.KIND, unloading_rows.noted(store.save(out, made), rows))


def time_folder(folder: Path, count: int) -> None:
    """Status, tables and report of many results, as often as the head of this file says."""
    out = folder / "results"
    for turn in ("first", "again", "a hundredth changed", "without notes"):
        if turn == "a hundredth changed":
            _change(out, count // 100)
        elif turn == "without notes":
            shutil.rmtree(shards.place(out))
        for name, code in COMMANDS.items():
            began = time.perf_counter()
            done = subprocess.run([sys.executable, "-c", code, str(out)], check=True, capture_output=True, text=True)
            wall = time.perf_counter() - began
            print(f"{count:,} results, {turn}: {name} {wall:.1f} s, {float(done.stdout.split()[-1]):.1f} CPU s (goal {GOAL_FOLDER:g})")


def _change(out: Path, number: int) -> None:
    """Curves as if they had been made anew, and had stopped."""
    for path in sorted((out / "tasks").glob("*.json"))[:number]:
        record = store.record_in(path.read_bytes())
        curve = replace(read_curve(out / record.files["curve"]), stopped="changed")
        write_curve(curve, out / record.files["curve"])
        unloading_rows.note(out, store.save(out, replace(record, summary={**record.summary, "hash": curve.content_hash})))


TELL = "; import time; print(time.process_time())"
#: each as a process of its own, which says at its end how much CPU time it took
COMMANDS = {
    "status": "import sys; from cases.command import execute; execute(['status', sys.argv[1]])" + TELL,
    "tables": "import sys; from pathlib import Path; from cases.batch.tables import write_again; write_again(Path(sys.argv[1]))" + TELL,
    "report": "import sys; from cases.command import execute; execute(['report', sys.argv[1]])" + TELL,
}


@contextlib.contextmanager
def _cluster(wanted: bool, jobs: int, folder: Path) -> Iterator[str | None]:
    """The address of a scheduler with workers, if one is wanted."""
    if not wanted:
        yield None
        return
    from cases.verification.dask_processes import DaskProcesses

    with DaskProcesses(jobs, folder, {}) as processes:
        yield processes.address


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m cases.benchmarks.batch_overhead", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", choices=("tasks", "folder"))
    parser.add_argument("--count", type=int, help="tasks, or results; default 10000, or 100000")
    parser.add_argument("--unloadings", type=int, default=1, help="of each curve in a folder; default 1")
    parser.add_argument("--jobs", type=int, default=2, help="processes; default 2")
    parser.add_argument("--scheduler", help="address of a Dask scheduler")
    parser.add_argument("--dask", action="store_true", help="start one")
    parser.add_argument("--in", dest="folder", type=Path, help="folder that is kept; filled only if it is not there")
    given = parser.parse_args(arguments)
    count = (given.count or (10_000 if given.what == "tasks" else 100_000)) // 10 * 10
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        if given.what == "tasks":
            with _cluster(given.dask, given.jobs, Path(temporary)) as address:
                time_tasks(folder, count, given.jobs, given.scheduler or address)
            return
        if not (folder / "results").exists():
            began = time.perf_counter()
            fill(folder, count, given.unloadings)
            print(f"filled in {time.perf_counter() - began:.0f} s")
        time_folder(folder, count)


if __name__ == "__main__":
    main()
