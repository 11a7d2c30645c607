"""`fe2dem slurm`: a batch on a cluster under Slurm, as two scripts: one that submits workers and runs the study, and the workers' own.

The workers' script is dask-jobqueue's, as an array of jobs, each of them one Dask worker on one core. Nobody has run these scripts on
Slurm: they were checked as text and by bash, and run with stand-ins for sbatch and scancel (`cases.verification.batch_faults slurm`).
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from cases.batch.store import problems_with_folder
from cases.casefile.reading import read_case
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import write_text
from contactlaws.version import code_version

NEVER_RUN = "never run on Slurm by those who wrote it: read both scripts before you submit them"
WORKERS, RUN = "workers.sbatch", "run.sh"
#: what sbatch takes as a time: minutes, or with hours, or with days
TIME = r"\d+|\d+:\d{2}|\d+:\d{2}:\d{2}|\d+-\d{1,2}(:\d{2}){0,2}"
WORD = r"[A-Za-z0-9_][A-Za-z0-9_.@+-]*"


class Request(NamedTuple):
    """What is asked of Slurm for the workers."""

    workers: int
    memory: str  # of each worker, such as 4 GB
    time: str  # after which Slurm ends a worker, such as 04:00:00
    queue: str | None = None  # partition
    account: str | None = None
    setup: str | None = None  # a shell command that makes `fe2dem` known, such as source .venv/bin/activate


def write_scripts(study: Path, request: Request, out: Path, folder: Path) -> tuple[Path, Path]:
    """Write `folder`/run.sh and `folder`/workers.sbatch, which put the results of `study` into `out`; returns both.

    Raises `InputError` for a study that cannot be run, a request that cannot be meant, or without dask-jobqueue.
    """
    read_case(study, lambda tasks: True)
    require(problems_with(request))
    require(problems_with_folder("--to", folder))
    workers = write_text(folder / WORKERS, workers_script(request, folder.resolve()))
    run = write_text(folder / RUN, run_script(study.resolve(), request, out.resolve(), folder.resolve()))
    run.chmod(0o755)
    return run, workers


def problems_with(request: Request) -> Iterator[Problem]:
    """Texts that would not be what they look like in a script."""
    if request.workers < 1:
        yield Problem("--workers", request.workers, "must be at least 1", "as many as there are cores to be had")
    if re.fullmatch(r"\d+(\.\d+)?\s*[kMGT]i?B", request.memory) is None:
        yield Problem("--memory", request.memory, "is no amount of memory", "write it like '4 GB'; 2 GB do for finite elements")
    if re.fullmatch(TIME, request.time) is None:
        yield Problem("--time", request.time, "is no time that Slurm knows", "write it like 04:00:00, or 2-00:00:00 for two days")
    for name, word in (("--queue", request.queue), ("--account", request.account)):
        if word is not None and re.fullmatch(WORD, word) is None:
            yield Problem(name, word, "must be one word", "sinfo and sacctmgr list them")


def workers_script(request: Request, folder: Path) -> str:
    """An array of jobs, each one Dask worker with one thread; a worker that has no scheduler for a minute ends."""
    job = _job_class()(
        scheduler='"$FE2DEM_SCHEDULER"',
        name='"fe2dem-$SLURM_ARRAY_JOB_ID-$SLURM_ARRAY_TASK_ID"',  # two workers of one name are refused
        queue=request.queue,
        account=request.account,
        walltime=request.time,
        cores=1,
        processes=1,
        memory=request.memory,
        job_name="fe2dem",
        job_extra_directives=[f"--array=1-{request.workers}", "--requeue"],
        job_script_prologue=_setup(request),
        worker_extra_args=["--no-dashboard", "--local-directory", '"${TMPDIR:-/tmp}"'],
        python="python",
        log_directory=shlex.quote(str(folder)) if re.search(r"\s", str(folder)) else str(folder),
        death_timeout=60,
        interface=None,
        nanny=True,
    )
    first, rest = job.job_script().rstrip("\n").split("\n", 1)
    return f"{first}\n{_words()}\n{rest.lstrip()}\n"


def run_script(study: Path, request: Request, out: Path, folder: Path) -> str:
    """Starts a scheduler, submits the workers, runs the study when the first is there, and takes back what is left of both."""
    queue = [f"#SBATCH -p {request.queue}"] if request.queue else []
    account = [f"#SBATCH -A {request.account}"] if request.account else []
    place, file = (shlex.quote(str(path)) for path in (out, folder / "scheduler.json"))
    lines = [
        "#!/usr/bin/env bash",
        _words(),
        "# bash run.sh on a login node that may, or sbatch run.sh: it needs one core, and to last as long as the study.",
        "# Run it again after anything has been killed: what is finished is kept.",
        "#SBATCH -J fe2dem-run",
        *queue,
        *account,
        "#SBATCH -n 1",
        "#SBATCH --mem=4G",
        f"#SBATCH -t {request.time}",
        "set -euo pipefail",
        *_setup(request),
        f"file={file}",
        'rm -f "$file"',
        'dask scheduler --port 0 --no-dashboard --scheduler-file "$file" &',
        "scheduler=$!",
        "workers=",
        'trap \'[ -z "$workers" ] || scancel "$workers"; kill "$scheduler"\' EXIT',
        'until [ -s "$file" ]; do kill -0 "$scheduler"; sleep 1; done',
        'address=$(python -c \'import json, sys; print(json.load(open(sys.argv[1]))["address"])\' "$file")',
        f'workers=$(sbatch --parsable --export=ALL,FE2DEM_SCHEDULER="$address" {shlex.quote(str(folder / WORKERS))})',
        "python -c 'import sys; from distributed import Client; Client(sys.argv[1]).wait_for_workers(1)' \"$address\"",
        f'fe2dem run {shlex.quote(str(study))} --out {place} --yes --scheduler "$address"',
    ]
    return "\n".join(lines) + "\n"


def _words() -> str:
    return f"# Written by {code_version()};\n# {NEVER_RUN}."


def _setup(request: Request) -> list[str]:
    return [] if request.setup is None else [request.setup]


def _job_class() -> Any:
    try:
        from dask_jobqueue.slurm import SLURMJob
    except ImportError:
        bound = "needs the package dask-jobqueue, which is not installed"
        raise InputError(Problem("fe2dem slurm", None, bound, "pip install 'fe2dem[cluster]'")) from None
    return SLURMJob
