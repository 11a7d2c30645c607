"""The spheres: where they are, how fast, how big, how heavy."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.errors import Problem, require

FloatArray = npt.NDArray[np.float64]


class Particles(NamedTuple):
    """The spheres at the start. Arrays in one order; `id` names a sphere for good."""

    position: FloatArray  # m, shape (n, 3); any periodic image
    velocity: FloatArray  # m/s, shape (n, 3); relative to the deforming box
    radius: float | FloatArray  # m; one number when all are equal, else shape (n,)
    mass: FloatArray  # kg, shape (n,)
    id: npt.NDArray[np.int64]  # shape (n,), all different
    kind: npt.NDArray[np.int64] | None = None  # which material, from 0 on, shape (n,); None: all are 0
    spin: FloatArray | None = None  # 1/s, shape (n, 3); None: none turns

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self.position)

    @property
    def radii(self) -> FloatArray:
        """Every radius in m, shape (n,)."""
        return np.broadcast_to(np.asarray(self.radius, dtype=float), (self.size,))

    @property
    def solid_volume(self) -> float:
        """m3; overlaps are counted twice, as usual."""
        return float(np.sum(4.0 / 3.0 * math.pi * self.radii**3))


def spheres(position: npt.ArrayLike, radius: float | npt.ArrayLike, density: float, velocity: npt.ArrayLike | None = None) -> Particles:
    """Solid spheres of one density (kg/m3), numbered from 1, at rest unless `velocity` is given; raises `InputError` on impossible values.

    >>> spheres([[0.0, 0.0, 0.0]], 5e-6, 4750.0).mass.round(15)
    array([2.487e-12])
    """
    x = np.array(position, dtype=float).reshape(-1, 3)
    v = np.zeros_like(x) if velocity is None else np.array(velocity, dtype=float).reshape(-1, 3)
    r: float | FloatArray = float(radius) if isinstance(radius, int | float) else np.array(radius, dtype=float)  # type: ignore[arg-type]
    if isinstance(r, np.ndarray) and (r.ndim == 0 or (r.size and np.all(r == r[0]))):
        r = float(r.flat[0])
    if not (math.isfinite(density) and density > 0.0):
        require([Problem("density", density, "must be a positive finite number", "give it in kg/m3")])
    mass = np.broadcast_to(density * 4.0 / 3.0 * math.pi * np.asarray(r) ** 3, (len(x),) if np.ndim(r) == 0 else np.shape(r)).copy()
    particles = Particles(x, v, r, mass, np.arange(1, len(x) + 1))
    require(problems_with(particles))
    return particles


def problems_with(particles: Particles) -> Iterator[Problem]:
    """Yield one `Problem` for each array whose shape or values no simulation can use."""
    count = particles.size
    for name, shape in (("position", (count, 3)), ("velocity", (count, 3)), ("mass", (count,)), ("id", (count,))):
        value = getattr(particles, name)
        if value.shape != shape:
            yield Problem(name, value.shape, f"must have the shape {shape}", "one row per particle")
        elif not np.isfinite(value).all():
            yield Problem(name, "not finite", f"row {int(np.argwhere(~np.isfinite(value))[0][0])} has a NaN or infinity", "repair that row")
    for name, array, wanted in (("kind", particles.kind, (count,)), ("spin", particles.spin, (count, 3))):
        if array is not None and (array.shape != wanted or not np.isfinite(array).all() or (name == "kind" and np.any(array < 0))):
            yield Problem(name, array.shape, f"must be finite, 0 or more for a kind, and have the shape {wanted}", "one row per particle")
    for name, unit in (("radius", "m"), ("mass", "kg")):
        value = np.atleast_1d(getattr(particles, name))
        if name == "radius" and np.ndim(particles.radius) and value.shape != (count,):
            yield Problem(name, value.shape, f"must be one number or have the shape ({count},)", "one radius per particle")
        wrong = ~(np.isfinite(value) & (value > 0.0))
        if wrong.any():
            yield Problem(name, float(value[wrong][0]), "must be a positive finite number", f"give it in {unit}")
    if len(np.unique(particles.id)) != len(particles.id):
        yield Problem("id", "repeated", "must be all different", "number the particles from 1 to n")
