"""This project's own law of ellipsoids, which stands beside the published one in figures and tables."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contactlaws import shaped
from contactlaws.curve import Curve, FloatArray
from contactlaws.material import Material
from contactlaws.whole_range_ellipsoid import whole_range_ellipsoid

#: as figures and tables call it
NAME = "our law"
#: forces in N at the overlaps in m of a path, which begins untouched or at the largest overlap so far
Follow = Callable[[FloatArray], FloatArray]


def own_law(curve: Curve) -> Follow | None:
    """Our law of the body of a curve, from its shape and its material alone; None of an elastic body."""
    if curve.material is None or curve.material.yield_stress is None:
        return None
    return of_shape(curve.material, (curve.radius * curve.aspect**2, 1.0, curve.radius * curve.aspect ** (2.0 / 3.0)))


def of_shape(material: Material, shape: tuple[float, float, float]) -> Follow:
    """Our law of one body on the flat; shape as in `contactlaws.shaped`."""
    law = whole_range_ellipsoid(material)

    def follow(overlap: FloatArray) -> FloatArray:
        memory, found = shaped.untouched(law), []
        for value in overlap.tolist():
            force, memory = shaped.force(law, shape, value, memory)
            found.append(force)
        return np.array(found)

    return follow
