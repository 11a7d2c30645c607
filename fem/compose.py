"""Put the runs of two meshes together into one `Curve` in SI units, with its error estimates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from contactlaws.curve import Curve
from contactlaws.material import Material
from fem import readout
from fem.branch import SHARES, Branch
from fem.first_yield import FirstYield
from fem.mesh import FloatArray
from fem.walk import Walk

#: a value is taken to be wrong by this share of the meshes' difference (unloading) or of what the extrapolation changed (loading)
SHARE_LEFT = 0.5
#: no estimate is smaller than this over the square of the divisions: where errors of opposite sign cancel in one mesh, they need not in
#: the other; measured at E/Y = 50
SMALLEST_ERROR = 0.16
#: nor, for what an unloading recovers and its exponent, than this over the divisions: the scatter that the mean of two phases leaves
SMALLEST_STIFFNESS_ERROR, SMALLEST_EXPONENT_ERROR = 0.035, 0.08


class Scales(NamedTuple):
    """From the solver's numbers to SI."""

    length: float
    stress: float

    @property
    def force(self) -> float:
        return self.stress * self.length**2

    @property
    def energy(self) -> float:
        return self.stress * self.length**3


def rows_with(run: Walk, nodes: int) -> int:
    """How many of the landing rows have no more than `nodes` surface nodes at rest."""
    return int(np.count_nonzero(run.landing_resting <= nodes))


def first_row(fine: Walk, coarse: Walk, divisions: int) -> float:
    """Smallest overlap reported: the contact covers the core on both meshes."""
    return float(max(run.landing_overlap[rows_with(run, m)] for run, m in ((fine, divisions), (coarse, divisions // 2))))


def _row_overlaps(fine: Walk, starts: Sequence[float], first: float, last: float) -> FloatArray:
    own = fine.landing_overlap[(fine.landing_overlap >= first) & (fine.landing_overlap < last)]
    rows = np.unique(np.concatenate([own, starts, [last]]))
    # a landing next to a stored state would make a row pair that is useless for interpolation
    keep = np.ones(rows.size, dtype=bool)
    for i in range(rows.size - 1):
        near = rows[i + 1] / rows[i] < 1.005
        if near and rows[i] not in starts:
            keep[i] = False
        elif near and rows[i + 1] not in starts and rows[i + 1] != last:
            keep[i + 1] = False
    return np.asarray(rows[keep])


def _raw_force(run: Walk, overlap: FloatArray) -> FloatArray:
    return np.interp(overlap, np.append(0.0, run.path_overlap), np.append(0.0, run.path_force))


def _branches(run: Walk, read: Callable[[FloatArray], readout.Loading], first: float) -> list[Branch]:
    """The unloadings of one mesh, those of the body before it yields from its loading, which `read` resolves from `first` on."""
    elastic = [readout.retraced_branch(readout.from_zero(read, first, a * SHARES), a) for a in run.elastic]
    return [*elastic, *run.branches]


def _relative(better: FloatArray, fine: FloatArray, least: float) -> float:
    """What the extrapolation leaves, as a mean relative error beyond the first fifth of the path."""
    change = np.abs(better / fine - 1.0)
    return max(least, SHARE_LEFT * float(change[change.size // 5 :].mean()))


def _branch_errors(pairs: list[tuple[Branch, Branch]], force: float, divisions: int) -> dict[str, float]:
    """Mean over the unloadings of half the difference between the meshes."""
    if not pairs:
        return {}
    change = [f.recovered / c.recovered - 1.0 for f, c in pairs]
    shift = [readout.exponent(f.overlap, f.force) - readout.exponent(c.overlap, c.force) for f, c in pairs]
    stiffness = max(SMALLEST_STIFFNESS_ERROR / divisions, SHARE_LEFT * float(np.abs(change).mean()))
    exponent = max(SMALLEST_EXPONENT_ERROR / divisions, SHARE_LEFT * float(np.abs(shift).mean()))
    return {"unloading_stiffness": stiffness, "unloading_exponent": exponent, "recovered_energy": force + stiffness}


def compose(
    fine: Walk,
    coarse: Walk,
    material: Material,
    radius: float,
    aspect: float,
    largest: float,
    divisions: int,
    found: FirstYield | None,
    provenance: Mapping[str, Any],
) -> Curve:
    """The curve of `fine`, extrapolated with `coarse`, up to the overlap `largest` or where the runs stopped."""
    scale = Scales(radius, material.stress_unit)
    last = min(largest, *(w.landing_overlap[-1] if w.stopped else largest for w in (fine, coarse)))
    first = first_row(fine, coarse, divisions)
    read_fine = readout.reader(fine, rows_with(fine, divisions // 2 + 1))
    read_coarse = readout.reader(coarse, rows_with(coarse, divisions // 4 + 1))

    def read(overlap: FloatArray) -> readout.Loading:
        return readout.extrapolated(read_fine(overlap), read_coarse(overlap))

    both = product(_branches(fine, read_fine, first), _branches(coarse, read_coarse, first))
    branches = [(f, c) for f, c in both if f.start == c.start <= last]
    overlap = _row_overlaps(fine, [f.start for f, _ in branches], first, last)
    own, rows = read_fine(overlap), read(overlap)
    unloads = []
    for f, c in branches:
        if f.start in fine.elastic:
            at = f.start * SHARES
            unloads.append(readout.retraced(readout.from_zero(read, first, at), at, _raw_force(fine, at)))
        else:
            unloads.append(readout.unloading(readout.better(f, c), read(np.array([f.start]))))
    least = SMALLEST_ERROR / divisions**2
    errors = {"force": _relative(rows.force, own.force, least)}
    errors |= {"contact_radius": _relative(rows.contact_radius, own.contact_radius, least)}
    errors |= _branch_errors(branches, errors["force"], divisions)
    columns: dict[str, Any] = {
        "overlap": np.concatenate([[0.0], overlap, *(np.maximum(u.overlap, 0.0) for u in unloads)]) * scale.length,
        "force": np.concatenate([[0.0], rows.force, *(u.force for u in unloads)]) * scale.force,
        "raw_force": np.concatenate([[0.0], _raw_force(fine, overlap), *(u.raw_force for u in unloads)]) * scale.force,
        "contact_radius": np.concatenate([[0.0], rows.contact_radius, *(u.contact_radius for u in unloads)]) * scale.length,
        "stored_energy": np.concatenate([[0.0], rows.stored, *(u.stored for u in unloads)]) * scale.energy,
        "dissipated_energy": np.concatenate([[0.0], rows.dissipated, *(u.dissipated for u in unloads)]) * scale.energy,
    }
    branch = np.concatenate([np.zeros(overlap.size + 1), *(np.full(u.overlap.size, k + 1.0) for k, u in enumerate(unloads))])
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(columns["overlap"])))])
    stopped = fine.stopped or coarse.stopped
    return Curve(
        time=travelled / columns["overlap"].max(),
        branch=branch.astype(np.int64),
        radius=radius,
        aspect=aspect,
        material=material,
        yield_overlap=found.overlap * scale.length if found else None,
        yield_place=(found.place[0] * scale.length, found.place[1] * scale.length) if found else None,
        errors=errors,
        stopped=stopped,
        provenance=provenance,
        **columns,
    )
