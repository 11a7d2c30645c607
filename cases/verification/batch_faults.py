"""A study while its processes are killed: what each fault costs, counted in runs of the solver, and whether the tables stay the same.

    python -m cases.verification.batch_faults [ROW ...] [--out FOLDER]      all rows: some eight minutes; needs the extra `cluster`, Linux

A grid of elastic bodies is pressed by finite elements, in local processes and on a Dask scheduler with four workers, all of them real
processes that are killed with kill -9 in mid-task. Each run of the solver leaves a line when it begins and when it ends. Of every row is
asked: each body has its whole result, none was begun when its result was there, no two processes pressed the same body at once, no more
runs were begun in vain than processes killed, and the tables are those of an undisturbed run, to the bit, but for the CPU times in them.

Exit code 1 if a row is not as expected.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from cases.slurm import Request, write_scripts
from cases.verification import rows, solver_runs
from cases.verification.batch_fault_judge import Expected, Verdict, judged
from cases.verification.dask_processes import DaskProcesses, alive, until

MODULI, RATIOS = 8, ("0.1", "0.2", "0.3")
LETHAL = "0.3"  # the Poisson's ratio of bodies that kill who presses them
STUDY = f"""
title = "many"
[materials.m]
youngs_modulus = {{ from = "1 GPa", to = "{MODULI} GPa", count = {MODULI} }}
poissons_ratio = [{", ".join(RATIOS)}]
[curves.press]
material = "m"
radius = 1
elastic = true
max_overlap = 0.05
tolerance = 0.05
[fits.fit]
law = "hertz"
curves = ["press"]
"""
#: the same with one body only that kills
POISONED = STUDY.replace(f'to = "{MODULI} GPa", count = {MODULI}', f'to = "{MODULI} GPa", count = 2')
BODIES = MODULI * len(RATIOS)
WORKERS = 4


class Place:
    """A folder for one row: study, results, and the lines of the solver's runs."""

    def __init__(self, folder: Path, study: str = STUDY, lethal: bool = False) -> None:
        self.runs, self.results, self.study = folder / "runs", folder / "results", folder / "study.toml"
        self.runs.mkdir(parents=True)
        self.folder = folder
        self.study.write_text(study)
        self.settings = {solver_runs.FOLDER: str(self.runs), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
        if lethal:
            self.settings[solver_runs.LETHAL] = LETHAL
        self.killed: list[int] = []
        self._chance = random.Random(1)

    def run(self, *options: str) -> subprocess.Popen[bytes]:
        """Start `fe2dem run`; it prints into run.log."""
        command = [sys.executable, "-m", "cases.verification.solver_runs", "run", str(self.study), "--out", str(self.results), *options]
        with (self.folder / "run.log").open("ab") as log:
            return subprocess.Popen(command, stdout=log, stderr=log, env={**os.environ, **self.settings})

    def cluster(self, workers: int = WORKERS) -> DaskProcesses:
        """Scheduler and workers that count for this place."""
        return DaskProcesses(workers, self.folder, self.settings, "cases.verification.solver_runs")

    def begun(self) -> list[int]:
        """Processes that press a body now."""
        last = [found[-1] for found in solver_runs.lines(self.runs).values() if found]
        return [line.process for line in last if line.what == "begin" and alive(line.process)]

    def workers(self) -> list[int]:
        """Processes that have pressed a body, and are there."""
        known = {line.process for found in solver_runs.lines(self.runs).values() for line in found}
        return [process for process in sorted(known) if alive(process)]

    def ended(self) -> int:
        """How many runs of the solver have come to their end."""
        return sum(line.what == "end" for found in solver_runs.lines(self.runs).values() for line in found)

    def kill_workers(self, number: int, each: int = 3) -> None:
        """Kill so many processes in mid-task, one whenever `each` more bodies are done."""
        for turn in range(number):
            until(lambda turn=turn: self.ended() >= each * (turn + 1) and bool(self.begun()))  # type: ignore[misc]
            victim = self._chance.choice(self.begun() or [0])
            if victim:
                os.kill(victim, signal.SIGKILL)
                self.killed.append(victim)

    def kill_run(self, run: subprocess.Popen[bytes], after: int, its_own: bool) -> None:
        """Kill a run when so many bodies are done; its_own: the processes in work are its children, and go with it."""
        until(lambda: self.ended() >= after and bool(self.begun()))
        at_work = self.begun()
        run.kill()
        run.wait()
        self.killed += at_work if its_own else []


def undisturbed(place: Place) -> int:
    """A local process, alone."""
    return place.run("--jobs", "1").wait()


def local_kills(place: Place) -> int:
    """Two local processes, five times killed."""
    run = place.run("--jobs", "2")
    place.kill_workers(5)
    return run.wait()


def local_run_killed(place: Place) -> int:
    """The whole run killed, twice, and begun again."""
    for number in (1, 2):
        place.kill_run(place.run("--jobs", "2"), number * BODIES // 3, its_own=True)
        until(lambda: not place.begun())
    return place.run("--jobs", "2").wait()


def local_two(place: Place) -> int:
    """Two runs at once on one folder, two of their processes killed."""
    runs = [place.run("--jobs", "2") for _ in range(2)]
    place.kill_workers(2)
    return max(run.wait() for run in runs)


def local_lethal(place: Place) -> int:
    """Bodies that kill their process."""
    return place.run("--jobs", "2").wait()


def dask_undisturbed(place: Place) -> int:
    """Four workers, nothing killed."""
    with place.cluster() as cluster:
        return place.run("--scheduler", cluster.address).wait()


def dask_kills(place: Place) -> int:
    """Five workers killed in mid-task."""
    with place.cluster() as cluster:
        run = place.run("--scheduler", cluster.address)
        place.kill_workers(5)
        return run.wait()


def dask_scheduler(place: Place) -> int:
    """The scheduler killed, it and its workers started again."""
    with place.cluster() as cluster:
        run = place.run("--scheduler", cluster.address)
        until(lambda: place.ended() >= BODIES // 3 and bool(place.begun()))
        workers = place.workers()  # until its own end comes, each may begin one more of the bodies that it holds
        cluster.kill()
        place.killed += workers
        cluster.start()
        return run.wait()


def dask_client(place: Place) -> int:
    """The client killed, and begun again."""
    with place.cluster() as cluster:
        place.kill_run(place.run("--scheduler", cluster.address), BODIES // 3, its_own=False)
        return place.run("--scheduler", cluster.address).wait()


def dask_two(place: Place) -> int:
    """Two clients at once on one folder, two workers killed."""
    with place.cluster() as cluster:
        runs = [place.run("--scheduler", cluster.address) for _ in range(2)]
        place.kill_workers(2)
        return max(run.wait() for run in runs)


def dask_lethal(place: Place) -> int:
    """Bodies that kill their worker."""
    with place.cluster() as cluster:
        return place.run("--scheduler", cluster.address).wait()


def slurm(place: Place) -> int:
    """The scripts for Slurm, with stand-ins for sbatch and scancel that start and end the workers here."""
    folder = place.folder / "slurm"
    write_scripts(place.study, Request(WORKERS, "1 GB", "01:00:00"), place.results, folder)
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (place.folder / name).write_text(text)
        (place.folder / name).chmod(0o755)
    path = f"{place.folder}:{Path(sys.executable).parent}:{os.environ['PATH']}"
    preload = {"DASK_DISTRIBUTED__WORKER__PRELOAD": "cases.verification.solver_runs"}
    with (place.folder / "run.log").open("ab") as log:
        environment = {**os.environ, **place.settings, **preload, "PATH": path, "STANDS_IN": str(place.folder)}
        done = subprocess.run(["bash", folder / "run.sh"], stdout=log, stderr=log, env=environment, check=False)
    left = [process for process in map(int, (place.folder / "jobs").read_text().split()) if alive(process)]
    return done.returncode or len(left)


SBATCH = r"""#!/usr/bin/env bash
for option; do case $option in --export=ALL,*) export "${option#--export=ALL,}";; *) script=$option;; esac; done
for number in $(seq "$(sed -n 's/^#SBATCH --array=1-//p' "$script")"); do
    SLURM_ARRAY_JOB_ID=7 SLURM_ARRAY_TASK_ID=$number setsid bash "$script" >>"$STANDS_IN/workers.log" 2>&1 &
    echo $! >>"$STANDS_IN/jobs"
done
echo 7
"""
SCANCEL = r"""#!/usr/bin/env bash
while read -r job; do kill -KILL -- -"$job"; done <"$STANDS_IN/jobs"
sleep 1
"""

#: what is done, and what its end is to be like
ROWS: Mapping[str, tuple[Callable[[Place], int], Expected]] = {
    "local": (undisturbed, Expected()),
    "local-kills": (local_kills, Expected()),
    "local-run-killed": (local_run_killed, Expected()),
    "local-two-runs": (local_two, Expected()),
    "local-lethal": (local_lethal, Expected(lethal=LETHAL)),
    "dask": (dask_undisturbed, Expected()),
    "dask-kills": (dask_kills, Expected()),
    "dask-scheduler": (dask_scheduler, Expected()),
    "dask-client": (dask_client, Expected()),
    "dask-two-clients": (dask_two, Expected()),
    "dask-lethal": (dask_lethal, Expected(lethal=LETHAL)),
    "slurm": (slurm, Expected()),
}
FIRST = "local"  # the others are held against it


def row(name: str, folder: Path) -> Verdict:
    """Do one row in a folder of its own, and judge what is there."""
    do, expected = ROWS[name]
    place = Place(folder / name, POISONED if expected.lethal else STUDY, bool(expected.lethal))
    try:
        code = do(place)
    except TimeoutError as error:
        return Verdict(name, str(do.__doc__), "an end", f"none: {error}", False)
    return judged(name, str(do.__doc__), place.folder, code, place.killed, expected, folder / FIRST)


def main(arguments: list[str] | None = None) -> int:
    """Do the rows asked for, or all; 0, or 1 if one is not as expected."""
    parser = rows.parser_of("batch_faults", __doc__, ROWS)
    parser.add_argument("--out", type=Path, help="folder in which everything is left; a temporary one if left out")
    given = rows.asked(parser, ROWS, arguments)
    with tempfile.TemporaryDirectory() as temporary:
        verdicts = []
        for name in dict.fromkeys([FIRST, *given.row]):
            verdicts.append(row(name, given.out or Path(temporary)))
            print(verdicts[-1].sentence(), flush=True)
    wrong = [verdict.row for verdict in verdicts if not verdict.sound]
    print(f"{len(verdicts)} rows, {len(wrong)} not as expected{': ' if wrong else ''}{', '.join(wrong)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
