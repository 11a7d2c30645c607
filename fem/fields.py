"""What the body looks like inside: deformed mesh, stress and plastic strain as .vtu (ParaView), through meshio."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactlaws.files import write_atomically
from fem.assembly import Discretisation
from fem.mesh import FloatArray
from fem.newton import State
from fem.walk import Visitor

if TYPE_CHECKING:
    import meshio


def contact_pressure(body: Discretisation, state: State) -> FloatArray:
    """Pressure at the surface nodes, over the stress unit: the flat's force on a node over the node's share of the surface."""
    surface = body.section.surface
    radius = body.section.mesh.p[0, surface] + state.displacement[surface, 0]
    # integral of 2 pi r times the node's hat function, r linear between nodes
    width = np.diff(radius)
    share = np.zeros(radius.size)
    share[:-1] += 2.0 * np.pi * width * (radius[:-1] / 3.0 + radius[1:] / 6.0)
    share[1:] += 2.0 * np.pi * width * (radius[:-1] / 6.0 + radius[1:] / 3.0)
    return np.asarray(-state.reaction / share)


def to_meshio(body: Discretisation, state: State, length: float, stress: float) -> meshio.Mesh:
    """The state as a mesh in SI units: deformed points (r, z, 0) in m, stress components rr, zz, rz, hoop in Pa."""
    import meshio  # not above: it takes long to load, and few runs ask for fields

    points = body.section.mesh.p.T
    pressure = np.zeros(points.shape[0])
    pressure[body.section.surface] = contact_pressure(body, state)
    mean = state.stress.mean(axis=1)
    deviator = mean - mean[:, [0, 1, 3]].mean(axis=1)[:, None] * np.array([1.0, 1.0, 0.0, 1.0])
    von_mises = np.sqrt(1.5 * (deviator[:, 0] ** 2 + deviator[:, 1] ** 2 + deviator[:, 3] ** 2 + 2.0 * deviator[:, 2] ** 2))

    def spatial(values: FloatArray) -> FloatArray:
        return np.column_stack([values * length, np.zeros(values.shape[0])])

    return meshio.Mesh(
        spatial(points + state.displacement),
        [("quad", body.cells)],
        point_data={"displacement": spatial(state.displacement), "undeformed": spatial(points), "contact_pressure": pressure * stress},
        cell_data={
            "stress": [mean * stress],
            "von_mises": [von_mises * stress],
            "equivalent_plastic_strain": [state.plastic_strain.mean(axis=1)],
        },
    )


def field_writer(body: Discretisation, stress: float, length: float, folder: Path) -> Visitor:
    """A visitor that writes `loading_D<overlap>.vtu` and `unloaded_D<overlap>.vtu` into `folder` for every unloading."""

    def visit(overlap: float, states: list[State]) -> None:
        for name, state in (("loading", states[0]), ("unloaded", states[-1])):
            write = partial(to_meshio(body, state, length, stress).write, file_format="vtu")
            write_atomically(folder / f"{name}_D{overlap:.4f}.vtu", write)

    return visit
