"""The page of the packings' trade: pictures, tables, and what they say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from matplotlib.figure import Figure

from cases.report.parts import figures, table, text
from cases.tradeoff.dem_errors import SEEDS, SIZE, SMALL_BESIDE, Row, Verdict, cost_of, packings_for, scatter
from cases.tradeoff.dem_runs import QUANTITIES, Results
from cases.tradeoff.dem_settings import DENSITY, FITTED_TO, FRICTION, MATERIAL, PACKING_FRACTION, RADIUS, STRAIN, USUAL, Plan, Setting
from cases.tradeoff.pareto import Panel, Point, draw

Block = dict[str, Any]
Table = tuple[Sequence[str], list[tuple[str, ...]]]
NAMES = {"peak": "stress at the largest strain", "loading": "mean stress while loading", "release": "mean stress while releasing"}
#: errors below are drawn at it: far below anything that counts
FLOOR = 1e-6


def sections(plan: Plan, results: Results, rows: Sequence[Row], found: Sequence[Verdict]) -> Iterator[dict[str, Any]]:
    """Title and blocks of each section."""
    yield {"title": "Which error matters", "blocks": list(_matters(plan, results, found))}
    yield {"title": "Error over cost", "blocks": list(_pictures(rows))}
    yield {"title": "All choices", "blocks": list(_all(plan, results, rows))}


def _matters(plan: Plan, results: Results, found: Sequence[Verdict]) -> Iterator[Block]:
    yield text(
        f"Random close packings at {PACKING_FRACTION:g} of spheres like those of NMC (R = {1e6 * RADIUS:g} µm, E = "
        f"{1e-9 * MATERIAL.youngs_modulus:g} GPa, ν = {MATERIAL.poissons_ratio:g}, "
        f"Y = {1e-9 * (MATERIAL.yield_stress or 0.0):g} GPa, "
        f"{DENSITY:g} kg/m³), compressed along one axis by {100 * STRAIN:g} % and released. The usual run: {USUAL.spheres} spheres, "
        f"the whole-range law fitted up to {FITTED_TO:g} R, friction {FRICTION:g} after Mindlin, inertial number "
        f"{USUAL.inertial_number:g}, {USUAL.time_step_fraction:g} of the critical time step, true density. One thing is changed at a time."
    )
    between, packings = scatter(plan, results), len([1 for setting, _ in results if setting == USUAL])
    shares = ", ".join(f"{NAMES[quantity]} {_percent(value)}" for quantity, value in between.items())
    yield text(
        f"One usual packing differs from another ({packings} packings, standard deviation over the mean) by: {shares}. An error is small "
        f"beside that if it is at most {SMALL_BESIDE:.2g} of it: the two together are then 5 % more than the scatter alone."
    )
    yield table(*verdicts_table(found))
    yield text(
        "Stress at the largest strain; the axes by the worst that their choices do. On the same packings the error is the root of the mean "
        "square over them; between packing sizes, where no two packings are the same, it is the bias. The last column says how many usual "
        "packings must be averaged before their scatter is down to the bias of the usual run.",
        note=True,
    )


def verdicts_table(found: Sequence[Verdict]) -> Table:
    """The axes, the most important first."""
    header = ("axis", "worst choice", "error", "over scatter", "usual error", "cheapest small", "packings")
    lines: list[tuple[str, ...]] = []
    for one in found:
        usual, cheapest = one.usual, one.cheapest
        needed = None if usual is None else packings_for(usual)
        lines.append(
            (
                one.axis,
                one.worst.choice,
                _percent(one.worst.own),
                f"{one.worst.own / one.worst.scatter:.2g}",
                "finest" if usual is None else _percent(usual.own),
                "only the finest" if cheapest is None else f"{cheapest.choice} ({cheapest.cpu_seconds:.2g} s)",
                "–" if needed is None else f"{needed}" if needed <= 1000 else "> 1000",
            )
        )
    return header, lines


def _pictures(rows: Sequence[Row]) -> Iterator[Block]:
    for quantity, name in NAMES.items():
        caption = (
            f"{name.capitalize()}: error of one run over its CPU seconds, a panel for each kind of choice, all on one scale. Dashed: the "
            "scatter between packings. A grey line joins what no other choice of the same kind beats."
        )
        if quantity != "loading":  # which looks like that of the largest strain
            yield figures((picture(rows, quantity), caption))


def picture(rows: Sequence[Row], quantity: str) -> Figure:
    """A panel for each axis."""
    own = [row for row in rows if row.quantity == quantity]
    panels = [
        Panel(axis, [_point(row) for row in own if row.axis == axis], next(row.scatter for row in own if row.axis == axis))
        for axis in dict.fromkeys(row.axis for row in own)
    ]
    return draw(panels, "CPU seconds", level="scatter between packings of the usual run", same_errors=True)


def _point(row: Row) -> Point:
    return Point(row.choice, "the usual run has it" if row.usual else "other choices", row.cpu_seconds, max(row.error, FLOOR))


def _all(plan: Plan, results: Results, rows: Sequence[Row]) -> Iterator[Block]:
    yield table(*choices_table(plan, results, rows))
    yield text(
        "Error: root of the mean square over the packings, against the finest choice of the same axis on the same packings (packing size: "
        "against the mean of the largest ones, so the scatter of a packing of that size is in it; number of packings: scatter of the usual "
        "run over the root of their number). Bias: the mean, with its standard error: what no number of packings averages away. CPU "
        "seconds: the least of the packings, one thread, compiled before. Density scaling is at the strain rate of the true density, and "
        "so the same as a larger inertial number.",
        note=True,
    )
    costs = ", ".join(
        f"{spheres} spheres {min(f['packing_cpu_seconds'] for (s, _), f in results.items() if s == Setting(spheres=spheres)):.2g} s"
        for spheres, _ in plan.sizes
    )
    yield text(f"The packings themselves cost on top (CPU seconds): {costs}.", note=True)


def choices_table(plan: Plan, results: Results, rows: Sequence[Row], quantities: Sequence[str] = QUANTITIES) -> Table:
    """Every choice: cost, then error and bias in each quantity; under each axis what it was measured against."""
    header = ("choice", "CPU s", *(word for quantity in quantities for word in (f"{quantity}: error", "bias")))
    named = {(row.axis, row.choice, row.quantity): row for row in rows}
    finest = {axis.name: axis.finest.setting for axis in plan.axes} | {SIZE: Setting(spheres=plan.sizes[-1][0])}
    lines: list[tuple[str, ...]] = []
    for axis in dict.fromkeys(row.axis for row in rows):
        own = [row for row in rows if row.axis == axis and row.quantity == QUANTITIES[0]]
        for row in own:
            there = [named[axis, row.choice, quantity] for quantity in quantities]
            cells = [cell for one in there for cell in (_percent(one.error), _bias(one))]
            lines.append((f"{axis}: {row.choice}{_marked(row.usual)}", f"{row.cpu_seconds:.2g}", *cells))
        if axis != SEEDS:
            seconds, dashes = cost_of(finest[axis], results)[0], ("–",) * 2 * len(quantities)
            lines.append((f"… against {own[0].reference}{_marked(finest[axis] == USUAL)}", f"{seconds:.2g}", *dashes))
    return header, lines


def _marked(usual: bool) -> str:
    return " (usual)" if usual else ""


def _percent(value: float) -> str:
    """Two digits.

    >>> _percent(0.01234), _percent(1e-9)
    ('1.2 %', '< 0.0001 %')
    """
    return "< 0.0001 %" if value < 1e-6 else f"{float(f'{100 * value:.2g}'):g} %"


def _bias(row: Row) -> str:
    if row.bias is None or row.bias_error is None:
        return "–"
    return f"{float(f'{100 * row.bias:.2g}'):+g} ± {float(f'{100 * row.bias_error:.1g}'):g} %" if abs(row.bias) >= 1e-6 else "0 %"
