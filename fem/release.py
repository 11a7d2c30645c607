"""Unloading by one factorisation: the body responds almost linearly, only the contact opens.

While the body is let go it is elastic almost everywhere, and what is not linear in it is small (strains of the order Y/E). So the elastic
tangent of the state it leaves from, factorised once with the contact free, serves many steps: each iteration asks for nodal forces only,
and what the iterations of a step show of the body beyond these factors corrects them.
Which nodes rest is found in the same breath: seen from the contact, the body is its compliance matrix, and resting forces (none pulls) and
gaps (none negative) that exclude each other are a small complementarity problem.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contactlaws.compiled import kernel
from fem.mesh import FloatArray, IntArray
from fem.newton import PENETRATION, RESIDUAL, BoolArray, Equilibrium, Guess, NoEquilibrium, State

ITERATIONS = 20
MEMORY = 5  # iterations that correct the factors
ALIKE = 1e-10  # square of the sine between two changes of force, below which they count as one
SLOW = 8  # a step of more iterations asks for a new factorisation
CONTRACTION = 0.7  # of the residual in each iteration, at least; else the tangent is too old
FREE_RESIDUAL = 0.001 * RESIDUAL  # off the flat: there the largest force is not that of the state, whose stresses are small


def complementary(compliance: FloatArray, gaps: FloatArray, resting: BoolArray) -> FloatArray:
    """Forces f >= 0 with gaps + compliance f >= 0, one of both zero at each node; `resting` is where to begin.

    Raises `NoEquilibrium` if the nodes that rest don't settle.
    """
    force = np.empty(gaps.size)
    if not _settle(compliance, gaps, resting.copy(), force):
        raise NoEquilibrium("the contact does not settle")
    return force


@kernel
def _settle(compliance, gaps, resting, force):  # type: ignore[no-untyped-def]
    """Find the nodes that rest, from `resting` on, and their forces; False if they do not settle. Compiled: small, but often."""
    largest = 1e-300
    for gap in gaps:
        largest = max(largest, abs(gap))
    slack = 1e-13 * largest
    for _ in range(3 * gaps.size + 10):
        nodes = np.flatnonzero(resting)
        matrix, right = np.empty((nodes.size, nodes.size)), np.empty(nodes.size)
        for i in range(nodes.size):
            right[i] = -gaps[nodes[i]]
            for j in range(nodes.size):
                matrix[i, j] = compliance[nodes[i], nodes[j]]
        force[:] = 0.0
        if nodes.size > 0:
            force[nodes] = np.linalg.solve(matrix, right)
        settled = True
        for i in range(gaps.size):
            wanted = force[i] > 0.0
            if not resting[i]:
                left = gaps[i]
                for j in nodes:
                    left += compliance[i, j] * force[j]
                wanted = left < -slack
            # forces and gaps are of the same guess: which nodes rest changes for all at once
            settled = settled and wanted == resting[i]
            resting[i] = wanted
        if settled:
            return True
    return False


class _Iterate(NamedTuple):
    """Where one iteration stood."""

    displacement: FloatArray  # (dofs,)
    free: FloatArray  # forces on components that nothing holds
    by_factors: FloatArray  # displacement that the factors take for these forces


class Secants:
    """What the last iterations have shown of the body beyond its factors: a correction of their inverse, in least squares (Anderson).

    Forces changed by `y` when the displacement changed by `s`, of which the factors say `h`: the inverse is given s - h for a force y.
    """

    def __init__(self, dofs: IntArray, size: int):
        self.dofs = dofs
        self._pairs = 0  # taken over so far; the last ones are kept, the newest in the place of the oldest
        self._forces, self._missed = np.empty((MEMORY, size)), np.empty((MEMORY, size))
        self._products = np.empty((MEMORY, MEMORY))
        self.inverse: FloatArray = np.zeros((0, 0))  # of the products of `forces`

    @property
    def forces(self) -> FloatArray:
        """(pairs, all dofs): unit vectors y."""
        return self._forces[: self._pairs]

    @property
    def missed(self) -> FloatArray:
        """(pairs, all dofs): s - h for them."""
        return self._missed[: self._pairs]

    def add(self, moved: FloatArray, forces: FloatArray, by_factors: FloatArray) -> None:
        """Take over one pair; the oldest is forgotten."""
        size = math.sqrt(float(forces @ forces))
        if not size > 0.0:
            return
        place, self._pairs = self._pairs % MEMORY, self._pairs + 1
        np.divide(forces, size, out=self._forces[place])
        np.divide(moved - by_factors, size, out=self._missed[place])
        known = self.forces.shape[0]
        self._products[place, :known] = self._products[:known, place] = self.forces @ self._forces[place]
        self._products[place, place] += ALIKE
        self.inverse = np.asarray(np.linalg.inv(self._products[:known, :known]))

    def corrected(self, forces: FloatArray, by_factors: FloatArray) -> FloatArray:
        """The displacement for `forces`, of which the factors alone say `by_factors`."""
        return by_factors + (self.inverse @ (self.forces @ forces)) @ self.missed

    def of_units(self) -> FloatArray:
        """(contact nodes, pairs): how much of each pair there is in a unit of force on each contact node."""
        return self.forces[:, self.dofs].T @ self.inverse


class Release:
    """Takes a body back from `origin`, of whose resting nodes none but leave (and return)."""

    def __init__(self, solver: Equilibrium, origin: State):
        self.solver = solver
        self.nodes = np.flatnonzero(origin.active)
        self.dofs = solver.surface_dofs[self.nodes]
        bulk, shear, _ = solver.moduli
        solver.linearise(origin.displacement, origin.history, (bulk, shear, np.inf))
        self.held = np.concatenate([solver.axis_dofs, solver.midplane_dofs])
        self.response = solver.compliance(self.dofs, self.held)  # displacements per unit of force on each resting node
        self.compliance = np.ascontiguousarray(self.response[:, self.dofs])
        self.tired = False

    def stiffness(self, state: State) -> float:
        """Tangent d force / d overlap with the resting nodes held."""
        resting = state.active[self.nodes]
        return float(np.linalg.solve(self.compliance[np.ix_(resting, resting)], np.ones(np.count_nonzero(resting))).sum())

    def step(self, start: State, overlap: float, largest_force: float, guess: Guess | None = None, contact: bool = True) -> State:
        """The equilibrium at `overlap`, or with contact=False off the flat; raises `NoEquilibrium` where the factors don't serve."""
        solver, tolerance = self.solver, RESIDUAL if contact else FREE_RESIDUAL
        displacement = (start if guess is None else guess).displacement.copy()
        displacement[:, 1] += overlap - (start if guess is None else guess).overlap
        resting = start.active[self.nodes] & contact
        force, last = np.where(resting, -start.reaction[self.nodes], 0.0), np.inf
        before: _Iterate | None = None
        secants = Secants(self.dofs, solver.body.dofs)
        for iteration in range(ITERATIONS):
            if not solver.evaluate(displacement, start.history):
                raise NoEquilibrium("an element was turned inside out")
            free = solver.forces.copy()
            free[self.held] = 0.0
            total = float(solver.forces[solver.midplane_dofs].sum())
            balance = free.copy()
            balance[self.dofs] += force
            residual = math.sqrt(float(balance @ balance))
            if iteration > 0 and residual < max(tolerance * max(abs(total), largest_force), solver.round_off):
                self.tired = iteration > SLOW
                return self._accepted(start, displacement, overlap, force > 0.0, total)
            if not math.isfinite(residual) or (iteration > 1 and not residual < CONTRACTION * last):
                raise NoEquilibrium("the tangent is too old")
            last = residual
            by_factors = free.copy()
            solver.solve(by_factors[None, :])
            if before is not None:
                secants.add(displacement.ravel() - before.displacement, free - before.free, by_factors - before.by_factors)
            before = _Iterate(displacement.ravel().copy(), free, by_factors)
            update = -secants.corrected(free, by_factors)
            if contact:
                force, moved = self._rest(solver.gaps(displacement)[self.nodes] - update[self.dofs], resting, secants)
                resting, update = force > 0.0, update - moved
            displacement += update.reshape(-1, 2)
            solver.statistics.iterations += 1
        raise NoEquilibrium(f"no convergence in {ITERATIONS} iterations")

    def _rest(self, gaps: FloatArray, resting: BoolArray, secants: Secants) -> tuple[FloatArray, FloatArray]:
        """Forces on the resting nodes that close `gaps`, which the body would have without them, and the displacement they take off."""
        with self.solver.statistics.timed("contact"):
            units = secants.of_units()
            compliance = self.compliance + (units @ secants.missed[:, self.dofs]).T
            if not (np.isfinite(compliance).all() and np.isfinite(gaps).all()):
                raise NoEquilibrium("what the iterations have shown does not correct the factors")
            force = complementary(compliance, gaps, resting)
            return force, force @ self.response + (force @ units) @ secants.missed

    def _accepted(self, start: State, displacement: FloatArray, overlap: float, resting: BoolArray, force: float) -> State:
        solver = self.solver
        if resting.any() and solver.gaps(displacement).min() < -max(PENETRATION * overlap, 1e-14):
            raise NoEquilibrium("a node lands that did not rest before")
        active = np.zeros_like(start.active)
        active[self.nodes[resting]] = True
        return solver.accept(start, displacement, overlap, active, force)
