"""Section 4.4: the exponent of the unloading and the reasons given for it."""

from __future__ import annotations

import numpy as np

from cases.edmans_sinka_2020.facts import HOLDS, NU, Facts, Finding, Lacking, Statement, span, verdict


def rises_when_elastic(facts: Facts) -> Finding:
    lines = [facts.points(modulus).exponent for modulus in (1.0, 2.0)]
    ours = "; ".join(f"{line[0]:.3f} to {line[-1]:.3f} for E/σ_y = {m}" for m, line in zip((1, 2), lines, strict=True))
    return Finding(ours, verdict(all((np.diff(line) > 0.0).all() and line[-1] > 1.8 for line in lines)), "")


def falls_when_plastic(facts: Facts) -> Finding:
    points = {modulus: facts.points(modulus) for modulus in (20.0, 100.0, 1000.0)}
    top = {modulus: int(np.argmax(p.exponent)) for modulus, p in points.items()}
    ours = "; ".join(
        f"E/σ_y = {m:g}: {p.exponent[0]:.3f}, largest {p.exponent[top[m]]:.3f} at {p.depth[top[m]]:g}, {p.exponent[-1]:.3f} at the end"
        for m, p in points.items()
    )
    monotonic = all((np.diff(p.exponent) < 0.0).all() for p in points.values())
    falls = all(p.exponent[-1] < 1.25 for p in points.values())
    reason = "For the stiffest bodies α first rises until the whole body flows, at an overlap of 0.05 to 0.1, and falls only from there."
    return Finding(ours, verdict(monotonic and falls, falls), reason)


def hertz_limit(facts: Facts) -> Finding:
    small, larger = (facts.at("exponent", 1.0, depth) for depth in (0.01, 0.05))
    by_depth = small - (larger - small) * 0.01 / 0.04
    by_root = small - (larger - small) * 0.1 / (np.sqrt(0.05) - 0.1)
    ours = f"{small:.3f} at δ/R = 0.01; continued to 0: {span([by_root, by_depth])}"
    return Finding(ours, verdict(by_root < 1.51 and by_depth > 1.49), "Continued in proportion to δ, and to its root.")


def bar(facts: Facts) -> Finding:
    return Finding("α = 1", HOLDS, "By its definition: constant section, uniform stress, small strain.")


def area_at_half(facts: Facts) -> Finding:
    found = {nu: facts.radius_at(1.0, 0.5, nu) ** 2 / 0.5 for nu in facts.study.poisson if (1.0, nu) in facts.study.curves}
    if not found:
        raise Lacking("E/σ_y = 1")
    ours = "a²/(Rδ) = " + ", ".join(f"{value:.2f} (ν = {nu:g})" for nu, value in found.items())
    reason = (
        "One number does not do: it depends on ν more than on anything else. The paper's belongs to ν = 0.3, of which its section speaks."
    )
    near = abs(found.get(NU, 0.0) - 1.4) < 0.1
    return Finding(ours, verdict(near), reason)


def area_falls_faster(facts: Facts) -> Finding:
    ratio = (facts.radius_at(1.0, 0.25) / facts.radius_at(1.0, 0.5)) ** 2
    ours = f"at half the overlap the area is {ratio:.3f} of that at δ/R = 0.5 (Hertz 0.5)"
    return Finding(ours, verdict(ratio < 0.48), "")


def any_pressure(facts: Facts) -> Finding:
    return Finding("no bound", HOLDS, "By definition: the von Mises stress knows the deviator only.")


def hydrostatic(facts: Facts) -> Finding:
    bodies = {depth: facts.within(1000.0).field("loading", depth) for depth in (0.01, 0.1, 0.5)}
    share = [body.mean(body.pressure) / -body.mean(body.stress[:, 1]) for body in bodies.values()]
    mean = [body.mean(body.pressure) for body in bodies.values()]
    peak = [float(body.pressure.max()) for body in bodies.values()]
    ours = (
        f"E/σ_y = 1000, δ/R = 0.01, 0.1, 0.5: mean hydrostatic pressure over σ_y {', '.join(f'{v:.2f}' for v in mean)}, its largest "
        f"{', '.join(f'{v:.2f}' for v in peak)}; mean pressure over mean axial stress {', '.join(f'{v:.3f}' for v in share)}"
    )
    reason = (
        "The mean over the body rises because more of it is loaded. But with free flanks and frictionless flats equilibrium makes the "
        "mean lateral stress zero, so that the mean hydrostatic part is one third of the axial stress, at any overlap, exactly as in a "
        "bar in simple compression; and the pressure beneath the contact, largest in indentation, falls."
    )
    return Finding(ours, verdict(bool(np.diff(mean).min() > 0.0 and peak[2] > peak[0]), mean[-1] > mean[0]), reason)


def uniform(facts: Facts) -> Finding:
    bodies = [facts.within(1000.0).field("loading", depth) for depth in (0.01, 0.1, 0.3, 0.5)]
    scatter = [body.scatter(body.stress[:, 1]) / -body.mean(body.stress[:, 1]) for body in bodies]
    ours = (
        f"axial stress at E/σ_y = 1000, standard deviation over mean: {', '.join(f'{s:.2f}' for s in scatter)} at δ/R = 0.01, 0.1, 0.3, 0.5"
    )
    return Finding(ours, verdict(bool((np.diff(scatter) < 0.0).all())), "")


def area_stays(facts: Facts) -> Finding:
    curve, left = facts.curve(1000.0), []
    for number in (0, -1):
        rows = curve.rows(facts.study.unloadings[1000.0, NU][number].branch)
        if curve.contact_radius is None:
            raise Lacking("the contact radius")
        share = curve.force[rows] / curve.force[rows][0]
        left.append(float(np.interp(0.2, share[::-1], (curve.contact_radius[rows] / curve.contact_radius[rows][0])[::-1])))
    ours = (
        f"at a fifth of the force the contact radius is {left[0]:.2f} of its start from the smallest overlap, {left[1]:.2f} from the "
        "largest (E/σ_y = 1000)"
    )
    return Finding(ours, verdict(left[1] > left[0] + 0.05), "")


def towards_one(facts: Facts) -> Finding:
    least = int(np.argmin(facts.study.points.exponent))
    points = facts.study.points
    ours = (
        f"least α {points.exponent[least]:.3f} (E/σ_y = {points.modulus[least]:g}, ν = {points.poisson[least]:g}, δ/R = "
        f"{points.depth[least]:g})"
    )
    reason = "1 is approached, not reached, within the range."
    return Finding(ours, verdict(points.exponent[least] < 1.1 and points.modulus[least] >= 500.0), reason)


def less_and_less(facts: Facts) -> Finding:
    values = [facts.at("exponent", modulus, 0.5) for modulus in (10.0, 100.0, 1000.0)]
    ours = f"α at δ/R = 0.5: {', '.join(f'{v:.3f}' for v in values)} for E/σ_y = 10, 100, 1000"
    return Finding(ours, verdict(values[0] - values[1] > 3.0 * (values[1] - values[2]) > 0.0), "")


def modulus_is_primary(facts: Facts) -> Finding:
    moduli = facts.study.moduli(NU)
    ends = {depth: [facts.at("exponent", modulus, depth) for modulus in moduli] for depth in (0.01, 0.5)}
    ours = "; ".join(f"α {span(values)} at δ/R = {depth:g}" for depth, values in ends.items())
    return Finding(ours, verdict(np.ptp(ends[0.5]) > 3.0 * np.ptp(ends[0.01])), "")


def poisson_elastic(facts: Facts) -> Finding:
    there = [nu for nu in facts.study.poisson if (1.0, nu) in facts.study.curves]
    if len(there) < 2:
        raise Lacking("E/σ_y = 1 for several ν")
    alpha, radius = [facts.at("exponent", 1.0, 0.5, nu) for nu in there], [facts.radius_at(1.0, 0.5, nu) for nu in there]
    ours = (
        f"δ/R = 0.5, E/σ_y = 1, ν = {', '.join(f'{nu:g}' for nu in there)}: α = {', '.join(f'{v:.2f}' for v in alpha)}, a/R = "
        f"{', '.join(f'{v:.2f}' for v in radius)}"
    )
    grows = bool((np.diff(alpha) > -0.005).all() and (np.diff(radius) > 0.0).all())
    return Finding(
        ours,
        verdict(grows, alpha[-1] > alpha[0]),
        "From ν = 0.3 on, the rise of α is spent. In our runs these bodies yield just before the end.",
    )


def poisson_plastic(facts: Facts) -> Finding:
    there = [nu for nu in facts.study.poisson if (1000.0, nu) in facts.study.curves]
    if len(there) < 2:
        raise Lacking("E/σ_y = 1000 for several ν")
    alpha = [facts.at("exponent", 1000.0, 0.5, nu) for nu in there]
    ours = f"δ/R = 0.5, E/σ_y = 1000: α = {', '.join(f'{v:.3f}' for v in alpha)} for ν = {', '.join(f'{nu:g}' for nu in there)}"
    return Finding(ours, verdict(bool((np.diff(alpha) < 0.0).all())), "")


def elastic_to_bar(facts: Facts) -> Finding:
    moduli = facts.study.moduli(NU)
    deep, shallow = ([facts.at("exponent", modulus, depth) for modulus in moduli] for depth in (0.5, 0.01))
    least = int(np.argmin(shallow))
    ours = f"α at δ/R = 0.5 from {deep[0]:.2f} to {deep[-1]:.2f} with rising E/σ_y"
    reason = f"At δ/R = 0.01 it is not so: α is least, {shallow[least]:.3f}, at E/σ_y = {moduli[least]:g} and rises again (Fig. 22a)."
    return Finding(ours, verdict(bool((np.diff(deep) < 0.0).all())), reason)


STATEMENTS = (
    Statement("4.4, Fig. 8", "For E/σ_y = 1 and 2 the exponent rises with the overlap, far beyond Hertz's", "—", rises_when_elastic),
    Statement(
        "4.4, Fig. 8",
        "For plastic bodies the exponent falls, ever more with the overlap, until unloading is nearly linear",
        "—",
        falls_when_plastic,
    ),
    Statement("4.4", "A yielded elastic bar without lateral constraint unloads linearly", "α = 1", bar),
    Statement("4.4", "For E/σ_y = 1 the exponent tends to Hertz's as the overlap vanishes", "1.5", hertz_limit),
    Statement("4.4", "For the elastic sphere a² grows from Rδ to a multiple of it at δ/R = 0.5", "about 1.4", area_at_half),
    Statement("4.4", "In unloading the elastic contact area shrinks faster than Hertz's", "—", area_falls_faster),
    Statement("4.4", "Yielded states of stress may have any hydrostatic part", "—", any_pressure),
    Statement("4.4", "At high E/σ_y further loading drives stress towards ever larger hydrostatic compression", "—", hydrostatic),
    Statement("4.4", "Stress becomes more uniform in the body as the overlap grows", "—", uniform),
    Statement("4.4", "From large overlaps of stiff bodies the contact area shrinks less in unloading", "—", area_stays),
    Statement("4.4", "The exponent tends to 1 as overlap and stiffness ratio grow", "→ 1", towards_one),
    Statement("4.4", "A further rise of E/σ_y changes the exponent less and less", "—", less_and_less),
    Statement("4.4", "E/σ_y governs the transition, the overlap magnifies the differences", "—", modulus_is_primary),
    Statement("4.4, Fig. 22", "For elastic bodies contact area and exponent grow with Poisson's ratio", "—", poisson_elastic),
    Statement("4.4, Fig. 22", "At high E/σ_y the exponent falls somewhat with Poisson's ratio", "—", poisson_plastic),
    Statement("7", "With rising E/σ_y unloading goes from that of an elastic sphere to that of a plastic bar", "—", elastic_to_bar),
)
