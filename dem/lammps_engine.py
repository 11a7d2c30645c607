"""LAMMPS as the engine of a scene: it decomposes the box, lists neighbours, integrates, and keeps and saves what contacts remember.

It is talked to by its commands and its library's functions. Every rank of an MPI run makes the same calls; what is asked of the whole is
the same on each of them.

A step: LAMMPS kicks half, drifts, brings ghosts or lists up to date, and calls back for forces; then it kicks the other half and moves the
box for the next step, with the spheres in it. So positions go as x F + v dt in the box that belongs to them, as in `dem.motion`; what that
needs of velocities (v F^-1, the drag) is done in the callback. Before an interval LAMMPS sets itself up anew: the first kick and the first
move of the box are made here, with the last forces, and LAMMPS starts with none.
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
from dem.lammps_forces import CLOCK, FORCE, LARGEST, REMEMBERED, ROUGH, SLOTS, SMOOTH, SUMS, TORQUE
from dem.lammps_library import SILENT, library
from dem.lammps_scope import problems_with
from dem.motion import Deformation
from dem.scene import Contact, Scene
from dem.working import needs_rates

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

#: spheres handed to LAMMPS, or asked for, at a time
HANDFUL = 100_000


class Snapshot(NamedTuple):
    """All spheres in the order of their numbers, 1 to n."""

    position: FloatArray  # m, from the lower corner of the box, not wrapped; shape (n, 3)
    velocity: FloatArray  # m/s, relative to the box, shape (n, 3)
    spin: FloatArray  # 1/s, shape (n, 3)
    partner: IntArray  # number of the other sphere of each slot, 0: free; shape (n, SLOTS)
    memory: FloatArray  # shape (n, SLOTS, columns)
    sums: FloatArray  # shape (n, SUMS)


class _Spheres(NamedTuple):
    """This rank's arrays, in LAMMPS's memory: they hold until it makes new lists. Its own spheres come first, then the ghosts."""

    tag: IntArray
    position: FloatArray
    velocity: FloatArray
    spin: FloatArray
    radius: FloatArray
    mass: FloatArray
    torque: FloatArray  # of its own alone, as all that follow
    partner: IntArray  # one row per slot
    memory: FloatArray
    sums: FloatArray


class Engine:
    """A running LAMMPS. `close` ends it."""

    def __init__(self, contact: Contact, skin: float, widest: float) -> None:
        """An empty one for spheres of radius `widest` (m) at most; `skin` in m."""
        self._lmp = library().lammps(cmdargs=list(SILENT))
        self._contact, self._skin, self._reach = contact, skin, 2.0 * widest
        self._rates = True if needs_rates(contact) else None
        self._turning = True if contact.tangential is not None else None
        self._columns = max(1, dispatch.floats_of_state(contact.normal)) + (REMEMBERED if self._rates else 0)
        self._interval: Deformation | None = None  # None: no forces are asked for
        self._first = 0  # number of the step before the interval
        self._pairs: lammps_list.Pairs | None = None
        self._failed: BaseException | None = None
        self._began = time.monotonic()

    @classmethod
    def of_scene(cls, scene: Scene) -> Engine:
        """The spheres of a scene as they are at its start; raises `InputError` before anything is made."""
        require(problems_with(scene))
        bodies, (x, y, z) = scene.particles, scene.box.lengths
        widest = float(bodies.radii.max())
        engine = cls(scene.contact, 2.0 * widest * scene.skin, widest)
        engine._commands("units si", "atom_style sphere", "atom_modify map array", "newton off", "boundary p p p")
        engine._commands(f"region box block 0 {x!r} 0 {y!r} 0 {z!r} units box", "create_box 1 box")
        engine._declare()
        order = np.argsort(bodies.id)
        wrapped = bodies.position[order] % np.array(scene.box.lengths)
        for start in range(0, bodies.size, HANDFUL):
            some = slice(start, start + HANDFUL)
            number, rest = bodies.id[order][some].tolist(), (wrapped[some], bodies.velocity[order][some])
            engine._lmp.create_atoms(len(number), number, [1] * len(number), *(rows.ravel().tolist() for rows in rest))
        own = engine._own("id") - 1
        engine._own("radius")[:] = bodies.radii[order][own]
        engine._own("rmass")[:] = scene.masses[order][own]
        if bodies.spin is not None:
            engine._own("omega")[:] = bodies.spin[order][own]
        here = scene.box.cell
        engine._interval, engine._first = Deformation(here, here, 1, 0.0), -1
        engine._commands("run 0 post no")  # the forces of the beginning
        engine._raise()
        return engine

    @classmethod
    def restored(cls, path: Path, contact: Contact, skin: float, widest: float) -> Engine:
        """What `save` wrote, on any number of ranks."""
        engine = cls(contact, skin, widest)
        engine._commands("newton off", f"read_restart {path}")  # what was said of newton counts, not what is in the file
        engine._declare()
        engine._commands("run 0 post no")  # only then will LAMMPS let the box be changed
        return engine

    def save(self, path: Path) -> None:
        """A LAMMPS restart file: spheres, box and what contacts remember."""
        self._commands(f"write_restart {path}")

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
    def lengths(self) -> FloatArray:
        """Edges of the box in m."""
        low, high = self._lmp.extract_box()[:2]
        return np.array(high) - np.array(low)

    def follow(self, interval: Deformation) -> None:
        """Take all steps of an interval; raises what went wrong in the force."""
        self._commands("run 0 post no")  # spheres that left the box come in again before anything else, as they do when the state is saved
        self._interval, self._first, self._pairs = interval, int(self._lmp.extract_global("ntimestep")), None
        start, first = self._edges(0), self._edges(1)
        fade = math.exp(-0.5 * interval.drag * interval.dt)
        moving = (self._own(name) for name in ("rmass", "radius", "v", "omega"))
        lammps_forces.first_kick(self._turning, *moving, 0.5 * interval.dt, fade, (first - start) / start, self._own("d2_sums"))
        self._move_box(first)
        change = (interval.end - interval.start).diagonal().tolist()
        last = self._first + interval.steps
        share = f"(ternary(step<{last},step+1,{last})-{self._first + 1})/{interval.steps}"
        edges = [axis for axis in range(3) if change[axis] != 0.0]
        for axis in edges:
            self._commands(f"variable change{axis} equal {change[axis]!r}*{share}")
        if edges:
            self._commands("variable rate equal 0.0")
            moved = " ".join(f"{'xyz'[axis]} variable v_change{axis} v_rate" for axis in edges)
            self._commands(f"fix box all deform 1 {moved} remap x")
        self._commands(f"timestep {interval.dt!r}", f"run {interval.steps} post no")
        if edges:
            self._commands("unfix box")
        self._interval = None
        self._raise()

    def extent(self) -> dict[str, int]:
        """How many spheres are this rank's own and how many ghosts, and bytes of the arrays that this engine keeps for them.

        The arrays are what contacts remember, the sums and the lists of pairs, beside those that any LAMMPS has.
        """
        self._list()
        assert self._pairs is not None
        kept = (*self._pairs, self._out, self._spheres.partner, self._spheres.memory, self._spheres.sums)
        ghosts = int(self._lmp.extract_setting("nghost"))
        return {"own": len(self._spheres.sums), "ghosts": ghosts, "arrays": sum(array.nbytes for array in kept)}

    def agreed(self) -> tuple[float, float]:
        """The same on all ranks: largest overlap of one body over its radius so far, infinite if the motion diverged; seconds so far."""
        sums = self._own("d2_sums")
        lost = ~np.isfinite(self._own("x")).all(axis=1) | ~np.isfinite(self._own("v")).all(axis=1)
        sums[lost, LARGEST] = np.inf
        sums[:, CLOCK] = time.monotonic() - self._began
        columns = " ".join(f"d2_sums[{column + 1}]" for column in (LARGEST, CLOCK))
        self._commands(f"compute own all property/atom {columns}", "compute agreed all reduce max c_own[1] c_own[2]")
        deepest, clock = self._lmp.numpy.extract_compute("agreed", 0, 1)[:2].tolist()
        self._commands("uncompute agreed", "uncompute own")
        return deepest, clock

    def snapshot(self) -> Snapshot | None:
        """All spheres, gathered on the first rank; None on the others, each of which must ask for it too."""
        count = int(self._lmp.get_natoms())
        low = np.array(self._lmp.extract_box()[0])

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
            position=gathered("x", 1, 3),
            velocity=gathered("v", 1, 3),
            spin=gathered("omega", 1, 3),
            partner=gathered("i2_partner", 0, SLOTS),
            memory=gathered("d2_memory", 1, SLOTS * self._columns).reshape(-1, SLOTS, self._columns),
            sums=gathered("d2_sums", 1, SUMS),
        )
        image = gathered("image", 0, 3)
        return found._replace(position=found.position - low + image * self.lengths) if self.rank == 0 else None

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

    def _declare(self) -> None:
        """What is no part of a restart file, or must be said again to get it back."""
        self._commands(
            f"fix memory all property/atom i2_partner {SLOTS} d2_memory {SLOTS * self._columns} d2_sums {SUMS}",
            f"comm_modify vel {'yes' if self._rates else 'no'}",
            f"pair_style zero {self._reach!r}",
            "pair_coeff * *",
            f"neighbor {self._skin!r} bin",
            "neigh_modify every 1 delay 0 check yes",
            f"fix motion all {'nve/sphere' if self._turning else 'nve'}",
            "fix law all external pf/callback 1 1",
        )
        self._lmp.set_fix_external_callback("law", self._called, None)

    def _move_box(self, edges: FloatArray) -> None:
        """Stretch the box, about its middle, to these edges in m, with the spheres in it."""
        low, high = (np.array(corner) for corner in self._lmp.extract_box()[:2])
        for axis in range(3):
            grown = edges[axis] - (high[axis] - low[axis])
            if abs(grown) > np.finfo(float).eps * edges[axis]:
                bounds = (float(low[axis] - 0.5 * grown), float(high[axis] + 0.5 * grown))
                self._commands(f"change_box all {'xyz'[axis]} final {bounds[0]!r} {bounds[1]!r} remap units box")

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
        if self._pairs is None or self._lmp.extract_setting("neigh_ago") == 0:
            self._list()
        assert self._pairs is not None
        contact, pairs, spheres, out = self._contact, self._pairs, self._spheres, self._out
        before, now = self._edges(number - 1), self._edges(number)
        gradient = (now - before) / (0.5 * (now + before) * interval.dt) if interval.dt > 0.0 else np.zeros(3)
        rates, turning = self._rates, self._turning
        full = lammps_forces.pair_forces(
            contact.normal, contact.tangential, contact.rolling, contact.damping, contact.share,
            pairs.first, pairs.second, pairs.slots, pairs.touching,
            spheres.tag, spheres.position, spheres.radius, spheres.mass,
            spheres.velocity if rates else None, spheres.spin if turning else None,
            now / before, gradient, interval.dt, spheres.partner, spheres.memory, out,
        )  # fmt: skip
        if full:
            raise InputError(Problem("contacts", int(full), f"this sphere has more than {SLOTS} contacts", "leave out --engine"))
        own = (spheres.radius, force, spheres.torque, spheres.sums)
        lammps_forces.sum_up(turning, pairs.begin, pairs.entry, pairs.touching, out, *own)
        last = number == interval.steps
        after = now if last else self._edges(number + 1)
        fade = math.exp(-interval.drag * interval.dt * (0.5 if last else 1.0))
        moving = (force, spheres.torque, spheres.velocity, spheres.spin)
        strain = (after - before) / now
        lammps_forces.carry(turning, spheres.mass, spheres.radius, *moving, 0.5 * interval.dt, fade, now / before, strain, spheres.sums)
        if last:
            spheres.sums[:, FORCE : FORCE + 3] = force
            spheres.sums[:, TORQUE : TORQUE + 3] = spheres.torque

    def _edges(self, number: int) -> FloatArray:
        """Edges in m in which the forces of a step of the interval are computed."""
        interval = self._interval
        assert interval is not None
        return np.asarray((interval.start + (interval.end - interval.start) * (number / interval.steps)).diagonal())

    def _list(self) -> None:
        """Look again at where LAMMPS has its arrays, and which pairs it lists."""
        count = self._lmp.extract_setting("nlocal")
        tag, position, velocity, spin, radius, mass = (
            self._own(name, ghosts=True) for name in ("id", "x", "v", "omega", "radius", "rmass")
        )
        torque, partner, memory, sums = (self._own(name) for name in ("torque", "i2_partner", "d2_memory", "d2_sums"))
        slots = memory.reshape(count * SLOTS, self._columns)
        moving = (tag, position, velocity, spin, radius, mass)
        self._spheres = _Spheres(*moving, torque, partner.reshape(count * SLOTS), slots, sums)
        self._pairs, left = lammps_list.from_lammps(self._lmp, tag, partner)
        if len(left):
            law = (self._contact.normal, self._contact.share)
            lammps_forces.forget(*law, left, self._spheres.radius, self._spheres.partner, slots, sums)
        self._out = np.zeros((len(self._pairs.first), ROUGH if self._rates else SMOOTH))
