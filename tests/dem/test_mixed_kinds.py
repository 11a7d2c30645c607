"""Particles of several kinds: every pair by its own law, and what is carried along for nothing changes nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

import dem
from contactlaws import dispatch, pair
from contactlaws.elastic import Hertz
from contactlaws.material import Material
from dem.measure import network, stress_tensor
from dem.motion import Deformation
from dem.packing import face_centred_cubic
from dem.particles import Particles
from dem.timestep import pair_stiffness, scene_time_step
from dem.working import Working, follow, working

RADII, DENSITY = (5e-6, 8e-6), 4750.0
MATERIALS = (Material(142e9, 0.25), Material(2e9, 0.4))
BOX = dem.Box((200e-6,) * 3)


def law_of(one: int, other: int) -> Hertz:
    body = pair.effective(MATERIALS[one], RADII[one], MATERIALS[other], RADII[other])
    return Hertz(body.radius, body.material.reduced_modulus)


def mixed(particles: Particles, **settings: object) -> dem.Scene:
    """Kinds 0 and 1, each pair by the law of its effective body; `contact` is that of two of kind 0."""
    between = ((0, 1, dem.Contact(law_of(0, 1))), (1, 1, dem.Contact(law_of(1, 1))))
    given: dict[str, object] = {"programme": (dem.hold(1.0),), "between": between, **settings}
    return dem.Scene(particles, given.pop("box", BOX), dem.Contact(law_of(0, 0)), **given)  # type: ignore[arg-type]


def two(first: int, second: int, overlap: float) -> Particles:
    apart = RADII[first] + RADII[second] - overlap
    bodies = dem.spheres([[50e-6] * 3, [50e-6 + apart, 50e-6, 50e-6]], [RADII[first], RADII[second]], DENSITY)
    return bodies._replace(radius=np.array([RADII[first], RADII[second]]), kind=np.array([first, second]))


@pytest.mark.parametrize(("first", "second"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_hertz_of_two_materials_and_two_radii(first: int, second: int) -> None:
    """4/3 E* sqrt(R) d^1.5 with the E* and R of the pair, whoever is listed first; equal and opposite to the last bit."""
    overlap = 1e-3 * RADII[0]
    work = working(mixed(two(first, second, overlap)))
    modulus = 1.0 / (1.0 / MATERIALS[first].reduced_modulus + 1.0 / MATERIALS[second].reduced_modulus)
    radius = 1.0 / (1.0 / RADII[first] + 1.0 / RADII[second])
    force = work.force[0][np.argsort(work.order)]
    np.testing.assert_array_equal(force[0], -force[1])
    # round-off of places near 50 um, over the overlap
    assert -force[0, 0] == pytest.approx(4.0 / 3.0 * modulus * math.sqrt(radius) * overlap**1.5, rel=1e-10)


def test_three_in_contact_feel_three_laws() -> None:
    """A row 0 - 1 - 1: each contact belongs to its own group, and no pair is counted twice."""
    overlap = 1e-3 * RADII[0]
    places = np.cumsum([0.0, RADII[0] + RADII[1] - overlap, 2.0 * RADII[1] - overlap])
    bodies = dem.spheres(np.stack([places, 0.0 * places, 0.0 * places], axis=1), [RADII[0], RADII[1], RADII[1]], DENSITY)
    found = network(working(mixed(bodies._replace(kind=np.array([0, 1, 1])))))
    assert sorted(found.group.tolist()) == [1, 2]
    for kinds, group in (((0, 1), 1), ((1, 1), 2)):
        law = law_of(*kinds)
        scale = pair.pair_scale(law, RADII[kinds[0]], RADII[kinds[1]])
        expected, _ = pair.pair_force(law, scale, overlap, 0.0, 0.0, dispatch.initial_state(law))
        assert found.normal_force[found.group == group] == pytest.approx([expected], rel=1e-10)


def test_kinds_of_one_material_are_one_material() -> None:
    """A lattice whose spheres are called by two names and given one law is as if they had one; radii and masses one by one."""
    crystal = face_centred_cubic((2, 2, 2), RADII[0])
    position = crystal.position * 0.99 + np.random.default_rng(3).uniform(-0.002, 0.002, crystal.position.shape) * RADII[0]
    bodies = dem.spheres(position, RADII[0], DENSITY)._replace(radius=np.full(32, RADII[0]))
    box = crystal.box.stretched((0.99,) * 3)
    same = dem.Contact(law_of(0, 0))
    named = mixed(bodies._replace(kind=np.arange(32) % 2), box=box, between=((0, 1, same), (1, 1, same)))
    one, other = working(dem.Scene(bodies, box, same, (dem.hold(1.0),))), working(named)
    # the same numbers summed in another order
    np.testing.assert_allclose(other.force, one.force, rtol=0.0, atol=1e-13 * np.abs(one.force).max())
    np.testing.assert_allclose(stress_tensor(other), stress_tensor(one), rtol=1e-12, atol=1e-12 * one.virial.max() / box.volume)


@pytest.mark.parametrize("walls", [False, True])
def test_the_time_step_is_that_of_the_stiffest_and_lightest(walls: bool) -> None:
    """Of all pairs of kinds and each kind on its wall."""
    bodies = two(0, 1, 1e-9)
    made = mixed(bodies, walls=(False, False, walls), box=dem.Box((200e-6,) * 3, (True, True, not walls)))
    found = scene_time_step(made, 1e-8, 1.0)
    steps = []
    for one in (0, 1):
        for other in (0, 1):
            stiffness = pair_stiffness(dem.Contact(law_of(one, other)), RADII[one], RADII[other], 1e-8)
            steps.append(math.sqrt(bodies.mass[one] / (6.0 * stiffness)))
        if walls:
            flat = pair_stiffness(dem.Contact(law_of(one, one)).on_rigid_flat, RADII[one], None, 1e-8)
            steps.append(math.sqrt(bodies.mass[one] / (6.0 * flat)))
    assert found.critical == pytest.approx(min(steps), rel=1e-12)


CARRIES = [("radius",), ("mass",), ("rates",), ("rotation",), ("radius", "mass", "rates", "rotation")]


@pytest.mark.parametrize("carry", CARRIES, ids=lambda carry: "-".join(carry))
def test_what_is_carried_for_nothing_changes_nothing(carry: tuple[str, ...]) -> None:
    """Everything that a scene leaves out, carried along all the same: 20 steps of a swinging lattice, equal to round-off."""
    crystal = face_centred_cubic((1, 1, 1), RADII[0])
    position = crystal.position * 0.99 + np.random.default_rng(3).uniform(-0.002, 0.002, crystal.position.shape) * RADII[0]
    bodies, box = dem.spheres(position, RADII[0], DENSITY), crystal.box.stretched((0.99,) * 3)
    contact = dem.Contact(law_of(0, 0))
    plain, full = (dem.Scene(bodies, box, contact, (dem.hold(1.0),), carry=names) for names in ((), carry))
    dt = scene_time_step(plain, 0.03 * RADII[0], 0.4).dt
    one, other = (_followed(made, dt) for made in (plain, full))
    carried = {
        "radius": other.bodies.radius,
        "mass": other.bodies.mass,
        "rates": other.groups[0].roles.rates,
        "rotation": other.bodies.spin,
    }
    assert all((carried[name] is not None) == (name in carry) for name in carried)
    # 20 steps of round-off, which a lattice that swings does not amplify
    np.testing.assert_allclose(other.bodies.position, one.bodies.position, rtol=0.0, atol=1e-13 * RADII[0])
    np.testing.assert_allclose(other.force, one.force, rtol=0.0, atol=1e-11 * np.abs(one.force).max())


def _followed(made: dem.Scene, dt: float) -> Working:
    work = working(made)
    return follow(work, Deformation(work.cell.copy(), work.cell.copy(), 100, dt), 0, 20)[0]
