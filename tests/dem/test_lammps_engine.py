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
from contactlaws.material import Material
from contactlaws.path import trace
from contactlaws.tangential import damper, mindlin
from dem import lammps_run
from dem.lammps_engine import Engine, launcher, library, problems_with
from dem.motion import Deformation
from dem.simulation import prepare, run
from dem.working import follow, working
from tests.dem import lammps_ranks as cases

RADIUS, NMC = cases.RADIUS, Material(142e9, 0.25)


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
    """A thousand spheres. The two differ by the first step of an interval, when LAMMPS's box stands still, and by round-off, which
    collisions make grow; the goal for the stress is .1 % of the largest.
    """
    scene = cases.packing(1000)
    ours, theirs = run(scene), lammps_run.run(scene)
    assert theirs.statistics["steps"] == ours.statistics["steps"]
    most = ours.stress.max()
    assert np.abs(theirs.stress - ours.stress).max() < 1e-3 * most
    assert np.abs(theirs.coordination_number - ours.coordination_number).max() < 0.01
    for name in ("stored", "dissipated", "boundary_work"):
        one, other = getattr(ours.energies, name), getattr(theirs.energies, name)
        assert np.abs(other - one).max() < 1e-3 * one.max(), name
    assert theirs.statistics["largest_overlap"] == pytest.approx(ours.statistics["largest_overlap"], rel=1e-2)
    # the drag's energy is split at outputs to half a step, and so is the box's
    assert theirs.statistics["energy_balance"] < 1e-3


@needs_lammps
@pytest.mark.compiled_only("a hundred steps of two hundred spheres take a minute in plain Python")
def test_a_hundred_steps_differ_by_round_off():
    """In a box at rest, from random speeds, with the drag. Overlaps of .001 R are good to 1e-12, since the box has 12 R; kicks add up."""
    scene = cases.packing()
    speed = np.random.default_rng(2).normal(size=(200, 3))
    scene = dataclasses.replace(scene, particles=scene.particles._replace(velocity=speed), programme=(dem.hold(1e-6),))
    work = working(scene)
    dt = prepare(scene, work).step.dt
    still = Deformation(scene.box.cell, scene.box.cell, 100, dt, 1e6)
    engine = Engine.of_scene(scene)
    engine.follow(still)
    found = engine.snapshot()
    engine.close()
    work, _ = follow(work, still, 0, 100)
    velocity = np.empty_like(speed)
    velocity[work.order] = work.bodies.velocity
    assert np.abs(found.velocity - velocity).max() < 1e-10
    assert np.abs(velocity - speed).max() > 0.1  # something happened


@needs_lammps
def test_a_restart_in_the_middle_goes_on_as_if_nothing_was(tmp_path):
    """The file has every bit of the state; new lists add forces in another order."""
    scene, found = cases.pair(density=cases.DENSITY), []
    widest, skin = RADIUS, 2.0 * RADIUS * scene.skin
    start, end = scene.box.cell, scene.box.cell @ np.diag([0.97, 1.0, 1.0])
    forth, back = Deformation(start, end, 200, 1e-10, 1e6), Deformation(end, start, 150, 1e-10, 2e6)
    engine = Engine.of_scene(scene)
    engine.follow(forth)
    engine.save(tmp_path / "half.restart")
    engine.follow(back)
    found.append(engine.snapshot())
    engine.close()
    again = Engine.restored(tmp_path / "half.restart", scene.contact, skin, widest)
    assert again.snapshot().memory.any()
    again.follow(back)
    found.append(again.snapshot())
    again.close()
    for one, other in zip(*found, strict=True):
        assert other == pytest.approx(one, rel=1e-12, abs=1e-12 * np.abs(one).max())


def _on_ranks(what: str, ranks: int, folder: Path) -> dict[str, np.ndarray]:
    place = folder / f"{what}-{ranks}.npz"
    command = [str(MPIEXEC), "-n", str(ranks), sys.executable, str(Path(cases.__file__)), what, str(place)]
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
@pytest.mark.compiled_only("thousands of steps of two hundred spheres take an hour in plain Python")
def test_two_ranks_do_what_one_does(tmp_path):
    """Forces are added in another order, and collisions make round-off grow: over the path .1 % of the largest is the goal."""
    one, two = (_on_ranks("compression", ranks, tmp_path) for ranks in (1, 2))
    for name, values in one.items():
        scale = 1e-3 * np.abs(values).max() if name != "coordination" else 0.02
        assert np.abs(two[name] - values).max() < scale, name


def test_what_this_engine_does_not_do_is_named_at_once():
    scene = cases.packing(60)
    assert not list(problems_with(scene))
    contact = scene.contact._replace(tangential=mindlin(0.3, NMC), damping=damper(0.7, NMC))
    asked = dataclasses.replace(
        scene, contact=contact, programme=(dem.simple_shear(0.1), dem.confined(1e6)), quasi_static=dem.QuasiStatic(), affine=False
    )
    named = {problem.name for problem in problems_with(asked)}
    assert named == {"tangential", "damping", "shear", "stress control", "quasi_static", "affine"}
    with pytest.raises(InputError, match="engine lammps"):
        lammps_run.run(asked)
    with pytest.raises(InputError, match="meet another twice"):
        lammps_run.run(cases.packing(8))
