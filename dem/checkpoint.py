"""A run on disk: one .npz of plain arrays, written beside and moved into place, so that a kill at any moment leaves a whole file."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from contactlaws.errors import InputError, Problem
from contactlaws.files import write_atomically


def writable_problems(path: Path) -> Iterator[Problem]:
    """What keeps a file from being written at `path`."""
    if path.is_dir():
        yield Problem("path", str(path), "is a folder", "name a file in it")
    elif not path.parent.is_dir():
        yield Problem("path", str(path), f"the folder {path.parent} does not exist", "create it first")
    elif not os.access(path.parent, os.W_OK):
        yield Problem("path", str(path), f"no permission to write into {path.parent}", "choose another folder")


def save(path: Path, identity: dict[str, str], numbers: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    """Write arrays, `numbers` (JSON types; floats survive to the last bit) and whose they are."""
    text = np.frombuffer(json.dumps({"identity": identity, "numbers": numbers}).encode(), dtype=np.uint8)

    def write(place: Path) -> None:
        with place.open("wb") as file:  # given a name, savez would add an ending to it
            np.savez(file, allow_pickle=False, header=text, **arrays)  # type: ignore[arg-type]

    write_atomically(path, write)


def load(path: Path, identity: dict[str, str]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """What `save` wrote; raises `InputError` if the file is damaged or belongs to something else."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        header = json.loads(arrays.pop("header").tobytes())
        found, numbers = header["identity"], header["numbers"]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(Problem("checkpoint", str(path), f"cannot be read ({error})", "delete it to start from the beginning")) from error
    for name, wanted in identity.items():
        if found.get(name) != wanted:
            remedy = f"delete {path} to start from the beginning"
            raise InputError(Problem(f"checkpoint {name}", found.get(name), f"this run has {wanted}", remedy))
    return numbers, arrays
