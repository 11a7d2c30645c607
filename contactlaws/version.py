"""Which code made a result."""

from __future__ import annotations

from contactlaws.sources import PACKAGES, source_hash

__version__ = "0.1.0"


def code_version() -> str:
    """Release and hash of the sources, as written into every output: two results with the same string come from the same code."""
    return f"fe2dem {__version__} (sources {source_hash(*PACKAGES)})"
