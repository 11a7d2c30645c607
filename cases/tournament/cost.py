"""Nanoseconds per contact of laws, in the pair kernel of the DEM itself, all in one run and against Hertz."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

import dem
from contactlaws.elastic import Hertz
from dem.measure import network
from dem.working import Working, renew_forces, working

FloatArray = npt.NDArray[np.float64]

#: spheres along an edge of the periodic cube, steps each way, how often all is repeated
EDGE, STEPS, REPEATS = 14, 12, 12
#: distance of neighbours over the diameter at the start and at the end of the loading, and how far each sphere is from its lattice point
START, END, OFF = 0.99, 0.93, 0.004
#: share of the loading that is taken back
RELIEF = 0.15


class Cost(NamedTuple):
    """Of one contact in one step of a scene: finding the overlap, the law, its memory, the forces on both spheres."""

    loading: float  # ns
    unloading: float  # ns
    loading_ratio: float  # to Hertz in the same run
    unloading_ratio: float


def costs(laws: Mapping[str, Any], edge: int = EDGE, repeats: int = REPEATS) -> dict[str, Cost]:
    """CPU time of each law in turn, several times over, the fastest of each: other work on the machine only ever adds.

    Some 2700 spheres near the points of a cubic lattice are squeezed until neighbours overlap by 7 % of their diameter, then relieved.
    """
    if numba.config.DISABLE_JIT:
        edge, repeats = 3, 1
    field = {"": Hertz(1.0, 100.0), **laws}
    best = {name: np.full(2, np.inf) for name in field}
    scenes = {name: _scene(law, edge) for name, law in field.items()}
    for _ in range(repeats):
        for name in field:
            best[name] = np.minimum(best[name], _timed(scenes[name]))
    return {name: Cost(*best[name].tolist(), *(best[name] / best[""]).tolist()) for name in laws}


def _scene(law: Any, edge: int) -> Working:
    """The spheres and their pairs; the law's own radius, so that its overlaps are those it was fitted for."""
    spacing = 2.0 * START * law.radius
    random = np.random.default_rng(0)
    points = np.stack(np.meshgrid(*3 * (np.arange(edge),), indexing="ij"), axis=-1).reshape(-1, 3) * spacing
    points = points + OFF * law.radius * random.uniform(-1.0, 1.0, points.shape)
    length = edge * spacing
    bodies, box = dem.spheres(points, law.radius, 1.0), dem.Box((length, length, length))
    return working(dem.Scene(bodies, box, dem.Contact(law), (dem.hold(1.0),), skin=0.025))


def _timed(scene: Working) -> FloatArray:
    """Nanoseconds per contact and step, loading and unloading."""
    memory = scene.groups[0].past.memory
    if memory is not None:
        memory[:] = 0.0
    down = np.linspace(1.0, END / START, STEPS)
    up = down[-1] + (1.0 - down[-1]) * RELIEF * np.linspace(0.05, 1.0, STEPS)
    return np.array([_pressed(scene, scales) for scales in (down, up)])


def _pressed(scene: Working, scales: FloatArray) -> float:
    spent, contacts = 0.0, 0
    start, cell = scene.bodies.position.copy(), scene.cell.copy()
    for scale in scales.tolist():
        scene.bodies.position[:], scene.cell[:] = start * scale, cell * scale
        began = time.thread_time()
        renew_forces(scene, dt=1.0)
        spent += time.thread_time() - began
        contacts += len(network(scene).first)
    scene.bodies.position[:], scene.cell[:] = start, cell
    return spent / max(contacts, 1) * 1e9
