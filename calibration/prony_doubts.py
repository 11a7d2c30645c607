"""What a table, or curves, do not tell about the series that was fitted to them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from calibration.prony_record import SeriesFit
from calibration.trust import LARGEST_CORRELATION, LARGEST_RELATIVE_ERROR

#: a modulus that is further than this from its limit at an end of the window has not been seen to level off
LEVEL = 0.02
#: standard deviations of chi squared beyond which a misfit is no chance
NO_CHANCE = 3.0
#: of numbers that cannot be told apart only these are named
MOST_PAIRS = 4


def doubts(fit: SeriesFit) -> Iterator[str]:
    """One sentence for each."""
    if fit.terms < fit.asked:
        yield f"only {fit.terms} of the {fit.asked} terms asked for have a weight and a time of their own; the others are left out"
    if fit.terms == 0:
        low, high = fit.window
        yield f"no relaxation can be told from the noise between {low:.4g} and {high:.4g} s; what is faster or slower is not seen"
    yield from _unseen(fit)
    yield from _undetermined(fit)
    if fit.misfit**2 > 1.0 + NO_CHANCE * math.sqrt(2.0 / fit.freedom):
        yield f"the series misses the {fit.source} by {fit.misfit:.3g} times the noise: more terms, or a larger noise, would be true"


def _unseen(fit: SeriesFit) -> Iterator[str]:
    low, high = fit.window
    for name, time in zip(fit.names[1 + fit.terms :], fit.modulus.times, strict=True):
        if not low <= time <= high:
            yield f"{name} = {time:.4g} s lies outside the {low:.4g} to {high:.4g} s that the {fit.source} can see"
    modulus = fit.modulus
    early, late = modulus.at([low, high]).tolist()
    if late > (1.0 + LEVEL) * modulus.long_term:
        above = 100.0 * (late / modulus.long_term - 1.0)
        yield f"the modulus is not seen to level off: after {high:.4g} s it is {above:.3g} % above its long-term value, an extrapolation"
    if early < (1.0 - LEVEL) * modulus.instantaneous:
        below = 100.0 * (1.0 - early / modulus.instantaneous)
        yield f"the instantaneous modulus is an extrapolation: after {low:.4g} s {below:.3g} % of it are gone"


def _undetermined(fit: SeriesFit) -> Iterator[str]:
    errors = fit.standard_errors
    for name, value in zip(fit.names, fit.values, strict=True):
        if not errors[name] < LARGEST_RELATIVE_ERROR * value:
            yield f"{name} is hardly determined: {value:.4g} with a standard error of {errors[name]:.2g}"
    if not errors["long_term"] < LARGEST_RELATIVE_ERROR * fit.modulus.long_term:
        yield "the long-term modulus can hardly be told from zero: this may be a fluid, which is not covered"
    yield from _alike(fit)


def _alike(fit: SeriesFit) -> Iterator[str]:
    pairs = itertools.combinations(range(len(fit.names)), 2)
    close = sorted((-abs(fit.correlation[pair]), pair) for pair in pairs if abs(fit.correlation[pair]) > LARGEST_CORRELATION)
    for _, (i, j) in close[:MOST_PAIRS]:
        yield f"{fit.names[i]} and {fit.names[j]} cannot be told apart (correlation {fit.correlation[i, j]:+.4f})"
    if len(close) > MOST_PAIRS:
        yield f"so it is with {len(close) - MOST_PAIRS} more pairs: fewer terms would say as much"
