"""CPU seconds of a reference curve, beside the goals and, where `ccx` is installed, beside CalculiX on the same sphere and material.

    python -m cases.benchmarks.fe_speed [--without-calculix]

One thread each. Compiling is done before and reported apart. Our time is that of the whole answer: two meshes, first yield, error
estimates. A viscoelastic ramp, hold and release is set beside the elastic press to the same overlap, which is run before and after it.
"""

from __future__ import annotations

import argparse
import time
from typing import NamedTuple

import numpy as np

import fem
from cases import calculix
from cases.benchmarks import calculix_deck
from contactlaws.curve import Curve
from contactlaws.material import Material
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from fem.mesh import spheroid
from fem.press import core_size, resolution_for
from fem.programme import ramp_hold_release

TOLERANCE = 0.01
RATIOS = (50.0, 200.0, 1000.0)  # Young's modulus over yield stress
POISSONS_RATIO = 0.3
SHALLOW, SHALLOW_GOAL = (0.1,), 2.0
DEEP, DEEP_GOAL = tuple(np.geomspace(0.005, 0.5, 14)), 10.0
IN_TIME_GOAL = 3.0
IN_TIME_DEPTHS = (0.02, 0.1, 0.3)
#: one term as of a polymer, and eight over twelve decades that leave a tenth of the modulus
ONE_TERM = Relaxation(1.0, (0.23,), (1.0,))
EIGHT_TERMS = Relaxation(1.0, (0.9 / 8.0,) * 8, tuple(np.logspace(-6.0, 6.0, 8).tolist()))
IN_TIME = {
    "one term, nu .43": uniaxial(ONE_TERM, 0.43),
    "one term, K constant": uniaxial(ONE_TERM, 0.43, constant_bulk=True),
    "eight terms, K constant": uniaxial(EIGHT_TERMS, 0.3, constant_bulk=True),
    "half of it, nu .499": uniaxial(Relaxation(1.0, (0.5,), (1.0,)), 0.499, constant_bulk=True),
}
CALCULIX_INCREMENTS, CALCULIX_TIMEOUT = 20, 170.0


class Cost(NamedTuple):
    """One curve of ours and what it cost."""

    curve: Curve
    cpu_seconds: float


def press(material: Material, unload_from: tuple[float, ...]) -> Cost:
    """Run `fem.press` once and take the time of this process, all threads."""
    began = time.process_time()
    curve = fem.press(material, unload_from=unload_from, tolerance=TOLERANCE)
    return Cost(curve, time.process_time() - began)


def press_in_time(material: PronyViscoelastic, depth: float) -> Cost:
    """The same for a ramp of 1 s to `depth` (over the radius), a hold of 2 s and a release in 1 s."""
    began = time.process_time()
    curve = fem.press_in_time(material, ramp_hold_release(depth, 1.0, 2.0, 1.0), tolerance=TOLERANCE)
    return Cost(curve, time.process_time() - began)


def elastic_seconds(material: PronyViscoelastic, depth: float) -> float:
    """CPU seconds of the elastic press to `depth`."""
    began = time.process_time()
    fem.press(material.instantaneous, max_overlap=depth, tolerance=TOLERANCE)
    return time.process_time() - began


def in_time() -> None:
    """Measure and print the viscoelastic curves."""
    for name, material in IN_TIME.items():
        for depth in IN_TIME_DEPTHS:
            before = elastic_seconds(material, depth)
            cost = press_in_time(material, depth)
            ratio = cost.cpu_seconds / (0.5 * (before + elastic_seconds(material, depth)))
            stopped = f"; STOPPED EARLY: {cost.curve.stopped}" if cost.curve.stopped else ""
            of_goal = cost.cpu_seconds / IN_TIME_GOAL
            print(
                f"{name:24s} ramp, hold, release at {depth:4g} R {cost.cpu_seconds:6.2f} CPU s, {of_goal:5.2f} of the goal, "
                f"{ratio:4.1f} times the elastic press; error stated {cost.curve.errors['force']:.2%}{stopped}",
                flush=True,
            )


def where(curve: Curve) -> str:
    """Where the time of a curve went: CPU seconds of both meshes, and counts."""
    meshes = curve.provenance["statistics"].values()
    total = {name: sum(mesh[name] for mesh in meshes) for name in next(iter(meshes))}
    kernel = total["forces"] + total["stiffness"] + total["history"]
    rest = curve.provenance["cpu_seconds"] - kernel - total["factorisation"] - total["solution"] - total["contact"]
    return (
        f"element kernels {kernel:.2f}, factorisation {total['factorisation']:.2f}, solution {total['solution']:.2f}, "
        f"contact search {total['contact']:.2f}, rest {rest:.2f}; {total['steps']} steps, {total['rejected']} cut, "
        f"{total['iterations']} iterations, {total['factorisations']} factorisations"
    )


def by_calculix(material: Material, curve: Curve) -> calculix.Result:
    """The same loading and unloading by CalculiX, with as many nodes on the surface as our finer mesh has."""
    rows = curve.rows(1)
    largest, separation = float(curve.overlap[rows][0]), float(curve.overlap[rows][-1])
    # eight-node elements of twice the size; a little of the force is left, as a body that hangs free is singular
    section = spheroid(resolution_for(TOLERANCE).divisions // 2, core_size(largest, largest))
    stops = [largest, separation + 0.02 * (largest - separation)]
    return calculix_deck.run(calculix_deck.quadratic(section), material, stops, CALCULIX_INCREMENTS, CALCULIX_TIMEOUT)


def loading_difference(curve: Curve, other: calculix.Result) -> float:
    """Work of our loading over that of CalculiX, beyond the first fifth, minus 1."""
    rows = curve.rows(0)
    last = int(np.argmax(other.overlap))
    x, force = other.overlap[: last + 1], other.force[1, : last + 1]
    beyond = x >= 0.2 * x[-1]
    ours = np.interp(x[beyond], curve.overlap[rows], curve.force[rows])
    return float(np.trapezoid(ours, x[beyond]) / np.trapezoid(force[beyond], x[beyond]) - 1.0)


def unloading_difference(curve: Curve, other: calculix.Result) -> float:
    """What our body gives back over what CalculiX's does, minus 1: overlaps from the start down to an eighth of the largest force."""
    rows = curve.rows(1)
    start = int(np.argmax(other.overlap))
    eighth = curve.force[rows][0] / 8.0
    ours = float(np.interp(eighth, curve.force[rows][::-1], curve.overlap[rows][::-1]))
    theirs = float(np.interp(eighth, other.force[1, start:][::-1], other.overlap[start:][::-1]))
    return (curve.overlap[rows][0] - ours) / (other.overlap[start] - theirs) - 1.0


def _beside(material: Material, cost: Cost) -> str:
    other = by_calculix(material, cost.curve)
    if not other.finished:
        reached = f"after {other.cpu_seconds:.0f} CPU s at an overlap of {other.overlap[-1:]}"
        return f"CalculiX did not finish: it ended {reached}; ratio so far {other.cpu_seconds / cost.cpu_seconds:.0f}"
    return (
        f"CalculiX {other.cpu_seconds:.1f}, ratio {other.cpu_seconds / cost.cpu_seconds:.0f}; "
        f"ours differs by {loading_difference(cost.curve, other):+.2%} in force, {unloading_difference(cost.curve, other):+.2%} in recovery"
    )


def main(arguments: list[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m cases.benchmarks.fe_speed", description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--without-calculix", action="store_true", help="only our own times, against the goals")
    compare = not parser.parse_args(arguments).without_calculix
    if compare and calculix.installed() is None:
        print("ccx is not installed (Debian: apt-get install calculix-ccx): only the goals to compare with")
        compare = False
    compiling = (
        press(Material(100.0, POISSONS_RATIO, 1.0), (1e-3,)).cpu_seconds - press(Material(100.0, POISSONS_RATIO, 1.0), (1e-3,)).cpu_seconds
    )
    print(f"compiling or loading compiled kernels: {compiling:.1f} CPU s, not in what follows", flush=True)
    for name, overlaps, goal in (("to .1 R and back", SHALLOW, SHALLOW_GOAL), ("to .5 R with 14 unloadings", DEEP, DEEP_GOAL)):
        for ratio in RATIOS:
            material = Material(ratio, POISSONS_RATIO, 1.0)
            cost = press(material, overlaps)
            stopped = f"; STOPPED EARLY: {cost.curve.stopped}" if cost.curve.stopped else ""
            print(
                f"E/Y {ratio:5g} {name:28s}{cost.cpu_seconds:7.2f} CPU s, {cost.cpu_seconds / goal:5.2f} of the goal{stopped}", flush=True
            )
            print(f"          {where(cost.curve)}")
            if compare and overlaps == SHALLOW:
                print(f"          {_beside(material, cost)}", flush=True)
    press_in_time(IN_TIME["one term, K constant"], 1e-3)  # loads what was compiled
    in_time()


if __name__ == "__main__":
    main()
