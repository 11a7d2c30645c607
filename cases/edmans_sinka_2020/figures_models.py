"""Figs. 10 to 13: stiffness ratio, Etsion's stiffness, contact area in unloading."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Points, Study
from cases.edmans_sinka_2020.drawing import D_MAX, GREY, Picture, beside, colour_of_modulus, new_figure, panel_titles, styled
from cases.edmans_sinka_2020.inside import Inside

NU = 0.3
RATIO = r"stiffness ratio $k_2/k_1 = \rho\,\bar\delta_{max}$"
#: E/Y of the curves in Fig. 12, from the range that section 4.5 states for it
FIG_12 = (200.0, 500.0, 1000.0)


def pictures(study: Study, inside: dict[float, Inside]) -> list[Picture]:
    """In the paper's order."""
    return [
        Picture(
            "10",
            "Stiffness ratio over relative overlap",
            over_relative_depth(study),
            "Unloading over loading stiffness, against the overlap relative to that at first yield (corrected Eq. 5), ν = 0.3. In "
            "Luding's model each line would be straight in (a); (b) is the same on logarithmic axes, where a measure of deformation by "
            "δ_max/δ_c alone would put all lines on one. Finite elements, ours.",
        ),
        Picture(
            "11",
            "Stiffness ratio over force",
            over_force(study),
            "Unloading over loading stiffness, against the force before unloading, ν = 0.3. In Walton & Braun's model each line would be "
            "straight. Dotted: the best straight line through each. Finite elements, ours.",
        ),
        Picture(
            "12",
            "Unloading stiffness against Etsion's relation",
            against_etsion(study),
            "Unloading stiffness by the relation of Etsion, Kligerman & Kadin 2005 (the paper's Eq. 9) over that of the finite elements "
            "(ours), ν = 0.3, corrected Eq. 5: (a) for the stiffness ratios that the paper's text names, (b) for all. Below 1, Eq. 9 "
            "recovers too much.",
        ),
        Picture(
            "13",
            "Force over contact area in unloading",
            over_area(study, inside),
            "Force over contact radius in unloading from δ/R = 0.5, ν = 0.3: finite elements (ours) and the relation of Mesarovic & "
            "Johnson (the paper's Eq. 10, black). Where the contact opens at its centre (triangles), dashed lines give the radius of a "
            "disc of the same area; what the paper draws there is not known.",
        ),
    ]


def relative_depth(points: Points) -> np.ndarray:
    """D_max/D_c, corrected Eq. 5."""
    return np.asarray(points.depth / paper.yield_depth(points.modulus, points.poisson))


def _ratio(points: Points) -> np.ndarray:
    return np.asarray(points.stiffness * points.depth)


@styled
def over_relative_depth(study: Study) -> Figure:
    """Fig. 10."""
    figure, axes = new_figure(9.2, 3.8, 1, 2)
    for modulus in study.moduli(NU):
        points = study.of(modulus, NU)
        for axis in axes:
            axis.plot(relative_depth(points), _ratio(points), "o-", ms=2.5, lw=1.0, color=colour_of_modulus(modulus), label=f"{modulus:g}")
    for axis in axes:
        axis.set_xlabel(r"$\bar\delta_{max}/\bar\delta_c$")
    axes[0].set_ylabel(RATIO)
    axes[0].ticklabel_format(axis="x", style="sci", scilimits=(0, 0), useMathText=True)
    axes[1].set(xscale="log", yscale="log")
    panel_titles(axes, ["linear axes", "logarithmic axes"])
    beside(figure, axes[0], r"$\bar E$")
    return figure


@styled
def over_force(study: Study) -> Figure:
    """Fig. 11."""
    figure, axes = new_figure(9.2, 3.8, 1, 2)
    for modulus in study.moduli(NU):
        points, colour = study.of(modulus, NU), colour_of_modulus(modulus)
        for axis in axes:
            axis.plot(points.force, _ratio(points), "o-", ms=2.5, lw=1.0, color=colour, label=f"{modulus:g}")
            axis.plot(points.force, np.polyval(np.polyfit(points.force, _ratio(points), 1), points.force), ":", lw=0.9, color=colour)
            axis.set_xlabel(r"force before unloading $\bar F_{max}$")
    axes[0].set_ylabel(RATIO)
    axes[0].set_ylim(bottom=0)
    axes[1].set_ylim(0, 60)
    panel_titles(axes, ["all", "low stiffness ratios, enlarged"])
    beside(figure, axes[0], r"$\bar E$")
    return figure


@styled
def against_etsion(study: Study) -> Figure:
    """Fig. 12."""
    figure, axes = new_figure(9.2, 3.6, 1, 2)
    for modulus in study.moduli(NU):
        points = study.of(modulus, NU)
        beyond = points.where(relative_depth(points) > 1.0)
        ratio = paper.etsion_stiffness(beyond.depth, relative_depth(beyond)) / beyond.stiffness
        for axis in axes if modulus in FIG_12 else axes[1:]:
            axis.plot(beyond.depth, ratio, "o-", ms=2.5, lw=1.0, color=colour_of_modulus(modulus), label=f"{modulus:g}")
    for axis in axes:
        axis.axhline(1.0, color=GREY, lw=0.7)
        axis.set(xlabel=D_MAX, ylim=(0, None))
    axes[0].set_ylabel(r"$\rho_{Eq.\,9}\,/\,\rho_{FE}$")
    panel_titles(axes, [r"$\bar E \geq 200$", r"all $\bar E$"])
    beside(figure, axes[1], r"$\bar E$")
    return figure


@styled
def over_area(study: Study, inside: dict[float, Inside]) -> Figure:
    """Fig. 13."""
    figure, axis = new_figure(6.6, 4.4)
    for modulus in study.moduli(NU):
        curve = study.curves[modulus, NU]
        if curve.contact_radius is None:
            continue
        rows = curve.rows(study.unloadings[modulus, NU][-1].branch)
        radius, force = curve.contact_radius[rows], curve.force[rows] / curve.force[rows][0]
        colour = colour_of_modulus(modulus)
        axis.plot(radius / radius[0], force, color=colour, lw=1.2, label=f"{modulus:g}")
        opened = inside[modulus].opening if modulus in inside else None
        if opened is not None:
            same_area, force_left = inside[modulus].equivalent_radius()[opened:], inside[modulus].force[opened:]
            axis.plot(same_area, force_left, "v--", markevery=[0], color=colour, lw=1.0, ms=5)
    line = np.linspace(0.0, 1.0, 200)
    axis.plot(line, paper.mesarovic_johnson_force(line), "k", lw=1.8, label="Eq. 10")
    axis.plot(line, line**3, color=GREY, lw=1.2, ls="-.", label="Hertz")
    axis.set(xlim=(0, 1.02), ylim=(0, 1.02), xlabel=r"contact radius $\hat a = a/a_{max}$", ylabel=r"force $F/F_{max}$")
    beside(figure, axis, r"$\bar E$")
    return figure
