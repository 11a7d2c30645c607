"""How large a step may be: leap-frog diverges beyond 2/omega_max, and the stiffness that counts is that of unloading.

The highest eigenfrequency of spheres on contact springs obeys omega^2 <= 2 z k/m (Gershgorin: k the stiffest contact, z contacts on the
lightest sphere m; exact for a pair with z = 1). So the critical step is sqrt(2 m/(z k)), with k the bound that the law itself gives over
all histories up to the largest overlap that the scene can reach. Friction moves a sphere and turns it: its spring counts 1 + m R^2/I = 7/2
times. A damper of ratio z brings the limit down by sqrt(1 + z^2) - z.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch, pair
from contactlaws.compiled import kernel
from contactlaws.tangential import tangential_stiffness
from dem import ellipsoid_timestep as of_ellipsoids
from dem.particles import Particles
from dem.scene import Contact, Scene

FloatArray = npt.NDArray[np.float64]

#: equal spheres that can touch one
KISSING_NUMBER = 12
#: Itasca's safety factor for spheres that move and turn in three dimensions (Wahn, Gan & Kamlah 2022, Eq. 2.8)
ITASCA = 0.17
#: of the tangential spring of a solid sphere: 1 + m R^2/I
TURNING = 3.5
#: overlap over the radius at which a contact has a stiffness worth the name
SHALLOW = 1e-6


class TimeStep(NamedTuple):
    """The step of a run and what it was derived from."""

    dt: float  # s
    critical: float  # s; dt/critical is the fraction that was asked for
    stiffness: float  # N/m; bound of the pair's tangent, unloading included
    overlap: float  # m; of a pair, the largest that was reckoned with
    contacts: int  # on the lightest sphere
    itasca: float  # s; 0.17 sqrt(m/k) of the same m and k

    @property
    def note(self) -> str:
        """One line for the start of a run."""
        return (
            f"time step {self.dt:.3g} s, {self.dt / self.critical:.3g} of the critical {self.critical:.3g} s (unloading stiffness up to "
            f"{self.stiffness:.3g} N/m at an overlap of {self.overlap:.3g} m, {self.contacts} contacts); Itasca's is {self.itasca:.3g} s"
        )


def critical_step(mass: float, stiffness: float, contacts: int = KISSING_NUMBER) -> float:
    """Largest stable step in s for the lightest sphere (kg) on `contacts` springs of `stiffness` (N/m) to others no lighter.

    >>> critical_step(mass=2.0, stiffness=1.0, contacts=1) == 2.0 / math.sqrt(2.0 * 1.0 / 2.0)
    True
    """
    return math.sqrt(2.0 * mass / (contacts * stiffness))


def pair_stiffness(contact: Contact, radius_1: float, radius_2: float | None, overlap: float) -> float:
    """Largest stiffness in N/m of a contact up to `overlap` (m), friction included; radius_2 None: on a wall."""
    law = contact.normal
    scale = pair.wall_scale(law, radius_1) if radius_2 is None else pair.pair_scale(law, radius_1, radius_2, contact.share)
    stiffness = float(pair.pair_stiffness_bound(law, scale, overlap, contact.share))
    if contact.tangential is not None:
        # no contact is wider than the smaller sphere; an elastic one has a^2 = R d
        radius = radius_1 if radius_2 is None else radius_1 * radius_2 / (radius_1 + radius_2)
        widest = min(radius_1, radius_2 or radius_1, 1.5 * math.sqrt(radius * overlap))
        stiffness = max(stiffness, TURNING * float(tangential_stiffness(contact.tangential, widest)))
    return stiffness


def time_step(law: object, particles: Particles, overlap: float, fraction: float, contacts: int = KISSING_NUMBER) -> TimeStep:
    """`fraction` of the critical step for overlaps up to `overlap` (m, of a pair), from the lightest sphere meeting the largest one."""
    radii = particles.radii
    stiffness = pair_stiffness(Contact(law), float(radii.min()), float(radii.max()), overlap)
    return _step(float(particles.mass.min()), stiffness, overlap, fraction, contacts, 1.0)


def scene_time_step(scene: Scene, overlap: float, fraction: float) -> TimeStep:
    """`fraction` of the critical step of a scene: the smallest of all kinds of contact, dampers and density scaling included.

    Overlaps below a millionth of the largest radius count as that.
    """
    overlap = max(overlap, SHALLOW * float(scene.particles.radii.max()))
    return min(_steps(scene, overlap, fraction), key=lambda step: step.critical)


def _steps(scene: Scene, overlap: float, fraction: float) -> Iterator[TimeStep]:
    kind = scene.particles.kind
    of_kind = [np.ones(scene.particles.size, bool) if kind is None else kind == number for number in range(scene.kinds)]
    radii, masses = scene.particles.radii, scene.masses
    for one, mine in enumerate(of_kind):
        if not mine.any():
            continue
        for other, theirs in enumerate(of_kind):
            if theirs.any():
                contact = scene.contact_between(one, other)
                if scene.particles.axes is not None:
                    axes = scene.particles.axes
                    yield _ellipsoid_step(contact, axes[mine], axes[theirs], float(masses[mine].min()), overlap, fraction)
                    continue
                for mass, radius in _quickest(masses[mine], radii[mine], float(radii[theirs].max())):
                    stiffness = pair_stiffness(contact, radius, float(radii[theirs].max()), overlap)
                    yield _step(mass, stiffness, overlap, fraction, KISSING_NUMBER, _damping(contact))
        if any(scene.walls):
            contact = scene.contact_with_wall(one)
            if scene.particles.axes is not None:
                yield _ellipsoid_step(contact, scene.particles.axes[mine], None, float(masses[mine].min()), overlap, fraction)
                continue
            for mass, radius in _quickest(masses[mine], radii[mine], math.inf):
                stiffness = pair_stiffness(contact, radius, None, overlap)
                yield _step(mass, stiffness, overlap, fraction, KISSING_NUMBER, _damping(contact))


def _quickest(masses: FloatArray, radii: FloatArray, widest: float) -> set[tuple[float, float]]:
    """Mass and radius of the spheres whose contacts with one of the radius `widest` may ask for the smallest step.

    At a given overlap the stiffness of a contact grows with a power of the pair's radius from 0 to 1, by the law: the ends and Hertz's 1/2.
    """
    pair_radii = radii / (1.0 + radii / widest)
    found = {int(np.argmin(masses / pair_radii**power)) for power in (0.0, 0.5, 1.0)}
    return {(float(masses[row]), float(radii[row])) for row in found}


def _ellipsoid_step(
    contact: Contact, axes_1: FloatArray, axes_2: FloatArray | None, mass: float, overlap: float, fraction: float
) -> TimeStep:
    """Of the lightest of the first on contacts with the second, or on a wall (None)."""
    normal, sliding = of_ellipsoids.turning(axes_1)
    stiffness = normal * of_ellipsoids.stiffness(contact, axes_1, axes_2, overlap)
    stiffness = max(stiffness, sliding * of_ellipsoids.sliding_stiffness(contact, axes_1, axes_2, overlap))
    return _step(mass, stiffness, overlap, fraction, of_ellipsoids.contacts_on(axes_1), _damping(contact))


def _damping(contact: Contact) -> float:
    """By what a damper brings the critical step down."""
    ratio = 0.0 if contact.damping is None else contact.damping.ratio
    return math.hypot(1.0, ratio) - ratio


def _step(mass: float, stiffness: float, overlap: float, fraction: float, contacts: int, damping: float) -> TimeStep:
    critical = damping * critical_step(mass, stiffness, contacts)
    return TimeStep(fraction * critical, critical, stiffness, overlap, contacts, ITASCA * math.sqrt(mass / stiffness))


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
    if particles.axes is not None:
        return of_ellipsoids.collision_overlap(law, particles.axes, float(particles.mass[heaviest]), speed) if energy > 0.0 else 0.0
    if not energy > 0.0:
        return 0.0
    return float(overlap_absorbing(law, pair.pair_scale(law, radius, radius), energy, 1e-12 * radius, 2.0 * radius))
