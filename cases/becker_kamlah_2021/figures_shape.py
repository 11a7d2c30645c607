"""Fig. 12, and what the paper does not have: lambda_max and epsilon_max of other materials."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from cases.becker_kamlah_2021.data import Key, nmc_key
from cases.becker_kamlah_2021.shape_fit import Read, fit, points, published
from cases.edmans_sinka_2020.drawing import GREY, Picture, beside, new_figure, styled
from cases.report.judgement import Lacking
from cases.report.plots import COLOURS

RELATIVE = r"$R_e/\hat r$"
LABELS = {"pressure_ratio": r"$\lambda_{max}$", "radius_ratio": r"$\epsilon_{max}$"}
#: triaxial bodies of the authors' material by an independent code: R_e/r, lambda_max; the sphere of that code for comparison
TRIAXIAL = {"1:0.5:2": (0.25, 2.92), "sphere": (0.25, 2.77)}
NU = 0.3


def pictures(read_of: Mapping[Key, Sequence[Read]]) -> list[Picture]:
    """Fig. 12 and two of ours."""
    if nmc_key() not in read_of:
        raise Lacking("readings of the authors' material")
    drawn = [Picture("12", "Plateau and its place against shape", shapes(read_of[nmc_key()]), CAPTION_12)]
    if sum(key[1] == NU for key in read_of) >= 3:
        drawn.append(Picture(None, "Plateaus of other materials", materials(read_of), CAPTION_MATERIALS))
        drawn.append(Picture(None, "No plateau far beyond", falling(read_of), CAPTION_FALLING))
    return drawn


CAPTION_12 = (
    "λ_max and ε_max of NMC against R_e/r. Filled: fit of the force with n = 1.8, with standard errors; open: λ at 15 % where no "
    "transition is seen (blunt bodies: λ falls from the start, ε has no value); crosses: the largest λ, where there is one within 15 %. "
    "Full line: Eq. 52 fitted to ours, dotted where no body tells; dashed: the paper's Eq. 54. Triangles: the triaxial body 1 : 0.5 : 2 "
    "and the sphere by an independent code, one R_e/r, two λ_max."
)
CAPTION_MATERIALS = (
    "The same for other E/Y, ν = 0.3 (left, middle) and for other ν (right, E/Y = 60), by the fit of the force; dashed: Eq. 54, which "
    "knows neither. For E/Y above 60 the force does not tell where λ_max is reached: the loading to 15 % lies far beyond."
)
CAPTION_FALLING = (
    "λ at 15 % of the mean radius over the largest λ on the way (1 is a plateau), ν = 0.3. The larger E/Y, the earlier the largest λ, and "
    "the deeper the fall up to 15 %: the fully plastic regime of a constant λ does not exist there."
)


def colour_of(key: Key) -> Any:
    """By E/Y, from 5 to 1000."""
    return matplotlib.colormaps["plasma"](np.clip(math.log(key[0] / 5.0) / math.log(200.0), 0.0, 1.0) * 0.88)


@styled
def shapes(rows: Sequence[Read]) -> Figure:
    """Fig. 12."""
    figure, axes = new_figure(8.6, 3.7, 1, 2)
    line = np.linspace(0.09, 0.64, 200)
    for axis, quantity in zip(axes, LABELS, strict=True):
        axis.plot(line, published(quantity, line), "--", color=COLOURS[1], label="Eq. 54")
        found = fit(*points(rows, quantity, "force"), quantity)
        if found is not None:
            scale, rate, limit = found.constants
            last = points(rows, quantity, "force")[0].max()
            for part, style in ((line[line <= last], "-"), (line[line > last], ":")):
                label = "fitted to ours" if style == "-" else None
                axis.plot(part, scale * np.exp(rate * part) + limit, style, color=COLOURS[0], label=label)
        seen = [row for row in rows if row.force.seen]
        name = "pressure_error" if quantity == "pressure_ratio" else "radius_error"
        axis.errorbar(
            [row.body.relative for row in seen],
            [getattr(row.force, quantity) for row in seen],
            [getattr(row.force, name) for row in seen],
            fmt="o",
            ms=4.0,
            lw=0.9,
            color=COLOURS[0],
            label="fit of the force",
        )
        levels = [row for row in rows if not row.force.seen and row.force.told is not None]
        if quantity == "pressure_ratio" and levels:
            axis.plot(
                [row.body.relative for row in levels],
                [row.force.level for row in levels],
                "o",
                ms=4.0,
                mfc="none",
                color=COLOURS[0],
                label=r"$\lambda$ at 15 %",
            )
            axis.plot(*zip(*TRIAXIAL.values(), strict=True), "^", ms=4.5, color=GREY, label="another code")
        axis.plot(*points(rows, quantity, "plateau"), "x", ms=5.0, color="black", label=r"largest $\lambda$")
        axis.set(xlabel=RELATIVE, ylabel=LABELS[quantity], xlim=(0.08, 0.65))
    axes[1].set_ylim(0.0, None)
    axes[0].legend()
    return figure


@styled
def materials(read_of: Mapping[Key, Sequence[Read]]) -> Figure:
    """E/Y and nu."""
    figure, axes = new_figure(10.0, 3.7, 1, 3)
    line = np.linspace(0.09, 0.64, 200)
    for axis, quantity in zip(axes, ("pressure_ratio", "radius_ratio", "pressure_ratio"), strict=True):
        axis.plot(line, published(quantity, line), "--", color=GREY, label="Eq. 54")
        axis.set(xlabel=RELATIVE, ylabel=LABELS[quantity], xlim=(0.08, 0.65))
    for key in sorted(read_of):
        if key[1] in (NU, nmc_key()[1]):
            for axis, quantity in zip(axes, LABELS, strict=False):
                axis.plot(*points(read_of[key], quantity, "force"), "o-", ms=2.6, lw=0.9, color=colour_of(key), label=_name(key))
    fixed = 60.0
    for number, nu in enumerate(sorted({key[1] for key in read_of if key[0] == fixed})):
        axes[2].plot(
            *points(read_of[fixed, nu], "pressure_ratio", "force"), "o-", ms=2.6, lw=0.9, color=COLOURS[number], label=rf"$\nu$ = {nu:g}"
        )
    axes[1].set(yscale="log")
    axes[2].set_title(f"E/Y = {fixed:g}")
    axes[2].legend()
    beside(figure, axes[0], "E/Y")
    return figure


def _name(key: Key) -> str:
    return f"{key[0]:.4g}" + (" (NMC)" if key == nmc_key() else "")


@styled
def falling(read_of: Mapping[Key, Sequence[Read]]) -> Figure:
    """What is left of the largest lambda at 15 %."""
    figure, axes = new_figure(8.6, 3.6, 1, 2)
    for key in sorted(read_of):
        rows = [row for row in read_of[key] if row.plateau is not None and key[1] in (NU, nmc_key()[1])]
        there = [(row.body.relative, row.plateau.at_end, row.plateau.radius_ratio**2) for row in rows if row.plateau is not None]
        if there:
            relative, left, place = zip(*there, strict=True)
            axes[0].plot(relative, left, "o-", ms=2.8, lw=0.9, color=colour_of(key), label=_name(key))
            depth = [w * row.body.yield_overlap / row.body.mean_radius for w, row in zip(place, rows, strict=True)]
            axes[1].plot(relative, depth, "o-", ms=2.8, lw=0.9, color=colour_of(key))
    axes[0].axhline(1.0, color=GREY, lw=0.8, ls=":")
    axes[0].set(xlabel=RELATIVE, ylabel=r"$\lambda$ at 15 % over the largest", ylim=(0.0, 1.05))
    axes[1].set(xlabel=RELATIVE, ylabel=r"overlap of the largest $\lambda$, $\delta/r$", ylim=(0.0, 0.16))
    beside(figure, axes[0], "E/Y")
    return figure
