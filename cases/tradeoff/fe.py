"""`fe2dem tradeoff fe`: error of the continuum solver against CPU time, for mesh, steps, smoothing, element and levels of tolerance."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from cases import console
from cases.report.plots import png
from cases.tradeoff import elements, fe_errors, fe_runs, locking
from cases.tradeoff.fe_page import Depth, picture, sections
from cases.tradeoff.fe_settings import plans, steps_plan
from cases.tradeoff.kept import kept
from cases.tradeoff.page import write_page, write_table
from contactlaws.version import code_version

#: meshes on which elements are compared; the quick look leaves out the last
ELEMENT_DIVISIONS = {"bilinear, full integration": (4, 6, 8, 12, 16, 24), "bilinear, mean dilatation": (4, 6, 8, 12, 16, 24)}
BIQUADRATIC_DIVISIONS = (4, 6, 8, 12)


def tradeoff_fe(out: Path, quick: bool, finest: int | None) -> Path:
    """Measure all, or what is missing in `out`; write tables (tradeoff_fe and elements, .csv and .parquet), pictures and report.html.

    Every run is a file in `out`/runs, so that an interrupted measurement goes on where it was.
    """
    folder, began = out / "runs", time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    with console.bar("continuum solver") as progress:
        measured = [(plan, fe_runs.measure(plan.everything, folder, progress)) for plan in plans(quick, finest)]
        alone = steps_plan()
        alone_results = fe_runs.measure(alone.everything, folder, progress)
        progress(0.0, "elements")
        compared, locked = _elements(folder, quick), _locked(folder, quick)
    rows = [row for plan, results in measured for row in fe_errors.rows(plan, results)]
    alone_rows = list(fe_errors.rows(alone, alone_results))
    depths = [
        Depth(plan, fe_errors.summaries(plan, fe_errors.rows(plan, results)), fe_errors.uncertainty(plan, results))
        for plan, results in measured
    ]
    verdicts = fe_errors.verdicts([depth.summaries for depth in depths])
    write_table([row._asdict() for row in (*rows, *alone_rows)], out / "tradeoff_fe")
    write_table([one._asdict() for one in compared], out / "elements")
    for depth in depths:
        png(picture(depth), out / f"tradeoff_fe_{depth.plan.depth:g}.png")
    cpu = sum(mesh["cpu_seconds"] for _, results in [*measured, (alone, alone_results)] for found in results for mesh in found["meshes"])
    lead = (
        f"{sum(len(results) for _, results in measured) + len(alone_results)} runs, {cpu:.0f} CPU seconds; "
        f"this command took {time.perf_counter() - began:.0f} s; {code_version()}."
    )
    failed = [problem for plan, results in [*measured, (alone, alone_results)] for problem in fe_errors.failures(plan, results)]
    shown = sections(depths, verdicts, (alone, fe_errors.summaries(alone, alone_rows)), compared, locked)
    page = write_page(out / "report.html", "What accuracy costs: the continuum solver", lead, shown, failed)
    show(verdicts)
    return page


def _elements(folder: Path, quick: bool) -> list[elements.Measured]:
    divisions = {**ELEMENT_DIVISIONS, "biquadratic": BIQUADRATIC_DIVISIONS}
    runs = [(name, nu, m) for nu in elements.POISSONS_RATIOS for name, own in divisions.items() for m in (own[:-1] if quick else own)]
    found = [kept(folder, elements.__name__, run, partial(elements.measure, *run)) for run in runs]
    return [elements.Measured(*one) for one in found]


def _locked(folder: Path, quick: bool) -> list[locking.Locked]:
    materials = locking.MATERIALS[:1] if quick else locking.MATERIALS
    return [locking.Locked(*one) for run in materials for one in kept(folder, locking.__name__, run, partial(locking.measure, *run))]


def show(verdicts: Sequence[fe_errors.Verdict]) -> None:
    """One line for each level of tolerance."""
    sheet = console.sheet("tolerance", "divisions", "verdict")
    for verdict in verdicts:
        sheet.add_row(f"{100 * verdict.tolerance:g} %", str(verdict.resolution.divisions), verdict.words)
    sheet.columns[2].justify = "left"
    console.out.print(sheet)
