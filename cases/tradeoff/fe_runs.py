"""One run of the continuum solver on two meshes, read in three ways; a file of numbers for each, never half written.

The three readings: the force as the solver has it at its steps, with the ripple of landing nodes; the smooth one of a single mesh
(derivative of the work between landings); and that of two meshes, extrapolated, which is what `fem.press` gives.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from calibration.unloadings import power_law, recovered_energy
from cases.tradeoff.fe_settings import Programme, Setting
from cases.tradeoff.kept import kept, place
from contactlaws.curve import Curve
from fem.assembly import discretise
from fem.compose import compose
from fem.mesh import spheroid
from fem.press import core_size, moduli_of, programme
from fem.walk import Walk, walk

FloatArray = npt.NDArray[np.float64]

READINGS = ("raw", "one mesh", "two meshes")
QUANTITIES = ("force", "contact_radius", "unloading_stiffness", "unloading_exponent", "recovered_energy")
#: the loading is compared from this share of the largest overlap on, at so many places
FROM_SHARE, PLACES = 0.2, 25


def measure(
    runs: Iterable[tuple[Programme, Setting]], folder: Path, progress: Callable[[float, str], None] = lambda fraction, text: None
) -> list[dict[str, Any]]:
    """The results of all runs, in their order; those whose file is in `folder` already are read."""
    wanted = list(runs)
    if any(not place(folder, __name__, *_values(*one)).exists() for one in wanted):
        _compile(wanted[0][0])
    found = []
    for number, (body, setting) in enumerate(wanted):
        progress(number / len(wanted), f"{setting.name}; {body.name}")
        found.append(kept(folder, __name__, _values(body, setting), partial(run, body, setting)))
    return found


def _values(body: Programme, setting: Setting) -> tuple[object, ...]:
    """All that a run depends on; what a setting is called is not among it."""
    return body._asdict(), setting.resolution.divisions, setting.resolution.steps._asdict()


def _compile(body: Programme) -> None:
    """Compiled code is there before time is taken."""
    largest = 1e-2
    walk(discretise(spheroid(4, core_size(largest, largest))), moduli_of(body.material), largest, (largest,))


def run(body: Programme, setting: Setting) -> dict[str, Any]:
    """Numbers of one run; JSON types."""
    asked, (divisions, steps) = programme(body.unload_from, None), setting.resolution
    core = core_size(asked.largest, asked.smallest)
    walks, meshes = [], []
    for size in (divisions // 2, divisions):
        began = time.process_time()
        discretised = discretise(spheroid(size, core, 1.0, asked.along))
        walks.append(walk(discretised, moduli_of(body.material), asked.largest, asked.unload_from, steps))
        cost, elements = time.process_time() - began, int(discretised.cells.shape[0])
        meshes.append({"divisions": size, "elements": elements, "cpu_seconds": cost, **vars(walks[-1].statistics)})
    coarse, fine = walks
    stopped = fine.stopped or coarse.stopped
    facts = {"meshes": meshes, "stopped": stopped}
    return facts if stopped else {**facts, "readings": readings(body, fine, coarse, divisions)}


def readings(body: Programme, fine: Walk, coarse: Walk, divisions: int) -> dict[str, dict[str, list[float]]]:
    """Each quantity, as each of `READINGS` has it."""

    def curve(other: Walk) -> Curve:
        return compose(fine, other, body.material, 1.0, 1.0, body.largest, divisions, None, {})

    one, two = curve(fine), curve(coarse)
    at = np.geomspace(FROM_SHARE * body.largest, body.largest, PLACES)
    raw = {"force": np.interp(at, fine.path_overlap, fine.path_force), "contact_radius": _outermost(fine, at)}
    raw |= back(one, np.asarray(one.raw_force))
    found = {"raw": raw, "one mesh": _smooth(one, at), "two meshes": _smooth(two, at)}
    return {reading: {name: list(map(float, values)) for name, values in columns.items()} for reading, columns in found.items()}


def _outermost(fine: Walk, at: FloatArray) -> FloatArray:
    """Radius of the node that landed last."""
    return np.asarray(fine.landing_radius[np.searchsorted(fine.landing_overlap, at, side="right") - 1])


def _smooth(curve: Curve, at: FloatArray) -> dict[str, FloatArray]:
    rows = slice(1, curve.rows(0).stop)
    x = np.log(curve.overlap[rows])
    columns = {"force": curve.force, "contact_radius": np.asarray(curve.contact_radius)}
    loading = {name: np.exp(CubicSpline(x, np.log(column[rows]))(np.log(at))) for name, column in columns.items()}
    return loading | back(curve, curve.force)


def back(curve: Curve, force: FloatArray) -> dict[str, FloatArray]:
    """What the unloadings of a curve say: stiffness, exponent, and energy recovered with `force`."""
    rows = [curve.rows(branch) for branch in curve.unloadings]
    return {
        "unloading_stiffness": np.array([curve.radius / (curve.overlap[r][0] - curve.overlap[r][-1]) for r in rows]),
        "unloading_exponent": np.array([power_law(curve.overlap[r], force[r]).exponent for r in rows]),
        "recovered_energy": np.array([recovered_energy(curve.overlap[r], force[r]) for r in rows]),
    }


def differences(found: Mapping[str, list[float]], reference: Mapping[str, list[float]]) -> dict[str, tuple[float, float]]:
    """Mean and largest error of each quantity: relative, of the exponent absolute."""
    errors = {}
    for name in QUANTITIES:
        x, y = np.array(found[name]), np.array(reference[name])
        error = abs(x - y) if name == "unloading_exponent" else abs(x / y - 1.0)
        errors[name] = (float(error.mean()), float(error.max()))
    return errors
