"""At most one process at a time works on a task, on this machine or on any other that shares the folder.

A claim is a lock on one byte of a file, at a place given by the task's key. The system gives it up by itself when the process that holds it
ends, however it ends; nothing is left behind that would have to be cleaned up.
"""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

fcntl: Any
try:
    import fcntl
except ImportError:  # Windows: two runs at once on one folder may then compute a result twice, and store the same bytes
    fcntl = None

#: file locks take 63-bit offsets
OFFSETS = 2**62


@contextlib.contextmanager
def claimed(folder: Path, key: str) -> Iterator[None]:
    """Wait until nobody else works on the task with this key (hexadecimal), and keep others away meanwhile."""
    if fcntl is None:
        yield
        return
    handle, place = _handle(folder), int(key, 16) % OFFSETS
    try:
        fcntl.lockf(handle, fcntl.LOCK_EX, 1, place)
    except OSError:  # a file system without locks
        yield
        return
    try:
        yield
    finally:
        fcntl.lockf(handle, fcntl.LOCK_UN, 1, place)


@functools.cache
def _handle(folder: Path) -> int:
    """One handle for the life of the process: closing any handle of a file would give up all its locks."""
    return os.open(folder / "tasks" / ".claims", os.O_RDWR | os.O_CREAT, 0o666)
