"""The table of extreme bodies: every run ends with a result or a reason, whatever happens to its process."""

from __future__ import annotations

import numpy as np
import pytest

from cases.verification.extremes import CASES, Case, Outcome, Result, compute, in_process, lines

QUICK, LONG = Case(100.0, 0.3, (), 1.5), Case(100.0, 0.3, (0.1, 0.5), 0.6)


def test_a_process_that_takes_too_long_is_ended_and_said_to_be():
    """By the limit on its CPU seconds, or by the clock where the machine is busy; one second is less than the solver takes to start."""
    outcome, silence = in_process(LONG, 0.01, limit=1)
    assert outcome is None
    assert silence is not None
    assert "answer" in silence
    result = Result(LONG, outcome, silence, None)
    assert not result.sound
    assert "NO ANSWER" in next(lines(result))


def test_a_refusal_is_a_reason():
    outcome = compute(QUICK, 0.01)
    assert outcome.reached is None
    assert outcome.reason is not None
    assert "the body ends there" in outcome.reason
    assert Result(QUICK, outcome, None, None).sound


def test_difference_from_a_finer_mesh_is_that_of_the_forces():
    """Of two power laws, 1 % apart, on other rows."""
    x, y = np.geomspace(0.01, 1.0, 30), np.geomspace(0.02, 0.9, 50)
    coarse, fine = (Outcome(float(d[-1]), 0, None, 0.0, {}, d, f, 1.0) for d, f in ((x, 1.01 * x**1.5), (y, y**1.5)))
    found = Result(QUICK, coarse, None, fine)
    assert found.difference() == pytest.approx(0.01, rel=1e-6)  # cubics in logarithms are exact for power laws


def test_the_table_covers_the_range_promised():
    ratios = [case.ratio for case in CASES if case.ratio is not None]
    assert (min(ratios), max(ratios)) == (1.0, 1e5)
    assert max(case.nu for case in CASES) == 0.4999
    assert (min(case.largest for case in CASES), max(case.largest for case in CASES)) == (1e-5, 0.9)
    assert any(case.ratio is None for case in CASES)
