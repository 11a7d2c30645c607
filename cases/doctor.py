"""What is there and what is missing: Python, packages, gmsh's shared libraries, the cache folder, optional programs and extras."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from typing import NamedTuple

from contactlaws.errors import InputError


class Finding(NamedTuple):
    """One line of the doctor's report."""

    name: str
    state: str  # ok; missing: something needed isn't there; optional: something that may be left out isn't there
    text: str


def examine() -> Iterator[Finding]:
    """Look at everything once."""
    supported = sys.version_info >= (3, 11)
    yield Finding(
        "python",
        "ok" if supported else "missing",
        f"{platform.python_version()} at {sys.executable}" + ("" if supported else "; 3.11 or newer is needed"),
    )
    yield Finding("cores", "ok", f"{_cores()} usable by this process")
    yield from _packages()
    yield _gmsh()
    yield from _cache()
    yield _program("ccx", "CalculiX, for the side-by-side benchmark; Debian: apt-get install calculix-ccx")
    yield from _extras()
    yield _lammps()


def _lammps() -> Finding:
    """Whether the engine loads, and how to start it; one that is installed may still lack its MPI."""
    from dem.lammps_library import launcher, library

    try:
        library()
    except InputError as error:
        problem = error.problems[0]
        return Finding("engine lammps", "optional", f"{problem.bound}; {problem.remedy}")
    start = "fe2dem simulate SCENE.toml --law LAW.json --engine lammps"
    more = f"--ranks N (by {launcher()})" if launcher() else "one rank only: no mpiexec of its MPI was found; pip install mpich"
    return Finding("engine lammps", "ok", f"{_version('lammps')}; {start}, {more}")


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _requirements() -> list[str]:
    try:
        return importlib.metadata.requires("fe2dem") or []
    except importlib.metadata.PackageNotFoundError:
        return []


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _name(requirement: str) -> str:
    return re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0]


def _packages() -> Iterator[Finding]:
    needed = [_name(item) for item in _requirements() if "extra ==" not in item]
    if not needed:
        yield Finding("packages", "missing", "fe2dem itself is not installed; run `make test`, or `pip install -e .`")
    for name in needed:
        version = _version(name)
        if name != "gmsh":
            yield Finding(name, "ok" if version else "missing", version or f"pip install {name}")


def _gmsh() -> Finding:
    """gmsh may be installed and yet not load: its wheel needs shared libraries of the desktop."""
    from fem.profile import load_gmsh

    try:
        load_gmsh()
    except InputError as error:
        problem = error.problems[0]
        return Finding("gmsh", "optional", f"{problem.bound}; {problem.remedy}")
    return Finding("gmsh", "ok", f"{_version('gmsh')}; meshes any meridian profile")


def _cache() -> Iterator[Finding]:
    from contactlaws.compiled import cache_root

    folder = cache_root()
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / 1e6 if folder.is_dir() else 0.0
    yield Finding("kernel cache", "ok", f"{folder} ({size:.0f} MB; may be deleted at any time)")


def _program(name: str, purpose: str) -> Finding:
    found = shutil.which(name)
    return Finding(name, "ok" if found else "optional", found or f"not found: {purpose}")


def _extras() -> Iterator[Finding]:
    members: dict[str, list[str]] = {}
    for item in _requirements():
        marker = re.search(r"extra == ['\"]([\w-]+)['\"]", item)
        if marker:
            members.setdefault(marker.group(1), []).append(_name(item))
    for extra, names in members.items():
        missing = [name for name in names if _version(name) is None]
        text = f"not installed: {', '.join(missing)}; pip install 'fe2dem[{extra}]'" if missing else ", ".join(names)
        yield Finding(f"extra {extra}", "optional" if missing else "ok", text)
