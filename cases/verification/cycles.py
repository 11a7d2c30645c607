"""Partial unloading and reloading cycles by finite elements: what a law that reloads along its unloading curve leaves out.

Four cycles from one overlap: two to half the force, two to separation; then the loading goes on. Of the cycles: the energy dissipated
over the work that the unloading gives back (hysteresis); the largest difference of the force of reloading from that of unloading at
equal overlap, over the force at the start (departure); the force when back at the overlap it started from, over the force at the start,
less 1. Of the loading that goes on: the largest difference from the loading that was never interrupted, over a tenth of the overlap. Then
a law along the same overlaps: its largest difference from the cycles, each force over the one at the start. That includes what this one
mesh is itself off by in the recovered overlap, which `fem.press` extrapolates away: it checks the law's cycles, not its unloading.

What is measured: reloading follows the unloading curve within .1 % of the force at the start, is back there within .1 %, and dissipates up
to .6 % of what the unloading gives back: nothing that a law needs a second memory for.

    python -m cases.verification.cycles [--law NAME] [--only E/Y]

Exit code 1 if a bound on what reloading leaves out, `BOUNDS`, is broken.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

import fem
from calibration import fit
from contactlaws import dispatch
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.path import trace
from contactlaws.whole_range import whole_range
from fem.cycle import CycleCurve, Measures, measures, onward_difference, press_cycle

RATIOS = (10.0, 50.0, 200.0, 1000.0)
OVERLAPS = (0.02, 0.1, 0.3)
SHARES = (0.5, 0.5, 0.0, 0.0)
NU = 0.3
#: what no cycle exceeds: hysteresis, departure, back; and the loading that goes on
BOUNDS, ONWARD_BOUND = Measures(0.01, 0.001, 0.001), 0.002
#: of the table, with their widths
COLUMNS = (
    ("E/Y", 8),
    ("from", 9),
    ("down to", 12),
    ("hysteresis", 12),
    ("departure", 11),
    ("back", 10),
    ("onward", 10),
    ("law off", 10),
    ("CPU", 12),
)


def law_for(name: str, material: Material, overlap: float) -> Any:
    """The law of a body of radius 1: ours from the material alone, any other fitted to a curve that unloads from the same overlap."""
    if name == "whole_range":
        return whole_range(material, 1.0)
    return fit([fem.press(material, unload_from=[0.5 * overlap, overlap], max_overlap=1.2 * overlap)], name).law


def law_differences(law: Any, curve: CycleCurve) -> list[float]:
    """For each cycle the largest difference of the law's force from that of the finite elements, each over its own force at the start."""
    legs = [leg for loop in curve.loops for leg in (loop.down, loop.up)]
    path = np.concatenate([[curve.start_overlap], *(np.maximum(leg.overlap, 0.0) for leg in legs)])
    force = np.concatenate([[curve.start_force], *(leg.force for leg in legs)])
    found = trace(law, path).force
    away = np.abs(found / found[0] - force / curve.start_force)
    ends = np.cumsum([loop.down.force.size + loop.up.force.size for loop in curve.loops])
    return [float(away[1 + start : 1 + end].max()) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def broken(curve: CycleCurve) -> Iterator[str]:
    """One sentence for each bound that a cycle breaks."""
    for number in range(len(curve.loops)):
        for name, value, bound in zip(Measures._fields, measures(curve, number), BOUNDS, strict=True):
            if not abs(value) <= bound:
                yield f"cycle {number + 1}: {name} {value:.3%} beyond {bound:.2%}"
    if not onward_difference(curve) <= ONWARD_BOUND:
        yield f"the loading that goes on differs by {onward_difference(curve):.3%}, beyond {ONWARD_BOUND:.2%}"


def lines(ratio: float, overlap: float, name: str) -> tuple[list[str], bool]:
    """The rows of the table for one body and overlap, and whether the bounds hold."""
    material = Material(ratio, NU, 1.0)
    try:
        curve = press_cycle(material, overlap, SHARES)
    except InputError as reason:
        return [f"{ratio:8g}{overlap:6g}  {reason}"], False
    law = law_differences(law_for(name, material, overlap), curve)
    rows = []
    for number, loop in enumerate(curve.loops):
        found = measures(curve, number)
        head = f"{ratio:8g}{curve.start_overlap:9.4f}" if number == 0 else " " * 17
        to = "separation" if loop.share == 0.0 else f"{loop.share:g} F"
        rows.append(f"{head}{to:>12s}{found.hysteresis:12.3%}{found.departure:11.3%}{found.back:+10.3%}{'':10s}{law[number]:10.2%}")
    rows.append(f"{'':62s}{onward_difference(curve):10.4%}{curve.provenance['cpu_seconds']:20.1f} s")
    faults = list(broken(curve))
    return [*rows, *(f"    BROKEN: {fault}" for fault in faults)], not faults


def main(arguments: list[str] | None = None) -> int:
    """Print the table; 0, or 1 if a bound is broken, or 2 if the law is unknown."""
    parser = argparse.ArgumentParser(prog="python -m cases.verification.cycles", description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--law", default="whole_range", help="registered law to compare; default whole_range")
    parser.add_argument("--only", type=float, help="only this E/Y")
    given = parser.parse_args(arguments)
    if given.law not in dispatch.laws():
        print(f"unknown law {given.law}; there are {', '.join(dispatch.laws())}", file=sys.stderr)
        return 2
    print(f"cycles at nu = {NU:g}, about a minute on one core; overlaps over the radius; law: {given.law}")
    print("".join(f"{name:>{width}s}" for name, width in COLUMNS))
    held = True
    for ratio in RATIOS if given.only is None else (given.only,):
        for overlap in OVERLAPS:
            rows, fine = lines(ratio, overlap, given.law)
            held &= fine
            print("\n".join(rows), flush=True)
    print("all bounds held" if held else "BROKEN")
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main())
