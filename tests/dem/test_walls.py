"""Walls: the law's own force, momentum, columns of springs, rolling on them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import dem
from contactlaws import dispatch
from dem.measure import energies, largest_overlap, network, stress_tensor
from dem.quasi_static import step_to
from dem.scene import QuasiStatic
from dem.working import follow, working
from tests.dem.scenes import (
    DENSITY,
    INERTIA,
    MASS,
    MATERIAL,
    MIDDLE,
    NEVER_YIELDS,
    RADIUS,
    YIELDS,
    contact,
    scene,
    step_for,
    still,
    walled_crystal,
)

#: pair and wall take the same modulus at their share of the overlap
STIFFNESS = 4.0 / 3.0 * MATERIAL.reduced_modulus * math.sqrt(RADIUS)


@pytest.mark.parametrize("law", [NEVER_YIELDS, YIELDS], ids=["elastic", "plastic"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_sphere_on_a_wall_is_a_body_on_a_rigid_flat(law: object, axis: int) -> None:
    """The law's own force to the last bits of the position, 1e-16 of R over an overlap of 1e-3 R; at either end of the box."""
    overlap = 1e-3 * RADIUS
    expected, _ = dispatch.normal_force(law, overlap, 0.0, 0.0, dispatch.initial_state(law))
    for end in (0, 1):
        place = np.full(3, MIDDLE)
        place[axis] = RADIUS - overlap if end == 0 else 2.0 * MIDDLE - (RADIUS - overlap)
        walls = (axis == 0, axis == 1, axis == 2)
        work = working(scene([place], contact(law=law), walls=walls))
        wanted = np.zeros(3)
        wanted[axis] = expected if end == 0 else -expected
        np.testing.assert_allclose(work.force[0, 0], wanted, rtol=1e-11)  # 1.5 times 40e-16/1e-3
        np.testing.assert_array_equal(work.reaction.sum(axis=(0, 1)), -work.force[0, 0])


def test_the_walls_take_what_the_spheres_lose() -> None:
    """The reaction over time is the momentum of a sphere that bounces: kicks by the same numbers, so round-off of their sum."""
    start = scene([[MIDDLE, MIDDLE, 1.001 * RADIUS]], contact(0.3, restitution=0.7), [[0.4, 0.0, -1.0]])
    dt, work, impulse = step_for(start, 0.01 * RADIUS, 0.1), working(start), np.zeros(3)
    for _ in range(2000):
        impulse += 0.5 * dt * work.reaction.sum(axis=(0, 1))
        work, _ = follow(work, still(work, dt), 0, 1)
        impulse += 0.5 * dt * work.reaction.sum(axis=(0, 1))
    assert work.bodies.velocity[0, 2] > 0.5
    np.testing.assert_allclose(impulse, MASS * (np.array([0.4, 0.0, -1.0]) - work.bodies.velocity[0]), atol=1e-12 * MASS)


@pytest.mark.parametrize(("affine", "moving"), [(True, 0.0), (False, 0.0), (False, 0.5), (False, 1.0)])
def test_a_column_between_walls_is_springs_in_series(affine: bool, moving: float) -> None:
    """Three spheres on each other: one force F in all contacts, 2 (F/k_pair)^(2/3) + 2 (F/k_wall)^(2/3) of overlap; and its work.

    Pressed in steps of rest, whose forces are balanced to a thousandth of the mean; the stored energy is 2/5 F times all overlaps.
    """
    squeeze = 0.004
    column = [[MIDDLE, MIDDLE, (2.0 * k + 1.0) * RADIUS] for k in range(3)]
    box = dem.Box((2.0 * MIDDLE, 2.0 * MIDDLE, 6.0 * RADIUS), (False,) * 3)
    programme = (dem.Stage((1.0, 1.0, 1.0 - squeeze), 1.0),)
    settings = {"outputs": 4, "box": box, "affine": affine, "moving_walls": moving, "programme": programme}
    run = dem.run(scene(column, contact(), quasi_static=QuasiStatic(force=1e-6), **settings))  # type: ignore[arg-type]
    assert run.stopped is None
    pair, wall = 0.5 * STIFFNESS * math.sqrt(0.5), STIFFNESS
    compliance = 2.0 * pair ** (-2.0 / 3.0) + 2.0 * wall ** (-2.0 / 3.0)
    force = (6.0 * RADIUS * run.strain[:, 2] / compliance) ** 1.5
    np.testing.assert_allclose(run.stress[:, 2, 2] * (2.0 * MIDDLE) ** 2, force, rtol=1e-5, atol=1e-9 * force.max())
    np.testing.assert_allclose(run.energies.stored, 0.4 * force * 6.0 * RADIUS * run.strain[:, 2], rtol=1e-5, atol=1e-30)
    # the trapezium over a force that goes with d^1.5, in four steps of the edge
    assert run.energies.boundary_work[-1] == pytest.approx(run.energies.stored[-1], rel=0.03)


@pytest.mark.compiled_only(reason="searches for rest")
def test_the_stress_is_what_the_walls_feel() -> None:
    """At rest the stress from the contacts inside is force over area at each wall (as accurate as the balance of forces)."""
    packing = walled_crystal()
    made = dem.packed_scene(
        packing, DENSITY, contact(0.3), (dem.Stage((1.0, 1.0, 0.98), 1.0),), walls=(False, False, True)
    )  # fmt: skip
    work = working(made)
    for share in (0.99, 0.98):
        cell = made.box.stretched((1.0, 1.0, share)).cell
        work, rest = step_to(work, cell, 1.0, True, lambda overlap: step_for(made, overlap, 1.0), 1e-6, QuasiStatic(force=1e-4))
        assert rest.found
    area = work.box.lengths[0] * work.box.lengths[1]
    low, high = work.reaction.sum(axis=0)[:, 2] / area
    stress = float(stress_tensor(work)[2, 2])
    assert -low == pytest.approx(stress, rel=1e-3)
    assert high == pytest.approx(stress, rel=1e-3)


def rolling_scene(velocity: float, roll: float, depth: float = 1e-3) -> dem.Scene:
    """A sphere on a floor, pressed by a roof: a second sphere, ten thousand times as large, too heavy to move, without friction."""
    large = 1e4 * RADIUS
    # the roof is a pair's contact, of half the modulus: deeper by 2^(2/3) for the same force, so that the sphere lies still
    up = (2.0 - depth - 2.0 ** (2.0 / 3.0) * depth * (1.0 + 1e-4) ** (1.0 / 3.0)) * RADIUS + large
    bodies = dem.spheres([[0.0, 0.0, RADIUS * (1.0 - depth)], [0.0, 0.0, up]], [RADIUS, large], DENSITY)
    mass = np.array([MASS, 1e12 * MASS])
    spin = np.array([[0.0, velocity / RADIUS if roll else 0.0, 0.0], [0.0, 0.0, 0.0]])
    moving = np.array([[velocity, 0.0, 0.0], [0.0, 0.0, 0.0]])
    bodies = bodies._replace(mass=mass, velocity=moving, spin=spin, kind=np.array([0, 1]))
    box, smooth = dem.Box((4.0 * large,) * 3, (False,) * 3), contact()
    floor, walls = contact(0.3, roll), (False, False, True)
    return dem.Scene(bodies, box, smooth, (dem.hold(1.0),), between=((0, 0, floor),), walls=walls, skin=1e-3)


@pytest.mark.compiled_only(reason="thousands of steps")
def test_a_sliding_sphere_ends_rolling_at_five_sevenths() -> None:
    """v + 2/5 R w is kept (angular momentum about the floor), and rolling has v = R w.

    The friction's spring goes on to swing about that.
    """
    speed = 5.0
    made = rolling_scene(speed, 0.0)
    work = working(made)
    press = float(work.reaction[0, 0, 2])
    dt = step_for(made, largest_overlap(work), 0.05)
    ends = 2.0 / 7.0 * speed / (0.3 * abs(press) / MASS)
    dt, seen = ends / 30 / math.ceil(ends / 30 / dt), []
    for _ in range(60):
        work, _ = follow(work, still(work, dt), 0, round(ends / 30 / dt))
        seen.append((work.bodies.velocity[work.order == 0][0, 0], RADIUS * work.bodies.spin[work.order == 0][0, 1]))  # type: ignore[index]
    velocity, turning = np.array(seen).T
    np.testing.assert_allclose(velocity[:28], speed - 0.3 * abs(press) / MASS * ends * np.arange(1, 29) / 30, rtol=1e-3)
    # the arm is shorter than R by the overlap of 1e-3 R, and the roof's slope is 1e-4 a radius gone
    np.testing.assert_allclose(velocity + 0.4 * turning, speed, rtol=3e-3)
    swing = 0.3 * abs(press) / math.sqrt(3.5 * 8.0 * tangential_modulus(made) * math.sqrt(1e-3) * RADIUS * MASS)
    assert swing < 0.1 * speed
    np.testing.assert_allclose(velocity[32:], 5.0 / 7.0 * speed, atol=swing + 3e-3 * speed)


def tangential_modulus(made: dem.Scene) -> float:
    """Of the floor, in Pa."""
    floor = made.contact_with_wall(0).tangential
    assert floor is not None
    return floor.shear_modulus


@pytest.mark.compiled_only(reason="thousands of steps")
def test_a_rolling_sphere_stops_at_the_rate_of_its_resistance() -> None:
    """A moment mu_r R F against a rolling sphere of inertia 7/5 m R^2 about the floor: 5/7 mu_r F/m, until it stands."""
    speed, roll = 0.5, 0.02
    made = rolling_scene(speed, roll)
    work = working(made)
    between = speed / (5.0 / 7.0 * roll * abs(float(work.reaction[0, 0, 2])) / MASS) / 20
    steps, seen = math.ceil(between / step_for(made, largest_overlap(work), 0.1)), []
    for _ in range(40):
        work, _ = follow(work, still(work, between / steps), 0, steps)
        seen.append(work.bodies.velocity[work.order == 0][0, 0])
    # the springs of friction and rolling swing about that
    np.testing.assert_allclose(seen[:18], speed * (1.0 - np.arange(1, 19) / 20), atol=0.02 * speed)
    # it then rocks on its rolling spring, with no more than what that can hold: (mu_r R F)^2/(2 k)
    assert np.abs(seen[24:]).max() < 0.15 * speed


def test_a_sphere_that_spins_between_walls_is_braked_by_their_rolling_resistance() -> None:
    """No friction, two walls: 2 mu_r R F/I, at any position and without moving; the same as one wall twice."""
    squeezed, rate, roll = 1e-3, 1e5, 0.05
    height = 2.0 * (1.0 - squeezed) * RADIUS
    box = dem.Box((2.0 * MIDDLE, 2.0 * MIDDLE, height), (False,) * 3)
    made = scene([[MIDDLE, MIDDLE, 0.5 * height]], contact(0.0, roll), spin=[[0.0, rate, 0.0]], box=box)
    work = working(made)
    moment = 2.0 * roll * RADIUS * STIFFNESS * (squeezed * RADIUS) ** 1.5  # of both walls
    brake = moment / INERTIA
    dt = 0.4 * rate / brake / 200
    work, _ = follow(work, still(work, dt), 0, 200)
    # the moment rises to its bound over a turn of moment/k, in which less than that bound is missing; and the first step has none
    stiffness = 2.0 * 8.0 * tangential_modulus(made) * math.sqrt(squeezed) * RADIUS**3
    rise = brake * (moment / stiffness / rate + 2.0 * dt)
    assert work.bodies.spin is not None
    assert work.bodies.spin[0, 1] == pytest.approx(0.6 * rate, abs=rise)
    assert not np.any(work.bodies.velocity[0, :2])


@pytest.mark.compiled_only(reason="10 000 steps of 32 spheres")
@pytest.mark.parametrize("law", [NEVER_YIELDS, YIELDS], ids=["elastic", "plastic"])
def test_energy_balance_with_friction_and_walls(law: object) -> None:
    """Compressed between walls and released, with friction, rolling resistance and dampers: the balance closes to the promised 1e-3."""
    packing = walled_crystal()
    touch = contact(0.3, 0.02, 0.8, law)
    made = dem.packed_scene(
        packing, DENSITY, touch, dem.uniaxial_compression(0.02), walls=(False, False, True), inertial_number=2e-3, outputs=20
    )
    for affine in (True, False):
        energies = dem.run(dataclasses.replace(made, affine=affine)).energies
        assert np.abs(energies.balance).max() < 1e-3
        for lost in (energies.rubbed, energies.dashed, energies.dissipated):
            assert np.diff(lost).min() >= -1e-4 * energies.boundary_work.max()
        assert energies.rubbed[-1] > 1e-3 * energies.boundary_work.max()
        assert energies.dashed[-1] > 0.0
        assert (energies.dissipated[-1] > 0.0) == (law is YIELDS)


def test_a_wall_given_its_own_physics() -> None:
    """`wall_contact` replaces what follows from the sphere's: a wall twice as stiff pushes twice as hard."""
    position = [[MIDDLE, MIDDLE, 0.999 * RADIUS]]
    stiff = contact(law=NEVER_YIELDS._replace(reduced_modulus=2.0 * NEVER_YIELDS.reduced_modulus)).on_rigid_flat
    one, other = (working(scene(position, contact(), **given)) for given in ({}, {"wall_contact": (stiff,)}))
    np.testing.assert_allclose(other.force, 2.0 * one.force, rtol=1e-15)
    assert network(other).second.tolist() == [-1]
    assert energies(other)[1] == pytest.approx(2.0 * energies(one)[1], rel=1e-15)
