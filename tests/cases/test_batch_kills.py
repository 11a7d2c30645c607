"""kill -9 at random moments, of workers and of whole runs: nothing is lost, and nothing that was finished is done again."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import time
from pathlib import Path

import pytest

from cases.batch import index, shards, store
from tests.cases import stand_in
from tests.cases.stand_in import alive, begun, prepared, run_traced, task, whole

pytestmark = [
    pytest.mark.compiled_only(reason="nothing is compiled here, and starting processes takes long"),
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes where Linux has them"),
]

KILLS, TASKS = 30, 200


def kill_one(folder: Path, chance: random.Random) -> bool:
    """Kill a worker; False if there is none now."""
    pids = [int(path.name) for path in (folder / "workers").iterdir() if alive(int(path.name))]
    if pids:
        os.kill(chance.choice(pids), signal.SIGKILL)
    return bool(pids)


def judge(folder: Path, lost_at_most: int) -> None:
    """Every task has its whole record; none was begun when it was done, nor while another was at it; few were begun in vain.

    And the index tells what the records say; without opening them, but for those whose processes were killed before they could note it.
    """
    tasks = [task(f"t{number}") for number in range(TASKS)]
    assert [one.name for one in tasks if not whole(folder, one)] == []
    assert begun(folder, tasks) - TASKS <= lost_at_most
    records = {path.name: store.record_in(path.read_bytes()) for path in (folder / "tasks").glob("*.json")}
    noted = [entry[0] for entry in shards.read(folder, store.NOTES).entries]
    assert len(records) - len(set(noted) & records.keys()) <= lost_at_most
    assert len(noted) == len(set(noted))
    assert index.all_records(folder) == records


@pytest.fixture(autouse=True)
def few_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Notes are read where there are as many results as here."""
    monkeypatch.setattr(index, "WORTH", TASKS)


def test_thirty_kills_at_random_moments(tmp_path: Path) -> None:
    """Two processes work, so a kill of the whole run cuts off two tasks at most, one of a worker one."""
    folder, chance = prepared(tmp_path), random.Random(3)
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.cases.stand_in"])
    kills, cut_off = 0, 0
    while True:
        whole_run = context.Process(target=run_traced, args=(str(folder), TASKS, "fork"))
        whole_run.start()
        while kills < KILLS and whole_run.is_alive():
            time.sleep(chance.uniform(0.0, 0.12))
            if chance.random() < 0.4:
                whole_run.kill()
                kills, cut_off = kills + 1, cut_off + 2
                break
            if kill_one(folder, chance):
                kills, cut_off = kills + 1, cut_off + 1
        whole_run.join()
        if whole_run.exitcode == 0:
            break
    assert kills == KILLS
    judge(folder, cut_off)


def test_two_runs_at_once_on_one_folder_share_the_work(tmp_path: Path) -> None:
    folder = prepared(tmp_path)
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.cases.stand_in"])
    runs = [context.Process(target=run_traced, args=(str(folder), TASKS, "fork")) for _ in range(2)]
    for one in runs:
        one.start()
    for one in runs:
        one.join()
    assert [one.exitcode for one in runs] == [0, 0]
    judge(folder, 0)
    assert len(list((folder / "workers").iterdir())) <= 4
    assert stand_in.KEPT > 0.0
