"""How large a step may be: leap-frog diverges beyond 2/omega_max, and the stiffness that counts is that of unloading.

The highest eigenfrequency of spheres on contact springs obeys omega^2 <= 2 z k/m (Gershgorin: k the stiffest contact, z contacts on the
lightest sphere m; exact for a pair with z = 1). So the critical step is sqrt(2 m/(z k)), with k the bound that the law itself gives over
all histories up to the largest overlap that the scene can reach.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contactlaws import dispatch, pair
from contactlaws.compiled import kernel
from dem.particles import Particles

#: equal spheres that can touch one
KISSING_NUMBER = 12


class TimeStep(NamedTuple):
    """The step of a run and what it was derived from."""

    dt: float  # s
    critical: float  # s; dt/critical is the fraction that was asked for
    stiffness: float  # N/m; bound of the pair's tangent, unloading included
    overlap: float  # m; of a pair, the largest that was reckoned with
    contacts: int  # on the lightest sphere

    @property
    def note(self) -> str:
        """One line for the start of a run."""
        return (
            f"time step {self.dt:.3g} s, {self.dt / self.critical:.3g} of the critical {self.critical:.3g} s "
            f"(unloading stiffness up to {self.stiffness:.3g} N/m at an overlap of {self.overlap:.3g} m, {self.contacts} contacts)"
        )


def critical_step(mass: float, stiffness: float, contacts: int = KISSING_NUMBER) -> float:
    """Largest stable step in s for the lightest sphere (kg) on `contacts` springs of `stiffness` (N/m) to others no lighter.

    >>> critical_step(mass=2.0, stiffness=1.0, contacts=1) == 2.0 / math.sqrt(2.0 * 1.0 / 2.0)
    True
    """
    return math.sqrt(2.0 * mass / (contacts * stiffness))


def time_step(law: object, particles: Particles, overlap: float, fraction: float, contacts: int = KISSING_NUMBER) -> TimeStep:
    """`fraction` of the critical step for overlaps up to `overlap` (m, of a pair), from the lightest sphere meeting the largest one."""
    radii = particles.radii
    scale = pair.pair_scale(law, float(radii.min()), float(radii.max()))
    stiffness = float(pair.pair_stiffness_bound(law, scale, overlap))
    critical = critical_step(float(particles.mass.min()), stiffness, contacts)
    return TimeStep(fraction * critical, critical, stiffness, overlap, contacts)


@kernel
def overlap_absorbing(law, scale, energy, step, limit):  # type: ignore[no-untyped-def]
    """Overlap in m at which the first loading of a pair has taken up `energy` (J), scanned from `step` (m) up to `limit` (m)."""
    state = dispatch.initial_state(law)
    overlap, before, work = 0.0, 0.0, 0.0
    while work < energy and overlap < limit:
        overlap = min(overlap + step, limit)
        force, state = pair.pair_force(law, scale, overlap, 0.0, 0.0, state)
        work += 0.5 * (before + force) * step
        before = force
        step *= 1.02
    return overlap


def collision_overlap(law: object, particles: Particles, speed: float) -> float:
    """Largest overlap in m when two spheres meet head-on at a relative `speed` (m/s); found to a few per cent, from above.

    No more than the diameter, where the centres coincide: a collision that reaches it goes beyond what bodies are.
    """
    heaviest = int(np.argmax(particles.mass))
    radius, reduced_mass = float(particles.radii[heaviest]), 0.5 * float(particles.mass[heaviest])
    energy = 0.5 * reduced_mass * speed * speed
    if not energy > 0.0:
        return 0.0
    return float(overlap_absorbing(law, pair.pair_scale(law, radius, radius), energy, 1e-12 * radius, 2.0 * radius))
