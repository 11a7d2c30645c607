"""Section 2 and appendix A: the elastic contact; first yield."""

from __future__ import annotations

import numpy as np

from cases.becker_kamlah_2021.apart import Loaded
from cases.becker_kamlah_2021.appendix_a import largest_error
from cases.becker_kamlah_2021.bodies import CASES, PROFILES
from cases.becker_kamlah_2021.facts import FAILS, Facts, Finding, Lacking, Statement, span, verdict
from contactlaws.contact_ellipse import exact_factors, hale
from contactlaws.pair import pressure_at_yield
from contactlaws.rivals.becker_kamlah import FIRST

RATIOS = np.geomspace(1.0, 20.0, 200)


def factors(facts: Facts) -> Finding:
    off = max(max(abs(a / b - 1.0) for a, b in zip(hale(q), exact_factors(q), strict=False)) for q in RATIOS.tolist())
    ours = f"as printed f1 = f2 = 0 for a sphere; with [q^0.0602 − 1] and [q^0.0684 − 1] (Hale 1999) at most {100 * off:.2f} % off"
    reason = "Hertz's integrals solved once per contact cost nothing; the kernels' fast form is off by 0.0003 %."
    return Finding(ours, verdict(False, off < 0.01), reason)


def eccentricity(facts: Facts) -> Finding:
    off = {q: q ** (-2.0 / 3.0) / exact_factors(q).axes - 1.0 for q in (2.0, 5.0, 20.0, 100.0)}
    ours = "b_c/a_c off by " + ", ".join(f"{100 * value:.1f} % (B/A = {q:g})" for q, value in off.items())
    return Finding(ours, verdict(False, abs(off[5.0]) < 0.02), "Good for the bodies of the paper, whose B/A stays below 5.")


def first_case_eccentricity(facts: Facts) -> Finding:
    square = 1.0 - CASES[0].contact.axes ** 2
    return Finding(f"e² = {square:.3f}, e = {square**0.5:.3f}", verdict(abs(square**0.5 - 0.65) < 0.01, False), "The number is e².")


def chart(facts: Facts) -> Finding:
    first, second = CASES[0].first, CASES[0].second
    printed = [largest_error(first, (1.0, 1.0, 2.0), True), largest_error(second, (1.0, 1.0, 1.0), True)]
    right = max(largest_error(first, (1.0, 1.0, 2.0), False), largest_error(second, (1.0, 1.0, 1.0), False))
    ours = f"curvatures of the bodies of Fig. 13 off by {100 * printed[0]:.0f} and {100 * printed[1]:.0f} % off their axes"
    reason = (
        f"(EM − GL) must be (EN − GL), which is exact to {right:.0e}; Eq. 66 remains singular at y z = 0. The tensor here needs no chart."
    )
    return Finding(ours, FAILS, reason)


def hertzian(facts: Facts) -> Finding:
    excess = {row.name: row.elastic_excess for row in facts.loading}
    ours = "F/F_Hertz at δ_Y: " + ", ".join(f"{value:.2f} ({name})" for name, value in excess.items())
    reason = "A finite body is no half-space: blunt bodies are stiffer, sharp ones softer, before anything yields."
    near = [abs(value - 1.0) < 0.07 for value in excess.values()]
    return Finding(ours, verdict(all(near), any(near)), reason)


def elastic_profile(facts: Facts) -> Finding:
    found = [profile for profile in facts.named.profiles if profile.depth < 1.0]
    off = [profile.largest / (FIRST * profile.depth**0.5) - 1.0 for profile in found]
    ours = f"largest pressure {span([100 * value for value in off], '.1f')} % above Hertz's at δ/δ_Y = {PROFILES[0]:g} and {PROFILES[1]:g}"
    return Finding(ours, verdict(max(abs(value) for value in off) < 0.05), "Body 1 : 0.66 : 0.66, whose finite size hardly shows.")


def pressure_of_first_yield(facts: Facts) -> Finding:
    exact = {nu: pressure_at_yield(nu) for nu in (0.0, 0.15, 0.25, 0.3, 0.45)}
    ours = "p_0/Y in Hertz's field: " + ", ".join(f"{value:.3f} (ν = {nu:g})" for nu, value in exact.items())
    sphere = _sphere(facts)
    reason = (
        f"Good to 3 % for ν = 0.25 to 0.3 alone. Finite elements yield at {sphere.first_yield:.2f} δ_Y for the sphere, "
        f"{span([row.first_yield for row in facts.loading], '.2f')} over all shapes: the pressure of finite bodies is higher as well."
    )
    return Finding(ours, verdict(False, abs(exact[0.25] / FIRST - 1.0) < 0.04), reason)


def _sphere(facts: Facts) -> Loaded:
    for row in facts.loading:
        if row.name == "1:1":
            return row
    raise Lacking("the sphere of NMC")


def overlap_of_first_yield(facts: Facts) -> Finding:
    found = {body.name: (body.curve.yield_overlap or 0.0) / body.mean_radius for body in facts.study.nmc}
    found["1:1"] = found[_sphere(facts).name]
    ours = f"{100 * found['1:1']:.2f} % for the sphere, {span([100 * value for value in found.values()], '.2f')} % over all shapes"
    return Finding(
        ours, verdict(found["1:1"] < 0.002, False), f"With E and Y of Table 1 a sphere bears {found['1:1'] / 0.001:.0f} times that."
    )


STATEMENTS: tuple[Statement[Facts], ...] = (
    Statement("Eq. 4", "f1 and f2 follow from the ratio of curvatures by two powers", "1 for a sphere", factors),
    Statement("Eq. 7", "e² = 1 − (A/B)^(4/3)", "—", eccentricity),
    Statement("5, Fig. 14", "The contact of the first pair has the eccentricity 0.65", "e = 0.65", first_case_eccentricity),
    Statement("Appendix A", "Principal curvatures anywhere on an ellipsoid from Eqs. 61 to 68", "—", chart),
    Statement("2, 4", "Up to first yield the force is Hertz's of the undeformed curvature", "—", hertzian),
    Statement("4, Fig. 9", "Elastic pressure profiles are well described by Hertz's", "—", elastic_profile),
    Statement("3, 3.2", "The contact is elastic up to p_0 = 1.6 Y", "1.6", pressure_of_first_yield),
    Statement("1", "NMC particles may yield at a reduction of their radius by 0.1 %", "0.1 %", overlap_of_first_yield),
)
