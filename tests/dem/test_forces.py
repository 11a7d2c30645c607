"""Forces and stress against lattices that can be summed by hand, and symmetries."""

from __future__ import annotations

import numpy as np
import pytest

from contactlaws.elastic import Hertz
from dem.box import Box
from dem.measure import coordination, stress_tensor
from dem.packing import body_centred_cubic, face_centred_cubic, simple_cubic
from dem.particles import spheres
from dem.working import Working, working

RADIUS, DENSITY = 5e-6, 4750.0
#: small enough that the change of geometry (3 times it) stays below 1e-6, large enough that round-off (1e-16 over it) does too
STRAIN = 1e-8
LATTICES = {"simple": simple_cubic, "body-centred": body_centred_cubic, "face-centred": face_centred_cubic}


def strained(law: Hertz, kind: str, cells: int, stretch: tuple[float, float, float]) -> tuple[Working, Box]:
    lattice = LATTICES[kind]((cells, cells, cells), RADIUS)
    box = lattice.box.stretched(stretch)
    bodies = spheres(lattice.position * np.array(stretch), RADIUS, DENSITY)
    return working(law, bodies, box, 0.1 * RADIUS), box


@pytest.mark.parametrize("cells", [1, 2, 3])  # one cell: spheres meet several images of each other and of themselves
@pytest.mark.parametrize(
    ("kind", "expected"), [("simple", 2.0 / 3.0), ("body-centred", 2.0 / 3.0**0.5), ("face-centred", 4.0 * 2.0**0.5 / 3.0)]
)
def test_isotropic_stress_of_lattices(hertz: Hertz, kind: str, expected: float, cells: int) -> None:
    work, box = strained(hertz, kind, cells, (1.0 - STRAIN,) * 3)
    stress = stress_tensor(work.virial, work.velocity, work.mass, box.volume) / (0.5 * hertz.reduced_modulus * STRAIN**1.5)
    np.testing.assert_allclose(stress, expected * np.eye(3), atol=1e-6 * expected)
    neighbours = {"simple": 6, "body-centred": 8, "face-centred": 12}[kind]
    assert coordination(work.pairs, work.magnitude) == (neighbours, neighbours, 0)


@pytest.mark.parametrize(
    ("kind", "along", "across"),
    [("simple", 2.0 / 3.0, 0.0), ("body-centred", 2.0 / 9.0, 2.0 / 9.0), ("face-centred", 2.0 / 3.0, 1.0 / 3.0)],
)
def test_uniaxial_stress_of_lattices(hertz: Hertz, kind: str, along: float, across: float) -> None:
    work, box = strained(hertz, kind, 2, (1.0, 1.0, 1.0 - STRAIN))
    stress = stress_tensor(work.virial, work.velocity, work.mass, box.volume) / (0.5 * hertz.reduced_modulus * STRAIN**1.5)
    np.testing.assert_allclose(np.diag(stress), [across, across, along], atol=1e-6 * along)


def test_pair_is_symmetric_for_unequal_radii(hertz: Hertz) -> None:
    position = np.array([[0.0, 0.0, 0.0], [1.1, 0.7, -0.4]]) * RADIUS
    radii = np.array([1.0, 0.5]) * RADIUS
    box = Box((20.0 * RADIUS,) * 3)
    one = working(hertz, spheres(position, radii, DENSITY), box, 0.1 * RADIUS)
    other = working(hertz, spheres(position[::-1], radii[::-1], DENSITY), box, 0.1 * RADIUS)
    a, b = one.force[np.argsort(one.order)], other.force[np.argsort(other.order)]
    assert one.magnitude[0] > 0.0
    np.testing.assert_array_equal(a[0], -a[1])  # the same numbers are added and subtracted
    np.testing.assert_array_equal(a, b[::-1])


def test_equal_radii_given_one_by_one_change_nothing(hertz: Hertz) -> None:
    """The kernel without radii against the one with them."""
    lattice = face_centred_cubic((2, 2, 2), RADIUS)
    bodies = spheres(lattice.position * 0.99, RADIUS, DENSITY)
    box = lattice.box.stretched((0.99, 0.99, 0.99))
    plain = working(hertz, bodies, box, 0.1 * RADIUS)
    listed = working(hertz, bodies._replace(radius=np.full(bodies.size, RADIUS)), box, 0.1 * RADIUS)
    assert plain.radius is None
    assert listed.radius is not None
    np.testing.assert_allclose(listed.virial, plain.virial, rtol=1e-14)  # one multiplication in another order


def test_contact_across_a_corner(hertz: Hertz) -> None:
    edge = 20.0 * RADIUS
    shift = 0.55 * RADIUS
    apart = np.array([[0.0, 0.0, 0.0], [2.0 * shift] * 3])
    across = np.array([[shift] * 3, [edge - shift] * 3])
    box = Box((edge, edge, edge))
    near, far = (working(hertz, spheres(x, RADIUS, DENSITY), box, 0.1 * RADIUS) for x in (apart, across))
    assert far.magnitude[0] == pytest.approx(near.magnitude[0], rel=1e-12)  # round-off of the edge
