"""Figures 13 to 16 again as bands over packings, density scaling, and jamming."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from cases.report.plots import COLOURS, GREY, styled
from cases.wahn_gan_kamlah_2022.figures import Picture, new
from cases.wahn_gan_kamlah_2022.jamming import Exponents, effective_medium
from cases.wahn_gan_kamlah_2022.packing_facts import PAPER_STRESS, RUBBING, SMOOTH, power
from cases.wahn_gan_kamlah_2022.packing_runs import SWEEP, TIMES, Jammed, rated
from cases.wahn_gan_kamlah_2022.packing_statements_rates import left, pair_share
from cases.wahn_gan_kamlah_2022.packings import Run, Runs

MEGA = 1e-6
TITLES = ((RUBBING, f"friction {RUBBING:g}"), (SMOOTH, "no friction"))


def draw(axis: Axes, runs: Sequence[Run], colour: str, label: str, style: str = "-", width: float = 1.3) -> None:
    """Mean over packings, and all of them as a band, against strain in per cent."""
    if not runs:
        return
    grid = np.linspace(0.0, max(float(r.strain.max()) for r in runs), 201)
    values = np.array([[r.at(x) for x in grid] for r in runs]) * MEGA
    axis.fill_between(100.0 * grid, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.18, lw=0)
    axis.plot(100.0 * grid, values.mean(axis=0), style, color=colour, label=label, lw=width, alpha=1.0 if width < 2.0 else 0.6)


def finish(axes: Sequence[Axes], across: str = "strain (%)") -> None:
    """Labels, legends, titles."""
    for axis in axes:
        axis.set_xlabel(across)
        axis.set_ylabel("stress along z (MPa)")
        axis.set_ylim(bottom=0.0)
        if axis.get_legend_handles_labels()[0]:
            axis.legend()


def pair_of_axes(width: float = 8.4, height: float = 3.5):  # type: ignore[no-untyped-def]
    """With friction on the left, without on the right."""
    figure, axes = new(width, height, 2)
    for axis, (_, title) in zip(axes, TITLES, strict=True):
        axis.set_title(title)
    return figure, axes


@styled
def figure_13(runs: Runs) -> Picture:
    """From .58."""
    figure, axes = new(8.4, 3.5, 2)
    for k, friction in enumerate(SWEEP):
        found = runs.of("13", "from .58", friction) or runs.of("friction", "13", friction)
        draw(axes[0], found, COLOURS[k], f"{friction:g}")
    for k, (name, label) in enumerate((("compacted, at rest", "at rest"), ("compacted, in motion", "in motion"))):
        draw(axes[1], runs.of("13", name, SMOOTH), COLOURS[k], label)
    axes[0].axvline(7.0, color=GREY, lw=0.8, ls=":")
    axes[0].set_title("from a fraction of .58")
    axes[1].set_title("from the last state without stress, no friction")
    finish(axes)
    axes[0].set_yscale("log")
    axes[0].set_ylim(1e-4, 10.0)
    axes[0].legend(title="friction", alignment="left")
    caption = (
        "Fig. 13 again: PVDF spheres dropped and rolled, compressed by 10 % (logarithmic), and, as in the paper, by 1 % from the "
        "last state without stress. Dotted: where the paper's stress begins. Bands are all packings."
    )
    return Picture("figure_13", figure, caption)


@styled
def figure_14(runs: Runs) -> Picture:
    """Routines."""
    figure, axes = pair_of_axes()
    names = (
        ("HSD, at rest, BCT", "HSD at rest", "-", 3.0),
        ("HSD, in motion, BCT", "HSD in motion, BCT", "--", 1.3),
        ("HSD, in motion, BC", "HSD in motion, BC", ":", 1.8),
        ("MZ in 10 s, at rest, BCT", "MZ in 10 s, at rest", "-", 3.0),
        ("MZ in 10 s, in motion, BCT", "MZ in 10 s, in motion, BCT", "--", 1.3),
    )
    for axis, (friction, _) in zip(axes, TITLES, strict=True):
        for k, (name, label, style, width) in enumerate(names):
            draw(axis, runs.of("14", name, friction), COLOURS[k], label, style, width)
    finish(axes)
    caption = (
        "Fig. 14 again: NMC at about .635 compressed by 1 %. Lines are means over packings, bands all packings. With friction the three "
        "lines of HSD lie on each other, and so do the two of MZ."
    )
    return Picture("figure_14", figure, caption)


@styled
def figure_15(runs: Runs) -> Picture:
    """Rates."""
    figure, axes = pair_of_axes()
    for axis, (friction, _) in zip(axes, TITLES, strict=True):
        for kind in ("E_soft", "E_stiff"):
            draw(axis, runs.of("15", kind, friction), GREY, "limits" if kind == "E_soft" else "")
        for k, time in enumerate(TIMES):
            found = runs.of("15", rated(time), friction)
            if found:
                grid = np.linspace(0.0, 0.005, 101)
                mean = MEGA * np.mean([[r.at(x) for x in grid] for r in found], axis=0)
                axis.plot(100.0 * grid, mean, "--", color=COLOURS[k], label=f"in {time:g} s")
    finish(axes)
    caption = (
        "Fig. 15 again: PVDF by 0.5 % in different times, means over packings; the two limits with their bands in grey. Packings differ by "
        "more than the rate does; what the rate does to each is in the next figure."
    )
    return Picture("figure_15", figure, caption)


@styled
def figure_shares(runs: Runs) -> Picture:
    """What a rate leaves of the overstress."""
    figure, axis = new(5.6, 3.4)
    for k, (friction, title) in enumerate(TITLES):
        found = [(time, share) for time in TIMES if (share := left(runs, time, friction)).packings]
        if not found:
            continue
        mean = np.array([share.mean for _, share in found])
        spread = np.array([[share.mean - share.least, share.most - share.mean] for _, share in found]).T
        at = np.array([time for time, _ in found]) * (1.0 + 0.06 * k)
        axis.errorbar(at, mean, spread, fmt="os"[k], ms=4, capsize=3, lw=1.0, color=COLOURS[k], label=title)
    times = np.geomspace(TIMES[0], TIMES[-1], 40)
    axis.plot(times, [pair_share(time) for time in times], color="black", lw=1.0, label="two spheres")
    for value in (0.0, 1.0):
        axis.axhline(value, color=GREY, lw=0.8, ls=":")
    axis.set(xscale="log", xlabel="loading time (s)", ylabel="share of the overstress left at 0.5 %")
    axis.legend()
    caption = (
        "Fig. 15 in one number: stress of MZ above the slow limit over what lies between both limits, each packing by itself; bars are all "
        "packings. Dotted: the limits. Without friction a packing may give way at another strain than in the limits."
    )
    return Picture("shares", figure, caption)


@styled
def figure_16(runs: Runs) -> Picture:
    """Relaxation."""
    figure, axes = new(8.4, 3.5, 2)
    names = (("MZ, at rest", "at rest", "-"), ("MZ, in motion", "in motion", "--"), ("MZ, in motion, fast", "in motion, fast", ":"))
    for k, (name, label, style) in enumerate(names):
        found = runs.of("16", name, RUBBING)
        if not found:
            continue
        values = MEGA * np.array([r.stress for r in found])
        axes[0].fill_between(found[0].time, values.min(axis=0), values.max(axis=0), color=COLOURS[k], alpha=0.15, lw=0)
        axes[0].plot(found[0].time, values.mean(axis=0), style, color=COLOURS[k], label=label)
        pairs = runs.pairs("16", name, "E_soft", RUBBING)
        for number, (own, soft) in enumerate(pairs):
            late = own.time >= 1.0
            over = 100.0 * (own.stress[late] / soft.at(0.003) - 1.0)
            axes[1].plot(own.time[late], over, style, color=COLOURS[k], lw=0.9, label=label if number == 0 else "")
    axes[0].axhline(MEGA * PAPER_STRESS, color=GREY, lw=0.8, ls=":")
    finish(axes, "time (s)")
    axes[1].set_ylabel("stress over the long-term one, less 1 (%)")
    axes[1].set_ylim(-5.0, 10.0)
    for value in (0.0, -3.0):
        axes[1].axhline(value, color=GREY, lw=0.8, ls=":")
    caption = (
        f"Fig. 16 again, friction {RUBBING:g}: 0.3 % in 1 s, held for 9 s. Left bands over packings, dotted the paper's .0127 MPa; right "
        "each packing over its own long-term stress, dotted 0 and the paper's −3 %. Fast: inertial number 1e-3."
    )
    return Picture("figure_16", figure, caption)


@styled
def figure_density(runs: Runs) -> Picture:
    """Density scaling."""
    figure, axes = pair_of_axes()
    for axis, (friction, _) in zip(axes, TITLES, strict=True):
        draw(axis, runs.of("density", "at rest", friction), "black", "at rest", width=3.0)
        names = sorted({r.name for r in runs.all if r.figure == "density" and r.name != "at rest"}, key=float, reverse=True)
        for k, name in enumerate(names):
            found = runs.of("density", name, friction)
            if found:
                draw(axis, found, COLOURS[k], f"masses × {power(found[0].density_scaling)}", "--")
    finish(axes)
    caption = "One packing of PVDF by 0.5 % in 1 s, MZ, with masses scaled to inertial numbers of 1e-2 (most) to 1e-5 (least)."
    return Picture("density", figure, caption)


@styled
def figure_jamming(jammed: Sequence[Jammed], found: Sequence[Exponents]) -> Picture:
    """Powers at jamming."""
    figure, axes = new(8.4, 3.5, 2)
    for k, (own, powers) in enumerate(zip(jammed, found, strict=True)):
        distance = own.fraction - powers.fraction
        axes[0].loglog(distance, own.pressure * MEGA, ".", ms=3, color=COLOURS[k % len(COLOURS)])
        axes[1].loglog(distance, own.coordination - powers.isostatic, ".", ms=3, color=COLOURS[k % len(COLOURS)])
        label = "effective medium" if k == 0 else ""
        axes[0].loglog(distance, effective_medium(own, powers.fraction) * MEGA, "-", lw=0.8, color=GREY, label=label)
    x = np.array([5e-4, 1.5e-2])
    axes[0].loglog(x, 10.0 * x**1.5, "k--", lw=0.9, label="slope 1.5")
    axes[1].loglog(x, 4.0 * x**0.5, "k--", lw=0.9, label="slope 0.5")
    for axis, label in zip(axes, ("pressure (MPa)", "contacts above isostatic"), strict=True):
        axis.set_xlabel("packing fraction above jamming")
        axis.set_ylabel(label)
        axis.set_xlim(1e-4, 3e-2)
        axis.legend()
    axes[0].set_ylim(1e-5, 1.0)
    axes[1].set_ylim(0.01, 2.0)
    return Picture("jamming", figure, "Frictionless PVDF packings let go isotropically until they fall apart; each colour is a packing.")


def all_figures(runs: Runs, jammed: Sequence[Jammed], found: Sequence[Exponents]) -> list[Picture]:
    """In the order of the page."""
    return [
        *(draw_one(runs) for draw_one in (figure_13, figure_14, figure_15, figure_shares, figure_density, figure_16)),
        figure_jamming(jammed, found),
    ]
