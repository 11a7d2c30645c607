"""One equilibrium: Newton's method merged with an active set of surface nodes that rest on the flat.

The flat is a plane, so a node in contact simply has its axial displacement prescribed: no penalty. A step is controlled by the overlap
(`ByOverlap`) or by the gap of one surface node with the overlap unknown (`ByGap`): with gap 0 the state found is the very instant at
which that node lands or leaves, with zero force on it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg.lapack import dgbtrf, dgbtrs

from contactlaws.compiled import kernel
from fem.assembly import Discretisation
from fem.element import advance, assemble
from fem.mesh import FloatArray

Moduli = tuple[float, float, float]  # bulk, shear, yield stress (infinite: elastic), one unit

ITERATIONS = 30  # a step that needs more is cut
PENETRATION = 1e-8  # of the overlap, that a node may go through the flat before it counts as touching
CONTACT_CHANGES = 60  # of the active set in one step
RESIDUAL = 1e-6  # of the largest force; two orders below the finest tolerance on offer, and Newton overshoots it by as much again


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
    rejected: int = 0


@dataclass(frozen=True)
class State:
    """A converged equilibrium; lengths over the half height, stresses in the unit of the moduli."""

    overlap: float
    force: float
    displacement: FloatArray  # (nodes, 2)
    active: npt.NDArray[np.bool_]  # (surface nodes,) which rest on the flat
    history: FloatArray  # (elements, 4, 4) Cp^-1: rr, zz, rz, hoop
    plastic_strain: FloatArray  # (elements, 4)
    stress: FloatArray  # (elements, 4, 4) Cauchy: rr, zz, rz, hoop
    reaction: FloatArray  # (surface nodes,) force of the flat on each node
    stored: float = 0.0
    dissipated: float = 0.0
    yield_ratio: float = 0.0  # largest trial von Mises stress over the yield limit in the last step
    yield_place: tuple[int, int] = (0, 0)  # element and Gauss point of it


@kernel
def constrain(band, half, fixed, values, rhs):  # type: ignore[no-untyped-def]
    """Prescribe dofs `fixed`: take their columns times `values` (fixed, right-hand sides) to the right, leave a unit diagonal."""
    size = rhs.shape[0]
    for k in range(fixed.size):
        d = fixed[k]
        for i in range(max(0, d - half), min(size, d + half + 1)):
            entry = band[d, 2 * half + i - d]
            for c in range(rhs.shape[1]):
                rhs[i, c] -= entry * values[k, c]
            band[d, 2 * half + i - d] = 0.0
            band[i, 2 * half + d - i] = 0.0
        band[d, 2 * half] = 1.0
    for k in range(fixed.size):
        rhs[fixed[k], :] = values[k, :]


class Equilibrium:
    """Finds the next converged state of one body against the flat."""

    def __init__(self, body: Discretisation, moduli: Moduli, statistics: Statistics | None = None):
        self.body, self.moduli = body, moduli
        self.statistics = Statistics() if statistics is None else statistics
        section = body.section
        self.surface_height = section.mesh.p[1, section.surface]
        self.surface_dofs = 2 * section.surface + 1
        self.midplane_dofs = 2 * section.midplane + 1
        self.axis_dofs = 2 * section.axis
        # what the strains' round-off (1e-16 of a stretch near 1) leaves of the nodal forces; the mean dilatation's is an average
        self.round_off = (1e-15 * moduli[1] + 1e-16 * moduli[0]) * np.sqrt(body.cells.shape[0])
        self.forces = np.empty(body.dofs)
        self.band = np.empty(body.band_shape)

    def start(self) -> State:
        """The undeformed body with its highest surface nodes just touching the flat."""
        cells = self.body.volumes.shape
        history = np.zeros((*cells, 4))
        history[..., [0, 1, 3]] = 1.0
        touching = self.surface_height >= self.body.section.height * (1.0 - 1e-12)
        zeros = np.zeros((self.body.dofs // 2, 2))
        return State(0.0, 0.0, zeros, touching, history, np.zeros(cells), np.zeros_like(history), np.zeros(touching.size))

    def stiffness(self, state: State) -> float:
        """Tangent d force / d overlap of the elastic response from a converged state, all resting nodes held."""
        bulk, shear, _ = self.moduli
        elastic = Equilibrium(self.body, (bulk, shear, np.inf))
        elastic._assemble(state.displacement, state.history)
        along = elastic._directions(state.displacement, state.active)[1]
        shift = 1e-7 * state.overlap
        elastic._assemble(state.displacement + shift * along, state.history)
        return (float(elastic.forces[self.midplane_dofs].sum()) - state.force) / shift

    def free_shape(self, state: State) -> State:
        """The body off the flat, moved rigidly to where it just touches: the separation after `state`."""
        off = replace(state, active=np.zeros_like(state.active))
        free = self.step(off, ByOverlap(state.overlap), state.force, contact=False)
        lift = float(self.gaps(free.displacement).min())
        displacement = free.displacement.copy()
        displacement[:, 1] += lift
        return replace(free, displacement=displacement, overlap=free.overlap + lift, force=0.0)

    def gaps(self, displacement: FloatArray) -> FloatArray:
        """Distance of every surface node from the flat, negative if it has gone through."""
        return self.body.section.height - self.surface_height - displacement[self.body.section.surface, 1]

    def _assemble(self, displacement: FloatArray, history: FloatArray) -> bool:
        b = self.body
        return bool(
            assemble(
                displacement, b.cells, b.gradients, b.hoops, b.volumes, history, self.moduli, b.slots, self.forces, self.band.reshape(-1)
            )
        )

    def _directions(self, displacement: FloatArray, active: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """Newton's update at fixed overlap, and the displacement per unit of overlap; also leaves the reactions in `forces`."""
        half = self.body.half_bandwidth
        closing = self.gaps(displacement)[active]
        fixed = np.concatenate([self.axis_dofs, self.midplane_dofs, self.surface_dofs[active]])
        values = np.zeros((fixed.size, 2))
        values[self.axis_dofs.size : self.axis_dofs.size + self.midplane_dofs.size, 1] = 1.0
        values[fixed.size - closing.size :, 0] = closing
        rhs = np.zeros((self.body.dofs, 2), order="F")
        rhs[:, 0] = -self.forces
        constrain(self.band, half, fixed, values, rhs)
        factors, pivots, info = dgbtrf(self.band.T, half, half, overwrite_ab=True)
        if info != 0:
            raise NoEquilibrium(f"singular tangent stiffness (pivot {info})")
        solution, info = dgbtrs(factors, half, half, rhs, pivots, overwrite_b=True)
        self.statistics.iterations += 1
        return solution[:, 0].reshape(-1, 2), solution[:, 1].reshape(-1, 2)

    def _residual(self, active: npt.NDArray[np.bool_]) -> float:
        free = self.forces.copy()
        free[self.axis_dofs] = 0.0
        free[self.midplane_dofs] = 0.0
        free[self.surface_dofs[active]] = 0.0
        return float(np.linalg.norm(free))

    def _violations(
        self, displacement: FloatArray, overlap: float, active: npt.NDArray[np.bool_], scale: float
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Nodes that have gone through the flat, and nodes that it would have to pull."""
        through = ~active & (self.gaps(displacement) < -max(PENETRATION * overlap, 1e-14))
        pulled = active & (self.forces[self.surface_dofs] > RESIDUAL * scale)
        return through, pulled

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
        displacement, overlap, active = start.displacement.copy(), start.overlap, start.active.copy()
        if guess is not None:
            displacement, overlap = guess.displacement.copy(), guess.overlap
        free = control.place if isinstance(control, ByGap) else free
        if free is not None:
            active[free] = False
        changes, best, fraction = 0, np.inf, 1.0
        update, advance_by = np.zeros_like(displacement), 0.0
        for iteration in range(ITERATIONS):
            sound = self._assemble(displacement, start.history)
            force = float(self.forces[self.midplane_dofs].sum())
            scale = max(abs(force), largest_force, 1e-300)
            residual = self._residual(active) if sound else np.inf
            if (residual > best or not sound) and fraction > 0.05 and iteration > 1:
                # backtrack along the last update: the residual must fall, but for the step's first move and after a change of contact
                fraction *= 0.5
                displacement -= fraction * update
                overlap -= fraction * advance_by
                continue
            if not np.isfinite(residual):
                raise NoEquilibrium("an element was turned inside out" if not sound else "Newton's method diverges")
            settled = iteration > 0 and residual < max(RESIDUAL * scale, self.round_off)
            changed = False
            # never leave unchecked; before that, look as soon as the contact can be trusted
            near = iteration > 1 and isinstance(control, ByOverlap) and residual < 0.02 * scale
            if contact and (settled or near):
                through, pulled = self._violations(displacement, overlap, active, scale)
                if free is not None:
                    through[free] = False
                changed = bool(through.any() or pulled.any())
                if changed:
                    changes += 1
                    if changes > CONTACT_CHANGES:
                        raise NoEquilibrium("the contact does not settle")
                    active = (active | through) & ~pulled
            if settled and not changed:
                return self._accept(start, displacement, overlap, active, force)
            best = np.inf if iteration == 0 or changed else residual
            update, along = self._directions(displacement, active)
            if isinstance(control, ByOverlap):
                advance_by = control.overlap - overlap
            else:
                dof = (self.body.section.surface[control.place], 1)
                advance_by = (self.gaps(displacement)[control.place] - control.gap - update[dof]) / along[dof]
            update += advance_by * along
            fraction = 1.0
            displacement += update
            overlap += advance_by
        raise NoEquilibrium(f"no convergence in {ITERATIONS} iterations (residual {best / scale:.1e} of the force)")

    def _accept(self, start: State, displacement: FloatArray, overlap: float, active: npt.NDArray[np.bool_], force: float) -> State:
        b = self.body
        history, plastic, stress = np.empty_like(start.history), np.empty_like(start.plastic_strain), np.empty_like(start.stress)
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
