"""The limits of a small, fully plastic contact by finite elements, and what the whole-range law makes of them.

A body of E/Y = 1e6: elastic strains are negligible while it is pressed, and nothing but the overlap gives a length. Mean pressure over Y,
a^2/(R d), the overlap recovered over Mesarovic & Johnson's 2 (1 - nu^2) F/(pi a E), which takes the pressure to be even (J. Mech. Phys.
Solids 48, 2000, 2009), and the unloading exponent; for the law its factor of the recovery.

    python -m cases.verification.similarity

The last line of a Poisson's ratio extrapolates the two smallest overlaps to 0, linearly in sqrt(d/R). Exit code 1 if pressure or area
there is more than `BOUND` off those of the law, or the law's force at any overlap more than `FORCE_BOUND`.
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
BOUND, FORCE_BOUND = 0.01, 0.05


class State(NamedTuple):
    """Where an unloading starts."""

    overlap: float
    pressure: float  # mean, over Y
    area: float  # a^2/(R d)
    recovery: float  # over Mesarovic & Johnson's
    exponent: float
    law_force: float  # the law's force over that of the finite elements, less 1
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
                load * math.pi / at.force - 1.0,
                recovered / (even * load / math.sqrt(area)),
            )
        )
    return found


def extrapolated(found: list[State], name: str) -> float:
    """The value of a column at overlap 0."""
    one, two = (float(getattr(state, name)) for state in found[:2])
    share = math.sqrt(found[0].overlap) / (math.sqrt(found[1].overlap) - math.sqrt(found[0].overlap))
    return one + (one - two) * share


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None).parse_args()
    print("small fully plastic contacts, E/Y = 1e6, about half a minute on one core")
    print("   nu   overlap/R     p/Y  a^2/(R d)  recovery  exponent  law: force  recovery")
    held = True
    for nu in POISSONS_RATIOS:
        found = states(nu)
        for state in found:
            shown = f"{state.pressure:8.3f}{state.area:11.3f}{state.recovery:10.3f}{state.exponent:10.3f}"
            print(f"{nu:5.2f}{state.overlap:12.4f}{shown}{state.law_force:+12.2%}{state.law_recovery:10.3f}", flush=True)
        pressure, area = extrapolated(found, "pressure"), extrapolated(found, "area")
        print(f"{nu:5.2f}{0.0:12.4f}{pressure:8.3f}{area:11.3f}")
        held &= abs(pressure / PRESSURE - 1.0) < BOUND and abs(area / AREA - 1.0) < BOUND
        held &= all(abs(state.law_force) < FORCE_BOUND for state in found)
    print("bounds: " + ("held" if held else f"pressure or area is more than {BOUND:.0%} off, or a force {FORCE_BOUND:.0%}"))
    sys.exit(0 if held else 1)


if __name__ == "__main__":
    main()
