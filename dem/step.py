"""A leap-frog step of everything, of spheres or of ellipsoids: kick and drift, and the forces. See `dem.motion`.

Which of the two is decided by a type while compiling, `shapes` being None or not: spheres know nothing of ellipsoids.
"""

from __future__ import annotations

import math

import numba
from numba import types
from numba.extending import overload

from contactlaws.compiled import inner, kernel
from dem.ellipsoid_forces import forces_of_ellipsoids, forces_of_ellipsoids_on_threads
from dem.forces import forces, forces_on_threads
from dem.rotation import turn


@inner
def move(  # type: ignore[no-untyped-def]
    position, velocity, spin, radius, one_radius, mass, one_mass, force, torque, before, fade, after, dt, carried, stretch, back, begin, end
):
    """Kick the spheres `begin` to `end` for `before` (s), let their speed fade by a factor, kick for `after`, drift for `dt`.

    `force` holds one sum per thread; `stretch` is F and `back` its inverse, for a box that carries them along. Returns the kinetic
    energy in J that the drag took and that the box gave, and the largest speed squared after the kicks.
    """
    taken, given, fastest = 0.0, 0.0, 0.0
    m = one_mass
    for i in range(begin, end):
        if mass is not None:
            m = mass[i]
        fx, fy, fz = force[0, i, 0], force[0, i, 1], force[0, i, 2]
        for t in range(1, len(force)):
            fx, fy, fz = fx + force[t, i, 0], fy + force[t, i, 1], fz + force[t, i, 2]
        x, y, z = before / m * fx, before / m * fy, before / m * fz
        vx, vy, vz = velocity[i, 0] + x, velocity[i, 1] + y, velocity[i, 2] + z
        taken += 0.5 * m * (vx * vx + vy * vy + vz * vz) * (1.0 - fade * fade)
        vx, vy, vz = vx * fade + after / m * fx, vy * fade + after / m * fy, vz * fade + after / m * fz
        square = vx * vx + vy * vy + vz * vz
        fastest = max(fastest, square)
        if spin is not None:
            r = one_radius if radius is None else radius[i]
            inertia = 0.4 * m * r * r
            for a in range(3):
                t3 = torque[0, i, a]
                for t in range(1, len(torque)):
                    t3 += torque[t, i, a]
                w = spin[i, a] + before / inertia * t3
                taken += 0.5 * inertia * w * w * (1.0 - fade * fade)
                spin[i, a] = w * fade + after / inertia * t3
        if dt > 0.0:
            px, py, pz = position[i, 0], position[i, 1], position[i, 2]
            if not carried:
                px, py, pz = px + dt * vx, py + dt * vy, pz + dt * vz
            else:
                qx = px * stretch[0, 0] + py * stretch[1, 0] + pz * stretch[2, 0] + dt * vx
                qy = py * stretch[1, 1] + pz * stretch[2, 1] + dt * vy
                px, py, pz = qx, qy, pz * stretch[2, 2] + dt * vz
                ux = vx * back[0, 0] + vy * back[1, 0] + vz * back[2, 0]
                uy = vy * back[1, 1] + vz * back[2, 1]
                vx, vy, vz = ux, uy, vz * back[2, 2]
                given += 0.5 * m * (vx * vx + vy * vy + vz * vz - square)
            position[i, 0], position[i, 1], position[i, 2] = px, py, pz
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = vx, vy, vz
    return taken, given, fastest


def _move_on_threads(  # type: ignore[no-untyped-def]
    position, velocity, spin, radius, one_radius, mass, one_mass, force, torque, before, fade, after, dt, carried, stretch, back, sums
):
    """`move` of all spheres, a share on each thread; what it returns goes into the rows of `sums`."""
    parts, count = len(sums), len(position)
    for part in numba.prange(parts):
        taken, given, fastest = move(
            position, velocity, spin, radius, one_radius, mass, one_mass, force, torque, before, fade, after, dt, carried, stretch, back,
            count * part // parts, count * (part + 1) // parts,
        )  # fmt: skip
        sums[part, 0], sums[part, 1], sums[part, 2] = taken, given, fastest


move_on_threads = kernel(_move_on_threads, parallel=True)


@inner
def move_everything(threaded, bodies, force, torque, before, fade, after, dt, carried, stretch, back, sums):  # type: ignore[no-untyped-def]
    """`move` of all spheres, with the record taken apart: only arguments are compiled away. `threaded` None: on this thread."""
    if threaded is None:
        sums[0, 0], sums[0, 1], sums[0, 2] = move(
            bodies.position, bodies.velocity, bodies.spin, bodies.radius, bodies.one_radius, bodies.mass, bodies.one_mass,
            force, torque, before, fade, after, dt, carried, stretch, back, 0, len(bodies.position),
        )  # fmt: skip
    else:
        move_on_threads(
            bodies.position, bodies.velocity, bodies.spin, bodies.radius, bodies.one_radius, bodies.mass, bodies.one_mass,
            force, torque, before, fade, after, dt, carried, stretch, back, sums,
        )  # fmt: skip


def _turn_on_threads(  # type: ignore[no-untyped-def]
    orientation, momentum, ease, axes, surface, spin, torque, before, fade, after, dt, sums
):
    """`turn` of all ellipsoids, a share on each thread; what it returns goes into the rows of `sums`."""
    parts, count = len(sums), len(orientation)
    for part in numba.prange(parts):
        taken, swept = turn(
            orientation, momentum, ease, axes, surface, spin, torque, before, fade, after, dt,
            count * part // parts, count * (part + 1) // parts,
        )  # fmt: skip
        sums[part, 0], sums[part, 3] = sums[part, 0] + taken, swept


turn_on_threads = kernel(_turn_on_threads, parallel=True)


@inner
def move_ellipsoids(threaded, bodies, shapes, force, torque, before, fade, after, dt, carried, stretch, back, sums):  # type: ignore[no-untyped-def]
    """`move_everything` of bodies that have a shape: their centres as those of spheres without spin, and their turns."""
    if threaded is None:
        sums[0, 0], sums[0, 1], sums[0, 2] = move(
            bodies.position, bodies.velocity, None, bodies.radius, bodies.one_radius, bodies.mass, bodies.one_mass,
            force, torque, before, fade, after, dt, carried, stretch, back, 0, len(bodies.position),
        )  # fmt: skip
        taken, swept = turn(
            shapes.orientation, shapes.momentum, shapes.ease, shapes.axes, shapes.surface, bodies.spin,
            torque, before, fade, after, dt, 0, len(bodies.position),
        )  # fmt: skip
        sums[0, 0], sums[0, 3] = sums[0, 0] + taken, swept
    else:
        move_on_threads(
            bodies.position, bodies.velocity, None, bodies.radius, bodies.one_radius, bodies.mass, bodies.one_mass,
            force, torque, before, fade, after, dt, carried, stretch, back, sums,
        )  # fmt: skip
        turn_on_threads(
            shapes.orientation, shapes.momentum, shapes.ease, shapes.axes, shapes.surface, bodies.spin,
            torque, before, fade, after, dt, sums,
        )  # fmt: skip
    fastest = 0.0
    for part in range(len(sums)):
        fastest = max(fastest, sums[part, 3])
    shapes.turned[0] += 2.0 * dt * math.sqrt(fastest)


def move_all(threaded, bodies, shapes, force, torque, before, fade, after, dt, carried, stretch, back, sums):  # type: ignore[no-untyped-def]
    """`move` of all bodies, and the turns of those that have a shape; `threaded` None: on this thread."""
    step = (force, torque, before, fade, after, dt, carried, stretch, back, sums)
    if shapes is None:
        move_everything(threaded, bodies, *step)
    else:
        move_ellipsoids(threaded, bodies, shapes, *step)


def all_forces(threaded, groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    """The forces of all pairs; `threaded` None: on this thread."""
    sums = (force, torque, virial, reaction, tally)
    if shapes is None:
        (forces if threaded is None else forces_on_threads)(groups, bodies, frame, dt, *sums)
    else:
        (forces_of_ellipsoids if threaded is None else forces_of_ellipsoids_on_threads)(groups, bodies, shapes, frame, dt, *sums)


# a branch on None is compiled away only where it is None: what has a shape would have the forces of spheres compiled as well


@overload(move_all)
def _(threaded, bodies, shapes, force, torque, before, fade, after, dt, carried, stretch, back, sums):  # type: ignore[no-untyped-def]
    if isinstance(shapes, types.NoneType):
        return lambda threaded, bodies, shapes, force, torque, before, fade, after, dt, carried, stretch, back, sums: move_everything(
            threaded, bodies, force, torque, before, fade, after, dt, carried, stretch, back, sums
        )
    return lambda threaded, bodies, shapes, force, torque, before, fade, after, dt, carried, stretch, back, sums: move_ellipsoids(
        threaded, bodies, shapes, force, torque, before, fade, after, dt, carried, stretch, back, sums
    )


@overload(all_forces)
def _(threaded, groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally):  # type: ignore[no-untyped-def]
    alone = isinstance(threaded, types.NoneType)
    if isinstance(shapes, types.NoneType):
        of_spheres = forces if alone else forces_on_threads
        return lambda threaded, groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally: of_spheres(
            groups, bodies, frame, dt, force, torque, virial, reaction, tally
        )
    of_ellipsoids = forces_of_ellipsoids if alone else forces_of_ellipsoids_on_threads
    return lambda threaded, groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally: of_ellipsoids(
        groups, bodies, shapes, frame, dt, force, torque, virial, reaction, tally
    )
