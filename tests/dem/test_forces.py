"""Forces and stress against lattices that can be summed by hand, and symmetries."""

from __future__ import annotations

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from dem.box import Box
from dem.measure import coordination, network, stress_tensor
from dem.packing import body_centred_cubic, face_centred_cubic, simple_cubic
from dem.particles import Particles, spheres
from dem.working import Working, working

RADIUS, DENSITY = 5e-6, 4750.0
#: small enough that the change of geometry (3 times it) stays below 1e-6, large enough that round-off (1e-16 over it) does too
STRAIN = 1e-8
LATTICES = {"simple": simple_cubic, "body-centred": body_centred_cubic, "face-centred": face_centred_cubic}


def started(law: Hertz, bodies: Particles, box: Box, **settings: object) -> Working:
    """The state at the start, with a skin of a tenth of a radius."""
    return working(dem.Scene(bodies, box, dem.Contact(law), (dem.hold(1.0),), skin=0.05, **settings))  # type: ignore[arg-type]


def strained(law: Hertz, kind: str, cells: int, stretch: tuple[float, float, float]) -> Working:
    lattice = LATTICES[kind]((cells, cells, cells), RADIUS)
    box = lattice.box.stretched(stretch)
    bodies = spheres(lattice.position * np.array(stretch), RADIUS, DENSITY)
    return started(law, bodies, box)


@pytest.mark.parametrize("cells", [1, 2, 3])  # one cell: spheres meet several images of each other and of themselves
@pytest.mark.parametrize(
    ("kind", "expected"), [("simple", 2.0 / 3.0), ("body-centred", 2.0 / 3.0**0.5), ("face-centred", 4.0 * 2.0**0.5 / 3.0)]
)
def test_isotropic_stress_of_lattices(hertz: Hertz, kind: str, expected: float, cells: int) -> None:
    work = strained(hertz, kind, cells, (1.0 - STRAIN,) * 3)
    stress = stress_tensor(work) / (0.5 * hertz.reduced_modulus * STRAIN**1.5)
    np.testing.assert_allclose(stress, expected * np.eye(3), atol=1e-6 * expected)
    neighbours = {"simple": 6, "body-centred": 8, "face-centred": 12}[kind]
    assert coordination(network(work), work.size) == (neighbours, neighbours, 0)


@pytest.mark.parametrize(
    ("kind", "along", "across"),
    [("simple", 2.0 / 3.0, 0.0), ("body-centred", 2.0 / 9.0, 2.0 / 9.0), ("face-centred", 2.0 / 3.0, 1.0 / 3.0)],
)
def test_uniaxial_stress_of_lattices(hertz: Hertz, kind: str, along: float, across: float) -> None:
    work = strained(hertz, kind, 2, (1.0, 1.0, 1.0 - STRAIN))
    stress = stress_tensor(work) / (0.5 * hertz.reduced_modulus * STRAIN**1.5)
    np.testing.assert_allclose(np.diag(stress), [across, across, along], atol=1e-6 * along)


def test_pair_is_symmetric_for_unequal_radii(hertz: Hertz) -> None:
    position = np.array([[0.0, 0.0, 0.0], [1.1, 0.7, -0.4]]) * RADIUS
    radii = np.array([1.0, 0.5]) * RADIUS
    box = Box((20.0 * RADIUS,) * 3)
    one = started(hertz, spheres(position, radii, DENSITY), box)
    other = started(hertz, spheres(position[::-1], radii[::-1], DENSITY), box)
    a, b = one.force[0][np.argsort(one.order)], other.force[0][np.argsort(other.order)]
    assert np.abs(a).max() > 0.0
    np.testing.assert_array_equal(a[0], -a[1])  # the same numbers are added and subtracted
    np.testing.assert_array_equal(a, b[::-1])


def test_equal_radii_given_one_by_one_change_nothing(hertz: Hertz) -> None:
    """The kernel without radii against the one with them."""
    lattice = face_centred_cubic((2, 2, 2), RADIUS)
    bodies = spheres(lattice.position * 0.99, RADIUS, DENSITY)
    box = lattice.box.stretched((0.99, 0.99, 0.99))
    plain = started(hertz, bodies, box)
    listed = started(hertz, bodies._replace(radius=np.full(bodies.size, RADIUS)), box)
    assert plain.bodies.radius is None
    assert listed.bodies.radius is not None
    np.testing.assert_allclose(listed.virial, plain.virial, atol=1e-14 * plain.virial.max())  # one multiplication in another order


def test_contact_across_a_corner(hertz: Hertz) -> None:
    edge = 20.0 * RADIUS
    shift = 0.55 * RADIUS
    apart = np.array([[0.0, 0.0, 0.0], [2.0 * shift] * 3])
    across = np.array([[shift] * 3, [edge - shift] * 3])
    box = Box((edge, edge, edge))
    near, far = (network(started(hertz, spheres(x, RADIUS, DENSITY), box)) for x in (apart, across))
    assert far.normal_force == pytest.approx(near.normal_force, rel=1e-12)  # round-off of the edge


@pytest.mark.compiled_only(reason="a hundred thousand pairs")
def test_spheres_strewn_over_many_boxes_feel_what_they_feel_in_one(hertz: Hertz) -> None:
    """More images than two bytes can number: each sphere is moved by whole boxes."""
    lattice = face_centred_cubic((15, 15, 15), RADIUS)
    rng = np.random.default_rng(3)
    shift = rng.integers(-40, 41, (len(lattice.position), 3)) * np.array(lattice.box.lengths)
    box = lattice.box.stretched((0.99,) * 3)
    stress, images = [], []
    for moved in (np.zeros_like(shift), shift):
        bodies = dem.spheres((lattice.position + moved) * 0.99, RADIUS, 1.0)
        work = working(dem.Scene(bodies, box, dem.Contact(hertz), (dem.hold(1.0),)))
        stress.append(stress_tensor(work))
        images.append(len(work.listed.images))
    assert images[1] > 65_535
    np.testing.assert_allclose(stress[1], stress[0], rtol=0.0, atol=1e-9 * stress[0].max())  # places 40 boxes away know 1e-14 of a radius
