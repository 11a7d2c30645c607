"""Which element: bilinear with full integration, bilinear with mean dilatation, biquadratic, on one elastic contact problem.

A sphere is pressed by its mid-plane against a rigid frictionless flat, at small strain and so little that Hertz's force is exact but for
the finite size (a/R is 1e-4 to 2e-4). scikit-fem assembles and the surface's compliance is found once; what touches at an overlap is then
found exactly, as a least-squares problem in forces that must not pull.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import nnls
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuad0, ElementQuad1, ElementQuad2, ElementVector, MeshQuad
from skfem.helpers import grad

from contactlaws.elastic import Hertz
from contactlaws.path import scan
from fem.mesh import Section, spheroid

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

#: radius of the fine core; the contact goes from filling it to twice that
CORE = 1e-4
#: surface nodes farther from the axis than so many cores stay out of reach
REACH = 4.0
PLACES = 40  # overlaps
POISSONS_RATIOS = (0.3, 0.4999)


class Measured(NamedTuple):
    """One element on one mesh."""

    element: str
    poissons_ratio: float
    divisions: int
    unknowns: int
    cpu_seconds: float  # assembling, factorising, the compliance, the contact
    error: float  # mean of |F/F_Hertz - 1|
    ripple: float  # standard deviation of F/F_Hertz, as nodes land one by one


class Problem(NamedTuple):
    """Stiffness of the body, and what touches: a unit modulus, lengths over the radius."""

    stiffness: csc_matrix
    fixed: IntArray  # dofs: radial ones on the axis, axial ones on the mid-plane
    surface: IntArray  # axial dofs of the surface within reach, from the pole outwards
    gap: FloatArray  # of the undeformed sphere there


def _strain(u: Any, w: Any) -> tuple[Any, Any, Any, Any]:
    """Radial, axial, hoop strain and shear angle."""
    g = grad(u)
    return g[0, 0], g[1, 1], u[0] / w.x[0], g[0, 1] + g[1, 0]


def _trace(u: Any, w: Any) -> Any:
    r, z, hoop, _ = _strain(u, w)
    return r + z + hoop


@BilinearForm
def _shear(u: Any, v: Any, w: Any) -> Any:
    """Deviator's part, for a shear modulus of 1."""
    (a, b, c, d), (e, f, g, h) = _strain(u, w), _strain(v, w)
    return 2.0 * np.pi * w.x[0] * (2.0 * (a * e + b * f + c * g) + d * h - 2.0 / 3.0 * _trace(u, w) * _trace(v, w))


@BilinearForm
def _bulk(u: Any, v: Any, w: Any) -> Any:
    """Volume's part, for a bulk modulus of 1."""
    return 2.0 * np.pi * w.x[0] * _trace(u, w) * _trace(v, w)


@BilinearForm
def _dilatation(u: Any, q: Any, w: Any) -> Any:
    """Change of volume of each element."""
    return 2.0 * np.pi * w.x[0] * _trace(u, w) * q


@BilinearForm
def _volume(p: Any, q: Any, w: Any) -> Any:
    return 2.0 * np.pi * w.x[0] * p * q


def full(basis: Basis, nu: float) -> csc_matrix:
    """Displacements alone, every Gauss point with its own dilatation. Young's modulus is 1."""
    return csc_matrix(_shear.assemble(basis) * (0.5 / (1.0 + nu)) + _bulk.assemble(basis) / (3.0 * (1.0 - 2.0 * nu)))


def mean_dilatation(basis: Basis, nu: float) -> csc_matrix:
    """The pressure of an element goes with the change of its volume as a whole, as in `fem.element`."""
    constant = basis.with_element(ElementQuad0())
    change, volume = csc_matrix(_dilatation.assemble(basis, constant)), _volume.assemble(constant).diagonal()
    bulk = change.T @ change.multiply(1.0 / volume[:, None])
    return csc_matrix(_shear.assemble(basis) * (0.5 / (1.0 + nu)) + bulk / (3.0 * (1.0 - 2.0 * nu)))


ELEMENTS: dict[str, tuple[Any, int, Callable[[Basis, float], csc_matrix]]] = {
    "bilinear, full integration": (ElementQuad1, 3, full),
    "bilinear, mean dilatation": (ElementQuad1, 3, mean_dilatation),
    "biquadratic": (ElementQuad2, 5, full),
}


def measure(element: str, nu: float, divisions: int) -> Measured:
    """Error and cost of one of `ELEMENTS`."""
    section, began = spheroid(divisions, CORE), time.process_time()
    kind, order, stiffness = ELEMENTS[element]
    basis = Basis(section.mesh, ElementVector(kind()), intorder=order)
    body = problem(basis, section, stiffness(basis, nu))
    at = np.geomspace(CORE**2, 4.0 * CORE**2, PLACES)
    give = compliance(body)
    force = np.array([press(give, body.gap, overlap) for overlap in at])
    cost = time.process_time() - began
    ratio = force / scan(Hertz(1.0, 1.0 / (1.0 - nu**2)), at).force
    return Measured(element, nu, divisions, int(basis.N), cost, float(abs(ratio - 1.0).mean()), float(ratio.std()))


def problem(basis: Basis, section: Section, stiffness: csc_matrix) -> Problem:
    """Which dofs are held and which may touch; mid-side nodes of the surface get the gap of the sphere, not that of their chord."""
    mesh = section.mesh
    axis, midplane = (_dofs(basis, mesh, nodes, k) for nodes, k in ((section.axis, 0), (section.midplane, 1)))
    surface = _dofs(basis, mesh, section.surface, 1)
    r = basis.doflocs[0, surface]
    order = np.argsort(r)
    near = order[r[order] < REACH * CORE]
    return Problem(stiffness, np.concatenate([axis, midplane]), surface[near], r[near] ** 2 / (1.0 + np.sqrt(1.0 - r[near] ** 2)))


def _dofs(basis: Basis, mesh: MeshQuad, nodes: IntArray, component: int) -> IntArray:
    """Those of one component on a part of the boundary: at its nodes and, if the element has any, in the middle of its edges."""
    found = basis.nodal_dofs[component, nodes]
    if basis.facet_dofs.size == 0:
        return np.asarray(found)
    edges = mesh.boundary_facets()
    edges = edges[np.isin(mesh.facets[:, edges], nodes).all(axis=0)]
    return np.concatenate([found, basis.facet_dofs[component, edges]])


def compliance(body: Problem) -> FloatArray:
    """How far each surface node goes in for a unit force on each other one."""
    free = np.setdiff1d(np.arange(body.stiffness.shape[0]), body.fixed)
    place = np.searchsorted(free, body.surface)
    loads = np.zeros((free.size, place.size))
    loads[place, np.arange(place.size)] = 1.0
    factor = splu(body.stiffness[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0)
    return np.asarray(factor.solve(loads)[place])


def press(give: FloatArray, gap: FloatArray, overlap: float) -> float:
    """Force at an overlap. `give` is the compliance C: of all forces p >= 0 the one with the least p C p / 2 - (overlap - gap) p."""
    root = np.linalg.cholesky(0.5 * (give + give.T))
    forces, _ = nnls(root.T, np.linalg.solve(root, overlap - gap))
    return float(forces.sum())
