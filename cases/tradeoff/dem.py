"""`fe2dem tradeoff dem`: error of a packing's stress against CPU time for each setting, beside the scatter between packings."""

from __future__ import annotations

import time
from pathlib import Path

from cases import console
from cases.report.plots import png
from cases.tradeoff import dem_errors, dem_page, dem_runs
from cases.tradeoff.dem_settings import plan
from cases.tradeoff.page import write_page, write_table
from contactlaws.version import code_version


def tradeoff_dem(out: Path, quick: bool) -> Path:
    """Measure all, or what is missing in `out`; print and write the table (.csv and .parquet), the pictures and report.html.

    Every run is a file in `out`/runs, so that an interrupted measurement goes on where it was.
    """
    folder, began = out / "runs", time.perf_counter()
    folder.mkdir(parents=True, exist_ok=True)
    wanted = plan(quick)
    with console.bar("packings") as progress:
        results = dem_runs.measure(wanted.runs, folder, progress)
    rows = dem_errors.rows(wanted, results)
    verdicts = dem_errors.verdicts(rows)
    write_table([row._asdict() for row in rows], out / "tradeoff_dem")
    for quantity in dem_runs.QUANTITIES:
        png(dem_page.picture(rows, quantity), out / f"tradeoff_dem_{quantity}.png")
    cpu = sum(found["cpu_seconds"] for found in results.values())
    lead = f"{len(results)} runs, {cpu:.0f} CPU seconds; this command took {time.perf_counter() - began:.0f} s; {code_version()}."
    shown = dem_page.sections(wanted, results, rows, verdicts)
    page = write_page(out / "report.html", "What accuracy costs: packings", lead, shown, dem_errors.failures(results))
    _print("stress at the largest strain, what each choice changes", dem_page.choices_table(wanted, results, rows, ("peak",)))
    _print("what matters", dem_page.verdicts_table(verdicts))
    return page


def _print(title: str, found: dem_page.Table) -> None:
    header, lines = found
    sheet = console.sheet(*header)
    sheet.title, sheet.title_justify = title, "left"
    for line in lines:
        sheet.add_row(*line)
    console.out.print(sheet)
