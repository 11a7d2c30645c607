"""Section 4.5: the models of others."""

from __future__ import annotations

import numpy as np

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Points
from cases.edmans_sinka_2020.facts import FAILS, HOLDS, NU, PARTLY, UNTESTED, Facts, Finding, Lacking, Statement, span, verdict
from cases.edmans_sinka_2020.figures_models import FIG_12, relative_depth


def etsion_falls(facts: Facts) -> Finding:
    low = facts.points(1.0)
    ours = f"Eq. 6 falls with δ for every material; α rises from {low.exponent[0]:.2f} to {low.exponent[-1]:.2f} at E/σ_y = 1"
    return Finding(ours, verdict(low.exponent[-1] > low.exponent[0]), "Eq. 6 was fitted at E/σ_y from 297 to 2464.")


def etsion_at_high(facts: Facts) -> Finding:
    points = facts.points(1000.0)
    predicted = paper.etsion_exponent(relative_depth(points))
    top = int(np.argmax(points.exponent))
    ours = (
        f"E/σ_y = 1000: α {points.exponent[0]:.3f}, {points.exponent[top]:.3f} at δ/R = {points.depth[top]:g}, {points.exponent[-1]:.3f} "
        f"at the end; Eq. 6 {predicted[0]:.3f} to {predicted[-1]:.3f}, off by {np.abs(predicted / points.exponent - 1.0).max():.0%} at "
        "most"
    )
    return Finding(
        ours,
        verdict(top == 0, points.exponent[-1] < points.exponent[0]),
        "The trend is falling only beyond the overlap at which the whole body flows.",
    )


def quoted_ranges(facts: Facts) -> Finding:
    first, last = (0.01 / float(paper.yield_depth(200.0, NU, r)) for r in ("unsquared", "corrected")), []
    last = [0.5 / float(paper.yield_depth(1000.0, NU, r)) for r in ("unsquared", "corrected")]
    small = list(first)
    ours = f"{small[0]:.0f} and {last[0]:.3g} by Eq. 5 without its square; {small[1]:.0f} and {last[1]:.3g} corrected"
    reason = (
        "366 follows from Eq. 5 as printed only if its numerator is not squared; 4.75·10⁵ from nothing, the same form gives 4.575·10⁵ "
        "(digits exchanged)."
    )
    return Finding(ours, FAILS if abs(last[0] / 4.75e5 - 1.0) > 0.01 else PARTLY, reason)


def stiffness_ratio(facts: Facts) -> Finding:
    return Finding("identity", HOLDS, "By the definitions of secant stiffnesses.")


def luding_transition(facts: Facts) -> Finding:
    return Finding(
        "—",
        UNTESTED,
        "A matter of words: in Luding's model the stiffness grows up to δ* and is constant beyond, so δ* is where plastic stiffening ends.",
    )


def _worst_line(points: Points, abscissa: np.ndarray) -> float:
    """Largest relative error of the straight line with the least sum of squared relative errors."""
    ratio = points.stiffness * points.depth
    design = np.column_stack([abscissa, np.ones(abscissa.size)]) / ratio[:, None]
    line = np.linalg.lstsq(design, np.ones(abscissa.size), rcond=None)[0]
    return float(np.abs(design @ line - 1.0).max())


def _lines(facts: Facts, abscissa: str) -> Finding:
    found = {}
    for modulus in (20.0, 100.0, 1000.0):
        points = facts.points(modulus).where(facts.points(modulus).plastic)
        found[modulus] = _worst_line(points, points.depth if abscissa == "overlap" else points.force)
    ours = (
        f"best line in the {abscissa} for each material: off by up to {', '.join(f'{100 * v:.0f} %' for v in found.values())} at E/σ_y = "
        "20, 100, 1000"
    )
    return Finding(
        ours, verdict(min(found.values()) > 0.1), "Lines with the least squared relative errors on the plastic unloadings, intercept free."
    )


def luding(facts: Facts) -> Finding:
    return _lines(facts, "overlap")


def walton_braun(facts: Facts) -> Finding:
    return _lines(facts, "force")


def etsion_monotonic(facts: Facts) -> Finding:
    recovered = [
        1.0 / float(paper.etsion_stiffness(0.1, 0.1 / paper.yield_depth(modulus, NU))) for modulus in (100.0, 200.0, 500.0, 1000.0)
    ]
    deeper = [1.0 / float(paper.etsion_stiffness(depth, depth / paper.yield_depth(1000.0, NU))) for depth in paper.DEPTHS]
    with_depth, with_modulus = bool((np.diff(deeper) > 0.0).all()), bool((np.diff(recovered) > 0.0).all())
    ours = (
        f"Eq. 9: recovered overlap {span(deeper, '.2g')} R rising with δ at E/σ_y = 1000; {recovered[0]:.4f} to {recovered[-1]:.4f} R "
        "falling with E/σ_y at δ/R = 0.1"
    )
    reason = "With the overlap it rises; with E/σ_y it falls, in Eq. 9 as in every simulation, since a stiffer body recovers less."
    return Finding(ours, verdict(with_depth and with_modulus, with_depth), reason)


def proportion_falls(facts: Facts) -> Finding:
    points = facts.points(1000.0)
    recovered, share = 1.0 / points.stiffness, 1.0 / (points.stiffness * points.depth)
    top = int(np.argmax(recovered))
    ours = (
        f"E/σ_y = 1000: recovered overlap largest at δ/R = {points.depth[top]:g} ({recovered[top]:.5f} R), {recovered[-1]:.5f} R from "
        "0.5; its share of δ falls from the start"
    )
    reason = "What begins to fall at large overlap is the overlap recovered; its proportion falls from first yield on."
    return Finding(ours, verdict(bool(np.argmax(share) > 0), 0 < top < recovered.size - 1), reason)


def etsion_recovers_more(facts: Facts) -> Finding:
    ratios = []
    for modulus in FIG_12:
        points = facts.points(modulus)
        ratios.append(paper.etsion_stiffness(points.depth, relative_depth(points)) / points.stiffness)
    ours = (
        "ρ of Eq. 9 over ours " + ", ".join(f"{r[0]:.2f} to {r[-1]:.3f}" for r in ratios) + " (δ/R 0.01 to 0.5) at E/σ_y = 200, 500, 1000"
    )
    holds = all((np.diff(r) < 0.0).all() for r in ratios) and ratios[0][0] > ratios[1][0] > ratios[2][0]
    return Finding(ours, verdict(bool(holds)), "Best at the smallest overlap and stiffness ratio, and then ever too soft.")


def mesarovic_johnson(facts: Facts) -> Finding:
    found = {}
    for modulus in (1.0, 2.0, 5.0, 10.0, 20.0, 100.0, 1000.0):
        curve = facts.curve(modulus)
        if curve.contact_radius is None:
            raise Lacking("the contact radius")
        rows = curve.rows(facts.study.unloadings[modulus, NU][-1].branch)
        share = np.linspace(0.02, 1.0, 99)
        force = curve.force[rows] / curve.force[rows][0]
        radius = np.interp(share, force[::-1], (curve.contact_radius[rows] / curve.contact_radius[rows][0])[::-1])
        found[modulus] = float(np.sqrt(np.mean((paper.mesarovic_johnson_force(radius) - share) ** 2)))
    ours = "rms difference of F/F_max: " + ", ".join(f"{value:.2f} ({modulus:g})" for modulus, value in found.items())
    low, high = min(found[m] for m in (1.0, 2.0, 5.0, 10.0)), min(found[m] for m in (100.0, 1000.0))
    closest = min(found, key=lambda modulus: found[modulus])
    reason = (
        f"Closest at E/σ_y = {closest:g}. Eq. 10 is made for a flat punch on a half-space; from 0.5 a "
        "stiff body is a barrel whose contact hardly shrinks."
    )
    return Finding(ours, verdict(high > 2.0 * max(low, 0.05)), reason)


def centre_opens(facts: Facts) -> Finding:
    text, opens = [], []
    for modulus in sorted(facts.inside):
        found = facts.within(modulus)
        if found.opening is not None:
            opens.append(modulus)
            text.append(f"{modulus:g}: below {100 * found.force[found.opening]:.1f} %")
    facts.within(10.0)
    reason = (
        "Unloading from δ/R = 0.5, ν = 0.3: below this share of the largest force the centre is off the flat while a ring still bears. "
        f"We see it at E/σ_y = {', '.join(f'{m:g}' for m in opens)}, not at 10 alone; at the ends of that range only in the last few per "
        "cent of the force."
    )
    return Finding("; ".join(text) or "it does not open", verdict(opens == [10.0], 10.0 in opens), reason)


def with_hardening(facts: Facts) -> Finding:
    return Finding(
        "—",
        UNTESTED,
        "The reason given, that Rojek et al. had hardening and one set of constants, needs a hardening material; this solver has none.",
    )


STATEMENTS = (
    Statement(
        "4.5, Eq. 6, Fig. 9",
        "Eq. 6 has α fall with the overlap for every material; simulations diverge for low and high E/σ_y",
        "—",
        etsion_falls,
    ),
    Statement("4.5, Fig. 9", "At larger E/σ_y both fall with the overlap, at different rates", "—", etsion_at_high),
    Statement("4.5, Eq. 8", "k₂/k₁ = ρδ̄_max", "—", stiffness_ratio),
    Statement("4.5, Eq. 7", "Luding's transition overlap can be read as that at first yield", "—", luding_transition),
    Statement("4.5, 7, Fig. 10", "Luding's linear growth with the overlap is limited even if fitted for each material", "—", luding),
    Statement(
        "4.5, 7, Fig. 11", "Walton & Braun's linear growth with the force is limited even if fitted for each material", "—", walton_braun
    ),
    Statement("4.5, Fig. 10", "That Rojek et al. found Luding's line sufficient is due to their hardening material", "—", with_hardening),
    Statement("4.5, Eq. 9", "Eq. 9 has the recovered overlap grow with overlap and with E/σ_y", "—", etsion_monotonic),
    Statement("4.5, Fig. 6", "At very large overlap the proportion recovered begins to fall", "—", proportion_falls),
    Statement(
        "4.5, Fig. 12",
        "Eq. 9 agrees at the smallest overlaps and E/σ_y; beyond, bodies recover much less than it says",
        "—",
        etsion_recovers_more,
    ),
    Statement(
        "4.5, Fig. 12", "Range of δ_max/δ_c in Fig. 12 (E/σ_y = 200, δ̄ = 0.01 to E/σ_y = 1000, δ̄ = 0.5)", "366 to 4.75·10⁵", quoted_ranges
    ),
    Statement(
        "4.5, Eq. 10, Fig. 13", "From δ/R = 0.5 Mesarovic & Johnson's relation is realistic for low E/σ_y only", "—", mesarovic_johnson
    ),
    Statement("Fig. 13", "At E/σ_y = 10 the contact opens at its centre before unloading ends", "E/σ_y = 10", centre_opens),
)
