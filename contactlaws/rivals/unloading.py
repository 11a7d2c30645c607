"""What the rivals' unloadings have in common: a part of the largest overlap is recovered, the force falls with a power of what is left."""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel

#: points and weights on (0, 1) for integrals of loading branches
_NODES, _SHARES = np.polynomial.legendre.leggauss(8)
POINTS, WEIGHTS = 0.5 * (1.0 + _NODES), 0.5 * _SHARES
#: a stiffness known at that many overlaps is largest between two of them by less than `MARGIN`
SAMPLES, MARGIN = 64, 1.005


@kernel
def part_left(largest, recovered, overlap):  # type: ignore[no-untyped-def]
    """s = (d - d_0)/(d_max - d_0) with d_max - d_0 = `recovered`; 0 where the body has left the flat, 1 at `largest`."""
    return min(1.0, max(0.0, 1.0 - (largest - overlap) / recovered))


@kernel
def hertzian_recovery(reduced_modulus, force, radius, largest):  # type: ignore[no-untyped-def]
    """The overlap in m that a Hertzian body under `force` (N) with contact radius `radius` (m) gives back, 3 F/(4 E* a); at most all."""
    return min(largest, 0.75 * force / (reduced_modulus * radius))


@kernel
def hertz(reduced_modulus, radius, overlap):  # type: ignore[no-untyped-def]
    """Hertz's force in N."""
    return 4.0 / 3.0 * reduced_modulus * math.sqrt(radius * overlap) * overlap


@kernel
def straight_force(stiffness, recovered, largest, overlap):  # type: ignore[no-untyped-def]
    """Force in N of two straight lines: up to the `largest` overlap (m) with `stiffness` (N/m), and down over `recovered` (m)."""
    force = stiffness * largest
    return force * part_left(largest, recovered, overlap) if overlap < largest else force


@kernel
def unknown_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """Of a law that does not know it."""
    return math.nan if overlap > 0.0 else 0.0


@kernel
def straight_energy(stiffness, recovered, largest, overlap):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy of two straight lines: two triangles."""
    force = stiffness * largest
    left = part_left(largest, recovered, overlap)
    return 0.5 * force * recovered * left * left, 0.5 * force * (largest - recovered)
