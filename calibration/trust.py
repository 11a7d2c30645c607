"""How far a fit can be trusted: standard errors, correlation, what the curves do not say."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

#: two parameters closer correlated than this are reported as not told apart
LARGEST_CORRELATION = 0.99
#: beyond this condition number of the scaled Jacobian a combination of parameters is reported (Belsley, Kuh & Welsch 1980 call 30 strong)
LARGEST_CONDITION = 30.0
#: a positive parameter whose logarithm is known to no better than this is reported
LARGEST_RELATIVE_ERROR = 0.5
#: from this factor on there is no point in stating it
NOT_DETERMINED = 1e3


class Trust(NamedTuple):
    """Errors of the inner (transformed) parameters, in the order of the fit."""

    errors: FloatArray  # infinite where the curves say nothing
    correlation: FloatArray  # NaN in the rows of such parameters
    condition_number: float  # of the Jacobian with columns of unit length; infinite with such a parameter
    misfit: float  # root mean square of the residuals in units of the curves' own error, per independent datum
    weakest: FloatArray  # the combination of parameters, of unit length, that is known least


def trust(jacobian: FloatArray, residuals: FloatArray, error_product: Callable[[FloatArray], FloatArray], data: float) -> Trust:
    """Trust in a least-squares result whose residuals are in units of the curves' error, so that their squares sum to `data` at that error.

    The error of a curve is systematic: more rows do not make it smaller. `error_product` gives A^T C A for any A with a row for each
    residual (`calibration.residuals.error_product`), C being the covariance of the residuals. The parameters inherit (J^T J)^-1 J^T C J
    (J^T J)^-1, which is V S^-1 (U^T C U) S^-1 V^T with J = U S V^T: so written it loses no digits where two parameters are hardly told
    apart. Where the misfit exceeds the curves' error, the law and not the curve is the limit, and the errors are widened by that factor;
    they are never narrowed below the curves' error.
    """
    size = jacobian.shape[1]
    misfit = math.sqrt(float(residuals @ residuals) / data) if data > 0.0 else 0.0
    length = np.linalg.norm(jacobian, axis=0)
    alive = length > 1e-6
    errors, correlation = np.full(size, np.inf), np.full((size, size), np.nan)
    weakest = np.where(alive, 0.0, 1.0)
    if not alive.any():
        return Trust(errors, correlation, math.inf if size else 1.0, misfit, weakest)
    left, singular, directions = np.linalg.svd(jacobian[:, alive] / length[alive], full_matrices=False)
    singular = np.maximum(singular, 1e-14 * singular[0])
    inverse = directions.T / singular
    covariance = inverse @ error_product(left) @ inverse.T
    spread = np.sqrt(np.diag(covariance))
    errors[alive] = max(1.0, misfit) * spread / length[alive]
    correlation[np.ix_(alive, alive)] = covariance / np.outer(spread, spread)
    if alive.all():
        return Trust(errors, correlation, float(singular[0] / singular[-1]), misfit, directions[-1])
    return Trust(errors, correlation, math.inf, misfit, weakest / np.linalg.norm(weakest))


def doubts(found: Trust, names: Sequence[str], above: Sequence[float | None]) -> Iterator[str]:
    """One sentence for each thing that the curves do not tell; `above` as in `calibration.recipes.Parameter`."""
    for name, error, bound in zip(names, found.errors, above, strict=True):
        if not np.isfinite(error):
            yield f"{name} has no influence on these curves: it cannot be fitted to them"
        elif bound is not None and error > LARGEST_RELATIVE_ERROR:
            factor = math.exp(min(error, 700.0))  # the inner parameter is the logarithm of the distance from the bound
            what = f"{name} - {bound:g}" if bound else name
            yield f"{what} is known to within a factor of {factor:.3g} only" if factor < NOT_DETERMINED else f"{name} is not determined"
    for i, j in itertools.combinations(range(len(names)), 2):
        if abs(found.correlation[i, j]) > LARGEST_CORRELATION:
            yield f"{names[i]} and {names[j]} cannot be told apart (correlation {found.correlation[i, j]:+.4f})"
    if LARGEST_CONDITION < found.condition_number < math.inf:
        mixed = [name for name, part in zip(names, found.weakest, strict=True) if abs(part) > 0.2]
        yield f"a combination of {', '.join(mixed)} is hardly determined (condition number {found.condition_number:.3g})"
    if found.misfit > 1.0:
        yield f"the law, not the curves, limits the fit: it misses them by {found.misfit:.3g} times their own error"
