"""Every statement of section 5.1: routines, ways of loading, and the long-term state."""

from __future__ import annotations

from cases.edmans_sinka_2020.facts import verdict
from cases.wahn_gan_kamlah_2022.packing_facts import (
    RUBBING,
    SMOOTH,
    Judged,
    both,
    excess,
    inline,
    largest,
    more_contacts,
    overstress,
    percent,
)
from cases.wahn_gan_kamlah_2022.packings import Runs

FIGURE = "5.1, Fig. 14"
REST, MOTION, BOX = "HSD, at rest, BCT", "HSD, in motion, BCT", "HSD, in motion, BC"
VISCOUS_REST, VISCOUS = "MZ in 10 s, at rest, BCT", "MZ in 10 s, in motion, BCT"
#: what the paper's law lacks, 1/(1 - nu^2), for NMC
LACKING = 1.0 / (1.0 - 0.25**2)


def routines(runs: Runs) -> Judged:
    rubbing, smooth = (largest(excess(runs, "14", MOTION, REST, friction)) < 0.05 for friction in (RUBBING, SMOOTH))
    reason = (
        "With friction slow motion is as good as rest. Without it the packing is so near to falling apart that even an inertial number of "
        f"1e-4 is not slow. At 0.2 % of strain: {inline(both(runs, '14', MOTION, REST, 0.002))}. Without drag: "
        f"{inline(both(runs, '14', MOTION + ', no drag', REST))}. With the printed density read in N, mm and s, masses times 10¹²: "
        f"{inline(both(runs, '14', MOTION + ', printed density', REST))}."
    )
    return Judged(
        FIGURE, "HSD in motion and at rest agree", "< 5 %", both(runs, "14", MOTION, REST), verdict(rubbing and smooth, rubbing), reason
    )


def box_loading(runs: Runs) -> Judged:
    motion, rest = both(runs, "14", BOX, MOTION), both(runs, "14", "HSD, at rest, BC", REST)
    found = [largest(excess(runs, "14", BOX, MOTION, friction)) for friction in (RUBBING, SMOOTH)]
    reason = (
        f"In slow motion at most {100.0 * max(found):.1f} % apart. With BC the load is a wave from the faces, which is seen only early: at "
        f"0.1 % of strain {inline(both(runs, '14', BOX, MOTION, 0.001))}. At rest: {inline(rest)}; smooth packings at rest find different "
        "ways to give."
    )
    close = [value < 0.04 for value in found]
    return Judged(FIGURE, "BC differs from BCT by no more than about 3 %", "3 %", motion, verdict(all(close), any(close)), reason)


def most_deviating(runs: Runs) -> Judged:
    found = {
        friction: {name: excess(runs, "14", own, REST, friction) for name, own in (("BC", BOX), ("MZ", VISCOUS))}
        for friction in (RUBBING, SMOOTH)
    }
    ours = "\n".join(
        f"{f'μ = {friction:g}' if friction else 'no friction'}: BC {percent(own['BC'])}, MZ {percent(own['MZ'])}"
        for friction, own in found.items()
    )
    holds = [abs(own["BC"].mean) > abs(own["MZ"].mean) for own in found.values()]
    reason = "From HSD at rest, after 1 %. MZ is farthest, by its overstress; BC is where BCT is."
    return Judged(FIGURE, "of all curves BC deviates most", "no number", ours, verdict(all(holds), any(holds)), reason)


def contacts(runs: Runs) -> Judged:
    texts, more = [], []
    for friction in (RUBBING, SMOOTH):
        early, late = (more_contacts(runs, "14", MOTION, BOX, friction, strain) for strain in (0.001, 0.01))
        name = f"μ = {friction:g}" if friction else "no friction"
        texts.append(f"{name}: {percent(early)} at 0.1 %, {percent(late)} at 1 %")
        more.append(early.least > 0.0 and late.least > 0.0)
    reason = "Contacts per sphere of BCT over those of BC, in motion. Slow loading leaves no more of the trial configuration than scatter."
    return Judged(FIGURE, "BCT makes more contacts than BC", "no number", "\n".join(texts), verdict(all(more), any(more)), reason)


def viscous_close(runs: Runs) -> Judged:
    found = [largest(excess(runs, "14", VISCOUS, REST, friction)) < 0.05 for friction in (RUBBING, SMOOTH)]
    share = overstress(10.0, 250.0 / 42.0)
    reason = (
        f"Contacts that grow evenly for 10 s with τ = 5.95 s keep {100.0 * share:.0f} % of their overstress, so "
        f"{4200.0 / 142.0 * share:+.1f} % of stress; in a packing some are younger. MZ at rest: "
        f"{inline(both(runs, '14', VISCOUS_REST, REST))}."
    )
    ours = both(runs, "14", VISCOUS, REST)
    return Judged(FIGURE, "MZ in 10 s is the long-term solution of NMC", "< 5 %", ours, verdict(all(found), any(found)), reason)


def softer(runs: Runs) -> Judged:
    found = excess(runs, "14", VISCOUS, MOTION, RUBBING)
    reason = (
        f"MZ over HSD, both in motion, after 1 %. MZ keeps overstress and cannot be softer. The law as printed lacks 1/(1 − ν²), "
        f"{LACKING:.3f} for NMC; with that left out ours would still be {100.0 * ((1.0 + found.mean) / LACKING - 1.0):.0f} % above."
    )
    ours = both(runs, "14", VISCOUS, MOTION)
    return Judged(
        FIGURE, "at the end MZ is slightly softer than HSD", "no number", ours, verdict(found.most < 0.0, found.least < 0.0), reason
    )


ROUTINES = (routines, box_loading, most_deviating, contacts, viscous_close, softer)
