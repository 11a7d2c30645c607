"""Two unlike spheres as two equal ones: what small-overlap theory says of them, and no more."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlaws import pair
from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton, thornton_yield_overlap
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.pair import effective, first_yield_pressure, pressure_at_yield, share_of_softer

ROUND_OFF = 1e-12

#: compiling takes longer than the deadline of an example
untimed = settings(deadline=None, max_examples=60)

bodies = st.tuples(
    st.builds(
        Material,
        st.floats(1e6, 1e12),
        st.floats(0.0, 0.499),
        st.none() | st.floats(1e5, 1e10),
        st.none(),
    ),
    st.floats(1e-6, 1.0),
)


@untimed
@given(bodies)
def test_two_equal_spheres_are_that_sphere(body: tuple[Material, float]):
    material, radius = effective(*body, *body)
    assert material.youngs_modulus == pytest.approx(body[0].youngs_modulus, rel=ROUND_OFF)
    assert material.poissons_ratio == pytest.approx(body[0].poissons_ratio, rel=ROUND_OFF)
    assert (material.yield_stress, radius) == (body[0].yield_stress, pytest.approx(body[1], rel=ROUND_OFF))


@untimed
@given(bodies, bodies)
def test_who_comes_first_does_not_matter(one: tuple[Material, float], two: tuple[Material, float]):
    there, back = effective(*one, *two), effective(*two, *one)
    assert there.radius == pytest.approx(back.radius, rel=ROUND_OFF)
    assert there.material.reduced_modulus == pytest.approx(back.material.reduced_modulus, rel=ROUND_OFF)
    if first_yield_pressure(one[0]) != first_yield_pressure(two[0]):
        assert there.material.yield_stress == back.material.yield_stress


@untimed
@given(bodies, bodies, st.floats(1e-6, 1e-3))
def test_elastic_pair_is_hertz_with_both_curvatures(one: tuple[Material, float], two: tuple[Material, float], share: float):
    (m1, r1), (m2, r2) = one, two
    material, radius = effective(m1, r1, m2, r2)
    law = Hertz(radius, material.reduced_modulus)
    overlap = share * min(r1, r2)
    modulus = 1.0 / ((1.0 - m1.poissons_ratio**2) / m1.youngs_modulus + (1.0 - m2.poissons_ratio**2) / m2.youngs_modulus)
    force, _ = pair.pair_force(law, pair.pair_scale(law, r1, r2), overlap, 0.0, 0.0, ())
    assert force == pytest.approx(4.0 / 3.0 * modulus * math.sqrt(r1 * r2 / (r1 + r2)) * overlap**1.5, rel=ROUND_OFF)


@untimed
@given(bodies, bodies, st.floats(1e-6, 1e-3), st.floats(0.1, 1.0))
def test_no_share_changes_small_overlaps(one: tuple[Material, float], two: tuple[Material, float], depth: float, share: float):
    """Elastic and plastic line of Thornton's law, contact radius, energies, stiffness: as for two equal bodies."""
    (m1, r1), (m2, r2) = one, two
    half, other = effective(m1, r1, m2, r2), effective(m1, r1, m2, r2, share)
    pressure = min(1e3 * half.material.youngs_modulus, first_yield_pressure(half.material))
    laws = [Thornton(body.radius, body.material.reduced_modulus, pressure) for body in (half, other)]
    largest = depth * min(r1, r2)
    _, state = pair.pair_force(laws[0], 1.0, largest, 0.0, 0.0, (0.0,))
    _, shared = pair.pair_force(laws[1], 1.0, largest, 0.0, 0.0, (0.0,), share)
    for overlap in (largest, 0.99 * largest):
        equal = pair.pair_force(laws[0], 1.0, overlap, 0.0, 0.0, state)[0], *pair.pair_energy(laws[0], 1.0, overlap, state)
        found = pair.pair_force(laws[1], 1.0, overlap, 0.0, 0.0, shared, share)[0], *pair.pair_energy(laws[1], 1.0, overlap, shared, share)
        scale = (equal[0], *[max(equal[1:])] * 2)
        assert found == pytest.approx(equal, rel=1e-9, abs=1e-9 * max(scale[1], 1e-300))  # energies are differences of larger ones
        radii = pair.pair_contact_radius(laws[0], 1.0, overlap, state), pair.pair_contact_radius(laws[1], 1.0, overlap, shared, share)
        assert radii[0] == pytest.approx(radii[1], rel=1e-9)
    bounds = pair.pair_stiffness_bound(laws[0], 1.0, largest), pair.pair_stiffness_bound(laws[1], 1.0, largest, share)
    assert bounds[0] == pytest.approx(bounds[1], rel=1e-9)


@untimed
@given(bodies, bodies)
def test_share_lies_between_two_equal_bodies_and_one(one: tuple[Material, float], two: tuple[Material, float]):
    share = share_of_softer(*one, *two)
    assert 0.5 <= share <= 1.0
    assert share == pytest.approx(share_of_softer(*two, *one), rel=ROUND_OFF)
    assert share_of_softer(one[0], one[1], one[0], two[1]) == pytest.approx(0.5, rel=ROUND_OFF)


def test_on_a_rigid_flat_the_softer_sphere_is_itself():
    soft, flat = (Material(70e9, 0.33, 0.3e9), 1e-3), (Material(1e22, 0.3), 1e9)
    share = share_of_softer(*soft, *flat)
    body = effective(*soft, *flat, share)
    assert share == pytest.approx(1.0, rel=1e-11)
    assert body.radius == pytest.approx(soft[1], rel=1e-11)
    assert body.material.youngs_modulus == pytest.approx(soft[0].youngs_modulus, rel=1e-11)
    assert body.material[1:] == soft[0][1:]


@untimed
@given(bodies, bodies)
def test_pair_yields_where_the_weaker_body_does(one: tuple[Material, float], two: tuple[Material, float]):
    """Overlap (pi p/(2 E*))^2 R of the pair at the smaller of the two pressures of first yield; then F grows by pi p R (Thornton)."""
    (m1, r1), (m2, r2) = one, two
    material, radius = effective(m1, r1, m2, r2)
    pressure = min(first_yield_pressure(m1), first_yield_pressure(m2))
    if math.isinf(pressure):
        assert material.yield_stress is None
        return
    assert first_yield_pressure(material) == pytest.approx(pressure, rel=ROUND_OFF)
    law = Thornton(radius, material.reduced_modulus, first_yield_pressure(material))
    modulus, curvature = 1.0 / (1.0 / m1.reduced_modulus + 1.0 / m2.reduced_modulus), 1.0 / r1 + 1.0 / r2
    limit = (math.pi * pressure / (2.0 * modulus)) ** 2 / curvature
    assert 2.0 * thornton_yield_overlap(law) == pytest.approx(limit, rel=ROUND_OFF)
    scale = pair.pair_scale(law, r1, r2)
    rise = pair.pair_force(law, scale, 3.0 * limit, 0.0, 0.0, (0.0,))[0] - pair.pair_force(law, scale, 2.0 * limit, 0.0, 0.0, (0.0,))[0]
    assert rise == pytest.approx(math.pi * pressure / curvature * limit, rel=1e-9)  # a difference of forces of its own size


def test_a_rigid_flat_gives_back_the_law_on_a_flat():
    """The sphere of diameter d on a rigid flat is half of a pair of spheres that double its overlap."""
    soft, rigid = Material(70e9, 0.33, 0.3e9), Material(1e22, 0.3)
    material, radius = effective(soft, 1e-3, rigid, 1e9)
    assert radius == pytest.approx(2e-3, rel=1e-11)
    assert material.reduced_modulus == pytest.approx(2.0 * soft.reduced_modulus, rel=1e-10)
    alone, both = Hertz(1e-3, soft.reduced_modulus), Hertz(radius, material.reduced_modulus)
    one, _ = pair.pair_force(both, 1.0, 1e-6, 0.0, 0.0, ())
    flat = 4.0 / 3.0 * alone.reduced_modulus * math.sqrt(1e-3) * 1e-6**1.5
    assert one == pytest.approx(flat, rel=1e-10)


@untimed
@given(st.floats(0.0, 0.4999))
def test_pressure_at_yield_is_the_maximum_over_depth(nu: float):
    """Against a scan of the axis in steps of a thousandth of the contact radius; its own error is second order in the step."""
    depths = [0.001 * k for k in range(1, 2001)]
    stress = max(abs((1.0 + nu) * (1.0 - z * math.atan(1.0 / z)) - 1.5 / (1.0 + z * z)) for z in depths)
    assert pressure_at_yield(nu) == pytest.approx(1.0 / stress, rel=1e-5)


def test_all_that_is_wrong_is_said_at_once():
    with pytest.raises(InputError) as caught:
        effective(Material(-1.0, 0.3), 1.0, Material(1.0, 0.5, 0.0), math.nan, 0.0)
    assert [problem.name for problem in caught.value.problems] == [
        "material_1: youngs_modulus",
        "material_2: yield_stress",
        "material_2: poissons_ratio",
        "radius_2",
        "share",
    ]
