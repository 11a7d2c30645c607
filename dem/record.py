"""What a run writes down at each output."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dem.box import Box
from dem.forces import LARGEST
from dem.measure import Energies, Network, contacts_per_sphere, coordination, energies, network, stress_tensor
from dem.scene import Scene
from dem.working import Working

FloatArray = npt.NDArray[np.float64]

#: columns of a run's table
COLUMNS = (
    *("time", "stage", "strain x", "strain y", "strain z", "shear xy", "shear xz", "shear yz"),
    *(f"stress {a}{b}" for a in "xyz" for b in "xyz"),
    *(f"fabric {a}{b}" for a in "xyz" for b in "xyz"),
    *("coordination", "coordination held", "rattlers", "packing fraction"),
    *Energies._fields,
    *("contacts beyond", "largest overlap", "time step", "steps"),
)


class Frame(NamedTuple):
    """Where everything was at one output; rows in the order of the scene's particles."""

    output: int  # which row of the trajectory
    time: float  # s
    box: Box
    id: npt.NDArray[np.int64]
    radius: FloatArray  # m, shape (n,)
    position: FloatArray  # m, shape (n, 3); not wrapped
    velocity: FloatArray  # m/s, relative to the box
    contacts: npt.NDArray[np.int64]  # of each sphere, that carry force
    pressure: FloatArray  # Pa; a third of the trace of each sphere's own stress, compression positive
    network: Network  # contacts that carry force; spheres by their row here
    axes: FloatArray | None = None  # m, half axes of ellipsoids, shape (n, 3)
    orientation: FloatArray | None = None  # unit quaternions (w, x, y, z), shape (n, 4)


class Beyond(NamedTuple):
    """The deepest contact that left the range its law was fitted for, at one output."""

    output: int
    first: int  # id of the sphere
    second: int | None  # id of the other; None: a wall
    depth: float  # overlap of one body over its radius
    position: tuple[float, float, float]  # m, of the first


def observe(scene: Scene, work: Working, reference: Box, step: float) -> tuple[dict[str, float], Network]:
    """The columns that a state decides (not time, stage and steps), and its contacts. `reference` is the box that strain counts from."""
    found = network(work)
    mean, held, rattlers = coordination(found, work.size)
    stress, box = stress_tensor(work), work.box
    stretch = np.linalg.inv(reference.cell) @ box.cell
    values = {f"strain {a}": 1.0 - box.lengths[i] / reference.lengths[i] for i, a in enumerate("xyz")}
    values |= {f"shear {'xyz'[j]}{'xyz'[i]}": stretch[i, j] / stretch[j, j] for i, j in ((1, 0), (2, 0), (2, 1))}
    values |= {f"stress {a}{b}": stress[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
    values |= {f"fabric {a}{b}": found.fabric[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
    solid = float(np.sum(4.0 / 3.0 * np.pi * work.radii**3))
    values |= {"coordination": mean, "coordination held": held, "rattlers": rattlers, "packing fraction": solid / box.volume}
    values |= dict(zip(Energies._fields, energies(work), strict=True))
    values |= {"contacts beyond": int((found.depth > limits(scene, work)[found.group]).sum()), "time step": step}
    return values | {"largest overlap": float(work.tally[:, LARGEST].max())}, found


def limits(scene: Scene, work: Working) -> FloatArray:
    """Per group the overlap of one body over its radius up to which the law was fitted; infinite where that is not known."""
    fitted = (kind.contact.fitted_overlap for kind in work.kinds)
    return np.array([math.inf if limit is None else limit for limit in fitted])


def deepest_beyond(scene: Scene, work: Working, found: Network, output: int) -> Beyond | None:
    """The contact that is farthest outside its law's range, None if all are within."""
    excess = found.depth / limits(scene, work)[found.group]
    if not len(excess) or excess.max() <= 1.0:
        return None
    row = int(excess.argmax())
    own = scene.particles.id[work.order]
    i, j = int(found.first[row]), int(found.second[row])
    x, y, z = work.bodies.position[i].tolist()
    return Beyond(output, int(own[i]), int(own[j]) if j >= 0 else None, float(found.depth[row]), (x, y, z))


def pressures(work: Working, found: Network) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Contacts of each sphere, and a third of the trace of its own stress in Pa; two spheres share a contact's by halves."""
    trace = np.asarray((found.branch * found.force).sum(axis=1))
    inner = found.second >= 0
    own = np.bincount(found.first, np.where(inner, 0.5, 1.0) * trace, work.size)
    own += np.bincount(found.second[inner], 0.5 * trace[inner], work.size)
    return contacts_per_sphere(found, work.size), own / (4.0 * np.pi * work.radii**3)


def in_scene_order(work: Working, rows: np.ndarray) -> np.ndarray:
    """Per-particle rows in the order of the scene."""
    back = np.empty_like(rows)
    back[work.order] = rows
    return back
