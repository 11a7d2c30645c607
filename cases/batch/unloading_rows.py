"""The table of unloadings. Whoever makes a curve notes its rows: to read them off 100 000 curves would take minutes.

The notes are a convenience: rows count only while the curve's file is the one that they were read off, and the code that reads is the same.
They are the text of the CSV table, which is then no more than put together, and read back for Parquet (floats keep every bit).
"""

from __future__ import annotations

import contextlib
import functools
import io
import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from cases.batch import shards
from cases.batch.sources import meaning_hash
from cases.batch.store import Record
from contactlaws.files import write_atomically
from contactlaws.unloading_table import csv_header, csv_text, schema

KIND = "unloadings"
#: fewer curves that no note is of are not worth to be noted anew
WORTH = 500
#: curves whose rows are written at once
AT_ONCE = 10_000

Name = tuple[str, str, str]  # what rows depend on: key of the curve, hash of its file, hash of the code that reads


def note(folder: Path, record: Record) -> None:
    """Note the rows of a curve that has just been saved; of anything else, and of a curve that cannot be read, there is nothing to note."""
    if record.usable and "curve" in record.files:
        with contextlib.suppress(Exception):  # it comes again, and is told, when the table is made
            shards.add(folder, KIND, noted(record, text_of(folder, record)))


def noted(record: Record, text: str) -> str:
    """What is noted of a curve."""
    return json.dumps([*_name(record), text])


def text_of(folder: Path, record: Record) -> str:
    """The lines of a curve in the table, read off its file."""
    from calibration.unloadings import table_rows  # not above: much is loaded for it, and where rows are noted it is not needed
    from contactlaws.curve_files import read_curve

    return csv_text(list(table_rows([read_curve(folder / record.files["curve"])])))


def write(folder: Path, records: Iterable[Record], stem: str) -> list[Path]:
    """Write one row per unloading of these curves, in their order, to `folder`/`stem`.csv and .parquet."""
    texts = _texts(folder, records)
    return [
        write_atomically(folder / f"{stem}.csv", lambda file: _write_csv(texts, file)),
        write_atomically(folder / f"{stem}.parquet", lambda file: _write_parquet(texts, file)),
    ]


def _texts(folder: Path, records: Iterable[Record]) -> list[str]:
    """The lines of each curve; of a curve under two names once."""
    notes = shards.read(folder, KIND)
    known = _believed(notes.entries)
    new, found = dict[Name, str](), dict[Name, str]()
    for record in records:
        name = _name(record)
        text = known.get(name)
        if text is None:
            text = new[name] = text_of(folder, record)
        found[name] = text
    if len(new) >= WORTH:
        shards.put_together(folder, KIND, (json.dumps([*name, text]) for name, text in {**known, **new}.items()), notes.files)
    return list(found.values())


def _name(record: Record) -> Name:
    return record.key, record.sizes["curve"][1], _code()


@functools.cache
def _code() -> str:
    """Of all code that reads and writes rows."""
    return f"{meaning_hash('calibration.unloadings')} {meaning_hash('contactlaws.unloading_table')}"


def _believed(entries: Iterable[Any]) -> dict[Name, str]:
    """The rows that notes tell of, of any curve, but of this code alone."""
    found, code = dict[Name, str](), _code()
    for entry in entries:
        try:
            key, content, by, text = entry
            if by == code and isinstance(text, str):
                found[key, content, by] = text
        except (ValueError, TypeError):
            continue
    return found


def _parts(texts: Sequence[str]) -> Iterator[bytes]:
    """Tables of some of the curves each: the whole may be larger than one likes to have in memory twice."""
    for start in range(0, len(texts), AT_ONCE):
        yield "".join(texts[start : start + AT_ONCE]).encode()


def _write_csv(texts: Sequence[str], file: Path) -> None:
    with file.open("wb") as out:
        out.write(csv_header().encode())
        out.writelines(_parts(texts))


def _write_parquet(texts: Sequence[str], file: Path) -> None:
    """The CSV table as Parquet: an empty cell is what the curve does not say."""
    import pyarrow.parquet as pq
    from pyarrow import csv

    columns: Any = schema()
    types = {field.name: field.type for field in columns}
    parsing = csv.ParseOptions(newlines_in_values=True)
    options = csv.ConvertOptions(
        column_types=types, null_values=[""], strings_can_be_null=True, true_values=["True"], false_values=["False"]
    )
    with pq.ParquetWriter(file, columns) as out:
        for part in _parts(texts):
            lines = io.BytesIO(csv_header().encode() + part)
            out.write_table(csv.read_csv(lines, convert_options=options, parse_options=parsing).cast(columns))
