"""The stress at a point: yield on the true stress, plastic incompressibility, and confined compression in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from fem.mesh import FloatArray
from fem.newton import Moduli
from fem.stress import artanh_over, artanh_over_slope, hencky_deviator, norm_squared, radial_return, sinh_over, volumetric_energy
from tests.fem.bodies import ELASTIC, NEARLY_INCOMPRESSIBLE, PLASTIC, Material, displacements, patch, von_mises

BODY = patch()
thorough = settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])


@thorough
@given(st.lists(displacements, min_size=1, max_size=4), st.sampled_from([PLASTIC, NEARLY_INCOMPRESSIBLE]))
def test_any_path_keeps_to_the_yield_surface(path: list[FloatArray], moduli: Moduli):
    """After every step: true von Mises stress not above Y, equal to it where the point has just flowed, flow without change of volume."""
    material = Material(BODY, moduli)
    for displacement in path:
        before = material.plastic_strain
        try:
            material.forces(displacement)
        except AssertionError:
            assume(False)  # an element inside out
        material.go(displacement)
        stress, flowed = von_mises(material.stress), material.plastic_strain > before
        # a difference of stresses of the size of the moduli: round-off relative to those
        atol = 1e-14 * max(1.0, np.abs(material.stress).max())
        assert stress.max() <= moduli[2] + 10 * atol
        np.testing.assert_allclose(stress[flowed], moduli[2], rtol=1e-12, atol=10 * atol)
        c = material.history
        np.testing.assert_allclose((c[..., 0] * c[..., 1] - c[..., 2] ** 2) * c[..., 3], 1.0, rtol=1e-12)
        assert (material.plastic_strain >= before).all()
        assert material.dissipated >= 0.0
        assert (material.dissipated > 0.0) == bool(flowed.any())


@thorough
@given(st.lists(displacements, min_size=1, max_size=4))
def test_elastic_path_leaves_no_trace(path: list[FloatArray]):
    material = Material(BODY, ELASTIC)
    for displacement in [*path, np.zeros((9, 2))]:
        material.go(displacement)
        assert material.dissipated == 0.0
    np.testing.assert_allclose(material.stress, 0.0, atol=1e-13)
    np.testing.assert_allclose(material.stored, 0.0, atol=1e-26)  # square of round-off
    assert not material.plastic_strain.any()


def confined(stretch: float) -> FloatArray:
    """Compressed along the axis with no strain across."""
    z = BODY.section.mesh.p[1]
    return np.stack([np.zeros_like(z), (stretch - 1.0) * z], axis=1)


@pytest.mark.parametrize("steps", [1, 7])
def test_confined_compression_and_release(steps: int):
    """Closed form at finite strain: elastic, plastic with the true stress on yield, elastic release, plastic release; any number of steps.

    With stretch s (= J): axial stress K ln s + 2/3 d, across K ln s - 1/3 d; the difference d is 2 G ln s / s until it reaches -Y, then -Y;
    after turning at s0, d = (-s0 Y + 2 G ln(s/s0))/s until it reaches Y.
    """
    bulk, shear, flow = PLASTIC
    material = Material(BODY, PLASTIC)
    turn = 0.75
    assert 2.0 * shear * abs(math.log(turn)) / turn > 2.0 * flow  # well beyond yield

    def check(stretch: float, difference: float) -> None:
        mean = bulk * math.log(stretch)
        expected = [mean - difference / 3.0, mean + 2.0 * difference / 3.0, 0.0, mean - difference / 3.0]
        np.testing.assert_allclose(material.stress, np.broadcast_to(expected, material.stress.shape), rtol=0, atol=1e-13)

    first = 0.97
    material.go(confined(first))
    check(first, 2.0 * shear * math.log(first) / first)
    for stretch in np.linspace(first, turn, steps + 1)[1:]:
        material.go(confined(float(stretch)))
        check(float(stretch), -flow)
    plastic = material.plastic_strain.copy()
    for stretch in (0.76, 0.78):
        material.go(confined(stretch))
        check(stretch, (-turn * flow + 2.0 * shear * math.log(stretch / turn)) / stretch)
    np.testing.assert_array_equal(material.plastic_strain, plastic)  # the release is elastic
    for stretch in np.linspace(0.85, 1.0, steps):
        material.go(confined(float(stretch)))
        check(float(stretch), flow)


def test_release_to_the_turning_point_returns():
    """Off and on again within yield: the same stress and no more plastic strain."""
    material = Material(BODY, PLASTIC)
    material.go(confined(0.8))
    stress, plastic = material.stress, material.plastic_strain
    material.go(confined(0.82))
    material.go(confined(0.8 + 1e-9))
    np.testing.assert_allclose(material.stress, stress, atol=1e-7)  # 1e-9 in stretch times the moduli
    np.testing.assert_allclose(material.plastic_strain, plastic, atol=1e-15)


stretches = st.floats(0.2, 4.0)  # squared


@given(stretches, stretches, stretches, st.floats(0.0, math.pi))
def test_hencky_deviator_is_the_logarithm_in_the_principal_axes(b1: float, b2: float, b3: float, angle: float):
    c, s = math.cos(angle), math.sin(angle)
    a, h, k = hencky_deviator(b1 * c * c + b2 * s * s, b1 * s * s + b2 * c * c, (b1 - b2) * c * s, b3)
    e1, e2, e3 = (0.5 * math.log(b) for b in (b1, b2, b3))
    mean, half = (e1 + e2 + e3) / 3.0, 0.5 * (e1 - e2)
    expected = (0.5 * (e1 + e2) - mean, half * math.cos(2.0 * angle), half * math.sin(2.0 * angle))
    assert (a, h, k) == pytest.approx(expected, rel=1e-13, abs=1e-14)  # the tensor's own round-off where the eigenvalues differ much
    squares = sum((e - mean) ** 2 for e in (e1, e2, e3))
    assert norm_squared(a, h, k) == pytest.approx(squares, rel=1e-12, abs=1e-28)


@pytest.mark.parametrize("x", [1e-9, 1e-3, 0.03, 0.0999999, 0.1000001, 0.3, 0.3162277, 0.3162279, 0.9])
def test_series_meet_the_closed_forms(x: float):
    """artanh(x)/x, its derivative with x^2 and sinh(x)/x, on both sides of where the series end, against sums of many terms."""
    square = x * x
    value = sum(square**n / (2 * n + 1) for n in range(300))
    slope = sum(n * square ** (n - 1) / (2 * n + 1) for n in range(1, 300))
    assert artanh_over(square) == pytest.approx(value, rel=4e-16)
    # beyond the series the difference of two numbers near 1 that is .007 at least
    assert artanh_over_slope(square, artanh_over(square)) == pytest.approx(slope, rel=1e-15 if x < 0.1 else 5e-14)
    assert sinh_over(square) == pytest.approx(math.fsum(square**n / math.factorial(2 * n + 1) for n in range(12)), rel=4e-16)


@given(*[st.floats(-0.5, 0.5)] * 3)
def test_return_is_radial(a: float, h: float, k: float):
    ratio, square = radial_return(a, h, k, 2.0, 0.2)
    trial = 2.0 * 2.0 * math.sqrt(1.5 * ((a + h) ** 2 + (a - h) ** 2 + 2.0 * k * k + 4.0 * a * a))
    assert square == pytest.approx(trial**2, rel=1e-13, abs=1e-300)
    assert ratio * trial == pytest.approx(min(trial, 0.2), rel=1e-13, abs=1e-300)
    assert 0.0 < ratio <= 1.0


@given(st.floats(0.3, 3.0))
def test_volumetric_energy_is_the_work_of_the_pressure(dilatation: float):
    """K (J ln J - J + 1) is the integral of K ln J; by Gauss-Legendre on 20 points, exact to round-off here."""
    x, w = np.polynomial.legendre.leggauss(20)
    half = 0.5 * (dilatation - 1.0)
    assert volumetric_energy(4.0, dilatation) == pytest.approx(
        float((4.0 * np.log(1.0 + half * (1.0 + x)) * w).sum() * half), rel=1e-9, abs=1e-16
    )


def test_volumetric_energy_has_no_seam():
    """The series near J = 1 meets the closed form, which has lost 10 digits to cancellation there."""
    for side in (-1.0, 1.0):
        inside, outside = (volumetric_energy(1.0, 1.0 + side * x) / x**2 for x in (0.999999e-3, 1.000001e-3))
        assert inside == pytest.approx(outside, rel=1e-8)
