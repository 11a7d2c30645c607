"""LAMMPS as the engine of a scene, on our own law: the same forces, the same path, whatever the number of ranks, over restarts too."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import dem
from contactlaws.errors import InputError
from contactlaws.path import trace
from dem import forces, lammps_forces, lammps_run
from dem.box import Box
from dem.lammps_engine import Engine
from dem.lammps_library import launcher, library
from dem.lammps_scope import problems_with
from dem.motion import Deformation
from dem.particles import spheres
from dem.simulation import prepare, run
from dem.working import follow, working
from tests.dem import lammps_ranks as cases

RADIUS = cases.RADIUS


def _missing() -> str | None:
    try:
        library()
    except InputError as error:
        return str(error)
    return None


MISSING = _missing()
needs_lammps = pytest.mark.skipif(MISSING is not None, reason=f"LAMMPS is not there: {MISSING}")
MPIEXEC = launcher()
needs_ranks = pytest.mark.skipif(MISSING is not None or MPIEXEC is None, reason=f"no LAMMPS or no mpiexec: {MISSING}")


@needs_lammps
def test_a_pair_that_is_loaded_unloaded_and_loaded_again_feels_the_law():
    """Positions are good to 1e-16 of the box, so overlaps (.01 R and more) to 1e-13, and forces, while unloading, to ten times that."""
    engine, overlaps, before = Engine.of_scene(cases.pair()), [0.0], 0.0
    for after in (0.005, 0.01, 0.02, 0.0198, 0.0196, 0.0194, 0.0197, 0.02, 0.025, 0.03, 0.0296, 0.0292, 0.02, 0.0, 0.029, 0.0295, 0.031):
        snapshot = cases.squeezed(engine, before, after)
        before, distance = after, float(snapshot.position[1, 0] - snapshot.position[0, 0])
        overlaps.append(0.5 * (2.0 * RADIUS - distance))
        assert distance == pytest.approx(2.0 * RADIUS * (1.0 - after), rel=1e-14)
        force = trace(cases.LAW, overlaps).force
        assert snapshot.sums[:, 0].sum() / distance == pytest.approx(force[-1], rel=0.0, abs=1e-12 * force.max())
        assert np.array_equal(snapshot.memory[0, 0, 0], snapshot.memory[1, 0, 0])
    assert min(force[3:6]) > 0.0  # the unloading was seen while it pushed
    engine.close()


@needs_lammps
@pytest.mark.compiled_only("thousands of steps of a thousand spheres take hours in plain Python")
def test_a_packing_goes_where_our_own_loop_takes_it():
    """A thousand spheres, 2690 steps. Overlaps of .001 R are good to 1e-12, since the box has 20 R; collisions make that grow."""
    scene = cases.packing(1000)
    ours, theirs = run(scene), lammps_run.run(scene)
    assert theirs.statistics["steps"] == ours.statistics["steps"]
    assert np.abs(theirs.stress - ours.stress).max() < 1e-9 * ours.stress.max()
    assert np.array_equal(theirs.coordination_number, ours.coordination_number)
    for name in ("kinetic", "stored", "dissipated", "damped", "boundary_work"):
        one, other = getattr(ours.energies, name), getattr(theirs.energies, name)
        assert np.abs(other - one).max() < 1e-9 * one.max(), name
    assert theirs.statistics["largest_overlap"] == pytest.approx(ours.statistics["largest_overlap"], rel=1e-9)


ROLES = {
    "smooth": cases.SMOOTH,
    "friction": cases.SMOOTH._replace(tangential=cases.ROUGH.tangential),
    "friction without turning and shrinking": cases.SMOOTH._replace(
        tangential=cases.ROUGH.tangential._replace(turning=False, shrinking=False)
    ),
    "damper": cases.SMOOTH._replace(damping=cases.ROUGH.damping),
    "all": cases.ROUGH,
}


@needs_lammps
@pytest.mark.compiled_only("a hundred steps of two hundred spheres take a minute in plain Python")
@pytest.mark.parametrize("roles", ROLES)
def test_a_hundred_steps_differ_by_round_off(roles):
    """From random speeds and spins, in a box that changes along each axis, then back, with the drag, and another step.

    Overlaps of .001 R are good to 1e-12, since the box has 12 R; kicks add up.
    """
    contact, random = ROLES[roles], np.random.default_rng(2)
    scene = cases.packing(contact=contact)
    speed, spin = random.normal(size=(200, 3)), random.normal(size=(200, 3)) / RADIUS
    bodies = scene.particles._replace(velocity=speed, spin=spin if contact.tangential else None)
    scene = dataclasses.replace(scene, particles=bodies, programme=(dem.hold(1e-6),))
    work, cell = working(scene), scene.box.cell
    dt = prepare(scene, work).step.dt
    there = Deformation(cell, cell @ np.diag([0.999, 1.001, 0.998]), 60, dt, 1e6)
    back = Deformation(there.end, cell, 40, 0.7 * dt, 2e6)
    engine = Engine.of_scene(scene)
    for interval in (there, back):
        engine.follow(interval)
        work, _ = follow(work, interval, 0, interval.steps)
    found = engine.snapshot()
    engine.close()
    assert _by_number(work, found.velocity) == pytest.approx(work.bodies.velocity, rel=0.0, abs=1e-10)
    if work.bodies.spin is not None:
        assert _by_number(work, found.spin) == pytest.approx(work.bodies.spin, rel=0.0, abs=1e-10 * np.abs(spin).max())
    for name in ("LOST", "SHEARED", "DAMPED", "DRAGGED", "WORK"):
        mine, theirs = work.tally[0, getattr(forces, name)], found.sums[:, getattr(lammps_forces, name)].sum()
        assert theirs == pytest.approx(mine, rel=1e-9), name
    assert np.abs(found.velocity - speed).max() > 0.1  # something happened


def _by_number(work, rows):
    return rows[work.order]


@needs_lammps
def test_a_restart_in_the_middle_goes_on_as_if_nothing_was(tmp_path):
    """The file has every bit of the state. The spheres meet across the border of the box."""
    scene, found = cases.pair(density=cases.DENSITY, contact=cases.ROUGH), []
    scene = dataclasses.replace(scene, particles=scene.particles._replace(spin=np.array([[1e4, 2e4, 3e4], [0.0, -1e4, 1e4]])))
    scene = dataclasses.replace(scene, particles=scene.particles._replace(position=scene.particles.position + 0.5 * cases.EDGE))
    start, end = scene.box.cell, scene.box.cell @ np.diag([0.97, 1.0, 1.0])
    forth, back = Deformation(start, end, 20, 1e-10, 1e6), Deformation(end, start, 150, 1e-10, 2e6)
    engine = Engine.of_scene(scene)
    engine.follow(forth)
    engine.save(tmp_path / "half.restart")
    engine.follow(back)
    found.append(engine.snapshot())
    engine.close()
    again = Engine.restored(tmp_path / "half.restart", scene, forth.end, np.zeros((0, 4)))
    assert again.snapshot().memory[..., -8:-4].any()  # the slip
    again.follow(back)
    found.append(again.snapshot())
    again.close()
    timeless = [snapshot._replace(sums=np.delete(snapshot.sums, lammps_forces.CLOCK, axis=1)) for snapshot in found]
    for one, other in zip(*timeless, strict=True):
        assert np.array_equal(one, other)


def _on_ranks(what: str, ranks: int, folder: Path, *more: Path) -> dict[str, np.ndarray]:
    place = folder / f"{what}-{ranks}.npz"
    command = [str(MPIEXEC), "-n", str(ranks), sys.executable, cases.__file__, what, str(place), *map(str, more)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=500)
    assert done.returncode == 0, done.stdout + done.stderr
    with np.load(place) as file:
        found = dict(file)
    assert found.pop("ranks") == ranks
    return found


@needs_ranks
def test_a_contact_that_crosses_the_border_of_ranks_keeps_its_memory(tmp_path):
    """Loaded and unloaded in part on one rank, carried through the box and over the border: the same force all the way, and beyond."""
    found = _on_ranks("flight", 2, tmp_path)
    virial, position = found["virial"], found["position"]
    way = position[11, 0] - position[1, 0]
    assert (way > 0.98 * cases.EDGE).all()  # once through: the edge along x is 2 % shorter
    # the box takes it along and brings it back, a position is good to 1e-16 of it, and an overlap of .02 R to 1e-13
    assert virial[2:12] == pytest.approx(np.full(10, virial[1]), rel=1e-9)
    overlaps = RADIUS - 0.5 * (position[:, 1, 0] - position[:, 0, 0])
    force = trace(cases.LAW, [0.0, *overlaps]).force[1:]
    assert force[1] < 0.95 * force[0]  # it would be more on the loading
    assert virial / (2.0 * (RADIUS - overlaps)) == pytest.approx(force, rel=0.0, abs=1e-11 * force.max())


@needs_ranks
@pytest.mark.compiled_only("thousands of steps of a hundred spheres take hours in plain Python")
def test_two_and_four_ranks_do_to_the_bit_what_one_does_after_a_kill_too(tmp_path):
    """Forces are added in the order of the spheres' numbers, stresses without rounding. The state is saved to the last bit."""
    whole = _on_ranks("paths", 1, tmp_path)
    for name in cases.SCENES:
        assert whole[f"{name} energies"].any(axis=1).all()  # all that there is to remember was there
    (tmp_path / "halves").mkdir()
    command = [sys.executable, cases.__file__, "killed", str(tmp_path / "halves")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=500)
    assert done.returncode == 0, done.stdout + done.stderr
    assert {file.stem for file in (tmp_path / "halves").glob("*.npz")} == set(cases.SCENES)
    for other in (_on_ranks("paths", 2, tmp_path, tmp_path / "halves"), _on_ranks("paths", 4, tmp_path)):
        for name, values in whole.items():
            assert np.array_equal(other[name], values), name


@needs_lammps
@pytest.mark.compiled_only("thousands of steps of a hundred spheres take hours in plain Python")
@pytest.mark.parametrize("name", cases.SCENES)
def test_every_kind_of_scene_goes_the_way_of_our_own_loop(name):
    """Some hundred to two thousand steps. Overlaps of .001 R are good to 1e-12, since the boxes have 10 R; collisions make that grow."""
    ours, theirs = run(cases.SCENES[name]()), lammps_run.run(cases.SCENES[name]())
    assert theirs.stopped is None
    assert theirs.statistics["steps"] == ours.statistics["steps"]
    assert np.abs(theirs.strain - ours.strain).max() < 1e-12
    assert np.abs(theirs.stress - ours.stress).max() < 1e-9 * np.abs(ours.stress).max()
    assert np.array_equal(theirs.coordination_number, ours.coordination_number)
    for term in ours.energies._fields:
        one, other = getattr(ours.energies, term), getattr(theirs.energies, term)
        assert np.abs(other - one).max() <= 1e-9 * np.abs(one).max(), term


@needs_lammps
def test_a_stress_that_makes_the_box_too_small_ends_the_run_with_the_reason():
    """Two spheres that touch cannot bear it, so the edges shrink from 4.3 radii at their fastest, by 5 % in the time given."""
    bodies = spheres([[0.2 * RADIUS] * 3, [2.2 * RADIUS, 0.2 * RADIUS, 0.2 * RADIUS]], RADIUS, cases.DENSITY)
    scene = dem.Scene(bodies, Box((4.3 * RADIUS,) * 3), cases.SMOOTH, (dem.confined(1e9),), inertial_number=1e-2, outputs=4)
    found = lammps_run.run(scene)
    assert "meet another twice" in found.stopped
    assert 0.95 < (1.0 - found.strain).min() < 1.0


def test_what_this_engine_does_not_do_is_named_at_once():
    scene = cases.pair(contact=cases.ROUGH)
    assert not list(problems_with(scene))
    asked = dataclasses.replace(scene, box=scene.box._replace(tilt=(RADIUS, 0.0, 0.0)), quasi_static=dem.QuasiStatic(), affine=False)
    assert {problem.name for problem in problems_with(asked)} == {"box tilt", "quasi_static"}
    open_box = dataclasses.replace(scene, box=scene.box._replace(periodic=(True, True, False)))
    assert {problem.name for problem in problems_with(open_box)} == {"box"}
    with pytest.raises(InputError, match="engine lammps"):
        lammps_run.run(asked)
    with pytest.raises(InputError, match="meet another twice"):
        lammps_run.run(dataclasses.replace(scene, box=Box((4.0 * RADIUS, *scene.box.lengths[1:]))))
