"""A law of LAMMPS's own replayed in LAMMPS: spheres in a row pressed together and taken apart, the force read from the virial.

Two arrangements. `ROW`: each sphere is pressed from both sides by its neighbours, a periodic row of three: the body between two flats for
which laws are made. `PAIR`: two spheres alone. Laws that know a contact only do the same in both; `mdr`, which lets a sphere grow by what
all of its contacts displace, does not. Positions are prescribed, nothing is integrated, so there is no inertia in what is read.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cases.benchmarks.lammps_input import Programs, Styles, head, run
from contactlaws.material import Material
from dem.box import Box
from dem.particles import spheres

FloatArray = npt.NDArray[np.float64]

ROW, PAIR = 3, 2
#: steps of the loading, as many for the unloading: `mdr` goes by increments, which must be small against the overlap that an unloading
#: recovers, and that goes with Y/E; with a quarter as many LAMMPS ended with "F_MDR is NaN" at E/Y = 2000
STEPS, STEPS_PER_RATIO, MOST_STEPS = 4000, 8.0, 400_000
LOGGED = 100


def steps_for(material: Material) -> int:
    """Steps of a loading."""
    ratio = 0.0 if material.yield_stress is None else material.youngs_modulus / material.yield_stress
    return round(min(max(STEPS, STEPS_PER_RATIO * ratio), MOST_STEPS))


class Replay(NamedTuple):
    """What LAMMPS found, in the order of the path."""

    overlap: FloatArray  # m, of one body: half of the pair's
    force: FloatArray  # N


def replay(programs: Programs, styles: Styles, radius: float, peak: float, arrangement: int, steps: int) -> Replay:
    """Load from 0 to `peak` (m, overlap of one body) and unload; raises `RuntimeError` if LAMMPS does not run."""
    edge = 2.0 * radius * ROW
    position = [[radius * (1 + 2 * i), 0.5 * edge, 0.5 * edge] for i in range(arrangement)]
    text = "\n".join(_lines(styles, radius, peak, steps)) + "\n"
    done = run(programs, spheres(position, radius, 1000.0), Box((edge, edge, edge)), text)
    step, length, stress = done.log.T
    overlap = peak * np.maximum(0.0, 1.0 - np.abs(step - 1.0 - steps) / steps)  # the box moves when the forces of a step are there
    contacts = ROW if arrangement == ROW else 1
    return Replay(overlap, stress * length * edge * edge / (contacts * 2.0 * (radius - overlap)))


def _lines(styles: Styles, radius: float, peak: float, steps: int) -> tuple[str, ...]:
    return (
        *head(styles, 0.5 * radius),
        "timestep 1.0",
        "variable now equal step",
        f"variable change equal {-2.0 * ROW * peak!r}*(1-abs(v_now-{steps})/{steps})",
        "variable rate equal 0.0",
        "fix squeeze all deform 1 x variable v_change v_rate remap x",
        "compute virial all pressure NULL pair",
        "thermo_style custom step lx c_virial[1]",
        'thermo_modify norm no format float "%.17g"',
        f"thermo {max(1, steps // LOGGED)}",
        f"run {2 * steps}",
    )
