"""Random packings of ellipsoids: the fraction asked for, no overlap, the same for the same seed, and what has none."""

from __future__ import annotations

import math

import numpy as np
import pytest

import dem
from contactlaws.ellipsoid_gap import meeting
from contactlaws.errors import InputError
from contactlaws.hertz_ellipse import HertzEllipse
from dem.ellipsoid_packing import EllipsoidPacking, random_ellipsoids

AXES = (5e-6, 4e-6, 3.3e-6)
compiled_only = pytest.mark.compiled_only(reason="thousands of steps of interpreted kernels")


@compiled_only
def test_fraction_is_reached_without_overlap() -> None:
    """Every pair in every image is looked at."""
    packing = random_ellipsoids(40, 0.6, AXES, seed=3)
    edge = packing.box.lengths[0]
    assert 40 * 4.0 / 3.0 * math.pi * math.prod(AXES) / edge**3 == pytest.approx(0.6, rel=1e-12)
    assert packing.worst_overlap <= 1e-3
    size, worst = math.cbrt(math.prod(AXES)), 0.0
    for i in range(40):
        for j in range(i):
            branch = packing.position[j] - packing.position[i]
            branch -= edge * np.rint(branch / edge)
            if np.linalg.norm(branch) < 2.0 * max(AXES):
                worst = max(worst, meeting(AXES, packing.orientation[i], AXES, packing.orientation[j], branch).overlap)
    assert worst / (2.0 * size) == pytest.approx(packing.worst_overlap, abs=1e-9)


def test_a_scene_takes_it_like_a_packing_of_spheres() -> None:
    orientation = np.array([[0.6, 0.0, 0.8, 0.0]])
    packing = EllipsoidPacking(np.full((1, 3), 1e-5), np.array([AXES]), orientation, dem.Box((2e-5,) * 3), 0.03, 0.0, 0)
    scene = dem.packed_scene(packing, 4750.0, dem.Contact(HertzEllipse(1.5e11)), (dem.hold(1e-9),))
    assert scene.box is packing.box
    assert scene.particles.axes is not None
    assert scene.particles.orientation is not None
    assert np.array_equal(scene.particles.axes, packing.axes)
    assert np.array_equal(scene.particles.orientation, packing.orientation)


@compiled_only
def test_same_seed_same_packing() -> None:
    one, again, other = (random_ellipsoids(12, 0.4, AXES, seed) for seed in (1, 1, 2))
    assert np.array_equal(one.position, again.position)
    assert np.array_equal(one.orientation, again.orientation)
    assert not np.array_equal(one.orientation, other.orientation)


@compiled_only
def test_orientations_are_alike_in_all_directions() -> None:
    """The mean of n n is a third, within three standard errors of 60 random directions: sqrt(4/45/60) each."""
    packing = random_ellipsoids(60, 0.5, AXES, seed=5)
    w, x, y, z = packing.orientation.T
    long = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)], axis=1)
    assert np.diag(long.T @ long / 60.0) == pytest.approx([1.0 / 3.0] * 3, abs=3.0 * math.sqrt(4.0 / 45.0 / 60.0))


@compiled_only
def test_what_jams_before_is_said() -> None:
    with pytest.raises(InputError, match="jam before"):
        random_ellipsoids(30, 0.76, AXES, seed=1)


def test_what_is_no_packing_is_refused() -> None:
    with pytest.raises(InputError, match="packing_fraction"):
        random_ellipsoids(10, 0.9, AXES)
    with pytest.raises(InputError, match="ratio of half axes"):
        random_ellipsoids(10, 0.3, (11.0, 1.0, 1.0))
    with pytest.raises(InputError, match="positive"):
        random_ellipsoids(10, 0.3, (1.0, 1.0, 0.0))
    with pytest.raises(InputError, match="count"):
        random_ellipsoids(0, 0.3, AXES)
