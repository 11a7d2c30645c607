"""The Maxwell-Zener law with a memory of where the contact was: right also while it shrinks, parts and meets again.

The contact is the row of relaxing springs of `contactlaws.foundation`, of which a few are remembered; between them the springs' forces are
straight in the onset. For a modulus that does not relax, or has relaxed, they are straight, so the few springs then give the elastic law
exactly, and nothing can be gained on any path.

While the contact grows, all springs in it have moved alike since they touched, so the recurrence of `maxwell_zener` is exact, and of each
remembered spring only the time is noted at which it touched, with the state that the first spring then had: the force of a growing contact
costs no more than without this memory. When the contact shrinks, that is turned into the springs' own states, and these are followed one by
one: those that would pull let go, relax by themselves and are met again. The turning point is that of Ting (1966): the edge of the contact
is where the springs' force ends. The springs' sum is scaled to meet the recurrence's force where the contact turns.

A contact whose overlap is back at 0 is forgotten, though the body may still be dented there: the next contact then begins too early.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register
from contactlaws.elastic import finite_size_area, finite_size_force, finite_size_stiffness, largest_finite_size_stiffness
from contactlaws.errors import InputError, Problem
from contactlaws.maxwell_zener import ELASTIC, FORCE, LOST, OVERLAP, WORK, decay, forget, frozen, grow, maxwell_zener, problems_with_terms
from contactlaws.prony import Relaxation

FloatArray = npt.NDArray[np.float64]

#: after the first five floats of `maxwell_zener`: time since the contact began (s), largest overlap and edge (m), number of springs that
#: have touched, and the scale of the springs' sum, 0 while the contact grows.
#: Then for each term f_i and q_i as there (while the springs are followed: exp(-dt/tau_i) and the share held), and the state of the first
#: spring (m); then for each spring, while the contact grows, the time at which it touched and the state of the first one then, and while
#: they are followed its own state.
TIME, DEEPEST, EDGE, TOUCHED, SCALE, FIRST = range(5, 11)
#: the smallest onset remembered over the largest
SPAN = 1e-3
#: the springs' sum is met within this share where the contact turns: the tangent may be larger by it
SLACK = 0.02


class MaxwellZenerTing(NamedTuple):
    """One body on a rigid flat; made by `maxwell_zener_ting`. Parameters as in `contactlaws.maxwell_zener.MaxwellZener`."""

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2) at once
    force_1: float  # c1, c2, c3; 0 is Hertz
    force_2: float
    force_3: float
    area_1: float  # a^2 = R d (1 + b1 sqrt(D) + b2 D^2)
    area_2: float
    fractions: FloatArray  # g_i of the reduced modulus
    times: FloatArray  # tau_i in s, rising
    onsets: FloatArray  # for each spring remembered: overlap (m), rising; elastic force (N) and its slope (N/m) there


def maxwell_zener_ting(
    modulus: Relaxation, radius: float, poissons_ratio: float | None = None, largest: float = 0.3, springs: int = 12
) -> MaxwellZenerTing:
    """The law of a body, as `contactlaws.maxwell_zener.maxwell_zener`, with `springs` remembered per contact.

    largest: overlap over the radius up to which they lie, evenly in its logarithm, down to a thousandth of it; beyond, a contact that
    shrinks is followed less closely. Raises `InputError`.
    """
    plain = maxwell_zener(modulus, radius, poissons_ratio)
    if not (0.0 < largest < 1.0 and springs >= 1):
        raise InputError(Problem("springs", (largest, springs), "need a largest overlap in (0, 1) and at least one", "0.3 and 12 will do"))
    overlap = largest * radius * (np.geomspace(SPAN, 1.0, springs) if springs > 1 else np.array([0.2]))
    rows = [(d, finite_size_force(plain, d), finite_size_stiffness(plain, d)) for d in overlap.tolist()]
    return MaxwellZenerTing(*plain, frozen(np.array(rows).T.copy()))


def _problems(law: MaxwellZenerTing) -> Iterator[Problem]:
    yield from problems_with_terms(law)  # type: ignore[arg-type]
    table = law.onsets
    if not (isinstance(table, np.ndarray) and table.ndim == 2 and table.shape[0] == 3 and table.shape[1] >= 1 and np.isfinite(table).all()):
        yield Problem("onsets", getattr(table, "shape", None), "must be three rows of finite numbers", "make the law with its function")
    elif not (table[0, 0] > 0.0 and (np.diff(table[0]) > 0.0).all()):
        yield Problem("onsets: overlap", table[0].tolist()[:5], "must be positive and rise", "make the law with its function")


@kernel
def note_touching(law, overlap, dt, state):  # type: ignore[no-untyped-def]
    """While the contact grows through a step: when the springs in its way were touched, and the first spring's state then and after it."""
    terms, before = law.fractions.size, state[OVERLAP]
    moved, own = overlap - before, FIRST + 2 * terms
    row = int(state[TOUCHED])
    while row < law.onsets.shape[1] and law.onsets[0, row] < overlap:
        part = (law.onsets[0, row] - before) / moved
        place = own + terms + row * (terms + 1)
        state[place] = state[TIME] + part * dt
        for i in range(terms):
            e, h = decay(part * dt / law.times[i])
            state[place + 1 + i] = e * state[own + i] + h * part * moved
        row += 1
    state[TOUCHED] = row
    for i in range(terms):
        e, h = decay(dt / law.times[i])
        state[own + i] = e * state[own + i] + h * moved


@kernel
def piece(left, right, low, high):  # type: ignore[no-untyped-def]
    """Integral of F_e'' times a straight line from `left` to `right`; low, high: overlap, elastic force and slope at the ends."""
    return right * high[2] - left * low[2] - (right - left) / (high[0] - low[0]) * (high[1] - low[1])


@kernel
def onset(law, row):  # type: ignore[no-untyped-def]
    """Overlap, elastic force and slope of a remembered spring; row -1 is the first spring, at 0."""
    if row < 0:
        return 0.0, 0.0, 0.0
    return law.onsets[0, row], law.onsets[1, row], law.onsets[2, row]


@kernel
def spring_place(law, row):  # type: ignore[no-untyped-def]
    """Where in the state a spring's own state begins."""
    terms = law.fractions.size
    return FIRST + 2 * terms if row < 0 else FIRST + 3 * terms + row * (terms + 1) + 1


@kernel
def elastic_point(law, overlap):  # type: ignore[no-untyped-def]
    """Overlap, elastic force and slope."""
    return overlap, finite_size_force(law, overlap), finite_size_stiffness(law, overlap)


@kernel
def begin_retreat(law, state):  # type: ignore[no-untyped-def]
    """Turn times of touching into the springs' states, and scale their sum to the force at hand."""
    terms, own = law.fractions.size, FIRST + 2 * law.fractions.size
    for row in range(int(state[TOUCHED])):
        place = spring_place(law, row)
        past = state[TIME] - state[place - 1]
        for i in range(terms):
            state[place + i] = state[own + i] - math.exp(-past / law.times[i]) * state[place + i]
    long_term = 1.0
    for i in range(terms):
        long_term -= law.fractions[i]
    total, low, left = 0.0, (0.0, 0.0, 0.0), 0.0
    for row in range(-1, int(state[TOUCHED])):
        point, place = onset(law, row), spring_place(law, row)
        push = long_term * (state[OVERLAP] - point[0])
        for i in range(terms):
            push += law.fractions[i] * state[place + i]
        if row >= 0:
            total += piece(left, push, low, point)
        low, left = point, push
    if state[OVERLAP] > low[0]:
        total += piece(left, 0.0, low, elastic_point(law, state[OVERLAP]))
    state[SCALE] = state[FORCE] / total if total > 0.0 else 1.0


@kernel
def begin_growth(law, force, state):  # type: ignore[no-untyped-def]
    """Turn the springs' states into times of touching and forces of the terms, at the largest overlap, where `force` acts."""
    terms, own, overlap = law.fractions.size, FIRST + 2 * law.fractions.size, state[OVERLAP]
    end = elastic_point(law, overlap)
    relaxing, found = 0.0, 0.0
    for i in range(terms):
        total, energy, low, left = 0.0, 0.0, (0.0, 0.0, 0.0), state[own + i]
        for row in range(int(state[TOUCHED]) + 1):
            last = row == int(state[TOUCHED])
            point = end if last else onset(law, row)
            right = 0.0 if last else state[spring_place(law, row) + i]
            if point[0] > low[0]:
                total += piece(left, right, low, point)
                energy += (point[2] - low[2]) * (left * left + left * right + right * right) / 3.0
            low, left = point, right
        state[FIRST + i], state[FIRST + terms + i] = total, energy
        relaxing += law.fractions[i]
        found += law.fractions[i] * total
    missing = (force - (1.0 - relaxing) * end[1] - found) / relaxing
    for i in range(terms):
        state[FIRST + i] += missing
    for row in range(int(state[TOUCHED])):
        place = spring_place(law, row)
        state[place - 1] = state[TIME]
        for i in range(terms):
            state[place + i] = state[own + i] - state[place + i]
    state[ELASTIC], state[SCALE] = end[1], 0.0


@kernel
def move_spring(law, place, at, overlap, onset_overlap, long_term, at_once, touched, state):  # type: ignore[no-untyped-def]
    """Take one spring through a step: its force over stiffness (below zero: what it would pull, were it held), and what it dissipates."""
    terms = law.fractions.size
    past, left = 0.0, 0.0
    for i in range(terms):
        past += law.fractions[i] * state[place + i]
        left += law.fractions[i] * state[FIRST + i] * state[place + i]
    length = at - onset_overlap
    if not touched:
        length = 0.0
    elif long_term * length + past <= 0.0:
        length = -past / long_term  # it was off the flat: nothing held it
    added = overlap - onset_overlap - length
    push = long_term * length + left + at_once * added
    if push <= 0.0:
        added -= push / at_once
    lost = 0.0
    for i in range(terms):
        e, h, z = state[FIRST + i], state[FIRST + terms + i], state[place + i]
        state[place + i] = e * z + h * added
        # of the dampers: straight motion makes the strain go to h added/(1 - e)
        gone = 1.0 - e
        x = gone / h
        steady = x / 3.0 if x < 1e-3 else (x - 2.0 * gone + 0.5 * gone * (1.0 + e)) / (x * x)
        lost += law.fractions[i] * max(0.0, 0.5 * z * z * gone * (1.0 + e) + z * added * h * gone + added * added * steady)
    return push, lost


@kernel
def retreat(law, overlap, dt, state):  # type: ignore[no-untyped-def]
    """Take all springs through a step to `overlap`: force in N. Notes the edge and what was dissipated."""
    terms, at = law.fractions.size, state[OVERLAP]
    long_term, at_once = 1.0, 1.0
    for i in range(terms):
        e, h = decay(dt / law.times[i])
        state[FIRST + i], state[FIRST + terms + i] = e, h
        long_term -= law.fractions[i]
        at_once -= law.fractions[i] * (1.0 - h)
    deepest = max(state[DEEPEST], overlap)
    total, dissipated, edge = 0.0, 0.0, 0.0
    low, left, before = (0.0, 0.0, 0.0), 0.0, 0.0
    row, last = -1, False
    while not last:
        last = row >= law.onsets.shape[1] or (row >= 0 and law.onsets[0, row] >= deepest)
        if last:  # the spring at the largest overlap has not been touched
            point, right, lost = elastic_point(law, deepest), at_once * (overlap - deepest), 0.0
        else:
            point = onset(law, row)
            right, lost = move_spring(law, spring_place(law, row), at, overlap, point[0], long_term, at_once, row < state[TOUCHED], state)
        if row >= 0 and point[0] > low[0]:
            dissipated += 0.5 * (lost + before) * (point[2] - low[2])
            if left > 0.0 and right > 0.0:
                total += piece(left, right, low, point)
                edge = point[0]
            elif left > 0.0 or right > 0.0:
                between = low[0] + (point[0] - low[0]) * left / (left - right)
                middle = elastic_point(law, between)
                if left > 0.0:
                    edge = between
                    if between > low[0]:
                        total += piece(left, 0.0, low, middle)
                else:
                    edge = point[0]
                    if point[0] > between:
                        total += piece(0.0, right, middle, point)
        low, left, before = point, right, lost
        row += 1
    state[TOUCHED], state[EDGE] = row - 1, edge
    state[LOST] += state[SCALE] * dissipated
    return state[SCALE] * max(0.0, total)


@inlined
def maxwell_zener_ting_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """One step: by the recurrence while the contact grows, by the springs otherwise."""
    if overlap <= 0.0:
        forget(state)
        return 0.0, state
    if state[SCALE] == 0.0 and overlap >= state[OVERLAP]:
        note_touching(law, overlap, dt, state)
        force, state[ELASTIC] = grow(law, overlap, dt, state, FIRST)
        state[EDGE] = overlap
    else:
        force = turned(law, overlap, dt, state)
    state[WORK] += 0.5 * (force + state[FORCE]) * (overlap - state[OVERLAP])
    state[TIME] += dt
    state[OVERLAP], state[FORCE], state[DEEPEST] = overlap, force, max(overlap, state[DEEPEST])
    if state[SCALE] > 0.0 and overlap >= state[DEEPEST]:
        begin_growth(law, force, state)
    return force, state


@kernel
def turned(law, overlap, dt, state):  # type: ignore[no-untyped-def]
    """A step of a contact that shrinks, or has shrunk and not yet grown back."""
    if state[SCALE] == 0.0:
        begin_retreat(law, state)
    return retreat(law, overlap, dt, state)


@kernel
def maxwell_zener_ting_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """That of the elastic body at the overlap at which it touches as far."""
    return math.sqrt(finite_size_area(law, min(state[EDGE], state[DEEPEST]))) if overlap > 0.0 else 0.0


@kernel
def maxwell_zener_ting_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Work put in less what the dampers have taken, and that; of a contact that has opened all that was left is lost."""
    return state[WORK] - state[LOST], state[LOST]


@kernel
def maxwell_zener_ting_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The instantaneous elastic tangent, with the slack of the springs' scale."""
    return (1.0 + SLACK) * largest_finite_size_stiffness(law, max(overlap, 0.0))


@kernel
def maxwell_zener_ting_row(law):  # type: ignore[no-untyped-def]
    """Floats of state."""
    terms = law.fractions.size
    return FIRST + 3 * terms + law.onsets.shape[1] * (terms + 1)


register(
    Law(
        "maxwell_zener_ting",
        MaxwellZenerTing,
        maxwell_zener_ting_force,
        maxwell_zener_ting_contact_radius,
        maxwell_zener_ting_energy,
        maxwell_zener_ting_stiffness_bound,
        ("overlap", "elastic_force", "force", "work", "dissipated", "time", "largest_overlap", "edge", "springs"),
        "Lee & Radok 1960; Ting 1966, J. Appl. Mech. 33, 845, as independent springs (Popov & Hess 2013); finite size as maxwell_zener",
        _problems,
        maxwell_zener_ting_row,
        in_time=True,
    )
)
