"""Beyond the paper's figures: where the contact opens, and the pressure on it."""

from __future__ import annotations

from matplotlib.figure import Figure

from cases.edmans_sinka_2020.drawing import Picture, beside, colour_of_depth, colour_of_modulus, new_figure, panel_titles, styled
from cases.edmans_sinka_2020.inside import DEPTHS, Inside
from cases.report.judgement import Lacking

SHOWN = (10.0, 1000.0)


def pictures(inside: dict[float, Inside]) -> list[Picture]:
    """What can be drawn of them."""
    found = []
    if any(item.opening is not None for item in inside.values()):
        caption = (
            "The ring of contact in unloading from δ/R = 0.5, ν = 0.3: outer edge (lines) and, where the centre has left the flat, inner "
            "edge (dashed), over the share of the force that is left. Edges lie half way between two nodes, hence the steps."
        )
        found.append(Picture(None, "Opening at the centre", rings(inside), caption))
    if all(modulus in inside for modulus in SHOWN):
        caption = (
            "Contact pressure at the end of loading, ν = 0.3: from Hertz's half ellipse to the plateau of indentation near 3σ_y, and on "
            "to the upsetting of a barrel, where the pressure falls towards σ_y again."
        )
        found.append(Picture(None, "Contact pressure", pressure(inside), caption))
    return found


@styled
def rings(inside: dict[float, Inside]) -> Figure:
    """Inner and outer edge of the contact."""
    figure, axis = new_figure(6.6, 3.8)
    for modulus, item in sorted(inside.items()):
        colour, there = colour_of_modulus(modulus), item.outer > 0.0
        axis.plot(item.force[there], item.outer[there], color=colour, lw=1.1, label=f"{modulus:g}")
        opened = item.inner > 0.0
        axis.plot(item.force[opened], item.inner[opened], "--", color=colour, lw=1.3)
    axis.set(xscale="log", xlim=(1.0, 2e-3), ylim=(0, None), xlabel=r"force left $F/F_{max}$", ylabel=r"edges of the contact $/R_0$")
    beside(figure, axis, r"$\bar E$")
    return figure


@styled
def pressure(inside: dict[float, Inside]) -> Figure:
    """Contact pressure over the radius."""
    figure, axes = new_figure(9.2, 3.5, 1, 2, sharey=True)
    for axis, modulus in zip(axes, SHOWN, strict=True):
        for depth in DEPTHS:
            try:
                radius, value = inside[modulus].field("loading", depth).contact_pressure()
            except Lacking:
                continue
            axis.plot(radius, value, "o-", ms=2.0, lw=1.0, color=colour_of_depth(depth), label=f"{depth:g}")
        axis.set(xlabel=r"distance from the axis $r/R_0$", xlim=(0, 1.02))
    axes[0].set_ylim(bottom=0)
    axes[0].set_ylabel(r"contact pressure $p/\sigma_y$")
    panel_titles(axes, [rf"$\bar E = {modulus:g}$" for modulus in SHOWN])
    beside(figure, axes[0], r"$\bar\delta$")
    return figure
