"""An elastic body unloads along its loading, also where the contact is too small to be resolved."""

from __future__ import annotations

import numpy as np
import pytest

from fem.branch import SHARES
from fem.mesh import FloatArray
from fem.readout import Loading, from_zero, retraced_branch


def punch(power: float, overlap: FloatArray) -> Loading:
    """Force overlap^power and what belongs to it: contact radius its slope, work its integral."""
    return Loading(overlap**power, power * overlap ** (power - 1.0), overlap ** (power + 1.0) / (power + 1.0), 0.0 * overlap)


@pytest.mark.parametrize("power", [1.0, 1.5, 2.0])  # flat punch, sphere, cone
def test_exact_for_a_power_law_from_any_first_row(power: float):
    def read(overlap: FloatArray) -> Loading:
        assert overlap.min() >= 0.02  # nothing below is resolved
        return punch(power, overlap)

    overlap = np.linspace(0.0, 0.1, 51)
    found, exact = from_zero(read, 0.02, overlap), punch(power, overlap)
    for name in ("force", "stored", "dissipated"):
        np.testing.assert_allclose(getattr(found, name), getattr(exact, name), rtol=1e-12, atol=1e-15)  # round-off
    np.testing.assert_allclose(found.contact_radius[1:], exact.contact_radius[1:], rtol=1e-12)
    assert found.contact_radius[0] == 0.0  # separated, also the flat


def test_branch_of_a_sphere_recovers_all():
    branch = retraced_branch(from_zero(lambda d: punch(1.5, d), 0.01, 0.05 * SHARES), 0.05)
    assert branch.recovered == branch.start == 0.05
    np.testing.assert_allclose(branch.shape, SHARES**1.5, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(branch.retreat, SHARES**0.5, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(branch.dissipated, 0.0)
