"""The rows of the table of unloadings. They are kept beside the records: to read them off 100 000 curves again would take minutes.

The file is a convenience: a row counts only while the curve's file is the one that it was read off, and the code that reads is the same.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from cases.batch.sources import meaning_hash
from cases.batch.store import Record
from contactlaws.errors import InputError
from contactlaws.files import write_atomically

Row = dict[str, Any]

PLACE = "tasks/.unloadings"
#: fewer new curves are not worth writing the file anew
WORTH = 500


def rows_of(folder: Path, records: Iterable[Record]) -> list[Row]:
    """One row per unloading of these curves, as `calibration.unloadings.table_rows` gives them, in their order."""
    from calibration.unloadings import table_rows
    from contactlaws.curve_files import read_curve

    known, found, new = _known(folder), dict[str, list[Row]](), 0
    for record in records:
        name = f"{record.key} {record.sizes['curve'][1]}"
        if name not in known:
            known[name] = list(table_rows([read_curve(folder / record.files["curve"])]))
            new += 1
        found[name] = known[name]
    if new >= WORTH:
        _keep(folder, found)
    return [row for rows in found.values() for row in rows]


def _head() -> list[str]:
    return ["fe2dem unloadings of curves 1", meaning_hash("calibration.unloadings")]


def _known(folder: Path) -> dict[str, list[Row]]:
    """What was kept; nothing if the file is missing, torn, or made by other code."""
    try:
        with (folder / PLACE).open(encoding="utf-8") as file:
            if json.loads(file.readline()) != _head():
                return {}
            names: Sequence[str] = json.loads(file.readline())
            return {key: [dict(zip(names, row, strict=True)) for row in rows] for key, rows in map(json.loads, file)}
    except (OSError, ValueError, TypeError):
        return {}


def _keep(folder: Path, found: dict[str, list[Row]]) -> None:
    names = next((list(rows[0]) for rows in found.values() if rows), [])

    def write(file: Path) -> None:
        with file.open("w", encoding="utf-8") as out:
            out.write(json.dumps(_head()) + "\n" + json.dumps(names) + "\n")
            out.writelines(json.dumps([key, [list(row.values()) for row in rows]]) + "\n" for key, rows in found.items())

    with contextlib.suppress(InputError):  # a folder that may only be read
        write_atomically(folder / PLACE, write)
