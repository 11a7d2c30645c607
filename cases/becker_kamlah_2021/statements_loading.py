"""Sections 3.2, 3.3 and 4: loading beyond yield."""

from __future__ import annotations

import math

import numpy as np

from cases.becker_kamlah_2021.data import REACH, nmc_key
from cases.becker_kamlah_2021.facts import FAILS, QUANTITIES, Facts, Finding, Lacking, Statement, span, verdict
from cases.becker_kamlah_2021.figures_shape import NU, TRIAXIAL
from cases.becker_kamlah_2021.shape_fit import Read, published
from contactlaws.rivals.becker_kamlah import EXPONENT, PRESSURE_CONSTANTS, RADIUS_CONSTANTS

#: of Eq. 53, in the order of Eq. 52
NAMES = {"pressure_ratio": "mop", "radius_ratio": "stu"}
#: a pressure counts as uniform within this share of the largest
UNIFORM = 0.05
#: from which R_e/r on the exponent cannot be told
BLUNT = 0.39


def flattens(facts: Facts) -> Finding:
    shares = {}
    for profile in facts.named.profiles:
        level = profile.pressure >= (1.0 - UNIFORM) * profile.largest
        shares[profile.depth] = float(profile.place[level].max() / profile.place[-1]), float(profile.pressure[0] / profile.largest)
    deepest = max(shares)
    plastic = {depth: value for depth, value in shares.items() if depth > 2.0}
    ours = "; ".join(f"δ/δ_Y = {depth:.2g}: out to {100 * value[0]:.0f} % of the radius" for depth, value in plastic.items())
    reason = (
        f"The pressure is within {100 * UNIFORM:.0f} % of the largest out to there, then drops. In the end it is lower at the centre: "
        f"{shares[deepest][1]:.2f} of the largest at δ/δ_Y = {deepest:.2g}, so it is uniform only on the way."
    )
    flat = [value[0] > 0.6 for value in plastic.values()]
    return Finding(ours, verdict(all(flat) and shares[deepest][1] > 1.0 - UNIFORM, any(flat)), reason)


def three_times(facts: Facts) -> Finding:
    largest = max(profile.largest for profile in facts.named.profiles)
    body = facts.named.papers
    end = REACH * body.mean_radius
    area = float(np.interp(end, body.overlap, body.contact_radius)) ** 2 / (body.radius * end)
    reason = (
        f"λ is not that pressure: Eq. 51 divides the force by Hertz's area, and the true area is {area:.2f} times that. So λ_max near 3 "
        f"and a pressure near 2 Y belong together."
    )
    return Finding(f"largest pressure {largest:.2f} Y up to 15 %, body 1 : 0.66 : 0.66", verdict(largest > 2.7, largest > 2.4), reason)


def stays(facts: Facts) -> Finding:
    left = {key: [row.plateau.at_end for row in rows if row.plateau is not None] for key, rows in facts.read_of.items()}
    stiff = {key: values for key, values in left.items() if values and key[0] >= 60.0}
    nmc = left.get(nmc_key())
    if not nmc:
        raise Lacking("a body of NMC with a largest λ")
    ours = f"λ at 15 % over the largest: {span(nmc, '.2f')} for NMC"
    if stiff:
        hardest = max(key[0] for key in stiff)
        values = [value for key, found in stiff.items() if key[0] == hardest for value in found]
        ours += f", {span(values, '.2f')} for E/Y = {hardest:g}"
    reason = "Past its largest value λ falls again, as the plastic zone reaches the flanks; for stiff bodies long before 15 %."
    return Finding(ours, verdict(not stiff and min(nmc) > 0.98, min(nmc) > 0.9), reason)


def finite_deformation(facts: Facts) -> Finding:
    found: dict[float, list[float]] = {}
    for (ratio, _), rows in facts.read_of.items():
        for row in rows:
            if row.plateau is not None:
                overlap = row.plateau.radius_ratio**2 * row.body.yield_overlap
                radius = float(np.interp(overlap, row.body.overlap, row.body.contact_radius))
                found.setdefault(ratio, []).append(radius / row.body.mean_radius)
    if not found:
        raise Lacking("a body with a largest λ")
    every = [value for values in found.values() for value in values]
    ours = f"contact radius over r̂ where λ is largest: {span(every, '.2f')}"
    ends = {ratio: float(np.median(found[ratio])) for ratio in (min(found), max(found))}
    reason = "Medians: " + ", ".join(f"{value:.2f} (E/Y = {ratio:.4g})" for ratio, value in ends.items()) + "."
    inside = [0.1 < value < 0.5 for value in every]
    return Finding(ours, verdict(all(0.16 <= value <= 0.4 for value in every), sum(inside) > 0.8 * len(inside)), reason)


def equation_28_fits(facts: Facts) -> Finding:
    sharp = [row for row in facts.nmc if row.force.seen]
    blunt = [row for row in facts.nmc if not row.force.seen]
    if not sharp:
        raise Lacking("a body of NMC with a transition")
    misfit = _percent([row.force.misfit for row in sharp])
    ours = f"root mean square misfit of the force, over the largest: {misfit} where there is a transition"
    if blunt:
        ours += f", {_percent([row.force.misfit for row in blunt])} for blunt bodies"
    reason = f"λ_max and ε_max fitted to each body, n = {EXPONENT:g}; no transition is seen for R_e/r ≥ {_first_blunt(blunt):.2f}."
    return Finding(ours, verdict(not blunt and max(row.force.misfit for row in sharp) < 0.01, bool(sharp)), reason)


def _first_blunt(rows: list[Read]) -> float:
    return min((row.body.relative for row in rows), default=math.nan)


def _percent(values: list[float]) -> str:
    return f"{span([100.0 * value for value in values], '.2g')} %"


def exponent(facts: Facts) -> Finding:
    told = [row for row in facts.nmc if math.isfinite(row.free.condition)]
    text = ", ".join(f"{row.free.exponent:.2f} ± {row.free.exponent_error or 0.0:.2f} ({row.body.name})" for row in told)
    lost = [row for row in facts.nmc if row.body.relative > BLUNT]
    if not told or not lost:
        raise Lacking("sharp and blunt bodies of NMC")
    conditions = ", ".join(f"{row.free.condition:.0f}" for row in told)
    reason = (
        f"Condition numbers {conditions}; for R_e/r of {span([row.body.relative for row in lost], '.2f')} infinite: ε runs to 1, where "
        "n does nothing. It is told for sharp bodies alone; from the sphere on a larger n with a larger ε does as well."
    )
    whole = facts.joint.get(nmc_key())
    if whole is not None:
        text += f"; all shapes at once {whole.constants[-1]:.2f} ± {whole.errors[-1]:.1f}"
    near = [row for row in told if abs((row.free.exponent or 0.0) - EXPONENT) < 0.35]
    return Finding(text, verdict(len(near) == len(facts.nmc), bool(near)), reason)


def shape_alone(facts: Facts) -> Finding:
    sphere = facts.of_shape(nmc_key(), 1.0).force.pressure_ratio
    others = {}
    for key in facts.read_of:
        row = next((row for row in facts.read_of[key] if row.body.name == "1:1" and row.force.risen), None)
        if row is not None and key[0] >= 20.0:
            others[key] = row.force.pressure_ratio
    if not others:
        raise Lacking("spheres of other materials")
    by_ratio = {ratio: value for (ratio, nu), value in sorted(others.items()) if nu == NU}
    ours = f"spheres: λ_max = {sphere:.2f} (NMC), " + ", ".join(f"{value:.2f} (E/Y = {ratio:g})" for ratio, value in by_ratio.items())
    fixed = {nu: value for (ratio, nu), value in sorted(others.items()) if ratio == 60.0}
    if len(fixed) > 1:
        ours += "; E/Y = 60: " + ", ".join(f"{value:.2f} (ν = {nu:g})" for nu, value in fixed.items())
    code = TRIAXIAL["1:0.5:2"][1], TRIAXIAL["sphere"][1]
    reason = (
        f"E/Y decides more than the shape does. Nor is the shape R_e/r alone: by an independent code the triaxial body 1 : 0.5 : 2 of "
        f"NMC has {code[0]:g} and the sphere {code[1]:g} at one R_e/r = 0.25, which bodies of revolution cannot show."
    )
    spread = max(abs(value / sphere - 1.0) for value in others.values())
    return Finding(ours, verdict(spread < 0.02, spread < 0.1), reason)


def _against(facts: Facts, quantity: str) -> dict[str, float]:
    """Eq. 54 over ours, less 1."""
    found = {}
    for row in facts.nmc:
        value = row.force.told if quantity == "pressure_ratio" else row.force.radius_ratio if row.force.seen else None
        if value is not None:
            found[row.body.name] = float(published(quantity, row.body.relative)[0]) / value - 1.0
    return found


def equation_54(facts: Facts, quantity: str) -> Finding:
    off = _against(facts, quantity)
    ours = ", ".join(f"{100 * value:+.1f} % ({name})" for name, value in off.items())
    beyond = [row.body.name for row in facts.nmc if row.body.name not in off]
    reason = "Eq. 54 over ours less 1, NMC; ours by the fit of the force"
    reason += ", λ at 15 % for the blunt ones." if quantity == "pressure_ratio" else f"; no transition to read for {', '.join(beyond)}."
    sizes = [abs(value) for value in off.values()]
    if not sizes:
        raise Lacking("a body of NMC with a transition")
    return Finding(ours, verdict(max(sizes) < 0.025 and not beyond, float(np.median(sizes)) < 0.03), reason)


def constants(facts: Facts) -> Finding:
    texts = []
    inside = []
    for quantity, theirs in zip(QUANTITIES, (PRESSURE_CONSTANTS, RADIUS_CONSTANTS), strict=True):
        found = facts.shape("force", quantity)
        for name, value, error, paper in zip(NAMES[quantity], found.constants, found.errors, theirs, strict=True):
            texts.append(f"{name} = {value:.3g} ± {error:.2g}")
            inside.append(abs(value - paper) < 2.0 * error)
    reason = "Our fit of Eq. 52 to NMC, with standard errors: the three constants of each line hardly tell apart, only their curve does."
    return Finding(", ".join(texts), verdict(all(inside), any(inside)), reason)


def other_materials(facts: Facts) -> Finding:
    spread = {}
    for key, rows in facts.read_of.items():
        off = [abs(float(published("pressure_ratio", row.body.relative)[0]) / row.force.told - 1.0) for row in rows if row.force.told]
        if off and key[1] == NU:
            spread[key[0]] = float(np.mean(off))
    if len(spread) < 3:
        raise Lacking("other materials")
    ours = "mean difference of Eq. 54 from λ_max: " + ", ".join(
        f"{100 * value:.0f} % (E/Y = {ratio:g})" for ratio, value in sorted(spread.items())
    )
    return Finding(ours, verdict(max(spread.values()) < 0.05, max(spread.values()) < 0.1), "Over all shapes, ν = 0.3.")


def universal(facts: Facts) -> Finding:
    found = {}
    for key, rows in facts.read_of.items():
        if key[1] in (NU, nmc_key()[1]):
            found[key[0]] = max((row.force.misfit for row in rows if row.force.told), default=math.nan)
    found = {ratio: value for ratio, value in found.items() if math.isfinite(value)}
    if len(found) < 3:
        raise Lacking("other materials")
    ours = "worst misfit of the force by Eqs. 25 to 31, fitted to each body: " + ", ".join(
        f"{100 * value:.1f} % (E/Y = {ratio:.4g})" for ratio, value in sorted(found.items())
    )
    reason = "Even with constants of their own, stiff bodies do not follow: the straight line of Eq. 31 is not there."
    return Finding(ours, verdict(max(found.values()) < 0.01, max(found.values()) < 0.03), reason)


def undeformed_curvature(facts: Facts) -> Finding:
    areas = [row.area for row in facts.loading]
    early = [float(np.interp(row.body.yield_overlap, row.body.overlap, row.body.contact_radius)) for row in facts.nmc]
    there = [radius**2 / (row.body.radius * row.body.yield_overlap) for radius, row in zip(early, facts.nmc, strict=True)]
    reason = f"At {100 * REACH:.0f} % of the mean radius, NMC; {span(there, '.2f')} at δ_Y."
    return Finding(f"contact area over that of Eq. 9: {span(areas, '.2f')}", verdict(max(areas) < 1.05, max(areas) < 1.2), reason)


def published_loading(facts: Facts) -> Finding:
    ours = "mean difference up to 15 %: " + ", ".join(f"{100 * row.error:.1f} % ({row.name})" for row in facts.loading)
    refitted = span([100.0 * row.refitted for row in facts.loading], ".2g")
    blunt = max(facts.loading, key=lambda row: row.error)
    reason = (
        f"Over the largest force. With λ_max and ε_max of each body {refitted} %. The worst, {blunt.name}, is elasticity of a finite body: "
        f"with its own force up to δ_Y in place of Hertz's, and Eq. 54 as it is, {100 * blunt.elastic_right:.1f} %."
    )
    small = [row.error < 0.015 for row in facts.loading]
    return Finding(ours, verdict(all(small), any(small)), reason)


def creates_no_energy(facts: Facts) -> Finding:
    gains = {row.name: row.gain for row in facts.loading}
    creating = {name: value for name, value in gains.items() if value > 1.0005}
    ours = "work back over work in: " + (", ".join(f"{value:.3f} ({name})" for name, value in creating.items()) or "never above 1")
    reason = "Just past yield, where the fitted force exceeds Hertz's and the unloading is still elastic: the law makes energy."
    return Finding(ours, FAILS if creating else verdict(True), reason)


STATEMENTS: tuple[Statement[Facts], ...] = (
    Statement("3, Fig. 9", "Beyond yield the profile becomes a region of uniform pressure with a sharp drop at its edge", "—", flattens),
    Statement("3", "Fully plastic where the largest pressure is some three times Y", "3 Y", three_times),
    Statement("3.3, Eq. 31", "In the fully plastic regime the pressure stays at λ_max Y, the force rises on a straight line", "—", stays),
    Statement("3", "Finite deformation sets in at a contact radius of 0.16 to 0.4 of the mean radius", "0.16–0.4", finite_deformation),
    Statement("4, Fig. 11", "λ follows Eq. 28", "—", equation_28_fits),
    Statement("4", "n = 1.8 fits the profile of λ best", "1.8", exponent),
    Statement("4, Fig. 12", "λ_max and ε_max depend on R_e/r", "R_e/r alone", shape_alone),
    Statement("Eq. 54", "λ_max = 1.05 exp(−4.62 R_e/r) + 2.42", "—", lambda facts: equation_54(facts, "pressure_ratio")),
    Statement("Eq. 54", "ε_max = 8.19 exp(−6.14 R_e/r) + 1.14", "—", lambda facts: equation_54(facts, "radius_ratio")),
    Statement("Eq. 53", "The constants of Eq. 52", "1.05, −4.62, 2.42; 8.19, −6.14, 1.14", constants),
    Statement("6", "The fit of the transition changes slightly for other materials", "slightly", other_materials),
    Statement("6", "The relations of the elastic and of the fully plastic regime hold for all materials", "—", universal),
    Statement("3.3, 3.4", "The curvature stays that of the undeformed bodies while the contact is loaded", "—", undeformed_curvature),
    Statement("4, Fig. 10", "The law with Eq. 54 follows finite elements on loading", "—", published_loading),
    Statement("(asked of any law)", "No turning back gives more work than was put in", "—", creates_no_energy),
)
