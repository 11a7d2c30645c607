"""Conservation: momentum, energy with the square of the step, work of the boundary."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from dem.box import Box
from dem.measure import energies, kinetic_energy
from dem.motion import Deformation
from dem.packing import Packing, face_centred_cubic
from dem.particles import Particles, spheres
from dem.timestep import critical_step, time_step
from dem.working import Working, follow, working

RADIUS, DENSITY = 5e-6, 4750.0


def started(law: Hertz, bodies: Particles, box: Box, skin: float) -> Working:
    return working(dem.Scene(bodies, box, dem.Contact(law), (dem.hold(1.0),), skin=skin))


@pytest.mark.compiled_only(reason="10 000 steps of 32 spheres")
def test_momentum_of_a_free_gas(hertz: Hertz) -> None:
    """Each force is added to one sphere and subtracted from another, so only round-off of the sums is left: 1e-16 times their number."""
    rng = np.random.default_rng(1)
    lattice = face_centred_cubic((2, 2, 2), RADIUS)
    box = lattice.box.stretched((1.3, 1.3, 1.3))
    bodies = spheres(lattice.position * 1.3, RADIUS, DENSITY, rng.normal(size=(32, 3)) * 10.0)
    scene = dem.Scene(bodies, box, dem.Contact(hertz), (dem.Stage((1.0, 1.0, 1.0), 2e-6),), outputs=10, time_step_fraction=0.2)
    trajectory = dem.run(scene)
    assert trajectory.statistics["largest_overlap"] > 0.0  # they did collide
    before, after = (bodies.mass[0] * trajectory.frames[k].velocity for k in (0, -1))
    assert np.abs(after - before).max() > 0.1 * np.abs(before).max()
    np.testing.assert_allclose(after.sum(axis=0), before.sum(axis=0), atol=1e-13 * np.abs(before).sum())
    assert not np.any(trajectory.energies.boundary_work)


def test_energy_drift_falls_with_the_square_of_the_step(hertz: Hertz) -> None:
    """A compressed crystal that swings without losing a contact, where the force is smooth: the order is 2, to 5 % of itself."""
    rng = np.random.default_rng(2)
    lattice = face_centred_cubic((2, 2, 2), RADIUS)
    box = lattice.box.stretched((0.99, 0.99, 0.99))
    bodies = spheres(lattice.position * 0.99, RADIUS, DENSITY, rng.normal(size=(32, 3)) * 1.0)
    unit = time_step(hertz, bodies, 0.03 * RADIUS, 1.0).dt
    errors, parts = [], (10, 20, 40)
    for per_step in parts:
        work = started(hertz, bodies, box, 0.1)
        found = []
        for step in range(0, 8 * per_step, per_step // 10):
            found.append(sum(energies(work)[:2]))
            work, _ = follow(work, Deformation(box.cell, box.cell, 10**6, unit / per_step), step, per_step // 10)
        errors.append(np.abs(np.array(found) - found[0]).max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.1)


def test_two_spheres_diverge_just_beyond_the_critical_step(hertz: Hertz) -> None:
    """The bound is sharp for a pair (z = 1): linear about a compressed state, stable at 0.99 of it and not at 1.01.

    The two are pressed together by their images, which doubles the springs that act on each, so z = 2.
    """
    depth = 1e-3 * RADIUS
    edge = 4.0 * RADIUS - 2.0 * depth
    box = Box((edge, 10.0 * RADIUS, 10.0 * RADIUS))
    position = [[0.0, 0.0, 0.0], [0.5 * edge, 0.0, 0.0]]
    nudge = 1e-9 * RADIUS
    bodies = spheres(np.array(position) + np.array([[nudge, 0.0, 0.0], [-nudge, 0.0, 0.0]]), RADIUS, DENSITY)
    stiffness = time_step(hertz, bodies, depth, 1.0).stiffness
    grown = []
    for fraction in (0.99, 1.01):
        work = started(hertz, bodies, box, 0.5)
        dt = fraction * critical_step(bodies.mass[0], stiffness, contacts=2)
        work, _ = follow(work, Deformation(box.cell, box.cell, 10**6, dt), 0, 60)
        grown.append(kinetic_energy(work) / (stiffness * nudge**2))
    assert grown[0] < 100.0 < 1e4 < grown[1]


def test_a_lone_sphere_in_a_shrinking_box_keeps_speed_times_length(hertz: Hertz) -> None:
    """Adiabatic compression of one free particle, exact in every step; the boundary's work is its kinetic energy."""
    bodies = spheres([[1.0 * RADIUS] * 3], RADIUS, DENSITY, [[1.0, 2.0, 3.0]])
    stage = dem.Stage((1.0, 0.8, 0.5), 1e-6)
    scene = dem.Scene(bodies, Box((20.0 * RADIUS,) * 3), dem.Contact(hertz), (stage,), outputs=5, drag=None)
    trajectory = dem.run(scene)
    np.testing.assert_allclose(trajectory.frames[-1].velocity[0], [1.0, 2.0 / 0.8, 3.0 / 0.5], rtol=1e-12)
    np.testing.assert_allclose(trajectory.energies.balance, 0.0, atol=1e-12)


@pytest.mark.compiled_only(reason="10 000 steps of 32 spheres; the balance of a user's law is run interpreted")
@pytest.mark.parametrize("drag", [None, 2.5])
@pytest.mark.parametrize("law_name", ["hertz", "soft_plastic"])
def test_energy_balance(law_name: str, drag: float | None, shaken_crystal: Packing, request: pytest.FixtureRequest) -> None:
    """Kinetic, stored, dissipated and damped energy against the work of the boundary, to the 1e-3 that a run promises."""
    law = request.getfixturevalue(law_name)
    scene = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(law), dem.uniaxial_compression(0.03), inertial_number=2e-3, outputs=20)
    trajectory = dem.run(dataclasses.replace(scene, drag=drag))
    energies = trajectory.energies
    assert np.abs(energies.balance).max() < 1e-3
    assert energies.stored.max() > 0.05 * energies.boundary_work.max()
    for lost in (energies.dissipated, energies.damped):
        assert np.diff(lost).min() >= -1e-14 * lost.max()  # never given back; round-off of the sum over contacts
    assert (energies.damped[-1] > 0.0) == (drag is not None)
    assert (energies.dissipated[-1] > 0.0) == isinstance(law, Thornton)


@pytest.mark.compiled_only(reason="hundreds of pair lists; their rebuilding is tested by itself")
def test_skin_decides_the_cost_not_the_result(soft_plastic: Thornton, shaken_crystal: Packing) -> None:
    """Memory survives new lists: one for every few steps and one for ever give the same path, to round-off that collisions amplify."""
    scene = dem.packed_scene(
        shaken_crystal, DENSITY, dem.Contact(soft_plastic), dem.uniaxial_compression(0.02), inertial_number=5e-3, outputs=10
    )
    runs = [dem.run(dataclasses.replace(scene, skin=skin)) for skin in (1e-5, 0.5)]
    assert runs[0].statistics["pair_lists"] > 20 * runs[1].statistics["pair_lists"]
    assert runs[0].energies.dissipated[-1] > 0.0
    np.testing.assert_allclose(runs[0].stress, runs[1].stress, rtol=1e-8, atol=1e-8 * runs[1].stress.max())
    np.testing.assert_allclose(runs[0].energies.dissipated, runs[1].energies.dissipated, rtol=1e-8)


def test_released_plastic_contacts_are_forgotten_but_not_their_losses(soft_plastic: Thornton) -> None:
    """A chain is pressed, pulled apart and pressed again: the second time it starts as new, and has dissipated twice as much."""
    edge = 2.0 * RADIUS
    box = Box((edge, 10.0 * RADIUS, 10.0 * RADIUS))
    bodies = spheres([[0.0, 0.0, 0.0]], RADIUS, DENSITY)
    stages = [dem.Stage((stretch, 1.0, 1.0), 1e-6) for stretch in (0.99, 1.01, 1.0, 0.99, 1.01)]
    trajectory = dem.run(dem.Scene(bodies, box, dem.Contact(soft_plastic), tuple(stages), outputs=50))
    lost = trajectory.energies.dissipated
    assert lost[100] > 0.0
    assert lost[250] == pytest.approx(2.0 * lost[100], rel=1e-9)  # the same path twice, to round-off
    np.testing.assert_allclose(trajectory.stress[150:201, 0, 0], trajectory.stress[:51, 0, 0], atol=1e-9 * trajectory.stress.max())
