"""From the runs to one table: what each choice changes on the same packings, beside what the choice of packing changes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cases.tradeoff.dem_runs import QUANTITIES, Results
from cases.tradeoff.dem_settings import USUAL, Axis, Plan, Setting

FloatArray = npt.NDArray[np.float64]

SIZE, SEEDS = "packing size", "number of packings"
#: an error of this share of the scatter makes the two together 5 % larger than the scatter alone
SMALL_BESIDE = 1.0 / 3.0


class Row(NamedTuple):
    """One quantity of one choice; errors relative to the reference."""

    axis: str
    choice: str
    spheres: int
    packings: int  # runs behind the numbers
    quantity: str
    error: float  # root of the mean square over the packings: what one run, or one mean, is off by
    bias: float | None  # mean, signed: what stays however many packings are averaged; None: no such thing
    bias_error: float | None  # standard error of the bias
    scatter: float  # standard deviation of one usual run between packings, over their mean
    cpu_seconds: float  # of a run: the least of the packings; the packing itself not counted
    steps: int  # or iterations of the quasi-static routine
    usual: bool  # what the usual run has
    reference: str  # what the error is measured against

    @property
    def own(self) -> float:
        """The error that is the choice's own: on the same packings all of it; between sizes, whose packings differ, only the bias."""
        return abs(self.bias) if self.axis == SIZE and self.bias is not None else self.error

    @property
    def small(self) -> bool:
        """Whether users may forget it beside the scatter of one packing."""
        return self.own <= SMALL_BESIDE * self.scatter


def rows(plan: Plan, results: Results) -> list[Row]:
    """All errors; a choice that stopped on some packing is left out, and an axis whose finest did."""
    return [row for axis in plan.axes for row in _model_rows(axis, plan, results)] + [
        *_size_rows(plan, results),
        *_seed_rows(plan, results),
    ]


def scatter(plan: Plan, results: Results) -> dict[str, float]:
    """Standard deviation between packings of the usual run over its mean, of each quantity."""
    return {quantity: float(x.std(ddof=1) / x.mean()) for quantity in QUANTITIES for x in (_of(USUAL, quantity, results),)}


def failures(results: Results) -> list[dict[str, str]]:
    """Runs that did not come to their end."""
    stopped = ((setting, seed, found["stopped"]) for (setting, seed), found in results.items() if found["stopped"])
    return [{"task": f"{setting}, packing {seed}", "reason": reason} for setting, seed, reason in stopped]


def _of(setting: Setting, quantity: str, results: Results, seeds: Sequence[int] | None = None) -> FloatArray:
    """Values on the packings of `seeds`, NaN where a run stopped; None: on all whose run did not."""
    own = [seed for (other, seed), found in results.items() if other == setting and not found["stopped"]] if seeds is None else seeds
    return np.array([results[setting, seed].get(quantity, math.nan) for seed in own])


def cost_of(setting: Setting, results: Results) -> tuple[float, int]:
    """Least CPU seconds and steps: of all packings the one that the rest of the machine disturbed least."""
    own = [(found["cpu_seconds"], found["steps"]) for (other, _), found in results.items() if other == setting]
    return min(own)


def _model_rows(axis: Axis, plan: Plan, results: Results) -> Iterator[Row]:
    between = scatter(plan, results)
    for choice in axis.choices:
        seconds, steps = cost_of(choice.setting, results)
        for quantity in QUANTITIES:
            own, finest = (_of(one.setting, quantity, results, plan.seeds) for one in (choice, axis.finest))
            difference = own / finest - 1.0
            if np.isfinite(difference).all():
                yield Row(
                    axis=axis.name,
                    choice=choice.name,
                    spheres=choice.setting.spheres,
                    packings=len(own),
                    quantity=quantity,
                    error=float(np.sqrt(np.mean(difference**2))),
                    bias=float(difference.mean()),
                    bias_error=float(difference.std(ddof=1) / math.sqrt(len(own))),
                    scatter=between[quantity],
                    cpu_seconds=seconds,
                    steps=steps,
                    usual=choice.setting == USUAL,
                    reference=axis.finest.name,
                )


def _size_rows(plan: Plan, results: Results) -> Iterator[Row]:
    """One packing of so many spheres against the mean of the largest ones."""
    between, largest = scatter(plan, results), Setting(spheres=plan.sizes[-1][0])
    for spheres, _ in plan.sizes[:-1]:
        setting = Setting(spheres=spheres)
        seconds, steps = cost_of(setting, results)
        for quantity in QUANTITIES:
            finest = _of(largest, quantity, results)
            own = _of(setting, quantity, results) / finest.mean()
            left = math.hypot(own.std(ddof=1) / math.sqrt(len(own)), finest.std(ddof=1) / finest.mean() / math.sqrt(len(finest)))
            yield Row(
                axis=SIZE,
                choice=f"{spheres} spheres",
                spheres=spheres,
                packings=len(own),
                quantity=quantity,
                error=float(np.sqrt(np.mean((own - 1.0) ** 2))),
                bias=float(own.mean() - 1.0),
                bias_error=left,
                scatter=between[quantity],
                cpu_seconds=seconds,
                steps=steps,
                usual=setting == USUAL,
                reference=f"mean of {len(finest)} packings of {largest.spheres}",
            )


def _seed_rows(plan: Plan, results: Results) -> Iterator[Row]:
    """The mean of several packings against that of all there could be: packings are independent, so the scatter over the root."""
    between = scatter(plan, results)
    seconds, steps = cost_of(USUAL, results)
    for count in plan.means:
        for quantity in QUANTITIES:
            yield Row(
                axis=SEEDS,
                choice=f"mean of {count}" if count > 1 else "one packing",
                spheres=USUAL.spheres,
                packings=len(_of(USUAL, quantity, results)),
                quantity=quantity,
                error=between[quantity] / math.sqrt(count),
                bias=None,
                bias_error=None,
                scatter=between[quantity],
                cpu_seconds=count * seconds,
                steps=count * steps,
                usual=count == 1,
                reference="mean of all packings of this size",
            )


class Verdict(NamedTuple):
    """One axis in one quantity."""

    axis: str
    usual: Row | None  # None: the usual run has the finest, or is not on the axis
    worst: Row
    cheapest: Row | None  # whose error is small beside the scatter; None: no choice's is, and only the finest will do


def verdicts(found: Sequence[Row], quantity: str = QUANTITIES[0]) -> list[Verdict]:
    """What matters: the axes of the model by the worst that they can do, largest first."""
    own = [row for row in found if row.quantity == quantity and row.axis != SEEDS]
    result = []
    for axis in dict.fromkeys(row.axis for row in own):
        there = [row for row in own if row.axis == axis]
        small = [row for row in there if row.small]
        usual = next((row for row in there if row.usual), None)
        worst = max(there, key=lambda row: row.own)
        result.append(Verdict(axis, usual, worst, min(small, key=lambda row: row.cpu_seconds, default=None)))
    return sorted(result, key=lambda one: -one.worst.own)


def packings_for(row: Row) -> int | None:
    """How many packings to average until their scatter is no more than the bias of this choice; None without a bias."""
    return None if not row.bias else max(1, math.ceil((row.scatter / row.bias) ** 2))
