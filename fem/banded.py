"""Direct solution of the banded equations: elimination without pivoting, four columns at a time.

LAPACK's `dgbtrf` pivots, which a stiffness needs not, and is made for bands of hundreds: at the half bandwidths of these meshes (40 to 110)
this takes a half to a quarter of its time. Row i of the matrix is row i of the band, its diagonal at `pad(half)`, so that in the
flat band one step down and one step left is a constant stride and rows can be worked on side by side.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from contactlaws.compiled import kernel

COLUMNS = 4  # eliminated together
REORDERED = {"contract", "reassoc", "nsz"}  # sums in any order, fused multiply-add: what makes the loops run in vector registers


def pad(half: int) -> int:
    """Place of the diagonal in a row of the band; the columns taken together need a few zeros beyond the band's own width."""
    return half + COLUMNS - 1


def band_shape(size: int, half: int) -> tuple[int, int]:
    """Shape of the band of a `size` x `size` matrix: whole groups of columns, and the pairs of rows that the last of them reaches."""
    return -(-size // COLUMNS) * COLUMNS + half + half % 2, 2 * pad(half) + 1


@kernel
def constrain(band, half, fixed, values, rhs):  # type: ignore[no-untyped-def]
    """Prescribe dofs `fixed`: take their columns times `values` (right-hand sides, fixed) to the right, leave a unit diagonal."""
    size, middle = rhs.shape[1], half + COLUMNS - 1
    for k in range(fixed.size):
        d = fixed[k]
        for i in range(max(0, d - half), min(size, d + half + 1)):
            entry = band[i, middle + d - i]
            for c in range(rhs.shape[0]):
                rhs[c, i] -= entry * values[c, k]
            band[d, middle + i - d] = 0.0
            band[i, middle + d - i] = 0.0
        band[d, middle] = 1.0
    for k in range(fixed.size):
        rhs[:, fixed[k]] = values[:, k]


def _factorise(band, size, half):  # type: ignore[no-untyped-def]
    """Overwrite the flat band with its factors: upper triangle, and below it the unit lower one; False if a pivot vanishes.

    For each group of four columns: eliminate within their four rows, then take all four off the rows below, two in one pass. Longer than a
    step, because the eight multipliers are what saves the memory traffic.
    """
    middle = half + COLUMNS - 1
    stride = 2 * middle
    width = -(-half // COLUMNS) * COLUMNS  # whole vector registers; the columns beyond the band's own are zeros
    above = np.zeros((COLUMNS, width))
    for k in range(0, size, COLUMNS):
        for p in range(COLUMNS):
            if k + p >= size:
                band[(k + p) * stride + middle + k + p] = 1.0
            from_row = (k + p) * stride + middle + k
            if not abs(band[from_row + p]) > 0.0:
                return False
            for q in range(p + 1, COLUMNS):
                row = (k + q) * stride + middle + k
                factor = band[row + p] / band[from_row + p]
                band[row + p] = factor
                for j in range(p + 1, COLUMNS + half):
                    band[row + j] -= factor * band[from_row + j]
        a, b, c, d = k * stride + middle + k, (k + 1) * stride + middle + k, (k + 2) * stride + middle + k, (k + 3) * stride + middle + k
        a0, b1, c2, d3 = 1.0 / band[a], 1.0 / band[b + 1], 1.0 / band[c + 2], 1.0 / band[d + 3]
        a1, a2, a3, b2, b3, c3 = band[a + 1], band[a + 2], band[a + 3], band[b + 2], band[b + 3], band[c + 3]
        for j in range(half):
            above[0, j], above[1, j], above[2, j], above[3, j] = band[a + 4 + j], band[b + 4 + j], band[c + 4 + j], band[d + 4 + j]
        u0, u1, u2, u3 = above[0], above[1], above[2], above[3]
        for i in range(k + COLUMNS, k + COLUMNS + half, 2):
            row, next_row = i * stride + middle + k, (i + 1) * stride + middle + k
            f0 = band[row] * a0
            f1 = (band[row + 1] - f0 * a1) * b1
            f2 = (band[row + 2] - f0 * a2 - f1 * b2) * c2
            f3 = (band[row + 3] - f0 * a3 - f1 * b3 - f2 * c3) * d3
            band[row], band[row + 1], band[row + 2], band[row + 3] = f0, f1, f2, f3
            g0, g1, g2, g3 = 0.0, 0.0, 0.0, 0.0
            if i + 1 < k + COLUMNS + half:
                g0 = band[next_row] * a0
                g1 = (band[next_row + 1] - g0 * a1) * b1
                g2 = (band[next_row + 2] - g0 * a2 - g1 * b2) * c2
                g3 = (band[next_row + 3] - g0 * a3 - g1 * b3 - g2 * c3) * d3
                band[next_row], band[next_row + 1], band[next_row + 2], band[next_row + 3] = g0, g1, g2, g3
            rest, next_rest = band[row + COLUMNS : row + COLUMNS + width], band[next_row + COLUMNS : next_row + COLUMNS + width]
            for j in range(width):
                rest[j] -= f0 * u0[j] + f1 * u1[j] + f2 * u2[j] + f3 * u3[j]
                next_rest[j] -= g0 * u0[j] + g1 * u1[j] + g2 * u2[j] + g3 * u3[j]
    return True


@partial(kernel, fastmath=REORDERED, inline=True)
def _products(row0, row1, row2, row3, known):  # type: ignore[no-untyped-def]
    """Scalar products of four rows with `known`."""
    sum0, sum1, sum2, sum3 = 0.0, 0.0, 0.0, 0.0
    for j in range(known.size):
        sum0 += row0[j] * known[j]
        sum1 += row1[j] * known[j]
        sum2 += row2[j] * known[j]
        sum3 += row3[j] * known[j]
    return sum0, sum1, sum2, sum3


def _solve(band, size, half, rhs):  # type: ignore[no-untyped-def]
    """Replace each row of `rhs` (right-hand sides, size) by its solution, from the factors in the flat band.

    Four rows at a time: what is known already is taken off all four at once, so that no row waits for the sum of the one before.
    """
    middle = half + COLUMNS - 1
    stride, whole = 2 * middle, -(-size // COLUMNS) * COLUMNS
    x = np.zeros(whole)
    for c in range(rhs.shape[0]):
        x[:size] = rhs[c]
        for k in range(0, whole, COLUMNS):
            p = k * stride + middle
            q, r, s = p + stride, p + 2 * stride, p + 3 * stride
            low = max(0, k - half)
            x0, x1, x2, x3 = _products(band[p + low : p + k], band[q + low : q + k], band[r + low : r + k], band[s + low : s + k], x[low:k])
            x0 = x[k] - x0
            x1 = x[k + 1] - x1 - band[q + k] * x0
            x2 = x[k + 2] - x2 - band[r + k] * x0 - band[r + k + 1] * x1
            x3 = x[k + 3] - x3 - band[s + k] * x0 - band[s + k + 1] * x1 - band[s + k + 2] * x2
            x[k], x[k + 1], x[k + 2], x[k + 3] = x0, x1, x2, x3
        for k in range(whole - COLUMNS, -1, -COLUMNS):
            p = k * stride + middle
            q, r, s = p + stride, p + 2 * stride, p + 3 * stride
            n, high = k + COLUMNS, min(whole, k + COLUMNS + half)
            x0, x1, x2, x3 = _products(
                band[p + n : p + high], band[q + n : q + high], band[r + n : r + high], band[s + n : s + high], x[n:high]
            )
            x3 = (x[k + 3] - x3) / band[s + k + 3]
            x2 = (x[k + 2] - x2 - band[r + k + 3] * x3) / band[r + k + 2]
            x1 = (x[k + 1] - x1 - band[q + k + 2] * x2 - band[q + k + 3] * x3) / band[q + k + 1]
            x0 = (x[k] - x0 - band[p + k + 1] * x1 - band[p + k + 2] * x2 - band[p + k + 3] * x3) / band[p + k]
            x[k], x[k + 1], x[k + 2], x[k + 3] = x0, x1, x2, x3
        rhs[c] = x[:size]


def _solve_many(band, size, half, rhs):  # type: ignore[no-untyped-def]
    """As `_solve` for many right-hand sides, the columns of `rhs` (size, right-hand sides): worked on side by side, four rows at a time."""
    middle = half + COLUMNS - 1
    stride = 2 * middle
    for step in range(2 * size):
        if step < size:
            i = step
            low, high = max(0, i - middle), i
        else:
            i = 2 * size - 1 - step
            low, high = i + 1, min(size, i + middle + 1)
        x, row = rhs[i], stride * i + middle
        j = low
        while j + 3 < high:
            f0, f1, f2, f3 = band[row + j], band[row + j + 1], band[row + j + 2], band[row + j + 3]
            x0, x1, x2, x3 = rhs[j], rhs[j + 1], rhs[j + 2], rhs[j + 3]
            for c in range(x.size):
                x[c] -= f0 * x0[c] + f1 * x1[c] + f2 * x2[c] + f3 * x3[c]
            j += 4
        while j < high:
            f0, x0 = band[row + j], rhs[j]
            for c in range(x.size):
                x[c] -= f0 * x0[c]
            j += 1
        if step >= size:
            for c in range(x.size):
                x[c] /= band[row + i]


factorise, solve, solve_many = (kernel(function, fastmath=REORDERED) for function in (_factorise, _solve, _solve_many))
