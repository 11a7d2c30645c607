"""Studies from the command line: what cannot be begun is refused with value, bound and remedy; what a run and its status say."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases import study
from cases.batch import pace, store
from cases.batch.local import Done
from cases.batch.store import Record
from cases.batch.task import Task
from cases.batch.worker import perform
from cases.command import BAD_INPUT, FAILED, execute
from cases.progress import Progress, reasons
from cases.report.page import write as write_page
from contactlaws.curve import Curve
from contactlaws.curve_files import write_curve
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.path import scan

STUDY = """
title = "many"
[materials.m]
youngs_modulus = { from = "1 GPa", to = "7 GPa", count = 7 }
poissons_ratio = [0.1, 0.2, 0.3]
[curves.press]
material = "m"
radius = 1
elastic = true
max_overlap = [0.01, 0.02]
"""
FEW = STUDY.replace('"7 GPa", count = 7', '"2 GPa", count = 2')


def hertz(task: Task, folder: Path, made: Mapping[str, Record], report: Any) -> Any:
    """A curve by formula in place of one by finite elements; one of the materials cannot be pressed."""
    material = Material(**task.values["material"])
    if material.youngs_modulus == 7e9:
        raise ArithmeticError(f"no convergence at {task.values['max_overlap']:g}")
    law = Hertz(task.values["radius"], material.reduced_modulus)
    overlap = np.linspace(0.0, task.values["max_overlap"], 12)
    curve = Curve(np.arange(12.0), overlap, scan(law, overlap).force, np.zeros(12, np.int64), radius=law.radius, material=material)
    file = folder / "curves" / f"{task.name}-{task.key}.parquet"
    file.parent.mkdir(exist_ok=True)
    write_curve(curve, file)
    return {"curve": f"curves/{file.name}"}, {"errors": {"force": 0.01}, "unloadings": 0, "cost": 0.1, "hash": curve.content_hash}, None


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which curves cost nothing, and reports neither."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(study, "LocalProcesses", InThisProcess)
    monkeypatch.setattr("cases.report.page.write", lambda folder: folder / "report.html")
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "few.toml").write_text(FEW)
    return tmp_path


class InThisProcess:
    """Workers that are none."""

    def __init__(self, jobs: int, kinds: Any) -> None:
        self.jobs, self._jobs = jobs, list[Any]()

    def __enter__(self) -> InThisProcess:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    @property
    def free(self) -> int:
        return 1 - len(self._jobs)

    def submit(self, job: Any) -> None:
        self._jobs.append(job)

    def wait(self, seconds: float) -> Any:
        job = self._jobs.pop()
        yield Done(job, perform(job._replace(make=hertz)))


def test_a_study_of_many_with_failures(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert execute(["run", "study.toml"]) == FAILED
    shown = capfd.readouterr()
    assert "42 results: 0 reused, 42 computed, 6 failed or stopped early" in shown.out
    assert "and 2 more: ArithmeticError: no convergence at 0.01" in shown.err
    assert shown.err.count("\n") < 20  # not a line for each result
    folder = place / "results" / "study"
    with (folder / "curves.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 42
    assert {row["state"] for row in rows} == {"done", "failed"}
    assert {row["reason"] for row in rows if row["youngs_modulus_Pa"] == "7000000000.0"} == {
        "ArithmeticError: no convergence at 0.01",
        "ArithmeticError: no convergence at 0.02",
    }
    assert (folder / "unloadings.csv").read_text().startswith("curve,")
    page = write_page(folder).read_text()
    assert page.count("<svg") == 0
    assert "36 bodies pressed" in page
    assert execute(["status", "results/study"]) == 0
    said = capfd.readouterr().out
    assert "36" in said
    assert "no convergence at 0.02" in said
    assert "press-E1GPa-nu0.1-d0.01" not in said
    assert execute(["status", "results/study", "--all"]) == 0
    assert "press-E1GPa-nu0.1-d0.01" in capfd.readouterr().out
    assert execute(["run", "study.toml"]) == FAILED
    assert "42 results: 42 reused, 0 computed" in capfd.readouterr().out


def test_a_longer_list_computes_what_is_new(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Also where the names change with it, and where only comments, order or units do."""
    assert execute(["run", "few.toml"]) == 0
    longer = FEW.replace("radius = 1", 'aspect = [1, 2]\nradius = ["1000 mm"]').replace("0.01, 0.02", "0.02, 0.01")
    (place / "few.toml").write_text("# longer\n" + longer)
    assert execute(["run", "few.toml"]) == 0
    assert "24 results: 12 reused, 12 computed" in capfd.readouterr().out


def test_results_of_other_code_are_kept_and_not_used(
    place: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert execute(["run", "few.toml"]) == 0
    monkeypatch.setattr("cases.batch.plan.meaning_hash", lambda start: "another")
    assert execute(["run", "few.toml"]) == 0
    assert "12 results: 0 reused, 12 computed" in capfd.readouterr().out
    assert execute(["status", "results/few"]) == 0
    assert "12 results of the same input by another version of the code" in capfd.readouterr().out
    (place / "few.toml").write_text(FEW.replace("[0.01, 0.02]", "0.01"))
    assert execute(["run", "few.toml"]) == 0
    with (place / "results" / "few" / "curves.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 6
    assert execute(["status", "results/few"]) == 0
    said = capfd.readouterr().out
    assert "6 results of the same input by another version of the code" in said
    assert "12 results of other input" in said


def test_the_folder_of_another_study_is_refused(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert execute(["run", "few.toml", "--out", "results"]) == 0
    before = (place / "results" / "case.json").read_text()
    (place / "other").mkdir()
    (place / "other" / "few.toml").write_text(FEW.replace("radius = 1", "radius = 2").replace('"many"', '"others"'))
    assert execute(["run", "other/few.toml", "--out", "results"]) == BAD_INPUT
    said = capfd.readouterr().err
    assert "holds the results of another study, 'many'" in said
    assert "--take-over" in said
    assert (place / "results" / "case.json").read_text() == before
    assert execute(["run", "other/few.toml", "--out", "results", "--take-over"]) == 0
    assert json.loads((place / "results" / "case.json").read_text())["title"] == "others"


def test_a_study_that_was_moved_or_changed_is_the_same(place: Path) -> None:
    assert execute(["run", "few.toml", "--out", "results"]) == 0
    (place / "few.toml").rename(place / "moved.toml")
    assert execute(["run", "moved.toml", "--out", "results"]) == 0
    (place / "moved.toml").write_text(FEW.replace("radius = 1", "radius = 3"))
    assert execute(["run", "moved.toml", "--out", "results"]) == 0


def test_very_many_tasks_ask_first(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nobody can be asked here, and that is said with the way out."""
    (place / "study.toml").write_text(STUDY.replace("count = 7", "count = 100000").replace("0.1, 0.2", "0.11, 0.12, 0.13, 0.2"))
    assert execute(["run", "study.toml"]) == BAD_INPUT
    said = capsys.readouterr().err
    assert "1,000,000 tasks" in said
    assert "--yes" in said
    assert not (place / "results").exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[0.1, 0.2, 0.3]", "[]", "materials.m.poissons_ratio = '[]': an empty list spans nothing"),
        ("[0.1, 0.2, 0.3]", "[0.1, 0.2, 0.1]", "materials.m.poissons_ratio[2] = 0.1: is the same point as [0]"),
        ('material = "m"', 'material = "m"\nelastc = true', "did you mean 'elastic'?"),
    ],
)
def test_a_wrong_grid_ends_before_any_computing(place: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, words: str) -> None:
    (place / "study.toml").write_text(STUDY.replace(old, new))
    assert execute(["run", "study.toml"]) == BAD_INPUT
    assert words in capsys.readouterr().err
    assert not (place / "results").exists()


def test_places_that_cannot_hold_results(place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert execute(["run", "few.toml", "--out", "few.toml/results"]) == BAD_INPUT
    assert "cannot be created" in capsys.readouterr().err
    monkeypatch.setitem(store.SPACE, "curves", 10**15)
    assert execute(["run", "few.toml"]) == BAD_INPUT
    said = capsys.readouterr().err
    assert "GB free" in said
    assert "12 results take" in said


def test_a_folder_that_may_only_be_read(place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("cases.batch.store.tempfile.TemporaryFile", refuse)
    assert execute(["run", "few.toml"]) == BAD_INPUT
    assert "cannot be written (Permission denied)" in capsys.readouterr().err


def test_jobs_and_scheduler_exclude_each_other(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["run", "few.toml", "--jobs", "2", "--scheduler", "tcp://127.0.0.1:1"]) == BAD_INPUT
    assert "leave out one of" in capsys.readouterr().err


def test_the_pace_is_weighed_by_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of two curves took 30 s; the other is twice as heavy by its tolerance, and one process works."""
    now = [0.0]
    monkeypatch.setattr("cases.batch.pace.time.monotonic", lambda: now[0])
    values = {"unload_from": [0.1] * 10}
    tasks = [Task("curves", "a", values | {"tolerance": 0.01}), Task("curves", "b", values | {"tolerance": 0.01 / 4 ** (1 / 3)})]
    measured = pace.Pace(tasks, 1)
    assert measured.seconds_left is None
    now[0] = 30.0
    measured.finished(tasks[0], Record(tasks[0].id, "k", "done", wall_seconds=30.0))
    assert measured.seconds_left == pytest.approx(60.0)
    assert measured.sentence() == "1 of 2; 2 per minute, about 60 s left"


def test_a_note_of_a_run_that_was_killed_is_not_believed(tmp_path: Path) -> None:
    found = pace.Pace([], 1)
    pace.write_note(tmp_path, found)
    assert (pace.read_note(tmp_path) or "").startswith("0 of 0")
    note = json.loads((tmp_path / "running.json").read_text())
    (tmp_path / "running.json").write_text(json.dumps(note | {"process": 2**22 + 1}))  # no system has so many
    assert pace.read_note(tmp_path) is None
    (tmp_path / "running.json").write_text("{")
    assert pace.read_note(tmp_path) is None


def test_reasons_are_grouped_and_the_most_frequent_come_first() -> None:
    records = [Record(f"curves.{n}", "k", "failed", "rare" if n == 3 else "often") for n in range(9)]
    assert next(iter(reasons(records))).endswith("curves.0 and 7 more: often")


def test_without_a_person_the_library_refuses_many(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY.replace("count = 7", "count = 100000"))
    with pytest.raises(InputError, match="--yes"):
        study.run_study(tmp_path / "study.toml", tmp_path / "out")


def test_a_small_run_says_a_line_for_each(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert execute(["run", "few.toml", "--out", "results"]) == 0
    assert capfd.readouterr().err.count("done     curves.press-") == 12
    assert isinstance(Progress([]), Progress)
