"""The arrays a run works in, and how they go forward in time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch, pair
from dem.box import Box
from dem.forces import LOST_ENERGY, TALLIES, pair_forces
from dem.motion import Deformation, advance, lengths_at
from dem.neighbours import PairList, carried_over, cell_order, neighbours
from dem.particles import Particles

FloatArray = npt.NDArray[np.float64]


class Working(NamedTuple):
    """State of a run. The kernels change the arrays in place; a new pair list makes a new record. Rows are sorted by cells: see `order`."""

    position: FloatArray  # m; never wrapped
    velocity: FloatArray  # m/s; relative to the box
    mass: FloatArray  # kg
    radius: FloatArray | None  # m; None: all are `one_radius`
    one_radius: float  # m
    widest: float  # m; the largest radius
    periodic: tuple[bool, bool, bool]
    order: npt.NDArray[np.int64]  # row k here is row order[k] of the scene's particles
    force: FloatArray  # N
    virial: FloatArray  # J; see forces.pair_forces
    tally: FloatArray  # see forces
    pairs: PairList
    memory: FloatArray | None  # per pair; None: the law has none
    magnitude: FloatArray  # N, per pair

    @property
    def radii(self) -> FloatArray:
        """Every radius in m."""
        return np.full(len(self.mass), self.one_radius) if self.radius is None else self.radius


def working(law: object, bodies: Particles, box: Box, skin: float) -> Working:
    """Arrays sorted by cells, so that neighbours in space are neighbours in memory (once, at the start: a dense packing hardly mixes)."""
    order = cell_order(bodies.position, bodies.radii)
    radii, count = bodies.radii[order], bodies.size
    pairs = neighbours(bodies.position[order], radii, box, skin)
    floats = dispatch.floats_of_state(law)
    work = Working(
        position=bodies.position[order],
        velocity=bodies.velocity[order],
        mass=bodies.mass[order],
        radius=None if np.ndim(bodies.radius) == 0 else radii,
        one_radius=float(radii[0]) if count else 1.0,
        widest=float(radii.max(initial=0.0)),
        periodic=box.periodic,
        order=order,
        force=np.zeros((count, 3)),
        virial=np.zeros(6),
        tally=np.zeros(TALLIES),
        pairs=pairs,
        memory=np.zeros((len(pairs.partner), floats)) if floats else None,
        magnitude=np.zeros(len(pairs.partner)),
    )
    motion = (work.position, work.velocity, work.radius, work.one_radius, pairs.lengths, np.zeros(3), 0.0)
    contacts = (pairs.start, pairs.partner, pairs.image, pairs.images, work.memory, work.magnitude)
    pair_forces(law, *motion, *contacts, work.force, work.virial, work.tally)
    return work


def follow(law: object, work: Working, deformation: Deformation, step: int, steps: int) -> tuple[Working, int]:
    """Take `steps` steps of a stage from number `step` on; return the state and how many new pair lists it took.

    Stops early, with positions that are not finite, if the motion diverges.
    """
    end, drifted, lists = step + steps, False, 0
    while step < end:
        step, drifted = advance(
            law, deformation, step, end - step, drifted, work.position, work.velocity, work.mass, work.radius, work.one_radius, work.widest,
            work.pairs, work.memory, work.magnitude, work.force, work.virial, work.tally,
        )  # fmt: skip
        if not np.isfinite(work.position).all():
            break
        if drifted:
            work, lists = _relisted(law, work, lengths_at(deformation, step + 1)), lists + 1
    return work, lists


def _relisted(law: object, work: Working, lengths: FloatArray) -> Working:
    """The same state with a new pair list in a box of these edges; the memory of every contact goes along."""
    x, y, z = (float(length) for length in lengths)
    pairs = neighbours(work.position, work.radii, Box((x, y, z), work.periodic), work.pairs.skin)
    memory = work.memory
    if memory is not None:
        fresh, homeless = carried_over(work.pairs, memory, pairs)
        work.tally[LOST_ENERGY] += sum(_ended(law, work, memory[row], row) for row in homeless)
        memory = fresh
    return work._replace(pairs=pairs, memory=memory, magnitude=np.zeros(len(pairs.partner)))


def _ended(law: object, work: Working, memory: FloatArray, row: int) -> float:
    """Energy in J used up by a contact that has moved apart by more than the skin within one step."""
    i, j = work.pairs.first[row], work.pairs.partner[row]
    scale = pair.pair_scale(law, work.radii[i], work.radii[j])
    return sum(pair.pair_energy(law, scale, 0.0, dispatch.load_state(law, memory.reshape(1, -1), 0)))


def largest_overlap(work: Working) -> float:
    """Deepest overlap in m of any pair; 0 if nothing touches."""
    pairs = work.pairs
    if not len(pairs.partner):
        return 0.0
    first, second = pairs.first, pairs.partner
    between = work.position[second] + pairs.images[pairs.image] * pairs.lengths - work.position[first]
    reach = work.radii[first] + work.radii[second]
    return max(0.0, float(np.max(reach - np.linalg.norm(between, axis=1))))


def arrays_of(work: Working) -> dict[str, np.ndarray]:
    """Everything that changes, by name, for a checkpoint."""
    names = ("position", "velocity", "order", "force", "virial", "tally", "magnitude", *(() if work.memory is None else ("memory",)))
    listed = {f"pairs_{name}": np.asarray(value) for name, value in work.pairs._asdict().items()}
    return {name: getattr(work, name) for name in names} | listed


def with_arrays(work: Working, arrays: dict[str, np.ndarray]) -> Working:
    """The state that `arrays_of` took apart."""
    pairs = PairList(**{name: arrays[f"pairs_{name}"] for name in PairList._fields if name != "skin"}, skin=float(arrays["pairs_skin"]))
    changed: dict[str, Any] = {name: arrays[name] for name in ("position", "velocity", "order", "force", "virial", "tally", "magnitude")}
    return work._replace(pairs=pairs, memory=arrays.get("memory"), **changed)
