"""What holds for every law, over the registry."""

from __future__ import annotations

from itertools import compress
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from contactlaws import dispatch, pair
from contactlaws.checks import Finding, check
from contactlaws.flaws import FLAWS
from contactlaws.path import scan
from contactlaws.travel import INTEGRATION, travel
from tests.contactlaws.samples import CASES, NAMES, SAMPLES

slow_interpreted = pytest.mark.compiled_only(reason="millions of evaluations; one of the checks compares with the interpreted law")
each_law = pytest.mark.parametrize(("law", "deepest"), CASES, ids=NAMES)
IN_TIME = [dispatch.law_of(law).in_time for law, _ in CASES]
TIMELESS = [not in_time for in_time in IN_TIME]
each_law_in_time = pytest.mark.parametrize(("law", "deepest"), list(compress(CASES, IN_TIME)), ids=list(compress(NAMES, IN_TIME)))
each_timeless_law = pytest.mark.parametrize(("law", "deepest"), list(compress(CASES, TIMELESS)), ids=list(compress(NAMES, TIMELESS)))


def test_every_law_of_the_project_is_sampled():
    own = {name for name, law in dispatch.laws().items() if law.record.__module__.startswith("contactlaws.")}
    assert own == set(SAMPLES)
    assert all(dispatch.laws()[name].source for name in own)


@slow_interpreted
@each_law
def test_passes_all_checks(law: Any, deepest: float):
    """A published law may fail those that its own mathematics break; `FLAWS` says which and why."""
    flaws = FLAWS.get(dispatch.law_of(law).name, {})
    failed: list[Finding] = [finding for finding in check(law, deepest, paths=6) if not finding.passed]
    assert [finding for finding in failed if finding.name not in flaws] == []


@slow_interpreted
@each_law_in_time
@settings(max_examples=25, deadline=None)
@given(
    # an overlap far smaller than a row of the path cannot be followed by it: the row that leaves the contact would be counted whole
    turns=st.lists(
        st.tuples(st.floats(-0.05, 1.0).map(lambda turn: turn if abs(turn) > 1e-3 else 0.0), st.floats(-3.0, 3.0)), min_size=1, max_size=6
    ),
    last=st.floats(-3.0, 3.0),
)
@example(turns=[(1.0, 1.0), (0.0625, 2.0), (1.0, -1.0)], last=-3.0)  # springs that grow on after a rest, and let go at once
def test_gives_back_no_more_than_was_put_in_at_any_speed(law: Any, deepest: float, turns: list[tuple[float, float]], last: float):
    """As the test above, with the logarithm of the time from turn to turn; work is known to `INTEGRATION` of all that was done."""
    corners = np.array([0.0, *(overlap for overlap, _ in turns), 0.0]) * deepest
    found = travel(law, corners, 10.0 ** np.array([*(speed for _, speed in turns), last]))
    done = max(float(np.sum(abs(np.diff(found.work)))), 1e-300)
    flaws = FLAWS.get(dispatch.law_of(law).name, {})
    assert found.work.min() >= -10.0 * INTEGRATION * done
    if "no tension" not in flaws:
        assert found.scan.force.min() >= 0.0
    if "dissipation never falls" not in flaws:
        assert np.all(np.diff(found.scan.dissipated_energy) >= -10.0 * INTEGRATION * done)


@slow_interpreted
@each_timeless_law
@settings(max_examples=25, deadline=None)
@given(turns=st.lists(st.floats(-0.05, 1.0), min_size=1, max_size=6))
def test_gives_back_no_more_than_was_put_in(law: Any, deepest: float, turns: list[float]):
    corners = np.concatenate(([0.0], np.array(turns), [0.0])) * deepest
    path = np.concatenate([np.linspace(a, b, 400) for a, b in zip(corners, corners[1:], strict=False)])
    found = scan(law, path)
    work = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(path) * (found.force[1:] + found.force[:-1]))))
    largest = dispatch.stiffness_bound(law, deepest)
    # a trapezoid misses at most h^2/8 times the change of slope in a row; slopes stay below the bound, up and down once a leg
    missed = len(turns) * 4.0 * largest * (deepest / 399.0) ** 2
    flaws = FLAWS.get(dispatch.law_of(law).name, {})
    if "loading is continuous" in flaws:  # a trapezoid over a jump misses at most the jump, 5 % of the force, times a row
        missed += len(turns) * 0.05 * largest * deepest * (deepest / 399.0)
    assert work.min() >= -missed
    assert found.force.min() >= 0.0
    if "dissipation never falls" not in flaws:
        # what is dissipated is the work less what is stored: its round-off goes with the larger of them
        put_in = abs(found.dissipated_energy).max() + abs(found.stored_energy).max()
        assert np.all(np.diff(found.dissipated_energy) >= -1e-12 * put_in)


@each_law
def test_scales_with_the_size_of_the_pair(law: Any, deepest: float):
    """No material length: lengths by s, forces by s^2, energies by s^3."""
    s = 3.0
    one, state_one = pair.pair_force(law, 1.0, deepest, 0.0, 0.0, dispatch.initial_state(law))
    large, state_large = pair.pair_force(law, s, s * deepest, 0.0, 0.0, dispatch.initial_state(law))
    assert large == pytest.approx(s**2 * one, rel=1e-14)
    assert pair.pair_energy(law, s, s * deepest, state_large) == pytest.approx(
        tuple(s**3 * e for e in pair.pair_energy(law, 1.0, deepest, state_one))
    )
    assert pair.pair_stiffness_bound(law, s, s * deepest) == pytest.approx(s * pair.pair_stiffness_bound(law, 1.0, deepest), rel=1e-14)


@each_law
def test_a_contact_that_opened_is_new_but_its_dissipation_stays(law: Any, deepest: float):
    """A second contact is the first one over again; what a contact had not given back when it opened is lost."""
    path = np.array([0.0, deepest, 0.0, deepest])
    found = scan(law, path)
    lost = sum(dispatch.energy(law, 0.0, dispatch.load_state(law, found.states, 1)))
    assert found.force[3] == found.force[1]
    assert found.dissipated_energy[2] == pytest.approx(lost, rel=1e-12)
    assert found.dissipated_energy[3] == pytest.approx(lost + found.dissipated_energy[1], rel=1e-12)
