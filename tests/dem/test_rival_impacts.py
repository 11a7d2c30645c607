"""Published laws through the kernel that collides two spheres, against their closed forms."""

from __future__ import annotations

import math

import pytest

from contactlaws.rivals.becker_kamlah import PUBLISHED, BeckerKamlah
from dem.impact import restitution

RADIUS, DENSITY = 5e-6, 4750.0
REDUCED_MASS = 0.5 * DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3


@pytest.mark.compiled_only(reason="100 000 steps of a collision")
@pytest.mark.parametrize(("ratio", "expected"), [(2.0, 0.96379), (10.0, 0.72611)])
def test_becker_kamlahs_restitution(ratio: float, expected: float) -> None:
    """Equal NMC spheres, made a thousand times softer so that speeds are small; V_y as for Thornton's law with p_Y = 1.6 Y."""
    law = BeckerKamlah(RADIUS, 142e6 / (1.0 - 0.25**2), 7.9e6, **PUBLISHED)
    depth = (math.pi * 1.6 * law.yield_stress / (2.0 * law.reduced_modulus)) ** 2 * law.radius
    energy = 2.0 * 8.0 / 15.0 * law.reduced_modulus * math.sqrt(law.radius) * depth**2.5
    speed = ratio * math.sqrt(2.0 * energy / REDUCED_MASS)
    # some 2000 steps in the collision leave less than 1e-3, as in the test of Thornton's law
    assert restitution(law, RADIUS, DENSITY, [speed]).restitution[0] == pytest.approx(expected, rel=1e-3)
