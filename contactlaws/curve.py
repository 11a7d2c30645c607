"""The reference curve: one body pressed by its mid-plane against a rigid flat, and what is known about how it was obtained."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem, require
from contactlaws.material import Material

FloatArray = npt.NDArray[np.float64]

#: what `errors` may name: mean relative error along the path of the first two, relative error of 1/(d_max - d_0),
#: absolute error of the unloading exponent, relative error of the recovered energy
QUANTITIES = ("force", "contact_radius", "unloading_stiffness", "unloading_exponent", "recovered_energy")


@dataclass(frozen=True)
class Curve:
    """An ordered path of states; never sorted. SI units.

    Branch 0 is the loading; branch k >= 1 is the k-th unloading, whose first row is the state it leaves from (a state on branch 0) and
    whose last row is the separation, with force 0. `overlap` is the approach of this one body: half that of a pair of equal bodies.
    Columns that an experiment cannot give are None.
    """

    time: FloatArray  # s; a path parameter where nothing depends on time
    overlap: FloatArray  # m
    force: FloatArray  # N
    branch: npt.NDArray[np.int64]  # 0 loading, k the k-th unloading
    radius: float  # m; half the height of the body, from the mid-plane to the pole
    contact_radius: FloatArray | None = None  # m
    raw_force: FloatArray | None = None  # N; before the landing ripple was removed
    stored_energy: FloatArray | None = None  # J
    dissipated_energy: FloatArray | None = None  # J
    aspect: float = 1.0  # equatorial semi-axis over `radius`
    material: Material | None = None
    yield_overlap: float | None = None  # m; None: no yield (or not known)
    yield_place: tuple[float, float] | None = None  # m; undeformed distance from the axis and from the mid-plane
    errors: Mapping[str, float] = field(default_factory=dict)  # estimated, per name in QUANTITIES
    stopped: str | None = None  # why the path ends before its programme does
    provenance: Mapping[str, Any] = field(default_factory=dict)  # code version, mesh, solver statistics, cost in CPU seconds; JSON types

    COLUMNS = ("time", "overlap", "force", "branch", "contact_radius", "raw_force", "stored_energy", "dissipated_energy")

    def __post_init__(self) -> None:
        for name in self.COLUMNS:
            value = getattr(self, name)
            if value is not None:
                array = np.array(value, dtype=np.int64 if name == "branch" else np.float64)
                array.flags.writeable = False
                object.__setattr__(self, name, array)
        require(_problems(self))

    def rows(self, branch: int) -> slice:
        """The consecutive rows of one branch."""
        found = np.flatnonzero(self.branch == branch)
        return slice(int(found[0]), int(found[-1]) + 1) if found.size else slice(0, 0)

    @property
    def unloadings(self) -> range:
        """The numbers of the unloading branches."""
        return range(1, int(self.branch.max(initial=0)) + 1)

    @property
    def content_hash(self) -> str:
        """Sixteen hexadecimal digits of the physics in the curve: columns, body, material; not of when and how fast it was computed."""
        digest = hashlib.sha256()
        for name in self.COLUMNS:
            value = getattr(self, name)
            digest.update(name.encode() + (b"-" if value is None else np.ascontiguousarray(value).tobytes()))
        digest.update(json.dumps([self.radius, self.aspect, self.material]).encode())
        return digest.hexdigest()[:16]


def _problems(curve: Curve) -> Iterator[Problem]:
    size = curve.overlap.size
    if size < 3:
        yield Problem("rows", size, "a curve needs at least 3", "measure or compute more states")
    for name in curve.COLUMNS:
        value = getattr(curve, name)
        if value is None:
            continue
        if value.shape != (size,):
            yield Problem(name, value.shape, f"must have {size} rows like overlap", "give every column the same length")
        elif not np.isfinite(value).all():
            row = int(np.flatnonzero(~np.isfinite(value))[0])
            yield Problem(f"{name}[row {row}]", float(value[row]), "must be finite", "remove or repair the row")
    if curve.branch.shape == (size,) and (curve.branch[0] != 0 or not np.isin(np.diff(curve.branch), (0, 1)).all()):
        yield Problem(
            "branch",
            curve.branch.tolist()[:8],
            "must start at 0 and go up by 0 or 1",
            "order the rows along the path: loading, then each unloading",
        )
    for name in ("radius", "aspect"):
        value = getattr(curve, name)
        if not (np.isfinite(value) and value > 0):
            yield Problem(name, value, "must be positive", "give it in metres" if name == "radius" else "1 is a sphere")
    if curve.overlap.shape == curve.branch.shape and np.any(np.diff(curve.overlap[curve.branch == 0]) <= 0):
        yield Problem("overlap", "decreases", "must increase along the loading (branch 0)", "give unloadings their own branch numbers")
    if all(getattr(curve, name).shape == (size,) for name in ("time", "force", "branch")):
        for branch in np.unique(curve.branch).tolist():
            yield from _problems_along(curve, branch)


def _problems_along(curve: Curve, branch: int) -> Iterator[Problem]:
    """Time and force of one branch. Force may wander by 1 %: near its end a computed unloading has some noise."""
    time, force = curve.time[curve.rows(branch)], curve.force[curve.rows(branch)]
    if (np.diff(time) < 0.0).any():
        row = int(np.flatnonzero(np.diff(time) < 0.0)[0]) + 1
        yield Problem(f"branch {branch} row {row}: time", float(time[row]), "must not fall along a branch", "keep the rows in their order")
    if branch and force.size and force[-1] > force[0] + 0.01 * abs(force).max():
        bound = f"must not end above the force that this unloading starts from, {force[0]:.6g} N"
        yield Problem(f"branch {branch} row {force.size - 1}: force", float(force[-1]), bound, "check the order and the sign of the force")
