"""The exact history of a viscoelastic contact: a row of springs, each with its own unilateral contact.

An elastic contact F_e(d), convex and without slope at the start, is the sum of springs that touch the flat one after the other: the
density of those that touch at the overlap l is F_e''(l). For a half-space pressed by a sphere that is more than bookkeeping: the
transformation that makes of the surface a row of independent springs (Popov & Hess 2013) is linear and knows no time, so with a relaxing
modulus each spring relaxes on its own, and leaves or meets the flat on its own. While the contact grows this is Lee & Radok's integral
(1960); on a first retreat it is Ting's solution (1966), for the separation condition int_{t1}^{t} psi(t - s) d'(s) ds = 0 says that the
spring l = d(t1) carries no force; for any other history it goes on being exact. What is not in it: a Poisson's ratio that changes in time
(a sphere's force then knows more than E*), and what large strains add while the contact shrinks.

Steps are implicit and the springs' lengths linear in time within a step, so a step may be far longer than any relaxation time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from contactlaws.errors import Problem, require
from contactlaws.maxwell_element import damped
from contactlaws.maxwell_element import decay as decay_of
from contactlaws.prony import Relaxation, problems_with_modulus

FloatArray = npt.NDArray[np.float64]


class Springs(NamedTuple):
    """Where springs touch the flat, and how stiff they are at once."""

    onset: FloatArray  # overlap, rising
    stiffness: FloatArray  # force per overlap; all together at an overlap d: dF_e/dd


class History(NamedTuple):
    """What the springs did, one row per time."""

    overlap: FloatArray
    force: FloatArray
    edge: FloatArray  # onset where the springs' force ends; the elastic body touches as far at that overlap
    stored: FloatArray  # energy in the springs, also those off the flat
    dissipated: FloatArray  # by their dampers; with what is stored, the work done but for the length of the steps, to second order


def springs_of(elastic_force: Callable[[FloatArray], FloatArray], largest: float, count: int, smallest: float = 1e-6) -> Springs:
    """Springs whose force is `elastic_force` at their onsets, which are spaced evenly in the root of the overlap, up to `largest`."""
    share = np.linspace(0.0, 1.0, count + 1)
    onset = largest * (smallest + (1.0 - smallest) * share) * share
    return springs_through(onset, elastic_force(onset))


def springs_through(overlap: FloatArray, force: FloatArray) -> Springs:
    """Springs whose elastic force is the straight line from row to row; the first row is 0, 0."""
    return Springs(overlap[:-1], np.diff(np.diff(force) / np.diff(overlap), prepend=0.0))


def follow(springs: Springs, modulus: Relaxation, time: npt.ArrayLike, control: npt.ArrayLike, by_force: npt.ArrayLike = False) -> History:
    """Take the springs through the rows of `control`, overlaps or (where `by_force`) forces, at `time` (s), from the unstrained state.

    modulus: only its fractions and times count, the springs' stiffness being the instantaneous one. The first row is where it starts.
    Raises `InputError`.
    """
    times, values = np.array(time, dtype=np.float64), np.array(control, dtype=np.float64)
    require([*problems_with_modulus(modulus), *_problems_with_programme(times, values)])
    forced = np.broadcast_to(np.asarray(by_force, dtype=np.bool_), times.shape).copy()
    columns = _follow(springs.onset, springs.stiffness, np.array(modulus.fractions), np.array(modulus.times), times, values, forced)
    return History(*columns)


def _problems_with_programme(time: FloatArray, control: FloatArray) -> Iterator[Problem]:
    if time.ndim != 1 or time.size == 0 or time.shape != control.shape:
        yield Problem("control", control.shape, f"must be one row, as long as that of the times, {time.shape}", "give one value per time")
    elif not (np.isfinite(time).all() and np.isfinite(control).all()):
        yield Problem("control", control.size, "must be finite numbers, and so must the times", "remove or repair the rows")
    elif np.any(np.diff(time) < 0.0):
        yield Problem("time", float(time[1:][np.diff(time) < 0.0][0]), "must not decrease", "put the rows in order")


@kernel
def held_share(step, times, decay, held):  # type: ignore[no-untyped-def]
    """For one time step: how much of each term is left, and how much of what is added evenly within the step."""
    for i in range(times.size):
        decay[i], held[i] = decay_of(step / times[i])


@kernel
def _spring_force(long_term, fractions, decay, held, length, strain, row, added):  # type: ignore[no-untyped-def]
    """Force over stiffness of one spring whose length grows by `added` in the step."""
    force = long_term * (length + added)
    for i in range(fractions.size):
        force += fractions[i] * (decay[i] * strain[row, i] + held[i] * added)
    return force


@kernel
def _total(overlap, onset, stiffness, long_term, at_once, fractions, decay, held, length, strain):  # type: ignore[no-untyped-def]
    """Force of all springs with the flat at `overlap`, and its slope."""
    force, slope = 0.0, 0.0
    for k in range(onset.size):
        one = _spring_force(long_term, fractions, decay, held, length[k], strain, k, overlap - onset[k] - length[k])
        if one > 0.0:
            force += stiffness[k] * one
            slope += stiffness[k] * at_once
    return force, slope


@kernel
def _follow(onset, stiffness, fractions, times, time, control, by_force):  # type: ignore[no-untyped-def]
    rows, terms = time.size, times.size
    long_term = 1.0 - fractions.sum()
    length, strain = np.zeros(onset.size), np.zeros((onset.size, terms))
    decay, held = np.empty(terms), np.empty(terms)
    overlap, force, edge, stored, dissipated = np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows), np.zeros(rows)
    flat, lost = 0.0, 0.0
    for n in range(rows):
        held_share(time[n] - time[n - 1] if n > 0 else 0.0, times, decay, held)
        at_once = long_term
        for i in range(terms):
            at_once += fractions[i] * held[i]
        if by_force[n]:
            flat = _overlap_for(control[n], flat, onset, stiffness, long_term, at_once, fractions, decay, held, length, strain)
        else:
            flat = control[n]
        total, kept, last = 0.0, 0.0, 0.0
        for k in range(onset.size):
            added = flat - onset[k] - length[k]
            one = _spring_force(long_term, fractions, decay, held, length[k], strain, k, added)
            if one > 0.0:
                total += stiffness[k] * one
                edge[n] = max(onset[k], flat) if k == onset.size - 1 else onset[k]
            else:
                if k > 0 and last > 0.0:
                    edge[n] = onset[k - 1] + (onset[k] - onset[k - 1]) * last / (last - one)
                added -= one / at_once
            last = one
            energy, gone = _move(long_term, fractions, decay, held, length, strain, k, added, one > 0.0)
            kept += stiffness[k] * energy
            lost += stiffness[k] * gone
        overlap[n], force[n], stored[n], dissipated[n] = flat, total, kept, lost
    return overlap, force, edge, stored, dissipated


@kernel
def _move(long_term, fractions, decay, held, length, strain, row, added, pressed):  # type: ignore[no-untyped-def]
    """Lengthen one spring by `added` in the step; its energy then and what its dampers took, both over its stiffness.

    Of a spring that ends off the flat, motion is not straight; what it loses is energy, and the work of a force that falls to zero.
    """
    before, after, push, taken = (
        0.5 * long_term * length[row] ** 2,
        0.5 * long_term * (length[row] + added) ** 2,
        long_term * length[row],
        0.0,
    )
    for i in range(fractions.size):
        old = strain[row, i]
        strain[row, i] = decay[i] * old + held[i] * added
        before += 0.5 * fractions[i] * old**2
        after += 0.5 * fractions[i] * strain[row, i] ** 2
        push += fractions[i] * old
        taken += fractions[i] * damped(old, added, decay[i], held[i])
    length[row] += added
    return after, taken if pressed else max(0.0, 0.5 * max(push, 0.0) * added + before - after)


@kernel
def _overlap_for(target, flat, onset, stiffness, long_term, at_once, fractions, decay, held, length, strain):  # type: ignore[no-untyped-def]
    """The overlap at which the springs carry `target`: Newton's method from above, where the force is convex; at 0 they just touch."""
    if target <= 0.0:
        # the flat where it meets the first spring, which nothing holds
        touching = 1e300
        for k in range(onset.size):
            free = _spring_force(long_term, fractions, decay, held, length[k], strain, k, 0.0)
            touching = min(touching, onset[k] + length[k] - free / at_once)
        return touching
    step = max(abs(flat), 1e-12 * onset[-1])
    high = flat
    for _ in range(200):
        if _total(high, onset, stiffness, long_term, at_once, fractions, decay, held, length, strain)[0] >= target:
            break
        high += step
        step *= 2.0
    for _ in range(100):
        force, slope = _total(high, onset, stiffness, long_term, at_once, fractions, decay, held, length, strain)
        if force - target <= 1e-14 * target:
            break
        high -= (force - target) / slope
    return high
