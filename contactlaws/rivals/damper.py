"""What rivals with a damper have in common: Hertz's spring beside a force that depends on the rate, and the energy that this takes.

The state is the overlap (m), the force (N) and the energy in J that the damper has taken. That energy is counted by trapezoids, as a
simulation does work, so that a simulation's energies balance.
"""

from __future__ import annotations

import math

from contactlaws.compiled import inlined, kernel

MEMORY = ("overlap", "force", "dissipated")


@inlined
def secant(law, overlap):  # type: ignore[no-untyped-def]
    """Hertz's force over the overlap in N/m, 4/3 E* sqrt(R d); the tangent is 3/2 of it, the energy 2/5 of it times d^2."""
    return 4.0 / 3.0 * law.reduced_modulus * math.sqrt(law.radius * overlap)


@inlined
def damped(law, overlap, damping, pulls, state):  # type: ignore[no-untyped-def]
    """Force in N of the spring and of a damper of force `damping`, and the new memory; only if the damper `pulls` is it below 0."""
    spring, before = secant(law, overlap), secant(law, state[0])
    force, moved = spring * overlap + damping, overlap - state[0]
    if force <= 0.0 and not pulls:  # the damper holds the spring, and takes what it had
        force = 0.0
        taken = 0.5 * state[1] * moved + 0.4 * (before * state[0] * state[0] - spring * overlap * overlap)
    else:
        taken = 0.5 * (damping + state[1] - before * state[0]) * moved
    return force, (overlap, force, state[2] + max(0.0, taken))  # below 0 only in a step in which the overlap turns


@kernel
def damped_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored in the spring, and taken by the damper: also what the spring still had, if the contact opens while the damper holds it."""
    x = max(overlap, 0.0)
    stored = 0.4 * secant(law, x) * x * x
    held = 0.4 * secant(law, state[0]) * state[0] * state[0] - stored if state[1] == 0.0 and x < state[0] else 0.0
    return stored, state[2] + held
