"""The place for this project's own law of ellipsoids beside the published one."""

from __future__ import annotations

from contactlaws.curve import Curve, FloatArray

#: as figures and tables call it
NAME = "our law"


def own_law(curve: Curve) -> FloatArray | None:
    """Force in N that our law predicts at every row of a curve, from the body and the material alone; None: there is no such law yet."""
    return None
