"""Figs. 5, 6, 18, 19 and 21: the unloading stiffness over modulus, overlap and Poisson's ratio."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Study
from cases.edmans_sinka_2020.drawing import (
    D_MAX,
    E_BAR,
    RHO,
    Picture,
    beside,
    colour_of_depth,
    colour_of_modulus,
    new_figure,
    panel_titles,
    styled,
)

NU = 0.3
SHALLOW, DEEP = 0.01, 0.5


def pictures(study: Study) -> list[Picture]:
    """In the paper's order."""
    return [
        Picture(
            "5",
            "Unloading stiffness over stiffness ratio",
            over_modulus(study, [NU]),
            "Unloading stiffness over the stiffness ratio at constant overlap, ν = 0.3. Dotted: what a body that recovers all its "
            "overlap would have, ρ = 1/δ̄_max. Finite elements, ours.",
        ),
        Picture(
            "6",
            "Unloading stiffness over overlap",
            over_depth(study, [NU], equation_3=False),
            "The same stiffness over the overlap before unloading, at constant stiffness ratio, ν = 0.3. Finite elements, ours.",
        ),
        Picture(
            "18",
            "Unloading stiffness over stiffness ratio, all Poisson's ratios",
            over_modulus(study, study.poisson),
            "As Fig. 5, for each Poisson's ratio. Dotted: ρ = 1/δ̄_max. Finite elements, ours.",
        ),
        Picture(
            "19",
            "Unloading stiffness over overlap, all Poisson's ratios",
            over_depth(study, study.poisson, equation_3=True),
            "As Fig. 6, for each Poisson's ratio. Lines: finite elements, ours. Circles: the paper's Eq. 3 with its constants (Table 1) "
            "and the corrected Eq. 5.",
        ),
        Picture(
            "21",
            "Poisson's ratio and unloading stiffness",
            over_poisson(study, "stiffness", RHO, log=True),
            "Unloading stiffness over the stiffness ratio for each Poisson's ratio, unloading from (a) δ/R = 0.01 and (b) 0.5. Finite "
            "elements, ours. The paper's axes are not stated in its caption; these show what the text reads from them.",
        ),
    ]


def _panels(count: int, width: float = 6.6, height: float = 4.2) -> tuple[Figure, list[Axes]]:
    if count == 1:
        figure, axis = new_figure(width, height)
        return figure, [axis]
    rows = (count + 1) // 2
    figure, axes = new_figure(9.2, 3.4 * rows, rows, 2, sharex=True, sharey=True, squeeze=False)
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    return figure, list(axes.flat[:count])


@styled
def over_modulus(study: Study, poisson: Sequence[float]) -> Figure:
    """Figs. 5 and 18."""
    figure, axes = _panels(len(poisson))
    for axis, nu in zip(axes, poisson, strict=True):
        points = study.points.where(study.points.poisson == nu)
        for depth in np.unique(points.depth):
            here = points.where(points.depth == depth)
            colour = colour_of_depth(float(depth))
            axis.plot(here.modulus, here.stiffness, "o-", ms=2.5, lw=1.0, color=colour, label=f"{depth:g}")
            axis.plot([1.0, 1000.0], [1.0 / depth] * 2, ":", lw=0.7, color=colour)
        axis.set(xscale="log", yscale="log")
    _label(axes, E_BAR, RHO, poisson)
    beside(figure, axes[0], r"$\bar\delta_{max}$")
    return figure


@styled
def over_depth(study: Study, poisson: Sequence[float], equation_3: bool) -> Figure:
    """Figs. 6 and 19."""
    figure, axes = _panels(len(poisson))
    for axis, nu in zip(axes, poisson, strict=True):
        for modulus in study.moduli(nu):
            points, colour = study.of(modulus, nu), colour_of_modulus(modulus)
            style = "-" if equation_3 else "o-"
            axis.plot(points.depth, points.stiffness, style, ms=2.5, lw=1.0, color=colour, label=f"{modulus:g}")
            if equation_3:
                axis.plot(points.depth, paper.stiffness(modulus, nu, points.depth), "o", ms=3.5, mfc="none", mew=0.8, color=colour)
        axis.set(yscale="log", xlim=(0, 0.51))
    _label(axes, D_MAX, RHO, poisson)
    beside(figure, axes[0], r"$\bar E$")
    return figure


@styled
def over_poisson(study: Study, quantity: str, name: str, log: bool) -> Figure:
    """Figs. 21 and 22: `quantity` of the points over the modulus, a line for each Poisson's ratio."""
    figure, axes = new_figure(9.2, 3.6, 1, 2)
    for axis, depth in zip(axes, (SHALLOW, DEEP), strict=True):
        for nu, style in zip(study.poisson, ("o-", "s--", "^-.", "d:", "v-"), strict=False):
            rows = (study.points.poisson == nu) & np.isclose(study.points.depth, depth, rtol=1e-6)
            here = study.points.where(rows)
            axis.plot(here.modulus, getattr(here, quantity), style, ms=3, lw=1.0, label=f"{nu:g}")
        axis.set(xscale="log", xlabel=E_BAR)
        if log:
            axis.set_yscale("log")
    axes[0].set_ylabel(name)
    panel_titles(axes, [rf"$\bar\delta_{{max}} = {depth:g}$" for depth in (SHALLOW, DEEP)])
    beside(figure, axes[0], r"$\nu$")
    return figure


def _label(axes: Sequence[Axes], x: str, y: str, poisson: Sequence[float]) -> None:
    if len(axes) == 1:
        axes[0].set(xlabel=x, ylabel=y)
        return
    panel_titles(axes, [rf"$\nu = {nu:g}$" for nu in poisson])
    for number, axis in enumerate(axes):
        if number % 2 == 0:
            axis.set_ylabel(y)
        if number >= len(axes) - 2:
            axis.set_xlabel(x)
            axis.tick_params(labelbottom=True)
