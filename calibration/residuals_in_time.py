"""How a law differs from curves in time: `calibration.residuals.Measures`, along the time where those go along the overlap."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from calibration.contact_history import path_of
from calibration.residuals import Measures
from contactlaws.curve import Curve
from contactlaws.path import trace

FloatArray = npt.NDArray[np.float64]
Triple = tuple[FloatArray, FloatArray, FloatArray]

#: what a release of fewer rows is like cannot be said
FEWEST = 3


def measures_in_time(law: object, curves: Sequence[Curve]) -> Measures:
    """Over all curves: force and contact radius are integrals of the absolute difference over the time, over those of the quantity.

    Unloadings are all stretches in which the contact shrinks: root mean square over the time of the difference of F, over F at the start.
    What is read at the separation of a body that forgets nothing is None.
    """
    force, radius, unloadings = [], [], []
    for curve in curves:
        path = path_of(curve)
        found, time = trace(law, path.overlap, path.time), path.time[path.rows]
        force.append((time, path.force, found.force[path.rows]))
        if curve.contact_radius is not None:
            radius.append((time, curve.contact_radius[path.own], found.contact_radius[path.rows]))
        unloadings += list(_unloadings(time, path.force, found.force[path.rows], curve.branch[path.own]))
    unloading = float(np.sqrt(np.mean(np.square(unloadings)))) if unloadings else None
    return Measures(_along(force), _along(radius) if radius else None, None, None, unloading, None)


def _along(triples: Sequence[Triple]) -> float:
    return float(
        sum(np.trapezoid(abs(law - curve), time) for time, curve, law in triples)
        / sum(np.trapezoid(abs(curve), time) for time, curve, _ in triples)
    )


def _unloadings(time: FloatArray, measured: FloatArray, found: FloatArray, branch: npt.NDArray[np.int64]) -> Iterator[float]:
    for number in range(1, int(branch.max()) + 1, 2):
        rows = branch == number
        start = max(0, int(np.argmax(rows)) - 1)
        if np.count_nonzero(rows) >= FEWEST and measured[start] > 0.0:
            square = np.trapezoid((found[rows] - measured[rows]) ** 2, time[rows]) / np.ptp(time[rows])
            yield float(np.sqrt(square)) / float(measured[start])
