"""Effective moduli of a packing: how its stress answers small strains of the box, with rest in between."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from contactlaws.errors import InputError, Problem, require
from contactlaws.version import code_version
from dem import checkpoint as disk
from dem.measure import stress_tensor
from dem.quasi_static import step_to
from dem.reduction import reduced
from dem.requirements import LOAD_SHARE, durations, problems_with, typical_force
from dem.scene import QuasiStatic, Scene
from dem.timestep import scene_time_step
from dem.working import Working, arrays_of, with_arrays, working

FloatArray = npt.NDArray[np.float64]

#: order of rows and columns, and where each stands in a tensor
VOIGT = ((0, 0), (1, 1), (2, 2), (2, 1), (2, 0), (1, 0))
#: a probe looks closer than a programme does
STRICT = QuasiStatic(force=1e-7, kinetic=1e-12, displacement=1e-9, most=200_000)


def moduli(scene: Scene, strain: float = 1e-6, checkpoint: str | Path | None = None, duration: float = 1.0) -> FloatArray:
    """Stiffness in Pa, shape (6, 6), of the scene's packing at rest: change of stress (xx yy zz yz xz xy) over engineering strain.

    Half the difference of two probes of opposite sign, each of which starts from the same state: where contacts slide or yield one way and
    not the other, the mean of both stiffnesses. With the `checkpoint` of a finished run
    the state is that of its end, with all that contacts remember; without, that of the scene's start. `duration` is the time (s) that a
    probe takes, which only a law in time asks about. Compression counts positive in both, so a stable packing has a positive diagonal.
    Raises `InputError` for a checkpoint of something else, and for a packing that does not come to rest.
    """
    require(problems_with(scene))
    identity = {"scene": scene.content_hash, "code": code_version()}
    scene, _ = reduced(scene, durations(scene))  # as the run did
    work = working(scene)
    if checkpoint is not None:
        _, arrays = disk.load(Path(checkpoint), identity)
        work = with_arrays(work, {name.removeprefix("work_"): value for name, value in arrays.items() if name.startswith("work_")})
    load = LOAD_SHARE * typical_force(scene)

    def critical(overlap: float) -> float:
        return scene_time_step(scene, overlap, 1.0).critical

    def probed(start: Working, tensor: FloatArray) -> Working:
        own = with_arrays(start, {name: array.copy() for name, array in arrays_of(start).items()})
        found, rest = step_to(own, own.cell @ (np.eye(3) - tensor), duration, True, critical, load, STRICT)
        if not rest.found:
            raise InputError(Problem("packing", rest.report, "found no rest", "probe one that holds, or try another strain"))
        return found

    rest = probed(work, np.zeros((3, 3)))
    columns = []
    for i, j in VOIGT:
        unit = np.zeros((3, 3))
        unit[i, j] = strain
        there, back = (stress_tensor(probed(rest, sign * unit), with_motion=False) for sign in (1.0, -1.0))
        columns.append([(there[a, b] - back[a, b]) / (2.0 * strain) for a, b in VOIGT])
    return np.array(columns).T
