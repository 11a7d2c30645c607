"""Programmes in time: what the makers make, how knots become steps, and what is no programme."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem.programme import (
    FEWEST,
    MANY,
    START,
    Knot,
    Programme,
    creep,
    problems_with_programme,
    ramp_hold_release,
    rows,
    sine,
    staircase,
)


def test_ramp_hold_release_leaves_out_what_is_not_asked_for():
    assert ramp_hold_release(1e-3, 2.0) == (START, Knot(2.0, 1e-3))
    assert ramp_hold_release(1e-3, 2.0, 3.0) == (START, Knot(2.0, 1e-3), Knot(5.0, 1e-3))
    assert ramp_hold_release(1e-3, 2.0, 0.0, 4.0, 5e-4) == (START, Knot(2.0, 1e-3), Knot(6.0, 5e-4))


def test_creep_takes_the_force_off_as_fast_as_it_came():
    knots = creep(3.0, 0.5, 10.0, 7.0)
    assert [knot.time for knot in knots] == [0.0, 0.5, 10.5, 11.0, 18.0]
    assert [knot.force for knot in knots[1:]] == [3.0, 3.0, 0.0, 0.0]
    assert all(knot.overlap is None for knot in knots[1:])


def test_a_staircase_rests_on_each_step():
    knots = staircase([0.01, 0.02, 0.015], 1.0, 5.0)
    assert [knot.time for knot in knots] == [0.0, 1.0, 6.0, 7.0, 12.0, 13.0, 18.0]
    assert [knot.overlap for knot in knots] == [0.0, 0.01, 0.01, 0.02, 0.02, 0.015, 0.015]


def test_a_sine_has_its_mean_amplitude_and_period():
    mean, amplitude, period, cycles = 0.02, 0.005, 2.0, 3.0
    wave = sine(mean, amplitude, period, cycles)[2:]
    time, overlap = np.array([(knot.time, knot.overlap) for knot in wave]).T
    # it begins a quarter of a period late; the sum of a few round-offs
    np.testing.assert_allclose(overlap, mean + amplitude * np.sin(2.0 * np.pi * (time - 0.5) / period), rtol=0, atol=1e-15)
    assert time[-1] == pytest.approx(0.5 + cycles * period, rel=1e-15)
    assert overlap.max() == pytest.approx(mean + amplitude, rel=1e-15)


programmes = st.lists(
    st.tuples(
        st.floats(0.0, 1e3),  # how long the segment takes; 0 is a jump
        st.booleans(),  # by force
        st.sampled_from([0.0, 1e-4, 2e-4, 5e-4]),
    ),
    min_size=1,
    max_size=20,
)


@given(programmes, st.floats(1e-6, 1e6), st.integers(1, 64))
def test_steps_lead_through_the_knots_in_order(segments: list[tuple[float, bool, float]], shortest: float, steps: int):
    knots: list[Knot] = [START]
    for span, by_force, value in segments:
        knots.append(Knot(knots[-1].time + span, None, value) if by_force else Knot(knots[-1].time + span, value))
    plan = rows(tuple(knots), shortest, steps)
    time = [0.0, *(row.time for row in plan)]
    # the end of a segment is begun plus the whole of its span: one round-off each
    assert all(later >= earlier - 1e-15 * later for earlier, later in zip(time[:-1], time[1:], strict=True))
    assert [row.segment for row in plan] == sorted(row.segment for row in plan)
    for number, (before, knot) in enumerate(zip(knots[:-1], knots[1:], strict=True), 1):
        own = [row for row in plan if row.segment == number]
        assert own[-1].share == 1.0
        assert own[-1].time == pytest.approx(knot.time, rel=1e-15)
        shares = [row.share for row in own]
        assert shares == sorted(shares)
        assert shares[0] > 0.0
        for row in own:
            assert row.target == (knot.force if row.by_force else knot.overlap)
            other = before.force if row.by_force else before.overlap
            assert row.start == (0.0 if before == START else other)


def test_steps_of_a_hold_grow_with_the_time_since_it_began():
    plan = [row for row in rows(ramp_hold_release(1e-3, 1.0, 1e6), 2.0, 20) if row.segment == 2]
    since = np.array([row.time - 1.0 for row in plan])
    # the first is a hundredth of the relaxation time; 1 s has been taken off
    assert since[0] == pytest.approx(0.02, rel=1e-12)
    np.testing.assert_allclose(since[2:] / since[1:-1], since[-1] / since[-2], rtol=1e-9)


def test_a_programme_of_many_segments_takes_fewer_steps_for_each():
    few = rows(ramp_hold_release(1e-3, 1.0), 1.0, 20)
    many = sine(1e-3, 5e-4, 1.0, 40.0)
    assert len(few) == 20
    assert len(rows(many, 1.0, 20)) == FEWEST * (len(many) - 1)
    edge = staircase([1e-3 * k for k in range(1, MANY // 2 + 1)], 1.0, 1.0)
    assert len(rows(edge, 1.0, 20)) == 20 * MANY


def knots_of(*pairs: tuple[float, float]) -> Programme:
    return tuple(Knot(time, overlap) for time, overlap in pairs)


@pytest.mark.parametrize(
    ("programme", "name", "bound"),
    [
        ((), "programme", "needs a knot"),
        ((START,), "programme", "needs a knot"),
        (knots_of((1.0, 0.0), (2.0, 0.1)), "programme[1]", "time 0 and overlap 0"),
        (knots_of((0.0, 0.1), (2.0, 0.1)), "programme[1]", "time 0 and overlap 0"),
        ((START, Knot(1.0, 0.1, 5.0)), "programme[2]", "exactly one of overlap and force"),
        ((START, Knot(1.0)), "programme[2]", "exactly one of overlap and force"),
        ((START, Knot(1.0, math.nan)), "programme[2]", "finite"),
        ((START, Knot(math.inf, 0.1)), "programme[2]", "finite"),
        ((START, Knot(1.0, 1.0)), "programme[2]", "smaller than the radius"),
        ((START, Knot(1.0, 0.1), Knot(2.0, -1.5)), "programme[3]", "smaller than the radius"),
        ((START, Knot(1.0, force=-1.0), Knot(2.0, 0.1)), "programme[2]", "the flat does not pull"),
        (knots_of((0.0, 0.0), (2.0, 0.1), (1.0, 0.2)), "programme[3]: time", "must rise"),
        (knots_of((0.0, 0.0), (2.0, 0.1), (2.0, 0.1)), "programme[3]: time", "must rise"),
        (knots_of((0.0, 0.0), (1.0, -0.1), (2.0, 0.0)), "programme", "never touches"),
        ((START, Knot(1.0, force=0.0)), "programme", "never touches"),
    ],
)
def test_what_is_no_programme(programme: Programme, name: str, bound: str):
    problems = list(problems_with_programme(programme, 1.0))
    assert [problem.name for problem in problems] == [name]
    assert bound in problems[0].bound
    assert problems[0].remedy


def test_two_overlaps_at_one_time_are_a_jump():
    assert not list(problems_with_programme(knots_of((0.0, 0.0), (0.0, 0.1), (2.0, 0.1), (2.0, 0.0)), 1.0))
