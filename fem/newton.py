"""One equilibrium: Newton's method merged with an active set of surface nodes that rest on the flat.

The flat is a plane, so a node in contact simply has its axial displacement prescribed: no penalty. A step is controlled by the overlap
(`ByOverlap`) or by the gap of one surface node with the overlap unknown (`ByGap`): with gap 0 the state found is the very instant at
which that node lands or leaves, with zero force on it.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from fem.assembly import Discretisation
from fem.banded import constrain, factorise, solve, solve_many
from fem.element import advance, assemble, assemble_forces
from fem.mesh import FloatArray, IntArray

BoolArray = npt.NDArray[np.bool_]
Moduli = tuple[float, float, float]  # bulk, shear, yield stress (infinite: elastic), one unit

ITERATIONS = 30  # a step that needs more is cut
PENETRATION = 1e-8  # of the overlap, that a node may go through the flat before it counts as touching
CONTACT_CHANGES = 60  # of the active set in one step
RESIDUAL = 1e-5  # of the largest force; two orders below the finest tolerance on offer, and the energies err by its square only

#: below this share of the largest force the factors of the last tangent may serve for the next move too: it costs a quarter of one with
#: a new tangent, as long as each brings the residual down to this share
NEAR, CONTRACTION = 0.01, 0.1


class ByOverlap(NamedTuple):
    """Go to this overlap (over the half height)."""

    overlap: float


class ByGap(NamedTuple):
    """Go to where the distance of the surface node number `place` from the flat is `gap` (over the half height)."""

    place: int
    gap: float


class Guess(NamedTuple):
    """Where Newton's method starts."""

    displacement: FloatArray
    overlap: float


class NoEquilibrium(RuntimeError):
    """Newton's method did not converge; the message says how it failed."""


@dataclass
class Statistics:
    """Counters of one run, for the provenance and for tuning."""

    steps: int = 0
    iterations: int = 0
    factorisations: int = 0
    rejected: int = 0  # steps that found no equilibrium and were cut
    # CPU seconds
    forces: float = 0.0  # nodal forces
    stiffness: float = 0.0  # nodal forces with their tangent
    factorisation: float = 0.0
    solution: float = 0.0
    contact: float = 0.0  # who rests, who leaves
    history: float = 0.0  # taking converged states over

    def timed(self, part: str) -> _Timed:
        """Add what runs inside to a part."""
        return _Timed(self, part)


class _Timed:
    """A context whose CPU time counts for a part; there are a dozen in each iteration, for which `contextlib` takes too long."""

    __slots__ = ("began", "part", "statistics")

    def __init__(self, statistics: Statistics, part: str):
        self.statistics, self.part = statistics, part

    def __enter__(self) -> None:
        self.began = time.process_time()

    def __exit__(self, *_: object) -> None:
        spent = time.process_time() - self.began
        setattr(self.statistics, self.part, getattr(self.statistics, self.part) + spent)


@dataclass(frozen=True)
class State:
    """A converged equilibrium; lengths over the half height, stresses in the unit of the moduli."""

    overlap: float
    force: float
    displacement: FloatArray  # (nodes, 2)
    active: BoolArray  # (surface nodes,) which rest on the flat
    history: FloatArray  # (elements, 4, 4) Cp^-1: rr, zz, rz, hoop
    plastic_strain: FloatArray  # (elements, 4)
    stress: FloatArray  # (elements, 4, 4) Cauchy: rr, zz, rz, hoop
    reaction: FloatArray  # (surface nodes,) force of the flat on each node
    stored: float = 0.0
    dissipated: float = 0.0
    yield_ratio: float = 0.0  # largest trial von Mises stress over the yield limit in the last step
    yield_place: tuple[int, int] = (0, 0)  # element and Gauss point of it


@dataclass
class _Trial:
    """Where the iterations of one step stand."""

    displacement: FloatArray
    overlap: float
    active: BoolArray
    update: FloatArray  # the last move
    onward: float = 0.0  # by how much the overlap grew in it
    fraction: float = 1.0  # of the last move that was kept

    def move(self, update: FloatArray, onward: float) -> None:
        """Go on by `update`."""
        self.update, self.onward, self.fraction = update, onward, 1.0
        self.displacement += update
        self.overlap += onward

    def halve(self) -> None:
        """Take back half of what is left of the last move."""
        self.fraction *= 0.5
        self.displacement -= self.fraction * self.update
        self.overlap -= self.fraction * self.onward


class Equilibrium:
    """Finds the next converged state of one body against the flat."""

    def __init__(self, body: Discretisation, moduli: Moduli, statistics: Statistics | None = None):
        self.body, self.moduli = body, moduli
        self.statistics = Statistics() if statistics is None else statistics
        section = body.section
        self.height = section.height
        self.depth = self.height - section.mesh.p[1, section.surface]  # of the surface nodes below the highest
        self.surface_dofs = 2 * section.surface + 1
        self.midplane_dofs = 2 * section.midplane + 1
        self.axis_dofs = 2 * section.axis
        # what the strains' round-off (1e-16 of a stretch near 1) leaves of the nodal forces; the mean dilatation's is an average
        self.round_off = (1e-15 * moduli[1] + 1e-16 * moduli[0]) * np.sqrt(body.cells.shape[0])
        self.undeformed = np.zeros((*body.volumes.shape, 4))  # Cp^-1 of a body without plastic strain
        self.undeformed[..., [0, 1, 3]] = 1.0
        self.forces = np.empty(body.dofs)
        self.band = np.empty(body.band_shape)
        self.loads: FloatArray | None = None  # dead nodal forces that act on the body from inside, besides those of its strain

    def start(self) -> State:
        """The undeformed body with its highest surface nodes just touching the flat."""
        cells, history = self.body.volumes.shape, self.undeformed.copy()
        touching = self.depth <= 1e-12 * self.height
        zeros = np.zeros((self.body.dofs // 2, 2))
        return State(0.0, 0.0, zeros, touching, history, np.zeros(cells), np.zeros_like(history), np.zeros(touching.size))

    def free_shape(self, state: State) -> State:
        """The body off the flat, moved rigidly to where it just touches: the separation after `state`."""
        off = replace(state, active=np.zeros_like(state.active))
        free = self.step(off, ByOverlap(state.overlap), state.force, contact=False)
        return self.touching(free)

    def touching(self, free: State) -> State:
        """A state without force, moved rigidly to where it just touches the flat."""
        lift = float(self.gaps(free.displacement).min())
        displacement = free.displacement.copy()
        displacement[:, 1] += lift
        return replace(free, displacement=displacement, overlap=free.overlap + lift, force=0.0)

    def gaps(self, displacement: FloatArray) -> FloatArray:
        """Distance of every surface node from the flat, negative if it has gone through."""
        return self.depth - displacement.reshape(-1)[self.surface_dofs]

    def evaluate(self, displacement: FloatArray, history: FloatArray) -> bool:
        """Put the nodal forces into `forces`; False if an element is turned inside out."""
        b = self.body
        with self.statistics.timed("forces"):
            sound = bool(assemble_forces(displacement, b.cells, b.gradients, b.hoops, b.volumes, history, self.moduli, self.forces))
        if self.loads is not None:
            self.forces += self.loads
        return sound

    def linearise(self, displacement: FloatArray, history: FloatArray, moduli: Moduli | None = None) -> bool:
        """The nodal forces, and their tangent into `band`; False if an element is turned inside out."""
        b, band = self.body, self.band.reshape(-1)
        with self.statistics.timed("stiffness"):
            sound = bool(
                assemble(displacement, b.cells, b.gradients, b.hoops, b.volumes, history, moduli or self.moduli, b.slots, self.forces, band)
            )
        if self.loads is not None:
            self.forces += self.loads
        return sound

    def elastic_forces(self, displacement: FloatArray, moduli: Moduli) -> None:
        """Put the nodal forces of a body of these moduli without a history or loads into `forces`."""
        b = self.body
        with self.statistics.timed("forces"):
            assemble_forces(displacement, b.cells, b.gradients, b.hoops, b.volumes, self.undeformed, moduli, self.forces)

    def factorise(self, fixed: IntArray, values: FloatArray, rhs: FloatArray) -> None:
        """Prescribe `values` (right-hand sides, fixed) of the components `fixed` in the tangent and take them to the right of `rhs`
        (right-hand sides, dofs); then factorise the tangent in place."""
        half, size = self.body.half_bandwidth, self.body.dofs
        with self.statistics.timed("factorisation"):
            constrain(self.band, half, fixed, values, rhs)
            if not factorise(self.band.reshape(-1), size, half):
                raise NoEquilibrium("singular tangent stiffness")
        self.statistics.factorisations += 1

    def solve(self, rhs: FloatArray) -> None:
        """Solve for each row of `rhs` with the factors at hand, in place."""
        with self.statistics.timed("solution"):
            solve(self.band.reshape(-1), self.body.dofs, self.body.half_bandwidth, rhs)

    def compliance(self, dofs: IntArray, fixed: IntArray) -> FloatArray:
        """Displacements (dofs, all dofs) per unit of force on each of `dofs`, `fixed` being held; factorises the tangent in place."""
        self.factorise(fixed, np.zeros((0, fixed.size)), np.zeros((0, self.body.dofs)))
        response = np.zeros((self.body.dofs, dofs.size))
        response[dofs, np.arange(dofs.size)] = 1.0
        with self.statistics.timed("solution"):
            solve_many(self.band.reshape(-1), self.body.dofs, self.body.half_bandwidth, response)
        return np.ascontiguousarray(response.T)

    def _directions(self, displacement: FloatArray, active: BoolArray) -> FloatArray:
        """From the tangent in `band`: Newton's update at fixed overlap, and the displacement per unit of overlap (2, dofs)."""
        closing = self.gaps(displacement)[active]
        fixed = np.concatenate([self.axis_dofs, self.midplane_dofs, self.surface_dofs[active]])
        values = np.zeros((2, fixed.size))
        values[1, self.axis_dofs.size : self.axis_dofs.size + self.midplane_dofs.size] = 1.0
        values[0, fixed.size - closing.size :] = closing
        rhs = np.zeros((2, self.body.dofs))
        rhs[0] = -self.forces
        self.factorise(fixed, values, rhs)
        self.solve(rhs)
        self.statistics.iterations += 1
        return rhs

    def _again(self, active: BoolArray) -> FloatArray:
        """Newton's update at fixed overlap by the factors at hand; the resting nodes are on the flat already."""
        update = -self._free_forces(active)[None, :]
        self.solve(update)
        self.statistics.iterations += 1
        return np.asarray(update[0])

    def _free_forces(self, active: BoolArray) -> FloatArray:
        """The forces on components that nothing holds, zero elsewhere."""
        free = self.forces.copy()
        free[self.axis_dofs] = 0.0
        free[self.midplane_dofs] = 0.0
        free[self.surface_dofs[active]] = 0.0
        return free

    def _update_contact(self, trial: _Trial, free: int | None, scale: float) -> bool:
        """Hold nodes that went through the flat (number `free` may), let go those that it would have to pull; whether there are any."""
        with self.statistics.timed("contact"):
            through = ~trial.active & (self.gaps(trial.displacement) < -max(PENETRATION * trial.overlap, 1e-14))
            if free is not None:
                through[free] = False
            pulled = trial.active & (self.forces[self.surface_dofs] > RESIDUAL * scale)
            trial.active = (trial.active | through) & ~pulled
            return bool(through.any() or pulled.any())

    def _onward(self, trial: _Trial, control: ByOverlap | ByGap, update: FloatArray, along: FloatArray) -> float:
        """By how much the overlap moves with `update` for `control` to be met."""
        if isinstance(control, ByOverlap):
            return control.overlap - trial.overlap
        dof = self.surface_dofs[control.place]
        return float((self.gaps(trial.displacement)[control.place] - control.gap - update[dof]) / along[dof])

    def step(
        self,
        start: State,
        control: ByOverlap | ByGap,
        largest_force: float = 0.0,
        guess: Guess | None = None,
        free: int | None = None,
        contact: bool = True,
    ) -> State:
        """The equilibrium that `control` asks for, from `start`; raises `NoEquilibrium`."""
        near = guess or Guess(start.displacement, start.overlap)
        trial = _Trial(near.displacement.copy(), near.overlap, start.active.copy(), np.zeros_like(start.displacement))
        free = control.place if isinstance(control, ByGap) else free
        if free is not None:
            trial.active[free] = False
        changes, best, scale = 0, np.inf, 0.0
        at_hand: FloatArray | None = None  # displacement per unit of overlap by the last factors, while these may serve again
        for iteration in range(ITERATIONS):
            near_by = at_hand is not None
            sound = (self.evaluate if near_by else self.linearise)(trial.displacement, start.history)
            force = float(self.forces[self.midplane_dofs].sum())
            scale = max(abs(force), largest_force, 1e-300)
            free_forces = self._free_forces(trial.active)
            residual = math.sqrt(float(free_forces @ free_forces)) if sound else np.inf
            if (residual > best or not sound) and trial.fraction > 0.05 and iteration > 1:
                # backtrack along the last update: the residual must fall, but for the step's first move and after a change of contact
                trial.halve()
                at_hand = None
                continue
            if not np.isfinite(residual):
                raise NoEquilibrium("an element was turned inside out" if not sound else "Newton's method diverges")
            settled, changed = iteration > 0 and residual < max(RESIDUAL * scale, self.round_off), False
            # never leave unchecked; before that, look as soon as the contact can be trusted
            if contact and (settled or (iteration > 1 and isinstance(control, ByOverlap) and residual < 0.02 * scale)):
                changed = self._update_contact(trial, free, scale)
                changes += changed
                if changes > CONTACT_CHANGES:
                    raise NoEquilibrium("the contact does not settle")
            if settled and not changed:
                return self.accept(start, trial.displacement, trial.overlap, trial.active, force)
            if at_hand is not None and not changed and residual < CONTRACTION * best:
                update, along = self._again(trial.active), at_hand
            else:
                if near_by:
                    self.linearise(trial.displacement, start.history)
                update, along = self._directions(trial.displacement, trial.active)
            best = np.inf if iteration == 0 or changed else residual
            at_hand = along if best < NEAR * scale else None
            onward = self._onward(trial, control, update, along)
            trial.move((update + onward * along).reshape(-1, 2), onward)
        raise NoEquilibrium(f"no convergence in {ITERATIONS} iterations (residual {best / scale:.1e} of the force)")

    def accept(self, start: State, displacement: FloatArray, overlap: float, active: BoolArray, force: float) -> State:
        """The state at a converged displacement, `forces` being its forces."""
        b = self.body
        history, plastic, stress = np.empty_like(start.history), np.empty_like(start.plastic_strain), np.empty_like(start.stress)
        with self.statistics.timed("history"):
            stored, dissipated, ratio, element, point = advance(
                displacement,
                b.cells,
                b.gradients,
                b.hoops,
                b.volumes,
                start.history,
                self.moduli,
                history,
                start.plastic_strain,
                plastic,
                stress,
            )
        self.statistics.steps += 1
        reaction = np.where(active, self.forces[self.surface_dofs], 0.0)
        return State(
            overlap,
            force,
            displacement,
            active,
            history,
            plastic,
            stress,
            reaction,
            stored,
            start.dissipated + dissipated,
            ratio,
            (element, point),
        )
