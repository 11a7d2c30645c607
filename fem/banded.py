"""Direct solution of the banded equations: elimination without pivoting, four columns at a time.

LAPACK's `dgbtrf` pivots, which a stiffness needs not, and is made for bands of hundreds: at the half bandwidths of these meshes (40 to 110)
this takes a half to a quarter of its time. Row i of the matrix is row i of the band, its diagonal at `pad(half)`, so that in the
flat band one step down and one step left is a constant stride and rows can be worked on side by side.
"""

from __future__ import annotations

import numpy as np

from contactlaws.compiled import kernel

COLUMNS = 4  # eliminated together
REORDERED = {"contract", "reassoc", "nsz"}  # sums in any order, fused multiply-add: what makes the loops run in vector registers


def pad(half: int) -> int:
    """Place of the diagonal in a row of the band; the columns taken together need a few zeros beyond the band's own width."""
    return half + COLUMNS - 1


def band_shape(size: int, half: int) -> tuple[int, int]:
    """Shape of the band of a `size` x `size` matrix: whole groups of columns, and the rows that the last of them reaches."""
    return -(-size // COLUMNS) * COLUMNS + half, 2 * pad(half) + 1


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

    For each group of four columns: eliminate within their four rows, then take all four off each row below in one pass. Longer than a
    step, because the four multipliers are what saves the memory traffic.
    """
    middle = half + COLUMNS - 1
    stride = 2 * middle
    above = np.empty((COLUMNS, half))
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
        for i in range(k + COLUMNS, k + COLUMNS + half):
            row = i * stride + middle + k
            f0 = band[row] * a0
            f1 = (band[row + 1] - f0 * a1) * b1
            f2 = (band[row + 2] - f0 * a2 - f1 * b2) * c2
            f3 = (band[row + 3] - f0 * a3 - f1 * b3 - f2 * c3) * d3
            band[row], band[row + 1], band[row + 2], band[row + 3] = f0, f1, f2, f3
            rest = band[row + COLUMNS : row + COLUMNS + half]
            for j in range(half):
                rest[j] -= f0 * u0[j] + f1 * u1[j] + f2 * u2[j] + f3 * u3[j]
    return True


def _solve(band, size, half, rhs):  # type: ignore[no-untyped-def]
    """Replace each row of `rhs` (right-hand sides, size) by its solution, from the factors in the flat band."""
    middle = half + COLUMNS - 1
    for c in range(rhs.shape[0]):
        x = rhs[c]
        for i in range(size):
            low = max(0, i - middle)
            row, known = band[2 * middle * i + middle + low : 2 * middle * i + middle + i], x[low:i]
            total = 0.0
            for j in range(known.size):
                total += row[j] * known[j]
            x[i] -= total
        for i in range(size - 1, -1, -1):
            high = min(size, i + middle + 1)
            row, known = band[2 * middle * i + middle + i : 2 * middle * i + middle + high], x[i:high]
            total = 0.0
            for j in range(1, known.size):
                total += row[j] * known[j]
            x[i] = (x[i] - total) / row[0]


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
