"""Contact states along loading and unloading, and what happens when no equilibrium is found."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, pairwise

import numpy as np
import pytest
from skfem import MeshQuad

from contactlaws.curve import Curve
from contactlaws.errors import InputError
from contactlaws.material import Material
from fem.assembly import Discretisation, discretise
from fem.branch import contact_edge, from_states
from fem.march import Steps, interval, landings, unload
from fem.mesh import FloatArray, spheroid
from fem.newton import RESIDUAL, ByOverlap, Equilibrium, NoEquilibrium, State
from fem.press import moduli_of, press
from fem.walk import walk

pytestmark = pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")

PLASTIC = moduli_of(Material(50.0, 0.3, 1.0))
ELASTIC = moduli_of(Material(50.0, 0.3))


@pytest.fixture(scope="module")
def body() -> Discretisation:
    return discretise(spheroid(4, 0.05))


def loaded(solver: Equilibrium, landed: int) -> Iterator[State]:
    """All states up to the landing number `landed`."""
    for _, path in islice(landings(solver, Steps()), landed):
        yield from path


def check_contact(solver: Equilibrium, state: State, largest_force: float) -> None:
    """Nothing through the flat, nothing pulled, supports held, and as much force above as below."""
    section = solver.body.section
    gaps = solver.gaps(state.displacement)
    # what the solver tolerates of penetration, over the half height
    assert gaps.min() > -2e-10
    np.testing.assert_allclose(gaps[state.active], 0.0, atol=1e-14)
    # the flat pushes downwards; the solver leaves its residual of the largest force on each node
    assert state.reaction.max() <= RESIDUAL * largest_force
    np.testing.assert_array_equal(state.displacement[section.axis, 0], 0.0)
    np.testing.assert_allclose(state.displacement[section.midplane, 1], state.overlap, rtol=1e-12, atol=1e-15)
    # the same, summed over the nodes
    assert -state.reaction.sum() == pytest.approx(state.force, rel=0, abs=np.sqrt(gaps.size * 10.0) * RESIDUAL * largest_force + 1e-15)


@pytest.mark.parametrize("moduli", [ELASTIC, PLASTIC], ids=["elastic", "plastic"])
def test_contact_conditions_hold_on_the_whole_path(body: Discretisation, moduli: tuple[float, float, float]):
    solver = Equilibrium(body, moduli)
    states = list(loaded(solver, 12))
    assert len(states) > 24
    for before, after in zip(states[:-1], states[1:], strict=True):
        check_contact(solver, after, after.force)
        assert after.overlap > before.overlap
        assert after.dissipated >= before.dissipated
    back = unload(solver, states[-1], Steps())
    for state in back[1:-1]:
        check_contact(solver, state, states[-1].force)
    free = back[-1]
    assert free.force == 0.0
    assert not free.active.any()
    assert solver.gaps(free.displacement).min() == pytest.approx(0.0, abs=1e-14)


def test_a_landing_carries_no_force(body: Discretisation):
    solver = Equilibrium(body, PLASTIC)
    for place, path in islice(landings(solver, Steps()), 12):
        landing = path[-1]
        assert landing.active[place]
        assert landing.reaction[place] == 0.0
        assert solver.gaps(landing.displacement)[place] == pytest.approx(0.0, abs=1e-14)


def test_elastic_unloading_ends_where_loading_began(body: Discretisation):
    solver = Equilibrium(body, ELASTIC)
    *_, last = loaded(solver, 12)
    free = unload(solver, last, Steps())[-1]
    assert free.overlap == pytest.approx(0.0, abs=RESIDUAL * last.overlap)
    assert free.stored == pytest.approx(0.0, abs=1e-12 * last.stored)
    assert free.dissipated == 0.0


def test_work_is_stored_or_dissipated_between_two_states(body: Discretisation):
    """A small step at fixed contact: the midpoint force's work, to third order of the step, is what the energies gain."""
    solver = Equilibrium(body, PLASTIC)
    *_, start = loaded(solver, 12)
    half_step = 1e-3 * start.overlap
    first = solver.step(start, ByOverlap(start.overlap + half_step), start.force)
    second = solver.step(first, ByOverlap(start.overlap + 2.0 * half_step), start.force)
    work = half_step / 3.0 * (start.force + 4.0 * first.force + second.force)
    gained = second.stored + second.dissipated - start.stored - start.dissipated
    # backward Euler dissipates at the end of the step: first order in it
    assert gained == pytest.approx(work, rel=2e-3)


def failing_beyond(monkeypatch: pytest.MonkeyPatch, limit: float) -> None:
    """Make every step beyond an overlap fail."""
    step = Equilibrium.step

    def limited(self: Equilibrium, start: State, *arguments: object, **named: object) -> State:
        state: State = step(self, start, *arguments, **named)  # type: ignore[arg-type]
        if state.overlap > limit:
            raise NoEquilibrium("made to fail")
        return state

    monkeypatch.setattr(Equilibrium, "step", limited)


def test_failure_keeps_the_curve_up_to_there(monkeypatch: pytest.MonkeyPatch):
    failing_beyond(monkeypatch, 0.03)
    curve = press(Material(50.0, 0.3, 1.0), unload_from=(0.01, 0.08))
    assert curve.stopped is not None
    assert "made to fail" in curve.stopped
    assert 0.02 < curve.overlap.max() <= 0.03
    assert list(curve.unloadings) == [1]
    assert curve.force[curve.rows(1)][-1] == 0.0


def test_failure_before_anything_is_resolved_says_so(monkeypatch: pytest.MonkeyPatch):
    failing_beyond(monkeypatch, 1e-5)
    with pytest.raises(InputError, match="made to fail"):
        press(Material(50.0, 0.3, 1.0), max_overlap=0.1)


def test_newton_that_never_converges_ends(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("fem.newton.ITERATIONS", 1)
    with pytest.raises(InputError, match="no convergence in 1 iterations"):
        press(Material(50.0, 0.3, 1.0), max_overlap=0.1)


def test_failed_unloading_keeps_the_loading_up_to_it(monkeypatch: pytest.MonkeyPatch):
    def gives_up(*_: object, **__: object) -> State:
        raise NoEquilibrium("no free shape")

    monkeypatch.setattr(Equilibrium, "touching", gives_up)
    curve: Curve = press(Material(50.0, 0.3, 1.0), unload_from=(0.05,))
    assert curve.stopped is not None
    assert "no free shape" in curve.stopped
    assert 0.04 < curve.overlap.max() <= 0.05


def test_a_body_that_the_march_cannot_land_in_order_ends():
    """A dimple at the pole: its nodes don't land from the pole outwards, which the march relies on. It must say so, not go on for ever."""
    round_one = spheroid(4, 0.1)
    r, z = round_one.mesh.p
    dimpled = MeshQuad(np.stack([r, z - 0.02 * z * np.exp(-((r / 0.1) ** 2))]), round_one.mesh.t)
    run = walk(discretise(round_one._replace(mesh=dimpled)), PLASTIC, 0.1)
    assert run.stopped is not None


def test_a_node_that_rests_before_its_turn_ends_the_interval(body: Discretisation):
    """The march is told to land a node that rests already: each step goes beyond the landing, however small."""
    solver = Equilibrium(body, ELASTIC)
    *_, state = loaded(solver, 8)
    resting = int(np.count_nonzero(state.active)) - 3
    with pytest.raises(NoEquilibrium):
        interval(solver, state, resting, 0.1 * state.overlap, state.force, Steps())


def surface_radius(body: Discretisation, state: State) -> FloatArray:
    """Deformed."""
    return np.asarray((body.section.mesh.p[0] + state.displacement[:, 0])[body.section.surface])


def test_the_edge_of_an_elastic_contact_goes_with_the_root_of_the_overlap_between_landings():
    """As in Hertz's contact, from node to node; what is read from pressures is within a tenth of an element of it."""
    body = discretise(spheroid(8, 0.05))
    before: State | None = None
    read = 0
    for place, path in islice(landings(Equilibrium(body, ELASTIC), Steps(first=0.2, growth=1.0)), 14):
        if before is not None and place > 3:
            ends = np.sqrt([before.overlap, path[-1].overlap])
            for state in path[:-1]:
                radius, (last, edge) = surface_radius(body, state), contact_edge(body, state)
                assert last == place - 1
                share = (np.sqrt(state.overlap) - ends[0]) / (ends[1] - ends[0])
                assert (edge - radius[last]) / (radius[place] - radius[last]) == pytest.approx(share, abs=0.1)
                read += 1
        before = path[-1]
    assert read > 20


def test_the_edge_passes_the_nodes_of_a_plastic_contact_as_they_are_let_go(body: Discretisation):
    """Read just before and after, it is at the node within a third of an element; usual steps read what short ones do."""
    solver = Equilibrium(body, PLASTIC)
    start = list(loaded(solver, 12))[-1]
    short = unload(solver, start, Steps(force_drop=0.01, tail=0.04))
    passed = 0
    for before, after in pairwise(short[:-1]):
        (node, edge), (inner, later) = contact_edge(body, before), contact_edge(body, after)
        if inner == node - 1 and after.force > 0.1 * start.force:  # the steps of the rest are no shorter than elements
            radius = surface_radius(body, after)
            assert np.array([edge, later]) == pytest.approx(radius[node], abs=0.33 * (radius[node] - radius[inner]))
            passed += 1
    assert passed >= 3
    usual, fine = (from_states(body, states).retreat for states in (unload(solver, start, Steps()), short))
    assert abs(usual - fine).mean() < 0.01
