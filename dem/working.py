"""The arrays a run works in, and how they go forward in time."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from contactlaws import dispatch, pair, shaped
from dem.box import Box
from dem.ellipsoid_forces import AXIS, BEFORE, FREE, OF_LAW, PUSH, REACH, ellipsoid_forces
from dem.forces import LOST, PRESSED, TALLIES, Bodies, Frame, Past, Roles, Rows, pair_forces
from dem.laws import in_time, known_law
from dem.motion import Deformation, Listed, advance
from dem.neighbours import cell_order, codes_of, neighbours, rows_before
from dem.rotation import Shapes, shapes_of
from dem.scene import Contact, Scene
from dem.step import all_forces

FloatArray = npt.NDArray[np.float64]


class Group(NamedTuple):
    """All pairs whose contacts share their physics."""

    roles: Roles
    rows: Rows
    past: Past

    @property
    def memory(self) -> FloatArray | None:
        """What contacts remember by their law, one row each, however it is kept."""
        memory = self.past.memory
        return memory if memory is None or self.roles.blocks is None else memory.T


class Kind(NamedTuple):
    """Which spheres a group is of: two kinds, or one and the walls."""

    first: int
    second: int | None  # None: the walls
    contact: Contact


class Working(NamedTuple):
    """State of a run. The kernels change the arrays in place; a new pair list makes a new record. Rows are sorted by cells: see `order`."""

    bodies: Bodies
    kind: npt.NDArray[np.int64] | None  # of each sphere; None: all are of kind 0
    periodic: tuple[bool, bool, bool]
    order: npt.NDArray[np.int32]  # row k here is row order[k] of the scene's particles
    cell: FloatArray  # m; the edge vectors
    old: FloatArray  # m; one step earlier
    begun: FloatArray  # the edge vectors in m that stretch counts from, and the stress in Pa with which the stage began; shape (2, 3, 3)
    walls: FloatArray  # see forces.Frame
    kinds: tuple[Kind, ...]  # of each group
    groups: tuple[Group, ...]
    listed: Listed
    force: FloatArray  # N, shape (threads, n, 3)
    torque: FloatArray  # N m, the same; (threads, 0, 3) without spins
    virial: FloatArray  # J, shape (threads, 3, 3); see forces.pair_forces
    reaction: FloatArray  # N, on walls, shape (threads, w, 3)
    tally: FloatArray  # shape (threads, TALLIES), see forces
    shapes: Shapes | None = None  # None: all are spheres

    @property
    def size(self) -> int:
        """Number of spheres."""
        return len(self.bodies.position)

    @property
    def radii(self) -> FloatArray:
        """Every radius in m, of an ellipsoid the mean one."""
        return np.full(self.size, self.bodies.one_radius) if self.bodies.radius is None else self.bodies.radius

    @property
    def reaches(self) -> FloatArray:
        """How far in m each body goes from its centre at most."""
        return self.radii if self.shapes is None else self.shapes.surface[:, REACH]

    @property
    def masses(self) -> FloatArray:
        """Every mass in kg."""
        return np.full(self.size, self.bodies.one_mass) if self.bodies.mass is None else self.bodies.mass

    @property
    def box(self) -> Box:
        """The box as it is."""
        return Box((1.0, 1.0, 1.0), self.periodic).with_cell(self.cell)

    @property
    def bytes_used(self) -> int:
        """By all arrays that last from step to step."""
        arrays = [*arrays_of(self).values(), self.order]
        return sum(array.nbytes for array in arrays)


def needs_rates(contact: Contact) -> bool:
    """Whether anything asks how fast surfaces move on each other."""
    return contact.tangential is not None or contact.damping is not None or in_time(contact.normal)


def kinds_of(scene: Scene) -> tuple[Kind, ...]:
    """The groups of pairs of a scene: those of the same physics, and each kind of particle on the walls."""
    pairs = itertools.combinations_with_replacement(range(scene.kinds), 2)
    kinds = [Kind(one, other, scene.contact_between(one, other)) for one, other in pairs]
    if any(scene.walls):
        kinds += [Kind(one, None, scene.contact_with_wall(one)) for one in range(scene.kinds)]
    return tuple(kinds)


def turns(scene: Scene) -> bool:
    """Whether the bodies of a scene have spins."""
    bodies = scene.particles
    asked = bodies.axes is not None or bodies.spin is not None or "rotation" in scene.carry
    return asked or any(kind.contact.tangential is not None for kind in kinds_of(scene))


def walls_of(scene: Scene) -> FloatArray:
    """The walls of a scene at its start, as in `forces.Frame`."""
    open_ones = [a for a in range(3) if scene.walls[a]]
    return np.array([[a, s, 0.0 if s > 0 else scene.box.lengths[a], 0.0] for a in open_ones for s in (1.0, -1.0)]).reshape(-1, 4)


def working(scene: Scene) -> Working:
    """Arrays sorted by cells, so that neighbours in space are neighbours in memory (once, at the start: a dense packing hardly mixes)."""
    bodies, count, kinds = scene.particles, scene.particles.size, kinds_of(scene)
    order, round_ones = cell_order(bodies.position, bodies.radii), bodies.axes is None
    radii, masses = bodies.radii[order], scene.masses[order]
    one_mass = count == 0 or bool(np.all(masses == masses[0]))
    spin = np.zeros((count, 3)) if bodies.spin is None else bodies.spin[order].astype(float)
    many = not round_ones or np.ndim(bodies.radius) > 0 or "radius" in scene.carry
    walls, turning = walls_of(scene), turns(scene)
    shapes = None
    if bodies.axes is not None and bodies.orientation is not None:
        shapes = shapes_of(bodies.axes[order], bodies.orientation[order], masses, spin)
    threads, skin, widest = scene.threads, scene.skin, float((radii if shapes is None else shapes.surface[:, REACH]).max(initial=0.0))
    work = Working(
        bodies=Bodies(
            position=bodies.position[order],
            velocity=bodies.velocity[order],
            spin=spin if turning else None,
            radius=radii.copy() if many else None,
            one_radius=float(radii[0]) if count else 1.0,
            mass=None if one_mass and "mass" not in scene.carry else masses,
            one_mass=float(masses[0]) if count else 1.0,
        ),
        kind=None if bodies.kind is None else bodies.kind[order],
        periodic=scene.box.periodic,
        order=order.astype(np.int32),
        cell=scene.box.cell,
        old=scene.box.cell,
        begun=np.stack([scene.box.cell, np.zeros((3, 3))]),
        walls=walls,
        kinds=kinds,
        groups=tuple(_new_group(kind.contact, bool(many), kind.second is None, scene.carry) for kind in kinds),
        listed=Listed(np.zeros((count, 3)), scene.box.cell, np.zeros((0, 3)), 2.0 * widest * skin, 2.0 * widest),
        force=np.zeros((threads, count, 3)),
        torque=np.zeros((threads, count if turning else 0, 3)),
        virial=np.zeros((threads, 3, 3)),
        reaction=np.zeros((threads, len(walls), 3)),
        tally=np.zeros((threads, TALLIES)),
        shapes=shapes,
    )
    work = relisted(work)
    renew_forces(work)
    return work


def renew_forces(work: Working, gradient: FloatArray | None = None, dt: float = 0.0) -> None:
    """Compute the forces of the state as it is, `dt` (s) after they were computed last, in a box of this velocity gradient (1/s)."""
    images = work.listed.images
    frame = Frame(images @ work.cell, np.zeros_like(images), np.zeros((3, 3)) if gradient is None else gradient, work.walls)
    sums = (work.force, work.torque, work.virial, work.reaction, work.tally)
    all_forces(threaded(work), work.groups, work.bodies, work.shapes, frame, dt, *sums)


def _new_group(contact: Contact, many: bool, wall: bool, carry: tuple[str, ...]) -> Group:
    """A group without pairs: its arrays tell what its contacts will remember."""
    rates = True if needs_rates(contact) or "rates" in carry else None
    slides = contact.tangential is not None
    if shaped.is_shaped(contact.normal):
        blocks: bool | None = True
        floats = OF_LAW + len(known_law(contact.normal).memory)
    else:
        floats, blocks = dispatch.floats_of_state(contact.normal), None if dispatch.law_of(contact.normal).block is None else True
    past = Past(
        memory=np.zeros((floats, 0) if blocks else (0, floats)) if floats else None,
        slip=np.zeros((4, 0)) if slides else None,
        roll=np.zeros((3, 0)) if slides and contact.rolling is not None else None,
        damping=np.zeros(0) if contact.damping is not None else None,
    )
    nobody = np.zeros(0, np.uint32)
    roles = Roles(contact.normal, contact.tangential, contact.rolling, contact.damping, contact.share, rates, blocks)
    return Group(roles, Rows(nobody, nobody, None if wall else np.zeros(0, np.uint16)), past)


def threaded(work: Working) -> bool | None:
    """Whether the kernels run on several threads, and see to it that numba has as many; None: no."""
    if len(work.force) == 1:
        return None
    if not numba.config.DISABLE_JIT:
        numba.set_num_threads(len(work.force))
    return True


def follow(work: Working, deformation: Deformation, step: int, steps: int, moving_walls: float = 0.0) -> tuple[Working, int]:
    """Take `steps` steps of a stage from number `step` on; return the state and how many new pair lists it took.

    Stops early, with positions that are not finite, if the motion diverges.
    """
    end, drifted, lists = step + steps, False, 0
    while step < end:
        step, drifted = advance(
            threaded(work), work.shapes, work.groups, deformation, step, end - step, drifted,
            work.bodies, work.cell, work.old, work.listed, work.walls, moving_walls,
            work.force, work.torque, work.virial, work.reaction, work.tally,
        )  # fmt: skip
        if not np.isfinite(work.bodies.position).all():
            break
        if drifted:
            work, lists = relisted(work), lists + 1
    return work, lists


def relisted(work: Working) -> Working:
    """The same state with a new pair list for the box as it is; what contacts remember goes along."""
    bodies, reaches, skin = work.bodies, work.reaches, work.listed.skin
    pairs = neighbours(bodies.position, reaches, work.box, skin)
    images = np.concatenate([[[0, 0, 0]], pairs.images])  # the first for walls
    groups = []
    for kind, group in zip(work.kinds, work.groups, strict=True):
        if kind.second is None:
            first, partner = _near_walls(work, reaches, skin)
            chosen = np.ones(len(first), bool) if work.kind is None else work.kind[first] == kind.first
            image = np.zeros(len(first), np.int64)
        else:
            first, partner, image = pairs.first, pairs.partner, pairs.image + 1
            chosen = np.ones(len(first), bool)
            if work.kind is not None:
                ends = np.stack([work.kind[first], work.kind[partner]])
                chosen = (ends.min(axis=0) == kind.first) & (ends.max(axis=0) == kind.second)
        new = (first[chosen], partner[chosen], image[chosen])
        groups.append(_carried_over(work, group, new, images))
    listed = Listed(bodies.position.copy(), work.cell.copy(), images.astype(float), skin, work.listed.reach)
    if work.shapes is not None:
        work.shapes.turned[:] = 0.0  # with what is counted from it, in `_carried_over`
    return work._replace(groups=tuple(groups), listed=listed)


def _near_walls(work: Working, reaches: FloatArray, skin: float) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """The spheres within the skin of a wall, and the walls."""
    near = [
        np.flatnonzero(side * (work.bodies.position[:, int(axis)] - place) - reaches <= skin)
        for axis, side, place, _ in work.walls.tolist()
    ]
    return np.concatenate(near), np.repeat(np.arange(len(near)), [len(rows) for rows in near])


def _carried_over(work: Working, group: Group, new: tuple[Any, Any, Any], images: npt.NDArray[np.int64]) -> Group:
    """The group with the pairs `new` (first, partner, row of the images), its memory moved to where its contacts now stand."""
    first, partner, image = new
    rows, past = group.rows, group.past
    if not any(array is not None for array in past):
        kept = past
    else:
        old_image = np.zeros(len(rows.first), np.int64) if rows.image is None else rows.image.astype(np.int64)
        old_images = work.listed.images.astype(np.int64) if len(work.listed.images) else images
        before = (rows.first.astype(np.int64), rows.partner.astype(np.int64), codes_of(old_images)[old_image])
        source = rows_before(before, (first, partner, codes_of(images)[image]), max(work.size, len(work.walls)))
        there = source >= 0
        if (memory := group.memory) is not None:
            used = memory if work.shapes is None else memory[:, BEFORE:]
            homeless = np.setdiff1d(np.flatnonzero(used.any(axis=1)), source[there])
            if work.shapes is None:
                work.tally[0, LOST] += sum(_ended(work, group, row) for row in homeless)
            else:
                work.tally[0, PRESSED] -= 0.5 * float(np.sum(memory[homeless, PUSH] * memory[homeless, BEFORE]))
        kept = Past(*(None if array is None else _moved(array, source, there, array is group.memory) for array in past))
        if work.shapes is not None and kept.memory is not None:
            kept.memory[FREE] = 0.0
            kept.memory[AXIS : AXIS + 3, ~there] = _centre_lines(work, first[~there], partner[~there], images[image[~there]], rows.image)
    number = np.uint16 if len(images) <= np.iinfo(np.uint16).max else np.uint32  # of images: spheres may be anywhere in space
    listed = None if rows.image is None else image.astype(number)
    return group._replace(rows=Rows(first.astype(np.uint32), partner.astype(np.uint32), listed), past=kept)


def _centre_lines(work: Working, first: Any, partner: Any, images: npt.NDArray[np.int64], listed: Any) -> FloatArray:
    """Unit vectors from the first to the second centre, shape (3, m): where the search for a common normal starts; of walls nothing."""
    if listed is None:
        return np.zeros((3, len(first)))
    branch = (work.bodies.position[partner] - work.bodies.position[first] + images @ work.cell).T
    length = np.linalg.norm(branch, axis=0)
    return np.where(length > 0.0, branch / np.maximum(length, np.finfo(float).tiny), [[0.0], [0.0], [1.0]])


def _moved(array: FloatArray, source: npt.NDArray[np.int64], there: npt.NDArray[np.bool_], in_rows: bool) -> FloatArray:
    """What pairs remember, in their new rows (or columns); zero for new pairs."""
    along = 0 if in_rows else array.ndim - 1
    shape = list(array.shape)
    shape[along] = len(source)
    moved = np.zeros(shape)
    if along == 0:
        moved[there] = array[source[there]]
    else:
        moved[:, there] = array[:, source[there]]
    return moved


def _ended(work: Working, group: Group, row: int) -> float:
    """Energy in J used up by a contact that has moved apart by more than the skin within one step."""
    law, share, radii = group.roles.normal, group.roles.share, work.radii
    i, j = group.rows.first[row], group.rows.partner[row]
    scale = pair.wall_scale(law, radii[i]) if group.rows.image is None else pair.pair_scale(law, radii[i], radii[j], share)
    return sum(pair.pair_energy(law, scale, 0.0, dispatch.load_state(law, group.memory, row), share))


#: arrays of `Shapes` that change
TURNING = ("orientation", "momentum", "surface", "turned")
#: arrays of the state itself
OWN = ("cell", "old", "begun", "walls", "force", "torque", "virial", "reaction", "tally")


def arrays_of(work: Working) -> dict[str, np.ndarray]:
    """Everything that changes, by name, for a checkpoint."""
    arrays: dict[str, Any] = {name: getattr(work, name) for name in OWN}
    arrays |= {f"body_{name}": value for name, value in work.bodies._asdict().items() if isinstance(value, np.ndarray)}
    if work.shapes is not None:
        arrays |= {f"shape_{name}": getattr(work.shapes, name) for name in TURNING}
    arrays |= {f"list_{name}": getattr(work.listed, name) for name in ("position", "cell", "images")}
    for number, group in enumerate(work.groups):
        arrays |= {
            f"group{number}_{name}": value for name, value in (group.rows._asdict() | group.past._asdict()).items() if value is not None
        }
    return arrays


def with_arrays(work: Working, arrays: dict[str, np.ndarray]) -> Working:
    """The state that `arrays_of` took apart; `work` is a state of the same scene."""

    def those(prefix: str) -> dict[str, Any]:
        return {name.removeprefix(prefix): value for name, value in arrays.items() if name.startswith(prefix)}

    bodies, listed = work.bodies._replace(**those("body_")), work.listed._replace(**those("list_"))
    shapes = None if work.shapes is None else work.shapes._replace(**those("shape_"))
    groups = []
    for number, group in enumerate(work.groups):
        own = those(f"group{number}_")
        rows = Rows(own["first"], own["partner"], own.get("image"))
        groups.append(group._replace(rows=rows, past=Past(*(own.get(name) for name in Past._fields))))
    changed: dict[str, Any] = {name: arrays[name] for name in OWN}
    return work._replace(bodies=bodies, listed=listed, groups=tuple(groups), shapes=shapes, **changed)


def forces_between(work: Working) -> list[FloatArray]:
    """The force in N on the second sphere of every pair (or on the wall), shape (m, 3), per group; the state stays as it is."""
    found = []
    frame = Frame(work.listed.images @ work.cell, np.zeros_like(work.listed.images), np.zeros((3, 3)), work.walls)
    for group in work.groups:
        roles, rows = group.roles, group.rows
        past = Past(*(None if array is None else array.copy() for array in group.past))
        network = np.zeros((len(rows.first), 3))
        sums = (np.zeros_like(work.force[0]), np.zeros_like(work.torque[0]), np.zeros((3, 3)), np.zeros_like(work.reaction[0]))
        span, tally = (0, len(rows.first)), np.zeros(TALLIES)
        if work.shapes is None:
            pair_forces(*roles, *rows, *past, *work.bodies, frame, 0.0, span, *sums, network, tally)
        else:
            physics = (roles.normal, roles.tangential, roles.damper, roles.share, roles.rates)
            b, s = work.bodies, work.shapes
            places = (b.position, b.velocity, b.spin, b.radius, b.mass, b.one_mass, s.surface, s.turned)
            ellipsoid_forces(*physics, *rows, past.memory, past.slip, past.damping, *places, frame, 0.0, span, *sums, network, tally)
        found.append(network)
    return found
