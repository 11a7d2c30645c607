"""For a Dask scheduler that must not outlive who started it, also if that one is killed: its workers end with it.

FE2DEM_PARENT=PROCESS dask scheduler --preload cases.verification.ends_with_parent
"""

from __future__ import annotations

import os
import threading
import time
from typing import Any

PARENT = "FE2DEM_PARENT"
#: s between two looks
EVERY = 0.5


def dask_setup(server: Any) -> None:
    """What Dask calls in a process that is started with --preload."""
    threading.Thread(target=_watch, args=(int(os.environ[PARENT]),), daemon=True).start()


def _watch(parent: int) -> None:
    """A process whose parent is gone gets another."""
    while os.getppid() == parent:
        time.sleep(EVERY)
    os._exit(1)
