"""The sources of this project, and their hash."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("contactlaws", "fem", "calibration", "dem", "cases")


@functools.cache
def source_hash(*packages: str) -> str:
    """Twelve hexadecimal digits that change with any edit of a Python file in `packages`."""
    digest = hashlib.sha256()
    for package in packages:
        for file in sorted((ROOT / package).rglob("*.py")):
            digest.update(f"{file.relative_to(ROOT)}\0".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:12]
