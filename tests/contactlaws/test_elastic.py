"""Hertz and his finite-size correction."""

from __future__ import annotations

import numpy as np
import pytest

from contactlaws import pair
from contactlaws.elastic import Hertz, HertzFiniteSize
from contactlaws.material import Material
from contactlaws.path import scan


def test_no_coefficients_is_hertz():
    path = np.geomspace(1e-8, 1e-6, 30)
    plain, corrected = scan(Hertz(5e-6, 1e11), path), scan(HertzFiniteSize(5e-6, 1e11, 0.0, 0.0, 0.0, 0.0, 0.0), path)
    for one, two in zip(plain, corrected, strict=True):
        np.testing.assert_allclose(one, two, rtol=1e-14)  # round-off


def test_hertz_force_of_two_spheres_is_the_textbooks():
    """Two PVDF spheres of 5 um at a strain of 2 %: the instantaneous and long-term forces of Wahn, Gan & Kamlah 2022, recomputed."""
    for modulus, expected in ((1365.9e6, 1.5822e-4), (1365.9e6 + 404.6e6, 2.0509e-4)):
        law = Hertz(5e-6, Material(modulus, 0.4471).reduced_modulus)
        force, _ = pair.pair_force(law, 1.0, 0.02 * 10e-6, 0.0, 0.0, ())
        textbook = 4 / 3 * 0.5 * law.reduced_modulus * np.sqrt(2.5e-6) * (0.02 * 10e-6) ** 1.5
        assert force == pytest.approx(textbook, rel=1e-14)
        assert force == pytest.approx(expected, rel=0.05)  # their Poisson's ratio differs between the two states
