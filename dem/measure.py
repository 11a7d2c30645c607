"""What is read off a state: homogenised stress, coordination, packing fraction, energies and their balance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from dem.neighbours import PairList

FloatArray = npt.NDArray[np.float64]

#: a frictionless sphere in three dimensions needs as many contacts to be held
FEWEST_TO_HOLD = 4


class Energies(NamedTuple):
    """In J, one value per output."""

    kinetic: FloatArray  # of the motion relative to the box
    stored: FloatArray  # in contacts, recoverable
    dissipated: FloatArray  # in contacts, living and ended
    damped: FloatArray  # by the drag
    boundary_work: FloatArray  # put in by the moving box since the start

    @property
    def balance(self) -> FloatArray:
        """What is missing: change of the energy held, dissipated and damped less the work, over the most that it ever came to."""
        held = self.kinetic + self.stored + self.dissipated + self.damped
        most = float(np.max(held, initial=0.0))
        return (held - held[:1] - self.boundary_work) / (most or 1.0)


def stress_tensor(virial: FloatArray, velocity: FloatArray, mass: FloatArray, volume: float) -> FloatArray:
    """Homogenised stress in Pa, shape (3, 3), compression positive: (sum of r F over contacts + sum of m v v over particles)/volume."""
    xx, yy, zz, yz, xz, xy = virial
    contact = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return (contact + np.einsum("i,ia,ib->ab", mass, velocity, velocity)) / volume


def kinetic_energy(velocity: FloatArray, mass: FloatArray) -> float:
    """In J."""
    return float(0.5 * np.sum(mass[:, None] * velocity * velocity))


@kernel
def _holding(start, partner, magnitude, needed):  # type: ignore[no-untyped-def]
    """Contacts of each particle after those with fewer than `needed` have been taken out, again and again."""
    count = len(start) - 1
    alive = np.ones(count, np.bool_)
    contacts = np.zeros(count, np.int64)
    changed = True
    while changed:
        contacts[:] = 0
        for i in range(count):
            for row in range(start[i], start[i + 1]):
                j = partner[row]
                if magnitude[row] != 0.0 and alive[i] and alive[j]:
                    contacts[i] += 1
                    contacts[j] += 1
        changed = False
        for i in range(count):
            if alive[i] and contacts[i] < needed:
                alive[i] = False
                changed = True
    return contacts, alive


def coordination(pairs: PairList, magnitude: FloatArray) -> tuple[float, float, int]:
    """Mean number of force-carrying contacts of all particles; of those that are held; and the number of rattlers, which are not."""
    count = len(pairs.start) - 1
    if count == 0:
        return 0.0, 0.0, 0
    contacts, alive = _holding(pairs.start, pairs.partner, magnitude, FEWEST_TO_HOLD)
    held = int(alive.sum())
    return 2.0 * np.count_nonzero(magnitude) / count, float(contacts[alive].mean()) if held else 0.0, count - held
