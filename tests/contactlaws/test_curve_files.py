"""Curves on disk: every bit comes back, and what is wrong with a file is said with row, value and remedy."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from contactlaws.curve_files import read_curve, write_curve
from contactlaws.errors import InputError
from contactlaws.files import write_text
from tests.contactlaws.samples import HARD, curve_of, edmans_sinka

CURVE = curve_of(
    edmans_sinka(HARD),
    0.1,
    (0.3, 1.0),
    HARD,
    rows=20,
    yield_overlap=5.3e-6,
    yield_place=(0.0, 0.99),
    errors={"force": 0.002},
    provenance={"cpu": 1.5},
)
HEADER = "overlap,force\n"
MEASURED = "# any remark\n# taken: on a Tuesday\n" + HEADER + "1e-7,1e-3\n2e-7,3e-3\n3e-7,6e-3\n2.8e-7,2e-3\n2.6e-7,0\n"


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_every_bit_comes_back(tmp_path: Path, ending: str):
    again = read_curve(write_curve(CURVE, tmp_path / f"curve.{ending}"))
    assert again.content_hash == CURVE.content_hash
    assert (again.yield_overlap, again.yield_place, again.errors, again.provenance) == (5.3e-6, (0.0, 0.99), {"force": 0.002}, {"cpu": 1.5})
    assert [file.name for file in tmp_path.iterdir()] == [f"curve.{ending}"]


def test_csv_is_the_contract(tmp_path: Path):
    lines = write_curve(replace(CURVE, contact_radius=None), tmp_path / "c.csv").read_text().splitlines()
    rows = [line for line in lines if not line.startswith("# ")]
    assert rows[0] == "branch,time,overlap,force,contact_radius"
    assert rows[1].startswith("0,0.0,")
    assert rows[1].endswith(",")  # a contact radius that is not known is empty
    assert all(": " in line for line in lines if line.startswith("#"))


def test_parquet_carries_units(tmp_path: Path):
    schema = pq.read_schema(write_curve(CURVE, tmp_path / "c.parquet"))
    assert {field.name: field.metadata[b"unit"] for field in schema} == {
        "time": b"s", "overlap": b"m", "force": b"N", "branch": b"1", "contact_radius": b"m",
    }  # fmt: skip


def test_a_measured_file_has_only_overlap_and_force(tmp_path: Path):
    file = tmp_path / "measured.csv"
    file.write_text(MEASURED)
    curve = read_curve(file, radius=5e-6)
    assert curve.branch.tolist() == [0, 0, 0, 1, 1, 1]
    assert curve.overlap.tolist() == [1e-7, 2e-7, 3e-7, 3e-7, 2.8e-7, 2.6e-7]
    assert curve.contact_radius is None
    file.write_text("# radius: 5e-6\n" + MEASURED)
    assert read_curve(file).radius == 5e-6
    with pytest.raises(InputError, match="contradicts"):
        read_curve(file, radius=6e-6)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "no rows"),
        ("# only a remark\n", "no rows"),
        ("overlap\n1\n2\n3\n", "column force missing"),
        ("overlap,force,colour\n1,2,3\n", "'colour'"),
        (HEADER + "1e-7,1\n2e-7,nan\n3e-7,2\n", r"line 3: force = 'nan': must be a finite number"),
        (HEADER + "1e-7,1\n2e-7,one\n3e-7,2\n", r"line 3: force = 'one'"),
        (HEADER + "1e-7,1\n2e-7\n3e-7,2\n", r"line 3 = '2e-7': must have 2 values"),
        (HEADER + "1e-7,1\n2e-7,\n3e-7,2\n", r"line 3: force missing"),
        (HEADER + "1e-7,1\n3e-7,2\n2e-7,1\n2.5e-7,1\n", r"line 5: overlap = .*must rise to the largest overlap \(line 3\)"),
        ("branch," + HEADER + "0,1e-7,1\n0,3e-7,2\n0,2e-7,1\n", r"line 4: overlap = .*must increase along the loading"),
        ("branch," + HEADER + "0,1e-7,1\n0,3e-7,2\n1,3e-7,2\n1,4e-7,1\n", r"line 5: overlap = .*must decrease along an unloading"),
        ("branch," + HEADER + "1,1e-7,1\n0,3e-7,2\n0,4e-7,2\n", r"line 2: branch"),
        (HEADER + "1e-7,1\n2e-7,2\n", "at least 3"),
        (HEADER + '1e-7,1\n2e-7,"2\n3e-7,3\n4e-7,4\n', r"line 3 = '2e-7,\"2': is no line of a CSV file"),
        ('overlap,"force\n1e-7,1\n2e-7,2\n3e-7,3\n', r"line 1 = .*stray quotation mark"),
        ("# radius: 1" + 400 * "0" + "\n" + MEASURED, "radius = 10+: must be a positive number"),
        ("# errors: " + 99999 * "[" + "\n" + MEASURED, "line 1: errors"),
        ("time," + HEADER + "1,1e-7,1\n3,2e-7,2\n2,3e-7,3\n", r"branch 0 row 2: time = 2.0: must not fall"),
        (HEADER + "1e-7,1\n3e-7,2\n2e-7,3\n1e-7,4\n", r"branch 1 row 2: force = 4.0: must not end above .* 2 N"),
        (HEADER + "0.1,1\n0.2,2\n0.3,3\n", "must stay below the radius"),
        ("# radius: large\n" + MEASURED, r"line 1: radius = 'large'"),
        ('# material: {"youngs_modulus": -1.0, "poissons_ratio": 0.3}\n' + MEASURED, "youngs_modulus = -1.0"),
    ],
)
def test_what_is_wrong_with_a_csv_is_said(tmp_path: Path, content: str, expected: str):
    file = tmp_path / "bad.csv"
    file.write_text(content)
    with pytest.raises(InputError, match=expected) as error:
        read_curve(file, radius=5e-6)
    assert all(problem.remedy for problem in error.value.problems)


def test_all_bad_rows_are_named_at_once(tmp_path: Path):
    file = tmp_path / "bad.csv"
    file.write_text(HEADER + "a,1\n2,b\n3,4\n")
    with pytest.raises(InputError) as error:
        read_curve(file, radius=5e-6)
    assert len(error.value.problems) == 2


def test_truncated_and_foreign_parquet(tmp_path: Path):
    file = write_curve(CURVE, tmp_path / "c.parquet")
    whole = file.read_bytes()
    for size in (0, 3, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:size])
        with pytest.raises(InputError, match="no whole Parquet file"):
            read_curve(file)
    pq.write_table(pa.table({"overlap": [1.0, 2.0, 3.0]}), file)
    with pytest.raises(InputError, match="is Parquet, but no"):
        read_curve(file)


def test_parquet_in_another_unit_or_without_a_column(tmp_path: Path):
    file = write_curve(CURVE, tmp_path / "c.parquet")
    table = pq.read_table(file)
    pq.write_table(table.drop_columns(["force"]), file)
    with pytest.raises(InputError, match=r"\['force'\]: these columns are missing"):
        read_curve(file)
    wrong = table.schema.set(1, table.schema.field("overlap").with_metadata({"unit": "mm"}))
    pq.write_table(table.cast(wrong), file)
    with pytest.raises(InputError, match="overlap in 'mm'"):
        read_curve(file)


@pytest.mark.parametrize("name", ["missing/curve.csv", "missing/curve.parquet"])
def test_no_folder(tmp_path: Path, name: str):
    for action in (lambda: write_curve(CURVE, tmp_path / name), lambda: read_curve(tmp_path / name)):
        with pytest.raises(InputError, match=name):
            action()


def test_another_ending(tmp_path: Path):
    with pytest.raises(InputError, match=r"\.csv or \.parquet"):
        write_curve(CURVE, tmp_path / "curve.xlsx")


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EACCES, errno.EROFS])
def test_a_write_that_fails_leaves_the_old_file_and_no_debris(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int):
    file = write_text(tmp_path / "law.json", "old")

    def refuse(*_: object, **__: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(Path, "write_text", refuse)
    with pytest.raises(InputError, match=os.strerror(code)):
        write_text(file, "new")
    monkeypatch.undo()
    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(InputError, match=os.strerror(code)):
        write_text(file, "new")
    assert [(entry.name, entry.read_text()) for entry in tmp_path.iterdir()] == [("law.json", "old")]
