"""The picture of an identification: the measured curve with its fit, what is left, and the profile of each unknown."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from calibration import Identified
from calibration.identify_search import LIMIT
from cases.report.plots import COLOURS, GREY, styled

LABELS = {
    "youngs_modulus": ("Young's modulus", "Pa"),
    "yield_stress": ("yield stress", "Pa"),
    "poissons_ratio": ("Poisson's ratio", ""),
    "zero": ("zero of the overlap", "m"),
    "compliance": ("machine compliance", "m/N"),
}
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p"))
#: deviances beyond are not shown
HIGHEST = 12.0


def scaled(size: float, unit: str) -> tuple[float, str]:
    """A factor and a unit with a prefix in which a number of about `size` is easily read.

    >>> scaled(2.1e11, "Pa"), scaled(3e-6, "m"), scaled(0.3, "")
    ((1000000000.0, 'GPa'), (1e-06, 'µm'), (1.0, ''))
    """
    if not unit or size <= 0.0:
        return 1.0, unit
    factor, prefix = next((pair for pair in PREFIXES if size >= pair[0]), PREFIXES[-1])
    return factor, prefix + unit


@styled
def picture(found: Identified) -> Figure:
    """The measured curve and its fit above what is left between them; beside them one profile for each unknown."""
    columns = (len(found.names) + 1) // 2
    figure = Figure(figsize=(5.0 + 2.7 * columns, 4.6), layout="constrained")
    halves: Any = figure.subfigures(1, 2, width_ratios=(5.0, 2.7 * columns))
    left, right = halves
    top, bottom = left.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [2.6, 1]})
    _draw_curve(found, top, bottom)
    axes = np.atleast_1d(right.subplots(2, columns)).ravel()
    for name, axis in zip(found.names, axes, strict=False):
        _draw_profile(found, name, axis)
    for axis in axes[len(found.names) :]:
        axis.set_visible(False)
    return figure


def _draw_curve(found: Identified, top: Axes, bottom: Axes) -> None:
    measured = found.measured
    length, length_unit = scaled(float(abs(measured.overlap).max()), "m")
    force, force_unit = scaled(float(measured.force.max()), "N")
    for branch in (0, *measured.unloadings):
        rows = measured.rows(branch)
        x, first = measured.overlap[rows] / length, branch == 0
        top.plot(x, measured.force[rows] / force, ".", color=GREY, ms=3.5, label="measured" if first else None)
        top.plot(x, found.fitted_force[rows] / force, color=COLOURS[1], lw=1.1, label="best fit" if first else None)
        bottom.plot(x, (measured.force[rows] - found.fitted_force[rows]) / found.noise, ".", color=GREY if first else COLOURS[0], ms=3.0)
    bottom.axhspan(-2.0, 2.0, color=GREY, alpha=0.15, lw=0)
    bottom.axhline(0.0, color="black", lw=0.7)
    top.set(ylabel=f"force ({force_unit})", ylim=(min(0.0, float(measured.force.min()) / force), None))
    top.legend(loc="upper left")
    bottom.set(xlabel=f"measured overlap ({length_unit})", ylabel="difference\nover noise")


def _draw_profile(found: Identified, name: str, axis: Axes) -> None:
    """Deviance against one unknown; the shaded part is its interval, open where the curve sets no limit."""
    profile, (low, high), (label, unit) = found.profiles[name], found.intervals[name], LABELS[name]
    shown = profile.deviance < HIGHEST
    values, deviance = profile.values[shown], profile.deviance[shown]
    factor, prefixed = scaled(float(abs(values).max(initial=0.0)), unit)
    first, last = values[0] if low is None else low, values[-1] if high is None else high
    axis.axvspan(first / factor, last / factor, color=COLOURS[0], alpha=0.12, lw=0)
    axis.plot(values / factor, deviance, "o-", color=COLOURS[0], ms=2.5, lw=1.1)
    axis.axhline(LIMIT, color=GREY, lw=0.7, ls=":")
    if name in ("youngs_modulus", "yield_stress") and values.size and values[-1] > 5.0 * values[0]:
        axis.set_xscale("log")
        axis.xaxis.set_minor_formatter(NullFormatter())
    axis.set(xlabel=f"{label} ({prefixed})" if prefixed else label, ylabel="deviance", ylim=(0.0, HIGHEST))
    axis.set_title(_interval(low, high, factor), fontsize=8.0)


def _interval(low: float | None, high: float | None, factor: float) -> str:
    ends: list[Any] = [None if end is None else f"{end / factor:.4g}" for end in (low, high)]
    if ends[0] and ends[1]:
        return f"95 %: {ends[0]} to {ends[1]}"
    return f"95 %: above {ends[0]}" if ends[0] else f"95 %: below {ends[1]}" if ends[1] else "not determined"
