"""The same batch on a Dask cluster of this machine, whose workers are killed; and what is said where there is none."""

from __future__ import annotations

import os
import random
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cases.batch import runner, store
from cases.batch.cluster import DaskCluster
from contactlaws.errors import InputError
from tests.cases.stand_in import Silent, alive, make, task, traced

pytestmark = pytest.mark.compiled_only(reason="nothing is compiled here, and starting processes takes long")

KILLS, TASKS = 3, 24


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as found:
        yield found


def test_without_the_extra_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'fe2dem\[cluster\]'"):
        DaskCluster("tcp://127.0.0.1:1", tmp_path)


def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    monkeypatch.setattr("cases.batch.cluster.CONNECT_SECONDS", 1)
    with pytest.raises(InputError, match="no scheduler answers there"):
        DaskCluster("tcp://127.0.0.1:1", tmp_path)


def test_workers_must_see_the_folder(cluster: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not see"):
        DaskCluster(cluster.scheduler_address, tmp_path / "elsewhere")


def test_needs_failures_and_reuse_are_as_on_one_machine(cluster: Any, tmp_path: Path) -> None:
    store.prepare(tmp_path)
    tasks = [task("c", "a", "b"), task("a"), task("b"), task("broken"), task("after", "broken")]
    for turn in range(2):
        watcher = Silent()
        with DaskCluster(cluster.scheduler_address, tmp_path) as workers:
            records = runner.run(tasks, tmp_path, workers, watcher, make)
        assert (tmp_path / records["curves.c"].files["text"]).read_text() == "curves.acurves.b"
        assert records["curves.broken"].reason == "ValueError: on purpose"
        assert records["curves.after"].state == "failed"
        assert (("started", "a") in watcher.seen) == (turn == 0)
    assert sorted((tmp_path / "log").read_text().split()) == ["a", "b", "broken", "c"]


def test_killed_workers_lose_only_what_they_were_at(cluster: Any, tmp_path: Path) -> None:
    for name in ("logs", "curves", "workers", "tasks"):
        (tmp_path / name).mkdir()
    chance, stop = random.Random(5), threading.Event()
    killed: list[int] = []

    def kill() -> None:
        while len(killed) < KILLS and not stop.wait(chance.uniform(0.02, 0.2)):
            pids = [int(path.name) for path in (tmp_path / "workers").iterdir() if alive(int(path.name))]
            if pids:
                killed.append(chance.choice(pids))
                os.kill(killed[-1], signal.SIGKILL)

    thread = threading.Thread(target=kill)
    tasks = [task(f"t{number}") for number in range(TASKS)]
    with DaskCluster(cluster.scheduler_address, tmp_path) as workers:
        thread.start()
        records = runner.run(tasks, tmp_path, workers, Silent(), traced)
        stop.set()
        thread.join()
    assert killed
    begun = 0
    for one in tasks:
        assert records[one.id].state == "done"
        assert store.load(tmp_path, one.id, one.key, verify=True) is not None
        lines = (tmp_path / "logs" / one.name).read_text().split("\n")[:-1]
        assert not {"twice", "overlap"} & set(lines), lines
        begun += sum(line.startswith("begin") for line in lines)
    assert begun - TASKS <= len(killed)
