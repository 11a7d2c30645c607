"""An edit of a law must reach every kernel: the disk cache never runs an old one. Each step is a process of its own, as users have it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from contactlaws.sources import PACKAGES, ROOT

OWN = """
from contactlaws.elastic import Hertz
from contactlaws.path import trace
print(repr(float(trace(Hertz(1.0, 0.75), [0.01]).force[0])))
"""

USERS_LAW = """
from typing import NamedTuple
import numba
from contactlaws.dispatch import Law, register

class Spring(NamedTuple):
    radius: float

@numba.njit(error_model="numpy")
def force(law, overlap, rate, dt, state):
    return 2.0 * overlap, state

@numba.njit
def contact_radius(law, overlap, state):
    return 0.0

@numba.njit
def energy(law, overlap, state):
    return overlap * overlap, 0.0

@numba.njit
def stiffness_bound(law, overlap):
    return 2.0

register(Law("spring", Spring, force, contact_radius, energy, stiffness_bound, (), "the user"))
"""

USERS = """
from contactlaws import path
from my_law import Spring
law = Spring(1.0)
print(repr(float(path.trace(law, [0.01]).force[0])))
"""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def run(script: str, folder: Path) -> float:
    environment = {**os.environ, "PYTHONPATH": str(folder), "FE2DEM_CACHE_DIR": str(folder / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, "-P", "-c", script], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return float(done.stdout)


def edit(file: Path, old: str, new: str) -> None:
    """Same length and same time stamp: the worst case for a cache that looks at either."""
    stamp = file.stat()
    text = file.read_text()
    assert text.count(old) >= 1
    assert len(old) == len(new)
    file.write_text(text.replace(old, new))
    os.utime(file, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


@pytest.mark.compiled_only(reason="without compiled code there is no cache")
def test_an_edit_of_a_law_of_the_project_is_seen(copy: Path):
    assert run(OWN, copy) == pytest.approx(1e-3)  # 4/3 * 0.75 * 0.01^1.5
    kernels = {file: file.stat().st_mtime_ns for file in (copy / "cache").rglob("*.nbc")}
    assert kernels
    assert run(OWN, copy) == pytest.approx(1e-3)
    assert {file: file.stat().st_mtime_ns for file in (copy / "cache").rglob("*.nbc")} == kernels  # nothing was compiled anew
    edit(copy / "contactlaws" / "elastic.py", "return 4.0 / 3.0 * law.reduced_modulus * math.sqrt(law.radius * overlap)",
         "return 8.0 / 3.0 * law.reduced_modulus * math.sqrt(law.radius * overlap)")  # fmt: skip
    assert run(OWN, copy) == pytest.approx(2e-3)


@pytest.mark.compiled_only(reason="without compiled code there is no cache")
def test_an_edit_of_a_users_law_is_seen(copy: Path):
    file = copy / "my_law.py"
    file.write_text(USERS_LAW)
    assert run(USERS, copy) == pytest.approx(0.02)
    edit(file, "return 2.0 * overlap, state", "return 3.0 * overlap, state")
    assert run(USERS, copy) == pytest.approx(0.03)
