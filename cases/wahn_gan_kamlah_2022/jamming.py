"""Where frictionless packings jam, and by which powers they stiffen."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from cases.wahn_gan_kamlah_2022.packing_runs import Jammed
from cases.wahn_gan_kamlah_2022.packings import FloatArray

#: distances from jamming that the slopes are taken over
NEAR, FAR = 5e-4, 1e-2
#: distance at which the effective medium is compared
MEDIUM_AT = 0.01


class Exponents(NamedTuple):
    """What one packing gives."""

    seed: int
    fraction: float  # at which it falls apart
    coordination: float  # z_J: of spheres that are held, where a straight line over (phi - phi_J)^1/2 meets jamming
    last: float  # z of the last state that carries pressure
    isostatic: float  # 6 - 4/N: 3 N - 3 motions apart from the box's own, and one contact more for a pressure
    contacts_exponent: float
    pressure_exponent: float
    over_medium: float  # pressure over the effective medium's


def exponents(jammed: Jammed, count: int) -> Exponents:
    """Jamming point and powers; the point lies between the last state with pressure and the first without."""
    fraction = jamming_fraction(jammed)
    distance = jammed.fraction - fraction
    held = count * float(jammed.held[-1])
    isostatic = 6.0 - 4.0 / held
    near = (distance > NEAR) & (distance < FAR)
    x = np.log(distance[near])
    own = float(np.polyfit(x, np.log(jammed.pressure[near]), 1)[0])
    at_jamming = float(np.polyfit(np.sqrt(distance[near]), jammed.coordination[near], 1)[1])
    above = jammed.coordination[near] - isostatic
    contacts = float(np.polyfit(x[above > 0.0], np.log(above[above > 0.0]), 1)[0])
    ratio = np.interp(MEDIUM_AT, distance[::-1], (jammed.pressure / effective_medium(jammed, fraction))[::-1])
    return Exponents(jammed.seed, fraction, at_jamming, float(jammed.coordination[-1]), isostatic, contacts, own, float(ratio))


def jamming_fraction(jammed: Jammed) -> float:
    """Between the first state without pressure and the last with it, where log p over log(phi - phi_J) is straightest."""
    low, high = jammed.falls_apart
    if low == 0.0:
        raise ValueError("the packing has not fallen apart: let it go further")

    def bend(fraction: float) -> float:
        rows = jammed.fraction - fraction < FAR
        x, y = np.log(jammed.fraction[rows] - fraction), np.log(jammed.pressure[rows])
        return float(np.polyfit(x, y, 1, full=True)[1][0])

    return float(minimize_scalar(bend, bounds=(low, high - 1e-3 * (high - low)), method="bounded").x)


def effective_medium(jammed: Jammed, fraction: float) -> FloatArray:
    """p = 2/(3 pi) phi z E* eps^1.5 in Pa, eps the linear strain from jamming and z that of the packing."""
    strain = 1.0 - (fraction / jammed.fraction) ** (1.0 / 3.0)
    contacts = jammed.coordination * jammed.held
    return np.asarray(2.0 / (3.0 * math.pi) * jammed.fraction * contacts * jammed.reduced_modulus * np.maximum(strain, 0.0) ** 1.5)
