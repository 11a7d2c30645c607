"""The particles: where they are, how fast, how big, how heavy; ellipsoids also which way they lie."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.contact_ellipse import slender_problems
from contactlaws.errors import Problem, require

FloatArray = npt.NDArray[np.float64]


class Particles(NamedTuple):
    """The spheres at the start, or the ellipsoids. Arrays in one order; `id` names a particle for good.

    Of an ellipsoid `radius` is the mean one, (a b c)^(1/3): that of the sphere of its volume.
    """

    position: FloatArray  # m, shape (n, 3); any periodic image
    velocity: FloatArray  # m/s, shape (n, 3); relative to the deforming box
    radius: float | FloatArray  # m; one number when all are equal, else shape (n,)
    mass: FloatArray  # kg, shape (n,)
    id: npt.NDArray[np.int64]  # shape (n,), all different
    kind: npt.NDArray[np.int64] | None = None  # which material, from 0 on, shape (n,); None: all are 0
    spin: FloatArray | None = None  # 1/s, shape (n, 3); None: none turns
    axes: FloatArray | None = None  # m, half axes, shape (n, 3); None: all are spheres
    orientation: FloatArray | None = None  # unit quaternions (w, x, y, z) from the body to the laboratory, shape (n, 4); with axes

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


def ellipsoids(
    position: npt.ArrayLike,
    axes: npt.ArrayLike,
    density: float,
    orientation: npt.ArrayLike | None = None,
    velocity: npt.ArrayLike | None = None,
    spin: npt.ArrayLike | None = None,
) -> Particles:
    """Solid ellipsoids of one density (kg/m3), numbered from 1; raises `InputError` on impossible values.

    axes: half axes in m, one triple for all or shape (n, 3). orientation: quaternions (w, x, y, z) of any length but 0, shape (n, 4); None:
    all lie along the axes of the laboratory. velocity in m/s and spin in 1/s, shape (n, 3); None: at rest.

    >>> ellipsoids([[0.0, 0.0, 0.0]], (5e-6, 4e-6, 3.3e-6), 4750.0).radius.round(8)
    array([4.04e-06])
    """
    x = np.array(position, dtype=float).reshape(-1, 3)
    given = np.array(axes, dtype=float)
    if given.shape not in ((3,), (len(x), 3)):
        require([Problem("axes", given.shape, f"must have the shape (3,) or ({len(x)}, 3)", "give three half axes, for all or for each")])
    half = np.array(np.broadcast_to(given, (len(x), 3)))
    turned = np.array(np.broadcast_to((1.0, 0.0, 0.0, 0.0), (len(x), 4))) if orientation is None else np.array(orientation, dtype=float)
    v, w = (np.zeros_like(x) if rows is None else np.array(rows, dtype=float).reshape(-1, 3) for rows in (velocity, spin))
    wrong = []
    if not (math.isfinite(density) and density > 0.0):
        wrong.append(Problem("density", density, "must be a positive finite number", "give it in kg/m3"))
    if not (np.isfinite(half) & (half > 0.0)).all():
        wrong.append(Problem("axes", half.min(initial=math.inf), "must be positive and finite", "give half axes in m"))
    if turned.shape == (len(x), 4):
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        if not (np.isfinite(length) & (length > 0.0)).all():
            wrong.append(Problem("orientation", "without length", "must be quaternions other than 0", "(1, 0, 0, 0) is no turn"))
        else:
            turned = turned / length
    require(wrong)
    mass = density * 4.0 / 3.0 * math.pi * half.prod(axis=1)
    particles = Particles(x, v, np.cbrt(half.prod(axis=1)), mass, np.arange(1, len(x) + 1), None, w, half, turned)
    require(problems_with(particles))
    return particles


def problems_with_shapes(particles: Particles) -> Iterator[Problem]:
    """Yield one `Problem` for each thing about half axes and orientations that no simulation can use."""
    axes, turned, count = particles.axes, particles.orientation, particles.size
    if axes is None or turned is None:
        if axes is not turned:
            yield Problem("axes, orientation", "one alone", "belong together", "use dem.ellipsoids")
        return
    if axes.shape != (count, 3) or not (np.isfinite(axes) & (axes > 0.0)).all():
        yield Problem("axes", axes.shape, f"must be positive, finite, and have the shape ({count}, 3)", "give half axes in m")
    else:
        yield from slender_problems("axes", axes)
    if turned.shape != (count, 4) or not (abs(np.linalg.norm(turned, axis=1) - 1.0) < 1e-6).all():
        yield Problem("orientation", turned.shape, f"must be unit quaternions of the shape ({count}, 4)", "use dem.ellipsoids")


def problems_with(particles: Particles) -> Iterator[Problem]:
    """Yield one `Problem` for each array whose shape or values no simulation can use."""
    count = particles.size
    yield from problems_with_shapes(particles)
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
