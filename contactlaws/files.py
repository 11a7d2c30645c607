"""Reading and writing whole files: a file on disk is either the old one or the new one, never half of it."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from contactlaws.errors import InputError, Problem


def write_atomically(path: str | Path, write: Callable[[Path], object]) -> Path:
    """Let `write` fill a temporary file beside `path`, bring it to the disk, then rename it: a power cut, too, leaves no half of it.

    Raises `InputError` where the system refuses (no permission, no such folder, disk full); then `path` is as it was and nothing is left
    behind.
    """
    target = Path(path)
    temporary = None
    try:
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
        os.close(handle)
        temporary = Path(name)
        write(temporary)
        temporary.chmod(0o666 & ~_umask())
        _to_disk(temporary)
        os.replace(temporary, target)
    except OSError as error:
        raise InputError(Problem(str(target), error.strerror or str(error), "cannot be written", _remedy(error))) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
    return target


def write_text(path: str | Path, text: str) -> Path:
    """`write_atomically` for text in UTF-8."""
    return write_atomically(path, lambda file: file.write_text(text, encoding="utf-8"))


def read_text(path: str | Path) -> str:
    """The text of a UTF-8 file, without a byte order mark; raises `InputError` where there is none to be had."""
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(Problem(str(path), error.strerror or str(error), "cannot be read", _remedy(error))) from error
    except UnicodeDecodeError as error:
        raise InputError(
            Problem(str(path), f"byte {error.start}", "is no text in UTF-8", "give a text file, or save it as UTF-8")
        ) from error


def _to_disk(path: Path) -> None:
    """A rename may reach the disk before what was written; this waits for the content."""
    with path.open("rb") as file:
        os.fsync(file.fileno())


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _remedy(error: OSError) -> str:
    if isinstance(error, FileNotFoundError):
        return "check the name, and that its folder exists"
    if isinstance(error, PermissionError):
        return "choose a place you have the permission for"
    return "check the place and the free space on its disk"
