"""Structured quadrilateral mesh of the meridian section, with element size proportional to the distance from the pole.

The bipolar (Moebius) map z + ir = conj((1 - w)/(1 + w)) takes the quarter unit disc in w to a quarter of the unit disc: the pole is
w = 0, the mid-plane |w| = 1, the axis arg w = 0, the surface arg w = pi/2, and all corners stay right angles. Log-polar cells in w
around a small O-grid core therefore give every contact radius the same number of elements.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from skfem import MeshQuad

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class Section(NamedTuple):
    """Meridian section (r >= 0, z >= 0) of a body of revolution: mesh and the node sets that carry boundary conditions."""

    mesh: MeshQuad  # points (r, z), lengths over the half height
    axis: IntArray  # nodes on r = 0
    midplane: IntArray  # nodes on z = 0
    surface: IntArray  # nodes on the free surface, from the pole outwards
    recipe: str  # how it was made, for the provenance

    @property
    def height(self) -> float:
        """Distance from the mid-plane to the highest surface node."""
        return float(self.mesh.p[1, self.surface].max())


def _core(divisions: int) -> tuple[FloatArray, IntArray]:
    """Nodes (i, j) of an m x m block filling a rounded square, as complex numbers of size about 1, and its quadrilaterals."""
    m = divisions
    w = np.zeros((m + 1, m + 1), dtype=complex)
    for i in range(m + 1):
        for j in range(m + 1):
            level = max(i, j)
            if level:
                angle = 0.25 * math.pi * (j / level if j <= i else 2.0 - i / level)
                roundness = 0.6 * level / m
                w[i, j] = (1 - roundness) * complex(i, j) / m + roundness * level / m * complex(math.cos(angle), math.sin(angle))
    index = np.arange((m + 1) ** 2).reshape(m + 1, m + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]).reshape(4, -1)
    return w.ravel(), quads


def spheroid(divisions: int, core: float, aspect: float = 1.0, along: float = 1.0) -> Section:
    """Section of a spheroid of half height 1 and equatorial radius `aspect`.

    divisions: elements across the core, half of those across the quarter circle. core: radius of the O-grid core over the half height,
    about the smallest contact radius to be resolved. along: rings per square cell (2: cells half as long along the surface as deep).
    """
    m = divisions
    core_w = 0.5 * core
    core_nodes, quads = _core(m)
    nodes = [core_w * core_nodes]
    index = np.arange((m + 1) ** 2).reshape(m + 1, m + 1)
    inner = np.concatenate([index[m, :], index[m - 1 :: -1, m]])
    angle = np.linspace(0.0, 0.5 * math.pi, 2 * m + 1)
    circle = np.exp(1j * angle)
    rounded = core_nodes[inner]
    rings = max(3, round(along * math.log(1.0 / core_w) * 4 * m / math.pi))
    radius = core_w ** (1.0 - np.arange(1, rings + 1) / rings)
    cells = [quads]
    surface, axis = [index[0, :]], [index[:, 0]]
    for k, ring_radius in enumerate(radius, start=1):
        # the rounded square turns into a circle while the radius grows by half: over any shorter way its corners would fold fine rings
        blend = min(1.0, math.log(ring_radius / core_w) / math.log(1.5))
        nodes.append(ring_radius * ((1.0 - blend) * rounded + blend * circle))
        outer = np.arange(2 * m + 1) + (m + 1) ** 2 + (k - 1) * (2 * m + 1)
        cells.append(np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]]))
        surface.append(outer[-1:])
        axis.append(outer[:1])
        inner = outer
    w = np.concatenate(nodes)
    p = (1.0 - w) / (1.0 + w)
    points = np.stack([-aspect * p.imag, p.real])
    axis_nodes, midplane = np.concatenate(axis), inner
    points[0, axis_nodes] = 0.0
    points[1, midplane] = 0.0
    mesh = MeshQuad(points, np.ascontiguousarray(np.concatenate(cells, axis=1)))
    return Section(
        mesh, axis_nodes, midplane, np.concatenate(surface), f"bipolar {m} x {rings} rings, core {core:.3g}, aspect {aspect:.6g}"
    )
