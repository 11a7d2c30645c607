"""LAMMPS as the engine of a scene: it decomposes the box, lists neighbours, integrates, and keeps and saves what contacts remember.

It is talked to by its commands and its library's functions. Every rank of an MPI run makes the same calls; what is asked of the whole is
the same on each of them.

A step: LAMMPS kicks half, drifts, brings ghosts or lists up to date, and calls back for forces; then it kicks the other half and moves the
box for the next step, with the spheres in it. So positions go as x F + v dt in the box that belongs to them, as in `dem.motion`; what that
needs of velocities (v F^-1, the drag) is done in the callback, which also says where the box goes, by the functions of `dem.motion`. Before
an interval LAMMPS sets itself up anew: the first kick and the first move of the box are made here, with the last forces, and LAMMPS starts
with none.

A box that does not carry the spheres along moves their images. LAMMPS moves a sphere that it has wrapped by its own speed alone, so the
callback takes it along with the image that it is, and velocities are those of the spheres on their way without jumps.

LAMMPS knows nothing of walls. Along their axis its box has room beyond them, more than any contact reaches across.
"""

from __future__ import annotations

import math
import os
import sys
import time
import traceback
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.errors import InputError, Problem, require
from dem import lammps_forces, lammps_list
from dem.box import wrapped
from dem.lammps_forces import CLOCK, FORCE, LARGEST, LEANED, OVERLAP, PLACE, PRESSED, REMEMBERED, ROUGH, SLOTS, SMOOTH, SUMS, TORQUE
from dem.lammps_library import SILENT, library
from dem.lammps_scope import leans, lowest_height, needed_height, problems_with
from dem.motion import Deformation, carried_along, moved_walls, next_cell, strain_of
from dem.requirements import SERVO_STRAIN
from dem.scene import Scene
from dem.working import Kind, kinds_of, needs_rates, turns, walls_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

#: spheres handed to LAMMPS, or asked for, at a time
HANDFUL = 100_000
#: what LAMMPS calls an edge of the box, and its leaning
EDGES = {(0, 0): "x", (1, 1): "y", (2, 2): "z", (1, 0): "xy", (2, 0): "xz", (2, 1): "yz"}
#: reaches of contacts that LAMMPS's box has beyond a wall
ROOM = 2.0
#: powers of two between the virial that makes edges go their fastest and the unit it is summed in; 2^23 times that virial is still exact
UNITS = 30
#: of a box that does not move
STILL, NOTHING = np.eye(3), np.zeros((3, 3))


class Snapshot(NamedTuple):
    """All spheres in the order of their numbers, 1 to n."""

    position: FloatArray  # m, as in the scene, from the lower corner of a box that carries the spheres along; not wrapped; shape (n, 3)
    velocity: FloatArray  # m/s, relative to the box, shape (n, 3)
    spin: FloatArray  # 1/s, shape (n, 3)
    partner: IntArray  # number of the other sphere of each slot, 0: free, -1: the first wall, and so on; shape (n, SLOTS)
    memory: FloatArray  # shape (n, SLOTS, columns)
    sums: FloatArray  # shape (n, SUMS or more)


class _Spheres(NamedTuple):
    """This rank's arrays, in LAMMPS's memory: they hold until it makes new lists. Its own spheres come first, then the ghosts."""

    tag: IntArray
    kind: IntArray
    position: FloatArray
    velocity: FloatArray
    spin: FloatArray
    radius: FloatArray
    mass: FloatArray
    torque: FloatArray  # of its own alone, as all that follow
    partner: IntArray  # one row per slot
    memory: FloatArray
    sums: FloatArray


class _List(NamedTuple):
    """The pairs of one of the scene's kinds of contacts."""

    pairs: lammps_list.Pairs
    out: FloatArray  # what each gives, see `lammps_forces`
    images: FloatArray | None  # by how many edges the second lies off, shape (m, 3); None: the box carries the spheres along


class Agreed(NamedTuple):
    """The same on all ranks."""

    depth: float  # largest overlap of one body over its radius so far, infinite if the motion diverged
    overlap: float  # m; the deepest there is
    clock: float  # s since the first rank began


class Engine:
    """A running LAMMPS. `close` ends it."""

    def __init__(self, scene: Scene, cell: FloatArray, walls: FloatArray) -> None:
        """An empty one for the spheres of a scene, in a box of edge vectors `cell` (m) with `walls` as in `forces.Frame`."""
        self._lmp = library().lammps(cmdargs=list(SILENT))
        bodies = scene.particles
        widest = float(bodies.radii.max())
        self._scene, self._skin, self._reach = scene, 2.0 * widest * scene.skin, 2.0 * widest
        self._kinds = kinds_of(scene)
        self._rates = tuple(True if needs_rates(kind.contact) else None for kind in self._kinds)
        self._turning = True if turns(scene) else None
        self._floats = max(1, *(dispatch.floats_of_state(kind.contact.normal) for kind in self._kinds))
        self._columns = self._floats + (REMEMBERED if any(self._rates) else 0)
        self._walled = True if not scene.affine and len(walls) else None  # whether nothing but walls moves
        self._jumping = not scene.affine and not len(walls)  # whether images move by themselves
        self._leaning = True if leans(scene) else None
        self._sums = SUMS + (3 if self._leaning or self._walled else 0)
        self._controlled = any(stage.follows_stress for stage in scene.programme)
        self._cell = self._before = cell.copy()  # where forces are computed; and a step earlier
        self.walls = walls.copy()
        self._interval: Deformation | None = None  # None: no forces are asked for
        self._first = 0  # number of the step before the interval
        self._moved: list[tuple[int, int]] = []  # edges, and their leanings, that change in the interval
        self._changes: list[tuple[str, int, int]] = []  # of these, what LAMMPS changes, with the name of its variable
        self._following = False  # whether a stress is followed in the interval
        self._lists: list[_List] | None = None
        self._failed: BaseException | None = None
        self._began = time.monotonic()

    @classmethod
    def of_scene(cls, scene: Scene) -> Engine:
        """The spheres of a scene as they are at its start; raises `InputError` before anything is made."""
        require(problems_with(scene))
        bodies, here = scene.particles, scene.box.cell
        engine = cls(scene, here, walls_of(scene))
        low, high = engine._faces(here)
        bounds = " ".join(f"{a!r} {b!r}" for a, b in zip(low.tolist(), high.tolist(), strict=True))
        style = "block"
        if engine._leaning:
            style, bounds = "prism", f"{bounds} {' '.join(map(repr, scene.box.tilt))}"
            engine._commands("box tilt large")
        engine._commands("units si", "atom_style sphere", "atom_modify map array", "newton off", "boundary p p p")
        engine._commands(f"region box {style} {bounds} units box", f"create_box {scene.kinds} box")
        engine._declare()
        order = np.argsort(bodies.id)
        inside = wrapped(bodies.position, scene.box)[order]
        kind = np.ones(bodies.size, np.int64) if bodies.kind is None else bodies.kind[order] + 1
        for start in range(0, bodies.size, HANDFUL):
            some = slice(start, start + HANDFUL)
            number, rest = bodies.id[order][some].tolist(), (inside[some], bodies.velocity[order][some])
            engine._lmp.create_atoms(len(number), number, kind[some].tolist(), *(rows.ravel().tolist() for rows in rest))
        own = engine._own("id") - 1
        engine._own("radius")[:] = bodies.radii[order][own]
        engine._own("rmass")[:] = scene.masses[order][own]
        if bodies.spin is not None:
            engine._own("omega")[:] = bodies.spin[order][own]
        if engine._jumping:
            engine._own("d2_unwrapped")[:] = bodies.position[order][own]
        engine._interval, engine._first = Deformation(here, here, 1, 0.0), -1
        engine._commands("run 0 post no")  # the forces of the beginning
        engine._raise()
        return engine

    @classmethod
    def restored(cls, path: Path, scene: Scene, cell: FloatArray, walls: FloatArray) -> Engine:
        """What `save` wrote, on any number of ranks, with what `cell` and `walls` were."""
        engine = cls(scene, cell, walls)
        engine._commands("box tilt large", "newton off", f'read_restart "{path}"')  # what was said of newton counts
        engine._declare()
        engine._commands("run 0 post no")  # only then will LAMMPS let the box be changed
        return engine

    def save(self, path: Path) -> None:
        """A LAMMPS restart file: spheres, box and what contacts remember."""
        self._commands(f'write_restart "{path}"')

    def close(self) -> None:
        """End it."""
        self._lmp.close()

    @property
    def ranks(self) -> int:
        """How many there are."""
        return int(self._lmp.extract_setting("world_size"))

    @property
    def rank(self) -> int:
        """Which this is, from 0 on."""
        return int(self._lmp.extract_setting("world_rank"))

    @property
    def cell(self) -> FloatArray:
        """The edge vectors in m."""
        return self._cell.copy()

    def follow(self, interval: Deformation) -> None:
        """Take all steps of an interval, on from the box as it is; raises what went wrong in the force."""
        self._commands("run 0 post no")  # spheres that left the box come in again before anything else, as they do when the state is saved
        self._interval, self._first, self._lists = interval, int(self._lmp.extract_global("ntimestep")), None
        within = [(i, j) for i in range(3) for j in range(i + 1)]
        self._moved = [(i, j) for i, j in within if interval.start[i, j] != interval.end[i, j] or (i == j and interval.gain[i] > 0.0)]
        self._following = any(interval.gain > 0.0)
        self._put_back()
        self._sum_exactly(interval)
        now, first = self._cell, self._next(interval, 1)
        fade = math.exp(-0.5 * interval.drag * interval.dt)
        moving = (self._own(name) for name in ("rmass", "radius", "x", "v", "omega"))
        roles, there = (self._turning, self._leaning, self._walled), (self._strain(now, now, first), self._unwrapped(), now, first)
        lammps_forces.first_kick(*roles, *moving, 0.5 * interval.dt, fade, *there, self._own("d2_sums"))
        self._move_on(interval, first)
        self._move_box(first)
        self._base, self._changes = self._size(first), [] if self._walled else [(f"change{i}{j}", i, j) for i, j in self._moved]
        for name, _, _ in self._changes:
            self._commands(f"variable {name} internal 0.0")
        if self._changes:
            self._commands("variable rate internal 0.0")
            edges = " ".join(f"{EDGES[i, j]} variable v_{name} v_rate" for name, i, j in self._changes)
            self._commands(f"fix box all deform 1 {edges} remap {'none' if self._jumping else 'x'} flip no")
        self._commands(f"timestep {interval.dt!r}", f"run {interval.steps} post no")
        if self._changes:
            self._commands("unfix box")
        if self._following:
            self._commands("uncompute whole", "uncompute shares")
        self._interval = None
        self._raise()

    def extent(self) -> dict[str, int]:
        """How many spheres are this rank's own and how many ghosts, and bytes of the arrays that this engine keeps for them.

        The arrays are what contacts remember, the sums and the lists of pairs, beside those that any LAMMPS has.
        """
        self._list()
        assert self._lists is not None
        listed = [array for one in self._lists for array in (*one.pairs, one.out)]
        kept = (*listed, self._spheres.partner, self._spheres.memory, self._spheres.sums)
        ghosts = int(self._lmp.extract_setting("nghost"))
        return {"own": len(self._spheres.sums), "ghosts": ghosts, "arrays": sum(array.nbytes for array in kept)}

    def crowded(self) -> str | None:
        """Why the box is too small for this engine, None if it is not; the same on all ranks."""
        lowest, needed = lowest_height(self._scene.box.with_cell(self._cell)), needed_height(self._scene)
        if lowest >= needed:
            return None
        return f"the box is {lowest:.4g} m across: below {needed:.4g} m a sphere may meet another twice, as engine lammps cannot tell"

    def agreed(self) -> Agreed:
        """What all ranks must know."""
        sums = self._own("d2_sums")
        lost = ~np.isfinite(self._own("x")).all(axis=1) | ~np.isfinite(self._own("v")).all(axis=1)
        sums[lost, LARGEST] = np.inf
        sums[:, CLOCK] = time.monotonic() - self._began
        wanted = (LARGEST, OVERLAP, CLOCK)
        columns = " ".join(f"d2_sums[{column + 1}]" for column in wanted)
        inputs = " ".join(f"c_own[{number + 1}]" for number in range(len(wanted)))
        self._commands(f"compute own all property/atom {columns}", f"compute agreed all reduce max {inputs}")
        found = Agreed(*self._lmp.numpy.extract_compute("agreed", 0, 1)[: len(wanted)].tolist())
        self._commands("uncompute agreed", "uncompute own")
        return found

    def snapshot(self) -> Snapshot | None:
        """All spheres, gathered on the first rank; None on the others, each of which must ask for it too."""
        count = int(self._lmp.get_natoms())

        def gathered(name: str, kind: int, columns: int) -> Any:
            gather = self._lmp.gather_subset if name[:3] in ("d2_", "i2_") else self._lmp.gather_atoms_subset
            found = np.empty((count if self.rank == 0 else 0, columns), (np.int32, np.float64)[kind])
            for start in range(0, count, HANDFUL):  # the others hold no more than a handful, and LAMMPS counts the values by 31 bits
                numbers = np.arange(start, min(start + HANDFUL, count), dtype=np.int32) + 1
                some = gather(name, kind, columns, len(numbers), np.ctypeslib.as_ctypes(numbers))
                if self.rank == 0:
                    found[start : start + len(numbers)] = np.ctypeslib.as_array(some).reshape(len(numbers), columns)
            return found

        found = Snapshot(
            position=gathered("d2_unwrapped" if self._jumping else "x", 1, 3),
            velocity=gathered("v", 1, 3),
            spin=gathered("omega", 1, 3),
            partner=gathered("i2_partner", 0, SLOTS),
            memory=gathered("d2_memory", 1, SLOTS * self._columns).reshape(-1, SLOTS, self._columns),
            sums=gathered("d2_sums", 1, self._sums),
        )
        image = gathered("image", 0, 3)
        if self.rank != 0:
            return None
        return found if self._jumping else found._replace(position=found.position - self._corner(self._cell) + image @ self._cell)

    def _raise(self) -> None:
        if self._failed is not None:
            raise self._failed

    def _commands(self, *lines: str) -> None:
        for line in lines:
            self._lmp.command(line)

    def _own(self, name: str, ghosts: bool = False) -> Any:
        """An array of LAMMPS's, the rows of this rank's own spheres, or of its ghosts too; changes go through."""
        rows = self._lmp.extract_setting("nall" if ghosts else "nlocal")
        return self._lmp.numpy.extract_atom(name, nelem=rows)

    def _unwrapped(self) -> FloatArray | None:
        """Where the own spheres are, or were a moment ago, without jumps; None where the box carries them along."""
        return self._own("d2_unwrapped") if self._jumping else None

    def _declare(self) -> None:
        """What is no part of a restart file, or must be said again to get it back."""
        self._commands(
            f"fix memory all property/atom i2_partner {SLOTS} d2_memory {SLOTS * self._columns} d2_sums {self._sums}",
            f"comm_modify vel {'yes' if any(self._rates) else 'no'}",
            f"pair_style zero {self._reach!r}",
            "pair_coeff * *",
            f"neighbor {self._skin!r} bin",
            "neigh_modify every 1 delay 0 check yes",
            f"fix motion all {'nve/sphere' if self._turning else 'nve'}",
            "fix law all external pf/callback 1 1",
        )
        if self._jumping:
            self._commands("fix ways all property/atom d2_unwrapped 3 ghost yes")
        if self._controlled:
            self._commands("fix parts all property/atom d2_shares 6")
        self._lmp.set_fix_external_callback("law", self._called, None)

    def _put_back(self) -> None:
        """Undo the round-off that LAMMPS's coordinates of a leaning box bring: how often it uses them depends on what has been saved."""
        if self._leaning:
            position, cell = self._own("x"), self._cell
            place = self._own("d2_sums")[:, PLACE : PLACE + 3]
            edges = np.rint((place - position) @ np.linalg.inv(cell))
            position[:] = place - (edges[:, :1] * cell[0] + edges[:, 1:2] * cell[1] + edges[:, 2:] * cell[2])

    def _size(self, cell: FloatArray) -> FloatArray:
        """Of LAMMPS's box, and how it leans, in m, shape (3, 3): `cell` with room beyond walls, which it does not know."""
        size = cell.copy()
        for axis in range(3) if len(self.walls) else ():
            if self._scene.walls[axis]:
                start, most = self._scene.box.lengths[axis], max(stage.stretch[axis] for stage in self._scene.programme)
                if self._walled:  # it stays as it is, and each of the walls may take all that the edge gains
                    size[axis, axis] = start * (2.0 * max(most, 1.0 + SERVO_STRAIN) - 1.0) + 2.0 * ROOM * self._reach
                else:
                    size[axis, axis] *= 1.0 + 2.0 * ROOM * self._reach / start
        return size

    def _faces(self, cell: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of LAMMPS's box, in m: it keeps its middle, that of the scene's box."""
        middle, half = 0.5 * np.array(self._scene.box.lengths), 0.5 * self._size(cell).diagonal()
        return middle - half, middle + half

    def _corner(self, cell: FloatArray) -> FloatArray:
        """Where the scene's positions count from, in m in LAMMPS's."""
        return 0.5 * (np.array(self._scene.box.lengths) - cell.diagonal()) if self._scene.affine else np.zeros(3)

    def _move_box(self, cell: FloatArray) -> None:
        """Bring LAMMPS's box to these edge vectors in m, with the spheres in it if it carries them along."""
        size, (low, high, *tilt) = self._size(cell), self._lmp.extract_box()[:5]
        carried = "" if self._jumping else "remap"
        for i, j in EDGES:
            now = high[i] - low[i] if i == j else tilt[i + j - 1]
            grown = float(size[i, j]) - now
            if abs(grown) > np.finfo(float).eps * size[i, i]:
                bounds = f"{low[i] - 0.5 * grown!r} {high[i] + 0.5 * grown!r}" if i == j else repr(float(size[i, j]))
                self._commands(f"change_box all {EDGES[i, j]} final {bounds} {carried} units box")

    def _called(self, caller: object, step: int, count: int, tag: Any, position: Any, force: Any) -> None:
        """What LAMMPS calls in each step. An exception would be lost on its way through the library, so it is kept, and the run ended."""
        if self._failed is not None:
            return
        if self._interval is None or step == self._first:
            force[:] = 0.0
            return
        try:
            self._forces(step - self._first, self._interval, force)
        except BaseException as error:
            if self.ranks > 1:  # the others wait for this one: there is no other way to end them
                traceback.print_exc()
                sys.stderr.flush()
                os._exit(3)
            self._failed = error
            self._lmp.force_timeout()

    def _forces(self, number: int, interval: Deformation, force: FloatArray) -> None:
        before, now, dt = self._before, self._cell, interval.dt
        walls = self._walls_there() if len(self.walls) else self.walls
        if self._lists is None or self._lmp.extract_setting("neigh_ago") == 0 or (self._walled and self._drifted(walls)):
            self._list()
        assert self._lists is not None
        spheres, turning, begun = self._spheres, self._turning, False
        back, gradient = carried_along(before, now, dt) if self._moved and self._scene.affine else (STILL, NOTHING)
        edges = (now - before).diagonal() / dt if self._jumping and self._moved else NOTHING[0]
        if self._walled:
            spheres.sums[:, PRESSED : PRESSED + 3] = 0.0
        for kind, rates, (pairs, out, images) in zip(self._kinds, self._rates, self._lists, strict=True):
            contact, flats = kind.contact, walls if kind.second is None else None
            full = lammps_forces.pair_forces(
                contact.normal, contact.tangential, contact.rolling, contact.damping, contact.share, self._leaning,
                pairs.first, pairs.second, pairs.slots, pairs.touching, flats,
                spheres.tag, spheres.position, spheres.radius, spheres.mass,
                spheres.velocity if rates else None, spheres.spin if contact.tangential is not None else None,
                back, gradient, images, edges, dt, self._floats, spheres.partner, spheres.memory, out,
            )  # fmt: skip
            if full:
                raise InputError(Problem("contacts", int(full), f"this sphere has more than {SLOTS} contacts", "leave out --engine"))
            own, part = (spheres.radius, force, spheres.torque, spheres.sums), 0.5 if flats is None else 1.0
            lammps_forces.sum_up(turning, self._leaning, pairs.begin, pairs.entry, pairs.touching, out, part, begun, *own)
            if flats is not None and self._walled:
                lammps_forces.press(pairs.first, pairs.second, pairs.touching, out, flats, self._scene.moving_walls, spheres.sums)
            begun = True
        last = number == interval.steps
        after = now if last else self._next(interval, number + 1)
        fade = math.exp(-interval.drag * dt * (0.5 if last else 1.0))
        moving = (force, spheres.torque, spheres.position, spheres.velocity, spheres.spin)
        there = (back, self._strain(now, before, after), self._unwrapped(), now, after)
        roles = (turning, self._leaning, self._walled)
        lammps_forces.carry(*roles, spheres.mass, spheres.radius, *moving, 0.5 * dt, fade, *there, spheres.sums)
        if last:
            spheres.sums[:, FORCE : FORCE + 3] = force
            spheres.sums[:, TORQUE : TORQUE + 3] = spheres.torque
            self._look_around(walls)
            if self._leaning:
                spheres.sums[:, PLACE : PLACE + 3] = spheres.position[: len(spheres.sums)]
        else:
            self._move_on(interval, after)
            if self._changes:
                size = (self._size(after) - self._base).tolist()
                for name, i, j in self._changes:
                    self._lmp.set_internal_variable(name, size[i][j])

    def _next(self, interval: Deformation, number: int) -> FloatArray:
        """The edge vectors in m after the next step of the interval, which is this one."""
        if not self._moved:
            return self._cell
        return np.asarray(next_cell(interval, number, self._cell, self._virial() if self._following else NOTHING))

    def _move_on(self, interval: Deformation, after: FloatArray) -> None:
        """Note that box and walls go to the edge vectors `after` in the next drift."""
        if len(self.walls):
            self.walls = moved_walls(self.walls, self._cell, after, self._scene.moving_walls, self._scene.affine, interval.dt)
        self._before, self._cell = self._cell, after

    def _strain(self, now: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Change of the box over what it is; of one of which nothing but walls moves the change itself, in m."""
        if not self._moved:
            return NOTHING
        return np.asarray(after - before if self._walled else strain_of(now, before, after))

    def _sum_exactly(self, interval: Deformation) -> None:
        """Make ready for sums of all virials to the same bits on any number of ranks, if a stress is to be followed."""
        if self._following:
            band = interval.fastest / float(interval.gain.max())  # Pa; of a stress that far off the edges go as fast as they may
            self._unit = 2.0 ** (math.floor(math.log2(band * float(np.prod(self._cell.diagonal())))) - UNITS)
            shares = " ".join(f"d2_shares[{k + 1}]" for k in range(6))
            inputs = " ".join(f"c_shares[{k + 1}]" for k in range(6))
            self._commands(f"compute shares all property/atom {shares}", f"compute whole all reduce sum {inputs}")

    def _virial(self) -> FloatArray:
        """Sum of d F over all contacts in J, shape (3, 3), of which only the diagonal is there."""
        lammps_forces.round_off_apart(self._own("d2_sums"), self._unit, self._own("d2_shares"))
        found = self._lmp.numpy.extract_compute("whole", 0, 1)
        return np.diag(found[:3] + found[3:6])

    def _walls_there(self) -> FloatArray:
        """The walls where LAMMPS has them."""
        walls, corner = self.walls.copy(), self._corner(self._cell)
        walls[:, 2] += corner[walls[:, 0].astype(int)]
        return walls

    def _drifted(self, walls: FloatArray) -> bool:
        """Whether walls that move by themselves have gone farther than the list of spheres near them allows."""
        return bool(np.abs(walls[:, 2] - self._listed[:, 2]).max() > 0.5 * self._skin)

    def _look_around(self, walls: FloatArray) -> None:
        """Note what is asked for at the end of an interval alone: the deepest overlap of any pair of this rank, and d F across."""
        assert self._lists is not None
        spheres, most, begun = self._spheres, 0.0, False
        for kind, (pairs, out, _) in zip(self._kinds, self._lists, strict=True):
            flats, part = (walls, 1.0) if kind.second is None else (None, 0.5)
            rows = (pairs.first, pairs.second, pairs.touching)
            most = max(most, float(lammps_forces.deepest(*rows, flats, spheres.position, spheres.radius)))
            lammps_forces.sum_up_across(pairs.begin, pairs.entry, *rows, out, flats, part, begun, spheres.position, spheres.sums)
            begun = True
        spheres.sums[:, OVERLAP] = most

    def _list(self) -> None:
        """Look again at where LAMMPS has its arrays, and which pairs it lists."""
        count = self._lmp.extract_setting("nlocal")
        tag, kind, position, velocity, spin, radius, mass = (
            self._own(name, ghosts=True) for name in ("id", "type", "x", "v", "omega", "radius", "rmass")
        )
        torque, partner, memory, sums = (self._own(name) for name in ("torque", "i2_partner", "d2_memory", "d2_sums"))
        moving = (tag, kind - 1, position, velocity, spin, radius, mass)
        self._spheres = _Spheres(*moving, torque, partner.reshape(count * SLOTS), memory.reshape(count * SLOTS, self._columns), sums)
        self._listed, every, unseen, lists = self._walls_there(), lammps_list.from_lammps(self._lmp), partner != 0, []
        for group, rates in zip(self._kinds, self._rates, strict=True):
            first, second = self._of(group, every)
            slots = (partner, self._spheres.memory, self._floats, unseen)
            pairs = lammps_list.arranged(first, second, True if group.second is None else None, tag, *slots)
            images = None
            if self._jumping:
                edges = self._cell.diagonal()
                images = lammps_list.images_of(pairs.first, pairs.second, position, self._own("d2_unwrapped", ghosts=True), edges)
            lists.append(_List(pairs, np.zeros((len(pairs.first), LEANED if self._leaning else ROUGH if rates else SMOOTH)), images))
        self._lists = lists
        if unseen.any():
            self._forget(np.flatnonzero(unseen.ravel()).astype(np.int32))

    def _of(self, group: Kind, every: tuple[IntArray, IntArray]) -> tuple[IntArray, IntArray]:
        """The pairs of a group among all that LAMMPS lists, or the spheres near walls."""
        kind, own = self._spheres.kind, len(self._spheres.sums)
        if group.second is not None:
            return every if self._scene.kinds == 1 else lammps_list.of_kinds(*every, kind, group.first, group.second)
        # a sphere may have gone half of the skin when walls that move by themselves ask for a list, and back until the next
        first, second = lammps_list.near_walls(self._spheres.position[:own], self._spheres.radius[:own], self._listed, 1.5 * self._skin)
        chosen = kind[first] == group.first
        return first[chosen], second[chosen]

    def _forget(self, left: IntArray) -> None:
        """Free the slots of contacts whose spheres went out of each other's reach without being seen to part."""
        spheres, bodies = self._spheres, self._scene.particles
        other = spheres.partner[left]
        kinds = np.zeros((2, len(left)), np.int64)
        if bodies.kind is not None:
            kinds[0] = spheres.kind[left // SLOTS]
            kinds[1] = bodies.kind[np.argsort(bodies.id)][np.maximum(other, 1) - 1]
        for group in self._kinds:
            chosen = (other < 0) & (kinds[0] == group.first)
            if group.second is not None:
                chosen = (other > 0) & (kinds.min(axis=0) == group.first) & (kinds.max(axis=0) == group.second)
            law = (group.contact.normal, group.contact.share)
            lammps_forces.forget(*law, left[chosen], spheres.radius, spheres.partner, spheres.memory, spheres.sums)
