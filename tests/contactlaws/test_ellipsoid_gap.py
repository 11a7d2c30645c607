"""The common normal of two ellipsoids against an independent criterion, dense search, closed forms, and symmetry."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlaws.ellipsoid import curvature, gap
from contactlaws.ellipsoid_gap import meeting

FloatArray = npt.NDArray[np.float64]
NO_TURN = (1.0, 0.0, 0.0, 0.0)


def turned(seed: int) -> FloatArray:
    """A random unit quaternion."""
    row = np.random.default_rng(seed).normal(size=4)
    return np.asarray(row / np.linalg.norm(row))


def matrix(q: FloatArray) -> FloatArray:
    """Its rotation, from Rodrigues' formula."""
    w, v = float(q[0]), q[1:]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross)


def tensor(axes: FloatArray, q: FloatArray) -> FloatArray:
    """S = Q diag(a^2) Q^T."""
    return np.asarray(matrix(q) @ np.diag(np.asarray(axes) ** 2) @ matrix(q).T)


def contact_function(one: FloatArray, other: FloatArray, branch: FloatArray) -> float:
    """Perram & Wertheim's, by golden section: they overlap if and only if it is below 1."""

    def value(x: float) -> float:
        return float(x * (1.0 - x) * branch @ np.linalg.solve((1.0 - x) * one + x * other, branch))

    low, high, golden = 0.0, 1.0, 0.5 * (math.sqrt(5.0) - 1.0)
    for _ in range(60):
        left, right = high - golden * (high - low), low + golden * (high - low)
        low, high = (low, right) if value(left) > value(right) else (left, high)
    return value(0.5 * (low + high))


def random_pair(seed: int, slender: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Half axes and turns of two ellipsoids of volume 1, and a direction."""
    rng = np.random.default_rng(seed)
    axes = slender ** rng.random((2, 3))
    axes /= np.cbrt(axes.prod(axis=1, keepdims=True))
    direction = rng.normal(size=3)
    return axes[0], turned(2 * seed), axes[1], turned(2 * seed + 1), direction / np.linalg.norm(direction)


@pytest.mark.parametrize("slender", [1.5, 10.0])
def test_no_contact_is_missed_and_none_invented(slender: float) -> None:
    """Pairs from nearly touching (1e-9) to anywhere, against the contact function. A million: cases.verification.ellipsoid_extremes."""
    for seed in range(150):
        axes_1, turn_1, axes_2, turn_2, direction = random_pair(seed, slender)
        touching = contact_function(tensor(axes_1, turn_1), tensor(axes_2, turn_2), direction)
        for wanted in (1.0 - 1e-9, 1.0 + 1e-9, 0.98, 1.02, 0.3, 3.0):  # goes with the distance squared
            found = meeting(axes_1, turn_1, axes_2, turn_2, direction * math.sqrt(wanted / touching))
            assert (found.overlap > 0.0) == (wanted < 1.0)


@pytest.mark.parametrize("slender", [1.5, 10.0])
def test_depth_is_the_least_over_all_directions(slender: float) -> None:
    """No direction of 40,000 has a smaller g; the best of them is above by its distance, squared, of 1e-2."""
    k = np.arange(40_000)
    z = 1.0 - (2.0 * k + 1.0) / len(k)
    n = np.stack([np.sqrt(1.0 - z * z) * np.cos(2.399963 * k), np.sqrt(1.0 - z * z) * np.sin(2.399963 * k), z], axis=1)
    for seed in range(40):
        axes_1, turn_1, axes_2, turn_2, direction = random_pair(seed, slender)
        one, other = tensor(axes_1, turn_1), tensor(axes_2, turn_2)
        reach = math.sqrt(1.0 / contact_function(one, other, direction))
        for part in (0.99, 0.8, 0.4):
            branch = direction * reach * part
            g = sum(np.sqrt(np.einsum("ka,ab,kb->k", n, s, n)) for s in (one, other)) - n @ branch
            depth = meeting(axes_1, turn_1, axes_2, turn_2, branch).overlap
            assert depth <= g.min() + 1e-12
            assert depth >= g.min() - 0.05 * max(axes_1.max(), axes_2.max())


def test_points_lie_on_both_surfaces_and_share_the_normal() -> None:
    for seed in range(50):
        axes_1, turn_1, axes_2, turn_2, direction = random_pair(seed, 3.0)
        branch = direction * 0.99 / math.sqrt(contact_function(tensor(axes_1, turn_1), tensor(axes_2, turn_2), direction))
        found = meeting(axes_1, turn_1, axes_2, turn_2, branch)
        half = 0.5 * found.overlap * found.normal
        for sign, axes, turn, point in ((1.0, axes_1, turn_1, found.point + half), (-1.0, axes_2, turn_2, found.point - half - branch)):
            level = np.linalg.inv(tensor(axes, turn))
            assert point @ level @ point == pytest.approx(1.0, abs=1e-11)  # on the surface: round-off
            outward = level @ point
            assert sign * outward / np.linalg.norm(outward) == pytest.approx(found.normal, abs=1e-7)  # the root of round-off, at a minimum


def test_gap_is_that_of_the_curvature_tensors() -> None:
    """Radius and ratio against contactlaws.ellipsoid, which comes from the level function."""
    for seed in range(50):
        axes_1, turn_1, axes_2, turn_2, direction = random_pair(seed, 3.0)
        branch = direction * 0.999 / math.sqrt(contact_function(tensor(axes_1, turn_1), tensor(axes_2, turn_2), direction))
        found, tensors = meeting(axes_1, turn_1, axes_2, turn_2, branch), []
        half = 0.5 * found.overlap * found.normal
        for axes, turn, point in ((axes_1, turn_1, found.point + half), (axes_2, turn_2, found.point - half - branch)):
            q = matrix(turn)
            x, y, z = axes.tolist()
            tensors.append(q @ curvature((x, y, z), q.T @ point).tensor @ q.T)
        between = gap(tensors[0], tensors[1], found.normal)
        assert found.radius == pytest.approx(between.effective_radius, rel=1e-6)  # normals agree to 1e-7
        assert found.ratio == pytest.approx(between.larger / between.smaller, rel=1e-5)


@given(
    first=st.floats(0.1, 10.0),
    second=st.floats(0.1, 10.0),
    part=st.floats(0.5, 1.5),
    seed=st.integers(0, 1000),
)
def test_spheres_are_exact(first: float, second: float, part: float, seed: int) -> None:
    """To round-off, however they are turned."""
    direction = np.random.default_rng(seed).normal(size=3)
    direction /= np.linalg.norm(direction)
    distance = (first + second) * part
    found = meeting((first,) * 3, turned(seed), (second,) * 3, turned(seed + 1), direction * distance)
    assert found.overlap == pytest.approx(first + second - distance, abs=1e-14 * (first + second))
    assert found.normal == pytest.approx(direction, abs=1e-12)
    assert found.radius == pytest.approx(first * second / (first + second), rel=1e-12)
    assert found.ratio == pytest.approx(1.0, abs=1e-6)  # the root of round-off; the law takes its logarithm squared


@pytest.mark.parametrize("change", [1e-12, 1e-9, 1e-6])
def test_near_spheres_go_to_spheres(change: float) -> None:
    """What changes is of the order of the change."""
    found = meeting((1.0, 1.0 + change, 1.0), turned(1), (1.0, 1.0, 1.0 - change), turned(2), (0.0, 0.0, 1.98))
    assert found.overlap == pytest.approx(0.02, abs=4.0 * change + 1e-14)
    assert found.radius == pytest.approx(0.5, abs=20.0 * change + 1e-12)


def test_frame_does_not_matter() -> None:
    """Everything turned: the same overlap, radius and ratio, and the vectors turned."""
    q = turned(99)
    w, v = q[0], q[1:]

    def after(p: FloatArray) -> FloatArray:
        return np.concatenate([[w * p[0] - v @ p[1:]], w * p[1:] + p[0] * v + np.cross(v, p[1:])])

    for seed in range(20):
        axes_1, turn_1, axes_2, turn_2, direction = random_pair(seed, 3.0)
        one = meeting(axes_1, turn_1, axes_2, turn_2, 1.5 * direction)
        two = meeting(axes_1, after(turn_1), axes_2, after(turn_2), matrix(q) @ (1.5 * direction))
        assert (two.overlap, two.radius) == pytest.approx((one.overlap, one.radius), rel=1e-7)
        assert two.point == pytest.approx(matrix(q) @ one.point, abs=1e-7)


@pytest.mark.parametrize("axes", [(10.0, 1.0, 1.0), (10.0, 10.0, 1.0), (1.0, 1.000001, 1.0)])
def test_needles_plates_and_faces(axes: tuple[float, float, float]) -> None:
    """End to end, side by side and across, in closed form."""
    a, b, c = axes
    quarter = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)  # about y: x goes to -z, z to x
    for turn, branch, expected in (
        (NO_TURN, (2.0 * a - 0.01, 0.0, 0.0), 0.01),
        (NO_TURN, (0.0, 2.0 * b - 0.01, 0.0), 0.01),
        (NO_TURN, (0.0, 0.0, 2.0 * c - 0.01), 0.01),
        (quarter, (a + c - 0.01, 0.0, 0.0), 0.01),
        (quarter, (0.0, 0.0, a + c - 0.01), 0.01),
    ):
        assert meeting(axes, NO_TURN, axes, turn, branch).overlap == pytest.approx(expected, abs=1e-12)


def test_centres_in_one_place() -> None:
    """Two equal plates in one place go apart along their axis; nothing is 0/0."""
    found = meeting((10.0, 10.0, 1.0), NO_TURN, (10.0, 10.0, 1.0), NO_TURN, (0.0, 0.0, 0.0))
    assert found.overlap == pytest.approx(2.0, rel=1e-9)
    assert abs(found.normal[2]) == pytest.approx(1.0, rel=1e-9)
