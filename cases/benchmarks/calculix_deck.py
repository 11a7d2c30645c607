"""The same press by CalculiX, see `cases.calculix`: its input deck from our mesh.

Eight-node axisymmetric elements with reduced integration (CAX8R), finite strain, perfect plasticity; the flat is rigid and frictionless.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases import calculix
from contactlaws.material import Material
from fem.mesh import FloatArray, IntArray, Section

#: CalculiX computes a wedge of 2 degrees
WEDGES = 180.0


class Quadratic(NamedTuple):
    """Eight-node quadrilaterals: the corners of a section and the middles of its edges."""

    points: FloatArray  # (2, nodes)
    cells: IntArray  # (8, elements): corners, then middles of the edges between them
    axis: IntArray
    midplane: IntArray
    surface: IntArray  # from the pole outwards


def quadratic(section: Section) -> Quadratic:
    """Put a node in the middle of every edge of a sphere's section, on the sphere where the edge is on the surface."""
    mesh, corners = section.mesh, section.mesh.p.shape[1]
    middles = mesh.p[:, mesh.facets].mean(axis=1)
    number = {frozenset(edge): corners + k for k, edge in enumerate(mesh.facets.T.tolist())}

    def between(nodes: IntArray) -> IntArray:
        chain = nodes.tolist()
        return np.array([number[frozenset(pair)] for pair in zip(chain[:-1], chain[1:], strict=True)])

    surface = between(section.surface)
    middles[:, surface - corners] /= np.hypot(*middles[:, surface - corners])
    points = np.concatenate([mesh.p, middles], axis=1)

    def line(nodes: IntArray, coordinate: int) -> IntArray:
        ordered = nodes[np.argsort(points[coordinate, nodes])]
        return np.concatenate([ordered, between(ordered)])

    along = np.empty(2 * section.surface.size - 1, dtype=np.int64)
    along[0::2], along[1::2] = section.surface, surface
    cells = np.concatenate([mesh.t, corners + mesh.t2f])
    return Quadratic(points, cells, line(section.axis, 1), line(section.midplane, 0), along)


def deck(body: Quadratic, material: Material, stops: list[float], increments: int) -> str:
    """CalculiX's input: one step of about `increments` increments to each overlap (over the half height) of `stops` in turn."""
    modulus, size = material.youngs_modulus / material.stress_unit, body.points.shape[1]
    lines = ["*NODE, NSET=BODY", *(f"{k + 1}, {r:.15g}, {z:.15g}, 0." for k, (r, z) in enumerate(body.points.T))]
    flat = size + np.arange(body.surface.size)
    lines += ["*NODE, NSET=FLAT", *(f"{k + 1}, {body.points[0, s]:.15g}, 1., 0." for k, s in zip(flat, body.surface, strict=True))]
    lines += ["*ELEMENT, TYPE=CAX8R, ELSET=BODY"]
    lines += [", ".join(map(str, (e + 1, *(nodes + 1)))) for e, nodes in enumerate(body.cells.T)]
    first, clearance = body.cells.shape[1] + 1, 1.0 - body.points[1, body.surface]
    lines += calculix.gaps(first, body.surface, flat, clearance, "0., 1., 0.", modulus)
    lines += [*calculix.node_set("AXIS", body.axis), *calculix.node_set("MIDPLANE", body.midplane)]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{modulus:.15g}, {material.poissons_ratio:.15g}"]
    if material.yield_stress is not None:
        lines += ["*PLASTIC", "1., 0."]
    lines += ["*SOLID SECTION, ELSET=BODY, MATERIAL=M", "*BOUNDARY", "FLAT, 1, 3", "AXIS, 1, 1"]
    for overlap in stops:
        lines += [f"*STEP, NLGEOM, INC={20 * increments}", "*STATIC", f"{0.2 / increments:.6g}, 1., 1e-8, {1.0 / increments:.6g}"]
        lines += ["*BOUNDARY", f"MIDPLANE, 2, 2, {overlap:.15g}"]
        lines += ["*NODE PRINT, NSET=MIDPLANE, TOTALS=ONLY", "RF", "*END STEP"]
    return "\n".join(lines) + "\n"


def run(body: Quadratic, material: Material, stops: list[float], increments: int, timeout: float) -> calculix.Result:
    """Lengths over the half height, forces over (stress unit times its square): of the whole body, not of CalculiX's wedge."""
    found = calculix.run(deck(body, material, stops, increments), stops, timeout)
    return found._replace(force=WEDGES * found.force)
