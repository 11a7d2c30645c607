"""Why the dilatation is a mean over the element: with every Gauss point on its own, plastic flow, which keeps its volume, is hindered.

The solver's own compiled element does both: a cell is replaced by four, each of which has one of its Gauss points four times, with a
quarter of its volume each. The mean dilatation of such a cell is that of its one point: full integration. (It costs four times the work of
the element, so that times are not compared.) Force of one mesh at a time: extrapolation would hide what it is about.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases.tradeoff.fe_runs import FROM_SHARE, PLACES
from cases.tradeoff.fe_settings import usual
from contactlaws.material import Material
from fem.assembly import Discretisation, discretise
from fem.compose import rows_with
from fem.mesh import FloatArray, spheroid
from fem.press import core_size, moduli_of
from fem.readout import WORK_SHARE, extrapolate, loading
from fem.walk import walk

#: E/Y and Poisson's ratio
MATERIALS = ((100.0, 0.45), (1000.0, 0.3))
LARGEST = 0.1
DIVISIONS = (4, 8)  # each twice the one before
POINTS = 4  # Gauss points of a cell


class Locked(NamedTuple):
    """How far the force is too high on one mesh."""

    modulus_over_yield_stress: float
    poissons_ratio: float
    divisions: int
    full_integration: float  # mean over the loading of F over that of the solver's element, extrapolated from its two finest meshes, less 1
    mean_dilatation: float  # the same of the solver's element on this mesh alone


def fully_integrated(body: Discretisation) -> Discretisation:
    """The same body, each Gauss point with its own dilatation."""

    def alone(values: FloatArray) -> FloatArray:
        """From (cells, points, ...) to (cells x points, points, ...)."""
        return np.ascontiguousarray(np.repeat(values.reshape(-1, 1, *values.shape[2:]), POINTS, axis=1))

    return body._replace(
        cells=np.repeat(body.cells, POINTS, axis=0),
        gradients=alone(body.gradients),
        hoops=alone(body.hoops),
        volumes=alone(body.volumes) / POINTS,
        places=alone(body.places),
        slots=np.repeat(body.slots, POINTS, axis=0),
    )


def force(material: Material, divisions: int, full: bool) -> FloatArray:
    """Smooth force of one mesh at overlaps from a fifth of `LARGEST` on, over the yield stress times R squared."""
    core = core_size(LARGEST, LARGEST)
    body = discretise(spheroid(divisions, core))
    run = walk(fully_integrated(body) if full else body, moduli_of(material), LARGEST, (), usual())
    return loading(run, np.geomspace(FROM_SHARE * LARGEST, LARGEST, PLACES), rows_with(run, divisions // 2 + 1)).force


def measure(ratio: float, nu: float) -> list[Locked]:
    """Both elements on all meshes, for one material."""
    material = Material(ratio, nu, 1.0)
    plain, full = ({divisions: force(material, divisions, way) for divisions in DIVISIONS} for way in (False, True))
    *_, coarse, fine = plain.values()
    limit = extrapolate(fine, coarse, WORK_SHARE)
    return [
        Locked(ratio, nu, divisions, *(float((way[divisions] / limit - 1.0).mean()) for way in (full, plain))) for divisions in DIVISIONS
    ]
