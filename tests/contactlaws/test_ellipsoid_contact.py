"""Contacts of ellipsoids that keep their place: against Hertz, against each other, and against the sphere."""

import math

import numpy as np
import pytest

from contactlaws.contact_ellipse import exact_factors
from contactlaws.ellipsoid_contact import of_pair, on_flat
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.whole_range import whole_range, whole_range_force

NMC = Material(142e9, 0.25, 7.9e9)


def test_an_elastic_ellipsoid_on_a_flat_is_hertz():
    """Curvatures a/b^2 and a/c^2 at the pole; the exact factors of their ratio."""
    a, b, c = 5e-6, 6e-6, 4e-6
    contact = on_flat(Material(142e9, 0.25), (a, b, c))
    radius, factors = b * c / a, exact_factors((b / c) ** 2)
    path = contact.along([1e-8])
    force = 4.0 / 3.0 * NMC.reduced_modulus * math.sqrt(radius) * (1e-8 / factors.approach) ** 1.5
    assert path.force[0] == pytest.approx(force, rel=1e-5)  # the kernel's factors are good to 3e-6
    assert path.semi_axes[0, 1] / path.semi_axes[0, 0] == pytest.approx(factors.axes, rel=1e-12)
    assert path.semi_axes[0].prod() == pytest.approx(path.contact_radius[0] ** 2, rel=1e-12)


def test_two_equal_ellipsoids_are_each_on_a_flat_at_half_the_overlap():
    axes, depth = (5e-6, 6e-6, 4e-6), np.array([1e-8, 1e-7, 4e-7, 3.5e-7])
    pair, single = of_pair(NMC, axes, NMC, axes), on_flat(NMC, axes)
    assert pair.along(2.0 * depth).force == pytest.approx(single.along(depth).force, rel=1e-12)


def test_a_pair_is_the_same_whichever_is_named_first_and_however_it_is_turned():
    other = Material(70e9, 0.3, 0.9e9)
    one, two = (5e-6, 6e-6, 4e-6), (3e-6, 2.5e-6, 4e-6)
    depth = np.array([1e-8, 2e-7, 1.5e-7])
    first, second = of_pair(NMC, one, other, two, 0.7), of_pair(other, two, NMC, one, -0.7)
    assert first.along(depth).force == pytest.approx(second.along(depth).force, rel=1e-9)
    turned = of_pair(NMC, one, other, (two[0], two[2], two[1]), 0.7 + 0.5 * math.pi)
    assert first.along(depth).force == pytest.approx(turned.along(depth).force, rel=1e-9)


def test_spheres_of_two_sizes_have_the_law_of_spheres():
    """R = 2 R1 R2/(R1 + R2) at half the overlap, exactly."""
    contact = of_pair(NMC, (3e-6,) * 3, NMC, (6e-6,) * 3)
    sphere = whole_range(NMC, 4e-6)
    depth = np.array([1e-7, 3e-7])
    wanted = [whole_range_force(sphere, d, 0.0, 0.0, (0.0,) * 6)[0] for d in depth]
    assert contact.along(2.0 * depth).force == pytest.approx(wanted, rel=1e-9)


def test_impossible_axes_are_refused():
    with pytest.raises(InputError, match="semi-axes"):
        on_flat(NMC, (1e-6, -1e-6, 1e-6))
    with pytest.raises(InputError, match="path in m"):
        on_flat(NMC, (1e-6, 1e-6, 1e-6)).along([math.nan])
