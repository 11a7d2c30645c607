"""What the paper prints: its closed forms, on arrays, and the numbers that it quotes. D is the overlap over the radius.

Eqs. 2-5 stand in `contactlaws.edmans_sinka` and are only called here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from contactlaws.edmans_sinka import FIRST_YIELD, PUBLISHED, EdmansSinka, first_yield, recovered_depth

FloatArray = npt.NDArray[np.float64]

MODULI = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)  # E/Y
POISSON = (0.0, 0.15, 0.3, 0.45)
DEPTHS = (0.01, 0.02, 0.03, 0.04, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
PERCENTILES = (50, 75, 90, 100)
#: relative errors of Eq. 3 at these percentiles (section 4.3), and the median R2 of the power law (section 4.2)
ERRORS_OF_EQUATION_3 = (0.0184, 0.0529, 0.1178, 0.3633)
MEDIAN_R2 = 0.999847
#: Fig. 2: an element's edge along the sphere, over the radius
ELEMENT_EDGE = np.radians(11.25 / 60.0)


@kernel
def _equation_3(modulus, poisson, depth, reading, gammas, stiffness, yield_depth):  # type: ignore[no-untyped-def]
    """Fill rho (Eqs. 3, 4) and D_c (Eq. 5) of bodies of radius 1 and yield stress 1."""
    k0, k1, power = reading
    g1, g2, g3, g4, g5 = gammas
    zero = 0.0
    for i in range(depth.size):
        nu = poisson[i]
        law = EdmansSinka(
            1.0, modulus[i] / (1.0 - nu * nu), nu, 1.0, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero,
            k0, k1, power, g1, g2, g3, g4, g5,
        )  # fmt: skip
        yield_depth[i] = first_yield(law)
        stiffness[i] = 1.0 / recovered_depth(law, depth[i], yield_depth[i])


def _both(modulus: Any, poisson: Any, depth: Any, reading: str, gammas: Sequence[float]) -> tuple[FloatArray, FloatArray]:
    columns = np.broadcast_arrays(*(np.asarray(value, dtype=np.float64) for value in (modulus, poisson, depth)))
    shape = columns[0].shape
    flat = [np.ascontiguousarray(column).ravel() for column in columns]
    stiffness, yield_depth = np.empty(flat[0].size), np.empty(flat[0].size)
    g1, g2, g3, g4, g5 = (float(gamma) for gamma in gammas)
    _equation_3(*flat, FIRST_YIELD[reading], (g1, g2, g3, g4, g5), stiffness, yield_depth)
    return stiffness.reshape(shape), yield_depth.reshape(shape)


def stiffness(modulus: Any, poisson: Any, depth: Any, reading: str = "corrected", gammas: Sequence[float] = PUBLISHED) -> FloatArray:
    """rho by Eqs. 3-5; `modulus` is E/Y, `reading` of Eq. 5 one of `contactlaws.edmans_sinka.FIRST_YIELD`.

    What the paper's constants give for E/Y = 5, nu = .3, D = .5:

    >>> [round(float(stiffness(5.0, 0.3, 0.5, reading)), 2) for reading in ("corrected", "unsquared")]
    [4.75, 8.81]
    """
    return _both(modulus, poisson, depth, reading, gammas)[0]


def yield_depth(modulus: Any, poisson: Any, reading: str = "corrected") -> FloatArray:
    """D_c by Eq. 5. The paper's .01/D_c = 366 for E/Y = 200, nu = .3 follows from the unsquared reading only:

    >>> [round(float(0.01 / yield_depth(200.0, 0.3, reading))) for reading in ("unsquared", "printed", "corrected")]
    [366, 84, 75]
    """
    return _both(modulus, poisson, 1.0, reading, PUBLISHED)[1]


def etsion_exponent(relative_depth: Any) -> FloatArray:
    """alpha by Eq. 6 (Etsion, Kligerman & Kadin 2005) from D/D_c."""
    return np.asarray(1.5 * np.asarray(relative_depth) ** -0.0331)


def etsion_stiffness(depth: Any, relative_depth: Any) -> FloatArray:
    """rho by Eq. 9 (Etsion, Kligerman & Kadin 2005) from D and D/D_c."""
    x = np.asarray(relative_depth)
    left = (1.0 - x**-0.28) * (1.0 - x**-0.69)
    return np.asarray(1.0 / ((1.0 - left) * np.asarray(depth)))


def mesarovic_johnson_force(retreat: Any) -> FloatArray:
    """F/F_max by Eq. 10 (Mesarovic & Johnson 2000) from a/a_max; as printed one of its a/a_max is a*.

    >>> float(mesarovic_johnson_force(1.0))
    1.0
    """
    a = np.clip(np.asarray(retreat, dtype=np.float64), 0.0, 1.0)
    return np.asarray(2.0 / np.pi * (np.arcsin(a) - a * np.sqrt(1.0 - a * a)))
