"""Rigid bodies that turn: order of the scheme, what it conserves, and tops with closed forms."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from dem.rotation import Shapes, inertia_of, matrices, rotational_energy, shapes_of, turn

FloatArray = npt.NDArray[np.float64]
MASS = np.array([2.0])


def top(axes: tuple[float, float, float], spin: tuple[float, float, float]) -> tuple[Shapes, FloatArray]:
    """One body at (1, 0, 0, 0) that turns with `spin` (1/s)."""
    rate = np.array([spin])
    return shapes_of(np.array([axes]), np.array([[1.0, 0.0, 0.0, 0.0]]), MASS, rate), rate


def advance(shapes: Shapes, rate: FloatArray, dt: float, steps: int, torque: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
    """Kick half, turn, kick half, with a constant torque (N m)."""
    load = np.array([[torque]])
    state = (shapes.orientation, shapes.momentum, shapes.ease, shapes.axes, shapes.surface, rate)
    for _ in range(steps):
        turn(*state, load, 0.0, 1.0, 0.5 * dt, dt, 0, 1)
        turn(*state, load, 0.5 * dt, 1.0, 0.0, 0.0, 0, 1)


def body_rates(shapes: Shapes, rate: FloatArray) -> FloatArray:
    """Spin in the body's own frame."""
    return np.asarray(np.einsum("nab,na->nb", matrices(shapes.orientation), rate)[0])


def test_inertia_is_that_of_a_solid_ellipsoid() -> None:
    """m (b^2 + c^2)/5; of a sphere 2/5 m r^2."""
    assert inertia_of(MASS, np.array([[3.0, 2.0, 1.0]]))[0] == pytest.approx([2.0, 4.0, 5.2])
    assert inertia_of(MASS, np.ones((1, 3)))[0] == pytest.approx([0.8] * 3)


def test_free_top_keeps_its_angular_momentum_to_the_last_bit_and_its_norm() -> None:
    shapes, rate = top((3.0, 2.0, 1.0), (0.3, 5.0, 0.2))
    before = shapes.momentum.copy()
    advance(shapes, rate, 0.05, 20_000)
    assert np.array_equal(shapes.momentum, before)
    assert np.linalg.norm(shapes.orientation) == pytest.approx(1.0, abs=1e-15)


def test_energy_of_a_free_top_does_not_drift() -> None:
    """It waves with the square of the step, but stays: over 200,000 steps no more than over 2,000."""
    worst = []
    for steps in (2_000, 200_000):
        shapes, rate = top((3.0, 2.0, 1.0), (0.3, 5.0, 0.2))
        start, largest = rotational_energy(shapes), 0.0
        for _ in range(200):
            advance(shapes, rate, 0.02, steps // 200)
            largest = max(largest, abs(rotational_energy(shapes) / start - 1.0))
        worst.append(largest)
    assert worst[1] < 1.5 * worst[0]
    assert worst[1] < 1e-3


def test_order_is_two() -> None:
    """Orientation after a second of a top that tumbles, against a step a hundred times smaller."""
    ends = []
    for steps in (100, 200, 400, 20_000):
        shapes, rate = top((3.0, 2.0, 1.0), (1.0, 2.0, 3.0))
        advance(shapes, rate, 1.0 / steps, steps, torque=(0.5, -1.0, 2.0))
        ends.append(shapes.orientation[0].copy())
    errors = [float(np.abs(end - ends[-1]).max()) for end in ends[:-1]]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("axes", [(2.0, 2.0, 1.0), (1.0, 1.0, 2.0)])
def test_symmetric_top_precesses_as_it_should(axes: tuple[float, float, float]) -> None:
    """The axis goes round the angular momentum at L/I_1, the body turns about it at a constant rate; second order, 1e-6 at this step."""
    shapes, rate = top(axes, (1.0, 0.0, 3.0))
    across, along = 1.0 / shapes.ease[0, 0], 1.0 / shapes.ease[0, 2]
    momentum = shapes.momentum[0]
    duration, steps = 2.0, 20_000
    advance(shapes, rate, duration / steps, steps)
    angle = np.linalg.norm(momentum) / across * duration
    axis = momentum / np.linalg.norm(momentum)
    start = np.array([0.0, 0.0, 1.0])
    expected = start * math.cos(angle) + np.cross(axis, start) * math.sin(angle) + axis * (axis @ start) * (1.0 - math.cos(angle))
    assert matrices(shapes.orientation)[0, :, 2] == pytest.approx(expected, abs=1e-6)
    own = body_rates(shapes, rate)
    turned = (across - along) / across * 3.0 * duration  # Euler: the rates turn in the body
    assert own == pytest.approx([math.cos(turned), -math.sin(turned), 3.0], abs=1e-6)


def test_only_the_middle_axis_is_unstable() -> None:
    """A spin about the middle axis, a millionth off, turns over; about the others it stays. Growth as exp of Euler's rate."""
    for axis in range(3):
        spin = [1e-6, 1e-6, 1e-6]
        spin[axis] = 1.0
        shapes, rate = top((3.0, 2.0, 1.0), (spin[0], spin[1], spin[2]))
        least = 1.0
        for _ in range(200):
            advance(shapes, rate, 0.01, 50)
            least = min(least, float(body_rates(shapes, rate)[axis]))
        assert (least < -0.99) if axis == 1 else (least > 1.0 - 1e-10)


def test_growth_of_the_middle_axis_is_eulers() -> None:
    """Small rates across grow with sqrt((I2 - I1)(I3 - I2)/(I1 I3)) times the spin; 1e-3 for what is not small, and the step."""
    shapes, rate = top((3.0, 2.0, 1.0), (0.0, 1.0, 1e-7))
    one, two, three = (1.0 / shapes.ease[0]).tolist()
    growth = math.sqrt((two - one) * (three - two) / (one * three))
    advance(shapes, rate, 0.002, 10_000)
    assert abs(body_rates(shapes, rate)[2]) == pytest.approx(1e-7 * math.cosh(growth * 20.0), rel=1e-3)


@pytest.mark.parametrize("angle", [1e-9, 0.2, 1.0, 50.0])
def test_a_million_turns_a_second(angle: float) -> None:
    """A needle that turns about a principal axis by `angle` in a step: exact however large, but for the round-off of its sum."""
    shapes, rate = top((5e-6, 5e-7, 5e-7), (0.0, 0.0, 1e6))
    start = rotational_energy(shapes)
    advance(shapes, rate, angle * 1e-6, 1000)
    assert rotational_energy(shapes) == pytest.approx(start, rel=1e-12)
    x = matrices(shapes.orientation)[0, :, 0]
    assert x == pytest.approx([math.cos(1000 * angle), math.sin(1000 * angle), 0.0], abs=1e-9)


def test_torque_gives_angular_momentum() -> None:
    """A constant torque for a second."""
    shapes, rate = top((3.0, 2.0, 1.0), (1.0, 0.0, 0.0))
    before = shapes.momentum[0].copy()
    advance(shapes, rate, 1e-3, 1000, torque=(1.0, 2.0, -3.0))
    assert shapes.momentum[0] - before == pytest.approx([1.0, 2.0, -3.0], rel=1e-12)
