"""The table of unloadings. Its rows are kept beside the records: to read them off 100 000 curves again would take minutes.

The file is a convenience: rows count only while the curve's file is the one that they were read off, and the code that reads is the same.
They are kept as the text of the CSV table, which is then no more than put together, and read back for Parquet (floats keep every bit).
"""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cases.batch.sources import meaning_hash
from cases.batch.store import Record
from contactlaws.errors import InputError
from contactlaws.files import write_atomically, write_text

PLACE = "tasks/.unloadings"
#: fewer new curves are not worth writing the file anew
WORTH = 500


def write(folder: Path, records: Iterable[Record], stem: str) -> list[Path]:
    """Write one row per unloading of these curves, in their order, to `folder`/`stem`.csv and .parquet."""
    from calibration.unloadings import csv_header

    text = csv_header() + "".join(_texts(folder, records))
    table = write_atomically(folder / f"{stem}.parquet", lambda file: _write_parquet(text, file))
    return [write_text(folder / f"{stem}.csv", text), table]


def _texts(folder: Path, records: Iterable[Record]) -> list[str]:
    """The lines of each curve."""
    from calibration.unloadings import csv_text, table_rows
    from contactlaws.curve_files import read_curve

    known, found, new = _known(folder), dict[str, str](), 0
    for record in records:
        name = f"{record.key} {record.sizes['curve'][1]}"
        text = known.get(name)
        if text is None:
            text = csv_text(list(table_rows([read_curve(folder / record.files["curve"])])))
            new += 1
        found[name] = text
    if new >= WORTH:
        _keep(folder, found)
    return list(found.values())


def _head() -> list[str]:
    return ["fe2dem unloadings of curves 2", meaning_hash("calibration.unloadings")]


def _known(folder: Path) -> dict[str, str]:
    """What was kept; nothing if the file is missing, torn, or made by other code."""
    try:
        with (folder / PLACE).open(encoding="utf-8") as file:
            return {} if json.loads(file.readline()) != _head() else dict(map(json.loads, file))
    except (OSError, ValueError, TypeError):
        return {}


def _keep(folder: Path, found: dict[str, str]) -> None:
    def write_lines(file: Path) -> None:
        with file.open("w", encoding="utf-8") as out:
            out.write(json.dumps(_head()) + "\n")
            out.writelines(json.dumps(item) + "\n" for item in found.items())

    with contextlib.suppress(InputError):  # a folder that may only be read
        write_atomically(folder / PLACE, write_lines)


def _write_parquet(text: str, file: Path) -> None:
    """The CSV table as Parquet: an empty cell is what the curve does not say."""
    import pyarrow.parquet as pq
    from pyarrow import csv

    from calibration.unloadings import schema

    columns: Any = schema()
    types = {field.name: field.type for field in columns}
    options = csv.ConvertOptions(
        column_types=types, null_values=[""], strings_can_be_null=True, true_values=["True"], false_values=["False"]
    )
    table = csv.read_csv(io.BytesIO(text.encode()), convert_options=options, parse_options=csv.ParseOptions(newlines_in_values=True))
    pq.write_table(table.cast(columns), file)
