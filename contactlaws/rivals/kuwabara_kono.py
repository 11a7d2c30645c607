"""Kuwabara & Kono 1987, Brilliantov et al. 1996: a viscoelastic sphere that is loaded slowly.

    F = F_H + A dF_H/dt,   F_H = 4/3 E* sqrt(R) d^1.5

These are the first two terms of Lee & Radok's integral in powers of relaxation time over time of loading: E* is the long-term modulus, A =
sum g_i tau_i/(1 - sum g_i), and the next term is sum g_i tau_i^2/(1 - sum g_i) d^2F_H/dt^2, at the end of a ramp of duration T .75/T^2
of that sum, over F_H. Faster loading has no limit here. At the end of a collision A dF_H/dt would pull; as usual in simulations (Poeschel
& Schwager 2005) the force is cut off at 0. Two spheres that collide at the speed v return

    e = 1 - C1 x + 3/5 C1^2 x^2 - ..., C1 = 1.15344, x = 3/2 A (k/m)^(2/5) v^(1/5), F_H = k d^1.5        (Ramirez et al. 1999)

(k, m of the pair), also when cut off: what that changes begins with x^(5/2) (Schwager & Poeschel 2008).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register
from contactlaws.elastic import hertz_contact_radius
from contactlaws.errors import InputError, Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.prony import Relaxation, problems_with_fractions, problems_with_times
from contactlaws.rivals.bounds import at_least
from contactlaws.rivals.damper import MEMORY, damped, damped_energy, secant


class KuwabaraKono(NamedTuple):
    """One body; of a material that relaxes, made by `kuwabara_kono`.

    The law knows no mass, so a simulation's time step knows no damper: where A is not small against the time of the collision, take
    steps short against m/(A k), k the tangent.
    """

    radius: float  # m
    reduced_modulus: float  # Pa; E/(1 - nu^2), the long-term one
    dissipation_time: float  # s; A


def kuwabara_kono(modulus: Relaxation, radius: float) -> KuwabaraKono:
    """The law of a body of `radius` (m), loaded slowly, whose reduced modulus (`contactlaws.prony.PronyViscoelastic.reduced`) is `modulus`.

    Raises `InputError`.

    >>> kuwabara_kono(Relaxation(2e9, (0.5,), (3.0,)), 5e-6)
    KuwabaraKono(radius=5e-06, reduced_modulus=1000000000.0, dissipation_time=3.0)
    """
    law = KuwabaraKono(radius, modulus.long_term, relaxation_dissipation(modulus))
    require(at_least({"radius": 0.0, "reduced_modulus": 0.0})(law))
    return law


def relaxation_dissipation(modulus: Relaxation) -> float:
    """A in s of a relaxation modulus: loss over storage modulus and angular frequency, where that is low. Raises `InputError`."""
    require([*problems_with_times(modulus.times), *problems_with_fractions("fractions", modulus.fractions, len(modulus.times))])
    return math.fsum(g * t for g, t in zip(modulus.fractions, modulus.times, strict=True)) / (1.0 - math.fsum(modulus.fractions))


def viscous_dissipation(material: Material, shear_viscosity: float, bulk_viscosity: float) -> float:
    """A in s of a Kelvin-Voigt solid, whose moduli are G + eta_G d/dt and K + eta_K d/dt: to first order, by correspondence.

    E* = 4 G (3 K + G)/(3 K + 4 G), and A is its logarithm's derivative. shear_viscosity, bulk_viscosity: eta_G, eta_K in Pa s. Raises
    `InputError`.
    """
    _require_viscosities(material, shear_viscosity, bulk_viscosity)
    g, k = 0.5 * material.youngs_modulus / (1.0 + material.poissons_ratio), material.youngs_modulus / (3.0 - 6.0 * material.poissons_ratio)
    mixed = (3.0 * bulk_viscosity + shear_viscosity) / (3.0 * k + g) - (3.0 * bulk_viscosity + 4.0 * shear_viscosity) / (3.0 * k + 4.0 * g)
    return shear_viscosity / g + mixed


def brilliantov_dissipation(material: Material, shear_viscosity: float, bulk_viscosity: float) -> float:
    """A in s as published in 1996, 1/3 (3 n2 - n1)^2/(3 n2 + 2 n1) (1 - nu^2)(1 - 2 nu)/(E nu^2), with n1 = 2 eta_G and n2 = eta_K.

    It assumes the displacements of the elastic contact also for the rates, and so is right only where both viscosities are in the ratio of
    their moduli; it vanishes for an incompressible body and has no limit for nu = 0 (Goldobin et al. 2015, Eur. Phys. J. E 38, 55).
    Use `viscous_dissipation`. Raises `InputError`.
    """
    _require_viscosities(material, shear_viscosity, bulk_viscosity)
    nu, eta_1, eta_2 = material.poissons_ratio, 2.0 * shear_viscosity, bulk_viscosity
    if nu == 0.0:
        raise InputError(Problem("poissons_ratio", nu, "must not be 0: the published formula divides by it", "use viscous_dissipation"))
    factor = (1.0 - nu * nu) * (1.0 - 2.0 * nu) / (material.youngs_modulus * nu * nu)
    return (3.0 * eta_2 - eta_1) ** 2 / (3.0 * (3.0 * eta_2 + 2.0 * eta_1)) * factor


def _require_viscosities(material: Material, shear_viscosity: float, bulk_viscosity: float) -> None:
    named = {"shear_viscosity": shear_viscosity, "bulk_viscosity": bulk_viscosity}
    bad = [Problem(n, v, "must be 0 or more", "give it in Pa s") for n, v in named.items() if not (math.isfinite(v) and v >= 0.0)]
    if not bad and not any(named.values()):
        bad = [Problem("shear_viscosity", shear_viscosity, "is 0, and so is bulk_viscosity", "without either nothing is dissipated")]
    require([*problems_with(material), *bad])


@inlined
def kuwabara_kono_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Spring and damper."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    return damped(law, overlap, 1.5 * law.dissipation_time * secant(law, overlap) * rate, False, state)


@kernel
def kuwabara_kono_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Hertz's tangent; the damper has no part in it."""
    return 1.5 * secant(law, max(overlap, 0.0))


register(
    Law(
        "kuwabara_kono",
        KuwabaraKono,
        kuwabara_kono_force,
        hertz_contact_radius,
        damped_energy,
        kuwabara_kono_stiffness_bound,
        MEMORY,
        "Kuwabara & Kono 1987, Jpn. J. Appl. Phys. 26, 1230; Brilliantov, Spahn, Hertzsch & Poeschel 1996, Phys. Rev. E 53, 5382",
        at_least({"reduced_modulus": 0.0}),
        in_time=True,
    )
)
