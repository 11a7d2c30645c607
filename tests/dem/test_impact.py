"""Two spheres through the kernel against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from contactlaws.errors import InputError
from dem.impact import restitution

RADIUS, DENSITY = 5e-6, 4750.0
REDUCED_MASS = 0.5 * DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3

#: Thornton's closed form at V/V_y
RESTITUTION = {1.5: 0.97124, 2.0: 0.93063, 5.0: 0.77334, 10.0: 0.65856, 50.0: 0.44461, 100.0: 0.37430, 1000.0: 0.21070}


@pytest.mark.parametrize("speed", [1e-3, 0.1, 10.0])
def test_elastic_collision(hertz: Hertz, speed: float) -> None:
    """e = 1, the duration 2.94328 d/v and the depth d of Hertz's collision; 2000 steps in it leave some 1e-6 in time and depth."""
    found = restitution(hertz, RADIUS, DENSITY, [speed])
    depth = (15.0 * REDUCED_MASS * speed**2 / (16.0 * math.sqrt(RADIUS / 2.0) * hertz.reduced_modulus / 2.0)) ** 0.4
    assert found.restitution[0] == pytest.approx(1.0, abs=1e-6)
    assert found.largest_overlap[0] == pytest.approx(depth, rel=5e-6)
    assert found.contact_time[0] == pytest.approx(2.94328 * depth / speed, rel=1e-5)


@pytest.mark.compiled_only(reason="100 000 steps; elastic collisions are run interpreted")
@pytest.mark.parametrize("ratio", RESTITUTION)
def test_thorntons_restitution(soft_plastic: Thornton, ratio: float) -> None:
    """V_y is the speed whose energy takes both bodies to first yield, 8/15 E* sqrt(R) d_Y^2.5 each, d_Y = (pi p_Y/(2 E*))^2 R."""
    law = soft_plastic
    depth = (math.pi * law.yield_pressure / (2.0 * law.reduced_modulus)) ** 2 * law.radius
    energy = 2.0 * 8.0 / 15.0 * law.reduced_modulus * math.sqrt(law.radius) * depth**2.5
    yield_speed = math.sqrt(2.0 * energy / REDUCED_MASS)
    r = 1.0 / ratio
    closed = math.sqrt(6.0 * math.sqrt(3.0) / 5.0 * (1.0 - r * r / 6.0)) * (r / (r + 2.0 * math.sqrt(1.2 - 0.2 * r * r))) ** 0.25
    assert closed == pytest.approx(RESTITUTION[ratio], abs=6e-6)  # the table has five digits
    assert restitution(law, RADIUS, DENSITY, [ratio * yield_speed]).restitution[0] == pytest.approx(closed, rel=1e-3)


def test_slower_than_yield_is_elastic(soft_plastic: Thornton) -> None:
    assert restitution(soft_plastic, RADIUS, DENSITY, [5e-3]).restitution[0] == pytest.approx(1.0, abs=1e-6)


def test_restitution_does_not_know_the_size(soft_plastic: Thornton) -> None:
    """No material length: spheres ten times as big, of the same law, collide alike; contact times go with the size."""
    small, big = (restitution(soft_plastic, radius, DENSITY, [0.1]) for radius in (RADIUS, 10.0 * RADIUS))
    assert big.restitution[0] == pytest.approx(small.restitution[0], rel=1e-9)
    assert big.contact_time[0] == pytest.approx(10.0 * small.contact_time[0], rel=1e-9)


@pytest.mark.parametrize(("radius", "density", "speed"), [(-1.0, 1.0, 1.0), (1.0, math.nan, 1.0), (1.0, 1.0, 0.0), (1.0, 1.0, math.inf)])
def test_impossible_impacts(hertz: Hertz, radius: float, density: float, speed: float) -> None:
    with pytest.raises(InputError, match="positive"):
        restitution(hertz, radius, density, [speed])


def test_all_problems_at_once(hertz: Hertz) -> None:
    with pytest.raises(InputError) as caught:
        restitution(hertz, 0.0, 0.0, [1.0, -1.0, np.nan])
    assert len(caught.value.problems) == 4


def test_speeds_beyond_what_bodies_are(hertz: Hertz) -> None:
    """A sphere pressed by its radius is gone; an overlap of 1e-24 R is no overlap in double precision. Both at once, nothing computed."""
    with pytest.raises(InputError) as caught:
        restitution(hertz, RADIUS, DENSITY, [1.0, 1e6, 1e-30])
    assert [problem.value for problem in caught.value.problems] == [1e6, 1e-30]
    assert "body ends" in caught.value.problems[0].bound
    assert "round-off" in caught.value.problems[1].bound


def test_the_slowest_collision_that_is_taken(hertz: Hertz) -> None:
    """At an overlap near 1e-9 R positions are rounded to some 1e-7 of it, and energy is conserved to that."""
    speed = restitution(hertz, RADIUS, DENSITY, [3e-8])
    assert 1e-9 < speed.largest_overlap[0] / RADIUS < 1e-8
    assert speed.restitution[0] == pytest.approx(1.0, abs=1e-5)


def test_a_collision_that_does_not_end(hertz: Hertz, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dem.impact.LONGEST", 400)
    with pytest.raises(InputError, match="still in contact after 400 steps"):
        restitution(hertz, RADIUS, DENSITY, [1.0])
