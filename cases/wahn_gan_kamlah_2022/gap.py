"""What the 5.4 % between the paper's finite elements and its law are made of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cases.wahn_gan_kamlah_2022.material import CONSTANT_BULK, OVERLAP, POISSON, PUBLISHED, RADIUS, STRAIN, TOGETHER
from cases.wahn_gan_kamlah_2022.numbers import half_space
from contactlaws.curve import FloatArray
from contactlaws.material import Material
from contactlaws.path import scan
from contactlaws.prony import PronyViscoelastic
from fem.press import press
from fem.press_in_time import press_in_time
from fem.programme import ramp_hold_release

#: s; the rates 1.0, 0.1, 0.01 and 0.001 1/s of Fig. 12 are 1/(loading time)
RAMPS = (1.0, 10.0, 100.0, 1000.0)
#: F/F_Hertz of a sphere between two opposite Hertz caps, at small strain: a Legendre series (Poisson's ratio .4314, overlap .02 R)
SMALL_STRAIN = 1.066
#: what the paper states, and its G_0 over that of its own equations
STATED, ITS_SHEAR = 0.054, 617.5 / 618.45


class Gap(NamedTuple):
    """One ramp: force of finite elements over the half-space law's, less 1."""

    ramp: float  # s
    consistent: float  # Poisson's ratio constant, as the law
    constant_bulk: float
    published: float  # g_1 and tau_1 of a constant bulk modulus, with k_1 = g_1
    published_over_elements: float  # the same, over the finite elements' force, with the paper's G_0: how a difference may be stated


class Elastic(NamedTuple):
    """Finite elements over Hertz along the overlap."""

    overlap: FloatArray  # over the radius
    ratio: FloatArray
    poisson: float


def end_force(material: PronyViscoelastic, ramp: float, tolerance: float = 0.0025) -> float:
    """Of the continuum at the paper's overlap."""
    return float(press_in_time(material, ramp_hold_release(OVERLAP, ramp), radius=RADIUS, tolerance=tolerance).force[-1])


def law_force(ramp: float) -> float:
    """Of the half-space law."""
    times = np.linspace(0.0, ramp, 2001)
    return float(scan(half_space(), OVERLAP * times / ramp, times).force[-1])


def gaps() -> list[Gap]:
    """For each ramp of Fig. 12."""
    found = []
    for ramp in RAMPS:
        law = law_force(ramp)
        consistent, bulk, published = (end_force(material, ramp) for material in (TOGETHER, CONSTANT_BULK, PUBLISHED))
        stated = 1.0 - law / (published * ITS_SHEAR)
        found.append(Gap(ramp, consistent / law - 1.0, bulk / law - 1.0, published / law - 1.0, stated))
    return found


def elastic(poisson: float = POISSON) -> Elastic:
    """The elastic sphere to .1 R."""
    material = Material(1000.0, poisson)
    curve = press(material, max_overlap=0.1, tolerance=0.0025)
    overlap, force = (column[curve.rows(0)][1:] for column in (curve.overlap, curve.force))
    return Elastic(overlap, force / (4.0 / 3.0 * material.reduced_modulus * overlap**1.5), poisson)


def parts(found: list[Gap]) -> list[tuple[str, float]]:
    """The gap of the slowest ramp, one cause after the other; they multiply."""
    slow = found[-1]
    return [
        (f"a sphere is no half-space: small strain, Legendre series at {STRAIN:g} R", SMALL_STRAIN - 1.0),
        ("large strain and the flat's own geometry: what finite elements add to that", (1.0 + slow.consistent) / SMALL_STRAIN - 1.0),
        ("k_1 = g_1 = .2369 in place of .2285: E_soft 1351 in place of 1366 MPa", (1.0 + slow.published) / (1.0 + slow.consistent) - 1.0),
        ("G_0 = 617.5 in place of 618.45 MPa", ITS_SHEAR - 1.0),
        ("together", (1.0 + slow.published) * ITS_SHEAR - 1.0),
        ("together, over the finite elements' force", slow.published_over_elements),
    ]
