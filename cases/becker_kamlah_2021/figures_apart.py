"""Beyond the paper: the causes of the law's error, each apart, by shape."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from cases.becker_kamlah_2021 import own
from cases.becker_kamlah_2021.apart import Loaded, Unloaded
from cases.becker_kamlah_2021.data import REACH, Body, Study
from cases.becker_kamlah_2021.figures_shape import RELATIVE
from cases.edmans_sinka_2020.drawing import GREY, Picture, beside, colour_of_depth, new_figure, panel_titles, styled
from cases.report.plots import COLOURS


def pictures(study: Study, loading: Sequence[Loaded], unloading: Sequence[Unloaded]) -> list[Picture]:
    """What can be drawn."""
    drawn = [
        Picture(None, "Finite bodies are no half-spaces", elastic(study), CAPTION_ELASTIC),
        Picture(None, "Overlap that is left", residuals(unloading), CAPTION_RESIDUAL),
        Picture(None, "Errors of the law", errors(loading, unloading), CAPTION_ERRORS),
        Picture(None, "Contact larger than Hertz", areas(study.nmc, unloading), CAPTION_AREAS),
    ]
    return drawn


CAPTION_ELASTIC = (
    "Force over Hertz's of the undeformed pole. Lines: bodies that never yield, by finite elements (ν as named); dots: NMC, to first yield "
    "of finite elements. A sharp body is softer than Hertz's half-space, a blunt one far stiffer: this is elasticity of a body of finite "
    "size, not plasticity. The published law has Hertz's force up to δ_Y."
)
CAPTION_RESIDUAL = (
    "Overlap left after unloading over the largest one, NMC. Left against the largest overlap, right against the shape at 15 %: finite "
    "elements (dots), Eqs. 34, 44 (lines) and our law (dotted on the left)."
)
CAPTION_ERRORS = (
    "Mean difference of the published law's force, over the largest force, NMC. Left: along the loading to 15 %, with the constants of "
    "Eq. 54; the same with the body's own elastic force up to δ_Y; and with constants read from each body. Right: along unloadings from "
    "the overlaps named (over the mean radius), most of which is the shape of the unloading and not the force it begins with; dotted: our "
    "law."
)
CAPTION_AREAS = (
    "Left: contact area over that of Eq. 9 along the loading, NMC, with the contact radius of the undeformed curvature; right: area "
    "that the published law has just after it begins to unload, over that of finite elements, which do not jump."
)


def _colour(body: Body) -> str:
    names = dict(zip((0.5, 2.0**-0.5, 1.0, 2.0**0.5, 2.0), COLOURS, strict=False))
    return next((colour for aspect, colour in names.items() if abs(aspect - body.aspect) < 1e-6), GREY)


@styled
def elastic(study: Study) -> Figure:
    """F/F_Hertz against the overlap over the mean radius."""
    keys = [key for key in study.elastic if key[1] in (0.0, 0.3, 0.45)] or study.elastic
    figure, axes = new_figure(9.4, 3.6, 1, max(1, len(keys)), sharey=True, squeeze=False)
    for axis, key in zip(axes[0], keys, strict=False):
        for body in study.of(key):
            if _colour(body) is not GREY:
                axis.plot(body.overlap / body.mean_radius, body.force / body.hertz(body.overlap), color=_colour(body), label=body.name)
        axis.set(title=rf"$\nu$ = {key[1]:g}")
    for axis in axes[0]:
        axis.axhline(1.0, color=GREY, lw=0.7, ls=":")
        axis.set(xlabel=r"overlap $\delta/r$", xlim=(0.0, 0.1), ylim=(0.85, 2.0))
        for body in study.nmc:
            early = body.overlap <= (body.curve.yield_overlap or 0.0)
            if _colour(body) is not GREY:
                overlap = body.overlap[early]
                axis.plot(
                    overlap / body.mean_radius,
                    body.force[early] / body.hertz(overlap),
                    "o",
                    ms=2.0,
                    color=_colour(body),
                    label=None if keys else body.name,
                )
    axes[0, 0].set_ylabel(r"$F/F_{Hertz}$")
    beside(figure, axes[0, 0], "shape a:b")
    return figure


@styled
def residuals(rows: Sequence[Unloaded]) -> Figure:
    """delta_p/delta_*."""
    figure, axes = new_figure(8.8, 3.6, 1, 2, sharey=True)
    for colour, name in zip(COLOURS, ("1:0.5", "1:0.707", "1:1", "1:1.41", "1:2"), strict=False):
        there = [row for row in rows if row.name == name]
        axes[0].plot([row.depth for row in there], [row.residual for row in there], "o", ms=3.4, color=colour, label=name)
        axes[0].plot([row.depth for row in there], [row.published for row in there], color=colour)
        if there and there[0].own_residual is not None:
            axes[0].plot([row.depth for row in there], [row.own_residual for row in there], ":", color=colour)
    deep = [row for row in rows if abs(row.depth - REACH) < 1e-6]
    axes[1].plot([row.relative for row in deep], [row.residual for row in deep], "o", ms=4.0, color="black", label="finite elements")
    axes[1].plot([row.relative for row in deep], [row.published for row in deep], "o-", ms=2.5, color=COLOURS[1], label="Eqs. 34, 44")
    if deep and deep[0].own_residual is not None:
        axes[1].plot([row.relative for row in deep], [row.own_residual for row in deep], "s-", ms=2.5, color=COLOURS[2], label=own.NAME)
    axes[0].set(xlabel=r"largest overlap $\delta_*/r$", ylabel=r"overlap left $\delta_p/\delta_*$", ylim=(0.0, 0.85), xlim=(0.0, None))
    axes[1].set(xlabel=RELATIVE)
    axes[0].legend(title="shape a:b", loc="upper left", fontsize=6.5, ncols=2)
    axes[1].legend(loc="lower right")
    panel_titles(axes, ("by depth", r"at $\delta_*$ = 0.15 r"))
    return figure


@styled
def errors(loading: Sequence[Loaded], unloading: Sequence[Unloaded]) -> Figure:
    """Loading and unloading apart."""
    figure, axes = new_figure(8.8, 3.6, 1, 2, width_ratios=(1.0, 1.15))
    relative = [row.relative for row in loading]
    kinds = (
        ("error", COLOURS[1], "Eq. 54"),
        ("elastic_right", COLOURS[4], "elastic part right"),
        ("refitted", COLOURS[0], "read from the body"),
        ("own", COLOURS[2], own.NAME),
    )
    for name, colour, label in kinds:
        values = [getattr(row, name) for row in loading]
        if None not in values:
            axes[0].plot(relative, [100.0 * value for value in values], "o-", ms=3.2, color=colour, label=label)
    for depth in sorted({round(row.depth, 4) for row in unloading}):
        there = [row for row in unloading if round(row.depth, 4) == depth]
        line = {"color": colour_of_depth(2.0 * depth), "ms": 3.0}
        axes[1].plot([row.relative for row in there], [100.0 * row.error for row in there], "o-", label=f"{depth:g}", **line)
        if there[0].own is not None:
            axes[1].plot([row.relative for row in there], [100.0 * (row.own or 0.0) for row in there], "s:", **line)
    for axis, title in zip(axes, ("loading", "unloading"), strict=True):
        axis.set(xlabel=RELATIVE, ylabel="mean difference of force (%)", title=title, ylim=(0.0, None))
    axes[0].legend()
    axes[1].legend(title=r"from $\delta_*/r$", fontsize=7.0)
    return figure


@styled
def areas(bodies: Sequence[Body], unloading: Sequence[Unloaded]) -> Figure:
    """Area of contact."""
    figure, axes = new_figure(8.8, 3.6, 1, 2)
    for body in bodies:
        if _colour(body) is not GREY:
            area = body.contact_radius**2 / (body.radius * body.overlap)
            axes[0].plot(body.overlap / body.mean_radius, area, color=_colour(body), label=body.name)
            there = [row for row in unloading if row.name == body.name]
            axes[1].plot([row.depth for row in there], [row.area for row in there], "o-", ms=3.0, color=_colour(body))
    for axis in axes:
        axis.axhline(1.0, color=GREY, lw=0.7, ls=":")
    axes[0].set(xlabel=r"overlap $\delta/r$", ylabel=r"$a^2/(R\,\delta)$, finite elements", xlim=(0.0, REACH), ylim=(0.8, None))
    axes[1].set(xlabel=r"largest overlap $\delta_*/r$", ylabel="area of the law as it unloads, over\nfinite elements", xlim=(0.0, None))
    axes[0].legend(title="shape a:b", loc="lower right")
    return figure
