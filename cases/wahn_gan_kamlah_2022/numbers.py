"""Every number of the two spheres, with what is expected and where that comes from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cases.wahn_gan_kamlah_2022.material import CONSTANT_BULK, OVERLAP, POISSON, RADIUS, TOGETHER
from contactlaws.dispatch import initial_state
from contactlaws.maxwell_zener import MaxwellZener, maxwell_zener
from contactlaws.pair import pair_force, pair_scale
from contactlaws.prony import Relaxation


class Number(NamedTuple):
    """One value held against another."""

    name: str
    value: float
    expected: float
    tolerance: float  # relative
    unit: str
    source: str

    @property
    def ok(self) -> bool:
        return abs(self.value - self.expected) <= self.tolerance * abs(self.expected)


def half_space(modulus: Relaxation | None = None) -> MaxwellZener:
    """The paper's law as it should read: Hertz's contact, constant Poisson's ratio."""
    return maxwell_zener(TOGETHER.reduced if modulus is None else modulus, RADIUS)


def pair_at(law: MaxwellZener, ramp: float, hold: float = 0.0, steps: int = 1000) -> float:
    """Force in N of two spheres at the strain, reached in `ramp` s and held for `hold` s; by the pair kernel, step after step."""
    scale, state, force = pair_scale(law, RADIUS, RADIUS), initial_state(law), 0.0
    for number in range(1, steps + 1):
        force, state = pair_force(law, scale, 2.0 * OVERLAP * number / steps, 2.0 * OVERLAP / ramp, ramp / steps, state)
    if hold > 0.0:
        force, state = pair_force(law, scale, 2.0 * OVERLAP, 0.0, hold, state)
    return float(force)


def numbers() -> Iterator[Number]:
    """All of them."""
    law = half_space()
    at_once, in_the_end = pair_at(law, 1e-9), pair_at(law, 1e9)
    yield Number("force at 2 % strain, infinitely slow", in_the_end, 1.5822e-4, 1e-4, "N", "Hertz with E_soft (Fig. 9)")
    yield Number("force at 2 % strain, infinitely fast", at_once, 2.0509e-4, 1e-4, "N", "Hertz with E_stiff (Fig. 9)")
    yield Number("force at the end of a ramp of 1 s", pair_at(law, 1.0), 1.9615e-4, 1e-4, "N", "Lee & Radok (Fig. 10)")
    late = pair_at(law, 1.0, 6.5) / in_the_end - 1.0
    yield Number("excess over the long-term force at 7.5 s", 100.0 * late, 0.65, 0.01, "%", "Lee & Radok (Fig. 10, “constant from 7.5 s”)")
    for ramp, expected in ((0.01, 0.99778), (0.1, 0.9781), (1.0, 0.8091), (10.0, 0.2424), (100.0, 0.02675)):
        left = (pair_at(law, ramp, steps=4000) - in_the_end) / (at_once - in_the_end)
        yield Number(f"overstress left after a ramp of {ramp:g} s", left, expected, 3e-4, "-", "Lee & Radok, closed form (rates of Fig. 9)")
    shear = CONSTANT_BULK.shear
    yield Number("K", CONSTANT_BULK.bulk.instantaneous / 1e6, 4301.5, 1e-4, "MPa", "Eq. 4.4")
    yield Number("G_0", shear.instantaneous / 1e6, 618.45, 1e-4, "MPa", "Eq. 4.3 corrected (paper: 617.5)")
    yield Number("g_1", shear.fractions[0], 0.2369, 3e-4, "-", "Eq. 4.2, K constant (paper: 0.237)")
    yield Number("tau_1", shear.times[0], 1.7805, 1e-4, "s", "Eq. 4.5 corrected, K constant (paper: 1.78)")
    yield Number("g_1 = k_1, nu constant", TOGETHER.shear_fractions[0], 0.2285, 3e-4, "-", "consistent with a constant Poisson's ratio")
    mixed = 1770.5 * (1.0 - shear.fractions[0])
    yield Number("E_soft that k_1 = g_1 = .2369 leads to", mixed, 1350.9, 3e-4, "MPa", "in place of 1365.9 MPa: 1.1 % too soft")
    yield Number("nu in the end, K constant", CONSTANT_BULK.long_term.poissons_ratio, 0.44708, 1e-3, "-", "3 K (1 - 2 nu) = E_soft")
    assert np.isclose(CONSTANT_BULK.poissons_ratio, POISSON)
