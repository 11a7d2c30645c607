"""The row of relaxing springs: Hertz at both ends of time, Lee & Radok while growing, Ting on retreat, creep, and energy."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from contactlaws.errors import InputError
from contactlaws.foundation import follow, springs_of
from contactlaws.prony import Relaxation
from tests.contactlaws.histories import (
    MATERIALS,
    PROGRAMMES,
    PVDF,
    STRONG,
    UNIT,
    WIDE,
    between,
    elastic,
    fine_springs,
    lee_radok,
    programme,
    psi,
    separation_time,
    ting,
    work,
)

#: for tests with some hundred thousand steps of a spring
LONG = pytest.mark.compiled_only("takes minutes")
BY_NAME = pytest.mark.parametrize("modulus", MATERIALS.values(), ids=MATERIALS)


def on_springs(springs, name):
    """A programme on the onsets of springs, where their elastic force is exact."""
    time, overlap = programme(name, 40)
    return time, springs.onset[np.searchsorted(springs.onset, overlap).clip(0, springs.onset.size - 1)]


@pytest.mark.parametrize("name", PROGRAMMES)
def test_a_body_that_never_relaxes_is_elastic_on_any_path(name):
    springs = fine_springs(200)
    time, overlap = on_springs(springs, name)
    found = follow(springs, Relaxation(UNIT), time, overlap)
    np.testing.assert_allclose(found.force, elastic(overlap), atol=1e-13)  # sums of 200 springs
    assert not found.dissipated.any()


@LONG
@BY_NAME
@pytest.mark.parametrize("name", [name for name in PROGRAMMES if name != "steps"])
def test_at_once_and_at_last_the_body_is_elastic(modulus, name):
    """With every relaxation time 1e9 times longer and shorter than the programme; what is left of the history is 1e-9 of the force."""
    springs = fine_springs(200)
    time, overlap = on_springs(springs, name)
    np.testing.assert_allclose(follow(springs, modulus, 1e-9 * time, overlap).force, elastic(overlap), atol=1e-7)
    if "recovery" not in name:  # touched and left at the same instant otherwise
        left = modulus.long_term / modulus.instantaneous
        np.testing.assert_allclose(follow(springs, modulus, 1e10 * time, overlap).force, left * elastic(overlap), atol=1e-7)


@LONG
@BY_NAME
def test_growing_contact_is_lee_and_radoks(modulus):
    """A ramp of 1 s, then the overlap stays. Two second-order errors: 800 springs 1e-6, 400 steps 5e-6 at most (a ninth of tau_1 each)."""
    time, overlap = between((0.0, 1.0, 5.0), (0.0, 1.0, 1.0), 400)
    found = follow(fine_springs(), modulus, time, overlap)
    rows = [40, 150, 400, 420, 600, 800]
    expected = [lee_radok(modulus, float(time[i]), min(float(time[i]), 1.0)) for i in rows]
    np.testing.assert_allclose(found.force[rows], expected, atol=6e-6)


@LONG
@BY_NAME
def test_first_retreat_is_tings(modulus):
    """Force and edge; the same two errors. The edge is where a straight line between two springs meets zero, of which one is a spring."""
    time, overlap = programme("ramp and release", 400)
    found = follow(fine_springs(), modulus, time, overlap)
    rows = [100, 300, 400, 401, 410, 450, 500, 560, 600, 640, 680]
    force, edge = np.array([ting(modulus, float(time[i])) for i in rows]).T
    np.testing.assert_allclose(found.force[rows], force, atol=6e-6)
    held = force > 0.0
    np.testing.assert_allclose(found.edge[rows][held], edge[held], atol=3e-5)
    end = separation_time(modulus)
    assert time[np.flatnonzero(found.force > 0.0)[-1]] == pytest.approx(end, abs=time[1])  # between two rows


@LONG
def test_overstress_after_a_ramp_of_pvdf():
    """What is left of the relaxing part at the end of ramps of .01 to 100 s; after one of 1 s, .65 % above the limit at 7.5 s."""
    springs, end = fine_springs(400), PVDF.long_term / UNIT
    for ramp, left in ((0.01, 0.99778), (0.1, 0.9781), (1.0, 0.8091), (10.0, 0.2424), (100.0, 0.02675)):
        time, overlap = between((0.0, ramp), (0.0, 1.0), 2000)
        force = follow(springs, PVDF, time, overlap).force[-1]
        assert (force - end) / (1.0 - end) == pytest.approx(left, rel=3e-4)  # of the last digit given, and of the steps at 100 s
    assert lee_radok(PVDF, 7.5, 1.0) / end - 1.0 == pytest.approx(0.0065, abs=5e-5)


@LONG
@BY_NAME
def test_creep_under_a_constant_force_follows_the_compliance(modulus):
    """d^1.5 = F J(t)/J(0) while the contact grows (Lee & Radok 1960): the creep found by inverting the series, not by the springs."""
    springs = fine_springs(2000, 12.0)  # the softest creeps to 10^(2/3)
    time = np.concatenate(([0.0], np.geomspace(1e-5, 200.0, 1500)))
    found = follow(springs, modulus, time, np.ones(time.size), True)
    creep = modulus.creep().at(time) / modulus.creep().instantaneous
    np.testing.assert_allclose(found.overlap**1.5, creep, rtol=6e-5)  # steps of 1.1 % of the time: half its square
    np.testing.assert_allclose(found.force, 1.0, rtol=1e-12)  # of Newton's method, which stops at 1e-14


@LONG
@BY_NAME
@pytest.mark.parametrize("name", ["ramp and release", "cycles", "growing cycles"])
def test_control_by_force_is_the_inverse_of_control_by_overlap(modulus, name):
    springs = fine_springs(300)
    time, overlap = programme(name, 50)
    first = follow(springs, modulus, time, overlap)
    pressed = np.flatnonzero(first.force <= 0.0)[1:2].tolist() or [time.size]
    rows = slice(1, pressed[0])  # while there is a force
    by_force = np.arange(time.size) > 0
    again = follow(springs, modulus, time[: pressed[0]], first.force[: pressed[0]], by_force[: pressed[0]])
    np.testing.assert_allclose(again.overlap[rows], overlap[rows], atol=1e-11)  # 1e-14 of the force over the least stiffness in there
    np.testing.assert_allclose(again.stored[rows], first.stored[rows], atol=1e-11)


def test_no_force_is_where_the_body_ends():
    """After a hold, let go: the overlap at which the springs just touch is the body's dent, which recovers."""
    time = np.concatenate(([0.0, 1e-9], np.linspace(1.0, 60.0, 600)))
    control = np.where(time < 20.0, 1.0, 0.0)
    found = follow(fine_springs(300), PVDF, time, control, time >= 20.0)
    free = time > 20.0
    assert (found.force[free] <= 1e-15).all()
    assert (np.diff(found.overlap[free]) < 0.0).all()
    assert found.overlap[free][0] > 1e-2
    assert found.overlap[-1] == pytest.approx(0.0, abs=1e-4)  # of the largest dent, after 17 retardation times


@LONG
@pytest.mark.parametrize("name", ["ramp and release", "cycles", "re-contact before recovery"])
@BY_NAME
def test_steps_are_of_second_order(modulus, name):
    """Half the step, a quarter of the error: on retreat and re-contact too."""
    springs, forces = fine_springs(200), []
    for rows in (50, 100, 800):
        time, overlap = programme(name, rows)
        forces.append(follow(springs, modulus, time, overlap).force[:: rows // 50])
    coarse, fine = (abs(force - forces[2]).max() for force in forces[:2])
    assert coarse / fine == pytest.approx(4.0, abs=0.6)  # springs are met in the middle of a step: not quite smooth


@st.composite
def random_histories(draw):
    """Up to eight turns, over eight decades of speed, some beyond separation."""
    turns = draw(st.integers(1, 8))
    lasts = [10.0 ** draw(st.floats(-4.0, 4.0)) for _ in range(turns)]
    depths = [draw(st.floats(-0.3, 1.0) | st.floats(-3.0, 0.0).map(lambda x: 10.0**x)) for _ in range(turns)]
    terms = draw(st.integers(1, 3))
    places = draw(st.lists(st.integers(-30, 30), min_size=terms, max_size=terms, unique=True))
    total, shares = draw(st.floats(0.01, 0.999)), [draw(st.floats(0.1, 1.0)) for _ in range(terms)]
    fractions = tuple(total * share / sum(shares) for share in shares)
    modulus = Relaxation(UNIT, fractions, tuple(10.0 ** (place / 10.0) for place in sorted(places)))
    return modulus, np.concatenate(([0.0], np.cumsum(lasts))), np.array([0.0, *depths])


@LONG
@settings(max_examples=40)
@given(random_histories())
def test_work_is_stored_or_dissipated_and_nothing_pulls(history):
    """Work by trapezoids is what is stored and taken by dampers, both summed up over the springs, but for the steps' errors."""
    modulus, corners, depths = history
    springs = fine_springs(100)
    differences = []
    for rows in (40, 160):
        time, overlap = between(corners, depths, rows, graded=True)
        found = follow(springs, modulus, time, overlap)
        done = work(overlap, found.force)
        assert (found.force >= 0.0).all()
        assert (found.stored >= 0.0).all()
        assert (np.diff(found.dissipated) >= 0.0).all()
        differences.append(abs(done - found.stored - found.dissipated).max())
    # four times the rows, less than half the error, though a leg may last ten million relaxation times; or 1e-3 of a full press's work, .4
    assert differences[1] <= max(0.5 * differences[0], 4e-4)


@pytest.mark.parametrize("modulus", [PVDF, STRONG, WIDE], ids=MATERIALS)
def test_a_step_may_be_a_million_relaxation_times(modulus):
    """One step from rest and from a jump: the long-term force; the overlap of the step counts as straight (tau/dt of the fraction)."""
    springs = fine_springs(300)
    left = modulus.long_term / UNIT
    for first in (0.0, 0.5):
        found = follow(springs, modulus, [0.0, 1e7], [first, 1.0])
        assert found.force[1] == pytest.approx(left, rel=3e-5)


def test_history_before_is_forgotten_by_the_fading_memory_alone():
    """A body pressed deep, released, and pressed again after 40 of its relaxation times, is as new: e^-40."""
    springs = fine_springs(300)
    time, overlap = between((0.0, 1.0, 2.0, 100.0, 101.0), (0.0, 1.0, -0.1, -0.1, 1.0), 50)
    found = follow(springs, PVDF, time, overlap)
    new = follow(springs, PVDF, time[150:], overlap[150:])
    np.testing.assert_allclose(found.force[150:], new.force, atol=1e-13)


def test_springs_carry_the_elastic_force_they_are_made_from():
    springs = springs_of(elastic, 0.3, 50)
    assert springs.onset[0] == 0.0
    assert (springs.stiffness > 0.0).all()
    for d in (springs.onset[7], springs.onset[-1]):
        assert (springs.stiffness * np.maximum(d - springs.onset, 0.0)).sum() == pytest.approx(d**1.5, rel=1e-12)
    assert psi(PVDF, 1e9) == pytest.approx(1.0 - 0.2285)


@pytest.mark.parametrize(
    ("time", "control", "said"),
    [
        ([0.0, 2.0, 1.0], [0.0, 0.1, 0.2], "time = 1.0: must not decrease"),
        ([0.0, 1.0], [0.0, 0.1, 0.2], r"control = \(3,\): must be one row, as long as that of the times"),
        ([0.0, np.nan], [0.0, 0.1], "must be finite numbers"),
        ([0.0, 1.0], [0.0, np.inf], "must be finite numbers"),
        ([], [], "must be one row"),
    ],
)
def test_programmes_that_cannot_be_are_refused(time, control, said):
    with pytest.raises(InputError, match=said) as raised:
        follow(fine_springs(10), PVDF, time, control)
    assert len(raised.value.problems) == 1


def test_a_modulus_that_cannot_be_is_refused():
    with pytest.raises(InputError, match="below 1 in sum"):
        follow(fine_springs(10), Relaxation(UNIT, (0.6, 0.6), (1.0, 2.0)), [0.0, 1.0], [0.0, 0.1])
