"""The Maxwell-Zener law: exact while the contact grows, however the steps are chosen; where it is cut off; energy; files."""

from __future__ import annotations

import json

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from contactlaws import dispatch, pair
from contactlaws.elastic import HertzFiniteSize, finite_size_factors
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw, load, save
from contactlaws.maxwell_zener import FIRST, LOST, MaxwellZener, maxwell_zener
from contactlaws.path import scan, trace
from contactlaws.prony import Relaxation, uniaxial
from tests.contactlaws.histories import MATERIALS, PVDF, STRONG, UNIT, WIDE, between, elastic, lee_radok, programme, work

BY_NAME = pytest.mark.parametrize("modulus", MATERIALS.values(), ids=MATERIALS)
#: PVDF of Wahn, Gan & Kamlah 2022 at constant Poisson's ratio
WAHN = uniaxial(Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,)), 0.4314).reduced


def straight(turns, time, rows):
    """A path on which the elastic force, not the overlap, is straight in time."""
    seconds, force = between(time, np.asarray(turns) ** 1.5, rows)
    return seconds, force ** (2.0 / 3.0)


@pytest.mark.parametrize("nu", [None, 0.0, 0.3, 0.4999])
def test_without_terms_it_is_the_elastic_law(nu):
    path = np.concatenate((np.linspace(0.0, 0.3, 40), np.linspace(0.3, -0.1, 30)))
    factors = (0.0,) * 5 if nu is None else finite_size_factors(nu)
    found, expected = scan(maxwell_zener(Relaxation(UNIT), 1.0, nu), path), scan(HertzFiniteSize(1.0, UNIT, *factors), path)
    np.testing.assert_array_equal(found.force, expected.force)
    np.testing.assert_array_equal(found.contact_radius, expected.contact_radius)
    assert not found.states[:, LOST].any()


@BY_NAME
@pytest.mark.parametrize("rows", [7, 100, 1000])
def test_one_step_is_as_good_as_many_where_the_elastic_force_is_straight(modulus, rows):
    """Load, hold, load on, retreat a little: the recurrence is exact, so only round-off is left."""
    turns, time = (0.0, 0.4, 0.4, 1.0, 0.95), (0.0, 0.3, 5.0, 5.1, 5.2)
    law = maxwell_zener(modulus, 1.0)
    many, one = (trace(law, *straight(turns, time, n)[::-1]).force[::n] for n in (rows, 1))
    np.testing.assert_allclose(many, one, rtol=1e-12)


@BY_NAME
def test_growing_contact_is_lee_and_radoks(modulus):
    """A ramp of the overlap, then a hold. In a step the elastic force counts as straight: 1/8 h^2 F_e'' psi', 2e-6 at 400 steps."""
    time, overlap = between((0.0, 1.0, 5.0), (0.0, 1.0, 1.0), 400)
    found = trace(maxwell_zener(modulus, 1.0), overlap, time).force
    rows = [40, 150, 400, 420, 600, 800]
    expected = [lee_radok(modulus, float(time[i]), min(float(time[i]), 1.0)) for i in rows]
    np.testing.assert_allclose(found[rows], expected, atol=4e-6)


@BY_NAME
def test_limits_of_speed(modulus):
    """With programmes 1e9 times faster and slower than the relaxation times; what is left is 1e-8 of the force."""
    time, overlap = between((0.0, 1.0), (0.0, 1.0), 50)
    law = maxwell_zener(modulus, 1.0)
    np.testing.assert_allclose(trace(law, overlap, 1e-9 * time).force, elastic(overlap), atol=1e-8)
    np.testing.assert_allclose(trace(law, overlap, 1e10 * time).force, modulus.long_term / UNIT * elastic(overlap), atol=1e-7)


@BY_NAME
def test_a_jump_and_a_hold_give_the_relaxation_function(modulus):
    """dt = 0, then steps of any length at rate 0, to 1e6 relaxation times: F_e psi(t)."""
    time = np.concatenate(([0.0, 0.0], np.geomspace(1e-8, 1e7, 200)))
    found = trace(maxwell_zener(modulus, 1.0), np.concatenate(([0.0], np.full(201, 0.3))), time).force
    np.testing.assert_allclose(found[1:], elastic(np.float64(0.3)) * modulus.at(time[1:]) / UNIT, rtol=1e-12)  # 200 factors exp(-dt/tau)


@pytest.mark.parametrize("cycles", [1000, pytest.param(1_000_000, marks=pytest.mark.compiled_only("takes a minute"))])
def test_the_long_term_spring_does_not_drift(cycles):
    """Oscillation about .5, then rest for 100 relaxation times: the elastic force of the long-term modulus, as closed as it is written."""
    overlap = 0.5 + 0.1 * np.sin(np.linspace(0.0, 2.0 * np.pi * cycles / 10.0, cycles))
    time = np.concatenate((np.linspace(0.0, 100.0, cycles), [1100.0]))
    found = trace(maxwell_zener(WIDE, 1.0), np.append(overlap, 0.5), time).force
    assert found[-1] == pytest.approx(WIDE.long_term / UNIT * 0.5**1.5, rel=1e-13)


def test_spheres_of_pvdf_at_two_per_cent():
    """Two spheres of 5 um, .2 um closer: limits 1.5822e-4 and 2.0509e-4 N, 1.9615e-4 N after 1 s, .65 % above the limit at 7.5 s."""
    law, closer = maxwell_zener(WAHN, 5e-6), 0.02 * 10e-6
    scale = pair.pair_scale(law, 5e-6, 5e-6)

    def pressed(ramp, hold, rows=1000):
        state, force = dispatch.initial_state(law), []
        times, overlaps = between((0.0, ramp, ramp + hold), (0.0, closer, closer), rows)
        for dt, overlap in zip(np.diff(times, prepend=0.0).tolist(), overlaps.tolist(), strict=True):
            push, state = pair.pair_force(law, scale, overlap, 0.0, dt, state)
            force.append(push)
        return np.array(force)

    assert pressed(1e-9, 1e-9, 10)[10] == pytest.approx(2.0509e-4, abs=5e-9)  # half of the last digit given
    assert pressed(1.0, 1e4, 10)[-1] == pytest.approx(1.5822e-4, abs=5e-9)
    ramp = pressed(1.0, 6.5)
    assert ramp.max() == pytest.approx(1.9615e-4, abs=5e-9)
    assert ramp[-1] / 1.5822e-4 - 1.0 == pytest.approx(0.0065, abs=1e-4)  # of the limit's last digit


@BY_NAME
def test_a_contact_that_opens_forgets(modulus):
    law = maxwell_zener(modulus, 1.0, 0.3)
    time, overlap = between((0.0, 1.0, 2.0), (-0.1, 0.2, -0.1), 30)
    found = scan(law, np.concatenate((overlap, overlap)), np.concatenate((time, time + 2.0)))
    np.testing.assert_allclose(found.force[61:], found.force[:61], atol=1e-14)  # the second time, steps are of other round-off
    assert not found.states[[0, 60, 61]].any()


@BY_NAME
@pytest.mark.parametrize("name", ["ramp and release", "cycles", "steps", "re-contact before recovery"])
def test_work_is_in_the_springs_or_lost(modulus, name):
    """The springs' energy from their strains, which the law keeps for each term, against work less loss, while the force is not cut off.

    Both count the overlap as straight in a step, but the force not: second order in the step.
    """
    differences = []
    for rows in (100, 200):
        time, overlap = programme(name, rows)
        found = scan(maxwell_zener(modulus, 1.0), overlap, time)
        cut = np.flatnonzero(found.force[1:] <= 0.0)
        last = cut[0] if cut.size else overlap.size
        terms = len(modulus.times)
        springs = modulus.long_term / UNIT * 0.4 * overlap**2.5 + 0.5 * found.states[:, FIRST + terms :] @ np.array(modulus.fractions)
        np.testing.assert_allclose(found.stored_energy + found.dissipated_energy, work(overlap, found.force), atol=1e-14)
        differences.append(abs(found.stored_energy - springs)[:last].max())
    assert differences[0] < 3e-3 * 0.4  # of the energy of the whole press
    assert differences[1] < 0.6 * differences[0] or differences[1] < 1e-5  # steps in no time have an error of their own


@st.composite
def random_paths(draw):
    turns = draw(st.integers(1, 6))
    lasts = [10.0 ** draw(st.floats(-8.0, 8.0)) * draw(st.sampled_from([0.0, 1.0])) for _ in range(turns)]
    depths = [draw(st.floats(-0.1, 0.3) | st.floats(-9.0, -1.0).map(lambda x: 10.0**x)) for _ in range(turns)]
    return between(np.concatenate(([0.0], np.cumsum(lasts))), [0.0, *depths], 20)


@settings(max_examples=60)
@given(random_paths(), st.sampled_from([PVDF, STRONG, WIDE]), st.sampled_from([None, 0.0, 0.4999]))
def test_finite_and_without_tension_on_any_path(path, modulus, nu):
    time, overlap = path
    found = scan(maxwell_zener(modulus, 1.0, nu), overlap, time)
    for column in found:
        assert np.isfinite(column).all()
    assert (found.force >= 0.0).all()
    assert not found.force[overlap <= 0.0].any()
    closed = np.flatnonzero(overlap > 0.0)
    lost = found.states[:, LOST]
    together = closed[1:][np.diff(closed) == 1]
    assert (lost[together] >= lost[together - 1]).all()


def test_two_times_twelve_decades_apart():
    """Jump, then rest: each term is gone when its time is, and not before."""
    modulus = Relaxation(UNIT, (0.3, 0.4), (1e-6, 1e6))
    time = np.concatenate(([0.0, 0.0], np.geomspace(1e-9, 1e9, 181)))
    found = trace(maxwell_zener(modulus, 1.0), np.concatenate(([0.0], np.full(182, 0.1))), time).force
    np.testing.assert_allclose(found[1:], elastic(np.float64(0.1)) * modulus.at(time[1:]) / UNIT, rtol=1e-12)


def test_tangent_is_never_above_the_bound():
    law = maxwell_zener(STRONG, 1.0, 0.3)
    for dt in (0.0, 0.1, 10.0):
        force = trace(law, [0.1, 0.2, 0.2001], [0.0, 1.0, 1.0 + dt]).force
        assert force[2] - force[1] <= 1e-4 * dispatch.stiffness_bound(law, 0.2001)


@pytest.mark.parametrize(
    ("modulus", "radius", "said"),
    [
        (Relaxation(UNIT, (0.1,), (-1.0,)), 1.0, r"relaxation_times\[1\] = -1.0: must be a positive"),
        (Relaxation(UNIT, (0.1,), (0.0,)), 1.0, r"relaxation_times\[1\] = 0.0: must be a positive"),
        (Relaxation(UNIT, (0.1, 0.1), (1.0, 1.0)), 1.0, "stands there twice"),
        (Relaxation(UNIT, (0.5, 0.5), (1.0, 2.0)), 1.0, "below 1 in sum"),
        (Relaxation(UNIT, (0.5,), (1.0, 2.0)), 1.0, "fractions = 1: must be 2, one for each"),
        (Relaxation(0.0, (0.5,), (1.0,)), 1.0, "reduced_modulus = 0.0: must be a positive"),
        (PVDF, float("nan"), "radius = nan: must be a positive"),
    ],
)
def test_what_is_no_body_is_refused(modulus, radius, said):
    with pytest.raises(InputError, match=said) as raised:
        maxwell_zener(modulus, radius)
    assert len(raised.value.problems) == 1


def test_every_bit_comes_back_from_a_file(tmp_path):
    law = maxwell_zener(WIDE, 1.0 / 3.0, 0.4314)
    again = load(save(FittedLaw(law, 0.1), tmp_path / "law.json")).law
    assert isinstance(again, MaxwellZener)
    for one, two in zip(again, law, strict=True):
        np.testing.assert_array_equal(one, two)
    time, overlap = programme("cycles", 20)
    np.testing.assert_array_equal(trace(again, 0.1 * overlap, time).force, trace(law, 0.1 * overlap, time).force)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"fractions": [0.2, 0.3]}, "fractions = 2: must be 3, one for each relaxation time"),
        ({"times": [-0.1, 1.0, 10.0]}, r"relaxation_times\[1\] = -0.1: must be a positive"),
        ({"times": [1.0, 0.1, 10.0]}, r"relaxation_times\[2\] = 0.1: must rise"),
        ({"fractions": [0.5, 0.3, 0.4]}, "fractions = 1.2: must be below 1 in sum"),
        ({"fractions": 0.5}, "fractions = 0.5: must be a list"),
        ({"fractions": [[0.2, 0.3, 0.4]]}, "fractions = 'ndarray': must be a row of numbers"),
        ({"times": [0.1, None, 10.0]}, "times = .*: must be a list of finite numbers"),
    ],
)
def test_damaged_files_are_refused_with_one_reason(tmp_path, changes, said):
    file = save(FittedLaw(maxwell_zener(WIDE, 1.0), 0.1), tmp_path / "law.json")
    content = json.loads(file.read_text())
    content["parameters"].update(changes)
    file.write_text(json.dumps(content))
    with pytest.raises(InputError, match=said) as raised:
        load(file)
    assert len(raised.value.problems) == 1


@given(seed=st.integers(0, 2**31), terms=st.integers(0, 4), size=st.integers(1, 9), opened=st.floats(0.0, 0.5))
@settings(max_examples=60, deadline=None)
def test_contacts_in_a_block_are_contacts_one_by_one(seed: int, terms: int, size: int, opened: float) -> None:
    """Forces (to round-off of 1000 N), memory and the energy of contacts that end, on random ways with openings.

    Some of the memory's columns are not the block's.
    """
    rng = np.random.default_rng(seed)
    modulus = Relaxation(1000.0, tuple((0.9 / max(terms, 1),) * terms), tuple(np.cumsum(rng.uniform(0.1, 3.0, terms)).tolist()))
    law = maxwell_zener(modulus, 1.0, 0.3)
    rows = dispatch.floats_of_state(law)
    alone, columns, block = np.zeros((size, rows)), np.full((rows, size + 3), 7.0), np.zeros((2 + 3 + dispatch.SCRATCH, 16))
    columns[:, 2 : 2 + size] = 0.0
    for _ in range(12):
        overlap = np.where(rng.random(size) < opened, -rng.random(size), 0.1 * rng.random(size))
        dt = float(10.0 ** rng.uniform(-3.0, 1.0))
        had = alone[:, 3].copy()
        forces = [dispatch.normal_force(law, overlap[q], 0.0, dt, alone[q])[0] for q in range(size)]
        block[2, :size] = overlap
        dispatch.normal_forces(law, dt, columns, 2, size, block, 2)
        np.testing.assert_allclose(block[3, :size], forces, rtol=1e-12, atol=1e-9)
        np.testing.assert_allclose(block[4, :size], np.where(overlap > 0.0, 0.0, had), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(columns[:, 2 : 2 + size].T, alone, rtol=1e-9, atol=1e-9)  # sums in another order
        assert np.all(columns[:, :2] == 7.0)
        assert np.all(columns[:, 2 + size :] == 7.0)
