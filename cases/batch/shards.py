"""An index that grows with a run: each process that makes results adds entries to files of its own, and nobody has to wait for another.

DIR/tasks/.index/KIND-HOST-PROCESS    entries of one process
DIR/tasks/.index/KIND-all-ID          entries of several, put together and written at once

An entry is a line: a checksum, and JSON. A process may be killed while it writes, a disk may be full or lose power: a line that is not
whole counts for nothing, and what it would have said is to be found in the result itself. So nothing here is waited for until it is on the
disk, and whoever reads must be able to do without.
"""

from __future__ import annotations

import contextlib
import json
import os
import platform
import uuid
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from contactlaws.errors import InputError
from contactlaws.files import write_atomically

#: bytes that are read, and understood, at once
AT_ONCE = 1 << 20


class Found(NamedTuple):
    """What was read."""

    entries: list[Any]
    files: list[Path]  # they stood in


def add(folder: Path, kind: str, entry: str) -> None:
    """Add an entry (JSON without a line break) to those of this process; what cannot be written is left out."""
    path = place(folder) / f"{kind}-{platform.node()}-{os.getpid()}"
    with contextlib.suppress(OSError):
        path.parent.mkdir(exist_ok=True)
        with path.open("ab", buffering=0) as file:  # one system call; the line begins anew, whatever was cut off before it
            file.write(b"\n" + _line(entry))


def read(folder: Path, kind: str) -> Found:
    """All whole entries of a kind."""
    entries, files = list[Any](), list[Path]()
    for path in sorted(place(folder).glob(f"{kind}-*")):
        with contextlib.suppress(OSError, ValueError), path.open("rb") as file:  # taken away meanwhile; not ours
            while lines := file.readlines(AT_ONCE):
                entries += json.loads(b"[%b]" % b",".join(line[9:-1] for line in lines if _whole(line)))
            files.append(path)
    return Found(entries, files)


def put_together(folder: Path, kind: str, entries: Iterable[str], files: Iterable[Path]) -> None:
    """Write entries in place of `files`, which were read. In a folder that may only be read, all stays as it is.

    An entry that is added to one of them meanwhile is lost: its result will be looked at once more.
    """
    target = place(folder) / f"{kind}-all-{uuid.uuid4().hex[:12]}"
    try:
        target.parent.mkdir(exist_ok=True)
        write_atomically(target, lambda file: file.write_bytes(b"".join(map(_line, entries))))
    except (OSError, InputError):
        return
    for path in files:
        with contextlib.suppress(OSError):
            path.unlink()


def place(folder: Path) -> Path:
    """Where they stand."""
    return folder / "tasks" / ".index"


def _line(entry: str) -> bytes:
    """
    >>> _whole(_line("[1]")), _whole(_line("[1]").rstrip()), _whole(b"\\n")
    (True, False, False)
    """
    content = entry.encode()
    return b"%08x %b\n" % (zlib.crc32(content), content)


def _whole(line: bytes) -> bool:
    return line[:8] == b"%08x" % zlib.crc32(line[9:-1])
