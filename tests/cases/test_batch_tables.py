"""The table of unloadings is the same whether its rows were kept or read off the curves again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from calibration.unloadings import table_rows, write_table
from cases.batch import results, store, tables, unloading_rows
from cases.batch.plan import plan
from cases.batch.worker import Job, perform
from cases.benchmarks.batch_overhead import formula, study_text
from cases.casefile.reading import read_case
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.version import code_version

TABLES = ("curves.csv", "unloadings.csv")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The results of a study of 20 curves, each with an unloading; from three new ones on, rows are kept."""
    monkeypatch.setattr(unloading_rows, "WORTH", 3)
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


def test_what_was_kept_is_what_is_read(folder: Path) -> None:
    first = written(folder)
    assert first[1].count(b"\n") == 21
    assert (folder / unloading_rows.PLACE).exists()
    assert written(folder) == first
    for torn in ("", '["fe2dem', (folder / unloading_rows.PLACE).read_text()[:-9]):
        (folder / unloading_rows.PLACE).write_text(torn)
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
    (folder / unloading_rows.PLACE).unlink()
    assert written(folder) == again


def test_rows_of_other_code_are_not_believed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(folder)
    kept = (folder / unloading_rows.PLACE).read_text()
    monkeypatch.setattr(unloading_rows, "meaning_hash", lambda start: "another")
    written(folder)
    assert (folder / unloading_rows.PLACE).read_text() != kept


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
