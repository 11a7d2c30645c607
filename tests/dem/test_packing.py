"""Packings have the fraction asked for and no overlaps; what cannot be reached is refused with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlaws.errors import InputError
from dem.packing import Packing, body_centred_cubic, face_centred_cubic, random_close_packing, simple_cubic

RADIUS = 5e-6


def smallest_gap(packing: Packing) -> float:
    """Smallest gap of any pair in any image, over the sum of the radii; by looking at all of them."""
    count = len(packing.position)
    radii = np.broadcast_to(packing.radius, (count,))
    images = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * np.array(packing.box.lengths)
    between = packing.position[None, :, None] - packing.position[:, None, None] + images
    ratio = np.linalg.norm(between, axis=-1) / (radii[:, None] + radii)[..., None]
    return float(ratio[ratio > 0.0].min()) - 1.0


def fraction(packing: Packing) -> float:
    radii = np.broadcast_to(packing.radius, (len(packing.position),))
    return float(np.sum(4.0 / 3.0 * math.pi * radii**3)) / packing.box.volume


@pytest.mark.compiled_only(reason="200 000 moves of single spheres")
def test_dense_random_packing_of_equal_spheres() -> None:
    packing = random_close_packing(250, 0.635, RADIUS, seed=1)
    assert fraction(packing) == pytest.approx(0.635, rel=1e-12)  # round-off: the box is made to fit
    assert smallest_gap(packing) >= -1e-12
    assert -packing.worst_overlap == pytest.approx(smallest_gap(packing), abs=1e-12)


@pytest.mark.parametrize(("count", "asked"), [(1, 0.5), (2, 0.4), (3, 0.3), (20, 0.05), (30, 0.5)])
def test_few_and_loose_spheres(count: int, asked: float) -> None:
    packing = random_close_packing(count, asked, RADIUS, seed=3)
    assert fraction(packing) == pytest.approx(asked, rel=1e-12)
    assert smallest_gap(packing) >= -1e-12
    assert packing.worst_overlap <= 1e-12


def test_many_radii() -> None:
    radii = np.linspace(1.0, 3.0, 40) * RADIUS
    packing = random_close_packing(40, 0.45, radii, seed=2)
    np.testing.assert_array_equal(packing.radius, radii)
    assert fraction(packing) == pytest.approx(0.45, rel=1e-12)
    assert smallest_gap(packing) >= -1e-12


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


def test_a_fraction_out_of_reach_names_the_one_that_was_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dem.packing.RATES", (1.0,))  # too fast to get anywhere dense
    with pytest.raises(InputError, match=r"0\.\d+ was reached with 30 spheres"):
        random_close_packing(30, 0.64, RADIUS)
