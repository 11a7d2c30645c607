"""Results that are made once: a file each, named by what it depends on, and never half written."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cases.batch.sources import meaning_hash
from cases.batch.store import hash_of
from contactlaws.files import write_text


def place(folder: Path, module: str, *values: object) -> Path:
    """Where the result of `module` for these values stands: its name changes with what the sources behind the module do."""
    return folder / f"{module.rsplit('.', 1)[-1]}-{hash_of(values, meaning_hash(module))}.json"


def kept(folder: Path, module: str, values: tuple[object, ...], make: Callable[[], Any]) -> Any:
    """What `make` returns (JSON types), from its file if that is there; a file that cannot be read is made again."""
    path = place(folder, module, *values)
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        folder.mkdir(parents=True, exist_ok=True)
        found = make()
        write_text(path, json.dumps(found) + "\n")
        return found
