"""The page: what was done, causes apart, constants, every statement judged, every figure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from cases.becker_kamlah_2021 import own, tables
from cases.becker_kamlah_2021.data import nmc_key
from cases.becker_kamlah_2021.facts import QUANTITIES, READINGS, Facts
from cases.becker_kamlah_2021.joint_fit import NAMES
from cases.becker_kamlah_2021.shape_fit import FASTEST, SLOWEST, Shape
from cases.becker_kamlah_2021.statements import in_words
from cases.console import number
from cases.edmans_sinka_2020.drawing import Drawn
from cases.edmans_sinka_2020.wording import Block, figure, statements, table, text
from cases.report import parts
from cases.report.judgement import Judgement
from cases.tradeoff.page import write_page
from contactlaws.rivals.becker_kamlah import PRESSURE_CONSTANTS, RADIUS_CONSTANTS

TITLE = "Elastoplastic ellipsoids: the law of Becker & Kamlah (2021), done again"
NOT_REDONE = (
    "Figs. 1 to 8 are sketches and the mesh; Fig. 14 shows the pressure along both axes of a triaxial contact, which a solver of bodies of "
    "revolution cannot give. The paper's data are not public: what is compared are numbers of its text, tables and captions."
)
SYMBOLS = {"pressure_ratio": "λ_max", "radius_ratio": "ε_max"}


def write(path: Path, facts: Facts, judgements: Sequence[Judgement], pictures: Sequence[Drawn]) -> Path:
    """Write the page; one file without any link."""
    ours = [item for item in pictures if item.picture.number is None]
    sections = [
        {"title": "What was done", "blocks": list(_summary(facts, judgements))},
        {"title": "What is elastic, what is loading, what is unloading", "blocks": [*_apart(facts), *(_figure(item) for item in ours)]},
        {"title": "The constants of Eq. 52", "blocks": list(_constants(facts))},
        {"title": "Every statement of the paper", "blocks": list(_statements(judgements))},
        {"title": "Figures", "blocks": [text(NOT_REDONE), *(_figure(item) for item in pictures if item.picture.number is not None)]},
        {"title": "Where the curves are from, and what they cost", "blocks": list(_sources(facts))},
    ]
    bodies = sum(len(found) for found in facts.study.bodies.values())
    lead = f"{bodies} spheroids of {len(facts.study.bodies)} materials, pressed by the mid-plane against a rigid flat, by finite elements."
    return write_page(path, TITLE, lead, sections)


def _summary(facts: Facts, judgements: Sequence[Judgement]) -> Iterator[Block]:
    yield text(
        "V. Becker and M. Kamlah extend Thornton's law to two ellipsoids: Hertz's ellipse up to first yield, then a pressure λY on the "
        "area that Hertz would have, with λ growing from 1.6 to λ_max, and a Hertzian unloading of a flatter body. Two functions of "
        "R_e/r, read from finite elements of one material (NMC), hold all that is not derived. Here the law is taken as published, with "
        f"what is misprinted set right, and every statement is held against other finite elements: {in_words(judgements)}."
    )
    yield text(
        "A spheroid a : b : b pressed along a against the flat is the pair with its mirror image: R_e/r = (b/a)^(4/3)/4, from 0.1 to 0.63 "
        "for b/a from 0.5 to 2, the whole axis of the paper's Fig. 12. Triaxial bodies are not computed. Overlaps of one body over its "
        "mean radius are those of the pair over both. δ_Y, c_Y, F_pY are the paper's, from Hertz at 1.6 Y. Forces are compared up to 15 %."
    )
    stopped = [(key, body) for key in facts.study.bodies for body in facts.study.of(key) if body.curve.stopped]
    for key, body in stopped:
        yield text(f"{body.name} of E/Y = {key[0]:g}, ν = {key[1]:g} ended early: {body.curve.stopped}.", note=True)


def _apart(facts: Facts) -> Iterator[Block]:
    yield text(
        "NMC, by shape. First yield by finite elements over δ_Y; elastic force over Hertz's at δ_Y: what a body of finite size does before "
        "anything is plastic. Mean difference of the force along the loading to 15 % over its largest: with Eq. 54; with Eq. 54, but up to "
        "δ_Y the body's own force in place of Hertz's, and what that adds at δ_Y kept beyond; with λ_max and ε_max read from the body. "
        "Contact area over Eq. 9 at 15 %; work that the law gives back over work put in, at worst. Last: the loading by our law."
    )
    columns = [
        "a:b",
        "R_e/r",
        "first yield",
        "F/F_Hertz at δ_Y",
        "loading, Eq. 54",
        "elastic part right",
        "own constants",
        "area",
        "work back",
    ]
    rows = [
        [
            row.name,
            f"{row.relative:.3f}",
            f"{row.first_yield:.3f}",
            f"{row.elastic_excess:.3f}",
            f"{100 * row.error:.2f} %",
            f"{100 * row.elastic_right:.2f} %",
            f"{100 * row.refitted:.2f} %",
            f"{row.area:.2f}",
            f"{row.gain:.3f}",
            *([] if row.own is None else [f"{100 * row.own:.2f} %"]),
        ]
        for row in facts.loading
    ]
    yield table(columns + ([own.NAME] if facts.loading and facts.loading[0].own is not None else []), rows)
    yield text(
        "Unloadings of NMC: overlap left over the largest one; mean difference of the force over its largest, with the law's first "
        "force as it is and set right; jump β of the law's contact radius, and its contact area just after, over finite elements."
    )
    columns = ["a:b", "from δ/r", "δ_p/δ*", "Eqs. 34, 44", "force", "its shape alone", "β", "area"]
    found = [
        [
            row.name,
            f"{row.depth:g}",
            f"{row.residual:.3f}",
            f"{row.published:.3f}",
            f"{100 * row.error:.1f} %",
            f"{100 * row.shape_error:.1f} %",
            f"{row.beta:.2f}",
            f"{row.area:.2f}",
            *([] if row.own is None else [f"{row.own_residual:.3f}", f"{100 * row.own:.2f} %"]),
        ]
        for row in facts.unloading
        if row.depth > 0.02
    ]
    more = ["δ_p/δ*, " + own.NAME, "force, " + own.NAME] if facts.unloading and facts.unloading[0].own is not None else []
    yield table(columns + more, found)


def _constants(facts: Facts) -> Iterator[Block]:
    yield text(
        "λ_max = m exp(o R_e/r) + p and ε_max = s exp(t R_e/r) + u. The paper does not say how a plateau was read. At first yield λ is "
        "0/0, and past its largest value it falls again; so λ_max and ε_max are those with which Eqs. 25 to 31, n = 1.8, fit the force "
        "best up to 15 % (reading “force”, which meets Eq. 54 for NMC). Where that shows no transition, λ at 15 % stands for λ_max, and "
        "ε_max has no value. Reading “plateau”: the largest λ beyond 1.5 δ_Y and where it is. Standard errors; where they reach the "
        "values, the three constants of a line are not told apart and only their curve is meant."
    )
    rows = []
    for quantity, names, paper in zip(QUANTITIES, tables.CONSTANTS.values(), (PRESSURE_CONSTANTS, RADIUS_CONSTANTS), strict=True):
        found = facts.shapes.get((nmc_key(), "force", quantity))
        for i, name in enumerate(names):
            ours = "–" if found is None else f"{found.constants[i]:.3g} ± {found.errors[i]:.2g}"
            rows.append((name, f"{paper[i]:g}", ours))
    yield table(("NMC", "Eq. 53", "ours"), rows)
    yield from _exponents(facts)
    yield from _joint(facts)
    materials: list[tuple[str, ...]] = []
    for key in facts.read_of:
        cells = []
        for reading in READINGS:
            for quantity in QUANTITIES:
                found = facts.shapes.get((key, reading, quantity))
                cells.append("–" if found is None else _row_of(found))
        if any(cell != "–" for cell in cells):
            materials.append((f"{key[0]:.4g}, {key[1]:g}", *cells))
    yield text("Every material with five readings or more; in brackets the largest difference of a body. constants.csv has the errors.")
    yield table(("E/Y, ν", "m, o, p (force)", "s, t, u (force)", "m, o, p (plateau)", "s, t, u (plateau)"), materials)
    yield from _together(facts)


def _row_of(shape: Shape) -> str:
    values = ", ".join(f"{value:.3g}" for value in shape.constants)
    return f"{values} ({100 * shape.largest:.0f} %)"


def _exponents(facts: Facts) -> Iterator[Block]:
    rows = [
        (
            row.body.name,
            f"{row.body.relative:.3f}",
            f"{row.force.pressure_ratio:.3f} ± {row.force.pressure_error:.2g}" if row.force.risen else f"{row.force.level:.3f} at 15 %",
            f"{row.force.radius_ratio:.3f} ± {row.force.radius_error:.2g}" if row.force.seen else "not seen",
            f"{row.free.exponent:.2f} ± {row.free.exponent_error:.2g}" if np.isfinite(row.free.condition) else "not told",
            number(row.free.condition, 3),
            f"{100 * row.force.misfit:.2f}, {100 * row.free.misfit:.2f} %",
        )
        for row in facts.nmc
    ]
    yield text(
        "NMC, body by body, and with n free between 1 and 8: from the sphere on n is not told, since a larger one with a larger ε_max does "
        "as well."
    )
    yield table(("a:b", "R_e/r", "λ_max", "ε_max", "n if free", "condition", "misfit held, free"), rows)


def _joint(facts: Facts) -> Iterator[Block]:
    if not facts.joint:
        return
    yield text(
        "All seven constants at once, with n, from the forces of all shapes in which λ rises; a dash where a constant does nothing. Where "
        "errors reach the values the constants stand for each other; for E/Y of 60 and more the misfit shows that no constants serve."
    )
    rows = []
    for key, found in facts.joint.items():
        cells = [
            f"{value:.3g} ± {error:.2g}" if np.isfinite(error) else "–" for value, error in zip(found.constants, found.errors, strict=True)
        ]
        rows.append((f"{key[0]:.4g}, {key[1]:g}", *cells, f"{100 * found.misfit:.2f} %", number(found.condition, 3), str(found.bodies)))
    yield table(("E/Y, ν", *NAMES, "misfit", "condition", "bodies"), rows)


def _together(facts: Facts) -> Iterator[Block]:
    if not facts.together:
        return
    yield text(
        "All materials together, with L = ln(E/Y): m, p, s, u = c_0 + c_1 L + c_2 L² + c_3 ν; o and t = "
        f"{FASTEST:g} + {SLOWEST - FASTEST:g}/(1 + exp(−c_0 − c_1 L − c_2 L² − c_3 ν)); of λ_max and of ln ε_max. A description for E/Y "
        "from 12 to 1000, not a law: the misfit of Eq. 28 to stiff bodies remains whatever its constants are."
    )
    rows = []
    for (reading, quantity), found in facts.together.items():
        for name, row, errors in zip(tables.CONSTANTS[quantity], found.coefficients, found.errors, strict=True):
            cells = [f"{value:.3g} ± {error:.2g}" for value, error in zip(row, errors, strict=True)]
            rows.append((f"{name} of {'ln ' if found.logarithm else ''}{SYMBOLS[quantity]}, {reading}", *cells))
        off = f"typically {100 * found.typical:.1f} %", f"at worst {100 * found.largest:.0f} %"
        rows.append((f"off, of {found.bodies} bodies", *off, "", ""))
    yield table(("constant", "c_0", "c_1", "c_2", "c_3"), rows)


def _statements(judgements: Sequence[Judgement]) -> Iterator[Block]:
    yield text("In our words, with the place in the paper. The verdict is computed from our curves.")
    yield from statements(judgements)


def _figure(item: Drawn) -> Block:
    return figure(item.picture.number, item.svg, item.picture.caption)


def _sources(facts: Facts) -> Iterator[Block]:
    versions: dict[str, list[float]] = {}
    every = [body.curve for found in facts.study.bodies.values() for body in found.values()]
    for curve in every:
        cost = curve.provenance.get("cpu_seconds", np.nan)
        versions.setdefault(str(curve.provenance.get("code", "not stated")), []).append(float(cost))
    yield parts.table(("code", "curves", "CPU seconds"), [(code, str(len(cost)), f"{sum(cost):.0f}") for code, cost in versions.items()])
    rows = []
    for name in ("force", "contact_radius", "unloading_stiffness", "recovered_energy"):
        values = np.array([curve.errors[name] for curve in every if name in curve.errors])
        if values.size:
            rows.append((name.replace("_", " "), f"{np.median(values):.4f}", f"{values.max():.4f}"))
    yield text("Errors of mesh and steps as each curve estimates them (relative).")
    yield table(("quantity", "median", "largest"), rows)
    yield text("bodies.csv, constants.csv, joint.csv, together.csv, loading.csv, unloading.csv and statements.csv hold all numbers.")
