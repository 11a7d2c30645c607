"""`fe2dem uncertainty`: one batch of scenes, from the errors of a fit and the seeds of packings to bands and shares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from cases import console
from cases.batch.plan import uncertainty_plan
from cases.batch.store import Record
from cases.casefile.reading import read_case
from cases.casefile.schema import Case, is_file
from cases.casefile.validation import suggestion
from cases.report.plots import png
from cases.study import run_tasks
from cases.tradeoff.page import write_page, write_table
from cases.uncertainty import page
from cases.uncertainty.runs import put_together
from cases.uncertainty.variance import taken_apart
from contactlaws import fitted
from contactlaws.errors import Problem, require

#: fewer packings or laws leave nothing to take apart
LEAST = 2
TABLE, PICTURE, REPORT = "uncertainty", "uncertainty.png", "uncertainty.html"


class Layout(NamedTuple):
    """How much is run."""

    draws: int
    packings: int


def propagate(
    case_file: Path,
    scene: str | None,
    layout: Layout,
    out: Path | None = None,
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    take_over: bool = False,
) -> tuple[Path, Mapping[str, Record]]:
    """Run a scene of a case on every drawn law and packing; write and print bands and shares. Returns the page and all records.

    scene: its name in the case file; may be left out if there is but one. out: folder for all results, without it
    results/CASE-SCENE. Run again, only what is missing is computed; with more draws or packings what is there stays.

    Raises `InputError` for a case that cannot be used, before anything is computed, and where fewer than two laws ran on all packings.
    """
    case = read_case(case_file)
    require(_problems(case, case_file, scene, layout))
    name = scene or next(iter(case.scenes))
    tasks = uncertainty_plan(case, name, *layout, case_file.resolve().parent)
    folder = (out or Path("results") / f"{case_file.stem}-{name}").resolve()
    title = f"{case.title}: {name}, its law's errors and its packing"
    records = run_tasks(title, case_file.resolve(), tasks, folder, jobs, scheduler, take_over)
    return _written(title, folder, records, case.scenes[name].loading), records


def _written(title: str, folder: Path, records: Mapping[str, Record], loading: str) -> Path:
    """Table, picture and page; what was found is printed."""
    runs = put_together(records, folder, loading)
    parts = taken_apart(runs.stress)
    write_table(page.rows(runs, parts), folder / TABLE)
    png(page.picture(runs, parts), folder / PICTURE)
    fit = next(record for record in records.values() if record.kind == "fits")
    law = fitted.load(folder / fit.files["law"])
    free = {name: (float(getattr(law.law, name)), law.standard_errors[name]) for name in fit.summary["free"]}
    cost = sum(record.cpu_seconds for record in records.values())
    lead = f"{len(runs.laws)} laws ({law.name}) on {len(runs.packings)} packings, {cost:.0f} CPU seconds in all; {fit.code}."
    for words in (*page.sentences(runs, parts), *runs.left_out):
        console.out.print(words)
    return write_page(folder / REPORT, title, lead, page.sections(runs, parts, free))


def _problems(case: Case, file: Path, scene: str | None, layout: Layout) -> Iterator[Problem]:
    if not case.scenes:
        yield Problem("scenes", None, f"{file} declares none", "add a table [scenes.NAME]; cases/quickstart.toml shows one")
    elif scene is None and len(case.scenes) > 1:
        yield Problem("--scene", None, f"{file} declares {len(case.scenes)} scenes", f"name one of {', '.join([*case.scenes][:12])}")
    elif scene is not None and scene not in case.scenes:
        yield Problem("--scene", scene, f"is no scene of {file}", suggestion(scene, case.scenes))
    else:
        table = case.scenes[scene or next(iter(case.scenes))]
        fit = table.fit
        if table.shape is not None:
            yield Problem("shape", table.shape, "ellipsoids have no fitted law whose errors could be drawn", "name a scene of spheres")
        if fit is not None and is_file(fit):
            bound = "is a law from a file, which does not say how its errors hang together"
            yield Problem("fit", fit, bound, "name a table under [fits]: the law is fitted again, to its curves")
    for name, number in layout._asdict().items():
        if number < LEAST:
            yield Problem(f"--{name}", number, f"must be at least {LEAST}", "take 8 or more; the intervals say what it is worth")
