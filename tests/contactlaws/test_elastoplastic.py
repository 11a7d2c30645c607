"""Thornton's law against his closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from contactlaws.elastoplastic import Thornton, thornton_energy, thornton_yield_overlap
from contactlaws.path import scan

LAW = Thornton(radius=5e-6, reduced_modulus=151.47e9, yield_pressure=12.64e9)
#: V/V_y: coefficient of restitution, from e = (6 sqrt 3/5)^1/2 (1 - r^2/6)^1/2 [r/(r + 2 sqrt(6/5 - r^2/5))]^1/4 with r = V_y/V
RESTITUTION = {1.5: 0.97124, 2.0: 0.93063, 5.0: 0.77334, 10.0: 0.65856, 50.0: 0.44461, 100.0: 0.37430, 1000.0: 0.21070}


@pytest.mark.parametrize(("ratio", "expected"), RESTITUTION.items())
def test_restitution_by_energy(ratio: float, expected: float):
    """All kinetic energy goes in; what is stored at the largest overlap comes back."""
    limit = thornton_yield_overlap(LAW)
    put_in = lambda top: sum(thornton_energy(LAW, top, (top,)))  # noqa: E731
    top = brentq(lambda top: put_in(top) / put_in(limit) - ratio**2, limit, 1e8 * limit, xtol=1e-12 * limit)
    stored, dissipated = thornton_energy(LAW, top, (top,))
    assert math.sqrt(stored / (stored + dissipated)) == pytest.approx(expected, abs=6e-6)  # the table has five digits
    r = 1.0 / ratio
    closed = math.sqrt(6 * math.sqrt(3) / 5) * math.sqrt(1 - r**2 / 6) * (r / (r + 2 * math.sqrt(6 / 5 - r**2 / 5))) ** 0.25
    assert math.sqrt(stored / (stored + dissipated)) == pytest.approx(closed, rel=1e-9)  # the root is found to 1e-12


def test_first_yield_of_one_body_and_of_a_pair():
    """delta_Y = (pi p_Y/2E*)^2 R: E* and R of a pair of equal spheres are half the body's, and its overlap is twice the body's."""
    pair = (math.pi * LAW.yield_pressure / (2 * 0.5 * LAW.reduced_modulus)) ** 2 * 0.5 * LAW.radius
    assert thornton_yield_overlap(LAW) == pytest.approx(0.5 * pair, rel=1e-14)
    pressure = 2 * LAW.reduced_modulus / math.pi * math.sqrt(thornton_yield_overlap(LAW) / LAW.radius)  # Hertz: p0 = 2 E* a/(pi R)
    assert pressure == pytest.approx(LAW.yield_pressure, rel=1e-14)


def test_yield_keeps_force_and_slope():
    limit = thornton_yield_overlap(LAW)
    step = 1e-5 * limit
    force = scan(LAW, limit + step * np.array([-1.0, 0.0, 1.0])).force
    below, above = np.diff(force) / step
    assert above == pytest.approx(below, rel=2e-5)  # differences of a curve with a bend of its own: of the order of the relative step


def test_unloads_as_a_flatter_hertzian_body():
    """At d_*: R_p = R F_Hertz/F_*; then F = 4/3 E* sqrt(R_p) (d - d_p)^1.5 and a^2 = R_p (d - d_p)."""
    top = 20 * thornton_yield_overlap(LAW)
    path = np.concatenate(([top], np.linspace(top, 0.6 * top, 50)))
    found = scan(LAW, path)
    hertz = 4 / 3 * LAW.reduced_modulus * math.sqrt(LAW.radius) * top**1.5
    flatter = LAW.radius * hertz / found.force[0]
    left = np.maximum(path - top * (1 - LAW.radius / flatter), 0.0)
    # the separation overlap is a difference of two numbers 2 to 3 times larger than what is left: a few round-offs
    np.testing.assert_allclose(
        found.force, 4 / 3 * LAW.reduced_modulus * np.sqrt(flatter) * left**1.5, rtol=1e-12, atol=1e-13 * found.force[0]
    )
    np.testing.assert_allclose(found.contact_radius**2, flatter * left, rtol=1e-12, atol=1e-13 * found.contact_radius[0] ** 2)
