"""The bands of stress against strain, and whose they are: a table, a picture, a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from cases.console import number, percent
from cases.report.parts import figures, table, text
from cases.report.plots import COLOURS, styled
from cases.uncertainty.runs import Runs
from cases.uncertainty.variance import LEVEL, PARTS, Parts

Block = dict[str, Any]

#: standard deviations to each side that hold 95 % of normal values
SIDES = 1.96
MEGA = 1e-6
#: below this part of the largest mean stress, shares are of round-off and of rattling; they are not drawn
WORTH = 0.01
WORDS = {"law": "the law's errors", "packing": "the packing", "rest": "both together"}


def rows(runs: Runs, parts: Parts) -> list[dict[str, Any]]:
    """One row per output: strain, mean stress, the band, and for each part its deviation and share with their intervals; SI units."""
    return [
        {
            "stage": int(runs.stage[k]),
            "strain": float(runs.strain[k]),
            "stress_Pa": float(parts.mean[k]),
            "stress_error_Pa": float(parts.mean_error[k]),
            "band_low_Pa": float(parts.mean[k] - SIDES * parts.whole[k]),
            "band_high_Pa": float(parts.mean[k] + SIDES * parts.whole[k]),
            **{key: value for place, name in enumerate(PARTS) for key, value in _part(parts, place, name, k).items()},
        }
        for k in range(runs.strain.size)
    ]


def _part(parts: Parts, place: int, name: str, k: int) -> dict[str, float | None]:
    share = [float(found[place, k]) for found in (parts.share, parts.share_low, parts.share_high)]
    return {
        f"{name}_deviation_Pa": float(parts.deviation[place, k]),
        f"{name}_deviation_low_Pa": float(np.sqrt(parts.low[place, k])),
        f"{name}_deviation_high_Pa": float(np.sqrt(parts.high[place, k])),
        **{f"{name}_share{end}": value if np.isfinite(value) else None for end, value in zip(("", "_low", "_high"), share, strict=True)},
    }


def sentences(runs: Runs, parts: Parts) -> Iterator[str]:
    """What was found, at the largest strain."""
    k = runs.peak
    mean = parts.mean[k]
    yield (
        f"at the largest strain, {percent(abs(runs.strain[k]))}: stress {mean * MEGA:.4g} MPa (standard error "
        f"{parts.mean_error[k] * MEGA:.2g}); one packing on one law as uncertain as the fitted one: "
        f"{(mean - SIDES * parts.whole[k]) * MEGA:.4g} to {(mean + SIDES * parts.whole[k]) * MEGA:.4g} MPa (95 %)"
    )
    for place, name in enumerate(PARTS):
        deviation, low, high = parts.deviation[place, k], np.sqrt(parts.low[place, k]), np.sqrt(parts.high[place, k])
        share = _share(parts, place, k)
        yield f"{WORDS[name]}: {percent(deviation / mean)} of the stress ({percent(low / mean)} to {percent(high / mean)}), {share}"


def _share(parts: Parts, place: int, k: int) -> str:
    found = [parts.share[place, k], parts.share_low[place, k], parts.share_high[place, k]]
    if not np.isfinite(found).all():
        return "nothing varies"
    return f"{100 * found[0]:.0f} % of the variance ({100 * found[1]:.0f} to {100 * found[2]:.0f})"


def sections(runs: Runs, parts: Parts, free: Mapping[str, tuple[float, float | None]]) -> Iterator[dict[str, Any]]:
    """Title and blocks of each section; free: value and standard error of each fitted parameter."""
    yield {"title": "Bands and shares", "blocks": list(_found(runs, parts))}
    yield {"title": "What was drawn", "blocks": list(_drawn(runs, free))}


def _found(runs: Runs, parts: Parts) -> Iterator[Block]:
    yield text("; ".join(sentences(runs, parts)) + ".")
    caption = (
        "Left: mean stress, where 95 % of packings on laws as uncertain as the fitted one lie (grey), and the same with the law's errors "
        f"or the packing alone. Right: the share of each in the variance, with its interval ({100 * LEVEL:.0f} %), where the stress is "
        f"above {percent(WORTH)} of its largest."
    )
    yield figures((picture(runs, parts), caption))
    yield text(
        f"{len(runs.laws)} laws on {len(runs.packings)} packings, each law on each: value = mean + law + packing + rest, with "
        "independent random effects. Estimates are unbiased and at least zero; intervals are those of normal effects. Few packings leave "
        "the interval of their share wide, whatever the number of laws, and the other way round. “Both together” is what a law changes on "
        "one packing and not on another, and the scatter of the scene itself.",
        note=True,
    )


def _drawn(runs: Runs, free: Mapping[str, tuple[float, float | None]]) -> Iterator[Block]:
    body = [(name, number(value), "none" if error is None else number(error, 2)) for name, (value, error) in free.items()]
    if body:
        yield table(("fitted parameter", "value", "standard error"), body)
    else:
        yield text("The law has no fitted parameter: all draws are the same, and the share of its errors is nil.")
    yield text(
        "Laws are drawn from the joint normal distribution of the fitted parameters (positive ones in the logarithm), with the errors that "
        "the fit states: those of the curves, widened where the law misses them. What no choice of parameters can mend is not in it.",
        note=True,
    )
    for words in runs.left_out:
        yield text(words, note=True)


@styled
def picture(runs: Runs, parts: Parts) -> Figure:
    """Bands on the left, shares on the right."""
    figure = Figure(figsize=(8.4, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    across = 100.0 * runs.strain
    for deviation, colour, label in (
        (parts.whole, "#8a8a8a", "both"),
        (parts.deviation[1], COLOURS[1], WORDS["packing"]),
        (parts.deviation[0], COLOURS[0], WORDS["law"]),
    ):
        low, high = (MEGA * (parts.mean + side * SIDES * deviation) for side in (-1.0, 1.0))
        for place, stage in enumerate(np.unique(runs.stage)):
            at = _of_stage(runs, int(stage))
            left.fill_between(across[at], low[at], high[at], color=colour, alpha=0.3, lw=0, label=None if place else label)
    left.plot(across, MEGA * parts.mean, color="black", label="mean")
    left.set_xlabel("strain (%)")
    left.set_ylabel("stress (MPa)")
    left.legend()
    _draw_shares(right, runs, parts)
    return figure


def _of_stage(runs: Runs, stage: int) -> Any:
    """Its outputs, and the last one before."""
    found = np.flatnonzero(runs.stage == stage)
    return np.concatenate((found[:1] - 1, found)) if found[0] else found


def _draw_shares(axis: Any, runs: Runs, parts: Parts) -> None:
    """Of the first stage, on which the strain grows."""
    first = np.flatnonzero(runs.stage == runs.stage[0])
    shown = first[parts.mean[first] > WORTH * parts.mean.max()]
    across = 100.0 * runs.strain[shown]
    for place, (name, colour) in enumerate(zip(PARTS, (COLOURS[0], COLOURS[1], COLOURS[2]), strict=True)):
        axis.fill_between(across, 100 * parts.share_low[place, shown], 100 * parts.share_high[place, shown], color=colour, alpha=0.18, lw=0)
        axis.plot(across, 100 * parts.share[place, shown], color=colour, label=WORDS[name])
    axis.set_ylim(0.0, 100.0)
    axis.set_xlabel("strain (%), loading")
    axis.set_ylabel("share of the variance (%)")
    axis.legend()
