"""Figs. 9 to 11: pressure on the contact, force, and lambda of the body 1 : .66 : .66."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.becker_kamlah_2021.apart import loading_of
from cases.becker_kamlah_2021.bodies import Named, Profile
from cases.becker_kamlah_2021.data import REACH, Body, Study
from cases.becker_kamlah_2021.readings import CLEAR, Reading, equation_28, pressure_ratio, read, sampled
from cases.edmans_sinka_2020.drawing import GREY, Picture, new_figure, styled
from cases.report.plots import COLOURS
from contactlaws.rivals.becker_kamlah import EXPONENT, FIRST

FINITE, PUBLISHED, REFITTED = "black", COLOURS[1], COLOURS[0]
#: Hertz's pressure is drawn beside contacts that are not far beyond first yield
HERTZ_SHOWN = 4.0
#: shapes beside the paper's in Fig. 11
OTHERS = (0.5, 1.0, 2.0**0.5, 2.0)
OVERLAP = r"overlap $\delta/\delta_Y$"


def pictures(study: Study, named: Named) -> list[Picture]:
    """All three."""
    found = read(named.papers)
    others = [body for body in study.nmc if any(abs(body.aspect - aspect) < 1e-6 for aspect in OTHERS)]
    return [
        Picture("9", "Pressure on the contact", pressure(named.profiles), _caption_9(named)),
        Picture("10", "Force", force(named.papers, found), _caption_10(named)),
        Picture("11", "lambda", ratio(named.papers, found, others), _caption_11(found)),
    ]


def _caption_9(named: Named) -> str:
    deepest = named.profiles[-1]
    return (
        "Pressure over the contact of NMC, body 1 : 0.66 : 0.66 on the flat (the paper does not say which body it shows). Dots: Hertz's "
        "pressure for the same overlap, Eqs. 1, 2 and 9. Elastic contacts are Hertz's; beyond yield the profile flattens and the contact "
        f"is larger than Eq. 9 has it. The pressure itself levels at {max(p.largest for p in named.profiles):.2f} Y, far below λ_max Y, "
        f"which Eq. 51 reads from force over Hertz's area; in the end it falls at the centre (δ/δ_Y = {deepest.depth:.3g}). c_Y by the "
        "paper's 1.6 Y."
    )


def _caption_10(named: Named) -> str:
    return (
        "Loading of the same body to 15 % of its mean radius, F_pY and δ_Y by the paper's 1.6 Y. The published constants are those of "
        f"Eq. 54 at R_e/r = {named.papers.relative:.3f}. The curve is the force of one body on the flat, which in these units is that of "
        "the pair with its mirror image."
    )


def _caption_11(found: Reading) -> str:
    return (
        f"λ by Eq. 51. Left: the same body; line: Eq. 28 with n = {EXPONENT:g}, fitted to the force: λ_max = {found.pressure_ratio:.2f}, "
        f"ε_max = {found.radius_ratio:.2f}; vertical: c_max. Right: other shapes of NMC to 20 %, with Eqs. 28 and 54 dashed. At first "
        "yield λ is 0/0: where the finite body's force is not Hertz's it runs off, upwards for blunt bodies, whose λ has no rise that "
        "Eq. 28 could mean."
    )


@styled
def pressure(profiles: list[Profile]) -> Figure:
    """Fig. 9."""
    figure, axis = new_figure(7.2, 3.9)
    colours = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.88, len(profiles)))
    for profile, colour in zip(profiles, colours, strict=True):
        axis.plot(profile.place, profile.pressure, color=colour, label=f"{profile.depth:.3g}")
        edge = np.sqrt(profile.depth)
        place = np.linspace(0.0, edge, 14)
        if profile.depth < HERTZ_SHOWN:
            axis.plot(place, FIRST * edge * np.sqrt(1.0 - (place / edge) ** 2), "o", ms=2.6, color=colour)
    axis.axhline(FIRST, color=GREY, lw=0.8, ls=":")
    axis.text(axis.get_xlim()[1], FIRST, " 1.6 Y", color=GREY, va="center", fontsize=8.0)
    axis.set(xlabel=r"distance from the centre $x/c_Y$", ylabel=r"contact pressure $p/Y$", ylim=(0.0, 3.2), xlim=(0.0, None))
    figure.legend(loc="outside right upper", title=OVERLAP, alignment="left")
    return figure


def _force_axes(axis: Axes) -> None:
    axis.set(xlabel=OVERLAP, ylabel=r"force $F/F_{pY}$", xlim=(0.0, None), ylim=(0.0, None))


@styled
def force(body: Body, found: Reading) -> Figure:
    """Fig. 10."""
    figure, axes = new_figure(8.4, 3.6, 1, 2, width_ratios=(1.2, 1.0))
    overlap = np.linspace(0.0, REACH * body.mean_radius, 300)
    own = body.law._replace(pressure_ratio=found.pressure_ratio, radius_ratio=found.radius_ratio)
    shown = body.overlap <= overlap[-1] * (1.0 + 1e-6)
    for axis, last in zip(axes, (None, 4.0), strict=True):
        axis.plot(overlap / body.yield_overlap, body.hertz(overlap) / body.yield_force, ":", color=GREY, label="Hertz")
        for law, colour, style, name in ((own, REFITTED, "-", "fitted to this body"), (body.law, PUBLISHED, "--", "published, Eq. 54")):
            axis.plot(overlap / body.yield_overlap, loading_of(law, overlap) / body.yield_force, style, color=colour, label=name)
        axis.plot(
            body.overlap[shown] / body.yield_overlap,
            body.force[shown] / body.yield_force,
            "o",
            ms=2.6,
            color=FINITE,
            label="finite elements",
        )
        _force_axes(axis)
        if last is not None:
            axis.set(xlim=(0.0, last), ylim=(0.0, 8.0), title="around first yield")
    axes[0].set_ylim(0.0, 1.15 * body.force[shown].max() / body.yield_force)
    axes[0].set_title("to 15 % of the mean radius")
    axes[0].legend(loc="upper left")
    return figure


@styled
def ratio(body: Body, found: Reading, others: Sequence[Body]) -> Figure:
    """Fig. 11, and the same of other shapes."""
    figure, (axis, beside) = new_figure(8.6, 3.7, 1, 2)
    _ratio_of_paper(axis, body, found)
    for other, colour in zip(others, COLOURS, strict=False):
        told = other.overlap > 1.06 * other.yield_overlap
        depth = other.overlap[told] / other.yield_overlap
        beside.plot(depth, pressure_ratio(other, other.overlap[told], other.force[told]), color=colour, label=other.name)
        line = np.sqrt(np.linspace(1.0, depth[-1], 200))
        law = other.law
        beside.plot(line**2, equation_28(line, law.pressure_ratio, law.radius_ratio, EXPONENT), "--", color=colour, lw=0.8)
    beside.set(xlabel=OVERLAP, ylabel=r"$\lambda$", ylim=(1.4, 3.6), title="other shapes")
    beside.legend(title="shape a:b", ncols=2, loc="lower right")
    axis.set_title(f"1:{body.aspect:g}")
    return figure


def _ratio_of_paper(axis: Axes, body: Body, found: Reading) -> None:
    overlap, values = sampled(body, start=1.06)
    told = body.overlap > 1.06 * body.yield_overlap
    axis.plot(
        body.overlap[told] / body.yield_overlap,
        pressure_ratio(body, body.overlap[told], body.force[told]),
        "o",
        ms=2.8,
        color=FINITE,
        label="finite elements",
    )
    radius = np.sqrt(np.linspace(1.0, overlap[-1] / body.yield_overlap, 300))
    axis.plot(radius**2, equation_28(radius, found.pressure_ratio, found.radius_ratio, EXPONENT), color=REFITTED, label="fitted")
    law = body.law
    axis.plot(radius**2, equation_28(radius, law.pressure_ratio, law.radius_ratio, EXPONENT), "--", color=PUBLISHED, label="Eq. 54")
    for full, colour in ((found.radius_ratio, REFITTED), (law.radius_ratio, PUBLISHED)):
        axis.axvline(full**2, color=colour, lw=0.7, ls=":")
    axis.axvspan(1.0, CLEAR, color=GREY, alpha=0.15, lw=0)
    axis.set(xlabel=OVERLAP, ylabel=r"$\lambda$", ylim=(1.4, max(3.2, 1.05 * float(values.max()))))
    axis.legend(loc="lower right")
