"""The pair list equals what looking at every pair in every image finds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlaws.elastic import Hertz
from dem.box import Box, wrapped
from dem.motion import Deformation
from dem.neighbours import PairList, codes_of, neighbours, rows_before
from dem.particles import spheres
from dem.scene import Contact, Scene, hold
from dem.working import follow, working


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
    names = [list(zip(p.first.tolist(), p.partner.tolist(), map(tuple, p.images[p.image].tolist()), strict=True)) for p in (old, new)]
    source = rows_before(*((p.first, p.partner, codes_of(p.images)[p.image]) for p in (old, new)), 30)
    assert [names[0].index(name) if name in names[0] else -1 for name in names[1]] == source.tolist()
    assert 0 < (source >= 0).sum() < len(source)


@pytest.mark.parametrize("angle", [0.3, -0.7, 5.2])
def test_a_sheared_box_finds_the_pairs_of_the_same_lattice(angle: float) -> None:
    """Against images written out one by one; tilted so far that an edge leans over several boxes."""
    rng = np.random.default_rng(7)
    box, radii = Box((1.0, 0.8, 1.2)).stretched((1.0, 1.0, 1.0), (0.0, angle, -0.3)), np.full(20, 0.11)
    position = rng.uniform(-1.0, 2.0, (20, 3)) @ box.cell
    listed = as_set(neighbours(position, radii, box, 0.02))
    inside = np.floor(position @ np.linalg.inv(box.cell))
    found = set()
    reach = range(-9, 10)
    for image in np.array(list(itertools.product(reach, range(-2, 3), range(-2, 3)))):
        between = (position - inside @ box.cell)[None] + image @ box.cell - (position - inside @ box.cell)[:, None]
        for i, j in np.argwhere(np.linalg.norm(between, axis=2) <= 0.24).tolist():
            if i < j or (i == j and tuple(image.tolist()) > (0, 0, 0)):
                found.add((i, j, tuple((image + inside[i] - inside[j]).astype(int).tolist())))
    as_one = {(i, j, max(image, tuple(-k for k in image))) if i == j else (i, j, image) for i, j, image in listed}
    assert as_one == found


@pytest.mark.parametrize("periodic", [(True, True, True), (False, True, False), (False, False, False)])
def test_no_particles(periodic: tuple[bool, bool, bool]) -> None:
    assert not len(neighbours(np.zeros((0, 3)), np.zeros(0), Box((1.0, 1.0, 1.0), periodic), 0.1).partner)


def test_spheres_are_found_however_often_a_run_is_looked_at() -> None:
    """Two spheres that meet after many skins of free flight; every call goes on for a fraction of the way that the list allows for."""
    start, speed, dt = np.array([[1.5, 4.0, 4.0], [6.5, 4.0, 4.0]]), 1.0, 0.002
    bodies = spheres(start, 1.0, 1.0, np.array([[speed, 0.0, 0.0], [-speed, 0.0, 0.0]]))
    work = working(Scene(bodies, Box((8.0, 8.0, 8.0)), Contact(Hertz(1.0, 1e3)), (hold(1.0),), skin=0.05))
    for step in range(1500):  # first contact after 750
        work, _ = follow(work, Deformation(work.cell, work.cell, 10**6, dt), step, 1)
    velocity = work.bodies.velocity[np.argsort(work.order)]
    np.testing.assert_allclose(velocity[:, 0], [-speed, speed], rtol=1e-3)  # back as they came; the step makes up the rest
