"""The page: what was done, Eq. 3, every statement judged, every figure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from cases.console import number
from cases.edmans_sinka_2020 import page_equation_3, paper, tables
from cases.edmans_sinka_2020.data import Study
from cases.edmans_sinka_2020.drawing import Drawn
from cases.edmans_sinka_2020.refit import Refit
from cases.edmans_sinka_2020.wording import Block, figure, statements, table, text
from cases.report.judgement import Judgement, tally
from cases.tradeoff.page import write_page

TITLE = "Unloading of elastic-plastic spheres: the study of Edmans & Sinka (2020), done again"
NOT_REDONE = (
    "Not redone: Figs. 1 and 14 are sketches, Fig. 2 is the paper's mesh. Not known from captions and text: which unloadings Fig. 3 "
    "draws, ν of Fig. 4, abscissae of Figs. 9, 12, 21 and 22, and what Fig. 13 draws where the contact opens at its centre. The data "
    "behind the paper's figures are not public: what is compared are the numbers that its text, captions and table state."
)


def write(
    path: Path,
    study: Study,
    judgements: Sequence[Judgement],
    pictures: Sequence[Drawn],
    refits: Sequence[Refit],
    errors: Sequence[tables.Row],
) -> Path:
    """Write the page; one file without any link."""
    sections = [
        {"title": "What was done", "blocks": list(_summary(study, judgements))},
        {"title": "The fitted unloading stiffness, Eq. 3", "blocks": list(page_equation_3.blocks(refits, errors))},
        {"title": "Every statement of the paper", "blocks": list(_statements(judgements))},
        {"title": "Figures", "blocks": [text(NOT_REDONE), *(_figure(item) for item in pictures)]},
        {"title": "Materials", "blocks": list(_materials(study))},
        {"title": "All unloadings", "blocks": list(_matrices(study))},
        {"title": "Where the curves are from, and what they cost", "blocks": list(_sources(study))},
    ]
    count = sum(len(found) for found in study.unloadings.values())
    lead = (
        f"{len(study.curves)} materials, {count} unloadings; one sphere pressed by its mid-plane against a rigid frictionless flat, by "
        "finite elements."
    )
    return write_page(path, TITLE, lead, sections)


def _summary(study: Study, judgements: Sequence[Judgement]) -> Iterator[Block]:
    found = tally(judgements)
    yield text(
        "B. D. Edmans and I. C. Sinka pressed an elastic-perfectly plastic sphere 560 times: ten ratios E/σ_y of Young's modulus to "
        "yield stress from 1 to 1000, four Poisson's ratios from 0 to 0.45, and unloading from 14 overlaps from 0.01 to 0.5 of the "
        "radius. Here every run, figure and number of their paper is made again with another solver, and every statement is held against "
        "it: " + ", ".join(f"{count} {name}" for name, count in found.items()) + "."
    )
    missing = [(e, nu) for nu in paper.POISSON for e in paper.MODULI if (e, nu) not in study.curves]
    if missing:
        yield text(
            f"Missing: E/σ_y, ν = {', '.join(f'{e:g}, {nu:g}' for e, nu in missing)}. What needs them is marked as not tested.", note=True
        )
    for key, curve in study.curves.items():
        if curve.stopped:
            yield text(f"E/σ_y = {key[0]:g}, ν = {key[1]:g} ended early: {curve.stopped}.", note=True)
    yield text(
        "Notation as in the paper: overbars are over the radius, the yield stress, or πR²σ_y; ρ = 1/(δ̄_max − δ̄_0) is the unloading "
        "stiffness, α the exponent of the unloading force. Both solvers have von Mises yield on the true stress at large strain and no "
        "hardening; they differ in the elastic law at large elastic strain, which matters below E/σ_y = 5, and in that our mesh keeps "
        "the number of elements in the contact at all overlaps."
    )


def _statements(judgements: Sequence[Judgement]) -> Iterator[Block]:
    yield text("In our words, with the place in the paper. The verdict is computed from our curves; “not tested” says what is lacking.")
    yield from statements(judgements)


def _figure(item: Drawn) -> Block:
    return figure(item.picture.number, item.svg, item.picture.caption)


def _materials(study: Study) -> Iterator[Block]:
    columns = {
        "E/σ_y": "modulus_over_yield_stress",
        "ν": "poissons_ratio",
        "first yield δ̄_c": "yield_overlap_over_radius",
        "Eq. 5 corrected": "yield_overlap_corrected",
        "its distance from the mid-plane": "yield_distance_from_midplane_over_radius",
        "F̄ at the end": "largest_force_over_pi_R2_Y",
        "least ρ": "least_stiffness",
        "last over least ρ": "stiffness_last_over_least",
        "first α": "exponent_first",
        "last α": "exponent_last",
        "least R²": "least_r2",
    }
    rows = tables.materials(study)
    yield text(
        "unloadings.csv and unloadings.parquet hold all unloadings with their energies and estimated errors; materials.csv this table."
    )
    yield table(tuple(columns), [tuple(number(row[name], 4) for name in columns.values()) for row in rows])


def _matrices(study: Study) -> Iterator[Block]:
    names = {"stiffness": ("Unloading stiffness ρ", 4), "exponent": ("Exponent α", 4)}
    for quantity, (title, digits) in names.items():
        for nu in study.poisson:
            depths = np.unique(study.points.depth[study.points.poisson == nu])
            yield text(f"{title} for ν = {nu:g}; E/σ_y downwards, δ/R before unloading to the right.")
            rows = []
            for modulus in study.moduli(nu):
                points = study.of(modulus, nu)
                there = dict(zip(points.depth.tolist(), getattr(points, quantity).tolist(), strict=True))
                rows.append((f"{modulus:g}", *(number(there.get(float(depth)), digits) for depth in depths)))
            yield table(("E/σ_y", *(f"{depth:g}" for depth in depths)), rows)


def _sources(study: Study) -> Iterator[Block]:
    versions: dict[str, list[float]] = {}
    for curve in study.curves.values():
        cost = curve.provenance.get("cpu_seconds", np.nan)
        versions.setdefault(str(curve.provenance.get("code", "not stated")), []).append(float(cost))
    yield table(("code", "curves", "CPU seconds"), [(code, str(len(cost)), f"{sum(cost):.0f}") for code, cost in versions.items()])
    names: Mapping[str, str] = {
        "force": "force",
        "contact_radius": "contact radius",
        "unloading_stiffness": "ρ",
        "unloading_exponent": "α",
        "recovered_energy": "recovered energy",
    }
    rows = []
    for name, title in names.items():
        values = np.array([curve.errors[name] for curve in study.curves.values() if name in curve.errors])
        if values.size:
            rows.append((title, *(f"{value:.4f}" for value in (np.median(values), values.max()))))
    yield text("Errors of mesh and steps as each curve estimates them (relative; of α absolute), over all materials.")
    yield table(("quantity", "median", "largest"), rows)
