"""The Maxwell-Zener law with a memory of where the contact was: right also while it shrinks, parts and meets again.

The contact is the row of relaxing springs of `contactlaws.foundation`, of which a few are remembered; between them the springs' forces are
straight in the onset. For a modulus that does not relax, or has relaxed, they are straight, so the few springs then give the elastic law
exactly, and nothing can be gained on any path.

While the contact grows, all springs in it have moved alike since they touched, so the recurrence of `maxwell_zener` is exact, and of each
remembered spring only the time is noted at which it touched, with the state that the first spring then had: the force of a growing contact
costs no more than without this memory. When the contact shrinks, that is turned into the springs' own states, and these are followed one by
one: those that would pull let go, relax by themselves and are met again. The turning point is that of Ting (1966): the edge of the contact
is where the springs' force ends (`contactlaws.retreating_springs`). The springs' sum is scaled to meet the recurrence's force where the
contact turns, and so is their energy, of which the law's account of what is stored and lost is made: it does not drift over cycles.

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
from contactlaws.elastic import finite_size_area, largest_finite_size_stiffness
from contactlaws.errors import InputError, Problem
from contactlaws.maxwell_zener import (
    ELASTIC,
    FORCE,
    LOST,
    OVERLAP,
    WORK,
    MaxwellZener,
    forget,
    frozen,
    grow,
    maxwell_zener,
    problems_with_terms,
)
from contactlaws.prony import Relaxation
from contactlaws.remembered_springs import (
    AHEAD,
    DEEPEST,
    EDGE,
    FIRST,
    KEPT,
    SCALE,
    TIME,
    TOUCHED,
    begin_growth,
    begin_retreat,
    elastic_point,
    note_touching,
    weights,
)
from contactlaws.retreating_springs import retreat

FloatArray = npt.NDArray[np.float64]

#: the smallest onset remembered over the largest
SPAN = 1e-3


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
    onsets: FloatArray  # for each spring remembered: overlap (m), rising; weights of the interval before it (N/m)


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
    return MaxwellZenerTing(*plain, frozen(_table(plain, overlap)))


def _table(law: MaxwellZener | MaxwellZenerTing, overlap: FloatArray) -> FloatArray:
    """Rows of `onsets` for springs at these overlaps."""
    points = [elastic_point(law, d) for d in (0.0, *overlap.tolist())]
    return np.array([(high[0], *weights(low, high)) for low, high in zip(points[:-1], points[1:], strict=True)]).T.copy()


def _problems(law: MaxwellZenerTing) -> Iterator[Problem]:
    yield from problems_with_terms(law)  # type: ignore[arg-type]
    table = law.onsets
    if not (isinstance(table, np.ndarray) and table.ndim == 2 and table.shape[0] == 4 and table.shape[1] >= 1 and np.isfinite(table).all()):
        yield Problem("onsets", getattr(table, "shape", None), "must be four rows of finite numbers", "make the law with its function")
    elif not (table[0, 0] > 0.0 and (np.diff(table[0]) > 0.0).all()):
        yield Problem("onsets: overlap", table[0].tolist()[:5], "must be positive and rise", "make the law with its function")
    elif not np.allclose(table, _table(law, table[0]), rtol=1e-9, atol=0.0):
        bound = "do not belong to the elastic force"
        yield Problem("onsets: weights", table[1:, 0].tolist(), bound, "make the law with its function, for its radius and modulus")


@inlined
def maxwell_zener_ting_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """One step. What most contacts do, growing on to no further spring, is part of the caller; the rest is a call of its own."""
    if state[OVERLAP] <= overlap <= state[AHEAD]:
        force, elastic = grow(law, law.fractions, law.times, overlap, dt, state, FIRST, True)
        state[WORK] += 0.5 * (force + state[FORCE]) * (overlap - state[OVERLAP])
        state[TIME] += dt
        state[OVERLAP], state[ELASTIC], state[FORCE] = overlap, elastic, force
        return force, state
    return other_step(law, overlap, dt, state), state


@kernel
def other_step(law, overlap, dt, state):  # type: ignore[no-untyped-def]
    """A step of a contact that opens, begins, grows on to the next springs, or has turned: by the recurrence while it grows, by the springs
    otherwise."""
    if overlap <= 0.0:
        forget(state)
        return 0.0
    if state[SCALE] == 0.0 and overlap >= state[OVERLAP]:
        note_touching(law.times, law.onsets, overlap, dt, state)
        force, state[ELASTIC] = grow(law, law.fractions, law.times, overlap, dt, state, FIRST, True)
    else:
        if state[SCALE] == 0.0:
            state[DEEPEST] = state[OVERLAP]
            begin_retreat(law, state)
        force = retreat(law, overlap, dt, state)
    state[WORK] += 0.5 * (force + state[FORCE]) * (overlap - state[OVERLAP])
    if state[SCALE] > 0.0:
        state[LOST] = max(state[LOST], state[WORK] - state[KEPT])
    state[TIME] += dt
    state[OVERLAP], state[FORCE], state[DEEPEST] = overlap, force, max(overlap, state[DEEPEST])
    if state[SCALE] > 0.0 and overlap >= state[DEEPEST]:
        begin_growth(law, force, state)
    if state[SCALE] == 0.0:
        row = int(state[TOUCHED])
        state[AHEAD] = law.onsets[0, row] if row < law.onsets.shape[1] else 1e300
    else:
        state[AHEAD] = -1.0
    return force


@kernel
def maxwell_zener_ting_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """That of the elastic body at the overlap at which it touches as far."""
    return math.sqrt(finite_size_area(law, overlap if state[SCALE] == 0.0 else state[EDGE])) if overlap > 0.0 else 0.0


@kernel
def maxwell_zener_ting_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Work put in less what the dampers have taken, and that; of a contact that has opened all that was left is lost."""
    return state[WORK] - state[LOST], state[LOST]


@kernel
def largest_scale(law, low, deepest):  # type: ignore[no-untyped-def]
    """By how much the springs' sum may have to be scaled up where a contact turns at `deepest`, its last spring at `low`.

    The springs' force falls with the onset, ever faster; the most that straight lines miss is a force that is even up to the edge. That
    is of the part that relaxes; the rest is straight.
    """
    long_term = 1.0
    for i in range(law.fractions.size):
        long_term -= law.fractions[i]
    end = elastic_point(law, deepest)
    found = (end[1] - elastic_point(law, low)[1]) / (deepest - low)
    return 1.0 / (long_term + (1.0 - long_term) * min(1.0, found / end[2]))


@kernel
def maxwell_zener_ting_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The instantaneous elastic tangent, times the largest scale of the springs."""
    if overlap <= 0.0:
        return 0.0
    low, bound, scale = 0.0, 0.0, 1.0
    for row in range(law.onsets.shape[1] + 1):
        deepest = overlap if row == law.onsets.shape[1] else min(overlap, law.onsets[0, row])
        if deepest > low:
            scale = largest_scale(law, low, deepest) if row <= 1 else max(scale, largest_scale(law, low, deepest))
            bound = max(bound, scale * largest_finite_size_stiffness(law, deepest))
            low = deepest
    return bound


@kernel
def maxwell_zener_ting_row(law):  # type: ignore[no-untyped-def]
    """Floats of state."""
    terms = law.fractions.size
    return FIRST + 4 * terms + law.onsets.shape[1] * (terms + 1)


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
