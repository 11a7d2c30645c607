"""The whole-range law: its limits, its continuity, and no energy from nothing, over all materials and depths."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlaws import dispatch
from contactlaws.elastic import HertzFiniteSize
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.path import scan, trace
from contactlaws.whole_range import DEEPEST, END, unloading, whole_range, whole_range_compact, whole_range_force
from contactlaws.whole_range_loading import AREA, BAR, INDENTATION, PRESSURE, elastic_area, elastic_load, loading_load, plastic_limit
from contactlaws.whole_range_unloading import shape, shape_slope, shape_terms, shape_work

MAKERS = pytest.mark.parametrize("make", [whole_range, whole_range_compact], ids=["whole", "compact"])
SLOW = pytest.mark.compiled_only(reason="tens of thousands of evaluations of the law")


def body(make: Any, modulus: float, poissons_ratio: float = 0.3) -> Any:
    """Radius and yield stress 1."""
    return make(Material(modulus, poissons_ratio, 1.0), 1.0)


@MAKERS
@pytest.mark.parametrize("modulus", [1.0, 20.0, 1e4])
def test_exactly_elastic_before_yield(make: Any, modulus: float):
    law = body(make, modulus)
    factors = (law.force_1, law.force_2, law.force_3)
    elastic = HertzFiniteSize(1.0, modulus / (1.0 - 0.3**2), *factors, 0.0, 0.0)
    path = law.yield_depth * np.array([0.2, 0.9999, 0.5, 0.1, 1.0])
    mine, theirs = scan(law, path), scan(elastic, path)
    np.testing.assert_allclose(mine.force, theirs.force, rtol=1e-14)  # round-off
    np.testing.assert_allclose(mine.stored_energy, theirs.stored_energy, rtol=1e-14)
    assert not mine.dissipated_energy.any()


@MAKERS
@pytest.mark.parametrize("modulus", [2.0, 20.0, 1e4])
def test_yield_keeps_force_and_slope(make: Any, modulus: float):
    law = body(make, modulus)
    for step in (1e-3, 1e-5):
        below, above = np.diff(trace(law, law.yield_depth * (1.0 + step * np.array([-1.0, 0.0, 1.0]))).force)
        # beyond yield f_el/f - 1 is at most z^2 (1 + lag)/onset with z = (share at yield)/2 step: the slopes differ by a multiple of step
        assert abs(above / below - 1.0) < 100.0 * step


@MAKERS
def test_hertz_with_its_finite_size_for_small_overlaps(make: Any):
    law = body(make, 50.0)
    depth = 1e-8
    hertz = 4.0 / 3.0 * 50.0 / (1.0 - 0.3**2) * depth**1.5
    assert trace(law, [depth]).force[0] == pytest.approx(hertz, rel=1.1 * math.sqrt(depth) * abs(law.force_1))


@MAKERS
def test_similarity_and_mesarovic_johnson_where_stiff_and_shallow(make: Any):
    """E/Y = 1e10 at D = 1e-8: fully plastic, small against the body. p = 2.84 Y, a^2 = 2.86 R d, w = 2 (1 - nu^2) F/(pi a E)."""
    nu, depth, modulus = 0.3, 1e-8, 1e10
    law = body(make, modulus, nu)
    load, phi, area, recovered, _ = unloading(law, depth)
    small = 1e-3  # factors of the finite body go with sqrt(D) = 1e-4, what is left of the elastic part with phi
    assert phi < 1e-3
    assert load / depth == pytest.approx(INDENTATION, rel=small)
    assert area / depth == pytest.approx(AREA, rel=5.0 * phi + small)
    assert load / area == pytest.approx(PRESSURE, rel=5.0 * phi + small)
    # theirs holds for an even pressure; finite elements (E/Y = 1e6, D = 3e-4) give 1.04 of it, curves from D = .01 on, fitted, some less
    assert recovered == pytest.approx(2.0 * (1.0 - nu**2) * load / math.sqrt(area) / modulus, rel=0.05)


@MAKERS
def test_a_bar_of_constant_volume_where_deep(make: Any):
    """The plastic limit towards D = 1: Y on the area 2/3 pi R^2/(1 - D)."""
    left = 1e-6
    assert plastic_limit(body(make, 100.0), 1.0 - left) * left == pytest.approx(BAR, rel=20.0 * left)  # ratio of cubics: smooth there


@MAKERS
@pytest.mark.parametrize("modulus", [2.0, 15.0, 200.0, 1e5])
def test_unloading_starts_with_the_force_and_radius_of_the_loading(make: Any, modulus: float):
    law = body(make, modulus)
    for top in (1.01 * law.yield_depth, 0.5, 0.7):
        step = 1e-9 * unloading(law, top)[3]
        found = trace(law, [top, top - step, top])
        assert found.force[2] == found.force[0]
        # a step of 1e-9 of the recovery: the force falls with a slope of at most some 5, the area with one of some 2
        np.testing.assert_allclose(found.force, found.force[0], rtol=1e-8)
        np.testing.assert_allclose(found.contact_radius, found.contact_radius[0], rtol=1e-8)


def test_does_not_depend_on_units():
    material, radius = Material(142e9, 0.25, 7.9e9), 5e-6
    one, other = whole_range(material, radius), body(whole_range, 142.0 / 7.9, 0.25)
    path = np.array([0.01, 0.3, 0.25, 0.29, 0.4, 0.3])
    si, plain = scan(one, radius * path), scan(other, path)
    unit = radius**2 * 7.9e9
    np.testing.assert_allclose(si.force, unit * plain.force, rtol=1e-12)  # round-off
    np.testing.assert_allclose(si.contact_radius, radius * plain.contact_radius, rtol=1e-12)
    np.testing.assert_allclose(si.dissipated_energy, radius * unit * plain.dissipated_energy, rtol=1e-11)


@SLOW
@MAKERS
@pytest.mark.parametrize("poissons_ratio", [0.0, 0.2, 0.35, 0.45, 0.4999])
def test_no_energy_from_nothing_over_the_whole_range(make: Any, poissons_ratio: float):
    """Closed paths gain nothing if the recovered energy grows no faster than the work of the loading, and unloading stays below it."""
    depths = np.geomspace(1e-6, 0.9, 240)
    shares = np.linspace(0.02, 0.98, 9)
    step = 1e-5
    for modulus in np.geomspace(1.0, 1e5, 31):
        law = body(make, float(modulus), poissons_ratio)
        limit = law.yield_depth
        for depth in depths[depths > limit * (1.0 + step)]:
            load, phi, area, recovered, _ = unloading(law, depth)
            assert 0.0 < phi <= 1.0
            assert 0.0 < load < math.inf
            assert 0.0 < area < math.inf
            assert 0.0 < recovered <= depth
            below, above = (energy_of(unloading(law, depth * (1.0 + side * step))) for side in (-1.0, 1.0))
            # central difference of a smooth function: its error goes with the square of the step, round-off with 1e-16/step
            assert (above - below) / (2.0 * step * depth) <= load * (1.0 + 1e-6)
        path = np.concatenate(([0.0], depths))
        assert (np.diff(trace(law, path).force) > 0.0).all()
        for depth in depths[depths > limit][::8]:
            recovered = unloading(law, depth)[3]
            down = depth - recovered * (1.0 - shares[::-1])
            force = trace(law, np.concatenate(([depth], down))).force
            assert (np.diff(force) <= 0.0).all()
            # the compact shape lets a body of E/Y about 1 unload above its loading by some 1e-3 of the largest force just past yield; no
            # path gains by that, since the largest overlap is remembered
            excess = 1e-9 if make is whole_range else 2e-3
            assert (force[1:] <= trace(law, down[::-1]).force[::-1] + excess * force[0]).all()


def energy_of(state: tuple[Any, ...]) -> float:
    load, _, _, recovered, terms = state
    return load * recovered * shape_work(terms, 1.0)


@pytest.mark.parametrize("phi", [1.0, 0.9, 0.5, 0.01])
@pytest.mark.parametrize("depth", [0.01, 0.2, 0.5])
def test_shape_its_slope_and_its_work_belong_together(phi: float, depth: float):
    terms = shape_terms(body(whole_range, 20.0), depth, phi)
    assert shape(terms, 1.0) == pytest.approx(1.0, rel=1e-14)
    step = 1e-6
    for s in (0.1, 0.5, 0.9):
        # central difference of a smooth function: step^2, and round-off over the step
        assert (shape(terms, s + step) - shape(terms, s - step)) / (2.0 * step) == pytest.approx(shape_slope(terms, s), rel=1e-8)
        points, weights = np.polynomial.legendre.leggauss(40)
        v = 0.5 * (1.0 + points)  # s v^4: the integrand goes with a power of v of at least 7
        work = sum(2.0 * weight * s * at**3 * shape(terms, s * at**4) for at, weight in zip(v, weights, strict=True))
        assert shape_work(terms, s) == pytest.approx(work, rel=1e-8)


def back(law: Any, top: float, shares: Any) -> Any:
    """Force and contact radius of an unloading from the depth `top`: there, and at these shares of its recovery."""
    return trace(law, np.concatenate(([top], overlaps(law, top, shares))))


def overlaps(law: Any, top: float, shares: Any) -> Any:
    return top - unloading(law, top)[3] * (1.0 - np.asarray(shares))


def test_a_small_contact_is_let_go_with_the_stiffness_of_its_radius():
    """dF/dd = 2 E* a (Pharr, Oliver & Brotzen 1992), all along: the radius goes with the slope of the force, by central differences."""
    law = body(whole_range, 1e6)
    shares = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    step = 1e-4
    above, at, below = (back(law, 1e-6, shares + side * step) for side in (1.0, 0.0, -1.0))
    stiffness = (above.force[1:] - below.force[1:]) / (overlaps(law, 1e-6, shares + step) - overlaps(law, 1e-6, shares - step))
    # 1.05 times 2 E* a, where the pressure is as uneven as finite elements have it; what is constant drops out of the radius
    ratio = stiffness / (2.0 * 1e6 / (1.0 - 0.3**2) * at.contact_radius[1:])
    assert ratio == pytest.approx(ratio[-1], rel=0.03)
    assert ratio[-1] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("modulus", [2.0, 20.0, 500.0, 1e5])
def test_area_of_an_unloading_goes_over_into_the_elastic_one_at_yield(modulus: float):
    law = body(whole_range, modulus)
    shares = np.array([0.9, 0.5, 0.2, 0.05])
    elastic = np.sqrt([elastic_area(law, law.yield_depth * share) for share in shares])
    misses = []
    for beyond in (1e-2, 1e-4, 1e-8):
        found = back(law, law.yield_depth * (1.0 + beyond), shares).contact_radius[1:]
        misses.append(abs(found / elastic - 1.0).max())
    assert misses[0] > misses[1] > misses[2]
    assert misses[2] < 1e-3  # the recovery leaves the elastic one with a vertical tangent


@SLOW
@MAKERS
@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 5.0).map(lambda power: 10.0**power), st.floats(0.0, 0.4999), st.floats(-5.0, -0.05).map(lambda power: 10.0**power))
def test_the_contact_never_grows_while_it_is_let_go(make: Any, modulus: float, poissons_ratio: float, top: float):
    radius = back(body(make, modulus, poissons_ratio), top, np.linspace(1.0, 0.0, 60)).contact_radius
    assert np.isfinite(radius).all()
    assert (np.diff(radius) <= 1e-9 * radius[0]).all()
    assert radius[-1] >= 0.0


@SLOW
@settings(max_examples=40, deadline=None)
@given(
    modulus=st.floats(0.0, 5.0).map(lambda power: 10.0**power),
    poissons_ratio=st.floats(0.0, 0.4999),
    deepest=st.floats(-5.0, -0.05).map(lambda power: 10.0**power),
    turns=st.lists(st.floats(-0.05, 1.0), min_size=1, max_size=6),
)
def test_any_material_on_any_path_gives_back_no_more_than_was_put_in(
    modulus: float, poissons_ratio: float, deepest: float, turns: list[float]
):
    law = body(whole_range, modulus, poissons_ratio)
    corners = np.concatenate(([0.0], np.array(turns), [0.0])) * deepest
    path = np.concatenate([np.linspace(a, b, 400) for a, b in zip(corners, corners[1:], strict=False)])
    found = scan(law, path)
    work = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(path) * (found.force[1:] + found.force[:-1]))))
    # a trapezoid misses at most h^2/8 times the change of slope in a row; slopes stay below the bound, up and down once a leg
    missed = len(turns) * 4.0 * dispatch.stiffness_bound(law, deepest) * (deepest / 399.0) ** 2
    assert work.min() >= -missed
    assert found.force.min() >= 0.0
    assert np.all(np.diff(found.dissipated_energy) >= -1e-12 * abs(found.dissipated_energy).max())


def test_beyond_its_end_the_force_stays_and_is_got_back():
    law = body(whole_range, 30.0)
    found = scan(law, [END, END + 0.2, END])
    np.testing.assert_allclose(found.force, found.force[0], rtol=1e-14)  # round-off: one loads, the others unload
    np.testing.assert_allclose(found.dissipated_energy[1], found.dissipated_energy[0], rtol=1e-14)


def test_wants_a_body_that_yields():
    with pytest.raises(InputError, match="yield_stress"):
        whole_range(Material(1e9, 0.3), 1.0)
    with pytest.raises(InputError, match="radius"):
        whole_range(Material(1e9, 0.3, 1e7), -1.0)


def test_elastic_parts_are_what_they_say():
    law = body(whole_range, 5.0)
    assert loading_load(law, 0.5 * law.yield_depth) == elastic_load(law, 0.5 * law.yield_depth)
    assert elastic_area(law, 1e-10) == pytest.approx(1e-10, rel=1e-4)


@SLOW
@pytest.mark.parametrize("poissons_ratio", [0.0, 0.15, 0.3, 0.45, 0.4999])
def test_the_loading_has_no_corner(poissons_ratio: float):
    """Beyond yield d ln F/d ln D changes by little from one overlap to one half a percent deeper, up to where the formulas end.

    Of the whole law only: the compact one has no constant for the onset.
    """
    for modulus in (1.0, 1.5, 2.0, 2.5, 3.2, 5.0, 10.0, 50.0, 1e3, 1e5):
        law = body(whole_range, modulus, poissons_ratio)
        depths = np.geomspace(1.02 * law.yield_depth, DEEPEST, round(math.log(DEEPEST / (1.02 * law.yield_depth)) / 0.005))
        if depths.size < 3:
            continue
        slope = np.diff(np.log(trace(law, depths).force)) / np.diff(np.log(depths))
        # elastic to plastic, 1.5 to .5, takes more than a tenth of the overlap in the sharpest curves of finite elements (E/Y 2 to 5)
        assert abs(np.diff(slope)).max() < 0.1, modulus


@pytest.mark.parametrize("largest", [0.0, 0.05, 0.4])
def test_an_overlap_that_is_not_a_number_gives_no_force(largest: float):
    """A diverged simulation must not go on unnoticed."""
    law = body(whole_range, 50.0)
    assert math.isnan(whole_range_force(law, math.nan, 0.0, 0.0, (largest, 0.0, 0.0, 0.0, 0.0, 0.0))[0])


@MAKERS
def test_beyond_the_formulas_force_and_area_grow_as_those_of_a_bar(make: Any):
    """Continuous where the formulas end, and with 1/(1 - D) from there on."""
    law = body(make, 100.0)
    found = trace(law, [DEEPEST * (1.0 - 1e-9), DEEPEST * (1.0 + 1e-9), 0.8, 0.95])
    assert found.force[1] == pytest.approx(found.force[0], rel=1e-7)  # slopes of a few times the force, over 1e-9
    assert found.contact_radius[1] == pytest.approx(found.contact_radius[0], rel=1e-7)
    np.testing.assert_allclose(found.force[2:] * [0.2, 0.05], found.force[1] * (1.0 - DEEPEST), rtol=1e-8)
    np.testing.assert_allclose(found.contact_radius[2:] ** 2 * [0.2, 0.05], found.contact_radius[1] ** 2 * (1.0 - DEEPEST), rtol=1e-8)
