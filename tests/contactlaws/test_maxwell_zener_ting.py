"""The Maxwell-Zener law that also retreats: against the exact history, its limits, its energy, its memory, in an impact, and from files."""

from __future__ import annotations

import json
import math

import hypothesis.strategies as st
import numba
import numpy as np
import pytest
from hypothesis import given, settings

from contactlaws import dispatch, pair
from contactlaws.elastic import HertzFiniteSize, finite_size_factors, finite_size_force
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw, load, save
from contactlaws.foundation import follow, springs_of
from contactlaws.maxwell_zener import LOST, maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.path import scan, trace
from contactlaws.prony import Relaxation
from contactlaws.remembered_springs import elastic_point, weights
from dem.impact import restitution
from tests.contactlaws.histories import (
    MATERIALS,
    PROGRAMMES,
    PVDF,
    STRONG,
    UNIT,
    WIDE,
    between,
    elastic,
    programme,
    separation_time,
    ting,
    work,
)

BY_NAME = pytest.mark.parametrize("modulus", MATERIALS.values(), ids=MATERIALS)
#: interpreted, a cycle takes a second
COMPILED = not numba.config.DISABLE_JIT
LONG = pytest.mark.compiled_only("takes minutes")
#: overlap over radius at which the programmes are run; that of the uppermost spring, as in `maxwell_zener_ting`
LARGEST = 0.3
#: largest error of the force over the largest force, of each material on all programmes, with 12 and with 32 springs: that of straight
#: lines between springs 1.9 times apart, and it falls by six where the springs are 2.7 times as many, as that of straight lines does
BOUNDS = {"PVDF": (2.1e-3, 3e-4), "90 % relaxing": (1.1e-2, 2e-3), "three terms": (5.5e-3, 9e-4)}


def exact(modulus, overlap, time, count=800):
    """By springs so many that they count as a continuum (7e-7 of the force)."""
    return follow(springs_of(elastic, LARGEST, count), modulus, time, overlap)


@LONG
@BY_NAME
@pytest.mark.parametrize("name", PROGRAMMES)
def test_any_programme_is_near_the_exact_history(modulus, name):
    time, overlap = programme(name, 200)
    overlap = LARGEST * overlap
    true = exact(modulus, overlap, time)
    bounds = BOUNDS[next(key for key, known in MATERIALS.items() if known is modulus)]
    for springs, bound in zip((12, 32), bounds, strict=True):
        found = scan(maxwell_zener_ting(modulus, 1.0, None, LARGEST, springs), overlap, time)
        assert abs(found.force - true.force).max() <= bound * true.force.max()
        assert (found.force >= 0.0).all()
        closed = overlap > 0.0
        last = true.edge[closed] > 0.0
        found_edge = found.contact_radius[closed][last] ** 2  # R d: radius 1
        assert abs(found_edge - np.minimum(true.edge[closed][last], LARGEST)).max() <= 12.0 * bound * LARGEST


@LONG
@BY_NAME
def test_errors_fall_with_the_number_of_springs(modulus):
    time, overlap = programme("growing cycles", 200)
    true = exact(modulus, LARGEST * overlap, time, 1600).force
    errors = [abs(trace(maxwell_zener_ting(modulus, 1.0, None, LARGEST, n), LARGEST * overlap, time).force - true).max() for n in (12, 100)]
    assert errors[1] < errors[0] / 16.0  # the square of 8.3, less a factor of four: edges lie anywhere between two springs


@BY_NAME
def test_first_retreat_is_tings(modulus):
    """Force, and when it ends, by quadrature and root finding; errors of 32 springs as above."""
    time, overlap = programme("ramp and release", 400)
    found = trace(maxwell_zener_ting(modulus, 1.0, None, 1.0 - 1e-9, 32), overlap, time).force
    rows = [300, 400, 410, 450, 500, 560, 600, 640]
    np.testing.assert_allclose(found[rows], [ting(modulus, float(time[i]))[0] for i in rows], atol=1.2e-3)
    parted = time[np.flatnonzero(found > 0.0)[-1]]
    assert parted == pytest.approx(separation_time(modulus), abs=4.0 * time[1])  # the edge of the last spring that holds


@BY_NAME
@pytest.mark.parametrize("nu", [None, 0.3])
def test_growing_contact_is_that_of_the_law_without_this_memory(modulus, nu):
    time, overlap = between((0.0, 1.0, 2.0, 2.0, 9.0), (0.0, 0.1, 0.1, 0.2, 0.5), 60)
    plain, with_memory = (scan(law, overlap, time) for law in (maxwell_zener(modulus, 1.0, nu), maxwell_zener_ting(modulus, 1.0, nu)))
    for one, two in zip(plain[:4], with_memory[:4], strict=True):
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize("name", PROGRAMMES)
@pytest.mark.parametrize("nu", [None, 0.3])
def test_a_body_that_never_relaxes_is_elastic_on_any_path(name, nu):
    """Straight lines are exact for it: with no term, with one of no size, and with one whose time never comes."""
    time, overlap = programme(name, 60)
    overlap = LARGEST * overlap
    factors = (0.0,) * 5 if nu is None else finite_size_factors(nu)
    expected = scan(HertzFiniteSize(1.0, UNIT, *factors), overlap)
    for modulus in (Relaxation(UNIT), Relaxation(UNIT, (0.0,), (1.0,)), Relaxation(UNIT, (0.9,), (1e12,))):
        found = scan(maxwell_zener_ting(modulus, 1.0, nu), overlap, time)
        np.testing.assert_allclose(found.force, expected.force, atol=1e-11)  # the last one has relaxed by 5e-12
        np.testing.assert_allclose(found.contact_radius, expected.contact_radius, atol=1e-5)  # the root of the edge


@BY_NAME
@pytest.mark.parametrize("step", [0.2, 10.0, 1e6])
def test_a_very_slow_cycle_is_the_long_term_bodys(modulus, step):
    """Steps short and long against the relaxation times, slow throughout: what is left is the viscous part, sum g tau F_e' d'."""
    rows = 400 if step < 1.0 else 100
    slowest = max(modulus.times)
    time, overlap = between((0.0, 1.0, 2.0), (0.0, LARGEST, 0.0), rows)
    total = step * rows * slowest if step > 1.0 else 2000.0 * slowest
    found = trace(maxwell_zener_ting(modulus, 1.0), overlap, total * time).force
    expected = modulus.long_term / UNIT * elastic(overlap)
    late = 1.5 * 3.0 * slowest / total * elastic(np.float64(LARGEST))  # 1.5 F_e/d d' tau, three times over
    np.testing.assert_allclose(found, expected, atol=late + 1e-12)


@BY_NAME
def test_changing_the_step_changes_little(modulus):
    """In the middle of a slow retreat, a step in no time: the force falls by no more than the instantaneous tangent allows."""
    law = maxwell_zener_ting(modulus, 1.0)
    time, overlap = between((0.0, 100.0, 200.0), (0.0, LARGEST, 0.05), 50)
    before = scan(law, overlap, time)
    for row in (55, 70, 95):
        for change in (-1e-5, 1e-5):
            after = trace(law, [overlap[row] * (1.0 + change)], [0.0], tuple(before.states[row])).force[0]
            allowed = dispatch.stiffness_bound(law, LARGEST) * abs(change) * overlap[row]
            assert 0.0 <= (after - before.force[row]) * np.sign(change) <= allowed


@st.composite
def random_histories(draw):
    """Programmes of all speeds, closed till the end, of a material of one to three terms; corners of time and overlap."""
    turns = draw(st.integers(2, 7))
    lasts = [10.0 ** draw(st.floats(-4.0, 4.0)) for _ in range(turns)]
    depths = [LARGEST * draw(st.floats(1e-4, 1.0) | st.floats(-4.0, 0.0).map(lambda x: 10.0**x)) for _ in range(turns)]
    terms = draw(st.integers(1, 3))
    places = draw(st.lists(st.integers(-30, 30), min_size=terms, max_size=terms, unique=True))
    total, shares = draw(st.sampled_from([0.2285, 0.5, 0.9])), [draw(st.floats(0.1, 1.0)) for _ in range(terms)]
    modulus = Relaxation(
        UNIT, tuple(total * share / sum(shares) for share in shares), tuple(10.0 ** (place / 10.0) for place in sorted(places))
    )
    return modulus, np.concatenate(([0.0], np.cumsum([*lasts, lasts[-1]]))), np.array([0.0, *depths, 0.0])


@LONG
@settings(max_examples=60)
@given(random_histories())
def test_nothing_is_gained_on_any_path(history):
    """Stored and dissipated energy are the work; what is dissipated never falls while the contact lasts."""
    modulus, corners, depths = history
    time, overlap = between(corners, depths, 50, graded=True)
    law, press = maxwell_zener_ting(modulus, 1.0), 0.4 * LARGEST**2.5
    found = scan(law, overlap, time)
    done = work(overlap, found.force)
    for column in found:
        assert np.isfinite(column).all()
    assert (found.force >= 0.0).all()
    assert done.min() >= -1e-4 * done.max()  # of trapezoids: steps that grow and fall are not the same
    closed = overlap > 0.0
    lost = found.states[:, LOST]
    np.testing.assert_allclose((found.stored_energy + lost)[closed], done[closed], atol=1e-14)
    together = np.flatnonzero(closed)[1:]
    assert (lost[together] >= lost[together - 1])[closed[together - 1]].all()
    # what is left of the springs' energy where the last spring parts, in straight lines between 12 of them; `press`: of a full press
    assert found.stored_energy.min() >= -0.02 * max(done.max(), 1e-3 * press)


@LONG
@BY_NAME
def test_energy_does_not_drift_over_many_cycles(modulus):
    """300 equal cycles: after 200, each stores what the one before did; the account is the springs', not a sum over steps."""
    cycles, rows = 300, 60
    time = np.arange(cycles * rows) / rows
    overlap = LARGEST * (1.0 - 0.2 * (1.0 - np.cos(2.0 * np.pi * time)))
    ramp = np.linspace(0.0, LARGEST, rows, endpoint=False)
    found = scan(maxwell_zener_ting(modulus, 1.0), np.concatenate((ramp, overlap)), np.concatenate((time[:rows], time + 1.0)))
    tops = found.stored_energy[rows::rows]
    np.testing.assert_allclose(tops[200:], tops[-1], rtol=1e-4)  # what is off the flat recovers in retardation times, up to 53 cycles
    assert (np.diff(found.states[:, LOST]) >= 0.0).all()


@LONG
def test_a_million_cycles_leave_nothing_behind():
    """Small oscillations for 1e6 steps, then rest at the largest overlap: the long-term force, in closed form on growth."""
    steps = np.arange(1_000_000)
    overlap = 0.2 + 0.02 * np.sin(0.37 * steps)
    time = np.append(0.01 * steps, 0.01 * steps[-1] + np.array([100.0, 200.0, 1e4]))
    found = trace(maxwell_zener_ting(PVDF, 1.0), np.append(overlap, [0.25, 0.25, 0.25]), time).force
    assert found[-1] == pytest.approx(PVDF.long_term / UNIT * 0.25**1.5, rel=1e-11)  # 1e6 roundings of what has faded since


@BY_NAME
def test_a_jump_a_hold_and_a_jump_back(modulus):
    """dt = 0 at once to .2, a hold at rate 0 for up to 1e6 relaxation times, dt = 0 back: Ting's springs are straight then, and exact."""
    law = maxwell_zener_ting(modulus, 1.0)
    left = modulus.long_term / UNIT
    found = trace(law, [0.0, 0.2, 0.2, 0.2 * 0.99], [0.0, 0.0, 1e7, 1e7]).force
    assert found[1] == pytest.approx(0.2**1.5, rel=1e-13)
    assert found[2] == pytest.approx(left * 0.2**1.5, rel=1e-9)
    # each spring falls by the change of overlap: int F_e'' max(0, left (d - l) - change) dl = left F_e(d - change/left)
    assert found[3] == pytest.approx(left * (0.2 - 0.2 * 0.01 / left) ** 1.5, rel=1e-9)


def test_memory_is_gone_when_the_contact_opens():
    law = maxwell_zener_ting(WIDE, 1.0, 0.3)
    time, overlap = between((0.0, 1.0, 1.5, 2.0, 3.0), (-0.1, 0.2, 0.1, 0.15, -0.1), 30)
    found = scan(law, np.concatenate((overlap, overlap)), np.concatenate((time, time + 3.0)))
    np.testing.assert_allclose(found.force[121:], found.force[:121], atol=1e-14)  # the second time, steps are of other round-off
    assert not found.states[[0, 120, 121]].any()


@BY_NAME
@pytest.mark.parametrize("deepest", [1e-9, 1e-5, 1e-4])
def test_contacts_smaller_than_the_first_spring(modulus, deepest):
    """Up to 3e-4 R there is the first spring, at 0, and the one at the largest overlap: one straight line, and never a pull."""
    time, overlap = programme("ramp and release", 200)
    found = trace(maxwell_zener_ting(modulus, 1.0), deepest * overlap, time).force
    true = follow(springs_of(elastic, 1.0, 400), modulus, time, overlap).force
    assert (found >= 0.0).all()
    np.testing.assert_allclose(found / deepest**1.5, true, atol=0.12)
    np.testing.assert_allclose(found[:201] / deepest**1.5, true[:201], atol=2e-5)


@BY_NAME
def test_beyond_the_last_spring(modulus):
    """At twice the overlap of the uppermost spring, one straight line spans the rest: less close, still without pull or gain."""
    time, overlap = programme("cycles", 100)
    found = scan(maxwell_zener_ting(modulus, 1.0, None, 0.1), 0.2 * overlap, time)
    true = follow(springs_of(elastic, 0.2, 400), modulus, time, 0.2 * overlap).force
    assert abs(found.force - true).max() <= 0.03 * true.max()
    assert (found.force >= 0.0).all()
    assert found.stored_energy.min() >= -1e-3 * found.stored_energy.max()


@LONG
@settings(max_examples=40)
@given(random_histories())
def test_tangent_is_never_above_the_bound(history):
    """From states along a path, a step in no time."""
    modulus, corners, depths = history
    time, overlap = between(corners, depths, 50, graded=True)
    law = maxwell_zener_ting(modulus, 1.0)
    states, force = scan(law, overlap, time).states, trace(law, overlap, time).force
    for row in range(3, overlap.size - 2, 29):
        at = float(overlap[row])
        if at < 1e-6:
            continue
        for change in (-1e-4, 1e-4):
            after = trace(law, [at * (1.0 + change)], [0.0], tuple(states[row])).force[0]
            allowed = dispatch.stiffness_bound(law, max(at * (1.0 + change), float(overlap[: row + 1].max())))
            assert (after - force[row]) / (change * at) <= allowed * (1.0 + 1e-9)


def test_weights_integrate_straight_lines_exactly():
    """int F_e'' p for p = 1 - x, x, x^2 by quadrature, and where the interval is too narrow for differences of energies."""
    law = maxwell_zener_ting(PVDF, 1.0, 0.3)
    x, w = np.polynomial.legendre.leggauss(20)
    for low, high in ((0.01, 0.02), (0.1, 0.1001), (0.1, 0.1 * (1.0 + 1e-9))):
        place = 0.5 * (x + 1.0)
        h = 1e-3 * low
        d = low + (high - low) * place
        curvature = np.array([finite_size_force(law, v + h) - 2.0 * finite_size_force(law, v) + finite_size_force(law, v - h) for v in d])
        expected = [float((0.5 * (high - low) * w * curvature / h**2 * p).sum()) for p in (1.0 - place, place, place**2)]
        np.testing.assert_allclose(weights(elastic_point(law, low), elastic_point(law, high)), expected, rtol=1e-3)  # even below 1e-3 wide


def test_restitution_falls_and_rises_with_the_relaxation_time():
    """Two spheres whose relaxation is much slower than the impact, or much faster, are elastic; in between they lose the most.

    The bodies part while overlaps last: at a ratio of 1 the loss is of the order of the relaxing share. Steps are 1/2000 of the impact.
    """
    ratios = [1e-4, 1e-2, 0.3, 1e2, 1e5] if COMPILED else [0.3]
    mass, radius, modulus = 1000.0 * 4.0 / 3.0 * math.pi * 1e-9, 1e-3, 1e9
    deepest = (15.0 * 0.5 * mass / (16.0 * math.sqrt(0.5 * radius) * 0.5 * modulus)) ** 0.4  # of elastic spheres at 1 m/s
    found = []
    for ratio in ratios:
        law = maxwell_zener_ting(Relaxation(modulus, (0.5,), (ratio * 2.94328 * deepest,)), radius)
        found.append(float(restitution(law, radius, 1000.0, [1.0]).restitution[0]))
    if len(found) > 1:
        assert found[0] > 0.995
        assert found[-1] == pytest.approx(1.0, abs=1e-4)
        assert min(found) < 0.9
    assert all(0.0 < e <= 1.0 + 1e-6 for e in found)


@pytest.mark.parametrize("ratio", [1e-3, 0.3, 1e3])
def test_energy_of_an_impact_is_kept(ratio):
    """Kinetic, stored and dissipated energy of two spheres in a leap-frog of 1000 steps: constant to third order per step, 1e-5 in all."""
    law = maxwell_zener_ting(Relaxation(UNIT, (0.6,), (ratio,)), 1.0)
    scale, mass, dt = pair.pair_scale(law, 1.0, 1.0), 1.0, 0.005
    closer, speed, force, state = 0.0, 0.1, 0.0, dispatch.initial_state(law)
    kinetic = 0.5 * mass * speed**2
    for _ in range(20_000):
        half = speed - 0.5 * dt * force / mass
        closer += dt * half
        if closer <= 0.0:
            break
        force, state = pair.pair_force(law, scale, closer, half, dt, state)
        speed = half - 0.5 * dt * force / mass
        stored, dissipated = pair.pair_energy(law, scale, closer, state)
        assert 0.5 * mass * speed**2 + stored + dissipated == pytest.approx(kinetic, rel=1e-5)
        if force == 0.0 and speed < 0.0:
            break
    assert speed < 0.0


def test_every_bit_comes_back_from_a_file(tmp_path):
    law = maxwell_zener_ting(WIDE, 1.0 / 3.0, 0.4314)
    again = load(save(FittedLaw(law, 0.1), tmp_path / "law.json")).law
    assert type(again) is type(law)
    for one, two in zip(again, law, strict=True):
        np.testing.assert_array_equal(one, two)
    time, overlap = programme("cycles", 20)
    np.testing.assert_array_equal(trace(again, 0.1 * overlap, time).force, trace(law, 0.1 * overlap, time).force)


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("fractions", lambda v: v[:2], "fractions = 2: must be 3, one for each relaxation time"),
        ("times", lambda v: [-v[0], *v[1:]], r"relaxation_times\[1\] = -0.1: must be a positive"),
        ("onsets", lambda v: v[:3], r"onsets = \(3, 12\): must be four rows"),
        ("onsets", lambda v: v[0], r"onsets = \(12,\): must be four rows"),
        ("onsets", lambda v: [*v[:3], v[3][:5]], "must be a list of finite numbers, or of such lists of one length"),
        ("onsets", lambda v: [v[0][::-1], *v[1:]], "onsets: overlap = .*: must be positive and rise"),
        ("onsets", lambda v: [v[0], *(np.array(v[1:]) * 1.01).tolist()], "onsets: weights = .*: do not belong to the elastic force"),
        ("radius", lambda v: 2.0 * v, "onsets: weights = .*: do not belong to the elastic force"),
    ],
)
def test_damaged_files_are_refused_with_one_reason(tmp_path, name, change, said):
    file = save(FittedLaw(maxwell_zener_ting(WIDE, 1.0), 0.1), tmp_path / "law.json")
    content = json.loads(file.read_text())
    content["parameters"][name] = change(content["parameters"][name])
    file.write_text(json.dumps(content))
    with pytest.raises(InputError, match=said) as raised:
        load(file)
    assert len(raised.value.problems) == 1


@pytest.mark.parametrize(("largest", "springs"), [(0.0, 12), (1.0, 12), (0.3, 0), (math.nan, 12)])
def test_springs_that_cannot_be_are_refused(largest, springs):
    with pytest.raises(InputError, match="need a largest overlap"):
        maxwell_zener_ting(STRONG, 1.0, None, largest, springs)
