"""The constants of `contactlaws.contact_ellipse.fast_factors`: rational functions through Hertz's exact integrals.

    python -m calibration.contact_ellipse_fit

Least squares with weights that grow where the error is large, which ends near the smallest possible largest error.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from contactlaws.contact_ellipse import FAST_UP_TO, exact_factors

FloatArray = npt.NDArray[np.float64]

ROUNDS = 40


def fraction(constants: FloatArray, z: FloatArray) -> FloatArray:
    """z (-2/9 + c0 z + c1 z^2)/(1 + c2 z + c3 z^2), z = tanh(ln(B/A)/4)^2: the first term makes it -(ln B/A)^2/72 around a circle."""
    c0, c1, c2, c3 = constants
    return np.asarray(z * (-2.0 / 9.0 + z * (c0 + z * c1)) / (1.0 + z * (c2 + z * c3)))


def fit(error: Callable[[FloatArray], FloatArray], start: FloatArray) -> tuple[FloatArray, float]:
    """Constants and the largest error."""
    weights, best, least = np.ones_like(error(start)), start, np.inf
    found = start
    for _ in range(ROUNDS):

        def weighted(constants: FloatArray, weights: FloatArray = weights) -> FloatArray:
            return error(constants) * np.sqrt(weights)

        found = least_squares(weighted, found, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=5000).x
        size = np.abs(error(found))
        if size.max() < least:
            best, least = found, float(size.max())
        weights = weights * (np.sqrt(size / size.max()) + 0.01)
        weights = weights / weights.mean()
    return best, least


def main() -> None:
    """Fit and print."""
    ratios = np.exp(np.linspace(0.0, np.log(1.05 * FAST_UP_TO), 1500)[1:])
    exact = np.array([exact_factors(float(ratio)) for ratio in ratios])
    x = np.log(ratios)
    z, start = np.tanh(0.25 * x) ** 2, np.array([0.1, -0.05, -0.5, 0.01])
    for name, column in (("f1", 0), ("f2", 1)):
        found, error = fit(lambda p, column=column: fraction(p, z) / exact[:, column] + 1.0 / exact[:, column] - 1.0, start)  # type: ignore[misc]
        print(name, [float(f"{value:.7g}") for value in found], f"largest error {error:.2g}")

    def of_axes(p: FloatArray) -> FloatArray:
        y = x * x
        power = (2.0 / 3.0 + y * (p[0] + y * p[1])) / (1.0 + y * (p[2] + y * p[3]))
        return np.asarray(-x * power - np.log(exact[:, 2]))

    found, error = fit(of_axes, np.array([0.042, 0.0004, 0.068, 0.0008]))
    print("b/a", [float(f"{value:.7g}") for value in found], f"largest error {error:.2g}")


if __name__ == "__main__":
    main()
