"""Figs. 13 and 15: the paths of the validation; and loading and unloading of the other shapes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.becker_kamlah_2021 import own
from cases.becker_kamlah_2021.bodies import PAPERS, Case, Named
from cases.becker_kamlah_2021.data import REACH, Body, Study, nmc_key
from cases.edmans_sinka_2020.drawing import GREY, Picture, new_figure, styled
from cases.report.plots import COLOURS
from contactlaws.curve import FloatArray
from contactlaws.ellipsoid_contact import of_pair
from contactlaws.path import trace
from contactlaws.rivals.becker_kamlah import FIRST, BeckerKamlah
from contactlaws.rivals.becker_kamlah_ellipsoid import becker_kamlah_separation

FINITE, PUBLISHED, OTHER, OURS, OURS_PAIR = "black", COLOURS[0], COLOURS[4], COLOURS[2], COLOURS[1]
#: of the page's four shapes
SHOWN = (0.5, 2.0**-0.5, 2.0**0.5, 2.0)


def pictures(study: Study, named: Named) -> list[Picture]:
    """All of them."""
    drawn = [Picture(case.number, f"Validation, Fig. {case.number}", path(case, body), caption(case)) for case, body in named.cases]
    bodies = [study.body(nmc_key(), aspect) for aspect in SHOWN]
    return [*drawn, Picture(None, "Loading and unloading by shape", by_shape(bodies), CAPTION_SHAPES)]


CAPTION_SHAPES = (
    "NMC spheroids a : b : b on the flat, every unloading to separation. The published law meets the loading of sharp bodies, not of blunt "
    "ones just past yield; unloaded, it leaves too much overlap in sharp bodies and far too little in blunt ones. Faint dots on the axis: "
    "separation by finite elements."
)


def caption(case: Case) -> str:
    """What Figs. 13 and 15 show."""
    one, two = (" : ".join(f"{axis:g}" for axis in axes) for axes in (case.first, case.second))
    compared = (
        "dashed, the law of spheres of the same mean radius" if case.number == "13" else "dashed, the elastic-fully plastic law (λ = 1.6)"
    )
    return (
        f"NMC ellipsoids {one} and {two}, loaded to {100 * case.turns[0]:g} %, unloaded, reloaded to "
        f"{100 * case.turns[1]:g} % of the mean radius and unloaded. Lines: the published law of the pair, and ours; {compared}. Dots: "
        f"finite elements of the spheroid 1:{case.aspect:.3f} with the same R_e/r = {case.relative:.4f}, for which the published law is "
        "the same in these units; the triaxial pair itself is beyond an axisymmetric solver. At one share of the mean radius the spheroid, "
        "whose δ_Y is larger, turns a little earlier in these units. Reloading retraces the unloading in all."
    )


def ways(case: Case) -> FloatArray:
    """The overlaps of the pair in m, there and back."""
    first, second = (turn * 2.0 * case.mean_radius for turn in case.turns)
    return np.concatenate([np.linspace(a, b, 300) for a, b in ((0.0, first), (first, 0.0), (0.0, second), (second, 0.0))])


@styled
def path(case: Case, body: Body) -> Figure:
    """One of the two."""
    figure, axis = new_figure(6.8, 4.0)
    limit, force = case.unit
    overlap = ways(case)

    def draw(law: BeckerKamlah, style: str, colour: str, name: str) -> None:
        axis.plot(overlap / limit, trace(law, overlap).force / force, style, color=colour, label=name)

    law = case.contact.law
    if case.number == "13":
        draw(case.spheres, "--", COLOURS[2], "spheres of the same mean radius")
    else:
        draw(law._replace(pressure_ratio=FIRST), "--", OTHER, "elastic-fully plastic")
    draw(law, "-", PUBLISHED, "published law")
    ours = of_pair(PAPERS, case.scaled(case.first), PAPERS, case.scaled(case.second))
    axis.plot(overlap / limit, ours.along(overlap).force / force, "-", color=OURS_PAIR, lw=0.9, label=f"{own.NAME} of the pair")
    for branch in (0, *body.curve.unloadings):
        rows = body.curve.rows(branch)
        x = body.curve.overlap[rows] / body.yield_overlap
        keep = x <= body.curve.overlap[body.curve.rows(2)][0] / body.yield_overlap * (1.0 + 1e-9)
        label = f"finite elements, 1:{case.aspect:.3f}" if branch == 0 else None
        axis.plot(x[keep], body.curve.force[rows][keep] / body.yield_force, "o", ms=2.6, color=FINITE, label=label)
    axis.set(xlabel=r"overlap $\delta/\delta_Y$", ylabel=r"force $F/F_{pY}$", xlim=(0.0, None), ylim=(0.0, None))
    axis.legend(loc="upper left")
    return figure


def _down(body: Body, top: float) -> FloatArray:
    """The overlaps (m) of the law's own unloading."""
    return np.linspace(top, becker_kamlah_separation(body.law, top), 60)


@styled
def by_shape(bodies: list[Body]) -> Figure:
    """Four shapes."""
    figure, axes = new_figure(9.2, 6.4, 2, 2)
    for axis, body in zip(axes.ravel(), bodies, strict=True):
        _draw(axis, body)
        axis.set(title=f"{body.name}, $R_e/\\hat r$ = {body.relative:.3f}", xlabel=r"overlap $\delta/r$", ylabel=r"force $F/F_{pY}$")
        axis.set(xlim=(0.0, None), ylim=(0.0, None))
    axes[0, 0].legend(loc="upper left")
    return figure


def _draw(axis: Axes, body: Body) -> None:
    curve, unit = body.curve, body.mean_radius
    ours = own.own_law(curve)
    for branch in (0, *curve.unloadings):
        rows = curve.rows(branch)
        x, first = curve.overlap[rows] / unit, branch == 0
        keep = x <= REACH * (1.0 + 1e-6)
        if not first and (not keep[0] or curve.overlap[rows][0] < body.yield_overlap):
            continue
        axis.plot(
            x[keep],
            curve.force[rows][keep] / body.yield_force,
            color="#b5b5b5",
            lw=3.2,
            solid_capstyle="butt",
            label="finite elements" if first else None,
        )
        overlap = curve.overlap[rows][keep] if first else _down(body, float(curve.overlap[rows][0]))
        law = trace(body.law, overlap).force / body.yield_force
        axis.plot(overlap / unit, law, color=PUBLISHED, lw=1.0, label="published law" if first else None)
        if ours is not None:
            path = curve.overlap[rows][keep]
            axis.plot(path / unit, ours(path) / body.yield_force, color=OURS, lw=1.0, label=own.NAME if first else None)
        if not first:
            axis.plot(x[-1], 0.0, "o", ms=3.0, color=GREY, clip_on=False)
    hertz = np.linspace(0.0, REACH, 60) * unit
    axis.plot(hertz / unit, body.hertz(hertz) / body.yield_force, ":", color=GREY, lw=0.9, label="Hertz")
    axis.set_ylim(0.0, 1.05 * float(np.interp(REACH * unit, body.overlap, body.force)) / body.yield_force)
