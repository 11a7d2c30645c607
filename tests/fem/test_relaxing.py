"""A relaxing body on one coarse mesh: what holds to round-off, or to what the solver leaves, whatever the mesh is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from contactlaws.foundation import follow
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from fem.assembly import Discretisation, discretise
from fem.march import Steps
from fem.mesh import FloatArray, spheroid
from fem.newton import PENETRATION, RESIDUAL, Equilibrium, State
from fem.press import core_size, moduli_of
from fem.press_in_time import springs_on_mesh
from fem.programme import START, Knot, Programme, creep, ramp_hold_release, rows
from fem.relaxing import held_share
from fem.walk import walk
from fem.walk_in_time import FORCE_TOLERANCE, TimeWalk, _Walker, walk_in_time

pytestmark = pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")

HALF = Relaxation(1.0, (0.5,), (1.0,))
BROAD = Relaxation(1.0, (0.3, 0.3, 0.3), (0.01, 1.0, 100.0))
NU = 0.3
#: constant Poisson's ratio, constant bulk modulus, three terms five decades apart
MATERIALS = {"nu": uniaxial(HALF, NU), "K": uniaxial(HALF, NU, constant_bulk=True), "three": uniaxial(BROAD, NU)}
DEPTH = 0.05
#: what two runs may differ by that solve the same equations: each state's residual is below this share of the largest force, and what was
#: left of it in earlier states is remembered; three of them is what is seen at most in the sum over a path
SOLVED = 10.0 * RESIDUAL


@cache
def coarse() -> Discretisation:
    return discretise(spheroid(4, 0.05))


@pytest.fixture
def body() -> Discretisation:
    return coarse()


def run(body: Discretisation, material: PronyViscoelastic, programme: Programme, steps: int = 10) -> TimeWalk:
    """Young's modulus is 1, so forces need no unit; holds begin with steps that do not depend on the material."""
    return walk_in_time(body, moduli_of(material.instantaneous), material, rows(programme, 1.0, steps))


@contextmanager
def watched() -> Iterator[list[State]]:
    """The states that a run goes through, as they come."""
    seen: list[State] = []
    step = _Walker.to

    def to(self: _Walker, *arguments: Any) -> None:
        step(self, *arguments)
        seen.append(self.state)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_Walker, "to", to)
        yield seen


def gaps_of(body: Discretisation, state: State) -> FloatArray:
    """Distance of every surface node from the flat."""
    return Equilibrium(body, (1.0, 1.0, np.inf)).gaps(state.displacement)


def lee_radok(found: TimeWalk, modulus: Relaxation) -> FloatArray:
    """The hereditary integral of the elastic forces, exact where these go straight between the rows."""
    terms, force = np.zeros(len(modulus.times)), np.zeros(found.time.size)
    g, tau = np.array(modulus.fractions), np.array(modulus.times)
    for i in range(1, found.time.size):
        decay, held = held_share(found.time[i] - found.time[i - 1], tau)
        terms = decay * terms + held * (found.elastic[i] - found.elastic[i - 1])
        force[i] = (1.0 - g.sum()) * found.elastic[i] + g @ terms
    return force


@given(st.floats(1e-300, 1e300), st.floats(1e-6, 1e6))
def test_what_a_step_leaves_of_a_term(step: float, time: float):
    left, held = (float(share[0]) for share in held_share(step, np.array([time])))
    assert 0.0 <= left <= held <= 1.0  # what came in the step is younger than what was there
    x = step / time
    # the mean of exp(-s) over the step, two ways: its series, and the integral
    expected = 1.0 - x / 2.0 + x * x / 6.0 if x < 1e-4 else (1.0 - left) / x
    assert held == pytest.approx(expected, rel=1e-11)  # 1 - exp(-x) at 1e-4 has lost four digits


def test_no_step_leaves_everything():
    left, held = held_share(0.0, np.array([1e-3, 1.0]))
    assert left.tolist() == held.tolist() == [1.0, 1.0]


@pytest.mark.parametrize("modulus", [HALF, BROAD], ids=["one term", "three terms"])
def test_lee_radok_while_the_contact_grows(body: Discretisation, modulus: Relaxation):
    found = run(body, uniaxial(modulus, NU), ramp_hold_release(DEPTH, 1.0, 2.0))
    assert found.stopped is None
    assert found.time[-1] == 3.0
    # the recurrence is the same arithmetic on every node; the residuals of the states cancel in the sum over the mid-plane
    np.testing.assert_allclose(found.force, lee_radok(found, modulus), rtol=0, atol=1e-10 * found.force.max())


@pytest.mark.parametrize("kind", MATERIALS)
def test_infinitely_fast_and_slow_presses_are_elastic(body: Discretisation, kind: str):
    material = MATERIALS[kind]
    for pace, other in ((1e-9, material.instantaneous), (1e9, material.long_term)):
        found = run(body, material, ramp_hold_release(DEPTH, pace), steps=8)
        elastic = run(body, PronyViscoelastic(*other[:2], (), ()), ramp_hold_release(DEPTH, 1.0), steps=8)
        # the elastic run's stress is over its own Young's modulus
        expected = elastic.force * (other.youngs_modulus if pace > 1.0 else 1.0)
        np.testing.assert_allclose(elastic.overlap, found.overlap, rtol=1e-15)
        # 8 steps of a ramp of 1e9 relaxation times leave 1e-8 of the modulus
        np.testing.assert_allclose(found.force, expected, rtol=0, atol=SOLVED * expected.max())


def test_a_jump_is_elastic_and_what_follows_relaxes_as_the_modulus(body: Discretisation):
    material = MATERIALS["three"]
    found = run(body, material, (START, Knot(0.0, DEPTH), Knot(1e4, DEPTH)), steps=20)
    jump = found.time == 0.0
    np.testing.assert_allclose(found.force[jump], found.elastic[jump], rtol=0, atol=1e-12 * found.force.max())
    # at constant overlap the shape stays, so the force is the elastic one times psi(t)
    since = found.time > 0.0
    np.testing.assert_allclose(found.force[since] / found.force[jump][-1], BROAD.at(found.time[since]), rtol=2e-5)  # residuals
    assert found.force[-1] == pytest.approx(0.1 * found.force.max(), rel=2e-5)


def test_a_step_far_longer_than_any_relaxation_time(body: Discretisation):
    found = run(body, MATERIALS["nu"], (START, Knot(1e-9, DEPTH), Knot(1e12, DEPTH)), steps=1)
    assert found.force[-1] == pytest.approx(0.5 * found.elastic[-1], rel=1e-11)  # 1e-12 of the modulus is left


def test_terms_of_no_size_change_nothing(body: Discretisation):
    programme = ramp_hold_release(DEPTH, 1.0, 1.0, 1.0)
    for kind in ("nu", "K"):
        material = MATERIALS[kind]
        bulk = None if material.bulk_fractions is None else (0.0, *material.bulk_fractions)
        more = material._replace(
            relaxation_times=(1e-3, *material.relaxation_times), shear_fractions=(0.0, *material.shear_fractions), bulk_fractions=bulk
        )
        one, other = run(body, material, programme), run(body, more, programme)
        np.testing.assert_allclose(one.force, other.force, rtol=0, atol=1e-12 * one.force.max())


def test_terms_of_one_time_are_one_term(body: Discretisation):
    programme = ramp_hold_release(DEPTH, 1.0, 1.0, 1.0)
    near = 1.0 + 1e-7
    one = run(body, uniaxial(HALF, NU), programme)
    two = run(body, uniaxial(Relaxation(1.0, (0.2, 0.3), (1.0, near)), NU), programme)
    # a relaxation time moved by 1e-7 moves a force by less; the solver leaves the same residuals on nearly the same path
    np.testing.assert_allclose(one.force, two.force, rtol=0, atol=1e-6 * one.force.max())


def test_a_bulk_modulus_that_relaxes_like_the_shear_modulus(body: Discretisation):
    programme = ramp_hold_release(DEPTH, 1.0, 1.0, 1.0)
    together = MATERIALS["three"]
    apart = together._replace(bulk_fractions=together.shear_fractions)
    one, other = run(body, together, programme), run(body, apart, programme)
    np.testing.assert_allclose(one.force, other.force, rtol=0, atol=1e-6 * one.force.max())
    np.testing.assert_allclose(one.edge, other.edge, rtol=1e-6, atol=0)


def test_times_and_relaxation_times_scale_together(body: Discretisation):
    material, programme = MATERIALS["K"], ramp_hold_release(DEPTH, 1.0, 1.0, 1.0)
    slow = material._replace(relaxation_times=tuple(1e3 * t for t in material.relaxation_times))
    later = tuple(knot._replace(time=1e3 * knot.time) for knot in programme)
    one = run(body, material, programme)
    other = walk_in_time(body, moduli_of(slow.instantaneous), slow, rows(later, 1e3, 10))
    np.testing.assert_allclose(other.time, 1e3 * one.time, rtol=1e-14)
    np.testing.assert_allclose(other.force, one.force, rtol=0, atol=1e-9 * one.force.max())  # round-off, along a path


#: overlaps over the depth
PATHS = {
    "release": ramp_hold_release(1.0, 1.0, 0.0, 1.0),
    "hold and release": ramp_hold_release(1.0, 1.0, 2.0, 1.0),
    "release, wait, press again": (*ramp_hold_release(1.0, 1.0, 2.0, 0.2), Knot(3.5, 1.1), Knot(4.0, 0.0)),
    "half way back and forth": (*ramp_hold_release(1.0, 1.0, 1.0, 0.2, 0.6), Knot(3.0, 0.9), Knot(4.0, 0.0)),
}


@pytest.mark.parametrize("depth", [1e-3, DEPTH])
@pytest.mark.parametrize("kind", PATHS)
def test_springs_where_the_contact_shrinks_opens_and_closes(kind: str, depth: float):
    """Ting's solution and what goes beyond it. They are exact on a half-space, so what a sphere does beyond them falls with its contact."""
    material = MATERIALS["nu"]
    programme = tuple(knot._replace(overlap=depth * knot.overlap) for knot in PATHS[kind])
    body = discretise(spheroid(4, core_size(depth, depth)))
    found = run(body, material, programme, steps=20)
    elastic = walk(body, moduli_of(material.instantaneous), 1.2 * depth, (), Steps())
    springs = follow(springs_on_mesh(body, material, elastic, found), material.reduced, found.time, found.overlap)
    assert found.stopped is None
    # of the order of the contact radius over the radius, on four divisions as on eight
    np.testing.assert_allclose(found.force, springs.force, rtol=0, atol=0.02 * np.sqrt(depth) * found.force.max())
    # while it grows for the first time they are the same but for the residuals
    growing = found.time <= 1.0
    np.testing.assert_allclose(found.force[growing], springs.force[growing], rtol=0, atol=SOLVED * found.force.max())


def test_the_body_can_be_left_and_met_again_and_again(body: Discretisation):
    """A sine that leaves the body ten times: a body that has forgotten its start does the same in each cycle."""
    knots = [START, *(Knot(0.5 + 0.5 * k, (0.02 if k % 2 else 1.0) * DEPTH) for k in range(20))]
    found = run(body, MATERIALS["K"], tuple(knots), steps=8)
    assert found.stopped is None
    left = np.flatnonzero((found.force[1:] == 0.0) & (found.force[:-1] > 0.0))
    assert left.size == 10
    # two rows of one cycle lie where those of the cycle before do, unless a step was cut
    time = found.time[found.time > 9.0]
    last, before = (np.interp(time - late, found.time, found.force) for late in (0.0, 1.0))
    # exp(-1/2) a cycle is left of the start's share, eight cycles ago
    np.testing.assert_allclose(last, before, rtol=0, atol=np.exp(-8.0 / 2.0) * found.force.max())
    assert last.max() > 0.5 * found.force.max()


@pytest.mark.parametrize("kind", ["nu", "K"])
def test_force_and_overlap_control_are_one_solution(body: Discretisation, kind: str):
    """Creep under a force, then the overlaps that it led to prescribed in the same steps: the force comes back."""
    material = MATERIALS[kind]
    crept = run(body, material, creep(2e-3, 0.5, 10.0))
    assert crept.stopped is None
    back = run(body, material, tuple(Knot(*row) for row in zip(crept.time.tolist(), crept.overlap.tolist(), strict=True)), steps=1)
    times = np.searchsorted(back.time, crept.time)  # a segment takes no fewer than three steps
    assert crept.overlap[-1] > 1.2 * crept.overlap[10]
    # within a step of the first run the overlap went straight here; what that changes is seen to fall with the square of the step
    tolerance = FORCE_TOLERANCE + SOLVED + 2e-3
    np.testing.assert_allclose(back.force[times], crept.force, rtol=0, atol=tolerance * crept.force.max())


def test_a_dent_goes_when_the_force_does(body: Discretisation):
    found = run(body, MATERIALS["nu"], creep(2e-3, 0.1, 5.0, 60.0), steps=20)
    off = int(np.flatnonzero((found.time > 5.0) & (found.control == 0.0))[0])
    assert (found.force[off:] == 0.0).all()
    assert found.overlap[off] / found.overlap.max() > 0.02
    assert (np.diff(found.overlap[off:]) < 0.0).all()
    # the retardation time is 2: exp(-30) is left of the dent, and a residual of that
    assert abs(found.overlap[-1]) < 1e-6 * found.overlap.max()


@settings(max_examples=15, phases=[Phase.generate])  # an example takes half a second: shrinking one takes minutes
@given(
    st.lists(
        st.one_of(
            # overlaps from a little off the undeformed body on, and forces
            st.builds(lambda span, overlap: Knot(span, overlap), st.floats(1e-3, 3.0), st.floats(-0.03, 0.08)),
            st.builds(lambda span, force: Knot(span, None, force), st.floats(1e-3, 3.0), st.floats(0.0, 4e-3)),
        ),
        min_size=1,
        max_size=5,
    ),
    st.sampled_from(["nu", "K"]),
)
def test_whatever_is_done_to_it(knots: list[Knot], kind: str):
    """Nothing goes through the flat, nothing is pulled, and no energy comes out of nothing."""
    times = np.cumsum([knot.time for knot in knots]).tolist()
    programme = (START, *(knot._replace(time=time) for knot, time in zip(knots, times, strict=True)))
    body = coarse()  # no argument, so that a failing example is not printed with all its nodes
    with watched() as seen:
        found = run(body, MATERIALS[kind], programme, steps=8)
    assert found.stopped is None
    largest = max(found.force.max(), 1e-9)
    for state in seen:
        assert gaps_of(body, state).min() >= -2.0 * max(PENETRATION * abs(state.overlap), 1e-14)
        assert state.reaction.max() <= 4.0 * SOLVED * largest  # over what is left at once of the modulus, half of it at least
    assert found.force.min() >= 0.0
    # it begins unstrained: what the flat has done on it is stored or dissipated; with the force at each step's end the sum errs upwards
    work = np.cumsum(found.force[1:] * np.diff(found.overlap))
    assert work.min() >= -SOLVED * largest * DEPTH
