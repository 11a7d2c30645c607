"""A table of unloadings on disk, CSV or Parquet: columns, units, format. `calibration.unloadings` makes its rows."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from contactlaws.curve import QUANTITIES
from contactlaws.errors import InputError, Problem
from contactlaws.files import write_atomically, write_text
from contactlaws.version import code_version

FORMAT = "fe2dem unloadings 1"
#: columns of the table and their units; texts and counts have none, "1" is a ratio
UNITS: Mapping[str, str | None] = {
    "curve": None,
    "youngs_modulus": "Pa",
    "poissons_ratio": "1",
    "yield_stress": "Pa",
    "modulus_over_yield_stress": "1",
    "radius": "m",
    "aspect": "1",
    "yield_overlap": "m",
    "yield_place_r": "m",
    "yield_place_z": "m",
    "branch": None,
    "overlap": "m",
    "overlap_over_radius": "1",
    "separation_overlap": "m",
    "force": "N",
    "contact_radius": "m",
    "stiffness": "1",
    "exponent": "1",
    "exponent_r2": "1",
    "recovered_energy": "J",
    "stored_energy": "J",
    "dissipated_energy": "J",
    "dissipated_on_unloading": "J",
    "plastic": None,
    **{f"error_{name}": "1" for name in QUANTITIES},
    "stopped": None,
}
_TYPES = {"curve": "string", "branch": "int64", "plastic": "bool_", "stopped": "string"}


def heading(column: str) -> str:
    """The name of a column in a file: with its unit, unless that is 1.

    >>> heading("force"), heading("stiffness")
    ('force_N', 'stiffness')
    """
    unit = UNITS[column]
    return column if unit in (None, "1") else f"{column}_{unit}"


def write_table(rows: Sequence[Mapping[str, Any]], path: str | Path) -> Path:
    """Write `table_rows` to .parquet or .csv; both carry the unit in the column's name, Parquet in its schema as well.

    Raises `InputError` for another ending or if the file cannot be written; a file that was there is then untouched.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".parquet":
        return write_atomically(path, lambda file: _write_parquet(rows, file))
    if suffix != ".csv":
        raise InputError(Problem(str(path), suffix, "is no kind of table file", "end the name in .csv or .parquet"))
    return write_text(path, csv_header() + csv_text(rows))


def csv_header() -> str:
    """The first line of a table as CSV."""
    return ",".join(map(heading, UNITS)) + "\n"


def csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """The lines of `table_rows` in a table as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(["" if row[name] is None else row[name] for name in UNITS] for row in rows)
    return text.getvalue()


def schema() -> Any:
    """The columns of a table as Parquet: types, units, format and code version."""
    import pyarrow as pa

    fields = [
        pa.field(heading(name), getattr(pa, _TYPES.get(name, "float64"))(), metadata=unit and {"unit": unit})
        for name, unit in UNITS.items()
    ]
    return pa.schema(fields, {"format": FORMAT, "code": code_version()})


def _write_parquet(rows: Sequence[Mapping[str, Any]], file: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = [pa.array([row[name] for row in rows], field.type) for name, field in zip(UNITS, schema(), strict=True)]
    pq.write_table(pa.table(columns, schema=schema()), file)
