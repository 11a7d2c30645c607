"""Analytic results that computed ones are shown beside; never used to compute anything."""

from __future__ import annotations

import math

from contactlaws.elastoplastic import Thornton, thornton_energy, thornton_yield_overlap


def thornton_restitution(speed_ratio: float) -> float:
    """Coefficient of restitution at `speed_ratio` = V/V_Y, closing speed over that of first yield (Thornton 1997).

    >>> [round(thornton_restitution(ratio), 5) for ratio in (0.5, 1.5, 2, 10, 1000)]
    [1.0, 0.97124, 0.93063, 0.65856, 0.2107]
    """
    if speed_ratio <= 1.0:
        return 1.0
    r = 1.0 / speed_ratio
    return math.sqrt(6.0 * math.sqrt(3.0) / 5.0 * (1.0 - r * r / 6.0)) * (r / (r + 2.0 * math.sqrt(1.2 - r * r / 5.0))) ** 0.25


def yield_speed(law: Thornton, radius: float, density: float) -> float:
    """Closing speed in m/s at which two equal spheres first yield; it does not depend on their radius.

    >>> round(yield_speed(Thornton(5e-6, 151.47e9, 12.64e9), 5e-6, 4750.0), 1)
    35.5
    """
    scale = radius / law.radius
    overlap = thornton_yield_overlap(law)
    stored, _ = thornton_energy(law, overlap, (overlap,))
    reduced_mass = 0.5 * density * 4.0 / 3.0 * math.pi * radius**3
    return math.sqrt(2.0 * 2.0 * scale**3 * stored / reduced_mass)
