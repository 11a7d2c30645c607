"""The reference curve: one body pressed by its mid-plane against a rigid flat, and what is known about how it was obtained."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem, require
from contactlaws.material import Material
from contactlaws.prony import PronyViscoelastic

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

    Of a path in time (`in_time`) the rows follow each other in time: on branches 0, 2, 4, ... the overlap grows or rests, on 1, 3, 5, ...
    it shrinks or rests; each begins with the row that the one before ends with.
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
    in_time: bool = False  # the force depends on how fast the overlap changed
    series: PronyViscoelastic | None = None  # what a viscoelastic body is made of; `material` is what it is at once
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

    def part(self, keep: npt.NDArray[np.bool_]) -> Curve:
        """The curve of some of its rows, its branches numbered anew."""
        columns = {name: value[keep] for name in self.COLUMNS if (value := getattr(self, name)) is not None}
        columns["branch"] = np.unique(columns["branch"], return_inverse=True)[1]
        return replace(self, **columns)

    def up_to(self, reach: float) -> Curve:
        """The part of a curve of loading and unloadings up to an overlap over the radius; unloadings from beyond it are left out.

        Raises `InputError` if the curve ends before.
        """
        relative = self.overlap / self.radius
        if relative.max() < reach * (1.0 - 1e-9):
            bound = f"ends at {relative.max():.3g} of the radius, short of {reach:.3g}"
            require([Problem("curve", self.content_hash, bound, "press the body deeper, or ask for less")])
        starts = np.array([relative[self.rows(branch).start] for branch in range(int(self.branch.max()) + 1)])
        return self.part((relative <= reach * (1.0 + 1e-9)) & (starts[self.branch] <= reach * (1.0 + 1e-9)))

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
        if self.in_time:
            digest.update(json.dumps(self.series).encode())
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
    if curve.in_time:
        if all(getattr(curve, name).shape == (size,) for name in ("time", "overlap", "branch")):
            yield from _problems_in_time(curve)
        return
    if curve.overlap.shape == curve.branch.shape and np.any(np.diff(curve.overlap[curve.branch == 0]) <= 0):
        yield Problem("overlap", "decreases", "must increase along the loading (branch 0)", "give unloadings their own branch numbers")
    if all(getattr(curve, name).shape == (size,) for name in ("time", "force", "branch")):
        for branch in np.unique(curve.branch).tolist():
            yield from _problems_along(curve, branch)


def branches_in_time(overlap: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """For each row of a path in time whether it is reached growing or resting (even) or shrinking (odd), counted up at each turn.

    Below overlap 0, where the flat stands off the undeformed body, it counts as resting.

    >>> branches_in_time([0.0, 1.0, 1.0, 0.5, 0.5, 0.7]).tolist()
    [0, 0, 0, 1, 1, 2]
    """
    signs = np.sign(np.diff(np.maximum(np.asarray(overlap, dtype=np.float64), 0.0), prepend=0.0))
    found, now = np.zeros(signs.size, dtype=np.int64), 0
    for row, sign in enumerate(signs):
        if sign != 0.0 and (sign < 0.0) != (now % 2 == 1):
            now += 1
        found[row] = now
    return found


def _problems_in_time(curve: Curve) -> Iterator[Problem]:
    steps = np.diff(curve.time)
    if (steps < 0.0).any():
        row = int(np.flatnonzero(steps < 0.0)[0]) + 1
        yield Problem(
            f"row {row}: time", float(curve.time[row]), f"must not fall below {curve.time[row - 1]:g} s", "order the rows in time"
        )
    wrong = (np.diff(np.maximum(curve.overlap, 0.0)) * np.where(curve.branch[1:] % 2 == 0, 1.0, -1.0) < 0.0) & (np.diff(curve.branch) == 0)
    if wrong.any():
        row = int(np.flatnonzero(wrong)[0]) + 1
        what = "must not fall on an even branch, nor rise on an odd one"
        yield Problem(f"row {row}: overlap", float(curve.overlap[row]), what, "leave the column branch out: it follows from the overlap")


def _problems_along(curve: Curve, branch: int) -> Iterator[Problem]:
    """Time and force of one branch. Force may wander by 1 %: near its end a computed unloading has some noise."""
    time, force = curve.time[curve.rows(branch)], curve.force[curve.rows(branch)]
    if (np.diff(time) < 0.0).any():
        row = int(np.flatnonzero(np.diff(time) < 0.0)[0]) + 1
        yield Problem(f"branch {branch} row {row}: time", float(time[row]), "must not fall along a branch", "keep the rows in their order")
    if branch and force.size and force[-1] > force[0] + 0.01 * abs(force).max():
        bound = f"must not end above the force that this unloading starts from, {force[0]:.6g} N"
        yield Problem(f"branch {branch} row {force.size - 1}: force", float(force[-1]), bound, "check the order and the sign of the force")
