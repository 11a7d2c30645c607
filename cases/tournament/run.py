"""The tournament on a folder of curves: play, write the tables and the page, say on the terminal who is how good."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from calibration.tournament import PERCENTILES, SCORED, Fitted, Score, Standing, Tournament, play, standings
from calibration.tournament_entrants import Entrant, entrants
from cases.batch.results import load_case
from cases.tournament.cost import Cost, costs
from cases.tradeoff.page import write_table
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.dispatch import law_of
from contactlaws.errors import InputError, Problem
from contactlaws.flaws import FLAWS
from contactlaws.version import code_version

#: the material that the cost per contact is taken at, and that the picture of the curves shows if it is there
TYPICAL = 100.0
#: which scores the percentiles of a standing are over
SUBSETS = ("all", "plastic", "inside", "unseen")


def tournament(folder: Path, laws: Sequence[str] | None, out: Path) -> tuple[Path, Tournament]:
    """Play on all curves of `folder` and write tournament.csv, .parquet, standings.csv, .parquet and report.html to `out`.

    Raises `InputError` for unknown laws, a folder without curves, or curves without unloadings, before any fit.
    """
    from cases import console
    from cases.report.tournament import write_page

    field = entrants(laws or None)
    curves, refused = curves_in(folder)
    out.mkdir(parents=True, exist_ok=True)
    began = time.process_time()
    with console.bar("tournament") as progress:
        played = play(curves, field, progress)
    measured = costs(typical_laws(played, curves))
    table = standing_rows(played, measured)
    write_table([score._asdict() for score in played.scores], out / "tournament")
    write_table(table, out / "standings")
    cpu = time.process_time() - began
    scored = len({fit.curve for fit in played.fits})
    lead = f"{len(field)} entrants, {scored} curves, {unloadings(played)} unloadings, {cpu:.0f} CPU seconds; {code_version()}."
    failures = [{"task": problem.name, "reason": str(problem)} for problem in refused]
    page = write_page(out, lead, failures, played, curves, measured, table)
    for problem in refused:
        console.log.print(f"[yellow]warning[/] not a curve: {problem}", markup=True)
    show(table)
    return page, played


def curves_in(folder: Path) -> tuple[list[Curve], list[Problem]]:
    """The curves of a folder of results (those of its last run), or of all .parquet and .csv files in it, and what could not be read.

    Raises `InputError` if there is no curve at all.
    """
    if not folder.is_dir():
        raise InputError(Problem("FOLDER", str(folder), "is no folder", "give one that holds curves (.parquet or .csv)"))
    found: list[Curve] = []
    refused: list[Problem] = []
    for path in _files(folder):
        try:
            found.append(read_curve(path))
        except InputError as error:
            refused += error.problems
    if not found:
        remedy = "compute some with fe2dem run or fe2dem reference"
        raise InputError([*refused, Problem("FOLDER", str(folder), "holds no curve", remedy)])
    return found, refused


def _files(folder: Path) -> list[Path]:
    if (folder / "case.json").exists():
        _, records = load_case(folder)
        return [folder / item.files["curve"] for item in records if item is not None and item.usable and item.kind == "curves"]
    return sorted(path for path in folder.iterdir() if path.suffix in (".parquet", ".csv") and not path.name.startswith("."))


def unloadings(played: Tournament) -> int:
    """How many were scored."""
    return len({(score.curve, score.overlap_over_radius) for score in played.scores})


def modulus_over_yield_stress(curve: Curve) -> float:
    """E/Y; infinite where it is not known."""
    material = curve.material
    return math.inf if material is None or material.yield_stress is None else material.youngs_modulus / material.yield_stress


def typical_curve(curves: Sequence[Curve]) -> Curve:
    """Of those with unloadings the one with E/Y nearest to 100 and Poisson's ratio nearest to 0.3; any if no material is known."""

    def distance(curve: Curve) -> float:
        stiffness = modulus_over_yield_stress(curve)
        return (
            math.inf
            if curve.material is None or math.isinf(stiffness)
            else abs(math.log(stiffness / TYPICAL)) + abs(curve.material.poissons_ratio - 0.3)
        )

    return min((curve for curve in curves if curve.unloadings), key=distance)


def typical_laws(played: Tournament, curves: Sequence[Curve]) -> dict[str, Any]:
    """One record of each entrant, of the typical material where it could be fitted there."""
    wanted = typical_curve(curves).content_hash
    found: dict[str, Any] = {}
    for fit in played.fits:
        if fit.law is not None and (fit.entrant not in found or fit.curve == wanted):
            found[fit.entrant] = fit.law
    return found


def standing_rows(played: Tournament, measured: Mapping[str, Cost]) -> list[dict[str, Any]]:
    """One row per entrant: what it is, what it costs, how many constants, and the percentiles of every quantity."""
    names = [entrant.name for entrant in played.entrants]
    keeps = {
        "all": lambda score: True,
        "plastic": lambda score: score.plastic,
        "inside": lambda score: score.inside,
        "unseen": lambda score: score.unseen,
    }
    tables = {name: standings(played.scores, names, keeps[name]) for name in SUBSETS}
    return [_row(entrant, played.fits, measured.get(entrant.name), tables) for entrant in played.entrants]


def _row(
    entrant: Entrant, fits: Sequence[Fitted], cost: Cost | None, tables: Mapping[str, Mapping[tuple[str, str], Standing]]
) -> dict[str, Any]:
    own = [fit for fit in fits if fit.entrant == entrant.name]
    constants = [fit.constants for fit in own if fit.constants is not None]
    record = next((fit.law for fit in own if fit.law is not None), None)
    row: dict[str, Any] = {
        "entrant": entrant.name,
        "law": entrant.law,
        "how_fitted": entrant.how,
        "claimed_range": entrant.claim,
        "source": None if record is None else law_of(record).source,
        "universal_constants": entrant.universal,
        "constants_per_material": max(constants, default=None),
        "curves_fitted": len(constants),
        "curves_failed": len(own) - len(constants),
        "flaws": "; ".join(f"{name}: {reason}" for name, reason in FLAWS.get(entrant.law, {}).items()),
        "loading_ns": None if cost is None else cost.loading,
        "unloading_ns": None if cost is None else cost.unloading,
        "loading_over_hertz": None if cost is None else cost.loading_ratio,
        "unloading_over_hertz": None if cost is None else cost.unloading_ratio,
    }
    for subset, table in tables.items():
        for quantity in SCORED:
            found = table[entrant.name, quantity]
            row[f"{subset}_{quantity}_points"] = found.points
            for percentile, value in zip(PERCENTILES, found.percentiles or (None,) * len(PERCENTILES), strict=True):
                row[f"{subset}_{quantity}_{percentile}"] = value
    return row


def read_scores(folder: Path) -> tuple[list[Score], dict[str, float]]:
    """Scores, and nanoseconds per contact while loading by entrant, from what `tournament` wrote; raises `InputError` for anything else."""
    scores = [Score(**row) for row in _read(folder / "tournament.parquet", set(Score._fields))]
    rows = _read(folder / "standings.parquet", {"entrant", "loading_ns"})
    return scores, {row["entrant"]: row["loading_ns"] for row in rows if row["loading_ns"] is not None}


def _read(path: Path, columns: set[str]) -> Iterator[dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    remedy = "give the folder that fe2dem tournament wrote to, or write it again"
    try:
        table = pq.ParquetFile(path).read()
    except (OSError, pa.ArrowException) as error:
        raise InputError(Problem(str(path), str(error).splitlines()[0], "cannot be read", remedy)) from error
    if not columns <= set(table.column_names):
        raise InputError(Problem(str(path), table.column_names[:6], f"must have the columns {', '.join(sorted(columns))}", remedy))
    yield from table.to_pylist()


def show(rows: Sequence[Mapping[str, Any]]) -> None:
    """Median, then worst error of every quantity, in percent, on the terminal."""
    from rich import box
    from rich.table import Table

    from cases import console

    for word, percentile in (("median", 50), ("worst", 100)):
        sheet = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
        sheet.add_column(f"{word} error in %", no_wrap=True, max_width=24)
        for heading in ("force", "radius", "stiff.", "shape", "resid.", "energy", "e", *(("ns",) if percentile == 50 else ())):
            sheet.add_column(heading, justify="right", no_wrap=True, min_width=max(4, len(heading)))
        for row in rows:
            values = [row[f"all_{name}_{percentile}"] for name in SCORED]
            cost = ("–" if row["loading_ns"] is None else f"{row['loading_ns']:.0f}",) if percentile == 50 else ()
            sheet.add_row(row["entrant"], *("–" if value is None else in_percent(value) for value in values), *cost)
        console.out.print(sheet)
    console.out.print(
        "force and contact radius where unloadings start; unloading stiffness and shape, residual overlap, recovered energy, e: "
        "restitution;\nns: one contact in one step of a scene while loading. All percentiles, costs and constants: standings.csv"
    )


def in_percent(value: float) -> str:
    """Two digits and no sign of percent; beyond a thousand the power of ten.

    >>> in_percent(0.0123), in_percent(0.4), in_percent(0.00004), in_percent(123.0), in_percent(0.0)
    ('1.2', '40', '<.01', '1e4', '0')
    """
    percent = 100.0 * value
    if percent >= 1000.0:
        return f"1e{round(math.log10(percent))}"
    if percent < 0.01:
        return "<.01" if percent > 1e-8 else "0"
    return f"{percent:.0f}" if percent >= 9.95 else f"{percent:.1f}" if percent >= 0.995 else f"{percent:.2g}"
