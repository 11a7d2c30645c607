"""Unloading by one factorisation: the same states as full Newton steps, and a contact that excludes pull and penetration."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contactlaws.material import Material
from fem.assembly import discretise
from fem.march import Steps, landings, unload
from fem.mesh import spheroid
from fem.newton import RESIDUAL, ByOverlap, Equilibrium, NoEquilibrium, State
from fem.press import moduli_of
from fem.release import Release, Secants, complementary


@given(st.integers(1, 8), st.integers(0, 10**6))
@settings(deadline=None)
def test_forces_and_gaps_exclude_each_other(size: int, seed: int):
    """Random compliances, symmetric and positive as an elastic body's are; the start, all resting, has nothing to do with the answer."""
    rng = np.random.default_rng(seed)
    root, gaps = rng.standard_normal((size, size)), rng.standard_normal(size)
    compliance = root @ root.T + 0.1 * np.eye(size)
    try:
        force = complementary(compliance, gaps, np.ones(size, dtype=bool))
    except NoEquilibrium:
        return  # to give up is allowed, a wrong answer is not
    left = gaps + compliance @ force
    # round-off of a system of condition some hundreds
    assert force.min() >= 0.0
    assert left.min() > -1e-9
    np.testing.assert_allclose(force * left, 0.0, atol=1e-9 * (1.0 + force.max()))


@given(st.integers(1, 4), st.integers(0, 10**6))
@settings(deadline=None)
def test_secants_are_exact_where_a_linear_body_has_been_seen(pairs: int, seed: int):
    """Forces in the span of those seen get the displacement of the true stiffness, whatever the factors say; so do unit forces in it."""
    rng = np.random.default_rng(seed)
    size = 6
    stiffness = np.eye(size) + 0.2 * rng.standard_normal((size, size))
    flexible = np.linalg.inv(np.eye(size) + 0.2 * rng.standard_normal((size, size)))  # what the factors take for its inverse
    moved = rng.standard_normal((pairs, size))
    secants = Secants(np.arange(size), size)
    for s in moved:
        secants.add(s, stiffness @ s, flexible @ stiffness @ s)
    wanted = rng.standard_normal(pairs) @ moved
    forces = stiffness @ wanted
    # the products of the forces are inverted to 1e-10 of their size; nearly parallel ones multiply that
    tolerance = 1e-9 * np.linalg.cond(stiffness @ moved.T) ** 2 * np.abs(moved).max() * size
    np.testing.assert_allclose(secants.corrected(forces, flexible @ forces), wanted, rtol=0, atol=tolerance)
    np.testing.assert_allclose(flexible @ forces + (forces @ secants.of_units()) @ secants.missed, wanted, rtol=0, atol=tolerance)


def deep(solver: Equilibrium, overlap: float) -> State:
    """The first landing beyond an overlap."""
    return next(path[-1] for _, path in landings(solver, Steps()) if path[-1].overlap > overlap)


@pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")
@pytest.mark.parametrize("ratio", [5.0, 50.0, 1000.0])
def test_same_states_as_full_newton_steps(ratio: float):
    solver = Equilibrium(discretise(spheroid(4, 0.1)), moduli_of(Material(ratio, 0.3, 1.0)))
    start = deep(solver, 0.1)
    states = unload(solver, start, Steps())
    for before, after in zip(states[:-2], states[1:-1], strict=True):
        full = solver.step(before, ByOverlap(after.overlap), start.force)
        # both leave the residual on each of some 500 components, of which the force is a sum
        assert after.force == pytest.approx(full.force, rel=0, abs=20.0 * RESIDUAL * start.force)
        np.testing.assert_array_equal(after.active, full.active)
        assert after.stored + after.dissipated == pytest.approx(full.stored + full.dissipated, rel=1e-5)
    free = solver.free_shape(states[-2])
    recovered = start.overlap - free.overlap
    assert start.overlap - states[-1].overlap == pytest.approx(recovered, rel=10.0 * RESIDUAL)


@pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")
def test_stiffness_is_the_slope_of_the_unloading():
    solver = Equilibrium(discretise(spheroid(4, 0.05)), moduli_of(Material(50.0, 0.3, 1.0)))
    start = next(path[-2] for _, path in landings(solver, Steps()) if path[-1].overlap > 0.02)
    step = 1e-4 * start.overlap
    back = solver.step(start, ByOverlap(start.overlap - step), start.force)
    # the force changes by some 1e-4 of itself, of which RESIDUAL is 1 %; the contact changes little
    assert Release(solver, start).stiffness(start) == pytest.approx((start.force - back.force) / step, rel=0.02)
