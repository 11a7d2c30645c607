"""From a meridian section to the arrays the compiled element runs on: scikit-fem's basis and quadrature, and a fixed band pattern."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, reverse_cuthill_mckee
from skfem import Basis, ElementQuad1, MeshQuad

from fem.banded import band_shape, pad
from fem.mesh import FloatArray, IntArray, Section


class Discretisation(NamedTuple):
    """Everything about the undeformed body that the solver needs; nodes are numbered for a small bandwidth."""

    section: Section
    cells: IntArray  # (elements, 4) nodes
    gradients: FloatArray  # (elements, 4 Gauss points, 4 nodes, 2) of the shape functions, undeformed
    hoops: FloatArray  # (elements, 4, 4) shape function over undeformed radius
    volumes: FloatArray  # (elements, 4) undeformed volume of each Gauss point, full revolution
    places: FloatArray  # (elements, 4, 2) undeformed (r, z) of the Gauss points
    slots: IntArray  # (elements, 8, 8) place of each stiffness entry in the flat band matrix
    half_bandwidth: int

    @property
    def dofs(self) -> int:
        """Number of displacement components; node i owns 2 i (radial) and 2 i + 1 (axial)."""
        return 2 * self.section.mesh.p.shape[1]

    @property
    def band_shape(self) -> tuple[int, int]:
        """Shape of the band matrix; see `fem.banded`."""
        return band_shape(self.dofs, self.half_bandwidth)


def _half_bandwidth(cells: IntArray) -> int:
    return int((cells.max(axis=0) - cells.min(axis=0)).max())


def renumbered(section: Section) -> Section:
    """The same section with its nodes in layers around the pole, or in reverse Cuthill-McKee order where that is narrower."""
    cells, size = section.mesh.t, section.mesh.p.shape[1]
    rows, columns = np.repeat(cells, 4, axis=0).ravel(), np.tile(cells, (4, 1)).ravel()
    graph = coo_matrix((np.ones(rows.size), (rows, columns)), shape=(size, size)).tocsr()
    layers = breadth_first_order(graph, section.surface[0], directed=False, return_predecessors=False)
    orders = [layers, reverse_cuthill_mckee(graph, symmetric_mode=True)]
    order = min(orders, key=lambda o: _half_bandwidth(np.argsort(o)[cells]))
    rank = np.argsort(order).astype(np.int64)
    mesh = MeshQuad(np.ascontiguousarray(section.mesh.p[:, order]), np.ascontiguousarray(rank[cells]), sort_t=False, validate=False)
    return section._replace(mesh=mesh, axis=rank[section.axis], midplane=rank[section.midplane], surface=rank[section.surface])


def discretise(section: Section) -> Discretisation:
    """Evaluate scikit-fem's bilinear quadrilateral at 2 x 2 Gauss points and lay out the band matrix."""
    section = renumbered(section)
    mesh = section.mesh
    basis = Basis(mesh, ElementQuad1(), intorder=3)
    places = np.moveaxis(np.asarray(basis.global_coordinates()), 0, -1)
    shape = np.stack([np.broadcast_to(np.asarray(b[0]), places.shape[:2]) for b in basis.basis], axis=-1)
    gradients = np.stack([np.moveaxis(np.asarray(b[0].grad), 0, -1) for b in basis.basis], axis=2)
    radius = places[..., 0]
    cells = np.ascontiguousarray(mesh.t.T.astype(np.int64))
    dofs = (2 * cells[:, :, None] + np.arange(2)).reshape(-1, 8)
    half = int((dofs.max(axis=1) - dofs.min(axis=1)).max())
    slots = dofs[:, :, None] * (2 * pad(half) + 1) + pad(half) + dofs[:, None, :] - dofs[:, :, None]
    return Discretisation(
        section,
        cells,
        np.ascontiguousarray(gradients),
        np.ascontiguousarray(shape / radius[..., None]),
        np.ascontiguousarray(2.0 * np.pi * radius * basis.dx),
        np.ascontiguousarray(places),
        np.ascontiguousarray(slots),
        half,
    )
