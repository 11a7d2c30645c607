"""The pair list equals what looking at every pair in every image finds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dem.box import Box, wrapped
from dem.neighbours import PairList, carried_over, neighbours, pair_keys


def brute_force(position: np.ndarray, radii: np.ndarray, box: Box, skin: float) -> set[tuple[int, int, tuple[int, ...]]]:
    """All pairs (i, j, image of j) whose surfaces are at most `skin` apart."""
    lengths = np.array(box.lengths)
    reach = 2.0 * radii.max() + skin
    spread = np.floor(np.ptp(position, axis=0) / lengths) if len(position) else np.zeros(3)
    furthest = (np.ceil(reach / lengths) + spread + 1).astype(int)
    ranges = [range(-n, n + 1) if repeats else range(1) for n, repeats in zip(furthest, box.periodic, strict=True)]
    found = set()
    for i, j in itertools.combinations_with_replacement(range(len(position)), 2):
        for image in itertools.product(*ranges):
            if i == j and image <= (0, 0, 0):
                continue
            if np.linalg.norm(position[j] + np.array(image) * lengths - position[i]) <= radii[i] + radii[j] + skin:
                found.add((i, j, image))
    return found


def as_set(pairs: PairList) -> set[tuple[int, int, tuple[int, ...]]]:
    images = [tuple(int(k) for k in image) for image in pairs.images[pairs.image]]
    return set(zip(pairs.first.tolist(), pairs.partner.tolist(), images, strict=True))


#: places that matter: faces, edges, corners, cell borders, outside the box
place = st.one_of(st.floats(-1.5, 2.5), st.sampled_from([0.0, 1.0, -1e-17, 0.5, 0.25, 1.0 / 3.0, 1.0 - 1e-16, -1.0, 2.0]))


@settings(deadline=None, max_examples=40)
@given(
    places=st.lists(st.tuples(place, place, place), min_size=0, max_size=12),
    lengths=st.tuples(*[st.floats(0.3, 6.0)] * 3),
    periodic=st.tuples(*[st.booleans()] * 3),
    sizes=st.lists(st.floats(0.05, 1.0), min_size=12, max_size=12),
    skin=st.floats(0.0, 0.5),
)
def test_list_equals_brute_force(places, lengths, periodic, sizes, skin) -> None:  # type: ignore[no-untyped-def]
    unit = 1e-6
    box = Box(tuple(length * unit for length in lengths), periodic)
    position = np.array(places).reshape(-1, 3) * np.array(box.lengths)
    radii = np.array(sizes[: len(places)]) * unit
    if not len(places):
        assert not len(neighbours(position, radii, box, skin * unit).partner)
        return
    pairs = neighbours(position, radii, box, skin * unit)
    listed = as_set(pairs)
    assert len(listed) == len(pairs.partner)  # each pair once
    surely, perhaps = (brute_force(position, radii, box, (skin + slack) * unit) for slack in (-1e-12, 1e-12))
    assert surely <= listed <= perhaps  # a pair at the limit to round-off may be found or not


def test_many_particles_on_cell_borders() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    pairs = neighbours(grid, np.full(125, 0.5), Box((5.0, 5.0, 5.0)), 0.01)
    assert len(pairs.partner) == 3 * 125  # six neighbours each, half a list


def test_a_single_sphere_meets_its_own_images() -> None:
    pairs = neighbours(np.zeros((1, 3)), np.array([0.5]), Box((1.0, 1.0, 1.0)), 0.01)
    assert as_set(pairs) == {(0, 0, (1, 0, 0)), (0, 0, (0, 1, 0)), (0, 0, (0, 0, 1))}


def test_wrapping_keeps_to_the_box() -> None:
    inside = wrapped(np.array([[-1e-20, 2.5, 1.0], [3.0, -7.0, 0.5]]), Box((1.0, 1.0, 1.0), (True, True, False)))
    assert np.all((inside[:, :2] >= 0.0) & (inside[:, :2] < 1.0))
    np.testing.assert_array_equal(inside[:, 2], [1.0, 0.5])


def test_memory_follows_its_pair_through_lists() -> None:
    rng = np.random.default_rng(5)
    box, radii = Box((1.0, 1.0, 1.0)), np.full(30, 0.15)
    position = rng.uniform(-1.0, 2.0, (30, 3))
    old = neighbours(position, radii, box, 0.05)
    new = neighbours(position + rng.uniform(-0.05, 0.05, position.shape), radii, box, 0.1)
    memory = rng.random((len(old.partner), 2))
    fresh, homeless = carried_over(old, memory, new)
    kept = dict(zip(pair_keys(new, 9).tolist(), fresh.tolist(), strict=True))
    for row, key in enumerate(pair_keys(old, 9).tolist()):
        assert (kept.get(key) == memory[row].tolist()) != (row in homeless)
    assert np.count_nonzero(fresh[:, 0]) == len(old.partner) - len(homeless)


@pytest.mark.parametrize("periodic", [(True, True, True), (False, True, False), (False, False, False)])
def test_no_particles(periodic: tuple[bool, bool, bool]) -> None:
    assert not len(neighbours(np.zeros((0, 3)), np.zeros(0), Box((1.0, 1.0, 1.0), periodic), 0.1).partner)
