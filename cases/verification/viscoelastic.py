"""What the viscoelastic solver claims, against theory, the elastic solver and its own finer meshes.

    python -m cases.verification.viscoelastic [PART ...]

Some four minutes on one core. Prints claim, measured value and bound as it goes and ends with exit code 1 if a claim is broken.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator

import numpy as np
from scipy.integrate import quad
from scipy.interpolate import CubicSpline, PchipInterpolator

from cases.verification.continuum import Check, at_most
from contactlaws.curve import Curve, FloatArray
from contactlaws.foundation import follow
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.pair import effective_in_time
from contactlaws.path import scan
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from fem.assembly import discretise
from fem.march import Steps
from fem.mesh import spheroid
from fem.press import core_size, moduli_of, press
from fem.press_in_time import press_in_time, springs_on_mesh
from fem.programme import Knot, Programme, creep, ramp_hold_release, rows
from fem.turning import turned_force
from fem.walk import walk
from fem.walk_in_time import TimeWalk, walk_in_time

#: PVDF of Wahn, Gan & Kamlah 2022 as a Maxwell-Zener element
PVDF = Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,))
NU = 0.4314
TOGETHER, CONSTANT_BULK = uniaxial(PVDF, NU), uniaxial(PVDF, NU, constant_bulk=True)
#: three times five decades apart in all, a tenth of the modulus left
BROAD = uniaxial(Relaxation(1770.5e6, (0.3, 0.3, 0.3), (0.01, 1.0, 1000.0)), 0.3)
MATERIALS = {"nu constant": TOGETHER, "K constant": CONSTANT_BULK, "three terms": BROAD}
DEPTHS = (0.02, 0.1)


def limits() -> Iterator[Check]:
    """Infinitely fast and slow presses are elastic ones."""
    for name, material in MATERIALS.items():
        for depth in DEPTHS:
            for pace, other, word in ((1e-8, material.instantaneous, "fast"), (1e8, material.long_term, "slow")):
                duration = pace * material.relaxation_times[0 if pace < 1.0 else -1]
                curve = press_in_time(material, ramp_hold_release(depth, duration))
                elastic = press(other, max_overlap=depth)
                overlap, force = (column[elastic.rows(0)][1:] for column in (elastic.overlap, elastic.force))
                same = curve.overlap >= overlap[0]
                expected = np.exp(CubicSpline(np.log(overlap), np.log(force))(np.log(curve.overlap[same])))
                error = np.abs(curve.force[same] - expected).max() / expected.max()
                yield at_most(f"{name}, to {depth:g} R infinitely {word}: force against the elastic curve, over the largest", error, 1e-3)


def on_mesh(material: PronyViscoelastic, depth: float, programme: Programme, steps: int, divisions: int) -> tuple[TimeWalk, FloatArray]:
    """A run on one mesh, and the force of springs on the elastic curve of that mesh in the same steps."""
    body = discretise(spheroid(divisions, core_size(depth, depth), 1.0, 1.0))
    moduli = moduli_of(material.instantaneous)
    plan = rows(programme, min(material.relaxation_times), steps)
    plan = [row._replace(target=row.target / (material.youngs_modulus if row.by_force else 1.0)) for row in plan]
    run = walk_in_time(body, moduli, material, plan)
    elastic = walk(body, moduli, depth, (), Steps(first=0.1, growth=2.0))
    springs = follow(springs_on_mesh(body, material, elastic, run), material.reduced, run.time, run.overlap)
    return run, springs.force


def lee_radok() -> Iterator[Check]:
    """While the contact grows: the hereditary integral of the elastic curve."""
    for depth in DEPTHS:
        for name, material in (("nu constant", TOGETHER), ("three terms", BROAD)):
            run, _ = on_mesh(material, depth, ramp_hold_release(depth, 1.0, 2.0), 20, 8)
            terms, force = np.zeros(len(material.relaxation_times)), np.zeros(run.time.size)
            g, tau = np.array(material.shear_fractions), np.array(material.relaxation_times)
            for i in range(1, run.time.size):
                x = (run.time[i] - run.time[i - 1]) / tau
                terms = np.exp(-x) * terms - np.expm1(-x) / x * (run.elastic[i] - run.elastic[i - 1])
                force[i] = (1.0 - g.sum()) * run.elastic[i] + g @ terms
            error = np.abs(run.force - force).max() / force.max()
            yield at_most(f"{name}, ramp and hold at {depth:g} R, every step of the mesh: Lee & Radok on its elastic forces", error, 1e-10)
        curve = press_in_time(TOGETHER, ramp_hold_release(depth, 1.0, 2.0), tolerance=0.0025)
        elastic = press(TOGETHER.instantaneous, max_overlap=depth, tolerance=0.0025)
        for when in (1.0, 2.0, 3.0):
            row = int(np.argmin(abs(curve.time - when)))
            exact = hereditary(elastic, TOGETHER.reduced, float(curve.time[row]), depth)
            error = float(curve.force[row]) / exact - 1.0
            yield at_most(f"nu constant, {depth:g} R at {when:g} s: quadrature over the elastic solver's own curve", error, 1e-4)


def hereditary(elastic: Curve, modulus: Relaxation, time: float, depth: float) -> float:
    """int psi(t - s) dF_e for a ramp of 1 s to `depth` and a hold, with the elastic curve to the power 2/3 interpolated."""
    r = elastic.rows(0)
    straight = PchipInterpolator(elastic.overlap[r], elastic.force[r] ** (2.0 / 3.0))
    slope = straight.derivative()

    def rate(s: float) -> float:
        return float(1.5 * np.sqrt(straight(s * depth)) * slope(s * depth) * depth)

    top = min(time, 1.0)
    psi = modulus._replace(instantaneous=1.0)
    return float(quad(lambda s: float(psi.at(time - s)) * rate(s), 0.0, top, limit=400, epsabs=0.0, epsrel=1e-6)[0])


def ting() -> Iterator[Check]:
    """While it shrinks, opens and closes again: independent springs (Ting's solution and what goes beyond it) on each mesh's own curve."""
    again = (*ramp_hold_release(1.0, 1.0, 2.0, 0.2, 0.3), Knot(4.0, 0.3), Knot(4.5, 0.8), Knot(5.5, 0.0))
    cases = {
        "ramp and release": ramp_hold_release(1.0, 1.0, 0.0, 1.0),
        "ramp, hold, release": ramp_hold_release(1.0, 1.0, 2.0, 1.0),
        "release and meet again": again,
        "opened and closed before recovery": (*ramp_hold_release(1.0, 1.0, 2.0, 0.2), Knot(3.5, 1.1), Knot(4.0, 0.0)),
    }
    for depth in DEPTHS:
        for words, unit in cases.items():
            programme = tuple(knot._replace(overlap=depth * (knot.overlap or 0.0)) for knot in unit)
            deepest = max(knot.overlap or 0.0 for knot in programme)
            for divisions, bound in ((8, 1e-3), (16, 5e-4)):
                run, springs = on_mesh(TOGETHER, deepest, programme, 40, divisions)
                error = np.abs(run.force - springs).max() / run.force.max()
                claim = (
                    f"nu constant, {words}, {depth:g} R, {divisions} divisions: mesh against springs on its elastic curve, over the largest"
                )
                yield at_most(claim, error, bound)
    run, springs = on_mesh(CONSTANT_BULK, 0.1, ramp_hold_release(0.1, 1.0, 2.0, 1.0), 40, 16)
    error = np.abs(run.force - springs).max() / run.force.max()
    yield at_most("K constant, ramp, hold, release, 0.1 R: the same (Poisson's ratio changes the finite-size part)", error, 6e-3)


def reciprocity() -> Iterator[Check]:
    """Creep and relaxation are one material; what is left of the dent goes."""
    force = 0.02**1.5 * 4.0 / 3.0 * TOGETHER.instantaneous.reduced_modulus
    for name, material in (("nu constant", TOGETHER), ("K constant", CONSTANT_BULK)):
        crept = press_in_time(material, creep(force, 1.0, 10.0), tolerance=0.0025)
        knots = tuple(Knot(float(t), float(d)) for t, d in zip(crept.time, crept.overlap, strict=True))
        back = press_in_time(material, knots, tolerance=0.0025)
        held = back.time >= 1.0
        error = np.abs(back.force[held] / force - 1.0).max()
        yield at_most(f"{name}: creep under a constant force, its overlap prescribed: force", error, 2e-3)
        rest = press_in_time(material, creep(force, 1.0, 10.0, 100.0))
        yield at_most(f"{name}: overlap left 56 relaxation times after the force was taken off, over the largest", left_of(rest), 1e-4)


def left_of(curve: Curve) -> float:
    """Last overlap over the largest."""
    return float(curve.overlap[-1] / curve.overlap.max())


def order() -> Iterator[Check]:
    """Of the steps in time, on one mesh: the force at the end of a release at half the depth."""
    programme = (*ramp_hold_release(0.02, 2.0)[:2], Knot(3.0, 0.01))
    forces = [on_mesh(TOGETHER, 0.02, programme, steps, 8)[0].force[-1] for steps in (8, 16, 32, 256)]
    errors = np.abs(np.array(forces[:3]) / forces[3] - 1.0)
    found = float(np.log2(errors[0] / errors[2]) / 2.0)
    yield Check(f"order of the time step (errors {', '.join(f'{e:.1e}' for e in errors)} for 8, 16, 32 steps a segment)", found, 1.5, 3.0)


def turning() -> Iterator[Check]:
    """What it would change if the stress of the past turned, or stretched, with the material: a choice of the continuum model."""
    for depth in (0.02, 0.1, 0.2):
        for left in (0.7715, 0.1):
            ours, with_body = turned_force(PVDF._replace(fractions=(1.0 - left,)), NU, depth)
            claim = f"end of a ramp of a relaxation time to {depth:g} R, {1.0 - left:.0%} relaxing: second instead of first Piola-Kirchhoff"
            yield at_most(claim, with_body / ours - 1.0, 0.03)


def bodies() -> Iterator[Check]:
    """Two spheres as one: each by finite elements on the flat under the force of both, their overlaps added, against one law of one series.

    Where the stiffer sphere is as much larger as it is stiffer and both relax alike, the surface between them stays flat and the sum is
    exact. Where they relax apart it does not stay flat; by how much that matters is what the second pair shows.
    """
    stiff = TOGETHER._replace(youngs_modulus=2.0 * TOGETHER.youngs_modulus)
    slow = stiff._replace(relaxation_times=(18.0,), shear_fractions=(0.5,))
    for words, other, bound in (("relaxing alike", stiff, 5e-3), ("relaxing apart, by half in 18 s", slow, 2e-2)):
        force = 0.002**1.5 * 4.0 / 3.0 * TOGETHER.instantaneous.reduced_modulus
        programme = creep(force, 1.0, 10.0)
        one = press_in_time(TOGETHER, programme, tolerance=0.0025)
        two = press_in_time(other, programme, radius=2.0, tolerance=0.0025)
        body = effective_in_time(TOGETHER, 1.0, other, 2.0)
        law = maxwell_zener_ting(body.modulus, body.radius, body.poissons_ratio)
        times = np.linspace(0.0, one.time[-1], 4001)
        overlap = np.interp(times, one.time, one.overlap) + np.interp(times, two.time, two.overlap)
        held = scan(law, 0.5 * overlap, times).force[times >= 1.0]
        error = np.abs(held / force - 1.0).max()
        yield at_most(
            f"two spheres, the second twice as large and stiff, {words}: force of one law at the sum of both overlaps", error, bound
        )
    for name, material in (("K constant", CONSTANT_BULK), ("three terms", BROAD)):
        for depth, bound in ((0.02, 5e-3), (0.1, 1e-2)):
            curve = press_in_time(material, ramp_hold_release(depth, 1.0, 2.0, 1.0))
            ratio = 0.5 * (material.poissons_ratio + material.long_term.poissons_ratio)
            law = maxwell_zener_ting(material.reduced, 1.0, ratio)
            times = np.unique(np.concatenate([curve.time, np.linspace(0.0, curve.time[-1], 2001)]))
            force = np.interp(curve.time, times, scan(law, np.interp(times, curve.time, curve.overlap), times).force)
            error = np.abs(force - curve.force).max() / curve.force.max()
            yield at_most(f"{name}, ramp, hold, release at {depth:g} R: the law of the body alone, over the largest force", error, bound)


def meshes() -> Iterator[Check]:
    """Default tolerance against a fourth of it, over the largest force."""
    for depth in DEPTHS:
        for name, material in MATERIALS.items():
            programme = ramp_hold_release(depth, 1.0, 2.0, 1.0)
            usual, finer = press_in_time(material, programme), press_in_time(material, programme, tolerance=0.0025)
            error = np.abs(np.interp(usual.time, finer.time, finer.force) - usual.force).max() / finer.force.max()
            yield at_most(f"{name}, ramp, hold, release at {depth:g} R: tolerance .01 against .0025", error, 5e-3)
            promised = usual.errors["force"]
            yield at_most(f"  the same, over the error it states ({promised:.2%})", error / promised, 1.0)


PARTS: dict[str, Callable[[], Iterator[Check]]] = {
    part.__name__: part for part in (limits, lee_radok, ting, reciprocity, order, turning, bodies, meshes)
}


def main(names: list[str]) -> int:
    """Run the parts named, or all; the exit code."""
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        print(f"no part {', '.join(unknown)}; there are {', '.join(PARTS)}", file=sys.stderr)
        return 2
    broken = 0
    for name in names or PARTS:
        for check in PARTS[name]():
            broken += not check.ok
            bound = f"<= {check.high:.3g}" if check.low == 0.0 else f"{check.low:.3g} to {check.high:.3g}"
            print(f"{'ok    ' if check.ok else 'BROKEN'} {check.measured:11.4g}  {bound:16s} {check.claim}", flush=True)
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
