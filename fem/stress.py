"""Stress and tangent at one point: Hencky elasticity of the deviator, von Mises yield on the Cauchy stress, closed-form radial return.

Stored energy per undeformed volume: K (J ln J - J + 1) + G |dev eps|^2 with the elastic Hencky strain eps = 1/2 ln b, hence the Cauchy
pressure -K ln J and the Kirchhoff deviator 2 G dev eps. Yield: the Cauchy von Mises stress reaches Y, so q of the Kirchhoff
deviator reaches J Y.

The logarithm of the in-plane tensor needs no principal axes: with the mean m of its diagonal and its deviator d, b = m + d and
x = |d|/m (half the difference of the eigenvalues over their mean), dev ln b = d/m artanh(x)/x, which is smooth where the eigenvalues are
equal. The deviator of eps is held as (a + h, a - h, k, -2 a): rr, zz, rz, hoop.
"""

from __future__ import annotations

import math
from functools import partial

from contactlaws.compiled import kernel

FUSED = {"contract"}  # fused multiply-add: it rounds once less
#: part of its caller: a handful of numbers go in and out of formulas that take no longer than handing them over
inlined = partial(kernel, fastmath=FUSED, inline=True)

SERIES = 0.01  # x^2 below which the series is exact to round-off: stretches less than a tenth apart, as in most metals


@inlined
def artanh_over(square):  # type: ignore[no-untyped-def]
    """artanh(x)/x from x^2."""
    if square < SERIES:
        low = 1.0 + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square * (1.0 / 7.0)))
        return low + square**4 * (1.0 / 9.0 + square * (1.0 / 11.0 + square * (1.0 / 13.0 + square * (1.0 / 15.0))))
    x = math.sqrt(square)
    return math.atanh(x) / x


@inlined
def artanh_over_slope(square, value):  # type: ignore[no-untyped-def]
    """Its derivative with x^2, `value` being `artanh_over(square)`."""
    if square < SERIES:
        low = 1.0 / 3.0 + square * (2.0 / 5.0 + square * (3.0 / 7.0 + square * (4.0 / 9.0)))
        return low + square**4 * (5.0 / 11.0 + square * (6.0 / 13.0 + square * (7.0 / 15.0 + square * (8.0 / 17.0))))
    return 0.5 * (1.0 / (1.0 - square) - value) / square


@inlined
def sinh_over(square):  # type: ignore[no-untyped-def]
    """sinh(x)/x from x^2."""
    if square < 10.0 * SERIES:
        return 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0 * (1.0 + square / 72.0 * (1.0 + square / 110.0))))
    x = math.sqrt(square)
    return math.sinh(x) / x


@inlined
def hencky_deviator(b11, b22, b12, b33):  # type: ignore[no-untyped-def]
    """Deviator (a, h, k) of the Hencky strain of b (rr, zz, rz, hoop)."""
    mean, half = 0.5 * (b11 + b22), 0.5 * (b11 - b22)
    in_plane = 0.5 * artanh_over((half * half + b12 * b12) / (mean * mean)) / mean
    # a third of the difference of the in-plane mean strain and the hoop strain, 1/4 ln(det/b33^2) = 1/2 artanh(y)
    determinant, hoop = b11 * b22 - b12 * b12, b33 * b33
    y = (determinant - hoop) / (determinant + hoop)
    return y * artanh_over(y * y) / 6.0, in_plane * half, in_plane * b12


@inlined
def norm_squared(a, h, k):  # type: ignore[no-untyped-def]
    """Square of a deviator's norm, (a, h, k) as above."""
    return 6.0 * a * a + 2.0 * (h * h + k * k)


@inlined
def radial_return(a, h, k, shear_modulus, flow_stress):  # type: ignore[no-untyped-def]
    """Ratio of the stress deviator to the trial one, 1 for an elastic point, and the square of the trial von Mises stress.

    a, h, k: trial elastic deviator of the Hencky strain; flow_stress: J Y in the same unit as the modulus.
    """
    square = 6.0 * shear_modulus * shear_modulus * norm_squared(a, h, k)
    if square > flow_stress * flow_stress:
        return flow_stress / math.sqrt(square), square
    return 1.0, square


@inlined
def stress_rates(half, shear, mean, trace, strain, by, flow):  # type: ignore[no-untyped-def]
    """Derivatives of the stress deviator (rr, rz, zz) over twice the shear modulus with one component of the displacement gradient.

    half, shear, mean, trace: derivatives of b's half difference rr - zz, of its rz, of its mean in the plane, and of ln J.
    strain: (a, h, k) and b's half difference and rz. by: the factor that makes (h, k) of these two, and its derivatives with half, shear
    and mean. flow: where the point flows, one over the square of the strain's norm (the return takes away what grows along it), else 0.
    """
    a, h, k, b_half, b_shear = strain
    factor, by_half, by_shear, by_mean = by
    change = by_half * half + by_shear * shear + by_mean * mean
    da, dh, dk = trace / 6.0, factor * half + b_half * change, factor * shear + b_shear * change
    along = flow * (6.0 * a * da + 2.0 * (h * dh + k * dk))
    da, dh, dk = da - along * a, dh - along * h, dk - along * k
    return da + dh, dk, da - dh


@inlined
def tangent(b11, b22, b12, a, h, k, ratio, shear_modulus, pressure_volume, volume, entries):  # type: ignore[no-untyped-def]
    """Fill `entries` (5, 5) with `volume` times the tangent of the virtual work at fixed mean dilatation, per undeformed volume.

    Rows and columns: virtual and actual displacement gradient (rr, rz, zr, zz, hoop). It holds the derivative of the Kirchhoff
    deviator, the geometric term -tau (dl Dl), and the mean pressure's part `pressure_volume` = p J (tr tr - dl : Dl^T). It is symmetric.
    """
    mean, half = 0.5 * (b11 + b22), 0.5 * (b11 - b22)
    over = 1.0 / mean
    square = (half * half + b12 * b12) * over * over
    value = artanh_over(square)
    slope = artanh_over_slope(square, value)
    # h = factor half, k = factor b12; the derivatives of factor with half, b12 and mean
    by_square = slope * over * over * over
    by = 0.5 * value * over, by_square * half, by_square * b12, -(slope * square + 0.5 * value) * over * over
    flow = 0.0
    if ratio < 1.0:
        flow = 1.0 / norm_squared(a, h, k)
    strain = a, h, k, half, b12
    rr_rr, rz_rr, _ = stress_rates(b11, b12, b11, 1.0, strain, by, flow)
    _, rz_rz, zz_rz = stress_rates(b12, b22, b12, 0.0, strain, by, flow)
    rr_zr, rz_zr, _ = stress_rates(-b12, b11, b12, 0.0, strain, by, flow)
    rr_zz, rz_zz, zz_zz = stress_rates(-b22, b12, b22, 1.0, strain, by, flow)
    # with the hoop strain a changes by -1/3, and by what the flow takes off
    along = -2.0 * flow * a
    da, dh, dk = -1.0 / 3.0 - along * a, -along * h, -along * k
    modulus, pressure = 2.0 * shear_modulus * ratio * volume, pressure_volume * volume
    entries[0, 0] = modulus * (rr_rr - (a + h))
    entries[0, 1] = entries[1, 0] = modulus * rz_rr
    entries[0, 2] = entries[2, 0] = modulus * rr_zr
    entries[0, 3] = entries[3, 0] = modulus * rr_zz + pressure
    entries[0, 4] = entries[4, 0] = modulus * (da + dh) + pressure
    entries[1, 1] = modulus * rz_rz
    entries[1, 2] = entries[2, 1] = modulus * (rz_zr - (a + h)) - pressure
    entries[1, 3] = entries[3, 1] = modulus * zz_rz
    entries[1, 4] = entries[4, 1] = entries[2, 4] = entries[4, 2] = modulus * dk
    entries[2, 2] = modulus * rz_zr
    entries[2, 3] = entries[3, 2] = modulus * rz_zz
    entries[3, 3] = modulus * (zz_zz - (a - h))
    entries[3, 4] = entries[4, 3] = modulus * (da - dh) + pressure
    entries[4, 4] = 2.0 * modulus * (a - da)


@inlined
def pressure(bulk_modulus, dilatation):  # type: ignore[no-untyped-def]
    """Cauchy mean stress K ln J (tension positive) and its derivative."""
    return bulk_modulus * math.log(dilatation), bulk_modulus / dilatation


@inlined
def volumetric_energy(bulk_modulus, dilatation):  # type: ignore[no-untyped-def]
    """Stored energy K (J ln J - J + 1) per undeformed volume, cancellation-free near J = 1."""
    x = dilatation - 1.0
    if abs(x) < 1e-3:
        return bulk_modulus * x * x * (0.5 - x / 6.0 + x * x / 12.0 - x * x * x / 20.0 + x**4 / 30.0)
    return bulk_modulus * (dilatation * math.log(dilatation) - x)
