"""Every statement of sections 5 and 5.1 that can be judged, with our numbers over all packings; and all statements together."""

from __future__ import annotations

from collections.abc import Sequence

from cases.edmans_sinka_2020.facts import FAILS, PARTLY, UNTESTED, verdict
from cases.wahn_gan_kamlah_2022.jamming import Exponents
from cases.wahn_gan_kamlah_2022.packing_facts import (
    PAPER_CONTACTS,
    PAPER_ONSET,
    PAPER_STRESS,
    RUBBING,
    SMOOTH,
    Judged,
    both,
    excess,
    from_loose,
    largest,
    listed,
    long_term,
    onsets,
    overstress,
    within,
)
from cases.wahn_gan_kamlah_2022.packing_runs import SWEEP
from cases.wahn_gan_kamlah_2022.packing_statements_rates import RATES, theory
from cases.wahn_gan_kamlah_2022.packings import Runs


def rearrangement(runs: Runs) -> Judged:
    smooth, rubbing = (onsets(from_loose(runs, friction))[0] for friction in (SMOOTH, RUBBING))
    ours = f"no friction: first stress at {smooth.text('.1f', ' %', 100.0)}; μ = {RUBBING:g}: at {rubbing.text('.1f', ' %', 100.0)}"
    reason = "Rearrangement without stress is that of smooth spheres. With friction the bed carries stress almost at once."
    verdict_ = verdict(rubbing.least > 0.05, smooth.least > 0.05)
    return Judged("5, Fig. 13", "a bed at .58 first rearranges without stress", "to about 7 %", ours, verdict_, reason)


def at_onset(runs: Runs) -> Judged:
    _, fraction, contacts = onsets(from_loose(runs, SMOOTH))
    _, fraction_rubbing, contacts_rubbing = onsets(from_loose(runs, RUBBING))
    ours = (
        f"no friction: φ {fraction.text('.3f')}, z {contacts.text('.2f')}; μ = {RUBBING:g}: φ {fraction_rubbing.text('.3f')}, z "
        f"{contacts_rubbing.text('.2f')}"
    )
    near = abs(fraction.mean - 0.62) < 0.015
    whole = near and abs(contacts.mean - PAPER_CONTACTS) < 0.3
    reason = (
        "φ follows from the strain, .58/(1 − ε). Smooth spheres need six contacts each to carry stress; fewer hold only with friction, and "
        "then at a lower fraction. 4.8 at .62 asks for a little friction, or counts spheres that are loose."
    )
    return Judged("5, Fig. 13", "stress begins at φ = .62 with 4.8 contacts each", ".62, 4.8", ours, verdict(whole, near), reason)


def dense_at_once(runs: Runs) -> Judged:
    texts = []
    for friction in (RUBBING, SMOOTH):
        end = onsets(runs.of("15", "E_soft", friction))[0].text(".2f", " %", 100.0)
        cut = onsets(runs.of("cut", "cut at .635", friction))[0].text(".2f", " %", 100.0)
        texts.append(f"μ = {friction:g}: contraction to its end {end}, cut at .635 {cut}")
    free = onsets(runs.of("cut", "cut at .635", SMOOTH))[0]
    reason = (
        "True with friction for packings whose contraction ended by itself, near .635 on the average. The fraction is no guarantee: a "
        "box cut "
        f"off there may have {100.0 * free.most:.1f} % to go, and smooth packings carry no stress at the very start."
    )
    return Judged("5", "at .635 spheres do not move freely", "from the start", "first stress at: " + "; ".join(texts), PARTLY, reason)


def which_friction(runs: Runs) -> Judged:
    strain = "; ".join(f"{mu:g}: {onsets(from_loose(runs, mu))[0].text('.1f', ' %', 100.0)}" for mu in SWEEP)
    stress = "; ".join(f"{mu:g}: {long_term(runs, mu).text('.4f', ' MPa', 1e-6)}" for mu in SWEEP)
    late = [mu for mu in SWEEP if abs(onsets(from_loose(runs, mu))[0].mean - PAPER_ONSET) < 0.015]
    near = [mu for mu in SWEEP if within(long_term(runs, mu), PAPER_STRESS)]
    reason = (
        f"First stress within 1.5 % of strain of the paper's 7 % has μ = {listed(late)}; .0127 MPa lies in the band of μ = {listed(near)}. "
        "So the paper's friction was small, if any."
    )
    ours = f"first stress from .58, by μ: {strain}. Stress at 0.3 %, by μ: {stress}"
    return Judged("3.1", "Coulomb's limit with a coefficient that is not given", "no number", ours, UNTESTED, reason)


def routines(runs: Runs) -> Judged:
    one, other = "HSD, in motion, BCT", "HSD, at rest, BCT"
    rubbing, smooth = (largest(excess(runs, "14", one, other, friction)) < 0.05 for friction in (RUBBING, SMOOTH))
    reason = (
        f"Inertial number 1e-4. At 0.2 %: {both(runs, '14', one, other, 0.002)}. With friction slow motion is rest; without it the "
        f"packing is "
        f"so near to falling apart that even slow motion is not. Without drag: {both(runs, '14', one + ', no drag', other)}; with masses "
        f"times "
        f"1e12, the printed density in N, mm, s: {both(runs, '14', one + ', printed density', other)}."
    )
    place, claim = "5.1, Fig. 14", "HSD in motion and at rest agree"
    return Judged(place, claim, "< 5 %", both(runs, "14", one, other), verdict(rubbing and smooth, rubbing), reason)


def box_loading(runs: Runs) -> Judged:
    motion = both(runs, "14", "HSD, in motion, BC", "HSD, in motion, BCT")
    rest = both(runs, "14", "HSD, at rest, BC", "HSD, at rest, BCT")
    rubbing, smooth = (
        largest(excess(runs, "14", "HSD, in motion, BC", "HSD, in motion, BCT", friction)) < 0.04 for friction in (RUBBING, SMOOTH)
    )
    early = both(runs, "14", "HSD, in motion, BC", "HSD, in motion, BCT", 0.001)
    reason = (
        f"At most 3 %, and with friction far less when loaded slowly. In motion at 0.1 % of strain: {early}; BC is a wave from the faces."
    )
    ours = f"in motion: {motion}. At rest: {rest}"
    return Judged("5.1, Fig. 14", "BC differs from BCT by about 3 %", "3 %", ours, verdict(rubbing and smooth, rubbing), reason)


def viscous_close(runs: Runs) -> Judged:
    ours = both(runs, "14", "MZ in 10 s, in motion, BCT", "HSD, at rest, BCT")
    rest = both(runs, "14", "MZ in 10 s, at rest, BCT", "HSD, at rest, BCT")
    share = overstress(10.0, 250.0 / 42.0)
    reason = (
        f"Contacts that grow evenly for 10 s with τ = 5.95 s keep {100.0 * share:.0f} % of their overstress, so "
        f"{4200.0 / 142.0 * share:+.1f} % "
        f"of stress; in a packing some are younger. At rest: {rest}. The law as printed lacks 1/(1 − ν²), 1.067 for NMC."
    )
    return Judged("5.1, Fig. 14", "MZ in 10 s is the long-term solution of NMC", "< 5 %", ours, FAILS, reason)


def judge(runs: Runs, jammed: Sequence[Exponents]) -> list[Judged]:
    """All statements of the paper, and after them what theory has to say of such packings."""
    first = (rearrangement, at_onset, dense_at_once, which_friction, routines, box_loading, viscous_close)
    return [*(check(runs) for check in (*first, *RATES)), *theory(jammed)]
