"""The contact force of spheres that LAMMPS moves: each sphere computes all its contacts itself and keeps their memory in slots of its own.

So a contact is computed twice, once from each side, by the same kernel from the same distance, and what it remembers is there twice. In
return nothing has to be sent when a contact reaches across the border of two ranks: LAMMPS carries the slots along with their sphere.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws import dispatch, pair
from contactlaws.compiled import kernel

#: columns of each sphere's sums: half the virial of its contacts in J (9); largest overlap of one body over its radius, at any time; J used
#: up by contacts that have ended; J taken by the drag; J given by the moving box
VIRIAL, LARGEST, LOST, DRAGGED, WORK = 0, 9, 10, 11, 12
SUMS = 13
#: contacts that one sphere remembers at a time; equal spheres that do not overlap leave room for twelve
SLOTS = 20


@kernel
def contact_forces(law, share, position, radius, tag, begin, neighbours, partner, memory, force, sums):  # type: ignore[no-untyped-def]
    """Forces in N on the spheres of this rank, whose neighbours are `neighbours[begin[i]:begin[i + 1]]`, rows of own and ghost spheres.

    partner: tag of each slot's other sphere, 0 where it is free, shape (n, SLOTS). memory: a row for each slot: the law's floats, and the
    pair's scale. Returns the tag of a sphere with more contacts than slots, 0 if there is none.
    """
    floats = memory.shape[1] - 1
    seen = np.zeros(SLOTS, np.bool_)
    full = 0
    for i in range(len(begin) - 1):
        seen[:] = False
        fx, fy, fz = 0.0, 0.0, 0.0
        for a in range(9):
            sums[i, VIRIAL + a] = 0.0
        for k in range(begin[i], begin[i + 1]):
            j = neighbours[k]
            dx, dy, dz = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1], position[j, 2] - position[i, 2]
            square, reach = dx * dx + dy * dy + dz * dz, radius[i] + radius[j]
            if square >= reach * reach:
                continue
            distance = math.sqrt(square)
            slot = -1
            for s in range(SLOTS):
                if partner[i, s] == tag[j]:
                    slot = s
            for s in range(SLOTS):
                if slot < 0 and partner[i, s] == 0:
                    slot = s
            if slot < 0:
                full = tag[i]
                continue
            row = i * SLOTS + slot
            scale = pair.pair_scale(law, radius[i], radius[j], share)
            partner[i, slot], memory[row, floats], seen[slot] = tag[j], scale, True
            f, state = pair.pair_force(law, scale, reach - distance, 0.0, 0.0, dispatch.load_state(law, memory, row), share)
            dispatch.put_back(law, memory, row, state)
            sums[i, LARGEST] = max(sums[i, LARGEST], share * (reach - distance) / (scale * law.radius))
            f /= distance
            gx, gy, gz = f * dx, f * dy, f * dz
            fx, fy, fz = fx - gx, fy - gy, fz - gz
            sums[i, 0], sums[i, 1], sums[i, 2] = sums[i, 0] + 0.5 * dx * gx, sums[i, 1] + 0.5 * dx * gy, sums[i, 2] + 0.5 * dx * gz
            sums[i, 3], sums[i, 4], sums[i, 5] = sums[i, 3] + 0.5 * dy * gx, sums[i, 4] + 0.5 * dy * gy, sums[i, 5] + 0.5 * dy * gz
            sums[i, 6], sums[i, 7], sums[i, 8] = sums[i, 6] + 0.5 * dz * gx, sums[i, 7] + 0.5 * dz * gy, sums[i, 8] + 0.5 * dz * gz
        for s in range(SLOTS):
            if partner[i, s] != 0 and not seen[s]:
                row = i * SLOTS + s
                stored, dissipated = pair.pair_energy(law, memory[row, floats], 0.0, dispatch.load_state(law, memory, row), share)
                sums[i, LOST] += 0.5 * (stored + dissipated)
                partner[i, s], memory[row] = 0, 0.0
        force[i, 0], force[i, 1], force[i, 2] = fx, fy, fz
    return full


@kernel
def carry(velocity, mass, force, half, fade, stretch, sums):  # type: ignore[no-untyped-def]
    """Between the two half kicks of a step: velocities relative to a box that has just been stretched, and the drag.

    LAMMPS has kicked for `half` (s) with the last forces and drifted, and will kick for `half` with `force` (N). `stretch` is what each
    edge of the box was multiplied by in the drift. After the second kick the velocity is to fade by `fade`: (v + h a) fade is reached from
    v fade + h a (fade - 1).
    """
    for i in range(len(force)):
        before, after, kicked = 0.0, 0.0, 0.0
        for a in range(3):
            v = velocity[i, a]
            relative = v / stretch[a]
            kick = half / mass[i] * force[i, a]
            before, after, kicked = before + v * v, after + relative * relative, kicked + (relative + kick) * (relative + kick)
            velocity[i, a] = relative * fade + kick * (fade - 1.0)
        sums[i, WORK] += 0.5 * mass[i] * (after - before)
        sums[i, DRAGGED] += 0.5 * mass[i] * kicked * (1.0 - fade * fade)


@kernel
def add_work(sums, count, strain):  # type: ignore[no-untyped-def]
    """Half the work in J of a box that changes by `strain` per edge in a step, on the contacts as they are."""
    for i in range(count):
        for a in range(3):
            sums[i, WORK] -= 0.5 * sums[i, 4 * a] * strain[a]
