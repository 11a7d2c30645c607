"""The banded elimination against dense elimination."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fem.banded import band_shape, constrain, factorise, pad, solve, solve_many
from fem.mesh import FloatArray

#: round-off of matrices of condition below 100
CLOSE = 1e-11


def matrix(size: int, half: int, seed: int) -> FloatArray:
    """Dense, banded, unsymmetric and dominated by its diagonal, as a stiffness is without being so."""
    rng = np.random.default_rng(seed)
    apart = np.abs(np.subtract.outer(np.arange(size), np.arange(size)))
    dense = np.where(apart <= half, rng.uniform(-1.0, 1.0, (size, size)), 0.0)
    return np.asarray(dense + (2.0 * half + 2.0) * np.eye(size))


def band_of(dense: FloatArray, half: int) -> FloatArray:
    size = dense.shape[0]
    band = np.zeros(band_shape(size, half))
    for i in range(size):
        for j in range(max(0, i - half), min(size, i + half + 1)):
            band[i, pad(half) + j - i] = dense[i, j]
    return band


@given(st.integers(1, 23), st.integers(1, 9), st.integers(1, 7), st.integers(0, 10**6))
@settings(deadline=None, max_examples=40)
def test_solutions_are_those_of_dense_elimination(size: int, half: int, columns: int, seed: int):
    dense, rhs = matrix(size, half, seed), np.random.default_rng(seed + 1).standard_normal((columns, size))
    band = band_of(dense, half).reshape(-1)
    assert factorise(band, size, half)
    expected = np.linalg.solve(dense, rhs.T).T
    rows, side_by_side = rhs.copy(), np.ascontiguousarray(rhs.T)
    solve(band, size, half, rows)
    solve_many(band, size, half, side_by_side)
    np.testing.assert_allclose(rows, expected, rtol=0, atol=CLOSE)
    np.testing.assert_allclose(side_by_side.T, expected, rtol=0, atol=CLOSE)


@pytest.mark.parametrize("place", [0, 5, 11])
def test_a_vanishing_pivot_is_told(place: int):
    dense = np.eye(12)
    dense[place, place] = 0.0
    assert not factorise(band_of(dense, 3).reshape(-1), 12, 3)


def test_prescribed_displacements():
    """Two right-hand sides, three prescribed components."""
    size, half = 12, 3
    rng = np.random.default_rng(5)
    dense, fixed = matrix(size, half, 5), np.array([0, 5, 11])
    rhs, values = rng.standard_normal((2, size)), rng.standard_normal((2, 3))
    free = np.setdiff1d(np.arange(size), fixed)
    expected = np.zeros((2, size))
    expected[:, fixed] = values
    expected[:, free] = np.linalg.solve(dense[np.ix_(free, free)], (rhs[:, free] - values @ dense[np.ix_(free, fixed)].T).T).T
    band, solution = band_of(dense, half), rhs.copy()
    constrain(band, half, fixed, values, solution)
    assert factorise(band.reshape(-1), size, half)
    solve(band.reshape(-1), size, half, solution)
    np.testing.assert_allclose(solution, expected, rtol=0, atol=CLOSE)
