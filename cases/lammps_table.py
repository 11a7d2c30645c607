"""An elastic law as a table of force against distance, which LAMMPS takes without compiling: `pair_style table`.

A table knows neither radii nor a past: it is the law of equal spheres that give back all the work they took, and of no others.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cases.benchmarks.lammps_input import Styles
from contactlaws.fitted import FittedLaw
from contactlaws.path import scan

#: as many rows, between which LAMMPS goes along lines, leave 5e-6 of the force at a quarter of the largest overlap, in the first step
ROWS = 4001
#: by which the table goes beyond the largest overlap, so that round-off does not leave it; beyond its end LAMMPS stops
MARGIN = 1e-6
KEYWORD = "LAW"


def table(fitted: FittedLaw) -> str:
    """The file: distance of the centres in m, energy of the pair in J, force in N."""
    return "\n".join(_lines(fitted)) + "\n"


def _lines(fitted: FittedLaw) -> Iterator[str]:
    radius = fitted.law.radius
    overlap = np.linspace(0.0, (1.0 + MARGIN) * fitted.max_overlap, ROWS)
    found = scan(fitted.law, overlap)
    distance = 2.0 * (radius - overlap)
    yield f"# law {fitted.name} of two spheres of radius {radius!r} m: row, distance of centres (m), energy (J), force (N)"
    yield f"\n{KEYWORD}\nN {ROWS} R {float(distance[-1])!r} {float(distance[0])!r}\n"
    rows = zip(distance[::-1].tolist(), (2.0 * found.stored_energy[::-1]).tolist(), found.force[::-1].tolist(), strict=True)
    yield from (f"{number} {r!r} {energy!r} {force!r}" for number, (r, energy, force) in enumerate(rows, start=1))


def styles(file: Path) -> Styles:
    """The commands that read it."""
    return Styles("table", f"pair_style table linear {ROWS}\npair_coeff * * {file} {KEYWORD}", turning=False)
