"""All records of a folder at once. Where they are many, what was read before is kept in one file: reading 100 000 small ones takes long.

The file is a convenience: what it says of a record counts only while size and time of the record's own file are the same.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from cases.batch.store import Record, record_in
from contactlaws.errors import InputError
from contactlaws.files import write_atomically

FORMAT = "fe2dem records 1"
#: fewer new records are not worth writing the file anew
WORTH = 2000

Stamp = tuple[int, int]  # time in ns, bytes


def all_records(folder: Path) -> dict[str, Record]:
    """The readable records in `folder`, by the names of their files; whether their results are whole is not looked at."""
    with no_garbage():
        return _read(folder)


@contextlib.contextmanager
def no_garbage() -> Iterator[None]:
    """Millions of small objects that all stay: looking for those that don't would take half of the time."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


def _read(folder: Path) -> dict[str, Record]:
    stamps = dict(_stamps(folder))
    known = _known(folder / "tasks" / ".records") if len(stamps) >= WORTH else {}
    records: dict[str, Record] = {}
    new = 0
    for name, stamp in stamps.items():
        before = known.get(name)
        if before is not None and tuple(before[0]) == stamp:
            records[name] = before[1]
            continue
        new += 1
        try:
            with open(f"{folder}/tasks/{name}", "rb") as file:
                records[name] = record_in(file.read())
        except (OSError, ValueError, TypeError):
            continue
    if new >= WORTH:
        _keep(folder / "tasks" / ".records", records, stamps)
    return records


def _stamps(folder: Path) -> Iterator[tuple[str, Stamp]]:
    try:
        with os.scandir(folder / "tasks") as entries:
            for entry in entries:
                if entry.name.endswith(".json"):
                    found = entry.stat()
                    yield entry.name, (found.st_mtime_ns, found.st_size)
    except OSError:
        return


def _known(path: Path) -> dict[str, tuple[Stamp, Record]]:
    """What was kept; nothing if the file is missing, torn, or of another release."""
    try:
        with path.open(encoding="utf-8") as file:
            if json.loads(file.readline()) != FORMAT:
                return {}
            return {name: (stamp, _record(content)) for name, stamp, content in map(json.loads, file)}
    except (OSError, ValueError, TypeError):
        return {}


def _record(content: dict[str, Any]) -> Record:
    content["sizes"] = {name: tuple(size) for name, size in content["sizes"].items()}
    return Record(**content)


def _keep(path: Path, records: dict[str, Record], stamps: dict[str, Stamp]) -> None:
    def write(file: Path) -> None:
        with file.open("w", encoding="utf-8") as out:
            out.write(json.dumps(FORMAT) + "\n")
            out.writelines(json.dumps([name, stamps[name], asdict(record)]) + "\n" for name, record in records.items())

    try:
        write_atomically(path, write)
    except InputError:  # a folder that may only be read
        return
