"""Figs. 8, 9, 20 and 22: the exponent of the unloading."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Study
from cases.edmans_sinka_2020.drawing import (
    ALPHA,
    D_MAX,
    GREY,
    Picture,
    beside,
    colour_of_modulus,
    new_figure,
    panel_titles,
    styled,
)
from cases.edmans_sinka_2020.figures_stiffness import over_poisson

NU = 0.3


def pictures(study: Study) -> list[Picture]:
    """In the paper's order."""
    return [
        Picture(
            "8",
            "Exponent over overlap",
            over_depth(study),
            "Exponent of the unloading over the overlap before it, ν = 0.3: (a) the whole range, (b) its beginning. Grey: Hertz's 1.5 "
            "and the 1 of a bar. Finite elements, ours.",
        ),
        Picture(
            "9",
            "Exponent against Etsion's relation",
            against_etsion(study),
            "Exponent from the finite elements (dots and lines, ours) against the relation of Etsion, Kligerman & Kadin 2005, the "
            "paper's Eq. 6 (black), over the overlap relative to that at first yield (corrected Eq. 5), ν = 0.3. Grey: the range that "
            "Eq. 6 was made for, up to 170.",
        ),
        Picture(
            "20",
            "Exponent, all Poisson's ratios",
            all_poisson(study, study.poisson),
            "As Fig. 8, for each Poisson's ratio. Finite elements, ours.",
        ),
        Picture(
            "22",
            "Poisson's ratio and exponent",
            over_poisson(study, "exponent", ALPHA, log=False),
            "Exponent over the stiffness ratio for each Poisson's ratio, unloading from (a) δ/R = 0.01 and (b) 0.5. Finite elements, "
            "ours. The paper's axes are not stated in its caption; these show what the text reads from them.",
        ),
    ]


def _lines(axis: Axes, study: Study, nu: float) -> None:
    for modulus in study.moduli(nu):
        points = study.of(modulus, nu)
        axis.plot(points.depth, points.exponent, "o-", ms=2.5, lw=1.0, color=colour_of_modulus(modulus), label=f"{modulus:g}")
    for value in (1.0, 1.5):
        axis.axhline(value, color=GREY, lw=0.7, zorder=0)


@styled
def over_depth(study: Study) -> Figure:
    """Fig. 8."""
    figure, axes = new_figure(9.2, 4.0, 1, 2)
    for axis, largest in zip(axes, (0.5, 0.1), strict=True):
        _lines(axis, study, NU)
        axis.set(xlabel=D_MAX, xlim=(0, 1.02 * largest))
    axes[0].set_ylabel(ALPHA)
    axes[1].set_ylim(1.25, 1.65)
    panel_titles(axes, ["whole range", "beginning"])
    beside(figure, axes[0], r"$\bar E$")
    return figure


@styled
def all_poisson(study: Study, poisson: Sequence[float]) -> Figure:
    """Fig. 20."""
    rows = (len(poisson) + 1) // 2
    figure, axes = new_figure(9.2, 3.3 * rows, rows, 2, sharex=True, sharey=True, squeeze=False)
    for axis, nu in zip(axes.flat, poisson, strict=False):
        _lines(axis, study, nu)
        axis.set_xlim(0, 0.51)
    for axis in axes.flat[len(poisson) :]:
        axis.set_visible(False)
    for axis in axes[:, 0]:
        axis.set_ylabel(ALPHA)
    for axis in axes[-1]:
        axis.set_xlabel(D_MAX)
    panel_titles(axes.flat[: len(poisson)], [rf"$\nu = {nu:g}$" for nu in poisson])
    beside(figure, axes.flat[0], r"$\bar E$")
    return figure


@styled
def against_etsion(study: Study) -> Figure:
    """Fig. 9."""
    figure, axis = new_figure(6.6, 4.0)
    axis.axvspan(1.0, 170.0, color="#ececec", lw=0)
    for modulus in study.moduli(NU):
        points = study.of(modulus, NU)
        relative = points.depth / paper.yield_depth(modulus, NU)
        axis.plot(relative, points.exponent, "o-", ms=2.5, lw=1.0, color=colour_of_modulus(modulus), label=f"{modulus:g}")
    line = np.geomspace(1.0, 2e5, 50)
    axis.plot(line, paper.etsion_exponent(line), "k", lw=1.6, label="Eq. 6")
    axis.set(xscale="log", xlabel=r"overlap over that at first yield $\bar\delta_{max}/\bar\delta_c$", ylabel=ALPHA)
    beside(figure, axis, r"$\bar E$")
    return figure
