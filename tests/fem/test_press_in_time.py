"""Reference curves of viscoelastic bodies: their limits, their shape as curves, their scales, and what cannot be computed."""

from __future__ import annotations

import math
import sys
from functools import cache

import numpy as np
import pytest

from contactlaws.curve import Curve
from contactlaws.errors import InputError
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from fem.newton import NoEquilibrium
from fem.press import press
from fem.press_in_time import press_in_time
from fem.programme import START, Knot, Programme, creep, ramp_hold_release, sine, staircase
from fem.walk_in_time import _Walker

pytestmark = pytest.mark.compiled_only("a curve is some hundred assemblies of two meshes; interpreted, minutes")

NU = 0.3
HALF = Relaxation(1.0, (0.5,), (1.0,))
TOGETHER, CONSTANT_BULK = uniaxial(HALF, NU), uniaxial(HALF, NU, constant_bulk=True)
THREE = uniaxial(Relaxation(1.0, (0.3, 0.3, 0.3), (0.01, 1.0, 100.0)), NU)
DEPTH = 0.02
PROGRAMMES: dict[str, Programme] = {
    "ramp": ramp_hold_release(DEPTH, 1.0),
    "ramp, hold, release": ramp_hold_release(DEPTH, 1.0, 2.0, 1.0),
    "release at once": ramp_hold_release(DEPTH, 1.0, 0.0, 1e-9),
    "staircase": staircase([0.5 * DEPTH, DEPTH], 0.5, 1.0),
    "sine": sine(0.5 * DEPTH, 0.45 * DEPTH, 1.0, 2.0),
    "met again before it has recovered": (*ramp_hold_release(DEPTH, 1.0, 2.0, 0.2), Knot(3.5, 1.1 * DEPTH), Knot(4.5, 0.0)),
    "creep and recovery": creep(2e-3, 0.1, 5.0, 20.0),
}


@cache
def curve_of(name: str, material: PronyViscoelastic = CONSTANT_BULK) -> Curve:
    """One curve for all tests that look at it."""
    return press_in_time(material, PROGRAMMES[name])


@pytest.mark.parametrize("name", PROGRAMMES)
def test_a_curve_is_a_path_in_time(name: str):
    curve = curve_of(name)
    assert curve.in_time
    assert curve.stopped is None
    assert curve.series == CONSTANT_BULK
    assert curve.material == CONSTANT_BULK.instantaneous
    assert (np.diff(curve.time) >= 0.0).all()
    assert curve.force.min() >= 0.0
    assert curve.contact_radius is not None
    assert ((curve.contact_radius == 0.0) == (curve.force == 0.0)).all()
    # overlaps grow on even branches and shrink on odd ones, and each branch begins with the row that the one before ends with
    for k in range(int(curve.branch.max()) + 1):
        rows = curve.rows(k)
        assert (np.diff(curve.overlap[rows]) * (1.0 if k % 2 == 0 else -1.0) >= 0.0).all()
        if k:
            assert all(
                getattr(curve, column)[rows.start] == getattr(curve, column)[rows.start - 1] for column in ("time", "overlap", "force")
            )
    # nothing but these rows stands there twice, unless the programme jumps
    assert np.count_nonzero(np.diff(curve.time) == 0.0) == curve.branch.max()


def test_a_release_ends_at_the_separation():
    curve = curve_of("ramp, hold, release")
    assert curve.branch.max() == 1
    assert curve.force[-1] == 0.0
    assert (curve.force[1:-1] > 0.0).all()
    # the body has relaxed by then, so it is left with a dent; it is more than half recovered
    assert 0.05 * DEPTH < curve.overlap[-1] < 0.5 * DEPTH
    assert 3.5 < curve.time[-1] < 4.0


def test_the_force_is_zero_between_two_contacts():
    curve = curve_of("met again before it has recovered")
    off = np.flatnonzero(curve.force == 0.0)
    parted, met = off[1], off[off > off[1]]
    assert curve.branch[parted] == 1
    assert (np.diff(met[:-1]) == 1).all()
    # what is met again is a dent that has not gone yet, and less of one than was left behind
    again = met[:-1][-1]
    assert curve.branch[again] == 2
    assert 0.0 < curve.overlap[again] < curve.overlap[parted]


def expected_force(elastic: Curve, overlap: np.ndarray) -> np.ndarray:
    """An elastic curve between its rows, smooth as the power that it nearly is."""
    from scipy.interpolate import CubicSpline

    rows = elastic.rows(0)
    known = CubicSpline(np.log(elastic.overlap[rows][1:]), np.log(elastic.force[rows][1:]))
    return np.exp(known(np.log(overlap)))


@pytest.mark.parametrize("material", [TOGETHER, CONSTANT_BULK, THREE], ids=["nu constant", "K constant", "three terms"])
def test_infinitely_fast_and_slow_presses_are_elastic(material: PronyViscoelastic):
    for pace, other in ((1e-9, material.instantaneous), (1e9, material.long_term)):
        curve = press_in_time(material, ramp_hold_release(DEPTH, pace))
        elastic = press(other, max_overlap=DEPTH)
        row = curve.overlap >= elastic.overlap[1]
        expected = expected_force(elastic, curve.overlap[row])
        # what was aimed at, and is needed where Poisson's ratio changes: the mesh then ripples otherwise than the springs that even it out
        tolerance = 1e-3 if material == CONSTANT_BULK and pace > 1.0 else 2e-5  # else it is two readouts of the same numbers
        np.testing.assert_allclose(curve.force[row], expected, rtol=0, atol=tolerance * expected.max())


def test_a_body_that_does_not_relax_is_the_elastic_one():
    elastic = PronyViscoelastic(1.0, NU, (), ())
    curve = press_in_time(elastic, ramp_hold_release(DEPTH, 1.0, 1.0, 1.0))
    assert curve.force[-1] == 0.0
    assert abs(curve.overlap[-1]) < 1e-3 * DEPTH  # no dent is left: what the separation is found to
    known = press(elastic.instantaneous, max_overlap=DEPTH)
    row = curve.overlap >= known.overlap[1]
    # up and back along the same curve
    np.testing.assert_allclose(curve.force[row], expected_force(known, curve.overlap[row]), rtol=0, atol=5e-5 * curve.force.max())


def test_a_curve_lies_between_the_limits():
    curve = curve_of("ramp, hold, release")
    rows = (curve.branch == 0) & (curve.overlap > 0.1 * DEPTH)
    high, low = (
        expected_force(press(other, max_overlap=DEPTH), curve.overlap[rows])
        for other in (CONSTANT_BULK.instantaneous, CONSTANT_BULK.long_term)
    )
    assert (curve.force[rows] < high).all()
    assert (curve.force[rows] > low).all()


def test_radius_and_modulus_scale_the_force():
    """Two bodies that are the same in dimensionless numbers: what differs is round-off."""
    small, stiff = 5e-6, 2e9
    plain = curve_of("ramp, hold, release")
    programme = tuple(knot._replace(overlap=small * (knot.overlap or 0.0)) for knot in PROGRAMMES["ramp, hold, release"])
    curve = press_in_time(CONSTANT_BULK._replace(youngs_modulus=stiff), programme, radius=small)
    np.testing.assert_allclose(curve.overlap, small * plain.overlap, rtol=1e-9, atol=1e-12 * small)
    np.testing.assert_allclose(curve.force, stiff * small**2 * plain.force, rtol=0, atol=1e-8 * stiff * small**2 * plain.force.max())
    assert plain.contact_radius is not None
    np.testing.assert_allclose(curve.contact_radius, small * plain.contact_radius, rtol=0, atol=1e-8 * small)


def test_times_scale_with_the_relaxation_times():
    plain = curve_of("ramp, hold, release")
    programme = tuple(knot._replace(time=1e3 * knot.time) for knot in PROGRAMMES["ramp, hold, release"])
    slow = CONSTANT_BULK._replace(relaxation_times=tuple(1e3 * t for t in CONSTANT_BULK.relaxation_times))
    curve = press_in_time(slow, programme)
    np.testing.assert_allclose(curve.time, 1e3 * plain.time, rtol=1e-9)
    np.testing.assert_allclose(curve.force, plain.force, rtol=0, atol=1e-8 * plain.force.max())


def test_a_jump_is_elastic_and_then_relaxes():
    curve = press_in_time(TOGETHER, (START, Knot(0.0, DEPTH), Knot(1e4, DEPTH)))
    at_once = curve.force[curve.time == 0.0][-1]
    elastic = press(TOGETHER.instantaneous, max_overlap=DEPTH)
    assert at_once == pytest.approx(elastic.force[-1], rel=1e-4)  # two readouts of the same runs
    later = curve.time > 0.0
    np.testing.assert_allclose(curve.force[later] / at_once, HALF.at(curve.time[later]), rtol=5e-5)  # residuals of the solver


def test_creep_is_the_force_asked_for_and_ends_where_the_slow_press_does():
    force = 2e-3
    curve = press_in_time(CONSTANT_BULK, creep(force, 0.1, 1e4))
    held = curve.time >= 0.1
    np.testing.assert_array_equal(curve.force[held], force)
    elastic = press(CONSTANT_BULK.long_term, max_overlap=1.2 * float(curve.overlap[-1]))
    rows = elastic.rows(0)
    end = float(np.exp(np.interp(math.log(force), np.log(elastic.force[rows][1:]), np.log(elastic.overlap[rows][1:]))))
    # the contact has only grown; Poisson's ratio has not stayed, which the springs of the smooth curve do not know, and the mesh ripples
    assert curve.overlap[-1] == pytest.approx(end, rel=3e-3)


def test_creep_and_its_overlaps_prescribed_are_one_solution():
    crept = curve_of("creep and recovery", TOGETHER)
    rows = (crept.time <= 5.1) & (crept.branch == 0)
    programme = tuple(Knot(*row) for row in zip(crept.time[rows].tolist(), crept.overlap[rows].tolist(), strict=True))
    back = press_in_time(TOGETHER, programme)
    held = (back.time > 0.1) & (back.time <= 5.1)
    # between the rows the force went straight there, the overlap here: half a per cent with 20 steps a segment
    np.testing.assert_allclose(back.force[held], 2e-3, rtol=0.01)


def test_a_dent_recovers():
    curve = curve_of("creep and recovery", TOGETHER)
    off = curve.time >= 5.2 - 1e-9
    assert (curve.force[off] == 0.0).all()
    dent = curve.overlap[off]
    assert dent[0] > 0.05 * curve.overlap.max()
    assert (np.diff(dent) < 0.0).all()
    # the retardation time is 2 s: exp(-10) is left of it after 20 s
    assert 0.3 * math.exp(-10.0) < dent[-1] / dent[0] < 3.0 * math.exp(-10.0)


@pytest.mark.parametrize("aspect", [0.5, 2.0])
def test_spheroids(aspect: float):
    """At a small overlap they are spheres of the pole's radius of curvature, aspect squared."""
    depth = 1e-4
    curve = press_in_time(TOGETHER, ramp_hold_release(depth, 1e-9), aspect=aspect)
    hertz = 4.0 / 3.0 / (1.0 - NU**2) * aspect * depth**1.5
    assert curve.aspect == aspect
    assert curve.force[-1] == pytest.approx(hertz, rel=0.02)  # a finite body: one and a half contact radii over the radius, at most
    assert curve.contact_radius is not None
    assert curve.contact_radius[-1] == pytest.approx(aspect * depth**0.5, rel=0.02)


def test_the_stated_error_covers_a_finer_mesh():
    usual = curve_of("ramp, hold, release")
    finer = press_in_time(CONSTANT_BULK, PROGRAMMES["ramp, hold, release"], tolerance=0.005)
    difference = np.abs(np.interp(usual.time, finer.time, finer.force) - usual.force).max() / finer.force.max()
    assert difference < usual.errors["force"] < 0.01


@pytest.mark.parametrize(
    ("material", "programme", "options", "words"),
    [
        (TOGETHER._replace(relaxation_times=(-1.0,)), PROGRAMMES["ramp"], {}, ["relaxation_times[1] = -1.0: must be a positive number"]),
        (TOGETHER._replace(shear_fractions=(1.0,)), PROGRAMMES["ramp"], {}, ["shear_fractions[1] = 1.0: must lie in [0, 1)"]),
        (TOGETHER._replace(poissons_ratio=0.5), PROGRAMMES["ramp"], {}, ["poissons_ratio = 0.5"]),
        (TOGETHER, PROGRAMMES["ramp"], {"radius": -1.0}, ["radius = -1.0"]),
        (TOGETHER, PROGRAMMES["ramp"], {"aspect": 20.0}, ["aspect = 20.0"]),
        (TOGETHER, PROGRAMMES["ramp"], {"tolerance": 1e-6}, ["tolerance = 1e-06"]),
        (TOGETHER, (START, Knot(1.0, 0.7)), {}, ["largest overlap over radius = 0.7: must lie between 1e-07 and 0.6"]),
        (TOGETHER, (START, Knot(1.0, force=3.0)), {}, ["largest overlap over radius = ", "press less"]),
        (TOGETHER, (START, Knot(1.0, 1e-9)), {}, ["largest overlap over radius = 1e-09", "press more"]),
        (TOGETHER, (START, Knot(1.0, -0.1)), {}, ["never touches"]),
        (TOGETHER, (START, Knot(1.0, 0.1, 1.0)), {"radius": math.nan}, ["radius = nan", "exactly one of overlap and force"]),
    ],
)
def test_what_cannot_be_computed_is_said_once(
    material: PronyViscoelastic, programme: Programme, options: dict[str, float], words: list[str]
):
    with pytest.raises(InputError) as error:
        press_in_time(material, programme, **options)
    assert len(error.value.problems) == (len(words) if "radius = nan" in words else 1)
    assert all(word in str(error.value) for word in words), str(error.value)


def stopping(at: float, meshes: tuple[int, ...]) -> type:
    """A walker that finds no equilibrium from time `at` on, on the meshes of these numbers of degrees of freedom."""

    class Stopping(_Walker):
        time = 0.0

        def to(self, step: float, control: float, by_force: bool) -> None:
            if self.time + step > at and self.solver.body.dofs in meshes:
                raise NoEquilibrium("as asked for")
            super().to(step, control, by_force)
            self.time += step

    return Stopping


def sizes() -> list[int]:
    """Degrees of freedom of the coarse and of the fine mesh."""
    found: list[int] = []
    with pytest.MonkeyPatch.context() as patch:
        module = sys.modules["fem.press_in_time"]  # `fem.press_in_time` itself is the function
        whole = module.walk_in_time  # type: ignore[attr-defined]

        def watched(body, *arguments):  # type: ignore[no-untyped-def]
            found.append(body.dofs)
            return whole(body, *arguments)

        patch.setattr(module, "walk_in_time", watched)
        press_in_time(TOGETHER, PROGRAMMES["ramp"])
    return found


def test_a_run_that_stops_keeps_what_it_has(monkeypatch: pytest.MonkeyPatch):
    """Whichever mesh stops, the curve ends there and says why."""
    both = sizes()
    assert both[0] < both[1]
    whole = press_in_time(TOGETHER, PROGRAMMES["ramp, hold, release"])
    for mesh in both:
        monkeypatch.setattr("fem.walk_in_time._Walker", stopping(1.5, (mesh,)))
        curve = press_in_time(TOGETHER, PROGRAMMES["ramp, hold, release"])
        assert curve.stopped is not None
        assert "as asked for" in curve.stopped
        assert 1.0 < curve.time[-1] <= 1.5
        rows = whole.time <= curve.time[-1]
        shared = np.isin(curve.time, whole.time)
        np.testing.assert_allclose(
            curve.force[shared], whole.force[rows][np.isin(whole.time[rows], curve.time)], rtol=0, atol=2e-3 * whole.force.max()
        )


def test_a_run_that_never_gets_anywhere_is_an_error(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("fem.walk_in_time._Walker", stopping(1e-9, tuple(sizes())))
    with pytest.raises(InputError, match=r"stops before the contact is resolved: .*as asked for"):
        press_in_time(TOGETHER, PROGRAMMES["ramp"])
