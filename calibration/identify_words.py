"""What a measured curve tells and what it does not, in plain sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from calibration.identify_data import FloatArray, Measured
from calibration.identify_search import Interval

#: an interval whose ends differ by more than this factor determines its parameter hardly
WIDE = 2.0
#: correlation beyond which two unknowns are called not told apart
TOGETHER = 0.99
#: rms difference over noise (the atlas's error included) beyond which the model itself is in doubt
MISFIT = 1.3
WORDS = {
    "youngs_modulus": "Young's modulus",
    "yield_stress": "the yield stress",
    "poissons_ratio": "Poisson's ratio",
    "zero": "the zero of the overlap",
    "compliance": "the machine's compliance",
}
UNITS = {"youngs_modulus": "Pa", "yield_stress": "Pa", "poissons_ratio": "", "zero": "m", "compliance": "m/N"}


def statements(
    measured: Measured, intervals: Mapping[str, Interval], names: Sequence[str], correlation: FloatArray, misfit: float, yielded: bool
) -> Iterator[str]:
    """One sentence for each thing that must be known before the numbers are used."""
    for name in names:
        yield from _about(name, intervals[name])
    if not yielded:
        yield "nothing in the curve is beyond first yield: it is elastic as far as it goes"
    if not measured.unloadings:
        yield "there is no unloading in the curve: it is from unloading that Young's modulus of a body that has yielded is known best"
    for i, one in enumerate(names):
        for j in range(i):
            if abs(correlation[i, j]) > TOGETHER:
                yield f"{WORDS[names[j]]} and {WORDS[one]} cannot be told apart by this curve (correlation {correlation[i, j]:+.4f})"
    if misfit > MISFIT:
        yield (
            f"no elastic-perfectly plastic sphere of the atlas follows the curve within its noise: {misfit:.2g} times that is left; "
            "the intervals do not contain what the model itself misses"
        )


def _about(name: str, found: Interval) -> Iterator[str]:
    word, unit = WORDS[name], UNITS[name]
    if found.low is None and found.high is None:
        yield f"{word} is not determined by this curve"
    elif found.high is None:
        yield f"{word} is bounded from below only: at least {found.low:.4g} {unit}".rstrip()
    elif found.low is None:
        yield f"{word} is bounded from above only, within the atlas's E/Y: at most {found.high:.4g} {unit}".rstrip()
    elif name in ("youngs_modulus", "yield_stress") and found.high > WIDE * found.low:
        yield f"{word} is known to within a factor of {math.sqrt(found.high / found.low):.2g} only"


def correlation_of(jacobian: FloatArray, names: Sequence[str]) -> FloatArray:
    """Correlation of E, Y and the others (logarithms of the first two) from the derivatives with respect to ln E, ln E/Y and the others."""
    to_vector = np.eye(len(names))
    to_vector[1, :2] = (1.0, -1.0)  # ln E/Y = ln E - ln Y
    rows = jacobian @ to_vector
    length = np.linalg.norm(rows, axis=0)
    covariance = np.linalg.pinv((rows / np.where(length > 0.0, length, 1.0)).T @ (rows / np.where(length > 0.0, length, 1.0)), rcond=1e-14)
    spread = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return np.asarray(covariance / np.outer(spread, spread))
