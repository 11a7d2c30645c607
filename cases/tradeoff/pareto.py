"""The picture of a trade: error over cost, and the choices that no other beats in both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from cases.report import plots

MARKERS = "osD^vPX"
#: range of a scale beyond which only powers of ten are written
MANY = 2e4
LEVEL: Any = {"color": "#8a8a8a", "lw": 1.0, "ls": "--", "zorder": 0}


class Point(NamedTuple):
    """One choice."""

    name: str  # written beside it if it lies on the frontier
    group: str  # points of a group share colour and marker
    cost: float
    error: float


class Panel(NamedTuple):
    """All choices, measured in one quantity."""

    title: str
    points: Sequence[Point]
    level: float | None = None  # an error to compare with, drawn as a dashed line


def frontier(points: Sequence[Point]) -> list[Point]:
    """The points that no other beats in both cost and error, from the cheapest on.

    >>> [p.name for p in frontier([Point("a", "", 1.0, 0.1), Point("b", "", 2.0, 0.2), Point("c", "", 3.0, 0.01)])]
    ['a', 'c']
    """
    best: list[Point] = []
    for point in sorted(points, key=lambda p: (p.cost, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return best


@plots.styled
def draw(
    panels: Sequence[Panel],
    cost_label: str,
    error_label: str = "error",
    columns: int = 3,
    level: str | None = None,
    same_errors: bool = False,
) -> Figure:
    """Error over cost, both axes logarithmic; grey steps join the frontier, whose points are named.

    `level` says what the panels' levels are; with `same_errors` all panels have one scale of errors.
    """
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(3.4 * columns, 3.0 * rows + 0.5), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=same_errors)
    groups = list(dict.fromkeys(point.group for panel in panels for point in panel.points))
    for number, axis in enumerate(axes.flat):
        if number < len(panels):
            _panel(axis, panels[number], groups)
            if number % columns == 0:
                axis.set_ylabel(error_label)
            if number + columns >= len(panels):
                axis.set_xlabel(cost_label)
                axis.tick_params(labelbottom=True)
        else:
            axis.set_visible(False)
    handles, labels = axes.flat[0].get_legend_handles_labels()
    if level is not None:
        handles, labels = [*handles, Line2D([], [], **LEVEL)], [*labels, level]
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 4))
    return figure


def _panel(axis: Axes, panel: Panel, groups: Sequence[str]) -> None:
    for number, group in enumerate(groups):
        own = [(point.cost, point.error) for point in panel.points if point.group == group]
        x, y = np.array(own).reshape(-1, 2).T
        axis.plot(x, y, MARKERS[number % len(MARKERS)], color=plots.COLOURS[number % len(plots.COLOURS)], ms=4.5, label=group, zorder=3)
    if panel.level is not None:
        axis.axhline(panel.level, **LEVEL)
    best = frontier(panel.points)
    axis.step([p.cost for p in best], [p.error for p in best], where="post", color="#c2c2c2", lw=1.4, zorder=1)
    for point in best:
        axis.annotate(point.name, (point.cost, point.error), xytext=(4, 3), textcoords="offset points", fontsize=6.5, zorder=4)
    axis.set(xscale="log", yscale="log", title=panel.title)
    axis.margins(0.14)
    axis.yaxis.set_major_formatter(FuncFormatter(_percent))
    axis.yaxis.set_minor_formatter(NullFormatter())
    for scale in (axis.xaxis, axis.yaxis):
        low, high = scale.get_view_interval()
        scale.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < MANY * low else (1.0,), numticks=12))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(True, which="major", color="#ececec", lw=0.6)


def _percent(value: float, _: int) -> str:
    return f"{100 * value:g} %"
