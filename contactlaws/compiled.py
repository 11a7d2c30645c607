"""The one decorator that compiles: numba with a disk cache that can never hold an old law.

numba's own cache is keyed by the time stamp of the file a function stands in, so a kernel that calls a law from another file would silently
keep the old law after an edit. Here the cache folder carries a hash of all sources that the kernel can reach (its own package and
`contactlaws`), so an edit leads to an empty folder. Laws defined outside this project are not in that hash: what runs them is never taken
from the disk nor put there, but compiled afresh in each process.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator, Set
from pathlib import Path
from typing import Any

import numba
from numba import types
from numba.core.caching import FunctionCache
from numba.core.registry import cpu_target

from contactlaws.sources import PACKAGES, source_hash


def cache_root() -> Path:
    """The folder for compiled kernels: $FE2DEM_CACHE_DIR, else $XDG_CACHE_HOME/fe2dem, else ~/.cache/fe2dem, else a temporary one."""
    named = os.environ.get("FE2DEM_CACHE_DIR")
    root = Path(named) if named else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fe2dem"
    try:
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root):
            return root
    except OSError:
        return Path(tempfile.gettempdir()) / f"fe2dem-{os.getuid() if hasattr(os, 'getuid') else 'user'}"


@contextlib.contextmanager
def _cache_folder(package: str) -> Iterator[None]:
    """numba reads its cache folder when a function is decorated; put ours there for that moment only."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_root() / f"kernels-{source_hash(*dict.fromkeys(('contactlaws', package)))}")
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def _from_outside(signature: Any) -> bool:
    """Whether a record from outside this project is among the types of a compiled signature."""
    records = (kind.instance_class for kind in getattr(signature, "args", signature) if isinstance(kind, types.BaseNamedTuple))
    return any(record.__module__.split(".")[0] not in PACKAGES for record in records)


class _ProjectCache(FunctionCache):
    """numba's disk cache, closed to laws from outside this project: their sources are in no hash, so what is on disk may be stale.

    Every function on the way down to the law must stay out of the cache, not only the loop: a loop that is compiled afresh would still
    load the stale `pair_force` that it calls.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        return None if _from_outside(sig) else super().load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        if not _from_outside(sig):
            super().save_overload(sig, data)


def kernel(
    function: Callable[..., Any], fastmath: Set[str] = frozenset(), inline: bool = False, parallel: bool = False, within: bool = False
) -> Any:
    """Compile a function of this project: no Python objects, IEEE division, cached on disk under a hash of the sources.

    fastmath: what the compiler may do to sums and products that changes them by round-off, in LLVM's names ("contract", "reassoc", ...).
    inline: whether to make it part of whatever calls it. A record is handed over value by value, which takes longer than a short formula.
    parallel: whether the loops over `numba.prange` run on threads.
    within: whether only other kernels call it. A way in from Python takes longer to compile than a short function.
    """
    compiled = numba.njit(
        error_model="numpy",
        fastmath=set(fastmath),
        forceinline=inline,
        parallel=parallel,
        no_cpython_wrapper=within,
        no_cfunc_wrapper=True,  # nobody asks for one, and it takes as long to compile as the function
    )(function)
    if not numba.config.DISABLE_JIT:
        with _cache_folder(function.__module__.split(".")[0]):
            compiled._cache = _ProjectCache(function)
    return compiled


def inner(function: Callable[..., Any]) -> Any:
    """`kernel` for what only other kernels call."""
    return kernel(function, within=True)


def inlined(function: Callable[..., Any]) -> Any:
    """`kernel` for what every contact of every step goes through: part of whatever calls it."""
    return kernel(function, inline=True)


if not numba.config.DISABLE_JIT:
    # numba puts this off to the first call of a kernel, which then takes half a second more; done here, forked processes share it
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()
