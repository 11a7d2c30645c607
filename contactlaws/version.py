"""Which code made a result, and on which libraries it ran."""

from __future__ import annotations

import functools
import importlib.metadata
import platform
import sys

from contactlaws.sources import PACKAGES, source_hash

__version__ = "0.1.0"

#: what the numbers go through
LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
_ON = " on "


@functools.cache
def code_version() -> str:
    """Release and hash of the sources, then the libraries, as written into every output.

    Two results whose sources are the same are made by the same code; where the libraries differ they may differ by round-off, so these are
    recorded, but make no result out of date.
    """
    return f"fe2dem {__version__} (sources {source_hash(*PACKAGES)}){_ON}{', '.join(_libraries())}"


def sources_alone(code: str) -> str:
    """A `code_version` without its libraries.

    >>> sources_alone("fe2dem 0.1.0 (sources 0123456789ab) on Python 3.11.7, numpy 2.4.1")
    'fe2dem 0.1.0 (sources 0123456789ab)'
    """
    return code.split(_ON)[0]


def _libraries() -> list[str]:
    versions = [f"{name} {_version(name)}" for name in LIBRARIES]
    return [f"Python {platform.python_version()}", *versions, platform.machine()]


def _version(name: str) -> str:
    if name in sys.modules:  # looking into what is installed takes far longer
        return str(sys.modules[name].__version__)
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "(unknown)"
