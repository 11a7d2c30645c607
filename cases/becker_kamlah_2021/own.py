"""The place for this project's own law of ellipsoids beside the published one."""

from __future__ import annotations

from collections.abc import Callable

from contactlaws.curve import Curve, FloatArray

#: as figures and tables call it
NAME = "our law"
#: forces in N at the overlaps in m of a path, which begins untouched or at the largest overlap so far
Follow = Callable[[FloatArray], FloatArray]


def own_law(curve: Curve) -> Follow | None:
    """Our law of the body of a curve, from its shape and its material alone; None: there is no such law yet."""
    return None
