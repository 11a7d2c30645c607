"""Every statement of section 5.2, rates, densities and relaxation, and what theory says of jammed packings."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cases.report.judgement import PARTLY, UNTESTED, verdict
from cases.wahn_gan_kamlah_2022.jamming import Exponents
from cases.wahn_gan_kamlah_2022.numbers import half_space, pair_at
from cases.wahn_gan_kamlah_2022.packing_facts import (
    LATE,
    PAPER_STRESS,
    RUBBING,
    SMOOTH,
    Judged,
    both,
    excess,
    inline,
    listed,
    long_term,
    percent,
    power,
    within,
)
from cases.wahn_gan_kamlah_2022.packing_runs import SWEEP, TIMES, rated, threshold
from cases.wahn_gan_kamlah_2022.packings import Band, Run, Runs, band, signed

FIGURE = "5.2, Fig. 15"


def left(runs: Runs, time: float, friction: float) -> Band:
    """Overstress left in a packing of Fig. 15 at the end of the loading, over that of an infinitely fast one."""
    at_end = [{r.seed: r.at(LATE["15"]) for r in runs.of("15", name, friction)} for name in ("E_soft", "E_stiff", rated(time))]
    seeds = sorted(set.intersection(*(set(values) for values in at_end)))
    rows = ([values[seed] for values in at_end] for seed in seeds)
    return band((own - soft) / (stiff - soft) for soft, stiff, own in rows if soft > threshold("PVDF"))


def pair_share(time: float) -> float:
    """The same for two spheres."""
    law = half_space()
    slow, fast = pair_at(law, 1e9), pair_at(law, 1e-9)
    return (pair_at(law, time, steps=2000) - slow) / (fast - slow)


def between_limits(runs: Runs) -> Judged:
    rows = [(t, left(runs, t, RUBBING), left(runs, t, SMOOTH)) for t in TIMES]
    ours = "\n".join(f"in {t:g} s: {a.text('.3f')}; a pair {pair_share(t):.3f}" for t, a, _ in rows)
    smooth = "; ".join(f"in {t:g} s {b.text('.3f')}" for t, _, b in rows if b.packings)
    reason = (
        f"Share of the overstress left at 0.5 %, at rest, μ = {RUBBING:g}: 0 is the slow limit, 1 the fast one. After slow loading more is "
        "left than of a pair, for contacts of a packing are made all along; after fast loading less, for the tangential springs of MZ have "
        f"the long-term modulus, those of E_stiff the stiff one. Without friction: {smooth}; above 1 where a packing gives way differently."
    )
    inside = [all(b.least >= 0.0 and b.most <= 1.0 for _, *bands in rows if (b := bands[k]).packings) for k in (0, 1)]
    return Judged(FIGURE, "all rates lie between the two limits", "yes", ours, verdict(all(inside), inside[0]), reason)


def limits_reached(runs: Runs) -> Judged:
    fast, slow = excess(runs, "15", rated(0.1), "E_stiff", RUBBING), excess(runs, "15", rated(50.0), "E_soft", RUBBING)
    ours = f"10 1/s (in 0.1 s): {percent(fast)} from the fast limit\n0.02 1/s (in 50 s): {percent(slow)} from the slow one"
    close = max(abs(fast.mean), abs(slow.mean)) < 0.03
    reason = f"Stress at 0.5 %, at rest, μ = {RUBBING:g}. A rate is one over the loading time."
    return Judged(FIGURE, "rates 10 and 0.02 1/s reproduce the limits", "sufficient accuracy", ours, verdict(close), reason)


def stiffer_at_first(runs: Runs) -> Judged:
    one, other = "MZ in 1 s, in motion", "MZ in 1 s"
    found = excess(runs, "15", one, other, RUBBING, 0.001)
    reason = (
        f"In motion over at rest at 0.1 % of strain, where smooth packings carry nothing at rest yet. At 0.5 %: "
        f"{inline(both(runs, '15', one, other))}. Inertia and drag, as the paper says."
    )
    return Judged(
        FIGURE, "in motion MZ is stiffer at the beginning", "“kinetic energy”", both(runs, "15", one, other, 0.001),
        verdict(found.least > 0.0, found.mean > 0.0), reason,
    )  # fmt: skip


def scaled_runs(runs: Runs, friction: float) -> list[Run]:
    """The density sweep, heaviest first."""
    moved = (r for r in runs.all if r.figure == "density" and r.name != "at rest" and r.friction == friction)
    return sorted(moved, key=lambda r: -r.density_scaling)


def density(runs: Runs) -> Judged:
    texts, slow = [], {}
    for friction in (RUBBING, SMOOTH):
        rest, moved = runs.of("density", "at rest", friction)[0].at(LATE["15"]), scaled_runs(runs, friction)
        over = [r.at(LATE["15"]) / rest - 1.0 if rest > threshold("PVDF") else math.nan for r in moved]
        words = ", ".join(f"× {power(r.density_scaling)} {signed(100.0 * v, '+.1f')} %" for r, v in zip(moved, over, strict=True))
        texts.append(f"{f'μ = {friction:g}' if friction else 'no friction'}: {words}")
        slow[friction] = abs(over[1]) < 0.05
    numbers = ", ".join(r.name for r in scaled_runs(runs, RUBBING))
    reason = (
        f"One packing, MZ by 0.5 % in 1 s: stress over that at rest, with masses times so much, for inertial numbers {numbers}. Inertia "
        "alone decides: with friction 1e-3 is slow enough and ten times the mass changes nothing; without it what is slow depends on how "
        "near the packing is to falling apart."
    )
    claim = "scaling the density by ten changes nothing"
    return Judged(FIGURE, claim, "almost the same", "\n".join(texts), verdict(all(slow.values()), slow[RUBBING]), reason)


def true_density(runs: Runs) -> Judged:
    moved = [scaled_runs(runs, friction)[-1] for friction in (RUBBING, SMOOTH)]
    steps = max(r.steps * math.sqrt(r.density_scaling) for r in moved)
    kinetic = [f"{f'μ = {r.friction:g}' if r.friction else 'no friction'} {r.kinetic:.0e}" for r in moved]
    free = band(r.kinetic for r in runs.of("14", "HSD, in motion, BCT, no drag", SMOOTH))
    ours = f"1 s takes {power(steps)} steps: not run\nmasses × {power(moved[0].density_scaling)}: to the end"
    reason = (
        "Less mass in the same time is nearer to rest. Kinetic over stored energy with the least masses that were run: "
        f"{', '.join(kinetic)}. What oscillates is a packing without any damping: with HSD, no friction and no drag it is up to "
        f"{free.most:.1g} (Fig. 14)."
    )
    return Judged(FIGURE, "at the true density slow runs oscillate and end early", "no number", ours, UNTESTED, reason)


def long_term_stress(runs: Runs) -> Judged:
    found = {mu: long_term(runs, mu) for mu in SWEEP}
    ours = "\n".join(f"μ = {mu:g}: {1e-6 * b.least:.4f} to {1e-6 * b.most:.4f} MPa" for mu, b in found.items())
    inside = [mu for mu, b in found.items() if within(b, PAPER_STRESS)]
    reason = (
        f"Packings with μ = {listed(inside)} have it; with less friction they carry less, with more friction more. One packing says "
        "little: bands are wide."
    )
    return Judged("5.2, Fig. 16", "long-term stress at 0.3 %", ".0127 MPa", ours, verdict(False, bool(inside)), reason)


def end_of_rest(runs: Runs, name: str, friction: float) -> Band:
    """Stress after 9 s of rest over the long-term one, less 1."""
    pairs = runs.pairs("16", name, "E_soft", friction)
    return band(own.stress[-1] / soft.at(LATE["16"]) - 1.0 for own, soft in pairs if soft.at(LATE["16"]) > threshold("PVDF"))


def relaxation(runs: Runs) -> Judged:
    names = ("MZ, at rest", "MZ, in motion", "MZ, in motion, fast", "MZ, in motion, fast, BC")
    ours = "\n".join(f"{name.removeprefix('MZ, ')}: {percent(end_of_rest(runs, name, RUBBING))}" for name in names)
    fast, rest = (end_of_rest(runs, name, RUBBING) for name in ("MZ, in motion, fast", "MZ, at rest"))
    smooth = "; ".join(f"{name.removeprefix('MZ, ')} {percent(end_of_rest(runs, name, SMOOTH))}" for name in (names[0], names[2]))
    reason = (
        f"Stress after 9 s over the long-term one, μ = {RUBBING:g}; 0.2 % of it is overstress still to go. Loaded at rest or slowly it "
        "ends where it should. Loaded fast (inertial number 1e-3, slow is 1e-4) it ends below, as in the paper: motion on the way up "
        "rearranges the packing. That is history, the paper's first guess, by the inertia of scaled masses. Smooth packings may give way "
        f"differently on the two ways, or not: {smooth}."
    )
    below = fast.most < 0.0, abs(fast.mean) < 0.05
    claim = "relaxation ends 3 % below the long-term stress"
    return Judged("5.2, Fig. 16", claim, "−3 %", ours, verdict(all(below) and rest.mean < -0.01, all(below)), reason)


RATES = (between_limits, limits_reached, stiffer_at_first, density, true_density, long_term_stress, relaxation)


def theory(jammed: Sequence[Exponents]) -> list[Judged]:
    """Jamming and the effective medium."""
    contacts, pressure = band(e.contacts_exponent for e in jammed), band(e.pressure_exponent for e in jammed)
    at_jamming, last = band(e.coordination for e in jammed), band(e.last for e in jammed)
    isostatic, fraction = band(e.isostatic for e in jammed), band(e.fraction for e in jammed)
    medium = band(e.over_medium for e in jammed)
    return [
        Judged(
            "theory", "smooth spheres jam with 6 contacts each at φ ≈ .64", f"6 − 4/N = {isostatic.mean:.3f}",
            f"z by a line: {at_jamming.text('.3f')}\nlast state with pressure: {last.text('.3f')}\nφ_J {fraction.text('.4f')}",
            verdict(abs(at_jamming.mean / isostatic.mean - 1.0) < 0.01 and abs(last.mean / isostatic.mean - 1.0) < 0.02),
            "Contacts of spheres that are held, the packing let go isotropically and sought to rest a thousand times finer. The line is "
            "over the root of φ − φ_J, to where that is 0.",
        ),
        Judged(
            "theory", "z − 6 grows as (φ − φ_J)^½", "0.5", contacts.text(".2f"), verdict(abs(contacts.mean - 0.5) < 0.05),
            "Slope of logarithms, φ − φ_J from 5e-4 to 1e-2.",
        ),
        Judged(
            "theory", "p grows as (φ − φ_J)^1.5", "1.5", pressure.text(".2f"), verdict(abs(pressure.mean - 1.5) < 0.1),
            "The same. In a range this wide z grows too, and with it p.",
        ),
        Judged(
            "theory", "effective medium, p = 2/(3π) φ z E* ε^1.5", "1", f"{medium.text('.2f')} of it", PARTLY,
            "At φ − φ_J = 0.01 with the simulated z. There every contact moves as the box does; in the packing they give way.",
        ),
    ]  # fmt: skip
