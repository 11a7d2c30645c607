"""The 560 runs of Edmans & Sinka (2020), 40 materials with 14 unloadings each: wall time, CPU time, memory, where the time goes, errors.

    python -m cases.benchmarks.study_speed [--jobs 2] [--against DIVISIONS] [--materials 10:0.3,100:0.3]

Starting the processes and importing counts; compiling does not (one small run before fills the cache). With --against, the materials are
run once more with that many divisions (16: four times as many elements, 32: four times as many divisions) and twice as many steps, and
the differences in force and in rho = R/(d_max - d_0) at all overlaps are printed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np

import fem
from cases.edmans_sinka_2020.paper import DEPTHS, MODULI, POISSON
from contactlaws.curve import Curve, FloatArray
from contactlaws.material import Material
from fem.assembly import Discretisation, discretise
from fem.march import Steps
from fem.mesh import spheroid
from fem.press import Resolution, core_size, press_body, programme

TOLERANCE = 0.01
FINER_STEPS = Steps(first=0.08, growth=2.0, force_drop=0.2, tail=0.5)
GOAL_SECONDS, GOAL_MEGABYTES, GOAL_FORCE, GOAL_RHO = 60.0, 500.0, 0.005, 0.01
PARTS = ("forces", "stiffness", "factorisation", "solution", "contact", "history")
COUNTS = ("steps", "iterations", "factorisations", "rejected")


class Point(NamedTuple):
    """E/Y and Poisson's ratio."""

    ratio: float
    poissons_ratio: float

    @property
    def material(self) -> Material:
        return Material(self.ratio, self.poissons_ratio, 1.0)


class Run(NamedTuple):
    """One material: force and rho at the overlaps reached, what it cost, and the largest memory its process has had."""

    force: FloatArray
    rho: FloatArray
    stopped: str | None
    statistics: Counter[str]  # both meshes together
    cpu_seconds: float
    megabytes: float


def measured(curve: Curve) -> Run:
    """What the benchmark keeps of a curve."""
    rows = [curve.rows(k) for k in curve.unloadings]
    statistics: Counter[str] = Counter()
    for mesh in curve.provenance["statistics"].values():
        statistics.update(mesh)
    return Run(
        force=np.array([curve.force[r][0] for r in rows]),
        rho=np.array([curve.radius / (curve.overlap[r][0] - curve.overlap[r][-1]) for r in rows]),
        stopped=curve.stopped,
        statistics=statistics,
        cpu_seconds=curve.provenance["cpu_seconds"],
        megabytes=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    )


def usual(point: Point) -> Run:
    """The study's own run of a material."""
    return measured(fem.press(point.material, unload_from=DEPTHS, tolerance=TOLERANCE))


def finer(divisions: int, point: Point) -> Run:
    """The same on a mesh of so many divisions, with more steps."""
    asked = programme(DEPTHS, None)

    def body(count: int) -> Discretisation:
        return discretise(spheroid(count, core_size(asked.largest, asked.smallest), 1.0, asked.along))

    return measured(press_body(body, point.material, 1.0, 1.0, asked, Resolution(divisions, FINER_STEPS), lambda: None))


def grid(text: str | None) -> list[Point]:
    """The materials named as E/Y:nu, or all 40; the dearest first, so that no process is left waiting at the end."""
    if text is None:
        return [Point(ratio, nu) for ratio in sorted(MODULI, reverse=True) for nu in POISSON]
    return [Point(*map(float, item.split(":"))) for item in text.split(",")]


def print_cost(runs: list[Run], wall: float, jobs: int) -> None:
    """Time, memory and where the time went, beside the goals."""
    total: Counter[str] = Counter()
    for run in runs:
        total.update(run.statistics)
    cpu = sum(run.cpu_seconds for run in runs)
    print(f"{len(runs)} materials, {sum(run.rho.size for run in runs)} unloadings in {wall:.1f} s wall on {jobs} processes")
    print(f"CPU {cpu:.1f} s, {cpu / len(runs):.2f} s per material (goal of the 40: {GOAL_SECONDS:g} s wall on 2 processes)")
    print(f"largest memory of a process {max(run.megabytes for run in runs):.0f} MB (goal {GOAL_MEGABYTES:g})")
    for part in PARTS:
        print(f"    {part:15s}{total[part]:8.1f} s {total[part] / cpu:6.1%}")
    rest = cpu - sum(total[part] for part in PARTS)
    print(f"    {'rest':15s}{rest:8.1f} s {rest / cpu:6.1%}    {', '.join(f'{total[name]:g} {name}' for name in COUNTS)}")
    for run in runs:
        if run.stopped:
            print(f"    stopped early: {run.stopped}")


def print_differences(runs: list[Run], better: list[Run], divisions: int) -> None:
    """Median, 90th percentile and largest relative difference of force and rho."""
    for name, goal in (("force", GOAL_FORCE), ("rho", GOAL_RHO)):
        pairs = [(getattr(run, name), getattr(fine, name)) for run, fine in zip(runs, better, strict=True)]
        change = np.concatenate([np.abs(a[: min(a.size, b.size)] / b[: min(a.size, b.size)] - 1.0) for a, b in pairs])
        median, most, worst = np.percentile(change, (50, 90, 100))
        print(
            f"{name} against {divisions} divisions, {change.size} points: median {median:.3%}, 90th percentile {most:.3%}, "
            f"worst {worst:.3%} (goal {goal:.1%})"
        )


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m cases.benchmarks.study_speed", description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--jobs", type=int, default=2, help="processes; default 2")
    parser.add_argument("--against", type=int, metavar="DIVISIONS", help="run the materials also with so many divisions and compare")
    parser.add_argument("--materials", help="E/Y:nu,... instead of all 40")
    given = parser.parse_args(arguments)
    points, spawn = grid(given.materials), multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        pool.submit(usual, Point(1.0, 0.3)).result()  # fills the cache of compiled kernels
    began = time.perf_counter()
    with ProcessPoolExecutor(given.jobs, mp_context=spawn) as pool:
        runs = list(pool.map(usual, points))
    print_cost(runs, time.perf_counter() - began, given.jobs)
    if given.against:
        with ProcessPoolExecutor(given.jobs, mp_context=spawn) as pool:
            print_differences(runs, list(pool.map(partial(finer, given.against), points)), given.against)


if __name__ == "__main__":
    main()
