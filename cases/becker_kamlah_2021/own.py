"""This project's own law of ellipsoids, which stands beside the published one in figures and tables."""

from __future__ import annotations

from collections.abc import Callable

from contactlaws.curve import Curve, FloatArray
from contactlaws.ellipsoid_contact import on_flat

#: as figures and tables call it
NAME = "our law"
#: forces in N at the overlaps in m of a path, which begins untouched or at the largest overlap so far
Follow = Callable[[FloatArray], FloatArray]


def own_law(curve: Curve) -> Follow | None:
    """Our law of the body of a curve, from its shape and its material alone; None of an elastic body."""
    if curve.material is None or curve.material.yield_stress is None:
        return None
    across = curve.radius * curve.aspect
    contact = on_flat(curve.material, (curve.radius, across, across))
    return lambda overlap: contact.along(overlap).force
