"""Laws of shaped bodies: Hertz's limits, and no energy from a contact that rolls while it is pressed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlaws import elastic, shaped
from contactlaws.compiled import kernel
from contactlaws.contact_ellipse import exact_factors
from contactlaws.errors import InputError
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.shaped import UNTOUCHED, ShapedLaw, shaped_force, shaped_law_of, shaped_stored, untouched
from contactlaws.whole_range_ellipsoid import whole_range_ellipsoid

MODULUS = 1.0e9
MEAN = 1.0
HERTZ = HertzEllipse(MODULUS)


class Yielding(NamedTuple):
    """A plastic law for the tests: it loads along k d R, and unloads steeper, to what is left."""

    stiffness: float
    steeper: float


@kernel
def yielding_force(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """k R d; below the largest overlap back along a line `steeper` times as steep."""
    largest = max(memory[0], overlap)
    k = law.stiffness * shape[0]
    return max(0.0, k * largest - law.steeper * k * (largest - overlap)), (largest,)


@kernel
def yielding_radius(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """Of a sphere."""
    return math.sqrt(shape[0] * max(overlap, 0.0))


@kernel
def yielding_stored(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """The triangle under the way back."""
    push, _ = yielding_force(law, shape, overlap, memory)
    return 0.5 * push * push / (law.steeper * law.stiffness * shape[0])


@kernel
def yielding_bound(law, shape, overlap):  # type: ignore[no-untyped-def]
    """Of the way back."""
    return law.steeper * law.stiffness * shape[0]


YIELDING = ShapedLaw(
    "yielding in tests", Yielding, yielding_force, yielding_radius, yielding_stored, yielding_bound, ("largest overlap",), "none"
)
shaped.register(YIELDING)


def test_a_sphere_is_hertz() -> None:
    """To the last bits."""
    sphere = elastic.Hertz(MEAN, MODULUS)
    for overlap in (1e-9, 1e-4, 0.1):
        push, _ = shaped.force(HERTZ, (MEAN, 1.0, MEAN), overlap, ())
        assert push == pytest.approx(elastic.hertz_force(sphere, overlap, 0.0, 0.0, ())[0], rel=1e-15)
        width = shaped.contact_radius(HERTZ, (MEAN, 1.0, MEAN), overlap, ())
        assert width == pytest.approx(elastic.hertz_contact_radius(sphere, overlap, ()), rel=1e-15)
        energy = shaped.stored(HERTZ, (MEAN, 1.0, MEAN), overlap, ())
        assert energy == pytest.approx(elastic.hertz_energy(sphere, overlap, ())[0], rel=1e-15)
        assert shaped.stiffness_bound(HERTZ, (MEAN, 1.0, MEAN), overlap) == pytest.approx(1.5 * push / overlap, rel=1e-14)


@pytest.mark.parametrize("ratio", [1.0, 1.3, 5.0, 100.0])
def test_an_ellipse_is_that_of_the_integrals(ratio: float) -> None:
    """The factors are within 3e-6 of the exact ones; the force goes with f2 to the power 3/2."""
    exact = exact_factors(ratio)
    push, _ = shaped.force(HERTZ, (0.7, ratio, MEAN), 0.01, ())
    assert push == pytest.approx(4.0 / 3.0 * MODULUS * math.sqrt(0.7) * (0.01 / exact.approach) ** 1.5, rel=6e-6)
    width = exact.mean_radius * math.cbrt(3.0 * push * 0.7 / (4.0 * MODULUS))
    assert shaped.contact_radius(HERTZ, (0.7, ratio, MEAN), 0.01, ()) == pytest.approx(width, rel=6e-6)


@pytest.mark.parametrize("law", [HERTZ, Yielding(1.0e9, 5.0)])
@pytest.mark.parametrize("ratio", [1.0, 7.0])
def test_work_is_the_integral_of_the_force(law: object, ratio: float) -> None:
    """Loading: what is put in is at least what is stored, and all of it where the law is elastic (trapezium, 1e-6)."""
    path, work, push, memory, rolled = np.linspace(0.0, 0.05, 20_001), 0.0, 0.0, untouched(law), UNTOUCHED
    for before, overlap in zip(path, path[1:], strict=False):
        old = push
        push, memory, rolled = shaped_force(law, (1.0, ratio, MEAN), float(overlap), memory, rolled)
        work += 0.5 * (old + push) * float(overlap - before)
    held = shaped_stored(law, MEAN, 0.05, memory, rolled)
    assert held <= work * (1.0 + 1e-6)
    if not shaped_law_of(law).memory:
        assert held == pytest.approx(work, rel=1e-6)


@given(
    steps=st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.2, 3.0), st.floats(1.0, 20.0), st.booleans()), min_size=2, max_size=25),
    plastic=st.booleans(),
)
def test_no_energy_from_a_contact_that_rolls(steps: list[tuple[float, float, float, bool]], plastic: bool) -> None:
    """Random overlaps and shapes, alone and together: what is held is never more than what was put in, nor is what came back.

    The work between two overlaps is summed over 60 parts; it misses by the square of a part, which is the tolerance.
    """
    law = Yielding(1.0, 5.0) if plastic else HertzEllipse(1.0)
    memory, rolled, work, push = untouched(law), UNTOUCHED, 0.0, 0.0
    at, shape, put_in = 0.0, (1.0, 1.0), 1e-9
    for overlap, radius, ratio, together in [*steps, (0.0, 1.0, 1.0, False)]:
        wanted = (radius, ratio)
        if not together:  # the contact rolls, then is pressed
            for share in np.linspace(0.0, 1.0, 8)[1:].tolist():
                now = (shape[0] + (wanted[0] - shape[0]) * share, shape[1] + (wanted[1] - shape[1]) * share, MEAN)
                push, memory, rolled = shaped_force(law, now, at, memory, rolled)
            shape = wanted
        start, old_shape = at, shape
        for share in np.linspace(0.0, 1.0, 61)[1:].tolist():
            now = (old_shape[0] + (wanted[0] - old_shape[0]) * share, old_shape[1] + (wanted[1] - old_shape[1]) * share, MEAN)
            old, before = push, at
            at = start + (overlap - start) * share
            push, memory, rolled = shaped_force(law, now, at, memory, rolled)
            done = 0.5 * (old + push) * (at - before)
            work, put_in = work + done, put_in + max(done, 0.0)
            assert 0.0 <= rolled[2] <= 1.0
            assert shaped_stored(law, MEAN, at, memory, rolled) <= work + 2e-3 * put_in
        shape = wanted
    assert push == 0.0
    assert work >= -2e-3 * put_in


def test_an_elastic_contact_that_rolls_there_and_back_loses_nothing() -> None:
    """Soft to stiff and back to soft: the factor is 1 again, and force and energy are those of the start."""
    memory, rolled, overlap = (), UNTOUCHED, 0.01
    first, memory, rolled = shaped_force(HERTZ, (1.0, 1.0, MEAN), overlap, memory, rolled)
    held = shaped_stored(HERTZ, MEAN, overlap, memory, rolled)
    stiff, memory, rolled = shaped_force(HERTZ, (2.0, 1.0, MEAN), overlap, memory, rolled)
    assert rolled[2] < 1.0
    assert shaped_stored(HERTZ, MEAN, overlap, memory, rolled) == pytest.approx(held, rel=1e-14)
    assert stiff == pytest.approx(first, rel=1e-14)  # 5/2 of the energy over the overlap
    again, memory, rolled = shaped_force(HERTZ, (1.0, 1.0, MEAN), overlap, memory, rolled)
    assert (again, rolled[2]) == pytest.approx((first, 1.0), rel=1e-14)


def test_a_contact_that_rolls_in_its_dent_gains_nothing_and_bears_again() -> None:
    """A blunt contact, unloaded to where it bears nothing, becomes a sharper one, which would be left with a shallower dent.

    Nothing comes back on the way out. Pressed again, less is got back than was put in, and deep enough the law is that of the new shape.
    """
    law = whole_range_ellipsoid(Material(18.0, 0.25, 1.0))
    blunt, sharp, deep = (2.0, 1.0, MEAN), (1.0, 1.0, MEAN), 0.1

    def in_the_dent() -> tuple[float, tuple[float, ...], tuple[float, ...]]:
        memory, rolled, at = untouched(law), UNTOUCHED, deep
        push, memory, rolled = shaped_force(law, blunt, at, memory, rolled)
        while push > 0.0:
            at *= 0.999
            push, memory, rolled = shaped_force(law, blunt, at, memory, rolled)
        assert shaped.stored(law, sharp, at, shaped.kept(law, memory)) > 0.0  # what there would be to gain
        _, memory, rolled = shaped_force(law, sharp, at, memory, rolled)
        return at, memory, rolled

    at, memory, rolled = in_the_dent()
    for overlap in np.linspace(at, 0.0, 50).tolist():
        push, memory, rolled = shaped_force(law, sharp, overlap, memory, rolled)
        assert push <= 1e-12  # round-off of the dent's depth
    at, memory, rolled = in_the_dent()
    push, _, _ = shaped_force(law, sharp, 0.15, memory, rolled)
    assert push == pytest.approx(shaped.force(law, sharp, 0.15, untouched(law))[0], rel=1e-12)
    work, before = 0.0, 0.0
    for overlap in np.linspace(at, deep, 400).tolist():
        push, memory, rolled = shaped_force(law, sharp, overlap, memory, rolled)
        work, before = work + 0.5 * (push + before) * (deep - at) / 399.0, push
    assert push > 0.0
    assert shaped_stored(law, MEAN, deep, memory, rolled) <= work * (1.0 + 1e-3)  # trapezium


def test_separation_clears_everything() -> None:
    law = Yielding(1.0, 5.0)
    _, memory, rolled = shaped_force(law, (1.0, 1.0, MEAN), 0.5, untouched(law), UNTOUCHED)
    assert shaped_force(law, (1.0, 1.0, MEAN), 0.0, memory, rolled) == (0.0, untouched(law), UNTOUCHED)


def test_a_law_of_spheres_is_none_of_ellipsoids() -> None:
    with pytest.raises(InputError, match="no law for ellipsoids"):
        shaped_law_of(elastic.Hertz(1.0, 1.0))
    with pytest.raises(InputError, match="registered already"):
        shaped.register(YIELDING)
