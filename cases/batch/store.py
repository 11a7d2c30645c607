"""A folder of results: one record per task, named by the hash of all that it depends on, and never half written.

DIR/case.json               what the last run wanted: title, where the case file is, and the tasks in their order
DIR/tasks/KIND-KEY.json     one record per task; it appears last, when the files that it names are complete and on the disk
DIR/tasks/.index/           what the records say, and rows of tables, noted once more so that many are read fast (`cases.batch.shards`)
DIR/curves/, fits/, ...     the files themselves, with the same KEY in their names

A record holds size and hash of each of its files: what a power cut or a full disk has left torn is found, and made again.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from cases.batch import shards
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import write_atomically, write_text

NOTES = "records"  # the kind of shards that tell of records
FINISHED = ("done", "stopped")  # states whose results can be used
#: bytes that a run takes at least; a curve with 14 unloadings takes about 35 kB, and files come in blocks of 4 kB
SPACE = {"curves": 60_000, "fits": 16_000}


Stamp = tuple[int, int]  # of a file: time in ns, bytes


@dataclass(frozen=True)
class Record:
    """What became of one task."""

    task: str  # KIND.NAME
    key: str  # hash of input, sources and what it was made from
    state: str  # done; stopped: ended early, kept up to there; failed
    reason: str | None = None  # why it stopped or failed
    passing: bool = False  # failed for a cause outside the input (memory, disk, a killed process): the next run tries again
    cpu_seconds: float = 0.0
    wall_seconds: float = 0.0
    code: str = ""  # release, source hash and libraries that made it
    input: str = ""  # hash of the input alone: with another key, the same result by other sources
    files: Mapping[str, str] = field(default_factory=dict)  # what it wrote: paths relative to the folder
    sizes: Mapping[str, tuple[int, str]] = field(default_factory=dict)  # bytes and hash of each of them
    summary: Mapping[str, Any] = field(default_factory=dict)  # numbers for tables and report; JSON types

    @property
    def kind(self) -> str:
        """One of `cases.batch.task.KINDS`."""
        return self.task.split(".", 1)[0]

    @property
    def name(self) -> str:
        """The name that the case file gives it."""
        return self.task.split(".", 1)[1]

    @property
    def usable(self) -> bool:
        """Whether others may be made from it."""
        return self.state in FINISHED


def hash_of(*parts: object) -> str:
    """Sixteen hexadecimal digits of JSON-like values, independent of the order of keys."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:16]


def record_path(folder: Path, task: str, key: str) -> Path:
    """Where the record of a task stands: whatever the task is called, the same result is found again."""
    return folder / "tasks" / record_name(task, key)


def record_name(task: str, key: str) -> str:
    """The name of the record's file there."""
    return f"{task.split('.', 1)[0]}-{key}.json"


def save(folder: Path, record: Record) -> Record:
    """Make a record known, once its files are on the disk, and note what it says; returns it with their sizes and hashes."""
    whole = replace(record, sizes={name: _size_and_hash(folder / file) for name, file in record.files.items()})
    path = record_path(folder, record.task, record.key)
    path.parent.mkdir(parents=True, exist_ok=True)
    text, stamps = json.dumps(asdict(whole), default=plain), list[Stamp]()

    def write(file: Path) -> None:
        file.write_text(f"{text}\n", encoding="utf-8")
        stamps.append(stamp(file.stat()))  # of this very file: at the record's own place another process may put its own meanwhile

    write_atomically(path, write)
    _sync_folder(path.parent)
    shards.add(folder, NOTES, noted(path.name, stamps[0], text))
    return whole


def stamp(found: os.stat_result) -> Stamp:
    """What tells a file from another that has taken its place since."""
    return found.st_mtime_ns, found.st_size


def noted(name: str, of: Stamp, text: str) -> str:
    """What is noted of a record: the name of its file, its stamp, and its JSON text."""
    return f'["{name}", {of[0]}, {of[1]}, {text}]'


def load(folder: Path, task: str, key: str, verify: bool = False) -> Record | None:
    """The record of a task if it is there, readable, and all its files are whole; None means the task is to be done.

    Files are whole if they have the size that they were written with and, with `verify`, the same bytes. The record comes under the name
    of the task that asks for it, which may have been another one when it was made.
    """
    try:
        record = record_in(record_path(folder, task, key).read_bytes())
    except (OSError, ValueError, TypeError):
        return None
    if record.key != key or not is_whole(folder, record, verify):
        return None
    return record if record.task == task else replace(record, task=task)


def is_whole(folder: Path, record: Record, verify: bool = False) -> bool:
    """Whether all files of a record are there with the size that they were written with and, with `verify`, the same bytes."""
    try:
        for name, file in record.files.items():
            path, size = f"{folder}/{file}", record.sizes[name]
            if _size_and_hash(Path(path)) != size if verify else _bytes_in(path) != size[0]:
                return False
    except OSError:
        return False
    return True


def record_in(text: bytes | str) -> Record:
    """A record from its JSON text; raises `ValueError` or `TypeError` if it is none, or torn."""
    return record_of(json.loads(text))


def record_of(content: Any) -> Record:
    """`record_in` for what the JSON says; `content` becomes the record's own."""
    if not isinstance(content, dict):
        raise ValueError("is no record")
    sizes, files = content.get("sizes", {}), content.get("files", {})
    if not isinstance(sizes, dict) or not isinstance(files, dict) or sizes.keys() != files.keys():
        raise ValueError("does not say how large its files are")
    content["sizes"] = {name: tuple(size) for name, size in sizes.items()}
    return Record(**content)


def _bytes_in(path: str) -> int:
    """Size of a file, or of all files in a folder."""
    found = os.stat(path)
    return sum(file.stat().st_size for file in _files(Path(path))) if stat.S_ISDIR(found.st_mode) else found.st_size


def _size_and_hash(path: Path) -> tuple[int, str]:
    digest, size = hashlib.sha256(), 0
    for file in _files(path) if path.is_dir() else (path,):
        content = file.read_bytes()
        digest.update(f"{file.relative_to(path.parent).as_posix()}\0".encode() + content)
        size += len(content)
    return size, digest.hexdigest()[:16]


def _files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.rglob("*") if file.is_file())


def _sync_folder(folder: Path) -> None:
    """The name of a new file is on the disk only when its folder is. Where this brings no others along, their loss is found."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def prepare(folder: Path, kinds: Mapping[str, int] | None = None) -> None:
    """Create the folder and try to write there; raises `InputError` before any computing if that cannot be done.

    kinds: how many results of each kind are still to be made, where it is known: the disk must have space for them.
    """
    require(problem._replace(value=str(folder)) for problem in problems_with_folder("--out", folder / "tasks"))
    needed = sum(SPACE.get(kind, 8_000) * number for kind, number in (kinds or {}).items())
    free = shutil.disk_usage(folder).free
    if needed > free:
        bound = f"has {free / 1e9:.3g} GB free, and {sum((kinds or {}).values()):,} results take {needed / 1e9:.3g} GB or more"
        raise InputError(Problem("--out", str(folder), bound, "choose another disk, free some space, or split the study"))


def problems_with_folder(name: str, folder: Path) -> Iterator[Problem]:
    """Create a folder if it isn't there, and try to write into it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        yield Problem(name, str(folder), f"cannot be created ({error.strerror})", "choose another folder")
        return
    yield from problems_with_writing(name, folder)


def problems_with_writing(name: str, folder: Path) -> Iterator[Problem]:
    """Try to write a little into an existing folder: permission and space are only known by trying."""
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"\0" * 65536)
            file.flush()
    except OSError as error:
        yield Problem(name, str(folder), f"cannot be written ({error.strerror})", "choose another place, or free some space")


def write_json(path: Path, value: object) -> None:
    """JSON by atomic rename."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(value, default=plain) + "\n")


def plain(value: Any) -> Any:
    """numpy's numbers and arrays as JSON has them."""
    return value.tolist() if hasattr(value, "tolist") else str(value)
