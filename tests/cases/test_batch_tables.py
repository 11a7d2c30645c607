"""The table of unloadings is the same whether its rows were noted by whoever made the curves, or are read off these again."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from calibration.unloadings import table_rows
from cases.batch import index, results, shards, store, tables, unloading_rows
from cases.batch.plan import plan
from cases.batch.task import Task
from cases.batch.worker import Job, perform
from cases.benchmarks.batch_overhead import formula, study_text
from cases.casefile.reading import read_case
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.errors import InputError
from contactlaws.unloading_table import write_table
from contactlaws.version import code_version
from tests.cases import stand_in

TABLES = ("curves.csv", "unloadings.csv")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The results of a study of 20 curves, each with an unloading; from three on, notes of them are made anew."""
    monkeypatch.setattr(unloading_rows, "WORTH", 3)
    monkeypatch.setattr(index, "WORTH", 3)
    (tmp_path / "study.toml").write_text(study_text(20))
    tasks = plan(read_case(tmp_path / "study.toml"), tmp_path)
    store.prepare(tmp_path)
    results.declare(tmp_path, "many", tmp_path / "study.toml", code_version(), tasks)
    for task in tasks:
        perform(Job(task, str(tmp_path), {}, formula))
    return tmp_path


def written(folder: Path) -> list[bytes]:
    tables.write_again(folder)
    return [(folder / name).read_bytes() for name in TABLES]


def unread(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """`written`, where no curve may be read."""
    with monkeypatch.context() as patch:
        patch.setattr(unloading_rows, "text_of", stand_in.refuse)
        return written(folder)


def notes(folder: Path) -> list[Path]:
    return stand_in.notes(folder, unloading_rows.KIND)


def test_rows_that_were_noted_when_the_curves_were_made_are_those_that_are_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = unread(folder, monkeypatch)
    assert first[1].count(b"\n") == 21
    shutil.rmtree(shards.place(folder))
    assert written(folder) == first
    assert unread(folder, monkeypatch) == first  # they were noted anew


def test_a_folder_of_an_older_release_has_the_same_tables(folder: Path) -> None:
    """It says nothing of rows; what it kept in other files is not looked at."""
    first = written(folder)
    shutil.rmtree(shards.place(folder))
    (folder / "tasks" / ".records").write_text('"fe2dem records 1"\n')
    (folder / "tasks" / ".unloadings").write_text('["fe2dem unloadings of curves 2", "0"]\n')
    assert written(folder) == first


def test_tables_do_not_depend_on_who_noted_what_in_which_order(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the lines in a file of their own, all backwards, some twice, one cut off."""
    first = written(folder)
    (path,) = notes(folder)
    lines = path.read_bytes().split(b"\n\n")[::-1]
    path.write_bytes(b"\n".join(lines[:12]) + b"\n")
    path.with_name(f"{unloading_rows.KIND}-another").write_bytes(b"\n".join(lines[8:]) + b"\n" + lines[3][:-7])
    assert unread(folder, monkeypatch) == first


@pytest.mark.parametrize("cut", [0, 7, 300, -9])
def test_rows_cut_off_are_read_again(folder: Path, cut: int) -> None:
    first = written(folder)
    (path,) = notes(folder)
    path.write_bytes(path.read_bytes()[:cut])
    assert written(folder) == first


def test_a_curve_that_is_another_is_read_again(folder: Path) -> None:
    first = written(folder)
    path = sorted((folder / "tasks").glob("*.json"))[7]
    record = store.record_in(path.read_bytes())
    file = folder / record.files["curve"]
    write_curve(replace(read_curve(file), stopped='changed, "twice"'), file)
    store.save(folder, record)
    again = written(folder)
    assert again[1].count(b"changed") == 1
    assert again != first
    shutil.rmtree(shards.place(folder))
    assert written(folder) == again


def test_rows_that_cannot_be_of_a_curve_are_not_believed(folder: Path) -> None:
    first = written(folder)
    record = next(found for found in results.load_case(folder)[1] if found is not None)
    key, content, code, text = json.loads(unloading_rows.noted(record, "a lie\n"))
    lies = (
        [key, "another file", code, text],
        ["another", content, code, text],
        [key, content, "other code", text],
        [key, content, code, 5],
    )
    for lie in (*lies, [key, content, code], "a lie", None, [[key], content, code, text]):
        shards.add(folder, unloading_rows.KIND, json.dumps(lie))
    assert written(folder) == first


def test_rows_of_other_code_are_not_believed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are read again, and noted in place of the others."""
    before = notes(folder)
    monkeypatch.setattr(unloading_rows, "_code", lambda: "another")
    written(folder)
    assert not set(before) & set(notes(folder))
    assert {entry[2] for entry in shards.read(folder, unloading_rows.KIND).entries} == {"another"}


def test_a_curve_that_cannot_be_read_is_told_when_the_table_is_made(folder: Path) -> None:
    """Whoever made it has its record all the same."""
    record = next(found for found in results.load_case(folder)[1] if found is not None)
    (folder / "broken.parquet").write_bytes(b"no curve")
    path = store.record_path(folder, record.task, record.key)
    path.unlink()
    task = Task("curves", record.name, {}, key=record.key)
    made = perform(Job(task, str(folder), {}, lambda *_: ({"curve": "broken.parquet"}, {}, None)))
    assert made.usable
    assert path.exists()
    with pytest.raises(InputError, match="no whole Parquet file"):
        written(folder)


def test_parquet_has_what_csv_has_to_the_bit(folder: Path) -> None:
    """It is read back from the text; a table made from the numbers themselves is the same."""
    import pyarrow.parquet as pq

    written(folder)
    paths = [record.files["curve"] for record in results.load_case(folder)[1] if record is not None]
    direct = write_table(list(table_rows(read_curve(folder / path) for path in paths)), folder / "direct.parquet")
    assert pq.read_table(folder / "unloadings.parquet").equals(pq.read_table(direct), check_metadata=True)
    direct = write_table(list(table_rows(read_curve(folder / path) for path in paths)), folder / "direct.csv")
    assert (folder / "unloadings.csv").read_bytes() == direct.read_bytes()


def test_results_that_are_not_there_have_no_rows(folder: Path) -> None:
    for path in sorted((folder / "tasks").glob("*.json"))[:5]:
        path.unlink()
    assert written(folder)[0].count(b"\n") == 16
