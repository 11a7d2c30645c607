"""Published laws through the kernel that collides two spheres, against their closed forms."""

from __future__ import annotations

import math
from typing import Any

import pytest

import dem
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.prony import Relaxation
from contactlaws.rivals.becker_kamlah import PUBLISHED, BeckerKamlah
from contactlaws.rivals.hertz_spring_dashpot import hertz_spring_dashpot, restitution_of
from contactlaws.rivals.kuwabara_kono import kuwabara_kono
from contactlaws.rivals.wahn_gan_kamlah import wahn_gan_kamlah
from dem import impact
from dem.box import Box
from dem.forces import LOST
from dem.impact import closing_speed, restitution
from dem.motion import Deformation
from dem.particles import spheres
from dem.timestep import collision_overlap, time_step
from dem.working import follow, working

RADIUS, DENSITY = 5e-6, 4750.0
REDUCED_MASS = 0.5 * DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3


@pytest.mark.compiled_only(reason="100 000 steps of a collision")
@pytest.mark.parametrize(("ratio", "expected"), [(2.0, 0.96379), (10.0, 0.72611)])
def test_becker_kamlahs_restitution(ratio: float, expected: float) -> None:
    """Equal NMC spheres, made a thousand times softer so that speeds are small; V_y as for Thornton's law with p_Y = 1.6 Y."""
    law = BeckerKamlah(RADIUS, 142e6 / (1.0 - 0.25**2), 7.9e6, **PUBLISHED)
    depth = (math.pi * 1.6 * law.yield_stress / (2.0 * law.reduced_modulus)) ** 2 * law.radius
    energy = 2.0 * 8.0 / 15.0 * law.reduced_modulus * math.sqrt(law.radius) * depth**2.5
    speed = ratio * math.sqrt(2.0 * energy / REDUCED_MASS)
    # some 2000 steps in the collision leave less than 1e-3, as in the test of Thornton's law
    assert restitution(law, RADIUS, DENSITY, [speed]).restitution[0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.compiled_only(reason="millions of steps")
@pytest.mark.parametrize("pull", [False, True])
@pytest.mark.parametrize("asked", [0.05, 0.1, 0.3, 0.5, 0.8, 0.95])
def test_the_damper_returns_what_is_asked(asked: float, pull: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A damper is given the velocity of half a step ago, so its error goes with the step: 1e-4 at the usual 2000 steps, 1e-6 at 200 000."""
    law = hertz_spring_dashpot(Material(1e7, 0.3, None, 2500.0), 1e-3, asked, pull)
    speeds = [1e-2, 1.0]
    assert restitution(law, 1e-3, 2500.0, speeds).restitution == pytest.approx(asked, abs=1e-4)
    monkeypatch.setattr(impact, "FRACTION", 1e-2 * impact.FRACTION)
    assert restitution(law, 1e-3, 2500.0, speeds).restitution == pytest.approx(asked, abs=1e-6)


@pytest.mark.compiled_only(reason="thousands of steps")
def test_a_damper_belongs_to_spheres_of_its_own_size() -> None:
    """Spheres s times as large are damped with the ratio z/s; 1e-4 as above."""
    law = hertz_spring_dashpot(Material(1e7, 0.3, None, 2500.0), 1e-3, 0.5)
    for s in (0.5, 2.0):
        found = restitution(law, s * 1e-3, 2500.0, [0.1]).restitution[0]
        assert found == pytest.approx(restitution_of(law.damping_ratio / s, pull=False), abs=1e-4)


@pytest.mark.compiled_only(reason="thousands of steps")
def test_ramirez_restitution_falls_with_the_fifth_root_of_the_speed() -> None:
    """x = 3/2 A (k/m)^(2/5) v^(1/5), all of the pair; beyond x^2 there is x^2.5, and the error of the step, below 1e-5."""
    modulus, radius, density = Relaxation(1e7, (0.01,), (2e-5,)), 1e-3, 2500.0
    law = kuwabara_kono(modulus, radius)
    k = 4.0 / 3.0 * 0.5 * law.reduced_modulus * math.sqrt(0.5 * radius)
    mass = 0.5 * density * 4.0 / 3.0 * math.pi * radius**3
    for speed in (1e-3, 1e-1):
        x = 1.5 * law.dissipation_time * (k / mass) ** 0.4 * speed**0.2
        expected = 1.0 - 1.15344 * x + 0.6 * 1.15344**2 * x**2
        assert restitution(law, radius, density, [speed]).restitution[0] == pytest.approx(expected, abs=x**2.5 + 1e-5)


@pytest.mark.compiled_only(reason="thousands of steps")
def test_a_slow_collision_is_that_of_a_relaxing_body() -> None:
    """The relaxation time is less than 1/500 of the collision's; the next term of the loss is a few times that, over the first."""
    modulus, radius, density = Relaxation(1e7, (0.3,), (1e-6,)), 1e-3, 2500.0
    laws = kuwabara_kono(modulus, radius), maxwell_zener(modulus, radius)
    damped, relaxing = (restitution(law, radius, density, [1e-2]) for law in laws)
    ratio = 1e-6 / damped.contact_time[0]
    assert ratio < 1.0 / 500.0
    assert 1.0 - relaxing.restitution[0] == pytest.approx(1.0 - damped.restitution[0], rel=5.0 * ratio)


SLOW = Relaxation(1e7, (0.5,), (1e-3,))


@pytest.mark.parametrize(
    ("law", "missing"),
    [
        # these know their energy by the work of each step, as the simulation does
        (maxwell_zener(SLOW, 1e-3), 1e-11),
        (maxwell_zener_ting(SLOW, 1e-3, springs=4), 1e-11),
        # the elastic energy in closed form: second order in the step
        (hertz_spring_dashpot(Material(1e7, 0.3, None, 2500.0), 1e-3, 0.3), 1e-4),
        (kuwabara_kono(SLOW._replace(times=(1e-4,)), 1e-3), 1e-4),
        # pulled to the end, where the force jumps: first order
        (wahn_gan_kamlah(SLOW, 1e-3), 3e-3),
    ],
    ids=["maxwell_zener", "maxwell_zener_ting", "hertz_spring_dashpot", "kuwabara_kono", "wahn_gan_kamlah"],
)
def test_what_a_collision_loses_is_in_the_simulations_account(law: Any, missing: float) -> None:
    """Kinetic energy before and after against the energy of the contact that has ended, over the energy before."""
    speed, radius = 0.1, 1e-3
    bodies = spheres([[0.0, 0.0, 0.0], [2.0 * radius, 0.0, 0.0]], radius, 2500.0, [[0.5 * speed, 0.0, 0.0], [-0.5 * speed, 0.0, 0.0]])
    dt = time_step(law, bodies, collision_overlap(law, bodies, speed), 0.01, contacts=1).dt
    box = Box((20.0 * radius,) * 3, (False, False, False))
    work = working(dem.Scene(bodies, box, dem.Contact(law), (dem.hold(1.0),), skin=0.5))
    work, _ = follow(work, Deformation(box.cell, box.cell, 1, dt), 0, 2000)
    assert closing_speed(work) < 0.0
    memory = work.groups[0].past.memory
    assert memory is not None
    assert not memory.any()
    before, after = (0.25 * float(bodies.mass[0]) * v**2 for v in (speed, closing_speed(work)))
    assert work.tally[0, LOST] > 0.1 * before
    assert before - after == pytest.approx(work.tally[0, LOST], abs=missing * before)
