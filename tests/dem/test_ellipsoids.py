"""Ellipsoids that meet: conservation, the limit of spheres, symmetry, walls, images, threads, restarts."""

from __future__ import annotations

import dataclasses
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numba
import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.tangential import mindlin, rolling
from contactlaws.whole_range_ellipsoid import whole_range_ellipsoid
from dem.ellipsoid_forces import BEFORE, FREE
from dem.measure import energies, network, stress_tensor
from dem.motion import Deformation
from dem.packing import random_close_packing
from dem.rotation import matrices
from dem.working import follow, working
from tests.dem.ellipsoid_scenes import (
    DENSITY,
    LAW,
    MATERIAL,
    SIZE,
    TRIAXIAL,
    angular_momentum,
    collided,
    contact,
    product,
    random_turns,
    scene,
)

compiled_only = pytest.mark.compiled_only(reason="thousands of steps of interpreted kernels")
APART = np.array([[100e-6, 100e-6, 95e-6], [101e-6, 101.5e-6, 109e-6]])
VELOCITY, SPIN = [[0.0, 0.0, 10.0], [0.0, 0.0, -10.0]], [[1e5, 0.0, 2e5], [0.0, 3e5, 0.0]]


def two(seed: int, **settings: object) -> dem.Scene:
    """Two triaxial bodies on their way to each other, off centre and turning."""
    friction, restitution = settings.pop("friction", 0.0), settings.pop("restitution", 1.0)
    bodies = dem.ellipsoids(APART, TRIAXIAL, DENSITY, random_turns(2, seed), VELOCITY, SPIN)
    return scene(bodies, contact(friction, restitution), **settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", [0, 2, 3])
@compiled_only
def test_elastic_collision_conserves_everything(seed: int) -> None:
    """Momentum and angular momentum to round-off; energy to the square of the step: 1e-4 at a fifth of the critical one, 16 times less."""
    made = two(seed)
    start = working(made)
    held, turning = energies(start), angular_momentum(start)
    for fraction, error in ((0.2, 1e-4), (0.05, 6e-6)):
        work = collided(made, 5e-8, fraction)
        ended = energies(work)
        change = (work.masses[:, None] * (work.bodies.velocity - start.bodies.velocity)).sum(axis=0)
        assert np.abs(change).max() < 1e-12 * work.masses[0] * 10.0
        assert np.abs(angular_momentum(work) - turning).max() < 1e-11 * np.abs(turning).max()
        assert ended[0] == pytest.approx(held[0], rel=error)


@pytest.mark.parametrize(("friction", "restitution"), [(0.3, 1.0), (0.0, 0.6), (0.3, 0.6)])
@compiled_only
def test_what_a_collision_loses_is_accounted_for(friction: float, restitution: float) -> None:
    """Friction and damper: angular momentum to round-off, and every joule in its own account, within 1e-4 at this step."""
    made = two(2, friction=friction, restitution=restitution)
    start = working(made)
    held, turning = energies(start), angular_momentum(start)
    work = collided(made, 5e-8, 0.05)
    ended = energies(work)
    assert np.abs(angular_momentum(work) - turning).max() < 1e-11 * np.abs(turning).max()
    assert ended[0] < held[0]
    assert sum(ended[:-1]) == pytest.approx(sum(held[:-1]), rel=1e-4)
    assert (ended[4] > 0.0) == (friction > 0.0)
    assert (ended[5] > 0.0) == (restitution < 1.0)


@compiled_only
def test_frame_does_not_matter() -> None:
    """The whole collision turned: the same end, turned; the bodies' last bits differ, and so may the sixth digit of chaos-free motion."""
    q = random_turns(1, 7)[0]
    turn, ends = matrices(q[None])[0], []
    for turned in (False, True):
        rows = [np.array(values, dtype=float) for values in (APART - 100e-6, VELOCITY, SPIN)]
        quaternions = random_turns(2, 2)
        if turned:
            rows, quaternions = [row @ turn.T for row in rows], product(q[None], quaternions)
        bodies = dem.ellipsoids(rows[0] + 100e-6, TRIAXIAL, DENSITY, quaternions, rows[1], rows[2])
        work = collided(scene(bodies, contact(0.3, 0.8)), 5e-8, 0.1)
        back = np.argsort(work.order)
        ends.append((work.bodies.velocity[back], work.bodies.spin[back]))  # type: ignore[index]
    for one, other in zip(ends[0], ends[1], strict=True):
        assert one @ turn.T == pytest.approx(other, abs=1e-7 * np.abs(one).max())


def spheres_and_the_like(friction: float | None) -> list[dem.Trajectory]:
    """A packing of spheres, by the engine of spheres and by that of ellipsoids."""
    packing = random_close_packing(40, 0.6, SIZE, seed=1)
    programme = dem.uniaxial_compression(0.02, strain_rate=2e4, release=False)
    found, full = [], contact(friction or 0.0, 0.9)
    for bodies, law in (
        (dem.spheres(packing.position, SIZE, DENSITY), Hertz(SIZE, MATERIAL.reduced_modulus)),
        (dem.ellipsoids(packing.position, (SIZE,) * 3, DENSITY, random_turns(40, 3)), LAW),
    ):
        touch = dem.Contact(law) if friction is None else full._replace(normal=law)
        found.append(dem.run(dem.Scene(bodies, packing.box, touch, programme, outputs=5, frames=2, drag=None)))
    return found


@pytest.mark.parametrize("friction", [None, 0.3])
@compiled_only
def test_spheres_as_ellipsoids_are_spheres(friction: float | None) -> None:
    """The same trajectory: round-off of 1e-16 a step, which collisions enlarge; the same contacts, stress to 1e-6."""
    one, other = spheres_and_the_like(friction)
    assert one.statistics["dt"] == pytest.approx(other.statistics["dt"], rel=1e-9)
    assert np.array_equal(one.coordination_number, other.coordination_number)
    assert other.stress == pytest.approx(one.stress, abs=1e-6 * np.abs(one.stress).max())
    assert other.fabric == pytest.approx(one.fabric, abs=1e-6)
    assert other.frames[-1].position == pytest.approx(one.frames[-1].position, abs=1e-6 * SIZE)
    for name in ("kinetic", "stored", "sheared", "rubbed", "boundary_work"):
        a, b = getattr(one.energies, name), getattr(other.energies, name)
        assert b == pytest.approx(a, abs=1e-6 * np.abs(one.energies.boundary_work).max())
    # the damper's work is summed over the way of the overlap, not over rate and time: two sums of the same order
    assert other.energies.dashed == pytest.approx(one.energies.dashed, rel=1e-2)


@compiled_only
def test_a_wall_throws_back() -> None:
    """An ellipsoid on a flat: energy to the square of the step, momentum along the wall untouched."""
    bodies = dem.ellipsoids([[100e-6, 100e-6, 8e-6]], TRIAXIAL, DENSITY, random_turns(1, 5), [[3.0, 0.0, -10.0]])
    made = scene(bodies, contact())
    start = working(made)
    held = energies(start)
    work = collided(made, 5e-8, 0.05)
    ended = energies(work)
    assert ended[0] == pytest.approx(held[0], rel=1e-5)
    assert work.bodies.velocity[0, :2] == pytest.approx([3.0, 0.0], abs=1e-12)
    assert work.bodies.velocity[0, 2] > 0.0
    assert np.abs(work.bodies.spin).max() > 1e4  # type: ignore[type-var]


def test_at_rest_on_a_wall_in_closed_form() -> None:
    """Pressed onto a flat by the long axis: R = b c/a, q = b^2/c^2 by turns, overlap as placed."""
    a, b, c = TRIAXIAL
    half = math.sqrt(0.5)
    upright = [[half, 0.0, half, 0.0]]  # about y: the first axis along z
    bodies = dem.ellipsoids([[100e-6, 100e-6, a - 2e-8]], TRIAXIAL, DENSITY, upright)
    work = working(scene(bodies, dem.Contact(LAW)))
    found = network(work)
    assert found.overlap == pytest.approx([2e-8], rel=1e-9)
    assert found.normal[0] == pytest.approx([0.0, 0.0, -1.0])
    push = 4.0 / 3.0 * MATERIAL.reduced_modulus * math.sqrt(b * c / a) * 2e-8**1.5  # f2 is within 1e-3 of 1 at this ratio
    assert found.normal_force[0] == pytest.approx(push, rel=1e-2)


def test_images_are_like_the_bodies_themselves() -> None:
    """The same two bodies across a face of the periodic box, or moved by whole edges: the same forces and torques."""
    turns = random_turns(2, 4)
    box, sums = dem.Box((40e-6,) * 3), []
    for shift in ([0.0, 0.0, 0.0], [-40e-6, 0.0, 0.0], [0.0, 80e-6, -40e-6]):
        position = np.array([[38e-6, 20e-6, 20e-6], [47e-6 + shift[0], 20.5e-6 + shift[1], 20.3e-6 + shift[2]]])
        made = dem.Scene(dem.ellipsoids(position, TRIAXIAL, DENSITY, turns), box, contact(), (dem.hold(1.0),), skin=0.3)
        work = working(made)
        back = np.argsort(work.order)
        assert work.force.any()
        sums.append((work.force[0][back], work.torque[0][back], work.virial[0]))
    for other in sums[1:]:
        for one, two_ in zip(sums[0], other, strict=True):
            assert two_ == pytest.approx(one, abs=1e-9 * np.abs(one).max())


def packed(law: object = LAW, **settings: object) -> dem.Scene:
    """Forty ellipsoids in a periodic box, a little pressed, with friction and dampers."""
    packing = random_close_packing(40, 0.5, 1.1 * SIZE, seed=2)
    bodies = dem.ellipsoids(packing.position, TRIAXIAL, DENSITY, random_turns(40, 6))
    programme = (dem.isotropic_compression(0.07, 1.5e-6), dem.simple_shear(0.05, 1e-6))
    given: dict[str, object] = {"programme": programme, "outputs": 6, "frames": 2, "drag": None, **settings}
    return dem.Scene(bodies, packing.box, contact(0.3, 0.8)._replace(normal=law), **given)  # type: ignore[arg-type]


@compiled_only
def test_packing_keeps_its_books() -> None:
    """Compressed and sheared with friction and dampers: energy to 1e-3; the stress is symmetric but for the spins' inertia."""
    found = dem.run(packed(time_step_fraction=0.1))
    assert found.statistics["energy_balance"] < 1e-3
    assert found.stopped is None
    assert found.pressure[-1] > 0.0
    for name in ("rubbed", "dashed"):
        assert np.all(np.diff(getattr(found.energies, name)) >= -1e-6 * found.energies.boundary_work.max())
    frame = found.frames[-1]
    assert frame.orientation is not None
    assert np.linalg.norm(frame.orientation, axis=1) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one thread here")
@pytest.mark.parametrize("law", [LAW, whole_range_ellipsoid(MATERIAL._replace(yield_stress=7.9e9))])
@compiled_only
def test_threads_share_the_work(law: object) -> None:
    """Two threads twice: the same bits; one and two: the same to round-off, enlarged by collisions. Also a law made of another's record."""
    made = packed(law, outputs=2, programme=(dem.isotropic_compression(0.07, 3e-7),))
    once, again = (dem.run(dataclasses.replace(made, threads=2)) for _ in range(2))
    alone = dem.run(made)
    assert np.array_equal(once.stress, again.stress)
    assert np.array_equal(once.frames[-1].position, again.frames[-1].position)
    assert once.stress == pytest.approx(alone.stress, abs=1e-6 * np.abs(alone.stress).max())


@compiled_only
def test_restart_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    """Killed with SIGKILL in the middle and started again."""
    path = tmp_path / "state.npz"
    code = (
        "import sys, dem.simulation, tests.dem.test_ellipsoids as t, dem\n"
        "dem.simulation.CHECKPOINT_EVERY = 0.0\n"
        f"dem.run(t.packed(), lambda part, text: print(part, flush=True), checkpoint={str(path)!r})\n"
    )
    root = Path(__file__).parents[2]
    child = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, cwd=root, env=os.environ | {"PYTHONPATH": str(root)}
    )
    assert child.stdout is not None
    for line in child.stdout:
        if float(line) >= 0.5:
            child.send_signal(signal.SIGKILL)
            break
    child.wait()
    for _ in range(100):
        if path.exists():
            break
        time.sleep(0.01)
    resumed, whole = dem.run(packed(), checkpoint=path), dem.run(packed())
    for name in ("stress", "fabric", "strain"):
        assert np.array_equal(getattr(resumed, name), getattr(whole, name))
    for one, other in zip(resumed.frames, whole.frames, strict=True):
        assert one.orientation is not None
        assert other.orientation is not None
        assert np.array_equal(one.orientation, other.orientation)
        assert np.array_equal(one.network.normal, other.network.normal)
    assert all(np.array_equal(a, b) for a, b in zip(resumed.energies, whole.energies, strict=True))


@compiled_only
@pytest.mark.parametrize(("speed", "rate"), [(20.0, 0.0), (0.0, 3e7), (5.0, 3e6)])
def test_what_is_passed_over_would_have_changed_nothing(speed: float, rate: float) -> None:
    """Bodies that fly, spin fast, or both, in a box under shear: the same bits where every pair is looked at in every step.

    Speeds in m/s and 1/s; some 5 % of a half axis, or of a turn, in the time that is followed, so contacts begin and end.
    """
    made, steps = packed(), 600
    found = []
    for passes in (True, False):
        work, rng = working(made), np.random.default_rng(3)
        work.bodies.velocity[:] = rng.normal(scale=speed, size=(work.size, 3))
        assert work.shapes is not None
        work.shapes.momentum[:] = rng.normal(scale=rate, size=(work.size, 3)) / work.shapes.ease
        sheared = work.cell.copy()
        sheared[1, 0] += 2e-7
        stage = Deformation(work.cell.copy(), sheared, steps, 2e-11)
        passed, touched = 0, 0
        for step in range(steps):
            memory = work.groups[0].past.memory
            assert memory is not None
            passed, touched = passed + int(np.sum(memory[FREE] > 0.0)), touched + int(np.sum(memory[BEFORE] > 0.0))
            if not passes:
                memory[FREE] = 0.0
            work, _ = follow(work, stage, step, 1)
        assert passed > 1000  # there is something to pass over, and to miss
        assert touched > 1000
        found.append((work.bodies.position, work.shapes.orientation, work.force, work.torque))
    for one, other in zip(*found, strict=True):
        assert np.array_equal(one, other)


@compiled_only
def test_stress_control_reaches_its_stress() -> None:
    """A bed under 50 MPa from all sides; the servo waves about it by the inertia of the bodies."""
    packing = random_close_packing(40, 0.55, 1.1 * SIZE, seed=2)
    bodies = dem.ellipsoids(packing.position, TRIAXIAL, DENSITY, random_turns(40, 6))
    made = dem.Scene(bodies, packing.box, contact(0.3, 0.8), (dem.confined(5e7),) * 4, outputs=4, frames=1, inertial_number=5e-3)
    found = dem.run(made)
    assert np.diagonal(found.stress[-1]) == pytest.approx([5e7] * 3, rel=0.01)


def test_what_ellipsoids_cannot_do_is_said() -> None:
    """All at once."""
    bodies = dem.ellipsoids([[2e-5, 2e-5, 2e-5]], TRIAXIAL, DENSITY)
    box = dem.Box((4e-5,) * 3)
    touch = dem.Contact(Hertz(SIZE, 1e9), mindlin(0.3, MATERIAL), rolling(0.1))
    with pytest.raises(InputError) as caught:
        dem.run(dem.Scene(bodies, box, touch, (dem.hold(1.0),), quasi_static=dem.QuasiStatic()))
    text = str(caught.value)
    for part in ("is a law of spheres", "rolling", "quasi_static"):
        assert part in text
    with pytest.raises(InputError, match="law of ellipsoids"):
        dem.run(dem.Scene(dem.spheres([[2e-5] * 3], SIZE, DENSITY), box, dem.Contact(LAW), (dem.hold(1.0),)))
    with pytest.raises(InputError, match="slender"):
        dem.ellipsoids([[0.0] * 3], (11.0, 1.0, 1.0), DENSITY)
    with pytest.raises(InputError, match="quaternions other than 0"):
        dem.ellipsoids([[0.0] * 3], TRIAXIAL, DENSITY, [[0.0] * 4])
    with pytest.raises(InputError, match="positive"):
        dem.ellipsoids([[0.0] * 3], (1.0, 1.0, -1.0), DENSITY)
    with pytest.raises(InputError, match="three half axes"):
        dem.ellipsoids([[0.0] * 3], (1.0, 1.0), DENSITY)


def test_stress_is_that_of_the_contacts() -> None:
    """Two bodies pressed: the virial is branch times force."""
    position = np.array([[20e-6, 20e-6, 20e-6], [29e-6, 20.5e-6, 20.3e-6]])
    made = dem.Scene(dem.ellipsoids(position, TRIAXIAL, DENSITY, random_turns(2, 4)), dem.Box((60e-6,) * 3), contact(), (dem.hold(1.0),))
    work = working(made)
    found = network(work)
    assert len(found.first) == 1
    assert stress_tensor(work) * work.box.volume == pytest.approx(np.outer(found.branch[0], found.force[0]), rel=1e-12)
    assert np.linalg.norm(np.cross(found.normal[0], found.force[0])) == pytest.approx(0.0, abs=1e-12 * found.normal_force[0])


def test_a_few_steps_run() -> None:
    """Also interpreted: a scene of every role takes steps, and its energy stays finite."""
    work = working(packed())
    work, _ = follow(work, Deformation(work.cell.copy(), 0.999 * work.cell, 5, 1e-11), 0, 5)
    assert np.isfinite(work.bodies.position).all()
    assert np.isfinite(energies(work)).all()
