"""`fe2dem tradeoff law`: error of the laws against nanoseconds per contact, from the scores of a tournament."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibration.tournament import SCORED, Score, cheapest_law
from cases.report import plots
from cases.tradeoff.pareto import Point, frontier
from contactlaws.errors import InputError, Problem

#: shown beside each other
PANELS = ("force", "unloading_stiffness", "recovered_energy", "restitution")
#: errors beyond these are drawn at them, those above as triangles
LIMITS = (1e-4, 10.0)


def tradeoff_law(folder: Path, quantity: str | None, tolerance: float | None, max_overlap: float | None, out: Path | None) -> None:
    """Print who is on the front of error and cost in each quantity and draw it; with a tolerance, say which law to take.

    folder: what `fe2dem tournament` wrote. Raises `InputError` for a folder without a tournament, an unknown quantity, a tolerance that no
    law meets.
    """
    from cases import console
    from cases.tournament.run import in_percent, read_scores

    problems = []
    if quantity is not None and quantity not in SCORED:
        problems.append(Problem("--quantity", quantity, f"must be one of {', '.join(SCORED)}", "choose one"))
    if tolerance is not None and not tolerance > 0.0:
        problems.append(Problem("--tolerance", tolerance, "must be above 0", "0.01 is 1 %"))
    if max_overlap is not None and not max_overlap > 0.0:
        problems.append(Problem("--max-overlap", max_overlap, "must be above 0", "give it over the radius"))
    if problems:
        raise InputError(problems)
    scores, nanoseconds = read_scores(folder)
    deepest = math.inf if max_overlap is None else max_overlap
    scores = [score for score in scores if score.overlap_over_radius <= deepest * (1.0 + 1e-9)]
    for name in SCORED if quantity is None else (quantity,):
        sheet = console.sheet(f"front for {name.replace('_', ' ')}", "ns per contact", "median (%)", "90th percentile (%)", "worst (%)")
        for point in frontier(points(scores, nanoseconds, name, 90.0)):
            values = [in_percent(error_of(scores, point.name, name, percentile)) for percentile in (50.0, 90.0, 100.0)]
            sheet.add_row(point.name, f"{point.cost:.3g}", *values)
        console.out.print(sheet)
    if tolerance is not None:
        name = quantity or "force"
        found = cheapest_law(tolerance, name, scores, nanoseconds, deepest)
        console.out.print(
            f"within {tolerance:g} in {name.replace('_', ' ')} at worst: {found.entrant}, {found.nanoseconds:.3g} ns per contact, "
            f"worst error {found.error:.3g}"
        )
    if out is not None:
        plots.png(tradeoff_figure(scores, nanoseconds), out)
        console.out.print(f"picture: {out}")


def error_of(scores: Sequence[Score], entrant: str, quantity: str, percentile: float) -> float:
    """Percentile of the absolute error of one entrant; infinite without a score."""
    values = [abs(value) for score in scores if score.entrant == entrant and (value := getattr(score, quantity)) is not None]
    return float(np.percentile(values, percentile)) if values else math.inf


def points(scores: Sequence[Score], nanoseconds: Mapping[str, float], quantity: str, percentile: float) -> list[Point]:
    """Every entrant with its error and its cost in ns, where it has both."""
    found = [Point(name, "", cost, error_of(scores, name, quantity, percentile)) for name, cost in nanoseconds.items()]
    return [point for point in found if math.isfinite(point.error)]


@plots.styled
def tradeoff_figure(scores: Sequence[Score], nanoseconds: Mapping[str, float]) -> Figure:
    """90th percentile of the error against nanoseconds per contact, every law by name; the front is orange."""
    figure = Figure(figsize=(9.2, 8.4), layout="constrained")
    axes: Any = figure.subplots(2, 2, sharex=True)
    for axis, quantity in zip(axes.flat, PANELS, strict=True):
        _panel(axis, points(scores, nanoseconds, quantity, 90.0), quantity)
    for axis in axes[1]:
        axis.set_xlabel("nanoseconds per contact while loading")
    for axis in axes[:, 0]:
        axis.set_ylabel("90th percentile of the error")
    return figure


def _panel(axis: Axes, choices: Sequence[Point], quantity: str) -> None:
    best = frontier(choices)
    shown = [(point, float(np.clip(point.error, *LIMITS))) for point in choices]
    axis.step([p.cost for p in best], [max(p.error, LIMITS[0]) for p in best], where="post", color="#f0b48a", lw=1.0, zorder=1)
    axis.set(xscale="log", yscale="log", ylim=(0.7 * LIMITS[0], 2.0 * LIMITS[1]))
    costs = [point.cost for point in choices]
    axis.set_xlim(0.85 * min(costs), 2.6 * max(costs))
    taken: list[tuple[float, float, float]] = []
    for point, error in sorted(shown, key=lambda item: item[1]):
        colour = plots.COLOURS[1] if point in best else plots.GREY
        axis.plot(point.cost, error, "o" if point.error <= LIMITS[1] else "^", color=colour, ms=4, zorder=3)
        x, y = axis.transLimits.transform(np.log10((point.cost, error)))
        y = _free(taken, float(x), float(y), 0.0125 * len(point.name))
        ink = colour if point in best else "#555555"
        behind: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8}
        axis.text(x + 0.018, y, point.name, color=ink, bbox=behind, transform=axis.transAxes, va="center", fontsize=6.5, zorder=2)
    axis.set_title(quantity.replace("_", " "))
    axis.set_yticks([1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0], ["0.01 %", "0.1 %", "1 %", "10 %", "100 %", "1000 %"])
    ticks = [tick for tick in (5, 10, 20, 50, 100, 200, 500, 1000, 2000) if 0.85 * min(costs) <= tick <= 2.6 * max(costs)]
    axis.set_xticks(ticks, [f"{tick}" for tick in ticks])
    axis.minorticks_off()
    axis.grid(True, which="major", color="#ececec", lw=0.6)


def _free(taken: list[tuple[float, float, float]], x: float, y: float, width: float) -> float:
    """The height nearest to `y` (all in parts of the axes) at which a label of this width meets no other; it is then taken."""
    for step in range(60):
        for side in (1.0, -1.0):
            height = y + side * step * 0.006
            if all(abs(height - other) >= 0.026 or x >= left + wide or left >= x + width for left, other, wide in taken):
                taken.append((x, height, width))
                return height
    return y
