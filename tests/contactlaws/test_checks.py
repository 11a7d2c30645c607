"""The checks find what is wrong with a wrong law, and only that."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import pytest

from contactlaws.checks import check
from contactlaws.dispatch import Law, register
from contactlaws.errors import InputError

njit = numba.njit(error_model="numpy")


@njit
def spring_contact_radius(law, overlap, state):
    return math.sqrt(law.radius * max(overlap, 0.0))


@njit
def spring_energy(law, overlap, state):
    return 0.5 * max(overlap, 0.0) ** 2, 0.0


@njit
def unit_stiffness(law, overlap):
    return 1.0


@njit
def spring_force(law, overlap, rate, dt, state):
    return max(overlap, 0.0), state


@njit
def sticky_force(law, overlap, rate, dt, state):
    return overlap - 0.1 * law.radius if overlap > 0.0 else 0.0, state


@njit
def generous_force(law, overlap, rate, dt, state):
    """Pushes back harder than it was pushed in."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    return (2.0 * overlap if overlap < state[0] else overlap), (max(overlap, state[0]),)


@njit
def stepped_force(law, overlap, rate, dt, state):
    if overlap <= 0.0:
        return 0.0, state
    return overlap * (1.0 if overlap < 0.03 * law.radius else 1.001), state


@njit
def oiled_force(law, overlap, rate, dt, state):
    """A spring and a damper that cannot pull; remembers overlap, force and what the damper took."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    force = max(0.0, overlap + law.damping * rate)
    moved = overlap - state[0]
    taken = 0.5 * (force + state[1]) * moved - 0.5 * (overlap * overlap - state[0] * state[0])
    return force, (overlap, force, state[2] + taken)


@njit
def oiled_energy(law, overlap, state):
    return 0.5 * max(overlap, 0.0) ** 2, state[2] + (0.5 * state[0] ** 2 if overlap <= 0.0 and state[1] == 0.0 else 0.0)


class Oiled(NamedTuple):
    radius: float
    damping: float


class Spring(NamedTuple):
    radius: float


class Sticky(NamedTuple):
    radius: float


class Generous(NamedTuple):
    radius: float


class Stepped(NamedTuple):
    radius: float


for record, force, memory in (
    (Spring, spring_force, ()),
    (Sticky, sticky_force, ()),
    (Generous, generous_force, ("largest",)),
    (Stepped, stepped_force, ()),
):
    register(Law(f"test_{record.__name__}", record, force, spring_contact_radius, spring_energy, unit_stiffness, memory, "this test"))
OILED = ("overlap", "force", "taken")
register(Law("test_oiled", Oiled, oiled_force, spring_contact_radius, oiled_energy, unit_stiffness, OILED, "this test", in_time=True))


def failures(law) -> set[str]:
    return {finding.name for finding in check(law, 0.1 * law.radius, paths=4) if not finding.passed}


def test_a_users_own_law_passes():
    assert failures(Spring(1.0)) == set()


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (Sticky(1.0), {"no tension", "work is stored or dissipated"}),
        (Generous(1.0), {"unloading starts on the loading", "no energy from a closed path", "stiffness bound holds"}),
        (Stepped(1.0), {"loading is continuous", "stiffness bound holds"}),
    ],
    ids=["sticky", "generous", "stepped"],
)
def test_a_wrong_law_is_found_out(law, expected):
    assert expected <= failures(law)


def test_a_users_own_law_in_time_passes():
    assert failures(Oiled(1.0, 0.5)) == set()


def test_a_motor_is_found_out():
    """A damper with the wrong sign gives energy."""
    assert {"dissipation never falls", "no energy from a closed path"} <= failures(Oiled(1.0, -0.5))


def test_a_duration_must_be_positive():
    with pytest.raises(InputError, match="duration"):
        check(Oiled(1.0, 0.5), 0.1, duration=0.0)


def test_a_range_must_be_positive():
    with pytest.raises(InputError, match="max_overlap"):
        check(Spring(1.0), -1.0)
