"""Elastic laws: no memory, nothing dissipated."""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register


class Hertz(NamedTuple):
    """A parabolic elastic body on a rigid flat (Hertz 1882): F = 4/3 E* sqrt(R) d^1.5. Good to 1 % for d < 5e-4 R, 5 % for d < 1e-2 R.

    >>> law = Hertz(radius=5e-6, reduced_modulus=151.47e9)
    >>> force, _ = hertz_force(law, 5e-8, 0.0, 0.0, ())
    >>> round(force * 1e3, 3)
    5.049
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2) of the one body


@kernel
def hertz_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Hertz 1882."""
    if overlap <= 0.0:
        return 0.0, state
    return 4.0 / 3.0 * law.reduced_modulus * math.sqrt(law.radius * overlap) * overlap, state


@kernel
def hertz_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """a^2 = R d."""
    return math.sqrt(law.radius * max(overlap, 0.0))


@kernel
def hertz_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored 8/15 E* sqrt(R) d^2.5, dissipated none."""
    x = max(overlap, 0.0)
    return 8.0 / 15.0 * law.reduced_modulus * math.sqrt(law.radius * x) * x * x, 0.0


@kernel
def hertz_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """dF/dd = 2 E* sqrt(R d)."""
    return 2.0 * law.reduced_modulus * math.sqrt(law.radius * max(overlap, 0.0))


register(Law("hertz", Hertz, hertz_force, hertz_contact_radius, hertz_energy, hertz_stiffness_bound, (), "Hertz 1882"))
