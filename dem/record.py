"""What is written down at each output, and the trajectory made of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dem.box import Box
from dem.forces import BOUNDARY_WORK, DAMPED_ENERGY, LARGEST_OVERLAP, LOST_ENERGY, audit
from dem.measure import coordination, kinetic_energy, stress_tensor
from dem.working import Working

FloatArray = npt.NDArray[np.float64]

#: one row per output
COLUMNS = (
    *("time", "stage", "strain x", "strain y", "strain z"),
    *(f"stress {a}{b}" for a in "xyz" for b in "xyz"),
    *("coordination", "coordination held", "rattlers", "packing fraction"),
    *("kinetic", "stored", "dissipated", "damped", "boundary work", "contacts beyond", "largest overlap"),
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


def observe(
    law: object, work: Working, box: Box, reference: Box, limit: float
) -> tuple[dict[str, float], npt.NDArray[np.int64], FloatArray]:
    """The columns that a state decides (not time and stage), and per sphere the contacts and the pressure in Pa.

    `reference` is the box that strain counts from, `limit` the overlap of one body over its radius up to which the law was fitted.
    """
    pairs, count = work.pairs, len(work.mass)
    contacts, pressure = np.zeros(count, np.int64), np.zeros(count)
    lists = (pairs.start, pairs.partner, pairs.image, pairs.images, work.memory, work.magnitude)
    stored, dissipated, beyond = audit(
        law, work.position, work.radius, work.one_radius, np.array(box.lengths), *lists, limit, contacts, pressure
    )
    solid = 4.0 / 3.0 * np.pi * work.radii**3
    mean, held, rattlers = coordination(pairs, work.magnitude)
    stress = stress_tensor(work.virial, work.velocity, work.mass, box.volume)
    strain = [1.0 - now / then for now, then in zip(box.lengths, reference.lengths, strict=True)]
    values = {f"strain {a}": value for a, value in zip("xyz", strain, strict=True)}
    values |= {f"stress {a}{b}": stress[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
    values |= {"coordination": mean, "coordination held": held, "rattlers": rattlers, "packing fraction": float(solid.sum()) / box.volume}
    values |= {"kinetic": kinetic_energy(work.velocity, work.mass), "stored": stored, "dissipated": dissipated + work.tally[LOST_ENERGY]}
    values |= {"boundary work": work.tally[BOUNDARY_WORK], "damped": work.tally[DAMPED_ENERGY]}
    values |= {"contacts beyond": beyond, "largest overlap": work.tally[LARGEST_OVERLAP]}
    return values, contacts, pressure / (3.0 * solid)


def in_scene_order(work: Working, rows: np.ndarray) -> np.ndarray:
    """Per-particle rows in the order of the scene."""
    back = np.empty_like(rows)
    back[work.order] = rows
    return back
