"""Beds of 250 NMC ellipsoids 1:.8:.66 and of spheres of the same volume, compressed along one axis and released.

    python -m cases.becker_kamlah_2021.compression [--law hertz] [--strain 0.08] [--seeds 3]

Three beds: spheres and ellipsoids of the same packing fraction, .635, and ellipsoids of .69. Spheres jam at .64, these ellipsoids above
.7, so the two kinds begin to bear at the same strain only if they begin as near to where they jam. Without friction, on the elastic law
(Hertz's, for spheres and for ellipses) or the plastic one (of the sphere and of the ellipsoid, the same for equal axes). What a bed does
not return went into plastic flow, or, where it is rearranged, into the drag: the energies of each run tell them apart.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np

import dem
from contactlaws.elastic import Hertz
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.whole_range import whole_range
from contactlaws.whole_range_ellipsoid import whole_range_ellipsoid
from dem.ellipsoid_packing import half_axes, random_ellipsoids
from dem.packing import random_close_packing
from dem.trajectory import Trajectory

#: NMC as in the paper
NMC, DENSITY = Material(142e9, 0.25, 7.9e9), 4750.0
#: m; of the spheres, and the mean one of the ellipsoids
RADIUS = 4.675e-6
PROPORTIONS, COUNT = (1.0, 0.8, 0.66), 250
#: packing fractions of the beds
SAME, JAMMING = 0.635, 0.69
STRAIN, INERTIAL_NUMBER, OUTPUTS = 0.08, 1e-3, 40
#: stress that counts, over the largest
BEARS = 0.01


class Laws(NamedTuple):
    """Of one material: for spheres of `RADIUS`, and for ellipsoids."""

    sphere: object
    ellipsoid: object
    fitted_overlap: float | None  # over the radius


LAWS = {
    "hertz": lambda: Laws(Hertz(RADIUS, NMC.reduced_modulus), HertzEllipse(NMC.reduced_modulus), None),
    "whole_range": lambda: Laws(whole_range(NMC, RADIUS), whole_range_ellipsoid(NMC), 0.2),
}


def bed(shape: str, fraction: float, laws: Laws, strain: float, seed: int, count: int = COUNT) -> dem.Scene:
    """The bed of "spheres" or "ellipsoids", ready to be compressed along z and released."""
    settings = {"outputs": OUTPUTS, "frames": 2, "inertial_number": INERTIAL_NUMBER}
    programme = dem.uniaxial_compression(strain)
    if shape == "spheres":
        packing = random_close_packing(count, fraction, RADIUS, seed)
        bodies, box, law = dem.spheres(packing.position, RADIUS, DENSITY), packing.box, laws.sphere
    else:
        others = random_ellipsoids(count, fraction, half_axes(PROPORTIONS, RADIUS), seed)
        bodies, box, law = others.particles(DENSITY), others.box, laws.ellipsoid
    return dem.Scene(bodies, box, dem.Contact(law, fitted_overlap=laws.fitted_overlap), programme, **settings)  # type: ignore[arg-type]


class Outcome(NamedTuple):
    """What a bed did."""

    bearing: float  # strain at which a hundredth of the largest stress is first borne
    stress: float  # Pa, along z at the largest strain
    sideways: float  # that across over that along
    contacts: float  # per body, there
    overlap: float  # largest of one body over its radius
    returned: float  # work that the bed gave back over that put in
    residual: float  # strain at which the stress was gone again, on the way back
    balance: float  # what is missing of the energy
    stages: Trajectory


def outcome(run: Trajectory) -> Outcome:
    """Read off a run."""
    top, along = OUTPUTS, run.stress[:, 2, 2]
    bears = along[: top + 1] > BEARS * along[top]
    back = along[top:] > BEARS * along[top]
    work = run.energies.boundary_work
    return Outcome(
        float(run.strain[int(np.argmax(bears)), 2]),
        float(along[top]),
        float(0.5 * (run.stress[top, 0, 0] + run.stress[top, 1, 1]) / along[top]),
        float(run.coordination_number[top]),
        float(run.statistics["largest_overlap"]),
        float((work[top] - work[-1]) / work[top]),
        float(run.strain[top + int(np.count_nonzero(np.cumprod(back))) - 1, 2]),
        float(run.statistics["energy_balance"]),
        run,
    )


def compressed(law: str = "hertz", strain: float = STRAIN, seed: int = 1, count: int = COUNT) -> dict[str, Outcome]:
    """All three beds of one seed, on a law of `LAWS`."""
    laws = LAWS[law]()
    beds = (("spheres", SAME), ("ellipsoids", SAME), ("ellipsoids", JAMMING))
    return {f"{shape} {fraction:g}": outcome(dem.run(bed(shape, fraction, laws, strain, seed, count))) for shape, fraction in beds}


def main() -> None:
    """Compress and print: means over seeds, and how far they are apart."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--law", choices=LAWS, default="hertz")
    parser.add_argument("--strain", type=float, default=STRAIN)
    parser.add_argument("--count", type=int, default=COUNT, help="bodies in a bed")
    parser.add_argument("--seeds", type=int, default=3, help="packings of each kind")
    given = parser.parse_args()
    runs = [compressed(given.law, given.strain, seed + 1, given.count) for seed in range(given.seeds)]
    print(f"{'bed':18s}{'bears at':>10s}{'stress MPa':>18s}{'across/along':>14s}{'contacts':>10s}{'largest D':>11s}", end="")
    print(f"{'returned':>10s}{'residual':>10s}{'energy off':>12s}")
    for name in runs[0]:
        rows = np.array([run[name][:-1] for run in runs], dtype=float)
        mean, apart = rows.mean(axis=0), np.ptp(rows[:, 1])
        stress = f"{mean[1] / 1e6:.0f} +- {apart / 2e6:.0f}"
        print(f"{name:18s}{mean[0]:10.3f}{stress:>18s}{mean[2]:14.2f}{mean[3]:10.2f}{mean[4]:11.3f}", end="")
        print(f"{mean[5]:10.3f}{mean[6]:10.3f}{rows[:, 7].max():12.1e}")


if __name__ == "__main__":
    main()
