"""A law from outside the project: it runs like any other, and an edited one is never answered from the cache."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

import dem
from contactlaws.dispatch import Law, register
from dem.packing import Packing

RADIUS, DENSITY = 5e-6, 4750.0


class WaltonBraun(NamedTuple):
    """Loads on one straight line, unloads on a steeper one (Walton & Braun 1986); e = sqrt(loading/unloading)."""

    radius: float  # m
    loading: float  # N/m
    unloading: float  # N/m


@numba.njit
def _force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    return max(0.0, law.loading * largest - law.unloading * (largest - overlap)), (largest,)


@numba.njit
def _contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    return math.sqrt(law.radius * max(overlap, 0.0))


@numba.njit
def _energy(law, overlap, state):  # type: ignore[no-untyped-def]
    largest = max(overlap, state[0])
    force = max(0.0, law.loading * largest - law.unloading * (largest - overlap))
    return 0.5 * force**2 / law.unloading, 0.5 * law.loading * largest**2 * (1.0 - law.loading / law.unloading)


@numba.njit
def _stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    return law.unloading


register(Law("walton_braun_of_a_test", WaltonBraun, _force, _contact_radius, _energy, _stiffness_bound, ("largest_overlap",), "test"))
LAW = WaltonBraun(RADIUS, 1e4, 6.25e4)


def test_restitution_of_a_users_law() -> None:
    """e = sqrt(k1/k2) at any speed; the last step of contact, one in 2000, is cut short."""
    found = dem.impact.restitution(LAW, RADIUS, DENSITY, [0.01, 1.0])
    np.testing.assert_allclose(found.restitution, 0.4, rtol=1e-4)


def test_energy_balance_of_a_users_law(shaken_crystal: Packing) -> None:
    scene = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(LAW), dem.uniaxial_compression(0.03), inertial_number=8e-3, outputs=20)
    energies = dem.run(scene).energies
    assert energies.dissipated[-1] > 0.2 * energies.boundary_work.max()
    assert np.abs(energies.balance).max() < 1e-3


EDITED = """
from typing import NamedTuple
import numba
from contactlaws import pair
from contactlaws.dispatch import Law, register

class Spring(NamedTuple):
    radius: float

@numba.njit
def force(law, overlap, rate, dt, state):
    return {stiffness} * overlap, state

register(Law("spring", Spring, force, force, force, force, (), "test"))
print(pair.pair_force(Spring(1.0), 1.0, 2.0, 0.0, 0.0, ())[0])
"""


@pytest.mark.compiled_only(reason="it is about the cache of compiled code")
def test_an_edited_law_changes_the_kernel_in_the_next_process(tmp_path: Path) -> None:
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONPATH": str(root), "FE2DEM_CACHE_DIR": str(tmp_path)}
    answers = []
    for stiffness in (1.0, 5.0):
        script = tmp_path / "user_law.py"
        script.write_text(EDITED.format(stiffness=stiffness))
        done = subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True, check=True)
        answers.append(float(done.stdout))
    assert answers == [1.0, 5.0]
