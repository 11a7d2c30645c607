"""Wahn, Gan & Kamlah 2022: Lee & Radok's integral of one relaxation time, as increments that are added up.

A Hertzian spring beside a Maxwell branch, one step of which is (their Eqs. 3.13 and 3.14, the middle of the step marked by *)

    F1 <- F1 exp(-dt/tau) + 2 E1 exp(-dt/(2 tau)) sqrt(R d*) (d' dt)        F2 <- F2 + 2 E2 sqrt(R d*) (d' dt)

with the factor 1/(1 - nu^2), which the paper leaves out, in both moduli, and the rate d' where it prints the overlap once more; 2 sqrt(R d)
is its prefactor sqrt(R_eff delta) for one of two equal spheres, R = 2 R_eff at d = delta/2. All else is kept. While the contact grows the
force is right but for the first step, which counts too much by 6 %, and to second order in steps that are short against tau; nothing brings
back what increments lose (the force drifts), and a contact that shrinks is pulled. `contactlaws.maxwell_zener` has no drift and takes
any step, `contactlaws.maxwell_zener_ting` also retreats rightly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register
from contactlaws.elastic import hertz_contact_radius
from contactlaws.errors import InputError, Problem, require
from contactlaws.prony import Relaxation, problems_with_fractions, problems_with_times
from contactlaws.rivals.bounds import at_least

#: the state: overlap (m), F1, F2 (N), work put in, energy in the Maxwell branch, energy dissipated (J)
OVERLAP, RELAXING, SPRING, WORK, KEPT, LOST = range(6)


class WahnGanKamlah(NamedTuple):
    """One body on a rigid flat; made by `wahn_gan_kamlah`."""

    radius: float  # m
    spring_modulus: float  # Pa; E2/(1 - nu^2), the long-term one
    relaxing_modulus: float  # Pa; E1/(1 - nu^2): at once both count
    relaxation_time: float  # s; tau = eta/E1


def wahn_gan_kamlah(modulus: Relaxation, radius: float) -> WahnGanKamlah:
    """The law of a body of `radius` (m) whose reduced modulus is `modulus`, which must have one term. Raises `InputError`.

    >>> law = wahn_gan_kamlah(Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,)).scaled(1.0 / (1.0 - 0.4314**2)), 5e-6)
    >>> round(law.relaxing_modulus / 1e6, 1), law.relaxation_time
    (497.1, 1.8)
    """
    if len(modulus.times) != 1:
        raise InputError(Problem("times", len(modulus.times), "terms: this law has one relaxation time", "take maxwell_zener, or one term"))
    require([*problems_with_times(modulus.times), *problems_with_fractions("fractions", modulus.fractions, 1)])
    law = WahnGanKamlah(radius, modulus.long_term, modulus.instantaneous * modulus.fractions[0], modulus.times[0])
    require(at_least({"radius": 0.0, "spring_modulus": 0.0})(law))
    return law


@inlined
def wahn_gan_kamlah_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """One step. The energies are this project's, the authors give none: in the Maxwell branch dW/dt = F1 d' - 2 W/tau, as if it grew."""
    if overlap <= 0.0:
        for i in range(state.size):
            state[i] = 0.0
        return 0.0, state
    moved = overlap - state[OVERLAP]
    slope = 2.0 * math.sqrt(law.radius * 0.5 * (overlap + state[OVERLAP]))
    half = math.exp(-0.5 * dt / law.relaxation_time)
    left = half * half
    before, spring_before = state[RELAXING], state[SPRING]
    relaxing = left * before + law.relaxing_modulus * half * slope * moved
    spring = spring_before + law.spring_modulus * slope * moved
    put_in = 0.5 * (before + relaxing) * moved
    kept = left * left * state[KEPT] + left * put_in
    state[LOST] += put_in - (kept - state[KEPT])
    state[WORK] += put_in + 0.5 * (spring_before + spring) * moved
    state[OVERLAP], state[RELAXING], state[SPRING], state[KEPT] = overlap, relaxing, spring, kept
    return relaxing + spring, state


@kernel
def wahn_gan_kamlah_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Work put in less what the dashpot has taken, and that."""
    return state[WORK] - state[LOST], state[LOST]


@kernel
def wahn_gan_kamlah_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The instantaneous tangent."""
    return 2.0 * (law.spring_modulus + law.relaxing_modulus) * math.sqrt(law.radius * max(overlap, 0.0))


@kernel
def wahn_gan_kamlah_row(law):  # type: ignore[no-untyped-def]
    """Floats of state."""
    return 6


register(
    Law(
        "wahn_gan_kamlah",
        WahnGanKamlah,
        wahn_gan_kamlah_force,
        hertz_contact_radius,
        wahn_gan_kamlah_energy,
        wahn_gan_kamlah_stiffness_bound,
        ("overlap", "relaxing_force", "spring_force", "work", "relaxing_energy", "dissipated"),
        "Wahn, Gan & Kamlah 2022, Eqs. 3.13 and 3.14, with 1/(1 - nu^2) and the overlap's rate",
        at_least({"spring_modulus": 0.0, "relaxation_time": 0.0}),
        wahn_gan_kamlah_row,
        in_time=True,
    )
)
