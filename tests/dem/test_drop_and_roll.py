"""Beds rest: every sphere lies on the floor or stably on three others, found by looking at all pairs in all images."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlaws.errors import InputError
from dem.drop_and_roll import drop_and_roll, periodic_in_height
from dem.packing import Packing
from dem.packing_cells import worst_overlap
from dem.packing_radii import lognormal_radii, uniform_radii

RADIUS = 5e-6


def supports(packing: Packing, i: int) -> np.ndarray:
    """Centres, seen from that of sphere i, of all images of earlier spheres that it touches (to 1e-8 of the sum of the radii)."""
    radii = np.broadcast_to(packing.radius, (len(packing.position),))
    shifts = [np.array([a, b, 0.0]) * packing.box.lengths for a in range(-3, 4) for b in range(-3, 4)]
    between = np.concatenate([packing.position[:i] + shift - packing.position[i] for shift in shifts])
    reach = np.tile(radii[:i] + radii[i], len(shifts))
    return between[abs(np.linalg.norm(between, axis=1) / reach - 1.0) < 1e-8]


def stable(centres: np.ndarray) -> bool:
    """Whether the vertical through the origin meets a triangle of three of the centres, in its plane not above the origin."""
    for three in itertools.combinations(centres, 3):
        matrix = np.vstack([np.array(three)[:, :2].T, np.ones(3)])
        if abs(np.linalg.det(matrix)) < 1e-12 * np.abs(three).max() ** 2:
            continue  # above one line
        share = np.linalg.solve(matrix, [0.0, 0.0, 1.0])
        if share.min() > -1e-5 and share @ np.array(three)[:, 2] < 0.0:  # beds are tilted by 1e-6 to see whether a sphere is balanced
            return True
    return False


def at_rest(packing: Packing) -> bool:
    radii = np.broadcast_to(packing.radius, (len(packing.position),))
    on_floor = abs(packing.position[:, 2] / radii - 1.0) < 1e-8
    return all(on_floor[i] or stable(supports(packing, i)) for i in range(len(radii)))


@settings(max_examples=25)
@given(st.integers(1, 40), st.integers(0, 2**32 - 1), st.floats(2.0, 9.0), st.sampled_from([0.0, 0.1, 0.5]))
def test_every_sphere_rests_on_the_floor_or_stably_on_three(count: int, seed: int, width: float, spread: float) -> None:
    radii = lognormal_radii(count, 1.0, spread, seed) if spread else np.ones(count)
    radii *= RADIUS / radii.max()
    packing = drop_and_roll(count, radii, seed, width * radii.max()).packing
    assert packing.worst_overlap < 1e-9  # TOUCH
    assert (packing.position[:, 2] > radii * (1.0 - 1e-12)).all()
    assert at_rest(packing)


@pytest.mark.compiled_only(reason="3000 spheres")
def test_a_bed_of_equal_spheres_has_the_known_density_and_hardly_depends_on_the_seed() -> None:
    """0.58 (Wahn, Gan & Kamlah 2022)."""
    for seed in (1, 2):
        bed = drop_and_roll(3000, RADIUS, seed)
        assert bed.interior_fraction == pytest.approx(0.58, abs=0.01)  # they give two digits
        assert bed.packing.packing_fraction < bed.interior_fraction  # floor and surface are loose
        assert at_rest(bed.packing._replace(position=bed.packing.position[:300]))


def test_in_a_box_of_one_diameter_spheres_pile_up_as_square_layers() -> None:
    """Each rests in the hollow of four images of the one below: face-centred cubic, pi sqrt(2)/6."""
    bed = drop_and_roll(30, RADIUS, seed=3, width=2.0 * RADIUS)
    assert bed.interior_fraction == pytest.approx(math.pi * math.sqrt(2.0) / 6.0, rel=0.02)  # the interior may cut layers anywhere
    np.testing.assert_allclose(np.diff(bed.packing.position[:, 2]), math.sqrt(2.0) * RADIUS, rtol=1e-9)


def test_sizes_over_a_factor_of_100() -> None:
    radii = np.random.default_rng(1).permutation(np.concatenate([np.full(4, 1.0), np.full(60, 0.01), np.full(30, 0.1)]))
    packing = drop_and_roll(len(radii), radii, seed=1).packing
    np.testing.assert_array_equal(packing.radius, radii)
    assert packing.worst_overlap < 1e-9
    assert at_rest(packing)


def test_the_seed_alone_decides() -> None:
    first, again, other = (drop_and_roll(20, RADIUS, seed).packing.position for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_bed_does_not_depend_on_the_unit_of_length() -> None:
    metres, micrometres = drop_and_roll(40, 0.5, seed=4).packing.position, drop_and_roll(40, 0.5e-6, seed=4).packing.position
    np.testing.assert_allclose(micrometres * 1e6, metres, rtol=1e-9)  # round-off, through hundreds of arcs


@settings(max_examples=25)
@given(st.integers(1, 60), st.integers(0, 2**32 - 1), st.booleans())
def test_the_periodic_box_is_as_low_as_it_can_be(count: int, seed: int, equal: bool) -> None:
    packing = periodic_in_height(drop_and_roll(count, RADIUS if equal else uniform_radii(count, 0.5 * RADIUS, RADIUS, seed), seed))
    x, y, z = packing.box.lengths
    assert packing.box.periodic == (True, True, True)
    assert packing.worst_overlap < 1e-9
    assert worst_overlap(packing.position, packing.radius, packing.box._replace(lengths=(x, y, z * (1.0 - 1e-4)))) > 1e-7


@pytest.mark.compiled_only(reason="100 000 moves of single spheres")
def test_a_box_as_dense_as_the_interior_without_overlaps() -> None:
    bed = drop_and_roll(420, RADIUS, seed=2, width=11.8 * RADIUS)
    packing = periodic_in_height(bed, count=226, packing_fraction=0.58)
    assert len(packing.position) == 226
    assert 226.0 * 4.0 / 3.0 * math.pi * RADIUS**3 / packing.box.volume == pytest.approx(0.58, rel=1e-12)
    assert worst_overlap(packing.position, packing.radius, packing.box) <= 1e-12
    with pytest.raises(InputError, match="left"):
        periodic_in_height(bed, count=226, packing_fraction=0.7)


def test_what_makes_no_bed_is_refused() -> None:
    for arguments in ((0, 1.0), (3, -1.0), (3, [1.0, 2.0]), (3, math.nan), (3, 1.0, 1, 1.9), (3, 1.0, 1, math.inf)):
        with pytest.raises(InputError):
            drop_and_roll(*arguments)
    bed = drop_and_roll(10, 1.0)
    with pytest.raises(InputError, match="drop more"):
        periodic_in_height(bed, count=5)
    with pytest.raises(InputError, match=r"\(0, 1\)"):
        periodic_in_height(bed, packing_fraction=1.2)
