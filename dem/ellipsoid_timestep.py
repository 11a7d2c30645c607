"""How stiff contacts of ellipsoids can be, how many there can be, and how much they turn their bodies: for the time step.

The gap of two bodies has a radius R = 1/(2 sqrt(A B)) of at most 1/(1/R_1 + 1/R_2), R_i that of the flattest point, a b/c (Minkowski's
inequality of determinants). What the ratio of the curvatures does is left to the law, which is asked at several.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from contactlaws import shaped
from contactlaws.tangential import tangential_stiffness
from dem.scene import Contact

FloatArray = npt.NDArray[np.float64]

#: ratios of curvatures and shares of the radii at which the law is asked
RATIOS, RADII = 6, 4
#: equal spheres that can touch one; bodies of a larger surface for their volume have the more contacts
KISSING_NUMBER = 12
#: angle in rad that no body turns by in a time step: contacts are to change little from one to the next
MOST_TURN = 0.02


def flattest(axes: FloatArray) -> float:
    """The largest radius sqrt(R' R'') in m on ellipsoids with these half axes (m), shape (n, 3): a b/c at the shortest axis."""
    return float((axes.prod(axis=1) / axes.min(axis=1) ** 2).max())


def stiffness(contact: Contact, axes_1: FloatArray, axes_2: FloatArray | None, overlap: float) -> float:
    """Largest normal stiffness in N/m of a contact up to `overlap` (m), wherever two ellipsoids touch; axes_2 None: on a wall.

    Axes in m, shape (n, 3): of all that may meet.
    """
    both = axes_1 if axes_2 is None else np.concatenate([axes_1, axes_2])
    share = contact.share
    widest = flattest(axes_1) if axes_2 is None else 1.0 / (1.0 / flattest(axes_1) + 1.0 / flattest(axes_2))
    mean = float(np.cbrt(both.prod(axis=1)).max()) * (1.0 if axes_2 is None else 0.5)
    slimmest = float((both.max(axis=1) / both.min(axis=1)).max()) ** 2
    shapes = (
        (widest * part / share, ratio, mean / share)
        for ratio in np.geomspace(1.0, max(slimmest, 1.0 + 1e-9), RATIOS).tolist()
        for part in np.linspace(1.0, 1.0 / RADII, RADII).tolist()
    )
    return share * max(float(shaped.stiffness_bound(contact.normal, shape, share * overlap)) for shape in shapes)


def sliding_stiffness(contact: Contact, axes_1: FloatArray, axes_2: FloatArray | None, overlap: float) -> float:
    """Largest tangential stiffness in N/m; no contact is wider than the smaller body, and an elastic one has c^2 = R d, but for ripples."""
    if contact.tangential is None:
        return 0.0
    widest = flattest(axes_1) if axes_2 is None else 1.0 / (1.0 / flattest(axes_1) + 1.0 / flattest(axes_2))
    smaller = min(float(axes.max()) for axes in (axes_1, axes_2) if axes is not None)
    return float(tangential_stiffness(contact.tangential, min(smaller, 1.5 * math.sqrt(widest * overlap))))


def turning(axes: FloatArray) -> tuple[float, float]:
    """1 + m r^2/I at most: of a normal force, whose arm is no longer than a - c, and of one in the plane of the contact, at the arm a."""
    normal, sliding = 1.0, 1.0
    for i in range(3):
        for j in range(3):
            squares = axes[:, i] ** 2 + axes[:, j] ** 2
            sliding = max(sliding, 1.0 + float((5.0 * axes[:, i] ** 2 / squares).max()))
            normal = max(normal, 1.0 + float((5.0 * (axes[:, i] - axes[:, j]) ** 2 / squares).max()))
    return normal, sliding


def contacts_on(axes: FloatArray) -> int:
    """How many equal ones can touch an ellipsoid: as many as spheres, times its surface over that of the sphere of its volume (Thomsen)."""
    a, b, c = axes.T**1.6075
    surface = ((a * b + b * c + c * a) / 3.0) ** (1.0 / 1.6075) / np.cbrt(axes.prod(axis=1)) ** 2
    return math.ceil(KISSING_NUMBER * float(surface.max()) - 1e-9)


def collision_overlap(law: object, axes: FloatArray, mass: float, speed: float) -> float:
    """Overlap in m at which two of `mass` (kg), touching where they are sharpest, have taken up the energy of a relative `speed` (m/s)."""
    sharpest = float((axes.min(axis=1) ** 2 / axes.max(axis=1)).min())
    mean = float(np.cbrt(axes.prod(axis=1)).max())
    energy, limit, step = 0.25 * mass * speed * speed, 2.0 * float(axes.min()), 1e-9 * mean
    memory, overlap, before, work = shaped.untouched(law), 0.0, 0.0, 0.0
    while work < energy and overlap < limit:
        overlap += step
        force, memory = shaped.force(law, (sharpest, 1.0, mean), 0.5 * overlap, memory)
        work += 0.5 * (before + float(force)) * step
        before, step = float(force), 1.02 * step
    return min(overlap, limit)
