"""Errors of parameters: what repeated measurements would scatter by, also where two parameters are hardly told apart."""

from __future__ import annotations

import numpy as np
import pytest

from calibration.trust import FloatArray, doubts, trust

ROWS = 60
PLACE = np.linspace(0.0, 3.0, ROWS)
#: half common to all rows, half correlated over a length of 1, as of curves
COVARIANCE = 0.5 + 0.5 * np.exp(-abs(PLACE[:, None] - PLACE))
#: two smooth shapes that are far from being multiples of one another
ONE, OTHER = np.exp(-PLACE), np.sin(2.0 * PLACE)


def carried(matrix: FloatArray) -> FloatArray:
    return np.asarray(matrix.T @ COVARIANCE @ matrix)


def test_errors_are_the_scatter_of_repeated_measurements() -> None:
    jacobian = np.array([ONE, 50.0 * OTHER, PLACE]).T
    found = trust(jacobian, np.zeros(ROWS), carried, 3.0)
    samples = 4000
    noise = np.random.default_rng(3).multivariate_normal(np.zeros(ROWS), COVARIANCE, samples)
    fitted = np.linalg.lstsq(jacobian, noise.T, rcond=None)[0]
    # a standard deviation from 4000 samples scatters by 1.1 %, a correlation by 1.6 % at most: four times that
    np.testing.assert_allclose(fitted.std(axis=1), found.errors, rtol=0.045)
    np.testing.assert_allclose(np.corrcoef(fitted), found.correlation, atol=0.065)


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_errors_grow_as_two_parameters_become_alike(apart: float) -> None:
    """With the second column the first plus `apart` times another shape, their difference is known to the error of that shape over it."""
    alone = trust(np.array([ONE, OTHER]).T, np.zeros(ROWS), carried, 2.0)
    with np.errstate(all="raise"):
        found = trust(np.array([ONE, ONE + apart * OTHER]).T, np.zeros(ROWS), carried, 2.0)
    # to first order in `apart`; the second column itself is rounded at 1e-16
    tolerance = 3.0 * apart + 1e-14 / apart
    np.testing.assert_allclose(found.errors * apart, alone.errors[1], rtol=tolerance)
    assert found.correlation[0, 1] == pytest.approx(-1.0, abs=tolerance)


def test_two_equal_parameters_are_not_told_apart() -> None:
    with np.errstate(all="raise"):
        found = trust(np.array([ONE, ONE, OTHER]).T, np.zeros(ROWS), carried, 3.0)
    assert np.isfinite(found.errors).all()
    assert (abs(found.correlation) <= 1.0 + 1e-12).all()
    said = list(doubts(found, ("a", "b", "c"), (None, None, None)))
    assert any(sentence.startswith("a and b cannot be told apart") for sentence in said)
    assert not any("no influence" in sentence for sentence in said)


def test_a_parameter_without_influence() -> None:
    with np.errstate(all="raise"):
        found = trust(np.array([ONE, np.zeros(ROWS)]).T, np.zeros(ROWS), carried, 2.0)
    assert found.errors[0] == pytest.approx(trust(ONE[:, None], np.zeros(ROWS), carried, 2.0).errors[0], rel=1e-12)  # round-off
    assert np.isinf(found.errors[1])
    assert list(doubts(found, ("a", "b"), (None, None))) == ["b has no influence on these curves: it cannot be fitted to them"]
