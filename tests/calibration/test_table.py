"""Tables of fits: every bit comes back, unknown columns are errors."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import calibration
from calibration import table
from contactlaws.errors import InputError
from tests.contactlaws.samples import NMC, SAMPLES, curve_of

LAW, DEEPEST = SAMPLES["thornton"][0]
CURVE = curve_of(LAW, DEEPEST, material=NMC, yield_overlap=8e-8)
FITS = table.table_of([calibration.fit(CURVE, "thornton"), calibration.fit(CURVE, "hertz")])


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_every_bit_comes_back(tmp_path: Path, ending: str):
    assert table.read(table.write(FITS, tmp_path / f"fits.{ending}")) == FITS


def test_parquet_carries_units(tmp_path: Path):
    schema = pq.read_schema(table.write(FITS, tmp_path / "fits.parquet"))
    assert schema.field("youngs_modulus").metadata == {b"unit": b"Pa"}


def test_unknown_and_missing_columns_are_errors(tmp_path: Path):
    file = table.write(FITS, tmp_path / "fits.parquet")
    content = pq.read_table(file)
    pq.write_table(content.append_column("colour", pa.array(["red", "blue"])), file)
    with pytest.raises(InputError, match="'colour': is not known"):
        table.read(file)
    pq.write_table(content.drop_columns(["misfit"]), file)
    with pytest.raises(InputError, match="column misfit missing"):
        table.read(file)
    text = table.write(FITS, tmp_path / "fits.csv").read_text()
    (tmp_path / "fits.csv").write_text(text.replace("misfit", "mis_fit", 1))
    with pytest.raises(InputError, match="'mis_fit'"):
        table.read(tmp_path / "fits.csv")


def test_damaged_files_are_errors(tmp_path: Path):
    file = table.write(FITS, tmp_path / "fits.parquet")
    file.write_bytes(file.read_bytes()[:-9])
    with pytest.raises(InputError, match="no whole Parquet file"):
        table.read(file)
    text = table.write(FITS, tmp_path / "fits.csv").read_text()
    (tmp_path / "fits.csv").write_text(text.replace('{""radius""', '{""radus""', 1))
    with pytest.raises(InputError, match=r"row 1: parameters: radius missing"):
        table.read(tmp_path / "fits.csv")


def test_a_law_and_material_stand_there_once():
    with pytest.raises(InputError, match="twice"):
        table.table_of([*FITS.rows, FITS.rows[0]])
