"""The page of the tournament: who is how good at what, on which materials, at what cost, and how each was fitted."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from calibration.residuals import follow
from calibration.tournament import SCORED, Score, Tournament
from cases.report import parts, plots
from cases.tournament.cost import Cost
from cases.tournament.run import in_percent, modulus_over_yield_stress, typical_curve, typical_laws
from cases.tradeoff.law import tradeoff_figure
from cases.tradeoff.page import write_page as write_sections
from contactlaws.curve import Curve

#: heading of each quantity in tables and pictures
TITLES = {
    "force": "force",
    "contact_radius": "contact radius",
    "unloading_stiffness": "unloading stiffness",
    "unloading_shape": "unloading shape",
    "residual_overlap": "residual overlap",
    "recovered_energy": "recovered energy",
    "restitution": "restitution",
}
COLOURS, RANGE = "YlOrRd", LogNorm(1e-3, 1.0)
WHAT = (
    "Every law was fitted to every curve: to the loading from the shallowest unloading on, and to every second unloading. Scores are "
    "absolute differences between law and curve at each unloading, in percent: force, contact radius at its start, unloading stiffness "
    "1/(δ_max − δ_0) and recovered energy relative; unloading shape the largest difference in F/F_max at equal (δ − δ_0)/(δ_max − δ_0); "
    "residual overlap over the radius; restitution, √(recovered energy/work of loading), the difference. 1e4 is ten thousand per cent."
)


def write_page(
    out: Path,
    lead: str,
    failures: Sequence[Mapping[str, str]],
    played: Tournament,
    curves: Sequence[Curve],
    measured: Mapping[str, Cost],
    table: Sequence[Mapping[str, Any]],
) -> Path:
    """Write `out`/report.html and the pictures as PNG files; failures: {"task", "reason"} of files that could not be used."""
    drawn = {
        "scores": heat(table),
        "materials": materials(played),
        "curves": small_multiples(typical_laws(played, curves), typical_curve(curves)),
        "tradeoff": tradeoff_figure(played.scores, {name: cost.loading for name, cost in measured.items()}),
    }
    for name, figure in drawn.items():
        plots.png(figure, out / f"{name}.png")
    failures = [*failures, *({"task": fit.entrant, "reason": f"curve {fit.curve}: {fit.reason}"} for fit in played.fits if fit.reason)]
    sections = list(_sections(played, table, drawn, typical_curve(curves)))
    return write_sections(out / "report.html", "Tournament of contact laws", lead, sections, failures)


def _sections(
    played: Tournament, table: Sequence[Mapping[str, Any]], drawn: Mapping[str, Figure], typical: Curve
) -> Iterator[dict[str, Any]]:
    caption = "Median and, smaller, worst error in percent over all unloadings of all curves; colour: 90th percentile."
    yield {"title": "Who is how good at what", "blocks": [parts.text(WHAT), parts.figures((drawn["scores"], caption))]}
    caption = "Median error in percent over the unloadings of all curves with this E/Y."
    yield {"title": "On which materials", "blocks": [parts.figures((drawn["materials"], caption))]}
    stiffness = modulus_over_yield_stress(typical)
    caption = f"Force over overlap for E/Y = {stiffness:g}: finite elements grey, the law in colour. Axes are the same in all panels."
    yield {"title": "What the laws look like", "blocks": [parts.figures((drawn["curves"], caption))]}
    caption = (
        "90th percentile of the error over all unloadings against the cost of one contact in one step. Orange: no other law beats both."
    )
    words = "The cost is that of the pair kernel of the DEM, with these implementations, while contacts load; all in one run."
    yield {"title": "Error against cost", "blocks": [parts.figures((drawn["tradeoff"], caption)), parts.text(words), _costs(table)]}
    yield {"title": "All unloadings", "blocks": [_percentiles(table, "all")]}
    yield {"title": "Beyond first yield only", "blocks": [_percentiles(table, "plastic")]}
    words = "Each law only where its authors claim that it holds; where they state no range, everywhere."
    yield {"title": "Inside the range that the authors claim", "blocks": [parts.text(words), _percentiles(table, "inside")]}
    words = "Unloadings that no law has seen in its fit: every second one, the shallowest among them."
    yield {"title": "Unseen unloadings", "blocks": [parts.text(words), _percentiles(table, "unseen")]}
    yield {"title": "How each was fitted, and where it is from", "blocks": list(_entrants(table))}


def _percentiles(table: Sequence[Mapping[str, Any]], subset: str) -> dict[str, Any]:
    """Points, and median, 90th percentile and worst of each quantity."""
    rows = []
    for row in table:
        cells = []
        for quantity in SCORED:
            values = [row[f"{subset}_{quantity}_{percentile}"] for percentile in (50, 90, 100)]
            cells.append("–" if values[0] is None else " / ".join(in_percent(value) for value in values))
        rows.append((row["entrant"], str(row[f"{subset}_force_points"]), *cells))
    return parts.table(("median / 90th percentile / worst, %", "points", *TITLES.values()), rows)


def _costs(table: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    columns = ("law", "loading (ns)", "over Hertz", "unloading (ns)", "over Hertz", "constants for all materials", "for each material")
    rows = []
    for row in table:
        times = [
            "–" if row[name] is None else f"{row[name]:.3g}"
            for name in ("loading_ns", "loading_over_hertz", "unloading_ns", "unloading_over_hertz")
        ]
        counts = ["–" if row[name] is None else str(row[name]) for name in ("universal_constants", "constants_per_material")]
        rows.append((row["entrant"], *times, *counts))
    return parts.table(columns, rows)


def _entrants(table: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    for row in table:
        fitted = f"{row['curves_fitted']} curves fitted" + (f", {row['curves_failed']} failed" if row["curves_failed"] else "")
        words = f"{row['entrant']}: {row['how_fitted']}; {fitted}. Claimed range: {row['claimed_range']}. {row['source'] or ''}"
        yield parts.text(words, note=True)
    for row in table:
        if row["flaws"]:
            yield parts.text(f"{row['entrant']}, as published, fails checks that a contact law must pass. {row['flaws']}.", note=True)


@plots.styled
def heat(table: Sequence[Mapping[str, Any]]) -> Figure:
    """Entrants by quantities: median and worst as text, 90th percentile as colour."""
    figure = Figure(figsize=(9.2, 0.32 * len(table) + 1.0), layout="constrained")
    axis = figure.subplots()
    values = np.array([[_number(row[f"all_{quantity}_90"]) for quantity in SCORED] for row in table])
    texts = [[_cell(row, quantity) for quantity in SCORED] for row in table]
    _tiles(
        figure,
        axis,
        values,
        texts,
        [row["entrant"] for row in table],
        [title.replace(" ", "\n") for title in TITLES.values()],
        "90th percentile of the error",
    )
    return figure


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _cell(row: Mapping[str, Any], quantity: str) -> tuple[str, str]:
    middle, worst = row[f"all_{quantity}_50"], row[f"all_{quantity}_100"]
    return ("–", "") if middle is None else (in_percent(middle), in_percent(worst))


def _tiles(
    figure: Figure,
    axis: Axes,
    values: Any,
    texts: Sequence[Sequence[tuple[str, str]]],
    rows: Sequence[str],
    columns: Sequence[str],
    label: str | None,
) -> None:
    """Coloured tiles with a number, and a smaller one behind it; grey where there is nothing."""
    shown = np.clip(values, RANGE.vmin, RANGE.vmax)
    axis.set_facecolor("#eeeeee")
    image = axis.pcolormesh(np.ma.masked_invalid(shown), cmap=COLOURS, norm=RANGE, edgecolors="white", linewidth=1.2)
    for i, line in enumerate(texts):
        for j, (large, small) in enumerate(line):
            dark = np.isfinite(values[i][j]) and values[i][j] > 0.2
            ink = "white" if dark else "black"
            if small:
                axis.text(j + 0.44, i + 0.5, large, ha="right", va="center", color=ink, fontsize=8.5)
                axis.text(j + 0.54, i + 0.5, small, ha="left", va="center", color=ink, fontsize=6.5)
            else:
                axis.text(j + 0.5, i + 0.5, large, ha="center", va="center", color=ink if large != "–" else plots.GREY, fontsize=8)
    axis.set_yticks(np.arange(len(rows)) + 0.5, rows)
    axis.set_xticks(np.arange(len(columns)) + 0.5, columns)
    axis.tick_params(length=0, top=False, labeltop=True, bottom=False, labelbottom=False)
    axis.set_ylim(len(rows), 0)
    for spine in axis.spines.values():
        spine.set_visible(False)
    if label:
        bar = figure.colorbar(image, ax=axis, location="right", shrink=0.6, aspect=28, pad=0.01, extend="both", label=label)
        bar.set_ticks([1e-3, 1e-2, 1e-1, 1.0], labels=["0.1 %", "1 %", "10 %", "100 %"])
        bar.minorticks_off()


@plots.styled
def materials(played: Tournament) -> Figure:
    """Entrants by E/Y: median error of the force and of the unloading stiffness."""
    names = [entrant.name for entrant in played.entrants]
    steps = sorted({score.modulus_over_yield_stress for score in played.scores if score.modulus_over_yield_stress is not None})
    figure = Figure(figsize=(9.2, 0.3 * len(names) + 1.0), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for axis, quantity in zip(axes, ("force", "unloading_stiffness"), strict=True):
        values = np.array([[_median(played.scores, name, step, quantity) for step in steps] for name in names])
        texts = [[("–" if math.isnan(value) else in_percent(value), "") for value in line] for line in values]
        last = quantity == "unloading_stiffness"
        _tiles(figure, axis, values, texts, names, [f"{step:g}" for step in steps], "median error" if last else None)
        axis.set_title(f"{TITLES[quantity]}, E/Y =", pad=4)
    return figure


def _median(scores: Sequence[Score], name: str, step: float, quantity: str) -> float:
    values = [
        abs(value)
        for score in scores
        if score.entrant == name and score.modulus_over_yield_stress == step and (value := getattr(score, quantity)) is not None
    ]
    return float(np.median(values)) if values else math.nan


@plots.styled
def small_multiples(laws: Mapping[str, Any], curve: Curve) -> Figure:
    """The curve in grey and one law in each panel."""
    columns = 4
    lines = math.ceil(len(laws) / columns)
    figure = Figure(figsize=(9.2, 1.75 * lines + 0.3), layout="constrained")
    axes = np.atleast_1d(figure.subplots(lines, columns, sharex=True, sharey=True)).ravel()
    scale, symbol = plots.stress_scale(curve)
    area = math.pi * curve.radius**2 * scale
    shown = _some(curve)
    for axis, (name, law) in zip(axes, laws.items(), strict=False):
        for branch in (0, *shown):
            rows = curve.rows(branch)
            x = curve.overlap[rows] / curve.radius
            axis.plot(x, curve.force[rows] / area, color="#c2c2c2", lw=2.8, solid_capstyle="butt")
            axis.plot(x, _extended(law, curve, branch) / area, color=plots.COLOURS[1], lw=0.9)
        axis.set_title(name, fontsize=8)
    for axis in axes[len(laws) :]:
        axis.set_visible(False)
    for axis in axes[max(0, len(laws) - columns) : len(laws)]:
        axis.tick_params(labelbottom=True)
    top = float(curve.force.max()) / area
    axes[0].set(xlim=(0, None), ylim=(0, 1.15 * top))
    figure.supxlabel("overlap $\\delta/R$", fontsize=9)
    figure.supylabel(rf"force $F/(\pi R^2 {symbol})$", fontsize=9)
    return figure


def _some(curve: Curve) -> list[int]:
    """At most four unloadings, evenly over the depth."""
    order = sorted(curve.unloadings, key=lambda branch: float(curve.overlap[curve.rows(branch)][0]))
    depths = np.array([float(curve.overlap[curve.rows(branch)][0]) for branch in order])
    wanted = depths.max(initial=0.0) * np.array([0.1, 0.4, 0.7, 1.0])
    return sorted({order[int(np.argmin(abs(depths - depth)))] for depth in wanted}) if order else []


def _extended(law: Any, curve: Curve, branch: int) -> Any:
    return follow(law, curve, branch).force
