"""Sections 5 and 6: the model of concentric cylinders, the rise of the stiffness at large overlap, and use in linear laws."""

from __future__ import annotations

import numpy as np

from calibration.unloadings import power_law
from cases.edmans_sinka_2020 import cylinder, paper
from cases.edmans_sinka_2020.facts import FAILS, HOLDS, NU, PARTLY, Facts, Finding, Lacking, Statement, span, verdict


def signs(facts: Facts) -> Finding:
    return Finding(
        "−ε",
        FAILS,
        "By algebra: in Eqs. 12, 15 and 16 compression must enter as −ε, or the elastic annulus pulls. Eqs. 13, 14 and 17 are right.",
    )


def algebra(facts: Facts) -> Finding:
    modulus, largest, depth = 100.0, 0.1, 0.095
    right, wrong = (float(f(modulus, largest, depth)) for f in (cylinder.unloading_force_with_tension, cylinder.printed_unloading_force))
    ours = f"E/σ_y = 100, from 0.1 at 0.095: Eq. 19 gives F̄ = {right:.3f}, Eq. 21 {wrong:.3f}"
    return Finding(ours, FAILS, "Eq. 19 is F̄_max − Ē(δ̄_max² − δ̄²). Eq. 21 has (δ̄ − δ̄_max)² in place of the difference of the squares.")


def uniformly_two(facts: Facts) -> Finding:
    found = []
    for modulus in (20.0, 100.0, 1000.0):
        for largest in (0.1, 0.5):
            overlap = np.linspace(largest, largest - 1.0 / modulus, 400)
            found.append(power_law(overlap, cylinder.unloading_force(modulus, largest, overlap)).exponent)
    ours = f"α = {span(found)} for E/σ_y 20 to 1000 and δ/R 0.1 to 0.5, no tension; 2 only before first yield"
    return Finding(
        ours,
        FAILS,
        "The exponent falls with the overlap towards 1, so that the corrected model does show the trend that the paper finds in its "
        "simulations.",
    )


def cylinder_trends(facts: Facts) -> Finding:
    fe = np.log(facts.at("stiffness", 1000.0, 0.1) / facts.at("stiffness", 100.0, 0.1)) / np.log(10.0)
    printed = np.log(float(cylinder.printed_stiffness(1000.0, 0.1) / cylinder.printed_stiffness(100.0, 0.1))) / np.log(10.0)
    ours = f"ρ ∝ (E/σ_y)^n at δ/R = 0.1: n = {printed:.2f} printed, 1.00 corrected, {fe:.2f} finite elements"
    return Finding(ours, PARTLY, "The rise is captured, in full: that it is less pronounced is the error of Eq. 21.")


def cylinder_size(facts: Facts) -> Finding:
    fe = facts.at("stiffness", 1000.0, 0.1)
    ours = (
        f"E/σ_y = 1000, δ/R = 0.1: {float(cylinder.printed_stiffness(1000.0, 0.1)):.0f} printed, "
        f"{float(cylinder.stiffness(1000.0, 0.1)):.0f} corrected, {fe:.0f} finite elements"
    )
    return Finding(ours, FAILS, "Without tension ρ = Ē exactly once δ̄_max > 1/Ē; Eqs. 22 and 23 fall with Eq. 21.")


def cylinder_depth(facts: Facts) -> Finding:
    ends = [float(cylinder.stiffness_with_tension(1000.0, d)) for d in (0.01, 0.1, 0.5)]
    ours = (
        f"E/σ_y = 1000, δ/R = 0.01, 0.1, 0.5: {', '.join(f'{v:.0f}' for v in ends)} with tension; 1000 at all without; ours "
        + ", ".join(f"{facts.at('stiffness', 1000.0, d):.0f}" for d in (0.01, 0.1, 0.5))
    )
    reason = (
        "That it lacks the rise at large overlap is right (without tension). The fall at moderate overlap that it seemed to have is "
        "another effect of Eq. 21."
    )
    return Finding(ours, PARTLY, reason)


def truncated_sphere(facts: Facts) -> Finding:
    ratio = {d: [facts.radius_at(m, d) / float(cylinder.contact_radius(d)) for m in facts.study.moduli(NU)] for d in (0.05, 0.3, 0.5)}
    ours = "finite elements over Eq. 13: " + "; ".join(f"{span(v)} at δ/R = {d:g}" for d, v in ratio.items())
    stiff = [v[-1] for v in ratio.values()]
    reason = (
        "For stiff bodies it is best at 0.2 to 0.3 and off by as much at 0.05 as at 0.5; elastic bodies touch in a smaller disc throughout."
    )
    return Finding(ours, verdict(False, stiff[2] > stiff[1]), reason)


def ratio_bound(facts: Facts) -> Finding:
    largest = max(facts.radius_at(m, d, nu) / float(cylinder.contact_radius(d)) for m, nu in facts.study.keys for d in paper.DEPTHS)
    ours = f"largest ratio of contact radii {largest:.3f}, of areas {largest**2:.2f}"
    return Finding(ours, verdict(largest <= 1.24), "The bound holds for the radius, which is what ā is; the paper calls it area.")


def peak_to_trough(facts: Facts) -> Finding:
    found = {}
    for modulus, nu in facts.study.keys:
        line = facts.study.of(modulus, nu).stiffness
        if modulus >= 20.0:
            found[modulus, nu] = float(line[-1] / line.min())
    if not found:
        raise Lacking("E/σ_y ≥ 20")
    here = [value for (_, nu), value in found.items() if nu == NU]
    if not here:
        raise Lacking("ν = 0.3")
    printed = paper.stiffness(20.0, NU, np.array(paper.DEPTHS))
    own = float(printed[-1] / printed.min())
    ours = f"{span(here, '.2f')} for ν = 0.3; {span(list(found.values()), '.2f')} for all ν"
    return Finding(
        ours,
        verdict(min(here) > 1.95 and max(here) < 2.45, max(here) > 1.9),
        f"ρ at δ/R = 0.5 over its least value; it falls as ν grows. Eq. 3 itself gives {own:.2f} at E/σ_y = 20.",
    )


def cause_of_rise(facts: Facts) -> Finding:
    modulus, depths, rows = 1000.0, (0.01, 0.1, 0.5), []
    for depth in depths:
        line = facts.loading(modulus)
        force, radius = float(np.interp(depth, line.depth, line.force)), facts.radius_at(modulus, depth)
        half_space = radius / (2.0 * (1.0 - NU**2) * force)
        rows.append((facts.at("stiffness", modulus, depth) / modulus, half_space, radius**2 / (force * (1.0 - depth))))
    names = ("finite elements", "flat punch on a half-space", "bar of the contact's section and the body's height")
    texts = [f"{name} {', '.join(f'{value:.2f}' for value in values)}" for name, values in zip(names, zip(*rows, strict=True), strict=True)]
    reason = (
        "At 0.01 a stiff sphere recovers as a half-space beneath a punch, at 0.5 as a short bar: half as high, its faces wholly in "
        "contact. That is geometry, and it accounts for the rise. The mean stress is as uniaxial at 0.5 as at 0.01 and the largest "
        "hydrostatic pressure smaller (section 4.4 above), so it is not hydrostatic compression that grows."
    )
    rise = [values[2] / values[1] for values in zip(*rows, strict=True)]
    return Finding(f"ρ/Ē at δ/R = 0.01, 0.1, 0.5: {'; '.join(texts)}", verdict(False, rise[2] < 0.7 * rise[0]), reason)


def no_yield_in_model(facts: Facts) -> Finding:
    return Finding("strain at the axis is δ̄, yield at 1/Ē", HOLDS, "By Eq. 14: the core opens at δ̄ = 1/Ē, which is 1.")


def linear_laws(facts: Facts) -> Finding:
    shape = [facts.at("exponent", modulus, depth) for modulus in (10.0, 100.0, 1000.0) for depth in (0.01, 0.1, 0.5)]
    ours = (
        f"with α = {span(shape)} a line from start to separation gives back "
        f"{span([100 * (a - 1.0) / 2.0 for a in shape], '.0f')} % too much energy"
    )
    return Finding(ours, PARTLY, "Separation and force at the start are right, the energy (1/(α + 1) against 1/2) is not; for E/σ_y ≥ 10.")


STATEMENTS = (
    Statement("5, Eqs. 12, 15, 16", "Elastic strain and force of the cylinder model", "+ε", signs),
    Statement("5, Eq. 14", "In the model no bar yields for E/σ_y = 1", "—", no_yield_in_model),
    Statement("5, Eqs. 20, 21", "The unloading force of the model", "Eq. 21", algebra),
    Statement("5", "The model's exponent is 2 throughout", "2", uniformly_two),
    Statement("5, Eqs. 22, 23", "The unloading stiffness of the model", "√(Ē/F̄_max)", cylinder_size),
    Statement("5, Figs. 16, 5", "The model's ρ rises with E/σ_y, less than in the simulations", "—", cylinder_trends),
    Statement("5, Figs. 17, 6", "The model has the fall of ρ at moderate overlap, not its rise at large", "—", cylinder_depth),
    Statement(
        "5, Eq. 13, Fig. 15", "The truncated sphere's contact radius becomes ever less accurate from δ/R = 0.3 on", "—", truncated_sphere
    ),
    Statement(
        "5, Fig. 15", "Contact areas of simulation and model before unloading differ by no more than a factor", "≤ 1.24", ratio_bound
    ),
    Statement("5, Fig. 6", "ρ rises again at large overlap: peak over trough for E/σ_y ≥ 20", "2.0 to 2.4", peak_to_trough),
    Statement(
        "5, 7",
        "This rise is mainly due to hydrostatic compression that restrains the recovery; the contact area plays a part",
        "—",
        cause_of_rise,
    ),
    Statement("6", "k₂/k₁ of Fig. 10 can serve linear unloading laws", "—", linear_laws),
)
