"""Small pieces of a body of revolution, and what can be done with them, for the tests of the element and of the stress."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from skfem import MeshQuad

from fem.assembly import Discretisation, discretise
from fem.element import advance, assemble, element, work_space
from fem.mesh import FloatArray, Section
from fem.newton import Moduli

ELASTIC: Moduli = (4.0, 2.0, np.inf)  # bulk, shear, yield stress
PLASTIC: Moduli = (4.0, 2.0, 0.2)
NEARLY_INCOMPRESSIBLE: Moduli = (200.0, 2.0, 0.2)

#: displacements of the nine nodes of `patch`, in units of its edge; up to strains of about 0.4
displacements = hnp.arrays(np.float64, (9, 2), elements=st.floats(-1.0, 1.0, width=32)).map(lambda u: 0.08 * u)


def patch(inner: float = 0.5) -> Discretisation:
    """Four irregular quadrilaterals, r from `inner` to `inner` + 1 and z from 0 to 1."""
    r = inner + np.array([0.0, 0.45, 1.0, 0.0, 0.58, 1.0, 0.0, 0.6, 1.0])
    z = np.array([0.0, 0.0, 0.0, 0.55, 0.42, 0.5, 1.0, 1.0, 1.0])
    mesh = MeshQuad(np.stack([r, z]), np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]).T.copy())
    axis = np.flatnonzero(r == 0.0)
    return discretise(Section(mesh, axis, np.array([0, 1, 2]), np.array([6, 7, 8]), "patch"))


def middle_node(body: Discretisation) -> int:
    """The one node of `patch` that no edge holds."""
    return int(np.argmax(np.bincount(body.cells.ravel())))


class Material:
    """The history of a piece of a body, step by step."""

    def __init__(self, body: Discretisation, moduli: Moduli):
        self.body, self.moduli = body, moduli
        self.history = np.zeros((*body.volumes.shape, 4))
        self.history[..., [0, 1, 3]] = 1.0
        self.plastic_strain = np.zeros(body.volumes.shape)
        self.stress = np.zeros_like(self.history)
        self.stored, self.dissipated, self.ratio = 0.0, 0.0, 0.0

    def go(self, displacement: FloatArray) -> None:
        """Take over the state at `displacement`; energies are of this step (dissipated) and of the state (stored)."""
        b = self.body
        history, plastic, stress = np.empty_like(self.history), np.empty_like(self.plastic_strain), np.empty_like(self.stress)
        self.stored, self.dissipated, self.ratio, _, _ = advance(
            displacement, b.cells, b.gradients, b.hoops, b.volumes, self.history, self.moduli, history, self.plastic_strain, plastic, stress
        )
        self.history, self.plastic_strain, self.stress = history, plastic, stress

    def forces(self, displacement: FloatArray) -> FloatArray:
        """Nodal forces (nodes, 2) at `displacement` from the present history."""
        return self.assembled(displacement)[0].reshape(-1, 2)

    def assembled(self, displacement: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nodal forces (dofs) and the band matrix."""
        b = self.body
        forces, band = np.empty(b.dofs), np.empty(b.band_shape)
        assert assemble(
            displacement, b.cells, b.gradients, b.hoops, b.volumes, self.history, self.moduli, b.slots, forces, band.reshape(-1)
        )
        return forces, band

    def element(self, displacement: FloatArray, e: int) -> tuple[FloatArray, FloatArray]:
        """Nodal forces (8) and stiffness (8 x 8) of one element."""
        b, force, stiffness = self.body, np.empty(8), np.empty((8, 8))
        assert element(
            displacement, b.cells, b.gradients, b.hoops, b.volumes, self.history, self.moduli, e, force, stiffness, *work_space()
        )
        return force, stiffness


def von_mises(stress: FloatArray) -> FloatArray:
    """Of stresses (..., 4): rr, zz, rz, hoop."""
    rr, zz, rz, hoop = np.moveaxis(stress, -1, 0)
    return np.sqrt(0.5 * ((rr - zz) ** 2 + (zz - hoop) ** 2 + (hoop - rr) ** 2) + 3.0 * rz**2)


def slope(function: Callable[[float], FloatArray], step: float = 5e-4) -> FloatArray:
    """Derivative at 0 by central differences with three steps, extrapolated: sixth order, good to about 1e-11 here."""
    d = [(function(h) - function(-h)) / (2.0 * h) for h in (step, step / 2.0, step / 4.0)]
    first = [(4.0 * d[1] - d[0]) / 3.0, (4.0 * d[2] - d[1]) / 3.0]
    return (16.0 * first[1] - first[0]) / 15.0
