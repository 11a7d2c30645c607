"""The limits of a small, fully plastic contact by finite elements, and what the whole-range law makes of them.

A body of E/Y = 1e6: elastic strains are negligible while it is pressed, and nothing but the overlap gives a length. Mean pressure over Y,
a^2/(R d), the overlap recovered over Mesarovic & Johnson's 2 (1 - nu^2) F/(pi a E), which takes the pressure to be even (J. Mech. Phys.
Solids 48, 2000, 2009), and the unloading exponent; for the law its factor of the recovery.

    python -m cases.verification.similarity

Exit code 1 if pressure or area at the smallest overlap is more than `BOUND` off 2.84 and 2.86.
"""

from __future__ import annotations

import argparse
import math
import sys
from typing import NamedTuple

import fem
from calibration.unloadings import unloading
from contactlaws.material import Material
from contactlaws.whole_range import unloading as law_unloading
from contactlaws.whole_range import whole_range
from contactlaws.whole_range_loading import AREA, PRESSURE

RATIO = 1e6
POISSONS_RATIOS = (0.0, 0.15, 0.3, 0.45, 0.49)
OVERLAPS = (0.0003, 0.001, 0.003, 0.01)
BOUND = 0.05


class State(NamedTuple):
    """Where an unloading starts."""

    overlap: float
    pressure: float  # mean, over Y
    area: float  # a^2/(R d)
    recovery: float  # over Mesarovic & Johnson's
    exponent: float
    law_recovery: float  # the law's, over the same with the law's force and area


def states(poissons_ratio: float) -> list[State]:
    """One per overlap."""
    material = Material(RATIO, poissons_ratio, 1.0)
    curve, law = fem.press(material, unload_from=OVERLAPS), whole_range(material, 1.0)
    found = []
    for branch in curve.unloadings:
        at = unloading(curve, branch)
        assert at is not None
        assert at.contact_radius is not None
        load, _, area, recovered, _ = law_unloading(law, at.overlap)
        even = 2.0 * (1.0 - poissons_ratio**2) / RATIO
        found.append(
            State(
                at.overlap,
                at.force / (math.pi * at.contact_radius**2),
                at.contact_radius**2 / at.overlap,
                1.0 / (at.stiffness * even * at.force / (math.pi * at.contact_radius)),
                at.exponent,
                recovered / (even * load / math.sqrt(area)),
            )
        )
    return found


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None).parse_args()
    print("small fully plastic contacts, E/Y = 1e6, about half a minute on one core")
    print("   nu   overlap/R     p/Y  a^2/(R d)  recovery  exponent  law's recovery")
    held = True
    for nu in POISSONS_RATIOS:
        found = states(nu)
        for state in found:
            print(f"{nu:5.2f}{state.overlap:12.4f}", end="")
            print(
                f"{state.pressure:8.3f}{state.area:11.3f}{state.recovery:10.3f}{state.exponent:10.3f}{state.law_recovery:16.3f}", flush=True
            )
        held &= abs(found[0].pressure / PRESSURE - 1.0) < BOUND and abs(found[0].area / AREA - 1.0) < BOUND
    print("pressure and area: held" if held else f"pressure or area is more than {BOUND:.0%} off {PRESSURE} and {AREA}")
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
