"""Sections 3.4 and 5: unloading, and the two cases of the validation."""

from __future__ import annotations

import math

import numpy as np

from calibration.residuals import follow
from calibration.unloadings import unloadings
from cases.becker_kamlah_2021.apart import whole_path_error
from cases.becker_kamlah_2021.bodies import CASES, Case
from cases.becker_kamlah_2021.data import REACH, Body, nmc_key
from cases.becker_kamlah_2021.facts import FAILS, HOLDS, Facts, Finding, Lacking, Statement, span, verdict
from contactlaws.path import trace
from contactlaws.rivals.becker_kamlah import FIRST, RADIUS_CONSTANTS, BeckerKamlah, becker_kamlah_loading, becker_kamlah_yield_overlap


def residual_overlap(facts: Facts) -> Finding:
    deep = [row for row in facts.unloading if abs(row.depth - REACH) < 1e-6]
    if not deep:
        raise Lacking("unloadings from 15 %")
    ours = "at 15 %, law and finite elements: " + ", ".join(f"{row.published:.2f}, {row.residual:.2f} ({row.name})" for row in deep)
    off = [abs(row.published - row.residual) for row in facts.unloading]
    reason = f"The two cross near R_e/r = 0.2, where it is right. Over all depths off by up to {max(off):.2f} of the largest overlap."
    return Finding(ours, verdict(max(off) < 0.02, min(abs(row.published - row.residual) for row in deep) < 0.02), reason)


def hertzian_unloading(facts: Facts) -> Finding:
    found = {}
    for body in facts.study.nmc:
        exponents = [u.exponent for u in unloadings(body.curve) if u.plastic and u.overlap <= REACH * body.mean_radius * (1.0 + 1e-6)]
        if exponents:
            found[body.name] = exponents[-1]
    ours = "best exponent at 15 %: " + ", ".join(f"{value:.2f} ({name})" for name, value in found.items())
    near = [abs(value - 1.5) < 0.05 for value in found.values()]
    shape = [row.shape_error for row in facts.unloading]
    reason = f"With its first force set right, the law is still {span([100 * value for value in shape], '.2g')} % of the largest force off."
    return Finding(ours, verdict(all(near), any(near)), reason)


def unloading_force(facts: Facts) -> Finding:
    means: dict[str, list[float]] = {}
    for row in facts.unloading:
        means.setdefault(row.name, []).append(row.error)
    ours = "mean difference, over the largest force: " + ", ".join(
        f"{100 * np.mean(values):.1f} % ({name})" for name, values in means.items()
    )
    reason = f"Mean over the unloadings from 1 to 15 %; at worst {100 * max(max(values) for values in means.values()):.0f} %."
    small = [float(np.mean(values)) < 0.02 for values in means.values()]
    return Finding(ours, verdict(all(small), any(small)), reason)


def continuous(facts: Facts) -> Finding:
    worst = 0.0
    for case in CASES:
        law = case.contact.law
        top = 7.0 * becker_kamlah_yield_overlap(law)
        force = trace(law, [top, top * (1.0 - 1e-9)]).force
        worst = max(worst, abs(float(force[1] / force[0]) - 1.0))
    return Finding(f"jump of the force {worst:.0e}", HOLDS if worst < 1e-7 else FAILS, "")


def jump(facts: Facts) -> Finding:
    betas, areas = [row.beta for row in facts.unloading], [row.area for row in facts.unloading]
    ours = f"β = {span(betas, '.2f')}: contact area {span(areas, '.2f')} times that of finite elements"
    reason = "The force does not notice; whatever goes with the contact radius (tangential stiffness, heat, current) does."
    return Finding(ours, verdict(max(betas) < 1.05, True), reason)


def reloading(facts: Facts) -> Finding:
    found = facts.named.cycles
    off = max(max(abs(loop.departure), abs(loop.back)) for loop in found)
    ours = f"within {100 * off:.2g} % of the force at the start, dissipating up to {100 * max(loop.hysteresis for loop in found):.2g} %"
    reason = "Two cycles to separation of each of the two spheroids of the validation; dissipation over what is given back."
    return Finding(ours, verdict(off < 0.005), reason)


def _case(facts: Facts, number: str) -> tuple[Case, Body]:
    return next((case, body) for case, body in facts.named.cases if case.number == number)


def validation(facts: Facts, number: str) -> Finding:
    case, body = _case(facts, number)
    curve = body.curve
    predicted = np.concatenate([follow(body.law, curve, branch).force for branch in (0, *curve.unloadings)])
    error = whole_path_error(curve, predicted, list(curve.unloadings))
    ours = f"{100 * error:.2f} %, spheroid 1:{case.aspect:.3f} of the same R_e/r = {case.relative:.4f}"
    reason = "Mean along the path, over the largest force; how the paper averages is not said. Our body is of revolution, theirs are not."
    return Finding(ours, verdict(error < case.papers_error * 1.2, error < 0.025), reason)


def spheres_overestimate(facts: Facts) -> Finding:
    case, _ = _case(facts, "13")
    top = 2.0 * case.mean_radius * case.turns[1]
    ratio = float(becker_kamlah_loading(case.spheres, top) / becker_kamlah_loading(case.contact.law, top))
    sphere, spheroid = (facts.study.body(nmc_key(), aspect) for aspect in (1.0, 2.0**-0.25))
    forces = [
        float(np.interp(case.turns[1] * body.mean_radius, body.overlap, body.force)) / body.mean_radius**2 for body in (sphere, spheroid)
    ]
    excess = 100.0 * (ratio - 1.0), 100.0 * (forces[0] / forces[1] - 1.0)
    ours = f"at {100 * case.turns[1]:g} %: by {excess[0]:.0f} % in the law, by {excess[1]:.0f} % in finite elements"
    return Finding(ours, verdict(ratio > 1.05 and forces[0] > 1.05 * forces[1]), "Spheroid 1:0.841, same mean radius and R_e/r.")


def without_transition(facts: Facts) -> Finding:
    case, body = _case(facts, "15")
    law: BeckerKamlah = body.law._replace(pressure_ratio=FIRST)
    top = case.turns[1] * body.mean_radius
    ratio = becker_kamlah_loading(law, top) / float(np.interp(top, body.overlap, body.force))
    ours = f"force at {100 * case.turns[1]:g} %: {ratio:.2f} of finite elements"
    return Finding(ours, verdict(ratio < 0.9), "Thornton's pressure of 1.6 Y held.")


def second_case(facts: Facts) -> Finding:
    law = _case(facts, "15")[0].contact.law
    scale, rate, limit = RADIUS_CONSTANTS
    other = math.log((2.94 - limit) / scale) / rate
    ours = f"ε_max = {law.radius_ratio:.3f}, ε_max² = {law.radius_ratio**2:.2f} by Eq. 54 at R_e/r = {CASES[1].relative:.4f}"
    return Finding(ours, verdict(abs(law.radius_ratio / 2.94 - 1.0) < 0.01, False), f"2.94 belongs to R_e/r = {other:.4f}.")


STATEMENTS: tuple[Statement[Facts], ...] = (
    Statement("3.4, Eqs. 34, 44", "The overlap that is left after unloading", "δ* (1 − R_e/R_ep)", residual_overlap),
    Statement("3.4", "Unloading is Hertz's of a flatter body: a power 1.5 of the overlap", "1.5", hertzian_unloading),
    Statement("3.4, 6", "The law follows finite elements on unloading", "—", unloading_force),
    Statement("3.4", "The force is continuous where unloading begins", "—", continuous),
    Statement("3.4", "The jump of the contact radius there is negligible", "negligible", jump),
    Statement("5", "Reloading follows the unloading", "—", reloading),
    Statement("5, Fig. 13", "Mean error of the first pair", "1.01 %", lambda facts: validation(facts, "13")),
    Statement("5, Fig. 15", "Mean error of the second pair", "0.59 %", lambda facts: validation(facts, "15")),
    Statement("5, Fig. 13", "Spheres of the same mean radius overestimate the force of the first pair", "—", spheres_overestimate),
    Statement("5, Fig. 15", "Without the transition the law underestimates the force by far", "—", without_transition),
    Statement("5, Fig. 15", "ε_max of the second pair", "2.94, fully plastic from 8.65 δ_Y", second_case),
)
