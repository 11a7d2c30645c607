"""Hertz's spring and a damper that returns one coefficient of restitution at every speed.

F = F_H + sqrt(5) z sqrt(m F_H/d) d', F_H = 4/3 E* sqrt(R) d^1.5, of a sphere of mass m on a flat; of two spheres the same with E*, R and
m of the pair. The damper goes with d^(1/4) (Tsuji, Tanaka & Ishida 1992): with y = d^(5/4) as the coordinate and the path run through at
another pace, the collision is that of a linear spring and dashpot of damping ratio z (Antypov & Elliott 2011), so the restitution e is its:

    the damper pulls until the overlap is 0:   e = exp(-pi tan t),         sin t = z < 1, or z = -ln e/sqrt(pi^2 + ln^2 e)
    the force ends when it is 0:               e = exp(-(pi - 2 t) tan t), sin t = z;  e = exp(-2 u coth u), cosh u = z >= 1

(the second after Schwager & Poeschel 2007 for the linear dashpot). A damper made for the first and cut off returns too much: .253 for .1.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from scipy.optimize import brentq

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register
from contactlaws.elastic import hertz_contact_radius
from contactlaws.errors import Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.rivals.bounds import at_least
from contactlaws.rivals.damper import MEMORY, damped, damped_energy, secant


class HertzSpringDashpot(NamedTuple):
    """One body; made by `hertz_spring_dashpot`. A force that also depends on the mass belongs to spheres of this radius and mass alone.

    In a pair s times as large the same record damps with z/s, which is too little for large spheres: there make a law for each size.
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2)
    mass: float  # kg; of one sphere
    damping_ratio: float  # z
    pull: float  # 1: the damper may pull, until the overlap is 0; 0: the force is never below 0


def hertz_spring_dashpot(material: Material, radius: float, restitution: float, pull: bool = False) -> HertzSpringDashpot:
    """The law of spheres of `radius` (m) that part with `restitution` (0 < e <= 1) times the speed at which they met, at any speed.

    pull: the damper as published, which pulls at the end; otherwise the force is cut off at 0, and the damping ratio is the one that
    returns the restitution all the same. The material needs its density. Raises `InputError`.

    >>> nmc = Material(142e9, 0.25, density=4750.0)
    >>> [round(hertz_spring_dashpot(nmc, 5e-6, 0.5, pull).damping_ratio, 4) for pull in (False, True)]
    [0.2553, 0.2155]
    """
    require([*problems_with(material), *_problems(material, radius, restitution)])
    assert material.density is not None
    mass = 4.0 / 3.0 * math.pi * radius**3 * material.density
    return HertzSpringDashpot(radius, material.reduced_modulus, mass, damping_ratio(restitution, pull), float(pull))


def _problems(material: Material, radius: float, restitution: float) -> Iterator[Problem]:
    if material.density is None:
        yield Problem("density", None, "is missing", "a damper that returns a restitution depends on the mass: give it in kg/m3")
    if not (math.isfinite(radius) and radius > 0.0):
        yield Problem("radius", radius, "must be a positive finite number", "give it in m")
    if not 0.0 < restitution <= 1.0:
        yield Problem("restitution", restitution, "must lie in (0, 1]", "1 is no damper; 0 no damper can reach")


def damping_ratio(restitution: float, pull: bool) -> float:
    """z for a coefficient of restitution in (0, 1]."""
    lost = -math.log(restitution)
    if lost == 0.0:
        return 0.0
    if pull:
        return lost / math.hypot(math.pi, lost)
    if abs(lost - 2.0) < 1e-12:
        return 1.0
    if lost > 2.0:  # u lies below lost, since 2 u coth u is more than u
        return math.cosh(float(brentq(lambda u: 2.0 * u / math.tanh(u) - lost, 1e-9, lost, xtol=1e-14)))
    # by the angle that is missing to a right one: (pi - 2 t) tan t = 2 w/tan w
    return math.cos(float(brentq(lambda w: 2.0 * w / math.tan(w) - lost, 1e-9, 0.5 * math.pi, xtol=1e-14)))


def restitution_of(damping: float, pull: bool) -> float:
    """The coefficient of restitution that a damping ratio returns; with `pull`, 0 from a ratio of 1 on: the spheres never part.

    >>> round(restitution_of(damping_ratio(0.1, pull=True), pull=False), 4)
    0.2527
    """
    if damping < 1.0:
        t = math.asin(damping)
        return math.exp(-(math.pi - (0.0 if pull else 2.0 * t)) * math.tan(t))
    u = math.acosh(damping)
    return 0.0 if pull else math.exp(-2.0 * (u / math.tanh(u) if u > 1e-9 else 1.0))


@inlined
def hertz_spring_dashpot_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Spring and damper."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    damping = law.damping_ratio * math.sqrt(5.0 * law.mass * secant(law, overlap)) * rate
    return damped(law, overlap, damping, law.pull > 0.0, state)


@kernel
def hertz_spring_dashpot_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Not Hertz's tangent k alone but the spring that limits the time step as much as spring and damper do.

    Central differences with the damper's force are stable below 2/w (sqrt(1 + q^2) - q), w^2 = k/m, with the damper's q = c/(2 sqrt(k m)).
    """
    q = math.sqrt(5.0 / 6.0) * law.damping_ratio
    slower = math.sqrt(1.0 + q * q) + q
    return 1.5 * secant(law, max(overlap, 0.0)) * slower * slower


register(
    Law(
        "hertz_spring_dashpot",
        HertzSpringDashpot,
        hertz_spring_dashpot_force,
        hertz_contact_radius,
        damped_energy,
        hertz_spring_dashpot_stiffness_bound,
        MEMORY,
        "Antypov & Elliott 2011, EPL 94, 50004, with the damper of Tsuji, Tanaka & Ishida 1992, Powder Technol. 71, 239",
        at_least({"reduced_modulus": 0.0, "mass": 0.0}),
        in_time=True,
    )
)
