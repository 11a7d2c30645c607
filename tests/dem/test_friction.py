"""Friction, rolling and dampers: impulses, momenta, energy, objectivity and Coulomb's bound."""

from __future__ import annotations

import math

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from contactlaws.tangential import Mindlin, dragged, tangential_stiffness
from dem.forces import LARGEST
from dem.working import working
from tests.dem.scenes import (
    INERTIA,
    MASS,
    MATERIAL,
    MIDDLE,
    RADIUS,
    angular_momentum,
    carried,
    collided,
    contact,
    in_order,
    scene,
    step_for,
)

#: m; a collision at 1 m/s is twice as deep
DEPTH = 0.01 * RADIUS
#: a way, or a force, in some unit
COMPONENT = st.floats(-1.0, 1.0)
#: of the force; squares of less than 1e-100 leave the range of floats
LIMIT = st.one_of(st.just(0.0), st.floats(1e-100, 1.0))
VECTOR = st.tuples(COMPONENT, COMPONENT, COMPONENT)


def test_oblique_impact_keeps_both_momenta() -> None:
    """Each force is given and taken, and acts at one point of the line of centres: only round-off of the sums is left."""
    shift, speed = 2.001 * RADIUS * math.sqrt(0.5), 1.0
    position = [[MIDDLE, MIDDLE, MIDDLE], [MIDDLE + shift, MIDDLE, MIDDLE + shift]]
    start = scene(position, contact(0.4, 0.02, 0.8), [[speed, 0.3, 0.0], [-speed, 0.0, 0.2]], spin=[[1e4, 2e4, 5e4], [0.0, -3e4, 1e4]])
    before, work = working(start), collided(start, step_for(start, DEPTH, 0.1))
    momentum = [state.masses @ state.bodies.velocity for state in (before, work)]
    assert np.abs(in_order(work, work.bodies.spin) - start.particles.spin).max() > 1e3
    np.testing.assert_allclose(momentum[1], momentum[0], atol=1e-13 * MASS * speed)
    np.testing.assert_allclose(angular_momentum(work), angular_momentum(before), atol=1e-12 * MASS * speed * MIDDLE)


@pytest.mark.parametrize("friction", [0.05, 0.3])
def test_gross_sliding_on_a_wall(friction: float) -> None:
    """Steeper than sticking allows, the force is Coulomb's from first to last: mu times the normal impulse, and R/I of that in spin.

    Sums of the same numbers times a factor: round-off. The force acts in the wall's plane, on an arm shorter than R by the overlap.
    """
    start = scene([[MIDDLE, MIDDLE, 1.001 * RADIUS]], contact(friction), [[10.0, 0.0, -1.0]])
    work = collided(start, step_for(start, DEPTH, 0.05))
    lost, gained = 10.0 - work.bodies.velocity[0, 0], work.bodies.velocity[0, 2] + 1.0
    assert gained == pytest.approx(2.0, rel=1e-3)
    assert lost == pytest.approx(friction * gained, rel=1e-10)
    assert work.bodies.spin is not None
    spin = friction * gained * MASS * RADIUS / INERTIA
    assert spin * (1.0 - work.tally[0, LARGEST]) < work.bodies.spin[0, 1] < spin
    assert not np.any(work.bodies.spin[0, [0, 2]])


@pytest.mark.parametrize("shrinking", [False, True])
def test_sticking_on_a_wall(shrinking: bool) -> None:
    """Too much friction to slide: Hertz's spring drives, dF = 8 G* a du + F da/a (the latter while a falls) brakes; solved by itself."""
    speed, touch = (0.2, -1.0), contact(1e6, shrinking=shrinking)
    start = scene([[MIDDLE, MIDDLE, RADIUS]], touch, [[speed[0], 0.0, speed[1]]])
    work = collided(start, step_for(start, DEPTH, 0.02))
    assert touch.on_rigid_flat.tangential is not None
    modulus = touch.on_rigid_flat.tangential.shear_modulus

    def rates(_: float, y: np.ndarray) -> list[float]:
        depth, closing, slip, force = y
        a = math.sqrt(RADIUS * max(depth, 0.0))
        push = 4.0 / 3.0 * MATERIAL.reduced_modulus * a * max(depth, 0.0)
        shrink = 0.5 * force * closing / depth if shrinking and closing < 0.0 < depth else 0.0
        return [closing, -push / MASS, -3.5 * force / MASS, 8.0 * modulus * a * slip + shrink]

    def parted(_: float, y: np.ndarray) -> float:
        return float(y[0])

    parted.terminal, parted.direction = True, -1.0  # type: ignore[attr-defined]
    solution = solve_ivp(rates, (0.0, 1e-6), [0.0, 1.0, speed[0], 0.0], events=parted, rtol=1e-10, atol=1e-20, max_step=1e-10)
    slip = work.bodies.velocity[0, 0] - RADIUS * work.bodies.spin[0, 1]  # type: ignore[index]
    # the step is 0.02 of the critical one, some 1000 in the collision; the trapezium of the friction force costs its first power
    assert slip == pytest.approx(solution.y[2, -1], abs=3e-3 * speed[0])
    # what changed of the velocity came with 5/2 of it in the spin, but for the overlap by which the arm is shorter
    spun = RADIUS * work.bodies.spin[0, 1]  # type: ignore[index]
    assert spun == pytest.approx(2.5 * (speed[0] - work.bodies.velocity[0, 0]), abs=work.tally[0, LARGEST] * 2.5 * speed[0])


def work_on_closed_paths(shrinking: bool) -> float:
    """Work put into friction on a wall: load, shear, unload half, shear back, part; over what the shearing took."""
    work = working(scene([[MIDDLE, MIDDLE, RADIUS]], contact(1e6, shrinking=shrinking)))
    dt, steps, spent, first = 1e-9, 200, 0.0, 0.0
    for way in ([0.0, 0.0, -DEPTH], [0.1 * DEPTH, 0.0, 0.0], [0.0, 0.0, 0.5 * DEPTH], [-0.1 * DEPTH, 0.0, 0.0], [0.0, 0.0, 0.5 * DEPTH]):
        velocity = np.array([way]) / (steps * dt)
        for _ in range(steps):
            before = work.force[0, 0, 0]
            carried(work, velocity, 0.0, dt)
            spent -= 0.5 * (before + work.force[0, 0, 0]) * velocity[0, 0] * dt
        first = first or spent
    return spent / first


def test_a_closed_path_gains_energy_only_without_shrinking() -> None:
    """Elata & Berryman: with springs k1 > k2 for the way there and back, 1/2 k1 u^2 goes in and (k1 - k2/2) u^2 comes out.

    k goes with the root of the overlap. Steps of 1/200 in a path of straight lines: the trapezium is exact but for round-off.
    """
    ratio = math.sqrt(0.5)
    assert work_on_closed_paths(shrinking=False) == pytest.approx(-(1.0 - ratio), rel=1e-6)
    assert work_on_closed_paths(shrinking=True) == pytest.approx(1.0 - ratio, rel=1e-6)


@hypothesis.given(st.lists(st.tuples(st.floats(0.01, 1.0), VECTOR, LIMIT), min_size=1, max_size=30))
def test_no_path_gains_energy_and_none_exceeds_coulomb(path: list[tuple[float, tuple[float, ...], float]]) -> None:
    """Random radii, ways and limits: the force is in the plane and bounded, and what it stores never exceeds the work done on it.

    A limit that falls takes its share before the way is gone: in one step of any length the mean of both forces would be too rough.
    """
    law, n, force, radius, spent = Mindlin(1.0, 1.0), (0.6, 0.0, 0.8), (0.0, 0.0, 0.0), 1.0, 0.0
    drag, stiffness_of = (getattr(f, "py_func", f) for f in (dragged, tangential_stiffness))  # handing over tuples takes longer
    for a, way, limit in path:
        stiffness = stiffness_of(law, a)
        force, _ = drag(stiffness, limit, a, radius, 0.0, n, (0.0, 0.0, 0.0), force)
        force, work = drag(stiffness, limit, a, a, 0.0, n, way, force)
        radius, spent = a, spent + work
        size = math.sqrt(sum(f * f for f in force))
        assert size <= limit * (1.0 + 1e-14)
        assert abs(sum(f * m for f, m in zip(force, n, strict=True))) <= 1e-14
        assert 0.5 * size**2 / stiffness <= spent + 1e-13  # of sums near 1


@pytest.mark.parametrize("axis", ["across", "along"])
def test_a_loaded_pair_turns_with_its_force(axis: str) -> None:
    """A quarter turn as a rigid body, about a line across the normal or about the normal: the force turns along.

    Each step turns it to first order: 2000 steps of 0.8 mrad leave 0.8e-3 x 1.6/2.
    """
    unit = {"across": np.array([0.0, 1.0, 0.0]), "along": np.array([1.0, 0.0, 0.0])}[axis]
    work = working(scene([[MIDDLE - RADIUS, MIDDLE, MIDDLE], [MIDDLE + RADIUS, MIDDLE, MIDDLE]], contact(1e6)))
    squeeze = np.array([[0.5 * DEPTH, 0.0, 0.0], [-0.5 * DEPTH, 0.0, 0.0]])
    shear = np.array([[0.0, 0.1, 0.05], [0.0, -0.1, -0.05]]) * DEPTH
    dt = 1e-9
    for way in (squeeze, shear):
        carried(work, in_order(work, way) / dt, 0.0, dt)
    before, steps = work.force[0].copy(), 2000
    speed, centre = 0.5 * math.pi / (steps * dt), np.full(3, MIDDLE)
    start = work.bodies.position - centre
    for step in range(1, steps + 1):
        place = turned(start, unit, 0.5 * math.pi * step / steps)
        velocity = np.cross(speed * unit, turned(start, unit, 0.5 * math.pi * (step - 0.5) / steps))
        work.bodies.position[:] = centre + place - dt * velocity
        carried(work, velocity, speed * unit, dt)
    assert np.abs(before[:, 1:]).max() > 0.01 * np.abs(before).max()
    np.testing.assert_allclose(work.force[0], turned(before, unit, 0.5 * math.pi), atol=1e-3 * np.abs(before[:, 1:]).max())


def turned(rows: np.ndarray, unit: np.ndarray, angle: float) -> np.ndarray:
    """Vectors turned about a unit vector (Rodrigues)."""
    along = np.outer(rows @ unit, unit)
    return np.asarray(along + math.cos(angle) * (rows - along) + math.sin(angle) * np.cross(unit, rows))


def test_many_turns_about_the_normal_do_not_blow_the_force_up() -> None:
    """Ten turns of a loaded pair about its line of centres: the force is as large as before, whatever the step (here 10 mrad)."""
    work = working(scene([[MIDDLE - RADIUS, MIDDLE, MIDDLE], [MIDDLE + RADIUS, MIDDLE, MIDDLE]], contact(1e6)))
    dt = 1e-9
    for way in ([[0.5 * DEPTH, 0.0, 0.0], [-0.5 * DEPTH, 0.0, 0.0]], [[0.0, 0.1 * DEPTH, 0.0], [0.0, -0.1 * DEPTH, 0.0]]):
        carried(work, in_order(work, np.array(way)) / dt, 0.0, dt)
    line = work.bodies.position[1] - work.bodies.position[0]
    line /= np.linalg.norm(line)
    before = np.linalg.norm(np.cross(work.force[0], line), axis=1)
    for _ in range(round(20.0 * math.pi / 0.01)):
        carried(work, 0.0, 0.01 / dt * line, dt)
    # the bound of each step's change of length: nothing but round-off
    np.testing.assert_allclose(np.linalg.norm(np.cross(work.force[0], line), axis=1), before, rtol=1e-9)


@pytest.mark.compiled_only(reason="thirty collisions; oblique impacts are run interpreted")
@pytest.mark.parametrize("partner", ["sphere", "wall"])
@pytest.mark.parametrize("asked", [0.05, 0.2, 0.5, 0.8, 1.0])
def test_restitution_that_was_asked_for(asked: float, partner: str) -> None:
    """At every speed the same, of two spheres and on a wall: time steps of 1/100 of the critical one leave their square."""
    for speed in (1e-4, 0.1, 3.0):
        position, velocity = [[MIDDLE, MIDDLE, RADIUS]], [[0.0, 0.0, -speed]]
        if partner == "sphere":
            position, velocity = (
                [[MIDDLE - RADIUS, MIDDLE, MIDDLE], [MIDDLE + RADIUS, MIDDLE, MIDDLE]],
                [[speed, 0.0, 0.0], [0.0, 0.0, 0.0]],
            )
        start = scene(position, contact(restitution=asked), velocity)
        deepest = 3.0 * DEPTH * speed**0.8
        work = collided(start, step_for(start, deepest, 0.01))
        v = in_order(work, work.bodies.velocity)
        after = v[0, 2] if partner == "wall" else v[1, 0] - v[0, 0]
        assert after / speed == pytest.approx(asked, rel=2e-3)


def test_a_damper_never_pulls() -> None:
    """Of an overdamped collision, force by force."""
    start = scene([[MIDDLE, MIDDLE, RADIUS]], contact(restitution=0.05), [[0.0, 0.0, -1.0]])
    work, dt = working(start), 1e-10
    forces = []
    for way in np.concatenate([np.full(60, -1.0), np.full(80, 1.0)]):
        carried(work, [[0.0, 0.0, way]], 0.0, dt)
        forces.append(work.force[0, 0, 2])
    assert max(forces) > 0.0
    assert min(forces) >= 0.0
