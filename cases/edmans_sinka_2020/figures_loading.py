"""Figs. 3, 4 and 7: force, energy, first yield."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibration.unloadings import Unloading
from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.data import Study, force_unit
from cases.edmans_sinka_2020.drawing import E_BAR, GREY, Picture, beside, colour_of_modulus, new_figure, styled
from contactlaws.curve import Curve
from contactlaws.edmans_sinka import FIRST_YIELD

NU = 0.3
#: of the paper's Eq. 5, and of the finite elements
YIELD_MARKS: tuple[dict[str, Any], ...] = ({"marker": "o", "mfc": "white", "ms": 5}, {"marker": "x", "ms": 5})
READING_STYLE = {"corrected": ("#0072B2", "-"), "printed": ("#D55E00", "--"), "unsquared": ("#009E73", ":")}


def pictures(study: Study) -> list[Picture]:
    """In the paper's order."""
    return [
        Picture(
            "3",
            "Force in loading",
            force(study),
            "Force against overlap in loading, ν = 0.3, and for E/σ_y = 10 the unloadings as well. Circles: first yield by the paper's "
            "Eq. 5 with its coefficients in their right places; crosses: first yield in the finite elements. All of it is ours; which "
            "unloadings the paper draws is not known.",
        ),
        Picture(
            "4",
            "Stored energy",
            stored_energy(study),
            "Energy stored in the half sphere, over that of a half sphere everywhere at the yield stress in tension, ⅔πR³·σ_y²/2E; "
            "loading to δ/R = 0.5 (lines) and unloading from there (dashed). ν = 0.3; the paper does not say its ν. All ours.",
        ),
        Picture(
            "7",
            "First yield",
            first_yield(study),
            "Overlap at first yield, ν = 0.3: finite elements (dots, ours) against the three readings of the paper's Eq. 5 (lines): with "
            "K = 0.454 + 0.41ν of Chang, Etsion & Bogy; as printed, with the two coefficients exchanged; and as printed without the "
            "square on the numerator, the only one that gives the 366 of section 4.5. Below: Eq. 5 over finite elements.",
        ),
    ]


def yield_mark(curve: Curve, depth: float) -> tuple[float, float] | None:
    """Overlap over radius and force over pi R^2 Y on the loading at `depth`; None outside of it."""
    rows = curve.rows(0)
    x = curve.overlap[rows] / curve.radius
    return (depth, float(np.interp(depth, x, curve.force[rows]) / force_unit(curve))) if depth <= x[-1] else None


@styled
def force(study: Study) -> Figure:
    """Fig. 3."""
    figure, (left, right) = new_figure(9.2, 4.0, 1, 2, gridspec_kw={"width_ratios": [1.5, 1]})
    for modulus in study.moduli(NU):
        curve = study.curves[modulus, NU]
        _force_of(left, curve, modulus)
        _force_of(right, curve, modulus)
    if (10.0, NU) in study.curves:
        _unloadings(left, study.curves[10.0, NU], study.unloadings[10.0, NU])
    left.set(xlim=(0, 0.505), ylim=(0, None), xlabel=r"overlap $\bar\delta = \delta/R_0$", ylabel=r"force $\bar F = F/(\pi R_0^2\sigma_y)$")
    right.set(xlim=(0, 0.1), ylim=(0, 0.3), xlabel=r"overlap $\bar\delta$", title="the beginning, enlarged")
    beside(figure, left, r"$\bar E$")
    return figure


def _force_of(axis: Axes, curve: Curve, modulus: float) -> None:
    rows = curve.rows(0)
    axis.plot(
        curve.overlap[rows] / curve.radius, curve.force[rows] / force_unit(curve), color=colour_of_modulus(modulus), label=f"{modulus:g}"
    )
    places = (float(paper.yield_depth(modulus, NU)), None if curve.yield_overlap is None else curve.yield_overlap / curve.radius)
    for depth, style in zip(places, YIELD_MARKS, strict=True):
        mark = None if depth is None else yield_mark(curve, depth)
        if mark is not None:
            axis.plot(*mark, color=colour_of_modulus(modulus), ls="", zorder=3, **style)


def _unloadings(axis: Axes, curve: Curve, found: tuple[Unloading, ...]) -> None:
    for item in found:
        rows = curve.rows(item.branch)
        axis.plot(curve.overlap[rows] / curve.radius, curve.force[rows] / force_unit(curve), color=colour_of_modulus(10.0), lw=0.7)


def energy_unit(curve: Curve) -> float:
    """2/3 pi R^3 Y^2/(2 E) in J: the caption of Fig. 4."""
    material = curve.material
    assert material is not None
    assert material.yield_stress is not None
    return float(2.0 / 3.0 * np.pi * curve.radius**3 * material.yield_stress**2 / (2.0 * material.youngs_modulus))


@styled
def stored_energy(study: Study) -> Figure:
    """Fig. 4."""
    figure, axis = new_figure(6.4, 4.0)
    for modulus in study.moduli(NU):
        curve = study.curves[modulus, NU]
        if curve.stored_energy is None:
            continue
        for branch, style in ((0, "-"), (curve.unloadings[-1], "--")):
            rows = curve.rows(branch)
            axis.plot(
                curve.overlap[rows] / curve.radius,
                curve.stored_energy[rows] / energy_unit(curve),
                style,
                color=colour_of_modulus(modulus),
                label=f"{modulus:g}" if branch == 0 else None,
                lw=1.3 if branch == 0 else 0.9,
            )
    axis.axhline(1.0, color=GREY, lw=0.7, ls=":")
    axis.set(
        xlim=(0, 0.505), ylim=(0, None), xlabel=r"overlap $\bar\delta$", ylabel=r"stored energy $/\,(\frac{2}{3}\pi R_0^3\,\sigma_y^2/2E)$"
    )
    beside(figure, axis, r"$\bar E$")
    return figure


@styled
def first_yield(study: Study) -> Figure:
    """Fig. 7."""
    figure, (top, bottom) = new_figure(6.0, 5.0, 2, 1, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    there = [modulus for modulus in study.moduli(NU) if study.curves[modulus, NU].yield_overlap is not None]
    depth = np.array([(study.curves[modulus, NU].yield_overlap or 0.0) / study.curves[modulus, NU].radius for modulus in there])
    line = np.geomspace(1.0, 1000.0, 60)
    for reading in FIRST_YIELD:
        colour, style = READING_STYLE[reading]
        top.plot(line, paper.yield_depth(line, NU, reading), style, color=colour, label=f"Eq. 5, {reading}")
        bottom.plot(there, paper.yield_depth(np.array(there), NU, reading) / depth, style, color=colour, marker="o", ms=3)
    top.plot(there, depth, "ko", ms=4, label="finite elements")
    top.set(xscale="log", yscale="log", ylabel=r"overlap at first yield $\bar\delta_c$")
    top.legend(loc="lower left")
    bottom.axhline(1.0, color=GREY, lw=0.7)
    bottom.set(xlabel=E_BAR, ylabel="Eq. 5 over\nfinite elements", yscale="log", ylim=(0.15, 12.0))
    bottom.set_yticks([0.2, 0.5, 1, 2, 5, 10], labels=["0.2", "0.5", "1", "2", "5", "10"])
    bottom.minorticks_off()
    return figure
