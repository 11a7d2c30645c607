"""Published laws in time against their closed forms: restitution, slow and fast limits, relaxation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import beta

from contactlaws.dispatch import law_of, stiffness_bound
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.path import trace
from contactlaws.prony import PronyViscoelastic, Relaxation
from contactlaws.rivals.hertz_spring_dashpot import damping_ratio, hertz_spring_dashpot, restitution_of
from contactlaws.rivals.kuwabara_kono import (
    KuwabaraKono,
    brilliantov_dissipation,
    kuwabara_kono,
    relaxation_dissipation,
    viscous_dissipation,
)
from contactlaws.rivals.unloading import hertz
from contactlaws.rivals.wahn_gan_kamlah import wahn_gan_kamlah

GLASS = Material(70e9, 0.22, None, 2500.0)
RADIUS = 1e-3
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * 2500.0
#: of the paper: E1 404.6, E2 1365.9 MPa, tau 1.8 s, nu .4314
PVDF = Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,)).scaled(1.0 / (1.0 - 0.4314**2))


def collided(law: Any, mass: float, speed: float) -> float:
    """Restitution of a sphere of `mass` that meets a flat at `speed` (two equal spheres at twice that), by a high-order integration."""
    force = law_of(law).force
    depth = 0.01 * law.radius
    period = math.sqrt(mass / stiffness_bound(law, depth))

    def motion(t: float, y: Any) -> list[float]:
        return [y[1], -force(law, float(y[0]), float(y[1]), 0.0, (0.0, 0.0, 0.0))[0] / mass]

    def parted(t: float, y: Any) -> float:
        return float(y[0])

    parted.terminal, parted.direction = True, -1  # type: ignore[attr-defined]
    start = 1e-14 * law.radius
    way = solve_ivp(
        motion, (0.0, 1e6 * period), (start, speed), "DOP853", None, False, parted, rtol=1e-12, atol=(1e-3 * start, 1e-13 * speed),
        first_step=1e-9 * period,
    )  # fmt: skip
    return float(-way.y[1, -1] / speed)


@pytest.mark.parametrize("pull", [False, True])
@pytest.mark.parametrize("asked", [0.05, 0.1, 0.3, 0.5, 0.8, 0.95, 1.0])
@pytest.mark.parametrize("speed", [1e-3, 0.5])
def test_the_damper_returns_what_is_asked_at_any_speed(asked: float, pull: bool, speed: float):
    """The integration keeps 1e-11."""
    law = hertz_spring_dashpot(GLASS, RADIUS, asked, pull)
    assert collided(law, MASS, speed) == pytest.approx(asked, abs=1e-10)
    assert restitution_of(law.damping_ratio, pull) == pytest.approx(asked, rel=1e-12)


def test_a_factor_of_two_in_place_of_the_root_of_five_returns_too_much():
    """Wahn, Gan & Kamlah's Eq. 3.3 has 2 where sqrt(5) belongs."""
    found = [restitution_of(2.0 / math.sqrt(5.0) * damping_ratio(e, pull=True), pull=True) for e in (0.9, 0.7, 0.5, 0.3, 0.1)]
    assert found == pytest.approx([0.910, 0.727, 0.540, 0.346, 0.141], abs=6e-4)


def test_a_damper_made_to_pull_returns_more_when_it_is_cut_off():
    pulling = hertz_spring_dashpot(GLASS, RADIUS, 0.1, pull=True)
    cut = collided(pulling._replace(pull=0.0), MASS, 0.1)
    assert cut == pytest.approx(restitution_of(pulling.damping_ratio, pull=False), abs=1e-10)
    assert cut == pytest.approx(0.2527, abs=1e-4)


def test_damping_is_continuous_where_it_becomes_critical():
    """At e = exp(-2) the ratio is 1, from both formulas."""
    limit = math.exp(-2.0)
    ratios = [damping_ratio(limit * (1.0 + side), pull=False) for side in (-1e-9, 0.0, 1e-9)]
    assert ratios == pytest.approx([1.0, 1.0, 1.0], abs=1e-8)
    assert ratios[0] > ratios[2]


def test_a_moving_damper_adds_to_hertz_and_a_resting_one_does_not():
    """sqrt(5) z sqrt(m F_H/d) d': with two spheres, E* = E'/2, R/2, m/2 and the pair's overlap 2 d give the same."""
    law = hertz_spring_dashpot(GLASS, RADIUS, 0.5)
    d, rate = 1e-6, 0.3
    at_rest, moving = (law_of(law).force(law, d, speed, 1e-9, (0.0, 0.0, 0.0))[0] for speed in (0.0, rate))
    assert at_rest == pytest.approx(hertz(law.reduced_modulus, RADIUS, d), rel=1e-14)
    k_pair = 4.0 / 3.0 * 0.5 * law.reduced_modulus * math.sqrt(0.5 * RADIUS)
    pair = math.sqrt(5.0) * law.damping_ratio * math.sqrt(0.5 * MASS * k_pair) * (2.0 * d) ** 0.25 * 2.0 * rate
    assert moving - at_rest == pytest.approx(pair, rel=1e-12)


def test_ramirez_series_of_the_restitution():
    """e = 1 - C1 x + 3/5 C1^2 x^2 + O(x^2.5), x = 3/2 A (k/m)^(2/5) v^(1/5); C1 by the work of the damper on the elastic path."""
    c1 = 2.0 * 0.4 * beta(0.6, 1.5) * 1.25**0.6
    assert c1 == pytest.approx(1.15344, abs=1e-5)
    k, speed = 4.0 / 3.0 * GLASS.reduced_modulus * math.sqrt(RADIUS), 0.1
    for x in (1e-3, 1e-2):
        law = KuwabaraKono(RADIUS, GLASS.reduced_modulus, x / (1.5 * (k / MASS) ** 0.4 * speed**0.2))
        e = collided(law, MASS, speed)
        assert e == pytest.approx(1.0 - c1 * x + 0.6 * c1**2 * x**2, abs=x**2.5)


def test_slow_loading_is_a_relaxing_body_to_second_order():
    """After a ramp of duration T the rest is -.75 sum(g tau^2)/(1 - sum g)/T^2 of Hertz's force; the next term is tau/(2 T) of it."""
    modulus = Relaxation(1000.0, (0.2, 0.3), (0.4, 1.0))
    rest = (0.2 * 0.4**2 + 0.3) / 0.5
    slow, whole = kuwabara_kono(modulus, 1.0), maxwell_zener(modulus, 1.0)
    for duration in (50.0, 200.0):
        time = np.linspace(0.0, duration, 20_001)
        path = 1e-3 * time / duration
        force = [trace(law, path, time).force[-1] for law in (slow, whole)]
        expected = 0.75 * rest / duration**2
        assert (force[0] - force[1]) / hertz(slow.reduced_modulus, 1.0, 1e-3) == pytest.approx(expected, rel=1.0 / duration)


def test_dissipation_of_shear_and_bulk_follows_from_the_relaxation_of_both():
    """First order in time, whatever the fractions: of a Prony series eta = M_0 g tau."""
    body = PronyViscoelastic(1e9, 0.35, (0.5, 2.0), (0.3, 0.1), (0.05, 0.2))
    eta_g, eta_k = (m.instantaneous * sum(g * t for g, t in zip(m.fractions, m.times, strict=True)) for m in (body.shear, body.bulk))
    assert relaxation_dissipation(body.reduced) == pytest.approx(viscous_dissipation(body.long_term, eta_g, eta_k), rel=1e-10)


def test_brilliantovs_constant_is_right_for_viscosities_in_the_ratio_of_the_moduli_only():
    material, time = Material(1e9, 0.3), 0.01
    g, k = 1e9 / 2.6, 1e9 / 1.2
    assert viscous_dissipation(material, g * time, k * time) == pytest.approx(time, rel=1e-12)
    assert brilliantov_dissipation(material, g * time, k * time) == pytest.approx(time, rel=1e-12)
    soft = Material(1e9, 0.4999)
    assert brilliantov_dissipation(soft, 1e6, 1e6) < 1e-3 * viscous_dissipation(soft, 1e6, 1e6)


@pytest.mark.parametrize(("duration", "modulus"), [(1e-9, PVDF.instantaneous), (1e9, PVDF.long_term)])
def test_increments_meet_hertz_in_both_limits(duration: float, modulus: float):
    """What the first steps count too much is .06 of a thousandth to the power 1.5."""
    law = wahn_gan_kamlah(PVDF, 5e-6)
    path = np.linspace(0.0, 1e-7, 1001)
    force = trace(law, path, duration * path / 1e-7).force[-1]
    assert force == pytest.approx(hertz(modulus, 5e-6, 1e-7), rel=1e-5)


def test_increments_give_the_papers_ramp():
    """2 % in 1 s: 1.9615e-4 N, between 1.5822e-4 (long-term) and 2.0509e-4 (at once)."""
    law = wahn_gan_kamlah(PVDF, 5e-6)
    assert hertz(PVDF.long_term, 5e-6, 1e-7) == pytest.approx(1.5822e-4, abs=1e-8)
    assert hertz(PVDF.instantaneous, 5e-6, 1e-7) == pytest.approx(2.0509e-4, abs=1e-8)
    path = np.linspace(0.0, 1e-7, 1001)
    assert trace(law, path, path / 1e-7).force[-1] == pytest.approx(1.9615e-4, abs=1.5e-8)


def test_increments_pull_on_retreat_and_drift():
    """The flaws that are kept: after a pause at the top the contact pulls; in the end the spring branch has lost its zero."""
    law = wahn_gan_kamlah(PVDF, 5e-6)
    up = np.linspace(0.0, 1e-7, 101)
    path = np.concatenate((up, [1e-7], up[::-1][1:-1]))
    time = np.concatenate((up / 1e-7, [20.0], 20.0 + up[1:-1] / 1e-8))
    found = trace(law, path, time)
    assert found.force[-1] < -0.01 * found.force.max()
    # there and back at once, by other steps: a spring would be where it was
    back = up[::-20]
    there = trace(law, np.concatenate((up, back[1:-1])), np.zeros(up.size + back.size - 2)).force
    assert abs(there[-1] - hertz(PVDF.instantaneous, 5e-6, float(back[-2]))) > 1e-4 * there.max()


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: hertz_spring_dashpot(GLASS._replace(density=None), RADIUS, 0.5), "density"),
        (lambda: hertz_spring_dashpot(GLASS, RADIUS, 0.0), "restitution"),
        (lambda: hertz_spring_dashpot(GLASS, -1.0, 0.5), "radius"),
        (lambda: kuwabara_kono(Relaxation(1.0, (0.5,), (-1.0,)), 1.0), "relaxation_times"),
        (lambda: kuwabara_kono(Relaxation(-1.0), 1.0), "reduced_modulus"),
        (lambda: viscous_dissipation(GLASS, -1.0, 0.0), "shear_viscosity"),
        (lambda: viscous_dissipation(GLASS, 0.0, 0.0), "bulk_viscosity"),
        (lambda: brilliantov_dissipation(Material(1.0, 0.0), 1.0, 1.0), "poissons_ratio"),
        (lambda: wahn_gan_kamlah(Relaxation(1.0, (0.1, 0.2), (1.0, 2.0)), 1.0), "times"),
        (lambda: wahn_gan_kamlah(Relaxation(1.0, (0.1,), (1.0,)), 0.0), "radius"),
    ],
)
def test_constants_without_meaning_are_refused(make: Any, name: str):
    with pytest.raises(InputError, match=name):
        make()
