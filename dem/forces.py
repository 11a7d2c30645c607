"""The one pair kernel: every force of every scene, and of the impact of two spheres, is computed here."""

from __future__ import annotations

import math

from contactlaws import dispatch, pair
from contactlaws.compiled import kernel

#: what the kernels keep count of: J given in by the moving boundary; J dissipated by contacts that have ended; J taken out by the drag;
#: largest overlap of one body over its radius, at any time
BOUNDARY_WORK, LOST_ENERGY, DAMPED_ENERGY, LARGEST_OVERLAP = range(4)
TALLIES = 4


@kernel
def forget(law, scale, memory, row):  # type: ignore[no-untyped-def]
    """End a contact: clear its memory and return the energy in J that it has used up."""
    state = dispatch.load_state(law, memory, row)
    touched = False
    for value in state:
        touched = touched or value != 0.0
    if not touched:
        return 0.0
    stored, dissipated = pair.pair_energy(law, scale, 0.0, state)
    for k in range(memory.shape[1]):  # afterwards: the state may be this very row
        memory[row, k] = 0.0
    return stored + dissipated


@kernel
def pair_forces(  # type: ignore[no-untyped-def]
    law,
    position,
    velocity,
    radius,
    one_radius,
    lengths,
    strain_rate,
    dt,
    start,
    partner,
    image,
    images,
    memory,
    magnitude,
    force,
    virial,
    tally,
):
    """Forces in N on all particles, shape (n, 3), from one pass over the half list. It is long because it is the loop that costs.

    `radius` is None when all are `one_radius`, `memory` is None for a law without memory: what is absent is compiled away. `strain_rate`
    (1/s, per axis) is that of the box, which moves images against each other; `dt` is the time since the last call. Filled in place:
    `force`, `magnitude` (N, per pair), `memory`, `tally` and `virial`, the sums of r_a F_b over contacts in J, in the order
    xx yy zz yz xz xy.
    """
    force[:] = 0.0
    xx, yy, zz, yz, xz, xy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    largest, lost = 0.0, 0.0
    shift = images * lengths
    reach = 2.0 * one_radius
    scale = pair.pair_scale(law, one_radius, one_radius)
    for i in range(len(position)):
        x, y, z = position[i, 0], position[i, 1], position[i, 2]
        fx, fy, fz = 0.0, 0.0, 0.0
        for row in range(start[i], start[i + 1]):
            j = partner[row]
            s = image[row]
            dx, dy, dz = position[j, 0] + shift[s, 0] - x, position[j, 1] + shift[s, 1] - y, position[j, 2] + shift[s, 2] - z
            square = dx * dx + dy * dy + dz * dz
            if radius is not None:
                reach = radius[i] + radius[j]
            if square >= reach * reach:
                magnitude[row] = 0.0
                if memory is not None:
                    if radius is not None:
                        scale = pair.pair_scale(law, radius[i], radius[j])
                    lost += forget(law, scale, memory, row)
                continue
            if radius is not None:
                scale = pair.pair_scale(law, radius[i], radius[j])
            distance = math.sqrt(square)
            overlap = reach - distance
            vx = velocity[j, 0] - velocity[i, 0] + strain_rate[0] * dx
            vy = velocity[j, 1] - velocity[i, 1] + strain_rate[1] * dy
            vz = velocity[j, 2] - velocity[i, 2] + strain_rate[2] * dz
            rate = -(dx * vx + dy * vy + dz * vz) / distance
            if memory is not None:
                f, state = pair.pair_force(law, scale, overlap, rate, dt, dispatch.load_state(law, memory, row))
                dispatch.put_back(law, memory, row, state)
            else:
                f, _ = pair.pair_force(law, scale, overlap, rate, dt, dispatch.initial_state(law))
            magnitude[row] = f
            largest = max(largest, 0.5 * overlap / scale)
            f /= distance
            gx, gy, gz = f * dx, f * dy, f * dz
            fx, fy, fz = fx - gx, fy - gy, fz - gz
            force[j, 0] += gx
            force[j, 1] += gy
            force[j, 2] += gz
            xx, yy, zz = xx + dx * gx, yy + dy * gy, zz + dz * gz
            yz, xz, xy = yz + dy * gz, xz + dx * gz, xy + dx * gy
        force[i, 0] += fx
        force[i, 1] += fy
        force[i, 2] += fz
    virial[0], virial[1], virial[2], virial[3], virial[4], virial[5] = xx, yy, zz, yz, xz, xy
    tally[LARGEST_OVERLAP] = max(tally[LARGEST_OVERLAP], largest / law.radius)
    tally[LOST_ENERGY] += lost


@kernel
def audit(law, position, radius, one_radius, lengths, start, partner, image, images, memory, magnitude, limit, contacts, pressure):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy in J of all contacts, and how many have an overlap of one body over its radius beyond `limit`.

    Filled in place, per particle: `contacts`, those that carry force; `pressure`, the trace of the contact virial in J (shared by halves).
    """
    stored, dissipated, beyond = 0.0, 0.0, 0
    contacts[:] = 0
    pressure[:] = 0.0
    for i in range(len(position)):
        for row in range(start[i], start[i + 1]):
            j = partner[row]
            square = 0.0
            for axis in range(3):
                d = position[j, axis] + images[image[row], axis] * lengths[axis] - position[i, axis]
                square += d * d
            reach = 2.0 * one_radius if radius is None else radius[i] + radius[j]
            if square >= reach * reach:
                continue
            scale = pair.pair_scale(law, one_radius, one_radius) if radius is None else pair.pair_scale(law, radius[i], radius[j])
            distance = math.sqrt(square)
            state = dispatch.initial_state(law) if memory is None else dispatch.load_state(law, memory, row)
            kept, used = pair.pair_energy(law, scale, reach - distance, state)
            stored += kept
            dissipated += used
            if 0.5 * (reach - distance) / scale > limit * law.radius:
                beyond += 1
            if magnitude[row] != 0.0:
                contacts[i] += 1
                contacts[j] += 1
                pressure[i] += 0.5 * magnitude[row] * distance
                pressure[j] += 0.5 * magnitude[row] * distance
    return stored, dissipated, beyond
