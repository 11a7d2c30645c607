"""From the runs to one table of errors and costs, and the verdict on the levels of tolerance that the solver offers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cases.tradeoff.fe_runs import QUANTITIES, READINGS, differences
from cases.tradeoff.fe_settings import Plan
from fem.press import RESOLUTIONS, Resolution

Results = Sequence[Mapping[str, Any]]
#: order of convergence of the mean force, by which what the finest mesh leaves is judged (see `fem.readout`)
ORDER = 1.4
#: a cheaper choice is named if it saves more than this; times of the same run scatter by about as much
WORTHWHILE = 0.15


class Row(NamedTuple):
    """One quantity of one run, read in one way, against the finest run of the same body."""

    modulus_over_yield_stress: float
    poissons_ratio: float
    depth: float  # largest overlap over the radius
    group: str
    setting: str
    divisions: int
    first: float
    growth: float
    force_drop: float
    elements: int
    reading: str
    quantity: str
    error: float  # mean along the loading, or over the unloadings; relative, of the exponent absolute
    largest_error: float
    cpu_seconds: float  # of the mesh or the two meshes that the reading needs
    cost: float  # the same in `level_costs`
    iterations: int
    finest: str


class Summary(NamedTuple):
    """One choice over all bodies of a plan: the worst of their errors, the mean of their costs."""

    group: str
    setting: str
    resolution: Resolution
    reading: str
    quantity: str
    error: float
    cost: float  # CPU seconds


class Choice(NamedTuple):
    """A mesh with its steps, over all depths that it was measured at: the worst mean force, the mean cost."""

    name: str
    resolution: Resolution
    error: float
    cost: float  # CPU seconds


class Verdict(NamedTuple):
    """What the measurement says about one level of tolerance."""

    tolerance: float
    resolution: Resolution
    own: Choice | None  # None: not coarser than the finest mesh here, so it cannot be judged by that
    cheapest: Choice | None  # of all that keep the tolerance at every depth; None: none does

    @property
    def words(self) -> str:
        """For people."""
        if self.own is None:
            return "not measured: as fine as the finest run here (raise --finest)"
        if self.own.error > self.tolerance:
            better = "none measured here does" if self.cheapest is None else f"{_described(self.cheapest)} does"
            return f"broken: off by {100 * self.own.error:.2g} %; {better}"
        if self.cheapest is not None and self.cheapest.cost < (1.0 - WORTHWHILE) * self.own.cost:
            return f"kept ({100 * self.own.error:.2g} %), but {_described(self.cheapest)} keeps it too"
        return f"kept ({100 * self.own.error:.2g} %), and nothing measured here keeps it for clearly less"


def _described(choice: Choice) -> str:
    divisions, steps = choice.resolution
    return (
        f"{divisions} divisions with steps {steps.first:.3g}, {steps.growth:.3g}, {steps.force_drop:.3g} "
        f"({100 * choice.error:.2g} %, {choice.cost:.3g} CPU s)"
    )


def rows(plan: Plan, results: Results) -> Iterator[Row]:
    """All errors of a plan's runs, whose results are in the order of `plan.everything`."""
    pairs = list(zip(plan.everything, results, strict=True))
    reference = {body: found["readings"] for (body, setting), found in pairs if setting == plan.finest and not found["stopped"]}
    seconds = level_costs(results)
    for (body, setting), found in pairs:
        if setting == plan.finest or found["stopped"] or body not in reference:
            continue
        divisions, steps = setting.resolution
        coarse, fine = found["meshes"]
        for reading in READINGS:
            used = (coarse, fine) if reading == "two meshes" else (fine,)
            for quantity, (mean, largest) in differences(found["readings"][reading], reference[body]["two meshes"]).items():
                yield Row(
                    modulus_over_yield_stress=body.modulus_over_yield_stress,
                    poissons_ratio=body.poissons_ratio,
                    depth=plan.depth,
                    group=setting.group,
                    setting=setting.name,
                    divisions=divisions,
                    first=steps.first,
                    growth=steps.growth,
                    force_drop=steps.force_drop,
                    elements=fine["elements"],
                    reading=reading,
                    quantity=quantity,
                    error=mean,
                    largest_error=largest,
                    cpu_seconds=sum(mesh["cpu_seconds"] for mesh in used),
                    cost=sum(mesh["iterations"] * seconds[mesh["divisions"]] for mesh in used),
                    iterations=fine["iterations"],
                    finest=plan.finest.name,
                )


def level_costs(results: Results) -> dict[int, float]:
    """CPU seconds of a Newton iteration on each mesh, by its divisions: the least of all runs on it.

    All do the same work in an iteration, so that this is what it costs when nothing else disturbs; seconds as measured vary with what
    else the machine does by more than the choices differ.
    """
    seconds: dict[int, float] = {}
    for found in results:
        for mesh in found["meshes"]:
            each = mesh["cpu_seconds"] / max(mesh["iterations"], 1)
            seconds[mesh["divisions"]] = min(each, seconds.get(mesh["divisions"], each))
    return seconds


def failures(plan: Plan, results: Results) -> list[dict[str, str]]:
    """Runs that did not come to their end."""
    pairs = zip(plan.everything, results, strict=True)
    return [{"task": f"{body.name}; {setting.name}", "reason": found["stopped"]} for (body, setting), found in pairs if found["stopped"]]


def summaries(plan: Plan, found: Iterable[Row]) -> list[Summary]:
    """Over the bodies of a plan; a choice that failed for one of them is left out."""
    kept: dict[tuple[str, str, str], list[Row]] = {}
    for row in found:
        if row.depth == plan.depth:
            kept.setdefault((row.setting, row.reading, row.quantity), []).append(row)
    resolutions = {setting.name: setting.resolution for setting in plan.settings}
    return [
        Summary(
            group=own[0].group,
            setting=setting,
            resolution=resolutions[setting],
            reading=reading,
            quantity=quantity,
            error=max(row.error for row in own),
            cost=float(np.mean([row.cost for row in own])),
        )
        for (setting, reading, quantity), own in kept.items()
        if len(own) == len(plan.programmes)
    ]


def verdicts(found: Sequence[Sequence[Summary]]) -> list[Verdict]:
    """For each level of tolerance its error in the mean force and its cost, and the cheapest of all choices that keep it.

    found: the summaries of each depth; only what was measured at every depth is a choice.
    """
    choices = _choices(found)
    result = []
    for tolerance, resolution in RESOLUTIONS:
        good = [choice for choice in choices.values() if choice.error <= tolerance]
        cheapest = min(good, key=lambda choice: choice.cost, default=None)
        result.append(Verdict(tolerance, resolution, choices.get(resolution), cheapest))
    return result


def _choices(found: Sequence[Sequence[Summary]]) -> dict[Resolution, Choice]:
    kept: dict[Resolution, list[Summary]] = {}
    for depth in found:
        for one in depth:
            if one.reading == "two meshes" and one.quantity == "force":
                kept.setdefault(one.resolution, []).append(one)
    return {
        resolution: Choice(own[0].setting, resolution, max(one.error for one in own), float(np.mean([one.cost for one in own])))
        for resolution, own in kept.items()
        if len(own) == len(found)
    }


def uncertainty(plan: Plan, results: Results) -> dict[str, float]:
    """What may still be wrong with the finest runs themselves, by quantity, the worst of the bodies.

    The second finest mesh differs from the finest by the first's error less the second's; these are as the sizes of their elements to the
    power `ORDER`.
    """
    second = max((setting for setting in plan.settings), key=lambda setting: setting.resolution.divisions)
    left = 1.0 / ((plan.finest.resolution.divisions / second.resolution.divisions) ** ORDER - 1.0)
    worst = dict.fromkeys(QUANTITIES, 0.0)
    for row in rows(plan, results):
        if row.setting == second.name and row.reading == "two meshes":
            worst[row.quantity] = max(worst[row.quantity], left * row.error)
    return worst
