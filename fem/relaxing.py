"""Relaxation of a whole body, on its nodal forces.

The nominal stress is the hereditary integral of the elastic one, P(t) = int psi(t - s) dP_e(F(s)), with one psi for the part that the shear
modulus makes and one for that of the bulk modulus. Integrals over the body commute with integrals over time, so what has to be remembered
is not stress at every point but nodal forces: two vectors for each term. Steps are exact for forces that grow evenly within them, however
long: an infinitely fast press is the elastic one with the instantaneous moduli, an infinitely slow one with the long-term moduli. And while
the contact of a body of constant Poisson's ratio grows, it takes on the very shapes of the elastic body, at any strain.

The nominal stress of the past does not turn with the material: where an element turns by an angle after it was loaded, the part of its
stress that is still remembered lags by that angle.
"""

from __future__ import annotations

import numpy as np

from contactlaws.prony import PronyViscoelastic
from fem.mesh import FloatArray
from fem.newton import Equilibrium, Moduli


def held_share(step: float, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What is left of each term after `step`, and of what is added evenly in it."""
    x = step / times
    return np.exp(-x), np.where(x > 1e-300, -np.expm1(-x) / np.maximum(x, 1e-300), 1.0)


class Relaxing:
    """The history of one body, and the elastic problem that its next step is.

    The nodal forces at the end of a step are A_s f_s(u) + A_b f_b(u) + h: the elastic forces of both moduli, each with the share of its
    modulus that is left at once, and what is known of the past. Divided by A_s it is an elastic body under dead loads.
    """

    def __init__(self, solver: Equilibrium, material: PronyViscoelastic):
        self.solver = solver
        self.moduli: Moduli = solver.moduli
        self.times = np.array(material.relaxation_times)
        self.shear = np.array(material.shear_fractions)
        self.bulk = None if material.bulk_fractions is None else np.array(material.bulk_fractions)
        size = solver.body.dofs
        self.elastic = np.zeros((1 if self.bulk is None else 2, size))  # f_s (or all of it) and f_b at the last state
        self.terms = np.zeros((len(self.elastic), self.times.size, size))
        self.scale = 1.0  # A_s
        self._decay = self._held = np.zeros(0)

    def begin(self, step: float) -> None:
        """Give the solver the moduli and loads of the next step, which takes `step` s."""
        self._decay, self._held = held_share(step, self.times)
        fractions = [self.shear] if self.bulk is None else [self.shear, self.bulk]
        at_once = [1.0 - float((g * (1.0 - self._held)).sum()) for g in fractions]
        past = np.zeros(self.solver.body.dofs)
        for g, terms, elastic in zip(fractions, self.terms, self.elastic, strict=True):
            past += (g * self._decay) @ terms - float((g * self._held).sum()) * elastic
        self.scale = at_once[0]
        bulk, shear, limit = self.moduli
        self.solver.moduli = (bulk * at_once[-1] / at_once[0], shear, limit)
        self.solver.loads = past / self.scale

    def end(self, displacement: FloatArray) -> None:
        """Take the state over that the step has led to."""
        new = np.empty_like(self.elastic)
        for row, moduli in enumerate(self._parts()):
            self.solver.elastic_forces(displacement, moduli)
            new[row] = self.solver.forces
        change = new - self.elastic
        self.terms = self._decay[:, None] * self.terms + self._held[:, None] * change[:, None, :]
        self.elastic = new

    def _parts(self) -> list[Moduli]:
        bulk, shear, limit = self.moduli
        return [self.moduli] if self.bulk is None else [(0.0, shear, limit), (bulk, 0.0, limit)]
