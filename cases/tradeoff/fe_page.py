"""The page of the continuum solver's trade: pictures, tables, and what they say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from cases.report import plots
from cases.report.parts import figures, table, text
from cases.tradeoff.elements import Measured
from cases.tradeoff.fe_errors import Summary, Verdict
from cases.tradeoff.fe_runs import QUANTITIES
from cases.tradeoff.fe_settings import USUAL, Plan
from cases.tradeoff.locking import Locked
from cases.tradeoff.pareto import MARKERS, Panel, Point, draw

Block = dict[str, Any]
NAMES = {
    "force": "force",
    "contact_radius": "contact radius",
    "unloading_stiffness": "unloading stiffness ρ",
    "unloading_exponent": "exponent α (absolute, 1 % is 0.01)",
    "recovered_energy": "recovered energy",
}
#: how a reading is called in pictures
READING_NAMES = {"raw": "one mesh, force as it is", "one mesh": "one mesh, smooth", "two meshes": "two meshes, extrapolated"}


class Depth(NamedTuple):
    """What was found down to one depth."""

    plan: Plan
    summaries: Sequence[Summary]
    uncertainty: dict[str, float]


def sections(
    depths: Sequence[Depth],
    verdicts: Sequence[Verdict],
    steps: tuple[Plan, Sequence[Summary]],
    elements: Sequence[Measured],
    locked: Sequence[Locked],
) -> Iterator[dict[str, Any]]:
    """Title and blocks of each section."""
    yield {"title": "Levels of tolerance", "blocks": list(_levels(verdicts, depths))}
    for depth in depths:
        yield {"title": f"Mesh, steps and smoothing, to an overlap of {depth.plan.depth:g} R", "blocks": list(_depth(depth))}
    yield {"title": "Steps alone", "blocks": list(_steps(*steps))}
    yield {"title": "Element", "blocks": list(_elements(elements, locked))}


def _levels(verdicts: Sequence[Verdict], depths: Sequence[Depth]) -> Iterator[Block]:
    places = " and ".join(f"{depth.plan.depth:g} R" for depth in depths)
    yield text(
        f"What --tolerance promises is the mean force. Each level of the solver, with the worst of all bodies and depths ({places}), and "
        "the cheapest choice of mesh and steps measured here that keeps the same tolerance. Cost: mean CPU seconds of a curve."
    )
    rows = []
    for verdict in verdicts:
        own = verdict.own
        measured = ("–", "–") if own is None else (percent(own.error), f"{own.cost:.3g}")
        rows.append((f"{100 * verdict.tolerance:g} %", str(verdict.resolution.divisions), *measured, verdict.words))
    yield table(("level", "divisions", "mean force off by", "CPU s", "verdict"), rows)


def _depth(depth: Depth) -> Iterator[Block]:
    plan = depth.plan
    bodies = "; ".join(f"E/Y {body.modulus_over_yield_stress:g}, ν {body.poissons_ratio:g}" for body in plan.programmes)
    starts = ", ".join(f"{start:g}" for start in plan.programmes[0].unload_from)
    yield text(
        f"Bodies: {bodies}; unloaded from {starts} R. Error: the worst of the bodies of the mean along the loading (from a fifth of the "
        f"largest overlap on) or over the unloadings, against {plan.finest.name}, two meshes. Points are named by the divisions of their "
        "mesh; a line joins what no other point beats."
    )
    yield figures((picture(depth), "Error over cost in each quantity; the grey line is the frontier."))
    floor = ", ".join(f"{NAMES[name]} {percent(value)}" for name, value in depth.uncertainty.items())
    yield text(
        f"The finest run itself may be off by ({floor}), judged by the second finest: errors near these are not resolved.", note=True
    )
    yield from _readings(depth)
    yield _all(depth.summaries)


def _readings(depth: Depth) -> Iterator[Block]:
    """What smoothing and the second mesh bring, and cost, on one mesh."""
    named = {(one.setting, one.reading, one.quantity): one for one in depth.summaries}
    meshes = [setting.name for setting in depth.plan.settings if (setting.name, "raw", "force") in named and setting.group == USUAL]
    rows = []
    for mesh in meshes:
        for reading, words in READING_NAMES.items():
            values = [percent(named[mesh, reading, name].error, absolute=name == "unloading_exponent") for name in QUANTITIES]
            rows.append(
                (
                    f"{named[mesh, reading, 'force'].resolution.divisions} divisions, {words}",
                    f"{named[mesh, reading, 'force'].cost:.3g}",
                    *values,
                )
            )
    if rows:
        yield table(("smoothing", "CPU s", *(NAMES[name] for name in QUANTITIES)), rows)


def _all(found: Sequence[Summary]) -> Block:
    """Every choice of mesh and steps, as the solver reads it."""
    named = {(one.setting, one.quantity): one for one in found if one.reading == "two meshes"}
    rows = []
    for setting in dict.fromkeys(one.setting for one in found):
        one = named[setting, "force"]
        divisions, steps = one.resolution
        values = [percent(named[setting, name].error, absolute=name == "unloading_exponent") for name in QUANTITIES]
        rows.append((setting, str(divisions), f"{steps.first:.3g}, {steps.growth:.3g}, {steps.force_drop:.3g}", f"{one.cost:.3g}", *values))
    return table(
        ("choice, two meshes", "divisions", "steps: first, growth, force drop", "CPU s", *(NAMES[name] for name in QUANTITIES)), rows
    )


def _steps(plan: Plan, found: Sequence[Summary]) -> Iterator[Block]:
    yield text(
        f"On one mesh ({plan.finest.resolution.divisions} divisions), one knob at a time, against all three a quarter as long: "
        "what the steps alone are answerable for. First: the first step after a landing, over the expected interval; growth: of the "
        "following ones; force drop: share of the force that an unloading step takes off."
    )
    yield _all(found)


def _elements(elements: Sequence[Measured], locked: Sequence[Locked]) -> Iterator[Block]:
    yield text(
        "Elastic contact at small strain against Hertz's force, on the solver's own family of meshes. At ν = 0.3 biquadratic elements are "
        "the better ones for the same unknowns. At ν = 0.4999 full integration locks, and the bilinear element with mean dilatation hardly "
        "notices; plastic flow keeps its volume too, whatever Poisson's ratio."
    )
    yield figures((elements_picture(elements), "Mean of |F/F_Hertz − 1| over twice the contact radius, by unknowns and by CPU time."))
    header = ("element", "ν", "divisions", "unknowns", "CPU s", "force", "ripple")
    yield table(
        header,
        [
            (
                e.element,
                f"{e.poissons_ratio:g}",
                str(e.divisions),
                str(e.unknowns),
                f"{e.cpu_seconds:.2g}",
                percent(e.error),
                percent(e.ripple),
            )
            for e in elements
        ],
    )
    yield text(
        "The same in plastic flow: the solver's element, with the dilatation of each Gauss point on its own (full integration) or its mean "
        "over the element: force of a single mesh against what the finest two with mean dilatation extrapolate to."
    )
    yield table(
        ("material", "divisions", "full integration", "mean dilatation"),
        [
            (
                f"E/Y {one.modulus_over_yield_stress:g}, ν {one.poissons_ratio:g}",
                str(one.divisions),
                f"{100 * one.full_integration:+.2f} %",
                f"{100 * one.mean_dilatation:+.2f} %",
            )
            for one in locked
        ],
    )


def percent(value: float, absolute: bool = False) -> str:
    """Two digits; an exponent's error is no share of anything.

    >>> percent(0.01234), percent(0.0123, absolute=True), percent(12.3)
    ('1.2 %', '0.012', '1200 %')
    """
    if absolute:
        return f"{value:.2g}"
    return f"{100 * value:.0f} %" if value >= 1.0 and value < 10.0 else f"{float(f'{100 * value:.2g}'):g} %"


def picture(depth: Depth) -> Figure:
    """The five quantities."""
    panels = [Panel(NAMES[name], list(_points(depth.summaries, name))) for name in QUANTITIES]
    return draw(panels, "CPU seconds of a curve")


def _points(found: Sequence[Summary], quantity: str) -> Iterator[Point]:
    for one in found:
        if one.quantity != quantity:
            continue
        if one.reading == "two meshes":
            group = {USUAL: READING_NAMES["two meshes"], "mesh, long steps": "two meshes, long steps"}.get(one.group, one.group)
            yield Point(one.setting, group, one.cost, one.error)
        elif one.group == USUAL:
            yield Point(one.setting, READING_NAMES[one.reading], one.cost, one.error)


@plots.styled
def elements_picture(elements: Sequence[Measured]) -> Figure:
    """Error over unknowns and over CPU seconds, a row for each Poisson's ratio."""
    ratios = sorted({one.poissons_ratio for one in elements})
    figure = Figure(figsize=(8.6, 2.9 * len(ratios)), layout="constrained")
    axes = figure.subplots(len(ratios), 2, squeeze=False, sharey="row")
    for row, nu in zip(axes, ratios, strict=True):
        for number, name in enumerate(dict.fromkeys(one.element for one in elements)):
            own = [one for one in elements if one.element == name and one.poissons_ratio == nu]
            error, style = [one.error for one in own], {"color": plots.COLOURS[number], "marker": MARKERS[number], "ms": 4.0, "lw": 1.0}
            row[0].plot([one.unknowns for one in own], error, label=name, **style)
            row[1].plot([one.cpu_seconds for one in own], error, label=name, **style)
        row[0].set(xlabel="unknowns", ylabel="error in force", title=f"ν = {nu:g}")
        row[1].set(xlabel="CPU seconds")
        for axis in row:
            axis.set(xscale="log", yscale="log")
            axis.yaxis.set_major_formatter(lambda value, _: percent(value))
            axis.grid(True, which="major", color="#ececec", lw=0.6)
    axes[0, 0].legend(loc="lower left")
    return figure
