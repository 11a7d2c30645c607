"""How wrong the forces of curves in time may be: as the curves state it, or as their scatter shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.optimize import nnls

from calibration.contact_history import Path
from calibration.residuals import Block, error_product
from contactlaws.curve import Curve

FloatArray = npt.NDArray[np.float64]

#: a curve states its error relative to the largest force so far, and that counts from this part of the largest force of all on
SMALLEST = 0.01
#: no stated error is smaller
LEAST = 1e-3
#: no scatter counts for less, over the largest force: by so much the law itself misses finite elements (up to 0.02 radii, Poisson's ratio
#: constant), and no term shall be made of that
TRUEST = 5e-4
#: rounds until the two parts of a scatter stay as they are
ROUNDS = 8
#: e-folds of the time or the overlap that are told apart at a path's beginning
EARLIEST = 1e-4


def all_state_errors(curves: Sequence[Curve]) -> bool:
    """Whether each of them says how wrong its force is."""
    return all("force" in curve.errors for curve in curves)


def stated(curve: Curve, path: Path) -> FloatArray:
    """One standard error in N of each force, by what the curve says.

    It is relative to the largest force so far: when the contact shrinks, what is wrong does not shrink with the force.
    """
    largest = np.maximum.accumulate(path.force)
    return np.asarray(max(curve.errors["force"], LEAST) * np.maximum(largest, SMALLEST * largest[-1]))


def scatter(differences: FloatArray, force: FloatArray) -> tuple[FloatArray, tuple[float, float]]:
    """One standard error of each force, and its two parts: one in N that all rows have, and one relative to the force.

    differences: of a law that fits, in N; force: that law's, in N. The squares are a line in the square of the force; their own scatter is
    in proportion to what is expected of them: so that is the weight.
    """
    line = np.column_stack((np.ones(force.size), force**2))
    # chance leaves some squares near zero, and no row may weigh more than a hundred times the others for that
    mean = float(np.mean(differences**2))
    least = max((TRUEST * float(abs(force).max())) ** 2, 1e-4 * mean)
    expected = np.full(force.size, max(mean, least))
    size = np.linalg.norm(line, axis=0)
    parts = np.zeros(2)
    for _ in range(ROUNDS):
        weighted = line / expected[:, None]
        parts = nnls(weighted / size, differences**2 / expected)[0] / size
        expected = np.maximum(line @ parts, least)
    return np.sqrt(expected), (float(np.sqrt(parts[0])), float(np.sqrt(parts[1])))


def inherited(paths: Sequence[Path], directions: FloatArray) -> FloatArray:
    """A^T C A with C the covariance of the rows of all paths in units of their stated errors, as `calibration.residuals.error_product`."""
    blocks = [
        Block("force", number, 0, path.force, np.ones(path.force.size), np.ones(path.force.size), _place(path))
        for number, path in enumerate(paths)
    ]
    return error_product(blocks, directions)


def _place(path: Path) -> FloatArray:
    """How far along each row lies: in e-folds of the time or of the overlap, whichever changes more."""
    columns = (path.time[path.rows] - path.time[0], path.overlap[path.rows])
    steps = [abs(np.diff(np.log(np.maximum(column, EARLIEST * column.max())), prepend=0.0)) for column in columns]
    together = np.maximum(*steps)
    together[0] = 0.0
    return np.asarray(np.cumsum(together))
