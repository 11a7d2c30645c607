"""Stress and tangent at one point: Hencky elasticity of the deviator, von Mises yield on the Cauchy stress, closed-form radial return.

Stored energy per undeformed volume: K (J ln J - J + 1) + G |dev eps|^2 with the elastic Hencky strain eps = 1/2 ln b, hence the Cauchy
pressure -K ln J and the Kirchhoff deviator 2 G dev eps. Yield: the Cauchy von Mises stress reaches Y, so q of the Kirchhoff
deviator reaches J Y.
"""

from __future__ import annotations

import math

from contactlaws.compiled import kernel


@kernel
def principal(b11, b22, b12):  # type: ignore[no-untyped-def]
    """Eigenvalues and the first eigenvector (cos, sin) of a symmetric 2 x 2 tensor."""
    mean = 0.5 * (b11 + b22)
    half = 0.5 * (b11 - b22)
    radius = math.sqrt(half * half + b12 * b12)
    if radius < 1e-14 * mean:
        return mean, mean, 1.0, 0.0
    # half-angle without trigonometry, from the larger of cosine and sine
    c2, s2 = half / radius, b12 / radius
    if c2 >= 0.0:
        c = math.sqrt(0.5 * (1.0 + c2))
        s = 0.5 * s2 / c
    else:
        s = math.sqrt(0.5 * (1.0 - c2))
        c = 0.5 * s2 / s
    return mean + radius, (b11 * b22 - b12 * b12) / (mean + radius), c, s


@kernel
def radial_return(e1, e2, e3, shear_modulus, flow_stress):  # type: ignore[no-untyped-def]
    """Kirchhoff deviator (3 principal values), its ratio to the trial deviator and the trial von Mises stress.

    e1, e2, e3: trial elastic Hencky strains; flow_stress: J Y in the same unit as the modulus. The ratio is 1 for an elastic point.
    """
    mean = (e1 + e2 + e3) / 3.0
    s1 = 2.0 * shear_modulus * (e1 - mean)
    s2 = 2.0 * shear_modulus * (e2 - mean)
    s3 = 2.0 * shear_modulus * (e3 - mean)
    q = math.sqrt(1.5 * (s1 * s1 + s2 * s2 + s3 * s3))
    ratio = 1.0
    if q > flow_stress:
        ratio = flow_stress / q
    return s1 * ratio, s2 * ratio, s3 * ratio, ratio, q


@kernel
def principal_tangent(tangent, b1, b2, s1, s2, s3, ratio, shear_modulus, pressure_volume):  # type: ignore[no-untyped-def]
    """Fill the 5 x 5 tangent of the virtual work at fixed mean dilatation, per undeformed volume, in the principal axes.

    Rows and columns: virtual and actual displacement gradient (11, 12, 21, 22, hoop). It holds the derivative of the Kirchhoff
    deviator, the rotation of its axes, the geometric term -tau (dl Dl), and the mean pressure's part `pressure_volume` = p J
    (tr tr - dl : Dl^T).
    """
    tangent[:, :] = 0.0
    plastic = ratio < 1.0
    n = 0.0
    if plastic:
        n = 1.0 / math.sqrt(s1 * s1 + s2 * s2 + s3 * s3)
    modulus = 2.0 * shear_modulus * ratio
    s = (s1, s2, s3)
    slot = (0, 3, 4)
    for i in range(3):
        for j in range(3):
            value = -modulus / 3.0 + pressure_volume
            if i == j:
                value += modulus - s[i] - pressure_volume
            if plastic:
                value -= modulus * (s[i] * n) * (s[j] * n)
            tangent[slot[i], slot[j]] = value
    if b1 - b2 > 1e-9 * b1:
        spin = (s1 - s2) / (b1 - b2)
    else:
        spin = modulus / (2.0 * b1)
        if plastic:
            spin -= modulus * ((s1 - s2) * n) * (s1 * n) / (2.0 * b1)
    tangent[1, 1] = spin * b2
    tangent[1, 2] = spin * b1 - s1 - pressure_volume
    tangent[2, 1] = spin * b2 - s2 - pressure_volume
    tangent[2, 2] = spin * b1


@kernel
def pressure(bulk_modulus, dilatation):  # type: ignore[no-untyped-def]
    """Cauchy mean stress K ln J (tension positive) and its derivative."""
    return bulk_modulus * math.log(dilatation), bulk_modulus / dilatation


@kernel
def volumetric_energy(bulk_modulus, dilatation):  # type: ignore[no-untyped-def]
    """Stored energy K (J ln J - J + 1) per undeformed volume, cancellation-free near J = 1."""
    x = dilatation - 1.0
    if abs(x) < 1e-3:
        return bulk_modulus * x * x * (0.5 - x / 6.0 + x * x / 12.0 - x * x * x / 20.0 + x**4 / 30.0)
    return bulk_modulus * (dilatation * math.log(dilatation) - x)
