"""Packings have the fraction asked for and no overlaps; what cannot be reached is refused with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlaws.errors import InputError
from dem.box import Box
from dem.packing import Packing, body_centred_cubic, face_centred_cubic, random_close_packing, simple_cubic
from dem.packing_cells import worst_overlap
from dem.packing_radii import lognormal_radii, tabulated_radii, uniform_radii

RADIUS = 5e-6


def smallest_gap(packing: Packing, reach: int = 1) -> float:
    """Smallest gap of any pair in any of so many images, over the sum of the radii; by looking at all of them."""
    count = len(packing.position)
    radii = np.broadcast_to(packing.radius, (count,))
    steps = [range(-reach, reach + 1) if periodic else (0,) for periodic in packing.box.periodic]
    images = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3) * np.array(packing.box.lengths)
    between = packing.position[None, :, None] - packing.position[:, None, None] + images
    ratio = np.linalg.norm(between, axis=-1) / (radii[:, None] + radii)[..., None]
    ratio[np.arange(count), np.arange(count), (images == 0.0).all(axis=1)] = np.inf  # each from itself
    return float(ratio.min()) - 1.0


def fraction(packing: Packing) -> float:
    radii = np.broadcast_to(packing.radius, (len(packing.position),))
    return float(np.sum(4.0 / 3.0 * math.pi * radii**3)) / packing.box.volume


@pytest.mark.compiled_only(reason="700 000 moves of single spheres")
@pytest.mark.parametrize(("asked", "seed"), [(0.635, 1), (0.635, 2), (0.635, 3), (0.64, 1)])
def test_dense_random_packings_of_equal_spheres(asked: float, seed: int) -> None:
    packing = random_close_packing(250, asked, RADIUS, seed)
    assert fraction(packing) == pytest.approx(asked, rel=1e-12)  # round-off: the box is made to fit
    assert smallest_gap(packing) >= -1e-12
    assert -packing.worst_overlap == pytest.approx(smallest_gap(packing), abs=1e-12)


@pytest.fixture(scope="module")
def dense() -> Packing:
    return random_close_packing(1000, None, RADIUS, seed=1)


@pytest.mark.compiled_only(reason="1.6 million moves of single spheres")
def test_as_dense_as_it_gets_is_random_close_packing_and_no_crystal(dense: Packing) -> None:
    """0.64 (Scott & Kilgour 1969: 0.6366 +- 0.0005; simulations to 0.645); jammed spheres touch about 6 others, in a crystal 12."""
    assert 0.635 < dense.packing_fraction < 0.65
    assert abs(dense.worst_overlap) < 1e-9  # what is left of the distance between inner and outer radius
    diameter, edge = 2.0 * RADIUS, dense.box.lengths[0]
    between = dense.position[None, :] - dense.position[:, None]
    distance = np.linalg.norm(between - edge * np.rint(between / edge), axis=-1) / diameter
    near = distance[np.triu_indices(len(distance), 1)]
    touching = 2.0 * np.count_nonzero(near < 1.0 + 1e-3) / len(dense.position)
    assert 5.0 < touching < 6.5  # isostatic is 6 without rattlers, which are a few per cent
    shell = 4.0 * math.pi * 1.5**2 * 0.1 * dense.packing_fraction * 6.0 / math.pi  # spheres between 1.45 and 1.55 diameters at mean density
    at_gap = 2.0 * np.count_nonzero(abs(near - 1.5) < 0.05) / len(dense.position) / shell
    assert 0.5 < at_gap < 1.1  # a crystal has a gap between sqrt(2) and sqrt(3): nothing there


@pytest.mark.compiled_only(reason="as above")
def test_a_random_packing_has_no_direction_and_no_place(dense: Packing) -> None:
    """Fabric of the contacts: a third along each axis, within three standard errors of so many unit vectors (variance of n_x^2: 4/45)."""
    edge = dense.box.lengths[0]
    between = dense.position[None, :] - dense.position[:, None]
    between -= edge * np.rint(between / edge)
    distance = np.linalg.norm(between, axis=-1) + 10.0 * edge * np.tri(len(between))
    normal = between[distance < 2.002 * RADIUS] / distance[distance < 2.002 * RADIUS][:, None]
    np.testing.assert_allclose(normal.T @ normal / len(normal), np.eye(3) / 3.0, atol=3.0 * math.sqrt(4.0 / 45.0 / len(normal)))
    halves = (dense.position < 0.5 * edge).mean(axis=0)
    np.testing.assert_allclose(halves, 0.5, atol=3.0 * 0.5 / math.sqrt(len(dense.position)))  # at most as scattered as points at random


@pytest.mark.parametrize(("count", "asked"), [(1, 0.5), (2, 0.4), (3, 0.3), (20, 0.05), (30, 0.5)])
def test_few_and_loose_spheres(count: int, asked: float) -> None:
    packing = random_close_packing(count, asked, RADIUS, seed=3)
    assert fraction(packing) == pytest.approx(asked, rel=1e-12)
    assert smallest_gap(packing) >= -1e-12
    assert packing.worst_overlap <= 1e-12


@pytest.mark.parametrize(
    ("radii", "asked"),
    [
        (np.linspace(1.0, 3.0, 40), 0.45),
        (lognormal_radii(60, 1.0, 0.3, seed=1), 0.5),
        (np.concatenate([np.full(3, 100.0), np.ones(30)]), 0.3),
    ],
)
def test_many_radii(radii: np.ndarray, asked: float) -> None:
    radii = radii * RADIUS
    packing = random_close_packing(len(radii), asked, radii, seed=2)
    np.testing.assert_array_equal(packing.radius, radii)
    assert fraction(packing) == pytest.approx(asked, rel=1e-12)
    assert -packing.worst_overlap == pytest.approx(smallest_gap(packing), abs=1e-12)
    assert packing.worst_overlap <= 1e-12


def test_a_box_that_is_no_cube() -> None:
    packing = random_close_packing(40, 0.5, RADIUS, seed=1, edges=(2.0, 1.0, 3.0))
    np.testing.assert_allclose(np.array(packing.box.lengths) / packing.box.lengths[1], (2.0, 1.0, 3.0), rtol=1e-12)
    assert fraction(packing) == pytest.approx(0.5, rel=1e-12)
    assert smallest_gap(packing) >= -1e-12


@pytest.mark.compiled_only(reason="350 000 moves of single spheres")
def test_sizes_that_differ_pack_denser() -> None:
    """Small spheres fill the gaps between large ones: what no packing of equal spheres reaches is reached."""
    radii = tabulated_radii(1008, [(5.0, 0.5), (1.0, 0.5)], by_volume=True)
    packing = random_close_packing(len(radii), 0.68, radii, seed=1)
    assert packing.worst_overlap <= 1e-12


def test_the_seed_alone_decides() -> None:
    first, again, other = (random_close_packing(20, 0.4, RADIUS, seed=seed).position for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize(
    ("lattice", "expected"),
    [
        (simple_cubic, math.pi / 6.0),
        (body_centred_cubic, math.pi * math.sqrt(3.0) / 8.0),
        (face_centred_cubic, math.pi * math.sqrt(2.0) / 6.0),
    ],
)
def test_lattices_touch(lattice, expected: float) -> None:  # type: ignore[no-untyped-def]
    packing = lattice((2, 3, 2), RADIUS)
    assert packing.packing_fraction == pytest.approx(expected, rel=1e-12)
    assert smallest_gap(packing) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("count", "asked", "radius", "word"),
    [
        (250, 0.70, RADIUS, "crystals"),
        (250, 0.0, RADIUS, "packing_fraction"),
        (250, math.nan, RADIUS, "packing_fraction"),
        (1, 0.6, RADIUS, "images"),
        (0, 0.5, RADIUS, "count"),
        (10, 0.5, -RADIUS, "radius"),
        (10, 0.5, [RADIUS] * 9, "radius"),
    ],
)
def test_impossible_packings_are_refused_before_computing(count: int, asked: float, radius: float, word: str) -> None:
    with pytest.raises(InputError, match=word):
        random_close_packing(count, asked, radius)


def test_a_fraction_out_of_reach_names_the_one_that_was_reached() -> None:
    radii = np.append(np.ones(30), 1.5)  # two sizes, nearly equal: 0.7 is out of their reach
    with pytest.raises(InputError, match=r"0\.\d+ was reached with 31 spheres"):
        random_close_packing(31, 0.8, radii)


@settings(max_examples=100)
@given(
    st.integers(1, 7),
    st.integers(0, 2**32 - 1),
    st.tuples(*[st.floats(0.05, 30.0)] * 3),
    st.tuples(*[st.booleans()] * 3),
    st.floats(0.0, 1.5),
)
def test_the_worst_overlap_is_that_of_all_pairs_in_all_images(
    count: int, seed: int, lengths: tuple[float, float, float], periodic: tuple[bool, bool, bool], spread: float
) -> None:
    """Boxes down to a fortieth of a diameter, spheres outside the box, radii over a factor of 20."""
    random = np.random.default_rng(seed)
    radii = np.exp(spread * random.uniform(-1.0, 1.0, count))
    packing = Packing(random.uniform(-1.0, 2.0, (count, 3)) * lengths, radii, Box(lengths, periodic), 0.0, 0.0)
    found = worst_overlap(packing.position, radii, packing.box)
    if count == 1 and not any(periodic):
        assert found == -math.inf
        return
    assert found == pytest.approx(-smallest_gap(packing, reach=4), abs=1e-9)  # round-off, over boxes of 30 radii


def test_drawn_radii_have_the_moments_of_their_distribution() -> None:
    """Within four standard errors of 20 000 draws."""
    uniform, normal = uniform_radii(20_000, 1e-6, 3e-6, seed=1), np.log(lognormal_radii(20_000, 2e-6, 0.4, seed=1) / 2e-6)
    assert uniform.mean() == pytest.approx(2e-6, abs=4.0 * 2e-6 / math.sqrt(12.0 * 20_000))
    assert normal.mean() == pytest.approx(0.0, abs=4.0 * 0.4 / math.sqrt(20_000))
    assert normal.std() == pytest.approx(0.4, abs=4.0 * 0.4 / math.sqrt(40_000))
    assert uniform.min() >= 1e-6
    assert uniform.max() <= 3e-6


@pytest.mark.parametrize("table", [[], [(1.0,)], [(0.0, 1.0)], [(1.0, -1.0), (2.0, 2.0)], [(1.0, 0.0)], [(math.nan, 1.0)]])
def test_useless_tables_of_radii_are_refused(table: list[tuple[float, float]]) -> None:
    with pytest.raises(InputError, match="table"):
        tabulated_radii(10, table)


def test_bounds_of_radii_are_checked() -> None:
    for draw in (lambda: uniform_radii(3, 2.0, 1.0), lambda: uniform_radii(3, -1.0, 1.0), lambda: lognormal_radii(0, 1.0, 0.1)):
        with pytest.raises(InputError):
            draw()


def test_overlaps_in_a_tilted_box_are_not_guessed() -> None:
    with pytest.raises(InputError, match="cuboid"):
        worst_overlap(np.zeros((1, 3)), 1.0, Box((4.0, 4.0, 4.0), tilt=(1.0, 0.0, 0.0)))
