"""Every statement of section 5 that can be judged, with our numbers over all packings; and all statements of the paper together."""

from __future__ import annotations

from collections.abc import Sequence

from cases.report.judgement import UNTESTED, verdict
from cases.wahn_gan_kamlah_2022.jamming import Exponents
from cases.wahn_gan_kamlah_2022.packing_facts import (
    LATE,
    PAPER_CONTACTS,
    PAPER_FRACTION,
    PAPER_ONSET,
    PAPER_STRESS,
    RUBBING,
    SMOOTH,
    Judged,
    excess,
    from_loose,
    largest,
    listed,
    long_term,
    onsets,
    within,
)
from cases.wahn_gan_kamlah_2022.packing_runs import SWEEP
from cases.wahn_gan_kamlah_2022.packing_statements_rates import RATES, theory
from cases.wahn_gan_kamlah_2022.packing_statements_routines import ROUTINES
from cases.wahn_gan_kamlah_2022.packings import Runs, band

FIGURE = "5, Fig. 13"
#: strain before which stress counts as there from the start, a fifth of what is pressed
AT_ONCE = 0.002


def rearrangement(runs: Runs) -> Judged:
    smooth, rubbing = (onsets(from_loose(runs, friction))[0] for friction in (SMOOTH, RUBBING))
    ours = f"first stress at\nμ = {RUBBING:g}: {rubbing.text('.1f', ' %', 100.0)}\nno friction: {smooth.text('.1f', ' %', 100.0)}"
    reason = "Only smooth spheres rearrange without stress. With friction the bed carries stress almost at once."
    found = verdict(rubbing.least > 0.05, smooth.least > 0.05)
    return Judged(FIGURE, "a bed at .58 first rearranges without stress", "to about 7 %", ours, found, reason)


def at_onset(runs: Runs) -> Judged:
    _, fraction, contacts = onsets(from_loose(runs, SMOOTH))
    _, fraction_rubbing, contacts_rubbing = onsets(from_loose(runs, RUBBING))
    ours = (
        f"μ = {RUBBING:g}: φ {fraction_rubbing.text('.3f')}, z {contacts_rubbing.text('.2f')}\n"
        f"no friction: φ {fraction.text('.3f')}, z {contacts.text('.2f')}"
    )
    near = abs(fraction.mean - PAPER_FRACTION) < 0.015
    whole = near and abs(contacts.mean - PAPER_CONTACTS) < 0.3
    nearest = min(SWEEP, key=lambda mu: abs(onsets(from_loose(runs, mu))[1].mean - PAPER_FRACTION))
    there = onsets(from_loose(runs, nearest))[2].mean
    reason = (
        "φ follows from the strain: .58/(1 − ε). Smooth spheres need six contacts each to carry stress, fewer hold by friction alone, "
        f"and then at a lower fraction. No coefficient gives both numbers (table below): at .62, with μ = {nearest:g}, it is {there:.1f} "
        "contacts."
    )
    return Judged(FIGURE, "stress begins at φ = .62 with 4.8 contacts each", ".62, 4.8", ours, verdict(whole, near), reason)


def compacted(runs: Runs) -> Judged:
    names = (("at rest", "compacted, at rest"), ("in motion", "compacted, in motion"))
    lines = ["after 1 % more, in MPa"]
    for friction in (RUBBING, SMOOTH):
        stress = (f"{word} {band(r.at(LATE['13']) for r in runs.of('13', name, friction)).text('.3f', '', 1e-6)}" for word, name in names)
        lines.append(f"{f'μ = {friction:g}' if friction else 'no friction'}: {', '.join(stress)}")
    close = [largest(excess(runs, "13", names[1][1], names[0][1], friction)) < 0.05 for friction in (RUBBING, SMOOTH)]
    reason = (
        "A bed that has just begun to carry stress goes on rearranging: at rest it gives way again and again, in motion inertia and drag "
        "hold it up, at an inertial number of 1e-4. Motion and rest agree far above the first stress, and with friction: next statements."
    )
    claim = "from the first stress on, motion and rest can be compared"
    return Judged(FIGURE, claim, "no number", "\n".join(lines), verdict(all(close), any(close)), reason)


def dense_at_once(runs: Runs) -> Judged:
    texts, at_once = [], []
    for friction in (RUBBING, SMOOTH):
        end = onsets(runs.of("15", "E_soft", friction))[0]
        cut = onsets(runs.of("cut", "cut at .635", friction))[0]
        at_once.append(end.most < AT_ONCE)
        name = f"μ = {friction:g}" if friction else "no friction"
        texts += [f"{name}: {end.text('.2f', ' %', 100.0)}", f"{name}, cut off at .635: {cut.text('.2f', ' %', 100.0)}"]
    free = onsets(runs.of("cut", "cut at .635", SMOOTH))[0]
    reason = (
        "With friction stress begins at once where the contraction ended by itself, at .635 on the average. The fraction is no guarantee: "
        f"a contraction cut off there may have {100.0 * free.most:.1f} % to go, and smooth packings carry no stress at the very start."
    )
    ours = "first stress at\n" + "\n".join(texts)
    found = verdict(all(at_once), at_once[0])
    return Judged("5", "at .635 spheres do not move freely", "from the start", ours, found, reason)


def which_friction(runs: Runs) -> Judged:
    late = [mu for mu in SWEEP if abs(onsets(from_loose(runs, mu))[0].mean - PAPER_ONSET) < 0.015]
    near = [mu for mu in SWEEP if within(long_term(runs, mu), PAPER_STRESS)]
    ours = f"first stress at 5.5 to 8.5 %: μ = {listed(late)}\n.0127 MPa within the band: μ = {listed(near)}"
    reason = (
        "The paper has Coulomb's limit and names no coefficient. Its two numbers ask for a small one, and for different ones; both "
        "packings are single ones. All statements are therefore judged with μ = 0.3, as dry grains have, and without friction."
    )
    return Judged("3.1, Figs. 13, 16", "friction, with a coefficient that is not given", "no number", ours, UNTESTED, reason)


FIRST = (rearrangement, at_onset, compacted, dense_at_once, which_friction)


def judge(runs: Runs, jammed: Sequence[Exponents]) -> list[Judged]:
    """All statements of the paper, and after them what theory has to say of such packings."""
    return [*(check(runs) for check in (*FIRST, *ROUTINES, *RATES)), *theory(jammed)]
