"""Curvatures of ellipsoids against closed forms, spheres, turned frames and a parametrised surface."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlaws.ellipsoid import bluntness, curvature, gap, tangent_basis
from contactlaws.errors import InputError

lengths = st.floats(0.1, 10.0)
bodies = st.tuples(lengths, lengths, lengths)
rays = st.tuples(*(st.floats(-1.0, 1.0),) * 3).filter(lambda ray: math.hypot(*ray) > 1e-3)


def on_surface(axes: tuple[float, float, float], ray: tuple[float, float, float]) -> np.ndarray:
    return np.array(ray) / math.sqrt(sum((x / a) ** 2 for x, a in zip(ray, axes, strict=True)))


@given(bodies, rays)
def test_gauss_and_mean_curvature_in_closed_form(axes: tuple[float, float, float], ray: tuple[float, float, float]) -> None:
    """K = h^4/(abc)^2 and k1 + k2 = h^3 (a^2 + b^2 + c^2 - r^2)/(abc)^2, h the distance of the tangent plane from the centre."""
    point = on_surface(axes, ray)
    found = curvature(axes, point)
    squares = np.array(axes) ** 2
    h = 1.0 / math.sqrt(float(np.sum(point**2 / squares**2)))
    product, total = h**4 / float(np.prod(squares)), h**3 * float(np.sum(squares) - point @ point) / float(np.prod(squares))
    small, large = found.principal
    assert small <= large
    assert small + large == pytest.approx(total, rel=1e-12)
    assert small * large == pytest.approx(product, rel=1e-12 * (large / small))
    assert found.normal @ point == pytest.approx(h, rel=1e-12)
    for value, direction in zip(found.principal, found.directions, strict=True):
        np.testing.assert_allclose(found.tensor @ direction, value * direction, atol=1e-12 * large)
        assert direction @ found.normal == pytest.approx(0.0, abs=1e-14)
    np.testing.assert_allclose(found.directions @ found.directions.T, np.eye(2), atol=1e-14)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("axis", "expected"), [(0, (1 / 25, 1 / 9)), (1, (3 / 25, 3 / 1)), (2, (5 / 9, 5 / 1))])
def test_on_the_axes(axis: int, expected: tuple[float, float], sign: float) -> None:
    """a/c^2 and a/b^2 and so on; where a chart is singular."""
    point = np.zeros(3)
    point[axis] = sign * (1.0, 3.0, 5.0)[axis]
    found = curvature((1.0, 3.0, 5.0), point)
    assert found.principal == pytest.approx(expected, rel=1e-15)
    np.testing.assert_array_equal(found.normal, np.sign(point))


@given(rays, st.floats(0.1, 10.0))
def test_a_sphere_is_round_everywhere(ray: tuple[float, float, float], radius: float) -> None:
    found = curvature((radius,) * 3, on_surface((radius,) * 3, ray))
    assert found.principal == pytest.approx((1.0 / radius,) * 2, rel=1e-14)


@given(rays)
def test_near_a_sphere_nothing_is_lost(ray: tuple[float, float, float]) -> None:
    """Half axes 1, 1 and 1.000001: curvatures within a few parts in a million of 1, directions still across each other."""
    found = curvature((1.0, 1.0, 1.000001), on_surface((1.0, 1.0, 1.000001), ray))
    assert found.principal == pytest.approx((1.0, 1.0), abs=3e-6)
    np.testing.assert_allclose(found.directions @ found.directions.T, np.eye(2), atol=1e-14)


def test_at_an_umbilic() -> None:
    """x^2 = a^2 (a^2 - b^2)/(a^2 - c^2), y = 0 for a > b > c: both curvatures are a c/b^3."""
    a, b, c = 3.0, 2.0, 1.0
    x, z = a * math.sqrt((a * a - b * b) / (a * a - c * c)), c * math.sqrt((b * b - c * c) / (a * a - c * c))
    assert curvature((a, b, c), (x, 0.0, z)).principal == pytest.approx((a * c / b**3,) * 2, rel=1e-8)  # the root of round-off


@given(bodies, rays, bodies, rays, st.floats(0.0, math.pi))
def test_the_gap_is_that_of_the_angle_between_principal_directions(one, ray, other, ray_2, angle) -> None:  # type: ignore[no-untyped-def]
    """A + B and B - A by the four curvatures and the angle between them: Johnson 1985, Eqs. 4.2 and 4.3."""
    first, second = curvature(one, on_surface(one, ray)), curvature(other, on_surface(other, ray_2))
    normal = np.array([0.0, 0.0, 1.0])
    tensors = []
    for found, turn in ((first, 0.0), (second, angle)):
        directions = np.array([[math.cos(turn), math.sin(turn), 0.0], [-math.sin(turn), math.cos(turn), 0.0]])
        tensors.append(directions.T @ np.diag(found.principal) @ directions)
    made = gap(*tensors, normal)
    spread = [found.principal[1] - found.principal[0] for found in (first, second)]
    total = 0.5 * (sum(first.principal) + sum(second.principal))
    difference = 0.5 * math.sqrt(max(spread[0] ** 2 + spread[1] ** 2 + 2.0 * spread[0] * spread[1] * math.cos(2.0 * angle), 0.0))
    assert made.smaller + made.larger == pytest.approx(total, rel=1e-12)
    assert made.larger - made.smaller == pytest.approx(difference, rel=1e-6, abs=1e-7 * total)
    assert made.effective_radius == pytest.approx(0.5 / math.sqrt(made.smaller * made.larger))


def test_effective_radii_of_becker_and_kamlah() -> None:
    """Two equal spheres: half the radius."""
    tensor = curvature((2.0, 2.0, 2.0), (0.0, 0.0, 2.0)).tensor
    assert gap(tensor, tensor, np.array([0.0, 0.0, 1.0])).effective_radius == pytest.approx(1.0)


@given(rays)
def test_the_basis_of_a_tangent_plane(ray: tuple[float, float, float]) -> None:
    normal = np.array(ray) / np.linalg.norm(ray)
    frame = np.vstack([tangent_basis(normal), normal])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)


@pytest.mark.parametrize(
    ("axes", "point"), [((1.0, 0.0, 1.0), (1.0, 0.0, 0.0)), ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)), ((1.0, -1.0, 1.0), (1, 1, 1))]
)
def test_no_ellipsoid_or_no_point(axes: tuple[float, float, float], point: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="axes"):
        curvature(axes, point)


@given(bodies, rays, bodies, rays, st.floats(0.0, math.pi))
def test_no_contact_is_sharper_or_blunter_than_the_ends_of_the_axes(
    first: tuple[float, float, float],
    ray_1: tuple[float, float, float],
    other: tuple[float, float, float],
    ray_2: tuple[float, float, float],
    angle: float,
) -> None:
    """Of any two points of two bodies of any size, turned by any angle about their normal: effective over mean radius."""
    tensors, means = [], []
    for axes, ray, turned in ((first, ray_1, 0.0), (other, ray_2, angle)):
        found = curvature(axes, on_surface(axes, ray))
        c, s = math.cos(turned), math.sin(turned)
        turn = np.array([[c, -s], [s, c]])
        tensors.append(np.pad(turn @ np.diag(found.principal) @ turn.T, ((0, 1), (0, 1))))
        means.append(math.cbrt(math.prod(axes)))
    flat = np.zeros((3, 3))
    least, largest = bluntness([first, other])
    for one, two, mean, low, high in (
        (tensors[0], flat, means[0], least[0], largest[0]),
        (tensors[0], tensors[1], means[0] * means[1] / (means[0] + means[1]), least.min(), largest.max()),
    ):
        ratio = gap(one, two, np.array([0.0, 0.0, 1.0])).effective_radius / mean
        assert low * (1.0 - 1e-9) <= ratio <= high * (1.0 + 1e-9)
