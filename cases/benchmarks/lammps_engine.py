"""`--engine lammps` beside LAMMPS's own `granular mdr` and beside our own loop, on the same packing; and what it needs on more ranks.

    python -m cases.benchmarks.lammps_engine [--counts 1000,10000,100000] [--steps 200] [--repeats 5] [--ranks 1,2,4]

The packings, the material and the elastic-plastic law are those of `cases.benchmarks.lammps`: spheres pressed until every contact has
yielded, from small random speeds, with the same time step and the same skin everywhere. On one rank CPU time counts, the runs take turns,
and the fastest of the repeats counts. On more ranks wall time counts, and means something only on a machine with as many idle cores.

What is measured on each number of ranks, and what `docs/large_scenes.md` reckons with: spheres and ghosts of a rank, the bytes that it
receives for its ghosts in a step, the memory that its arrays and its whole process take for each of its spheres.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import dem
from cases.benchmarks.lammps import PLASTIC, PRESSED, SKIN, TIME_STEP_FRACTION, our_run, their_run
from cases.benchmarks.lammps_input import Programs, granular_mdr, installed
from cases.benchmarks.settled_packing import DENSITY, LARGEST, MATERIAL, RADIUS, hertz, settled
from contactlaws.tangential import mindlin
from contactlaws.whole_range import whole_range
from dem.box import Box
from dem.lammps_engine import Engine
from dem.lammps_library import finish, launcher
from dem.measure import network
from dem.motion import Deformation
from dem.particles import spheres
from dem.scene import Contact, Scene
from dem.timestep import scene_time_step
from dem.working import working

#: friction of the rough spheres, and bytes of a number
FRICTION, WORD = 0.3, 8
PAGE = os.sysconf("SC_PAGE_SIZE")


class Seconds(NamedTuple):
    """Of as many steps of the same packing."""

    own: float
    engine: float
    mdr: float | None  # None: no program `lmp`


def scene_of(position: np.ndarray, velocity: np.ndarray, lengths: tuple[float, float, float], rough: bool = False) -> Scene:
    """The spheres on the elastic-plastic law, in a box at rest."""
    contact = Contact(whole_range(PLASTIC, RADIUS), mindlin(FRICTION, MATERIAL) if rough else None)
    return Scene(spheres(position, RADIUS, DENSITY, velocity), Box(lengths), contact, (dem.hold(1.0),), skin=SKIN)


def pressed(count: int) -> tuple[Scene, float]:
    """The scene, and its time step in s."""
    particles, box = settled(8 * (count // 8) if count > LARGEST else count, PRESSED)
    elastic = Scene(particles, box, Contact(hertz()), ())
    dt = scene_time_step(elastic, 1.5 * float(network(working(elastic)).overlap.max()), TIME_STEP_FRACTION).dt
    return scene_of(particles.position, particles.velocity, box.lengths), dt


def engine_run(engine: Engine, cell: np.ndarray, dt: float, steps: int) -> tuple[float, float]:
    """CPU and wall time of `steps` steps in s, on this rank."""
    cpu, wall = time.process_time(), time.perf_counter()
    engine.follow(Deformation(cell, cell, steps, dt))
    return time.process_time() - cpu, time.perf_counter() - wall


def in_turns(scene: Scene, dt: float, steps: int, repeats: int, programs: Programs | None) -> Seconds:
    """CPU time of all three on one core, the fastest of the repeats of each."""
    engine, cell = Engine.of_scene(scene), scene.box.cell
    our_run(scene, dt, 2)  # compiles
    engine_run(engine, cell, dt, 2)
    own, mine, theirs = [], [], []
    for _ in range(repeats):
        own.append(our_run(scene, dt, steps)[0])
        mine.append(engine_run(engine, cell, dt, steps)[0])
        if programs is not None:
            theirs.append(their_run(programs, granular_mdr(PLASTIC), scene, dt, steps, 1)[0])
    engine.close()
    return Seconds(min(own), min(mine), min(theirs, default=None))


def resident() -> int:
    """Bytes of memory that this process occupies; only where there is /proc."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE


def on_a_rank(file: Path, steps: int, repeats: int, rough: bool) -> None:
    """What each of several ranks does; the measurements go beside the file."""
    with np.load(file) as found:
        position, velocity, lengths, dt = found["position"], found["velocity"], found["lengths"].tolist(), float(found["dt"])
    scene = scene_of(position, velocity, (lengths[0], lengths[1], lengths[2]), rough)
    cell = scene.box.cell
    warm = Engine.of_scene(scene_of(position[:1], velocity[:1], (lengths[0], lengths[1], lengths[2]), rough))
    engine_run(warm, cell, dt, 2)  # compiles
    warm.close()
    before = resident()
    engine = Engine.of_scene(scene)
    seconds = [engine_run(engine, cell, dt, steps) for _ in range(repeats)]
    measured: dict[str, Any] = engine.extent() | {"resident": resident() - before, "seconds": seconds}
    began, snapshot = time.perf_counter(), engine.snapshot()
    measured["gathering"] = time.perf_counter() - began
    measured["gathered"] = 0 if snapshot is None else sum(array.nbytes for array in snapshot)
    file.with_name(f"rank{engine.rank}.json").write_text(json.dumps(measured))
    engine.close()
    finish()


def on_ranks(scene: Scene, dt: float, steps: int, repeats: int, ranks: int, rough: bool) -> list[dict[str, Any]]:
    """Measurements of each rank; raises `RuntimeError` if they fail."""
    with tempfile.TemporaryDirectory() as name:
        file = Path(name) / "scene.npz"
        bodies = scene.particles
        np.savez(file, position=bodies.position, velocity=bodies.velocity, lengths=np.array(scene.box.lengths), dt=np.array(dt))
        options = ["--steps", str(steps), "--repeats", str(repeats), "--worker", str(file), *(["--rough"] if rough else [])]
        command = [str(launcher()), "-n", str(ranks), sys.executable, "-m", __spec__.name, *options]
        done = subprocess.run(command, env=os.environ | {"OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"the ranks ended with {done.returncode}: {(done.stdout + done.stderr)[-2000:]}")
        return [json.loads((Path(name) / f"rank{rank}.json").read_text()) for rank in range(ranks)]


def told(count: int, seconds: Seconds, steps: int) -> str:
    """A line."""
    done = count * steps / 1e6
    line = (
        f"{count:8d} spheres, million particle-steps per CPU s: our own loop {done / seconds.own:.2f}, engine {done / seconds.engine:.2f}"
    )
    line += f" ({seconds.engine / seconds.own:.2f} times the CPU of our own)"
    if seconds.mdr is None:
        return line
    return f"{line}, granular mdr {done / seconds.mdr:.2f}: the engine is {seconds.mdr / seconds.engine:.2f} times as fast as that"


def told_of_ranks(ranks: int, found: list[dict[str, Any]], steps: int, rough: bool, alone: float | None) -> tuple[str, float]:
    """A line, and the wall time in s."""
    wall = min(max(rank["seconds"][k][1] for rank in found) for k in range(len(found[0]["seconds"])))
    own, ghosts = [sum(rank[name] for rank in found) / ranks for name in ("own", "ghosts")]
    numbers = 9 if rough else 3  # position; with friction velocity and spin too
    arrays, process = (sum(rank[name] for rank in found) / max(sum(rank["own"] for rank in found), 1) for name in ("arrays", "resident"))
    line = f"    {ranks} rank{'s' if ranks > 1 else ' '}, {'friction' if rough else 'smooth':8s}: "
    line += f"{own:.0f} spheres and {ghosts:.0f} ghosts each, "
    line += f"{ghosts * numbers * WORD / 1e3:.0f} kB received in a step; bytes per sphere {arrays:.0f} in the engine's arrays, "
    line += f"{process:.0f} in the process; {1e3 * wall / steps:.2f} ms of wall time a step"
    line += "" if alone is None else f", {alone / wall:.2f} times as fast as on the first number"
    whole = sum(rank["own"] for rank in found)
    gathered, gathering = (max(rank[name] for rank in found) for name in ("gathered", "gathering"))
    return f"{line}; an output: {gathered / whole:.0f} bytes per sphere on the first rank, gathered in {1e3 * gathering:.0f} ms", wall


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--counts", default="1000,10000,100000", help="spheres; more than 12500 are 8 copies of a packing")
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--ranks", default="1,2,4")
    parser.add_argument("--lmp", help="path of LAMMPS's program, if it is not on the path")
    parser.add_argument("--worker", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--rough", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args(arguments)
    if asked.worker is not None:
        on_a_rank(asked.worker, asked.steps, asked.repeats, asked.rough)
        return
    programs = installed(asked.lmp)
    for count in map(int, asked.counts.split(",")):
        scene, dt = pressed(count)
        size, steps = scene.particles.size, max(2, min(asked.steps, 200 * asked.steps * 50 // count))
        print(told(size, in_turns(scene, dt, steps, asked.repeats, programs), steps), flush=True)
        began = time.process_time()
        work = working(scene)
        print(f"    read off by our own code: {work.bytes_used / size:.0f} bytes per sphere, {time.process_time() - began:.2f} CPU s")
        for rough in (False, True):
            alone = None
            for ranks in map(int, asked.ranks.split(",")):
                found = on_ranks(scene, dt, steps, asked.repeats, ranks, rough)
                line, wall = told_of_ranks(ranks, found, steps, rough, alone)
                alone = alone or wall
                print(line, flush=True)


if __name__ == "__main__":
    main()
