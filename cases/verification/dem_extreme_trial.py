"""What a trial at the extremes is, and the spheres that it is made with."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import dem
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.material import Material
from dem.packing import Packing, face_centred_cubic
from dem.trajectory import Trajectory

FloatArray = npt.NDArray[np.float64]

#: NMC, 5 um
MATERIAL, RADIUS, DENSITY = Material(142e9, 0.25, 7.9e9), 5e-6, 4750.0
HERTZ = Hertz(RADIUS, MATERIAL.reduced_modulus)
MASS = DENSITY * 4.0 / 3.0 * np.pi * RADIUS**3


class Trial(NamedTuple):
    """One line of the table."""

    done: str
    measured: str
    bound: str
    sound: bool
    verdict: str


def judged(done: str, value: float, bound: float, unit: str = "") -> Trial:
    """Right if `value` does not exceed `bound` in magnitude; a NaN does."""
    sound = bool(abs(value) <= bound)
    return Trial(done, f"{value:.2g}{unit and ' '}{unit}", f"{bound:.2g}", sound, "finite and right" if sound else "NOT RIGHT")


def refused(done: str, attempt: Callable[[], object], words: str) -> Trial:
    """Right if the attempt ends in one clear error that has these words."""
    try:
        attempt()
    except InputError as error:
        found = str(error)
        sound = words in found and len(error.problems) == 1
        return Trial(done, found, f"an error with '{words}'", sound, "one clear error" if sound else "ANOTHER ERROR")
    except Exception as crash:  # what a table of extremes is there to find
        return Trial(done, repr(crash), f"an error with '{words}'", False, "CRASH")
    return Trial(done, "no error", f"an error with '{words}'", False, "NOT REFUSED")


def finite(found: Trajectory) -> bool:
    """Whether there is no NaN or infinity in anything that a run gives back."""
    arrays = [getattr(found, field.name) for field in dataclasses.fields(found)]
    numbers = [array for array in [*arrays, *found.energies] if isinstance(array, np.ndarray)]
    frames = [array for frame in found.frames for array in frame if isinstance(array, np.ndarray)]
    return all(bool(np.isfinite(array).all()) for array in [*numbers, *frames])


def whole(found: Trajectory, value: float) -> float:
    """`value`, or NaN if the run is not finite or ended early: a bound then fails."""
    return value if finite(found) and found.stopped is None else float("nan")


def shaken(squeezed: float = 0.99, moved: float = 0.004, cells: int = 2) -> Packing:
    """A face-centred lattice pressed together, each sphere moved at random by a little."""
    crystal = face_centred_cubic((cells,) * 3, RADIUS)
    off = np.random.default_rng(0).uniform(-moved, moved, crystal.position.shape) * RADIUS
    x, y, z = (length * squeezed for length in crystal.box.lengths)
    return crystal._replace(position=crystal.position * squeezed + off, box=dem.Box((x, y, z)))


def hertz_collision(speed: float, mass: float, radius: float, modulus: float) -> tuple[float, float]:
    """Depth (m) and duration (s) of Hertz's collision of a pair with these reduced values."""
    depth = (15.0 * mass * speed**2 / (16.0 * np.sqrt(radius) * modulus)) ** 0.4
    return float(depth), float(2.94328 * depth / speed)
