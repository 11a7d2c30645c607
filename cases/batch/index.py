"""All records of a folder at once: where they are many, what was noted of them when they were saved is read in place of their files.

The notes are a convenience: what one says of a record counts only while size and time of the record's own file are the same.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from cases.batch import shards, store
from cases.batch.store import Record, Stamp

#: fewer are read one by one, and fewer that there is no note of are not worth to be noted anew
WORTH = 2000


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
    notes = shards.read(folder, store.NOTES) if len(stamps) >= WORTH else shards.Found([], [])
    records = dict(_believed(notes.entries, stamps))
    believed = len(records)
    records.update(_one_by_one(folder, [name for name in stamps if name not in records]))
    if len(records) - believed >= WORTH:
        texts = (store.noted(name, stamps[name], json.dumps(vars(record))) for name, record in records.items())
        shards.put_together(folder, store.NOTES, texts, notes.files)
    return records


def _stamps(folder: Path) -> Iterator[tuple[str, Stamp]]:
    try:
        with os.scandir(folder / "tasks") as entries:
            yield from ((entry.name, store.stamp(entry.stat())) for entry in entries if entry.name.endswith(".json"))
    except OSError:
        return


def _believed(entries: Iterable[Any], stamps: Mapping[str, Stamp]) -> Iterator[tuple[str, Record]]:
    """What notes say of the files that are there; a note of another release may say what is no record here."""
    for entry in entries:
        try:
            name, time, size, content = entry
            if stamps.get(name) == (time, size) and _named(record := store.record_of(content), name):
                yield name, record
        except (ValueError, TypeError, AttributeError):
            continue


def _one_by_one(folder: Path, names: Iterable[str]) -> Iterator[tuple[str, Record]]:
    for name in names:
        try:
            with open(f"{folder}/tasks/{name}", "rb") as file:
                if _named(record := store.record_in(file.read()), name):
                    yield name, record
        except (OSError, ValueError, TypeError, AttributeError):
            continue


def _named(record: Record, name: str) -> bool:
    """Whether a record is what the name of its file says."""
    return store.record_name(record.task, record.key) == name
