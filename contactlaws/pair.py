"""From one body on a rigid flat to a pair: the only place where the two conventions meet.

Two equal spheres of radius R that approach by `overlap` are each a body on a flat at overlap/2. Spheres of one material and radii R1, R2
meet like two equal spheres of radius 2 R1 R2/(R1 + R2): exact for Hertz and for plasticity that is small against the radius. A law belongs
to a body of radius `law.radius`; another radius is reached by scaling lengths by s, forces by s^2, energies by s^3 (no material length).
"""

from __future__ import annotations

from contactlaws import dispatch
from contactlaws.compiled import kernel


@kernel
def pair_scale(law, radius_i, radius_j):  # type: ignore[no-untyped-def]
    """Ratio of the equivalent equal spheres' radius to the law's radius."""
    return 2.0 * radius_i * radius_j / ((radius_i + radius_j) * law.radius)


@kernel
def pair_force(law, scale, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Force in N between two spheres whose centres are `overlap` (m) closer than the sum of their radii, and the new memory."""
    half = 0.5 / scale
    force, state = dispatch.normal_force(law, overlap * half, rate * half, dt, state)
    return scale * scale * force, state


@kernel
def pair_contact_radius(law, scale, overlap, state):  # type: ignore[no-untyped-def]
    """Contact radius in m of the pair."""
    return scale * dispatch.contact_radius(law, 0.5 * overlap / scale, state)


@kernel
def pair_energy(law, scale, overlap, state):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy in J of both bodies together."""
    stored, dissipated = dispatch.energy(law, 0.5 * overlap / scale, state)
    factor = 2.0 * scale * scale * scale
    return factor * stored, factor * dissipated


@kernel
def pair_stiffness_bound(law, scale, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent stiffness in N/m of the pair, over all histories that stay at or below `overlap`."""
    return 0.5 * scale * dispatch.stiffness_bound(law, 0.5 * overlap / scale)
