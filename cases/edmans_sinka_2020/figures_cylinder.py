"""Figs. 15 to 17: the model of concentric cylinders, printed and corrected, against the finite elements."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.edmans_sinka_2020 import cylinder, paper
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
PANELS = ("printed (Eq. 23)", "algebra corrected", "and no tension")
WHICH = (
    "(a) as printed, Eq. 23; (b) with the algebra of Eq. 21 put right, bars that have come free still pulling; (c) with no bar pulling, "
    "where ρ is 1/δ̄_max up to first yield and exactly E/σ_y from there on."
)


def pictures(study: Study) -> list[Picture]:
    """In the paper's order."""
    return [
        Picture(
            "15",
            "Contact radius",
            contact_radius(study),
            "Contact radius over overlap in loading, ν = 0.3: finite elements (lines, ours), the paper's Eq. 13 (black), and Hertz "
            "(grey). Below: finite elements over Eq. 13.",
        ),
        Picture(
            "16",
            "Cylinder model over stiffness ratio",
            over_modulus(),
            f"Unloading stiffness of the cylinder model over the stiffness ratio: {WHICH}",
        ),
        Picture("17", "Cylinder model over overlap", over_depth(), f"Unloading stiffness of the cylinder model over the overlap: {WHICH}"),
    ]


@styled
def contact_radius(study: Study) -> Figure:
    """Fig. 15."""
    figure, (top, bottom) = new_figure(6.6, 5.2, 2, 1, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    for modulus in study.moduli(NU):
        curve = study.curves[modulus, NU]
        if curve.contact_radius is None:
            continue
        rows = slice(curve.rows(0).start + 1, curve.rows(0).stop)
        x, a = curve.overlap[rows] / curve.radius, curve.contact_radius[rows] / curve.radius
        top.plot(x, a, color=colour_of_modulus(modulus), lw=1.1, label=f"{modulus:g}")
        bottom.plot(x, a / cylinder.contact_radius(x), color=colour_of_modulus(modulus), lw=1.1)
    line = np.linspace(0.0, 0.5, 200)
    top.plot(line, cylinder.contact_radius(line), "k--", lw=1.4, label="Eq. 13")
    top.plot(line, np.sqrt(line), color="#8a8a8a", ls=":", lw=1.4, label="Hertz")
    bottom.axhline(1.0, color="k", ls="--", lw=0.9)
    top.set(ylabel=r"contact radius $\bar a = a/R_0$", ylim=(0, None))
    bottom.set(xlabel=r"overlap $\bar\delta$", ylabel="over Eq. 13", xlim=(0, 0.505))
    beside(figure, top, r"$\bar E$")
    return figure


def _three() -> tuple[Figure, list[Axes]]:
    figure, axes = new_figure(9.6, 3.6, 1, 3, sharex=True, sharey=True)
    panel_titles(axes, PANELS)
    axes[0].set_ylabel(RHO)
    return figure, list(axes)


MODELS = (cylinder.printed_stiffness, cylinder.stiffness_with_tension, cylinder.stiffness)


@styled
def over_modulus() -> Figure:
    """Fig. 16."""
    figure, axes = _three()
    for axis, model in zip(axes, MODELS, strict=True):
        for depth in paper.DEPTHS:
            values = [float(model(modulus, depth)) for modulus in paper.MODULI]
            axis.plot(paper.MODULI, values, "o-", ms=2.5, lw=1.0, color=colour_of_depth(depth), label=f"{depth:g}")
        axis.set(xscale="log", yscale="log", xlabel=E_BAR)
    beside(figure, axes[0], r"$\bar\delta_{max}$")
    return figure


@styled
def over_depth() -> Figure:
    """Fig. 17."""
    figure, axes = _three()
    line = np.geomspace(0.01, 0.5, 120)
    for axis, model in zip(axes, MODELS, strict=True):
        for modulus in paper.MODULI:
            axis.plot(line, model(modulus, line), lw=1.2, color=colour_of_modulus(modulus), label=f"{modulus:g}")
        axis.set(yscale="log", xlabel=D_MAX.replace("overlap before unloading ", ""))
    beside(figure, axes[0], r"$\bar E$")
    return figure
