"""The Maxwell-Zener law: Hertz's contact, or a finite sphere's, whose modulus relaxes as a Prony series, while the contact grows.

Lee & Radok (1960): F(t) = int psi(t - s) dF_e(d(s)), with the elastic force F_e of the instantaneous modulus and psi = 1 - sum g_i (1 -
exp(-t/tau_i)). The long-term spring is in closed form, so it cannot drift; each other term remembers one force f_i, whose recurrence is
exact for an elastic force that grows evenly in the step, however long the step:

    f_i <- e f_i + h (F_e' - F_e),   e = exp(-dt/tau_i),   h = (1 - e) tau_i/dt,   F = (1 - sum g_i) F_e + sum g_i f_i

(Wahn, Gan & Kamlah 2022, Eqs. 3.11 to 3.14, with the factor 1/(1 - nu^2) that is missing there and the rate in place of the overlap.)
When the contact shrinks this is no solution any more: the force falls too fast, and would pull before it should end; it is cut off at zero.
`maxwell_zener_ting` is the law that also retreats rightly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register
from contactlaws.elastic import HertzFiniteSize, finite_size_area, finite_size_factors, finite_size_force, largest_finite_size_stiffness
from contactlaws.errors import InputError, Problem
from contactlaws.maxwell_element import decay_and_mean
from contactlaws.prony import Relaxation, problems_with_fractions, problems_with_times

FloatArray = npt.NDArray[np.float64]

#: the state: overlap (m), elastic force, force (N), work put in, energy dissipated (J); then for each term f_i (N), and q_i (J), twice the
#: energy in its springs over g_i
OVERLAP, ELASTIC, FORCE, WORK, LOST, FIRST = range(6)


class MaxwellZener(NamedTuple):
    """One body on a rigid flat; made by `maxwell_zener`. F_e = 4/3 E* sqrt(R) d^1.5 (1 + c1 sqrt(D) + c2 D + c3 D^3), D = d/R.

    >>> law = maxwell_zener(Relaxation(2175.3e6, (0.2285,), (1.8,)), 5e-6)
    >>> law.fractions.tolist(), law.force_1
    ([0.2285], 0.0)
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2) at once
    force_1: float  # c1, c2, c3; 0 is Hertz
    force_2: float
    force_3: float
    area_1: float  # a^2 = R d (1 + b1 sqrt(D) + b2 D^2)
    area_2: float
    fractions: FloatArray  # g_i of the reduced modulus
    times: FloatArray  # tau_i in s, rising


def maxwell_zener(modulus: Relaxation, radius: float, poissons_ratio: float | None = None) -> MaxwellZener:
    """The law of a body of `radius` (m) whose reduced modulus (`contactlaws.prony.PronyViscoelastic.reduced`) is `modulus`.

    poissons_ratio: of the finite-size correction (the mean over time where it changes); None: Hertz's half-space. Raises `InputError`.
    """
    factors = (0.0, 0.0, 0.0, 0.0, 0.0) if poissons_ratio is None else finite_size_factors(poissons_ratio)
    law = MaxwellZener(radius, modulus.instantaneous, *factors, frozen(modulus.fractions), frozen(modulus.times))
    problems = [*problems_with_terms(law), *_problems_with_body(law)]
    if problems:
        raise InputError(problems)
    return law


def frozen(values: npt.ArrayLike) -> FloatArray:
    """A row of floats that nobody changes."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def problems_with_terms(law: MaxwellZener) -> Iterator[Problem]:
    """What kernels rely on: as many times as fractions, in order, and something left of the modulus."""
    for name in ("fractions", "times"):
        if not (isinstance(value := getattr(law, name), np.ndarray) and value.ndim == 1 and value.dtype == np.float64):
            yield Problem(name, type(value).__name__, "must be a row of numbers", "make the law with its function")
            return
    yield from problems_with_times(law.times.tolist())
    yield from problems_with_fractions("fractions", law.fractions.tolist(), law.times.size)


def _problems_with_body(law: MaxwellZener) -> Iterator[Problem]:
    for name in ("radius", "reduced_modulus"):
        value = getattr(law, name)
        if not (math.isfinite(value) and value > 0.0):
            yield Problem(name, value, "must be a positive finite number", "give it in SI units")


@inlined
def follow(e, h, m, old, kept, risen, moved):  # type: ignore[no-untyped-def]
    """One term through a step: its new force, q_i and what its damper takes over g_i, the elastic force `risen` and the overlap `moved`.

    e, h, m: of `decay_and_mean`. Steps count as straight in overlap and elastic force; the dissipation of a step is then never negative
    while the contact grows.
    """
    left = e * old
    new = left + h * risen
    energy = e * e * kept + h * moved * (left + new)
    # work on the term: overlap moved times the mean of f_i in the step
    return new, max(0.0, energy), max(0.0, moved * (h * old + m * risen) - 0.5 * (energy - kept))


@inlined
def settle(force, force_before, work, moved, lost, lost_before):  # type: ignore[no-untyped-def]
    """Force, work put in and energy dissipated after a step: no contact pulls, and nothing can be lost that was not put in.

    Where the force is cut off, the terms move on without it.
    """
    force = max(0.0, force)
    work += 0.5 * (force + force_before) * moved
    return force, work, min(lost, max(lost_before, work))


@inlined
def grow(law, fractions, times, overlap, dt, state, first, lengths):  # type: ignore[no-untyped-def]
    """Take f_i and q_i, from float `first` of the state on, through a step of `dt` to `overlap`; returns force and elastic force in N.

    fractions, times: the law's; each look into a record of arrays counts a reference. lengths: whether the strains of springs that move
    with the overlap follow, one for each term. The energy dissipated is added up.
    """
    terms = fractions.size
    elastic = finite_size_force(law, overlap)
    risen, moved = elastic - state[ELASTIC], overlap - state[OVERLAP]
    force, lost = elastic, 0.0
    for i in range(terms):
        g, own, spring = fractions[i], first + i, first + terms + i
        e, h, m = decay_and_mean(dt / times[i])
        state[own], state[spring], taken = follow(e, h, m, state[own], state[spring], risen, moved)
        lost += g * taken
        force += g * (state[own] - elastic)
        if lengths:
            state[first + 2 * terms + i] = e * state[first + 2 * terms + i] + h * moved
    state[LOST] += lost
    return force, elastic


@kernel
def forget(state):  # type: ignore[no-untyped-def]
    """The contact is open: nothing is remembered."""
    for i in range(state.size):
        state[i] = 0.0


@inlined
def maxwell_zener_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """One step of the recurrence."""
    if overlap <= 0.0:
        forget(state)
        return 0.0, state
    before = state[LOST]
    force, elastic = grow(law, law.fractions, law.times, overlap, dt, state, FIRST, False)
    force, state[WORK], state[LOST] = settle(force, state[FORCE], state[WORK], overlap - state[OVERLAP], state[LOST], before)
    state[OVERLAP], state[ELASTIC], state[FORCE] = overlap, elastic, force
    return force, state


@inlined
def maxwell_zener_block(law, dt, memory, row, size, block, at):  # type: ignore[no-untyped-def]
    """The recurrence for a block of contacts: every line is a loop over all of them, which the compiler takes several at a time.

    What is written is what binds, so the memory is changed where it is; it takes few arrays at once to be told apart from the block.
    """
    body = HertzFiniteSize(law.radius, law.reduced_modulus, law.force_1, law.force_2, law.force_3, law.area_1, law.area_2)  # no arrays
    fractions, times = law.fractions, law.times
    overlap, force, ended, elastic, risen, moved, lost = at, at + 1, at + 2, at + 3, at + 4, at + 5, at + 6
    for q in range(size):
        reached = max(block[overlap, q], 0.0)
        at_once = finite_size_force(body, reached)
        block[elastic, q] = block[force, q] = at_once
        block[risen, q] = at_once - memory[ELASTIC, row + q]
        block[moved, q] = reached - memory[OVERLAP, row + q]
        block[lost, q] = 0.0
    for i in range(fractions.size):
        g, own, spring = fractions[i], FIRST + i, FIRST + fractions.size + i
        e, h, m = decay_and_mean(dt / times[i])
        for q in range(size):
            old, kept = memory[own, row + q], memory[spring, row + q]
            new, energy, taken = follow(e, h, m, old, kept, block[risen, q], block[moved, q])
            memory[own, row + q] = new if block[overlap, q] > 0.0 else 0.0
            memory[spring, row + q] = energy if block[overlap, q] > 0.0 else 0.0
            block[lost, q] += g * taken
            block[force, q] += g * (new - block[elastic, q])
    for q in range(size):
        before, had, touching = memory[LOST, row + q], memory[WORK, row + q], block[overlap, q] > 0.0
        taken = before + block[lost, q]
        pushed, work, gone = settle(block[force, q], memory[FORCE, row + q], had, block[moved, q], taken, before)
        block[force, q] = pushed if touching else 0.0
        block[ended, q] = 0.0 if touching else had
        block[risen, q] = work if touching else 0.0
        block[moved, q] = gone if touching else 0.0
    for q in range(size):
        memory[OVERLAP, row + q] = max(block[overlap, q], 0.0)
        memory[ELASTIC, row + q] = block[elastic, q] if block[overlap, q] > 0.0 else 0.0
    for q in range(size):
        memory[FORCE, row + q] = block[force, q]
        memory[WORK, row + q] = block[risen, q]
        memory[LOST, row + q] = block[moved, q]


@kernel
def maxwell_zener_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """That of the elastic body at the same overlap."""
    return math.sqrt(finite_size_area(law, max(overlap, 0.0)))


@kernel
def maxwell_zener_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Work put in less what the dampers have taken, and that; of a contact that has opened all that was left is lost."""
    return state[WORK] - state[LOST], state[LOST]


@kernel
def maxwell_zener_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The instantaneous elastic tangent."""
    return largest_finite_size_stiffness(law, max(overlap, 0.0))


@kernel
def maxwell_zener_row(law):  # type: ignore[no-untyped-def]
    """Floats of state."""
    return FIRST + 2 * law.fractions.size


register(
    Law(
        "maxwell_zener",
        MaxwellZener,
        maxwell_zener_force,
        maxwell_zener_contact_radius,
        maxwell_zener_energy,
        maxwell_zener_stiffness_bound,
        ("overlap", "elastic_force", "force", "work", "dissipated", "2_for_each_term"),
        "Lee & Radok 1960, J. Appl. Mech. 27, 438; Wahn, Gan & Kamlah 2022, Eqs. 3.11-3.14 corrected; finite size by finite elements",
        problems_with_terms,
        maxwell_zener_row,
        in_time=True,
        block=maxwell_zener_block,
    )
)
