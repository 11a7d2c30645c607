"""The paper's model of concentric cylinders (section 5): as printed, and carried through correctly.

A half sphere is a bundle of elastic-perfectly plastic bars along the contact normal that slide freely past each other. With u = sqrt(1 -
r^2) for the bar at the distance r from the axis (over the radius), E the modulus over the yield stress and D the overlap over the radius,
a bar is in contact for u > 1 - D, and has yielded for u > u_p = E (1 - D_max)/(E - 1) (Eqs. 11-14).

The force of Eq. 19 is F_max - E (D_max^2 - D^2), forces over pi R^2 Y. The paper's Eq. 21 has F_max - E (D_max - D)^2 in its place, from
which follow its Eqs. 22, 23 and an exponent of 2. Moreover Eq. 19 lets bars that have come free pull. Without tension the last bar, the one
on the axis, leaves the flat when it has recovered its yield strain, so rho = E as soon as any bar has yielded.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def contact_radius(depth: Any) -> FloatArray:
    """Eq. 13: that of a truncated sphere."""
    d = np.asarray(depth, dtype=np.float64)
    return np.sqrt(d * (2.0 - d))


def _plastic_edge(modulus: float, largest: FloatArray | float) -> FloatArray:
    """u_p, Eq. 14; 1 where no bar has yielded."""
    if modulus <= 1.0:
        return np.ones_like(np.asarray(largest, dtype=np.float64))
    return np.minimum(1.0, modulus * (1.0 - np.asarray(largest)) / (modulus - 1.0))


def loading_force(modulus: float, depth: Any) -> FloatArray:
    """Eq. 17, over pi R^2 Y.

    >>> round(float(loading_force(10.0, 0.05)), 6), round(float(loading_force(10.0, 0.5)), 6)
    (0.025, 0.722222)
    """
    return unloading_force(modulus, depth, depth)


def unloading_force(modulus: float, largest: Any, depth: Any) -> FloatArray:
    """Force at `depth` after unloading from `largest`, no bar pulling; over pi R^2 Y."""
    d = np.asarray(depth, dtype=np.float64)
    edge = _plastic_edge(modulus, largest)
    recovered = modulus * (np.asarray(largest) - d)
    core = np.where(recovered < edge, 1.0 - edge**2 - 2.0 * recovered * (1.0 - edge), np.maximum(1.0 - recovered, 0.0) ** 2)
    core = np.where(edge < 1.0, core, 0.0)
    return np.asarray(core + modulus * np.maximum(edge - (1.0 - d), 0.0) ** 2)


def unloading_force_with_tension(modulus: float, largest: float, depth: Any) -> FloatArray:
    """Eq. 19, free bars pulling: F_max - E (D_max^2 - D^2); it holds while bars around the core touch, D > 1 - u_p."""
    d = np.asarray(depth, dtype=np.float64)
    return np.asarray(loading_force(modulus, largest) - modulus * (largest**2 - d**2))


def printed_unloading_force(modulus: float, largest: float, depth: Any) -> FloatArray:
    """Eq. 21, which does not follow from Eq. 19."""
    return np.asarray(loading_force(modulus, largest) - modulus * (largest - np.asarray(depth)) ** 2)


def printed_stiffness(modulus: float, depth: Any) -> FloatArray:
    """rho by Eqs. 22 and 23."""
    return np.asarray(np.sqrt(modulus / loading_force(modulus, depth)))


def stiffness_with_tension(modulus: float, depth: Any) -> FloatArray:
    """rho where the force of Eq. 19 vanishes."""
    d = np.asarray(depth, dtype=np.float64)
    left = np.sqrt(np.maximum(d**2 - loading_force(modulus, d) / modulus, 0.0))
    return np.asarray(1.0 / (d - left))


def stiffness(modulus: float, depth: Any) -> FloatArray:
    """rho without tension: the modulus once any bar has yielded (D > 1/E), 1/D before.

    >>> [float(stiffness(100.0, d)) for d in (0.005, 0.02, 0.5)]
    [200.0, 100.0, 100.0]
    """
    return np.asarray(1.0 / np.minimum(np.asarray(depth, dtype=np.float64), 1.0 / modulus))
