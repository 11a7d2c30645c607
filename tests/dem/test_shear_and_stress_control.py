"""Sheared boxes against lattice sums, and boxes that follow a stress."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.prony import Relaxation
from contactlaws.tangential import mindlin
from dem.box import Box
from dem.measure import network, stress_tensor
from dem.packing import Packing, body_centred_cubic, face_centred_cubic, simple_cubic
from dem.quasi_static import step_to
from dem.scene import QuasiStatic
from dem.timestep import scene_time_step
from dem.working import Working, working
from tests.dem.scenes import MATERIAL, RADIUS

DENSITY = 4750.0
LATTICES = {"simple": simple_cubic, "body-centred": body_centred_cubic, "face-centred": face_centred_cubic}
#: of the lattices before they are sheared
SQUEEZED = 0.99


def sheared(kind: str, law: Hertz, angle: float, cells: int = 2) -> Working:
    """A squeezed lattice, sheared along x by `angle` times the height."""
    lattice = LATTICES[kind]((cells,) * 3, RADIUS)
    position = lattice.position * SQUEEZED
    position[:, 0] += angle * position[:, 2]
    box = lattice.box.stretched((SQUEEZED,) * 3, (0.0, angle, 0.0))
    return working(dem.Scene(dem.spheres(position, RADIUS, DENSITY), box, dem.Contact(law), (dem.hold(1.0),)))


def shear_modulus(work: Working, law: Hertz) -> float:
    """-d(sigma_xz)/d(angle) of central forces: 1/V of the sum over contacts of k x^2 z^2/r^2 - F (z^2/r - x^2 z^2/r^3)."""
    found = network(work)
    x, z, r = found.branch[:, 0], found.branch[:, 2], np.linalg.norm(found.branch, axis=1)
    stiffness = 1.5 * found.normal_force / found.overlap
    return float(np.sum(stiffness * (x * z / r) ** 2 - found.normal_force * (z**2 / r - (x * z) ** 2 / r**3)) / work.box.volume)


@pytest.mark.parametrize("kind", LATTICES)
def test_shear_modulus_of_lattices(kind: str, hertz: Hertz) -> None:
    """Central differences of the stress over 1e-5: its square, times what the force law bends, is far below 1e-6."""
    step = 1e-5
    stress = [stress_tensor(sheared(kind, hertz, angle))[0, 2] for angle in (-step, step)]
    expected = -shear_modulus(sheared(kind, hertz, 0.0), hertz)
    assert (stress[1] - stress[0]) / (2.0 * step) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("angle", [1.3, -2.7, 1.0])
@pytest.mark.parametrize("cells", [1, 2, 3])
def test_a_far_sheared_box_is_its_upright_twin(angle: float, cells: int, hertz: Hertz) -> None:
    """A simple lattice sheared by a whole number is the same lattice: stress to round-off of places some boxes away."""
    far, near = (stress_tensor(sheared("simple", hertz, a, cells)) for a in (angle, angle - round(angle)))
    assert np.abs(near).max() > 0.0
    np.testing.assert_allclose(far, near, rtol=0.0, atol=1e-10 * np.abs(near).max())


@pytest.mark.compiled_only(reason="thousands of steps")
def test_shearing_there_step_by_step_gives_the_same(hertz: Hertz) -> None:
    """The programme shears the box by 1.3 in time, with pair lists made on the way; each sphere of a lattice stays where symmetry holds it.

    Velocities relative to the box stay 0 but for round-off, which an unstable lattice lets grow: a drag holds it down.
    """
    lattice = simple_cubic((3, 3, 3), RADIUS)
    box = lattice.box.stretched((SQUEEZED,) * 3)
    bodies = dem.spheres(lattice.position * SQUEEZED, RADIUS, DENSITY)
    made = dem.Scene(bodies, box, dem.Contact(hertz), (dem.simple_shear(1.3, 5e-7),), outputs=13)
    run = dem.run(made)
    np.testing.assert_allclose(run.shear[:, 1], np.linspace(0.0, 1.3, 14), atol=1e-12)
    for output in (3, 10, 13):
        expected = stress_tensor(sheared("simple", hertz, 0.1 * output, 3))
        np.testing.assert_allclose(run.stress[output], expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())
    assert run.statistics["pair_lists"] > 5


@pytest.mark.compiled_only(reason="searches for rest")
def test_friction_stiffens_a_lattice_as_its_springs_say() -> None:
    """Infinite friction and spheres that turn freely, so that only the symmetric part of the shear stretches their springs.

    A face-centred lattice has per volume the same number of contacts in each of 6 directions (0, 1, 1)/sqrt(2), ...: with r = 2R, the
    shear modulus is r^2 n_c/V (k <nx^2 nz^2> + k_t/4 <nx^2 + nz^2 - 4 nx^2 nz^2>) = r^2 n_c/V (k/12 + k_t/12); 4 x 6 contacts a cell.
    Prestress changes it by the overlap over the radius, 1e-4 here.
    """
    law, depth, step = Hertz(RADIUS, MATERIAL.reduced_modulus), 1e-4, 1e-8
    friction = mindlin(1e6, MATERIAL)
    lattice = face_centred_cubic((2, 2, 2), RADIUS)
    box = lattice.box.stretched((1.0 - depth,) * 3)
    bodies = dem.spheres(lattice.position * (1.0 - depth), RADIUS, DENSITY)
    made = dem.Scene(bodies, box, dem.Contact(law, friction), (dem.simple_shear(1e-3, 1.0),), quasi_static=QuasiStatic(force=1e-8))
    work = working(made)
    cell = box.stretched((1.0, 1.0, 1.0), (0.0, step, 0.0)).cell
    work, rest = step_to(
        work, cell, 1.0, True, lambda overlap: scene_time_step(made, overlap, 1.0).critical, 1e-12, QuasiStatic(force=1e-8)
    )
    assert rest.found
    overlap, edge = 2.0 * RADIUS * depth, lattice.box.lengths[0] / 2.0
    radius = np.sqrt(0.5 * RADIUS * overlap)
    normal, tangential = law.reduced_modulus * radius, 8.0 * friction.shear_modulus * radius
    expected = (2.0 * RADIUS) ** 2 * 24.0 / edge**3 * (normal + tangential) / 12.0
    assert -stress_tensor(work)[0, 2] / step == pytest.approx(expected, rel=2e-3)


@pytest.mark.compiled_only(reason="10 000 steps of 32 spheres")
@pytest.mark.parametrize("way", ["dynamic", "quasi-static"])
def test_stress_control_reaches_its_target(way: str, hertz: Hertz, shaken_crystal: Packing) -> None:
    """From loose to a pressure on every edge: the servo to the share that its strain rate leaves, the search to its tolerance."""
    pressure = 1e-3 * hertz.reduced_modulus
    settings = {"quasi_static": QuasiStatic()} if way == "quasi-static" else {"inertial_number": 2e-3}
    stages = (dem.confined(pressure), *((dem.confined(pressure),) if way == "dynamic" else ()))
    made = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), stages, outputs=5, **settings)
    run = dem.run(made)
    assert run.stopped is None
    allowed = 3e-3 if way == "quasi-static" else 1e-2
    np.testing.assert_allclose(np.diag(run.stress[-1]), pressure, rtol=allowed)
    assert (run.strain[-1] > 0.01).all()


@pytest.mark.compiled_only(reason="searches for rest")
def test_one_edge_held_and_two_pressed(hertz: Hertz, shaken_crystal: Packing) -> None:
    """Biaxial: strain along x, stress along y and z."""
    pressure = 1e-3 * hertz.reduced_modulus
    stages = (dem.confined(pressure), dem.Stage((0.97, 1.0, 1.0), stress=(None, pressure, pressure)))
    made = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), stages, outputs=4, quasi_static=QuasiStatic())
    run = dem.run(made)
    assert run.stopped is None
    np.testing.assert_allclose(np.diag(run.stress[-1])[1:], pressure, rtol=3e-3)
    confined = run.strain[4]
    np.testing.assert_allclose(1.0 - run.strain[-1, 0], 0.97 * (1.0 - confined[0]), rtol=1e-12)  # of the box that was confined


@pytest.mark.compiled_only(reason="searches for rest")
@pytest.mark.parametrize("way", ["dynamic", "quasi-static"])
def test_a_stage_goes_on_from_where_the_stress_was_reached(way: str, hertz: Hertz, shaken_crystal: Packing) -> None:
    """Confine, shear, hold: the edges stay as the confinement left them, at constant volume, and the hold keeps the shear."""
    pressure, angle = 1e-3 * hertz.reduced_modulus, 0.02
    settings = {"quasi_static": QuasiStatic()} if way == "quasi-static" else {"inertial_number": 5e-3}
    programme = (dem.confined(pressure), dem.simple_shear(angle), dem.hold(1e-7))
    run = dem.run(dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), programme, outputs=4, **settings))
    assert run.stopped is None
    assert (run.strain[4] > 0.01).all()
    np.testing.assert_allclose(run.strain[5:], np.broadcast_to(run.strain[4], (8, 3)), rtol=1e-12)
    np.testing.assert_allclose(
        run.shear[:, 1], [*[0.0] * 5, *(np.arange(1, 5) * angle / 4), *[angle] * 4], rtol=1e-5, atol=1e-15
    )  # of edges that the stress left unequal


@pytest.mark.compiled_only(reason="searches for rest")
def test_a_second_stress_begins_with_the_first(hertz: Hertz, shaken_crystal: Packing) -> None:
    """In even parts from there, within the search's tolerance."""
    pressure = 1e-3 * hertz.reduced_modulus
    made = dem.packed_scene(
        shaken_crystal,
        DENSITY,
        dem.Contact(hertz),
        (dem.confined(pressure), dem.confined(2.0 * pressure)),
        outputs=4,
        quasi_static=QuasiStatic(),
    )
    run = dem.run(made)
    expected = pressure * np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0])
    np.testing.assert_allclose(run.pressure[1:], expected, rtol=3e-3 * 4.0)


@pytest.mark.compiled_only(reason="searches for rest")
def test_a_lattice_creeps_under_its_pressure_as_one_contact() -> None:
    """At constant force the overlap of a relaxing contact grows to (E0/E_infinity)^(2/3) of that at once: half the modulus here.

    The pressure is that of the force, but for the box: it shrinks by the overlap, 1e-4. Over ten relaxation times in 20 steps.
    """
    law = maxwell_zener(Relaxation(MATERIAL.reduced_modulus, (0.5,), (1.0,)), RADIUS)
    lattice, at_once = face_centred_cubic((2, 2, 2), RADIUS), Hertz(RADIUS, MATERIAL.reduced_modulus)
    box = lattice.box.stretched((0.9999,) * 3)
    bodies = dem.spheres(lattice.position * 0.9999, RADIUS, DENSITY)
    still = working(dem.Scene(bodies, box, dem.Contact(at_once), (dem.hold(1.0),)))
    pressure = float(np.trace(stress_tensor(still)) / 3.0)
    programme = (dem.confined(pressure, 1e-6), dem.hold(10.0, pressure))
    bodies = dem.spheres(lattice.position, RADIUS, DENSITY)
    made = dem.Scene(bodies, lattice.box, dem.Contact(law), programme, outputs=20, neglect=0.0, quasi_static=QuasiStatic(force=1e-6))
    run = dem.run(made)
    assert run.stopped is None
    np.testing.assert_allclose(run.pressure[20:], pressure, rtol=4e-3)
    overlap = run.strain[:, 0] * 2.0 * RADIUS
    assert overlap[20] == pytest.approx(1e-4 * 2.0 * RADIUS, rel=4e-3)
    assert overlap[-1] / overlap[20] == pytest.approx(2.0 ** (2.0 / 3.0), rel=1e-2)


@pytest.mark.compiled_only(reason="searches for rest")
@pytest.mark.parametrize("stage", [dem.Stage((1.0, 1.0, 0.98), 1.0), dem.isotropic_compression(0.02, 1.0)], ids=["uniaxial", "isotropic"])
def test_carried_along_or_not_a_lattice_ends_in_one_state(stage: dem.Stage, hertz: Hertz) -> None:
    """BCT and BC: forces of the state of rest are the same to the balance that ends the search."""
    lattice = body_centred_cubic((2, 2, 2), RADIUS)
    made = dem.packed_scene(
        lattice, DENSITY, dem.Contact(hertz), (stage,), outputs=5, quasi_static=QuasiStatic(force=1e-6, kinetic=1e-12, displacement=1e-8)
    )
    one, other = (dem.run(dataclasses.replace(made, affine=affine)) for affine in (True, False))
    assert one.stopped is None
    assert other.stopped is None
    np.testing.assert_allclose(other.stress, one.stress, rtol=0.0, atol=1e-5 * one.stress.max())
    np.testing.assert_allclose(other.energies.stored, one.energies.stored, rtol=1e-5, atol=1e-12 * one.energies.stored.max())


def test_a_box_that_is_pressed_by_nothing_stays(hertz: Hertz) -> None:
    """A single sphere far from its images feels no stress: with none asked for, nothing moves."""
    bodies, box = dem.spheres([[RADIUS] * 3], RADIUS, DENSITY), Box((20.0 * RADIUS,) * 3)
    made = dem.Scene(bodies, box, dem.Contact(hertz), (dem.confined(0.0),), quasi_static=QuasiStatic(), outputs=2)
    run = dem.run(made)
    assert run.stopped is None
    np.testing.assert_array_equal(run.strain, 0.0)
