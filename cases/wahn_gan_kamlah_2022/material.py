"""PVDF and the two spheres of the paper, as the paper has them and as they are consistent."""

from __future__ import annotations

from contactlaws.prony import Relaxation, uniaxial
from fem.programme import Knot, Programme, ramp_hold_release

RADIUS = 5e-6  # m
#: of the box of two spheres, 4 R high: an overlap of the pair of .04 R, of each sphere against the plane between them of .02 R
STRAIN = 0.02
#: overlap of one sphere, m; what Fig. 12 calls 1.0e-4 mm
OVERLAP = STRAIN * RADIUS
#: Table 1, with E_1 = 404.6 MPa as E_stiff - E_soft has it
YOUNG = Relaxation(1770.5e6, (404.6 / 1770.5,), (728.28 / 404.6,))
POISSON = 0.4314

#: Poisson's ratio constant, consistent with the paper's own law
TOGETHER = uniaxial(YOUNG, POISSON)
#: bulk modulus constant, as Eqs. 4.3 to 4.5 derive g_1 and tau_1
CONSTANT_BULK = uniaxial(YOUNG, POISSON, constant_bulk=True)
#: what the paper's finite elements were given: g_1 and tau_1 of a constant bulk modulus, but k_1 = g_1
PUBLISHED = TOGETHER._replace(shear_fractions=CONSTANT_BULK.shear_fractions, relaxation_times=CONSTANT_BULK.relaxation_times)


def scaled(knots: Programme, overlap: float) -> Programme:
    """A programme in units of `overlap` (m)."""
    return tuple(knot._replace(overlap=overlap * (knot.overlap or 0.0)) for knot in knots)


#: histories in units of the overlap; s
HISTORIES: dict[str, Programme] = {
    "ramp, hold, release": ramp_hold_release(1.0, 1.0, 6.5, 1.0),
    "ramp and release": ramp_hold_release(1.0, 1.0, 0.0, 1.0),
    "slow ramp, fast release": ramp_hold_release(1.0, 10.0, 0.0, 0.1),
    "release and meet again": (*ramp_hold_release(1.0, 1.0, 3.0, 0.2, 0.2), Knot(4.7, 0.2), Knot(5.2, 0.9), Knot(7.2, 0.9), Knot(8.2, 0.0)),
    "three cycles": (Knot(0.0, 0.0), *(Knot(t, d) for t, d in ((1, 1.0), (1.5, 0.4), (2, 0.9), (3, 0.3), (4, 1.0), (5, 0.0)))),
}
