"""Figures 9, 10 and 12 of the paper, and what goes beyond them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.report.plots import COLOURS, GREY, styled
from cases.wahn_gan_kamlah_2022 import accuracy
from cases.wahn_gan_kamlah_2022.gap import SMALL_STRAIN, STATED, Elastic, Gap
from cases.wahn_gan_kamlah_2022.material import OVERLAP, PUBLISHED, RADIUS, STRAIN, TOGETHER
from cases.wahn_gan_kamlah_2022.trade import Choice
from contactlaws.curve import Curve, FloatArray
from contactlaws.path import scan

MILLINEWTON = 1e3
ROWS = 2000
#: black for the continuum
CONTINUUM, OURS, OLD = "black", COLOURS[0], COLOURS[1]


class Picture(NamedTuple):
    """A figure, the stem of its file, and its caption."""

    name: str
    figure: Figure
    caption: str


def ramp(law: Any, duration: float, overlap: float = OVERLAP) -> tuple[FloatArray, FloatArray]:
    """Strain in per cent and force in mN of two spheres along an even ramp."""
    share = np.linspace(0.0, 1.0, ROWS)
    return 100.0 * STRAIN * share * overlap / OVERLAP, MILLINEWTON * scan(law, overlap * share, duration * share).force


def new(width: float, height: float, columns: int = 1) -> tuple[Figure, Any]:
    """A figure and its axes."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(1, columns)


def axes_of_force(axis: Axes, across: str) -> None:
    """Labels."""
    axis.set_xlabel(across)
    axis.set_ylabel("normal force (mN)")
    axis.set_ylim(bottom=0.0)


@styled
def figure_9(curves: Mapping[float, Curve]) -> Picture:
    """Rates between the limits."""
    figure, axes = new(8.4, 3.6, 2)
    old, ours = (accuracy.laws(TOGETHER)[name] for name in (accuracy.PLAIN, accuracy.OURS))
    for axis, law, title in ((axes[0], old, "the paper's law (Hertz)"), (axes[1], ours, "with finite size, and finite elements")):
        for duration, style in ((1e-12, "-"), (1e12, "-")):
            axis.plot(*ramp(law, duration), style, color=GREY, lw=2.5, alpha=0.6, zorder=1)
        for number, duration in enumerate(sorted(curves)):
            colour = COLOURS[number]
            axis.plot(*ramp(law, duration), "--" if law is old else "-", color=colour, label=f"in {duration:g} s")
            if law is ours:
                curve = curves[duration]
                axis.plot(100.0 * curve.overlap / RADIUS, MILLINEWTON * curve.force, "o", ms=2.2, color=colour)
        axis.set_title(title)
        axes_of_force(axis, "strain (%)")
    axes[0].legend(title="2 % strain", alignment="left")
    top = max(axis.get_ylim()[1] for axis in axes)
    for axis in axes:
        axis.set_ylim(0.0, top)
    caption = (
        "Fig. 9 again: two PVDF spheres of 5 µm radius pressed to 2 % strain in 0.01 to 100 s (the paper's rates are one over that). Grey: "
        "infinitely fast and slow. Left the half-space law, right ours with finite elements as dots."
    )
    return Picture("figure_09", figure, caption)


@styled
def figure_10(curve: Curve) -> Picture:
    """Relaxation after a ramp of 1 s."""
    figure, axes = new(8.4, 3.4, 2)
    laws = {"the paper's law": (accuracy.PLAIN, OLD, "--"), "ours": (accuracy.OURS, OURS, "-")}
    times = np.concatenate([np.linspace(0.0, 1.0, 200), np.geomspace(1.0, 20.0, 400)[1:]])
    overlap = OVERLAP * np.minimum(times, 1.0)
    strain = 100.0 * overlap / RADIUS
    for label, (name, colour, style) in laws.items():
        law = accuracy.laws(TOGETHER)[name]
        force = MILLINEWTON * scan(law, overlap, times).force
        axes[0].plot(times, force, style, color=colour, label=label)
        axes[1].plot(strain, force, style, color=colour)
        for duration in (1e-12, 1e12):
            axes[1].plot(*ramp(law, duration), ":", color=colour, lw=0.9)
    axes[0].plot(curve.time, MILLINEWTON * curve.force, "o", ms=2.5, color=CONTINUUM, label="finite elements")
    axes[1].plot(100.0 * curve.overlap / RADIUS, MILLINEWTON * curve.force, "o", ms=2.5, color=CONTINUUM)
    axes[0].axvline(7.5, color=GREY, lw=0.8, ls=":")
    axes[0].text(7.6, 0.01, "7.5 s: 0.65 % left", color=GREY, fontsize=7.5)
    axes_of_force(axes[0], "time (s)")
    axes_of_force(axes[1], "strain (%)")
    axes[0].legend()
    return Picture(
        "figure_10", figure, "Fig. 10 again: 2 % strain in 1 s, then held; dotted on the right the infinitely fast and slow limits."
    )


@styled
def figure_12(curves: Mapping[float, Curve]) -> Picture:
    """Finite elements against laws."""
    figure, axis = new(5.6, 4.0)
    old = accuracy.laws(TOGETHER)[accuracy.PLAIN]
    ours = accuracy.laws(PUBLISHED)[accuracy.OURS]
    for number, (duration, curve) in enumerate(sorted(curves.items())):
        axis.plot(*ramp(old, duration), "--", color=COLOURS[number])
        axis.plot(*ramp(ours, duration), "-", color=COLOURS[number], label=f"{1.0 / duration:g} 1/s")
        axis.plot(100.0 * curve.overlap / RADIUS, MILLINEWTON * curve.force, "o", ms=2.5, color=COLOURS[number])
    axes_of_force(axis, "strain (%)")
    axis.legend(title="rate of the paper", alignment="left")
    caption = (
        "Fig. 12 again: finite elements with the paper's g_1 = k_1 = .2369 (dots), its half-space law (dashed; 5.4 % below, as the paper "
        "says), and ours for the same constants (lines)."
    )
    return Picture("figure_12", figure, caption)


@styled
def figure_gap(elastic: Elastic, gaps: Sequence[Gap]) -> Picture:
    """Where the 5.4 % come from."""
    figure, axes = new(8.4, 3.6, 2)
    law = accuracy.laws(TOGETHER)[accuracy.OURS]
    hertz = accuracy.laws(TOGETHER)[accuracy.TING]
    depth = np.linspace(1e-4, 0.1, 200)
    ratio = np.array([scan(law, [d * RADIUS]).force[0] / scan(hertz, [d * RADIUS]).force[0] for d in depth])
    axes[0].plot(elastic.overlap, 100.0 * (elastic.ratio - 1.0), "o", ms=2.5, color=CONTINUUM, label="finite elements, elastic")
    axes[0].plot(depth, 100.0 * (ratio - 1.0), color=OURS, label="finite-size part of our law")
    axes[0].plot(STRAIN, 100.0 * (SMALL_STRAIN - 1.0), "D", color=COLOURS[2], label="small strain (Legendre series)")
    axes[0].axvline(STRAIN, color=GREY, lw=0.8, ls=":")
    axes[0].set(xlabel="overlap over the radius", ylabel="force above Hertz's (%)", ylim=(0.0, None))
    axes[0].legend(loc="lower right")
    durations = [gap.ramp for gap in gaps]
    for values, style, label in (
        ([gap.consistent for gap in gaps], "o-", "Poisson's ratio constant (g .2285), as the law"),
        ([gap.constant_bulk for gap in gaps], "s-", "bulk modulus constant (g .2369)"),
        ([gap.published for gap in gaps], "^-", "as published: g .2369, but k_1 = g_1"),
        ([gap.published_over_elements for gap in gaps], "v--", "the same over the elements' force, G_0 617.5 MPa"),
    ):
        axes[1].plot(durations, 100.0 * np.array(values), style, ms=4, label=label)
    axes[1].axhline(100.0 * STATED, color=GREY, lw=0.8, ls=":")
    axes[1].text(durations[0], 100.0 * STATED - 0.35, "5.4 % (paper)", color=GREY, fontsize=7.5)
    axes[1].set(xscale="log", xlabel="loading time (s)", ylabel="finite elements above the half-space law (%)", ylim=(4.0, 12.0))
    axes[1].legend(loc="upper right")
    caption = (
        "Where the 5.4 % come from: a sphere is no half-space. Left, elastic: the force above Hertz's. Right, viscoelastic at 2 % strain: "
        "with the constants that belong to the law the gap is 7.2 %; the paper's finite elements had a long-term modulus 1.1 % too small."
    )
    return Picture("gap", figure, caption)


@styled
def figure_retreat(curves: Mapping[str, Curve]) -> Picture:
    """Histories that shrink, rest and meet again."""
    figure, axes = new(8.4, 3.6, len(curves))
    shown = {"ours": (accuracy.OURS, OURS, "-"), "the paper's increments": (accuracy.RIVAL, OLD, "--")}
    shown["Kuwabara & Kono"] = ("kuwabara_kono", COLOURS[2], ":")
    for axis, (history, curve) in zip(axes, curves.items(), strict=True):
        for label, (name, colour, style) in shown.items():
            force = accuracy.followed(accuracy.laws(TOGETHER)[name], curve)
            axis.plot(curve.time, MILLINEWTON * force, style, color=colour, label=label, lw=1.1)
        axis.plot(curve.time, MILLINEWTON * curve.force, "o", ms=2.2, color=CONTINUUM, label="finite elements")
        axis.axhline(0.0, color=GREY, lw=0.6)
        axis.set(title=history, xlabel="time (s)", ylabel="normal force (mN)")
    axes[0].legend(fontsize=7.0)
    caption = (
        "Contacts that shrink, part and meet again, 2 % strain: the paper's increments pull at the end of a retreat (below zero) and are "
        "7 % low for want of finite size; Kuwabara & Kono have no memory."
    )
    return Picture("retreat", figure, caption)


@styled
def figure_trade(choices: Sequence[Choice]) -> Picture:
    """Error against cost."""
    figure, axes = new(8.4, 3.6, 2)
    for axis, name, title in ((axes[0], "growing", "while the contact grows and rests"), (axes[1], "retreating", "after it has turned")):
        for number, springs in enumerate(sorted({choice.springs for choice in choices})):
            rows = [choice for choice in choices if choice.springs == springs]
            label = "without Ting" if springs == 0 else f"Ting, {springs} springs"
            cost = [row.loading if name == "growing" else row.unloading for row in rows]
            axis.plot(cost, [100.0 * getattr(row, name) for row in rows], "o-", color=COLOURS[number], ms=3.5, label=label)
            for row, at in zip(rows, cost, strict=True):
                axis.annotate(str(row.terms), (at, 100.0 * getattr(row, name)), fontsize=6.5, textcoords="offset points", xytext=(3, 3))
        axis.set(yscale="log", xscale="log", xlabel="cost of a contact in the pair kernel over Hertz's", title=title)
    axes[0].set_ylabel("error over the largest force (%)")
    axes[0].legend()
    caption = (
        "Error against cost for 1, 2, 3, 5 and 8 terms (numbers) of a material that relaxes evenly over six decades, along histories of "
        "0.01 to 1000 s; errors against the continuum with all twelve terms."
    )
    return Picture("trade", figure, caption)
