"""Sections 2.1, 3 and 4.1: definitions, loading, first yield, energy."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Study
from cases.edmans_sinka_2020.facts import HOLDS, NU, Facts, Finding, Lacking, Statement, span, verdict
from cases.edmans_sinka_2020.figures_loading import energy_unit
from contactlaws.elastic import Hertz, hertz_force

#: a place of first yield counts as the centre, or as on the axis, within this distance (over the radius)
NEAR = 0.1


def first_yields(study: Study, moduli: list[float]) -> list[tuple[float, ...]]:
    """E/Y, nu, overlap, distance from the axis and from the mid-plane at first yield, over the radius, of those that yield."""
    found = []
    for modulus, nu in study.keys:
        curve = study.curves[modulus, nu]
        if modulus in moduli and curve.yield_overlap is not None and curve.yield_place is not None:
            found.append((modulus, nu, *(value / curve.radius for value in (curve.yield_overlap, *curve.yield_place))))
    if not found:
        raise Lacking(f"a curve that yields with E/σ_y among {moduli}")
    return found


def extremes(facts: Facts, modulus: float, poisson: float = NU) -> tuple[float, float, float]:
    """Overlap of the least slope of the force beyond D = .02; overlap of the largest stored energy, and its size over `energy_unit`."""
    curve, rows = facts.curve(modulus, poisson), facts.curve(modulus, poisson).rows(0)
    if curve.stored_energy is None:
        raise Lacking("the stored energy")
    x = curve.overlap[rows] / curve.radius
    line = np.linspace(0.02, x[-1], 500)
    slope = PchipInterpolator(x, curve.force[rows]).derivative()(line)
    energy = PchipInterpolator(x, curve.stored_energy[rows] / energy_unit(curve))(line)
    return float(line[np.argmin(slope)]), float(line[np.argmax(energy)]), float(energy.max())


def hertz_limit(facts: Facts) -> Finding:
    curve = facts.curve(1.0)
    overlap, force = (column[curve.rows(0)][1] for column in (curve.overlap, curve.force))
    assert curve.material is not None
    ratio = float(force) / hertz_force(Hertz(curve.radius, curve.material.reduced_modulus), float(overlap), 0.0, 0.0, ())[0]
    ours = f"F/F_Hertz = {ratio:.3f} at δ/R = {overlap / curve.radius:.2g}"
    return Finding(
        ours, verdict(abs(ratio - 1.0) < 0.06), "What is left is the finite size of the sphere, which goes with the contact radius."
    )


def mostly_plastic(facts: Facts) -> Finding:
    share = {depth: 1.0 / (facts.at("stiffness", 1000.0, depth) * depth) for depth in (0.01, 0.5)}
    ours = f"recovered at E/σ_y = 1000: {100 * share[0.01]:.1f} % of the overlap from 0.01, {100 * share[0.5]:.2f} % from 0.5"
    return Finding(ours, verdict(share[0.01] < 0.1 and share[0.5] < 0.01), "")


def lowest_never_yields(facts: Facts) -> Finding:
    study = facts.study
    there = [key for key in study.keys if key[0] == 1.0]
    if not there:
        raise Lacking("E/σ_y = 1")
    yielded = [study.curves[key].yield_overlap for key in there]
    at = [float(value) / study.curves[key].radius for key, value in zip(there, yielded, strict=True) if value is not None]
    if not at:
        return Finding("no yield", HOLDS, "")
    body = facts.within(1.0).field("loading", 0.5)
    cell = int(np.argmax(body.von_mises))
    squeezed = float(np.exp(-body.pressure[cell] * 3.0 * (1.0 - 2.0 * NU)))
    reason = (
        "At E/σ_y = 1 it is the elastic law at large strain that decides. Ours is linear between logarithmic strain and Kirchhoff stress "
        f"in shear, so the true stress grows as a body is squeezed, where it yields to {squeezed:.2f} of its volume; a law for the true "
        "stress asks for that much more strain, which is about what is left of the range. Up to there nothing yields in either."
    )
    return Finding(f"first yield at δ/R = {span(at)}", verdict(False, min(at) > 0.4), reason)


def centre(facts: Facts) -> Finding:
    found = first_yields(facts.study, [1.0, 2.0])
    at_centre = [f"{e:g}, {nu:g}" for e, nu, _, r, z in found if np.hypot(r, z) < NEAR]
    heights = [z for *_, z in found]
    ours = f"distance from the mid-plane {span(heights)} R; at the centre only for E/σ_y, ν = {'; '.join(at_centre) or 'none'}"
    reason = "With falling E/σ_y the place wanders down the axis; it arrives at the centre only for the lowest ratio and the higher ν."
    return Finding(ours, verdict(len(at_centre) == len(found), bool(at_centre)), reason)


def below_surface(facts: Facts) -> Finding:
    found = first_yields(facts.study, [5.0, 10.0, 20.0])
    off_axis, depth = max(r for *_, r, _ in found), [1.0 - z for *_, z in found]
    scale = [d / np.sqrt(item[2]) for d, item in zip(depth, found, strict=True)]
    ours = f"on the axis (within {off_axis:.2g} R), {span(depth)} R below the pole, or {span(scale)} of √(Rδ)"
    return Finding(
        ours, verdict(off_axis < 0.05 and min(depth) > 0.02), "Hertz's theory has 0.38 (ν = 0) to 0.56 (ν = 0.45) of the contact radius."
    )


def at_surface(facts: Facts) -> Finding:
    found = first_yields(facts.study, [500.0, 1000.0])
    scale = [(1.0 - z) / np.sqrt(overlap) for _, _, overlap, _, z in found]
    elements = [np.sqrt(overlap) / paper.ELEMENT_EDGE for _, _, overlap, *_ in found]
    ours = (
        f"{span(scale)} of the contact radius below the surface, as for every stiff material, at δ/R = {span([item[2] for item in found])}"
    )
    reason = (
        f"At once it is, but not at the surface: at first yield the contact radius is {span(elements, '.1f')} elements of the paper's "
        "mesh, which therefore sees yield in its surface element. Strains this small cannot move the place where Hertz's stress is "
        "largest; we resolve it in a run of its own."
    )
    return Finding(ours, verdict(max(scale) < 0.1, False), reason)


def interacts(facts: Facts) -> Finding:
    found = first_yields(facts.study, [50.0, 100.0, 200.0])
    scale = [(1.0 - z) / np.sqrt(overlap) for _, _, overlap, _, z in found]
    ours = f"first yield {span(scale)} of the contact radius below the surface"
    reason = (
        "The zone starts inside as for 5 to 20 and breaks through later. At first yield √(Rδ) spans "
        f"{span([np.sqrt(item[2]) / paper.ELEMENT_EDGE for item in found])} of the paper's elements, too few to tell the two apart."
    )
    return Finding(ours, verdict(max(scale) < 0.1, True), reason)


def retarded(facts: Facts) -> Finding:
    places, slopes = [], []
    for modulus in (20.0, 100.0, 1000.0):
        line = facts.loading(modulus)
        slope = PchipInterpolator(line.depth, line.force).derivative()
        least = extremes(facts, modulus)[0]
        places.append(least)
        slopes.append(float(slope(least) / slope(np.linspace(0.01, least, 200)).max()))
    ours = f"least slope {span([100 * s for s in slopes], '.0f')} % of the largest before, at δ/R = {span(places)} (E/σ_y 20 to 1000)"
    return Finding(
        ours, verdict(max(slopes) < 0.9), "Beyond it the whole body flows and the force rises again with the growing cross-section."
    )


def contact_area_alone(facts: Facts) -> Finding:
    pressure = []
    for depth in (0.01, 0.1, 0.3, 0.5):
        line = facts.loading(1000.0)
        pressure.append(float(np.interp(depth, line.depth, line.force)) / facts.radius_at(1000.0, depth) ** 2)
    ours = f"mean contact pressure over σ_y at E/σ_y = 1000: {', '.join(f'{p:.2f}' for p in pressure)} at δ/R = 0.01, 0.1, 0.3, 0.5"
    reason = "The force does follow the area at first (indentation); as the plastic zone reaches the flanks the pressure halves."
    return Finding(ours, verdict(min(pressure) > 0.9 * max(pressure), False), reason)


def minima_and_maxima(facts: Facts) -> Finding:
    pairs = {modulus: extremes(facts, modulus) for modulus in (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)}
    text = "; ".join(f"{modulus:g}: {slope:.2f}, {energy:.2f}" for modulus, (slope, energy, _) in pairs.items())
    close = [abs(slope / energy - 1.0) < 0.25 for slope, energy, _ in pairs.values()]
    reason = (
        "The two agree where E/σ_y is 20 to 50. For stiffer bodies the stored energy is full as soon as the whole body has yielded, at "
        "ever smaller overlap, while the least slope stays at 0.2: the second depends on the shape, the first on the yield strain."
    )
    return Finding(f"E/σ_y: least slope, largest energy at δ/R = {text}", verdict(all(close), any(close)), reason)


def more_than_one(facts: Facts) -> Finding:
    largest = extremes(facts, 1000.0)[2]
    volume, shape = facts.within(1000.0).field("loading", 0.1).energies()
    unit = 2.0 / 3.0 * np.pi / (2.0 * 1000.0)
    ours = f"up to {largest:.3f}; at δ/R = 0.1, E/σ_y = 1000: {shape / unit:.3f} of shape and {volume / unit:.3f} of volume"
    reason = (
        "The value exceeds 1, but not for the stated cause: logarithmic and linear strain differ by 0.05 % at a yield strain of 0.001. "
        f"Plastic flow bounds the energy of shape only, at (1 + ν)/1.5 = {1.3 / 1.5:.3f}; the rest is hydrostatic compression, which "
        "yield does not bound."
    )
    return Finding(ours, verdict(False, largest > 1.0), reason)


def circumferential(facts: Facts) -> Finding:
    shares = {
        modulus: facts.within(modulus).field("unloaded", 0.5).elastic_strain_shares()[3] for modulus in (2.0, 5.0, 10.0, 100.0, 1000.0)
    }
    text = ", ".join(f"{modulus:g}: {100 * share:.0f} %" for modulus, share in shares.items())
    plastic = [share for modulus, share in shares.items() if modulus >= 5.0]
    reason = (
        "Mean square of the residual elastic strain over the body, circumferential part; from δ/R = 0.5. At E/σ_y = 2 little has flowed."
    )
    return Finding(f"E/σ_y: {text}", verdict(min(shares.values()) > 0.5, min(plastic) > 0.5), reason)


def flow_on_unloading(facts: Facts) -> Finding:
    shares = [
        (item.dissipated_on_unloading / item.recovered_energy, key, item.overlap / facts.study.curves[key].radius)
        for key, found in facts.study.unloadings.items()
        for item in found
        if item.dissipated_on_unloading is not None
    ]
    if not shares:
        raise Lacking("the dissipated energy")
    largest, key, depth = max(shares)
    ours = f"dissipated over recovered energy at most {100 * largest:.1f} % (E/σ_y = {key[0]:g}, ν = {key[1]:g}, δ/R = {depth:g})"
    many = sum(share[0] > 0.01 for share in shares)
    reason = f"It grows with E/σ_y, and as ν falls; it is more than 1 % on {many} of {len(shares)} unloadings."
    return Finding(ours, verdict(largest < 0.2 and key[0] >= 200.0, largest < 0.2), reason)


def other_poisson(facts: Facts) -> Finding:
    least, largest = [], []
    for nu in facts.study.poisson:
        for modulus in (50.0, 200.0, 1000.0):
            slope, energy, _ = extremes(facts, modulus, nu)
            least.append(slope)
            largest.append(energy)
    ours = f"E/σ_y 50 to 1000, all ν: least slope at δ/R = {span(least, '.2f')}, largest energy at {span(largest, '.2f')}"
    reason = (
        "Where ν is high the stored energy has a plateau in place of a peak: what exceeds the energy of shape is hydrostatic and goes "
        "with 1 − 2ν."
    )
    return Finding(ours, verdict(max(least) - min(least) < 0.05 and max(largest) < 0.25, max(least) - min(least) < 0.1), reason)


STATEMENTS = (
    Statement("2.1", "For a vanishing overlap and a low stiffness ratio the response is Hertz's", "—", hertz_limit),
    Statement("2.1", "Stiff bodies deform plastically and recover little of the overlap", "—", mostly_plastic),
    Statement("4.1, Fig. 3", "No yield for E/σ_y = 1 up to δ/R = 0.5", "no yield", lowest_never_yields),
    Statement("4.1", "First yield at the centre of the sphere for E/σ_y < 5", "centre", centre),
    Statement(
        "4.1",
        "First yield on the axis somewhat below the surface for E/σ_y from 5 to 20, as linear elasticity has it",
        "below the surface",
        below_surface,
    ),
    Statement("4.1", "For E/σ_y from 50 to 200 the plastic zone interacts with the contact surface as it develops", "—", interacts),
    Statement("4.1", "First yield at the contact surface, almost at once, for the stiffest bodies (E/σ_y > 500)", "surface", at_surface),
    Statement("4.1", "Once plastic flow dominates, the force grows less", "—", retarded),
    Statement(
        "4.1, Figs. 3, 4", "The overlaps of least slope of the force and of largest strain energy are related", "—", minima_and_maxima
    ),
    Statement(
        "Fig. 4",
        "The strain energy exceeds that of a half sphere at the yield stress, because logarithmic strain is used",
        "> 1",
        more_than_one,
    ),
    Statement("Fig. 4", "The elastic strain left after unloading is mainly circumferential", "—", circumferential),
    Statement("4.1", "Results are similar for other Poisson's ratios", "—", other_poisson),
    Statement("4.1", "Unloading is mainly elastic, with some plastic flow at high E/σ_y", "—", flow_on_unloading),
)
