"""Tables of fits: one row per material and law, as Parquet or CSV; read back strictly and without running anything that stands in a
file.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args, get_type_hints

from calibration.fit import Fit
from calibration.residuals import Measures
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text, write_atomically, write_text
from contactlaws.fitted import FORMAT as LAW_FORMAT
from contactlaws.fitted import FittedLaw, from_json, to_json
from contactlaws.json_input import parsed
from contactlaws.material import Material

FORMAT = "fe2dem fit table 1"


@dataclass(frozen=True)
class Row:
    """One fit, without its correlation."""

    fitted: FittedLaw
    residuals: Measures
    condition_number: float
    misfit: float
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class FitTable:
    """Fits in the order they were made."""

    rows: tuple[Row, ...]

    def __post_init__(self) -> None:
        keys = [(row.fitted.name, row.fitted.material, row.fitted.law.radius, tuple(row.fitted.curve_hashes)) for row in self.rows]
        twins = [key for key, times in Counter(keys).items() if times > 1]
        require(Problem("law, material and curves", key, "stand in the table twice", "keep one row for each") for key in twins)


#: unit of each column; texts have none. Parameters and their errors are JSON objects, in SI units
UNITS: Mapping[str, str | None] = {
    "law": None,
    "youngs_modulus": "Pa",
    "poissons_ratio": "1",
    "yield_stress": "Pa",
    "density": "kg/m3",
    "max_overlap": "m",
    "parameters": None,
    "standard_errors": None,
    **{f"residual_{name}": "1" for name in Measures._fields},
    "condition_number": "1",
    "misfit": "1",
    "warnings": None,
    "curve_hashes": None,
    "code_version": None,
}
#: columns that hold JSON
_JSON = ("parameters", "standard_errors", "warnings", "curve_hashes")
_MEASURES = tuple(f"residual_{name}" for name, kind in get_type_hints(Measures).items() if type(None) in get_args(kind))
_OPTIONAL = ("youngs_modulus", "poissons_ratio", "yield_stress", "density", "condition_number", *_MEASURES)


def row_of(fit: Fit) -> Row:
    """The row of a fit."""
    return Row(fit.fitted, fit.residuals, fit.condition_number, fit.misfit, fit.warnings)


def table_of(fits: Iterable[Fit | Row]) -> FitTable:
    """The table of some fits; raises `InputError` if a law comes twice for the same material and curves."""
    return FitTable(tuple(row_of(fit) if isinstance(fit, Fit) else fit for fit in fits))


def write(table: FitTable | Iterable[Fit | Row], path: str | Path) -> Path:
    """Write to .parquet (units in the schema) or .csv; raises `InputError` if that cannot be done, leaving an older file untouched."""
    rows = [_flat(row) for row in (table if isinstance(table, FitTable) else table_of(table)).rows]
    if _suffix(path) == ".parquet":
        return write_atomically(path, lambda file: _write_parquet(rows, file))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(UNITS)
    writer.writerows(
        [["" if value is None else repr(value) if isinstance(value, float) else value for value in row.values()] for row in rows]
    )
    return write_text(path, text.getvalue())


def read(path: str | Path) -> FitTable:
    """Read what `write` wrote; raises `InputError` for unknown or missing columns and damaged values, naming row and column."""
    rows = _read_parquet(Path(path)) if _suffix(path) == ".parquet" else _read_csv(path)
    return FitTable(tuple(_row(row, f"{path} row {number}") for number, row in enumerate(rows, 1)))


def _suffix(path: str | Path) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(Problem(str(path), suffix, "is no kind of table file", "end the name in .csv or .parquet"))
    return suffix


def _flat(row: Row) -> dict[str, Any]:
    law = to_json(row.fitted)
    material = law.pop("material") or dict.fromkeys(Material._fields)
    values = {**law, **material, **{f"residual_{name}": value for name, value in row.residuals._asdict().items()}}
    values |= {"condition_number": row.condition_number if math.isfinite(row.condition_number) else None}
    values |= {"misfit": row.misfit, "warnings": list(row.warnings)}
    return {name: json.dumps(values[name], allow_nan=False) if name in _JSON else values[name] for name in UNITS}


def _row(values: dict[str, Any], place: str) -> Row:
    values = {name: _parsed(name, value, place) for name, value in values.items()}
    missing = [name for name, value in values.items() if value is None and name not in _OPTIONAL]
    require(Problem(f"{place}: {name}", None, "has no value", "write the table again") for name in missing)
    material = {name: values[name] for name in Material._fields}
    content = {name: values[name] for name in ("law", "parameters", "max_overlap", "curve_hashes", "code_version", "standard_errors")}
    known = None if material["youngs_modulus"] is None else material
    fitted = from_json({"format": LAW_FORMAT, "material": known, **content}, place)
    condition = values["condition_number"]
    warnings = values["warnings"]
    if not (isinstance(warnings, list) and all(isinstance(text, str) for text in warnings)):
        raise InputError(Problem(f"{place}: warnings", warnings, "must be a list of texts", "write the table again"))
    residuals = Measures(*(values[f"residual_{name}"] for name in Measures._fields))
    return Row(fitted, residuals, math.inf if condition is None else condition, values["misfit"], tuple(warnings))


def _parsed(name: str, value: Any, place: str) -> Any:
    if value is None or (UNITS[name] is None and name not in _JSON):
        return value
    try:
        if name in _JSON:
            return parsed(value)
        number = float(value)
        if not math.isfinite(number):
            raise ValueError
        return number
    except (TypeError, ValueError) as error:
        raise InputError(Problem(f"{place}: {name}", value, "cannot be understood", "write the table again")) from error


def _problems_with_columns(path: str | Path, names: list[str]) -> Iterator[Problem]:
    for name in names:
        if name not in UNITS or names.count(name) > 1:
            yield Problem(f"{path}: column", name, f"is not known, or stands there twice; columns are {', '.join(UNITS)}", "remove it")
    for name in UNITS:
        if name not in names:
            yield Problem(f"{path}: column {name}", None, "must be there", "write the whole table")


def _read_csv(path: str | Path) -> list[dict[str, Any]]:
    try:
        lines = list(csv.reader(io.StringIO(read_text(path)), strict=True))
    except csv.Error as error:
        remedy = "remove a stray quotation mark; a large tabulated law needs a .parquet table"
        raise InputError(Problem(str(path), str(error), "is no CSV file that can be read", remedy)) from error
    require(_problems_with_columns(path, lines[0] if lines else []))
    for number, cells in enumerate(lines[1:], 1):
        if len(cells) != len(lines[0]):
            raise InputError(Problem(f"{path} row {number}", f"{len(cells)} values", f"must have {len(lines[0])}", "write the table again"))
    return [{name: cell or None for name, cell in zip(lines[0], cells, strict=True)} for cells in lines[1:]]


def _write_parquet(rows: list[dict[str, Any]], file: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [
        pa.field(name, pa.string() if unit is None else pa.float64(), metadata=unit and {"unit": unit}) for name, unit in UNITS.items()
    ]
    pq.write_table(pa.Table.from_pylist(rows, pa.schema(fields, {"format": FORMAT})), file)


def _read_parquet(path: Path) -> list[dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(path).read()
    except OSError as error:
        raise InputError(Problem(str(path), error.strerror or str(error), "cannot be read", "check the name and the permission")) from error
    except pa.ArrowException as error:
        raise InputError(
            Problem(str(path), str(error).splitlines()[0], "is no whole Parquet file", "it may be truncated: write it again")
        ) from error
    if (table.schema.metadata or {}).get(b"format") != FORMAT.encode():
        raise InputError(
            Problem(str(path), table.column_names[:8], f"is Parquet, but no {FORMAT!r}", "write it with calibration.table.write")
        )
    require(_problems_with_columns(path, table.column_names))
    return table.to_pylist()
