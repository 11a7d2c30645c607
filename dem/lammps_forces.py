"""The contact forces of spheres that LAMMPS moves: own spheres have slots for what their contacts remember, which LAMMPS carries along.

What a contact remembers lies with both spheres. A contact of two spheres of one rank is computed once, for both; one that reaches across
the border of two ranks twice, on each from its side, by the same kernel from the same numbers: so nothing has to be sent between steps.
"""

from __future__ import annotations

import math

from contactlaws import dispatch, pair
from contactlaws.compiled import inlined, kernel
from contactlaws.tangential import damper_force, dragged, tangential_stiffness

#: columns of each sphere's sums: half of d F per axis over its contacts in J; largest overlap of one body over its radius, at any time;
#: its half of the J used up by contacts that have ended, that tangential forces and moments took up, and that dampers took; J taken by the
#: drag; J given by the moving box; force in N and torque in N m at the end of an interval; s since the rank began that has the sphere
VIRIAL, LARGEST, LOST, SHEARED, DAMPED, DRAGGED, WORK, FORCE, TORQUE, CLOCK = 0, 3, 4, 5, 6, 7, 8, 9, 12, 15
SUMS = 16
#: contacts that one sphere remembers at a time; equal spheres that do not overlap leave room for twelve
SLOTS = 20
#: columns of what a pair gives: force on the second; half of d F per axis; overlap of one body over its radius; energy of the contact, if
#: it has just ended; and with friction or a damper: torque on both, over their radii; rolling moment on the first; work of these two;
#: of the damper
PUSH, HALF, DEPTH, ENDED, TWIST, ROLL, SHEAR, DASH = 0, 3, 6, 7, 8, 11, 14, 15
SMOOTH, ROUGH = 8, 16
#: what a contact remembers beyond its law: tangential force on the sphere that remembers and the contact radius; rolling moment on it; the
#: damper's force
SLIP, TURNED, HELD = 0, 4, 7
REMEMBERED = 8


@inlined
def _released(memory, partner, slots, k):  # type: ignore[no-untyped-def]
    """Free the slots of a pair."""
    for side in range(2):
        at = slots[k, side]
        if at >= 0:
            partner[at] = 0
            memory[at] = 0.0
            slots[k, side] = -1


@inlined
def _taken(partner, tag, i, j):  # type: ignore[no-untyped-def]
    """A free slot of own sphere i, now for sphere j; -1 if there is none."""
    for s in range(i * SLOTS, (i + 1) * SLOTS):
        if partner[s] == 0:
            partner[s] = tag[j]
            return s
    return -1


@kernel
def pair_forces(  # type: ignore[no-untyped-def]
    law, tangential, rolling, damper, share, first, second, slots, touching,
    tag, position, radius, mass, velocity, spin, stretch, gradient, dt, partner, memory, out,
):  # fmt: skip
    """What each pair gives, into its row of `out`, where `touching` says so.

    partner, memory: one row per slot of the own spheres; `mass` None: no damper; `velocity` None: nothing asks for speeds; `spin` None: no
    friction. The velocities are those before the box was stretched by `stretch` per edge, with the `gradient` (1/s) per axis. Returns the
    number of a sphere with more contacts than slots, 0 if there is none. It is long because it is the loop that costs.
    """
    count, full = len(partner) // SLOTS, 0
    floats = memory.shape[1] - (0 if velocity is None else REMEMBERED)
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx, dy, dz = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1], position[j, 2] - position[i, 2]
        square, reach = dx * dx + dy * dy + dz * dz, radius[i] + radius[j]
        at = slots[k, 0]
        open_ = square >= reach * reach
        if open_ and at < 0:
            touching[k] = False
            continue
        touching[k] = True
        scale = pair.pair_scale(law, radius[i], radius[j], share)
        distance = math.sqrt(square)
        vx, vy, vz, rate = 0.0, 0.0, 0.0, 0.0
        if velocity is not None:
            vx = (velocity[j, 0] - velocity[i, 0]) / stretch[0] + dx * gradient[0]
            vy = (velocity[j, 1] - velocity[i, 1]) / stretch[1] + dy * gradient[1]
            vz = (velocity[j, 2] - velocity[i, 2]) / stretch[2] + dz * gradient[2]
            rate = -(dx * vx + dy * vy + dz * vz) / distance
        if open_:
            stored, dissipated = pair.pair_energy(law, scale, 0.0, dispatch.load_state(law, memory, at), share)
            for c in range(out.shape[1]):
                out[k, c] = 0.0
            out[k, ENDED] = stored + dissipated
            if damper is not None:
                out[k, DASH] = 0.5 * memory[at, floats + HELD] * rate * dt
            _released(memory, partner, slots, k)
            continue
        if at < 0:
            at = _taken(partner, tag, i, j)
            slots[k, 0] = at
            if j < count:
                slots[k, 1] = _taken(partner, tag, j, i)
            if at < 0 or (j < count and slots[k, 1] < 0):
                full = tag[i] if at < 0 else tag[j]
                _released(memory, partner, slots, k)
                touching[k] = False
                continue
        overlap = reach - distance
        before = dispatch.load_state(law, memory, at)
        f, state = pair.pair_force(law, scale, overlap, rate, dt, before, share)
        a = 0.0
        if tangential is not None or damper is not None:
            a = pair.pair_contact_radius(law, scale, overlap, state, share)
        dispatch.put_back(law, memory, at, state)
        if damper is not None:
            m = mass[i] * mass[j] / (mass[i] + mass[j])
            held = max(f + damper_force(damper, a, m, rate), 0.0) - f
            out[k, DASH] = 0.5 * (held + memory[at, floats + HELD]) * rate * dt
            memory[at, floats + HELD] = held
            f += held
        inverse = 1.0 / distance
        push = f * inverse
        gx, gy, gz = push * dx, push * dy, push * dz
        if tangential is not None:
            n = (dx * inverse, dy * inverse, dz * inverse)
            ri, rj = radius[i], radius[j]
            cx, cy, cz = (
                (ri * spin[i, 0] + rj * spin[j, 0]) / reach,
                (ri * spin[i, 1] + rj * spin[j, 1]) / reach,
                (ri * spin[i, 2] + rj * spin[j, 2]) / reach,
            )
            way = ((vx - (cy * dz - cz * dy)) * dt, (vy - (cz * dx - cx * dz)) * dt, (vz - (cx * dy - cy * dx)) * dt)
            slip = floats + SLIP
            had = memory[at, slip + 3] if tangential.shrinking else a
            turn = (cx * n[0] + cy * n[1] + cz * n[2]) * dt if tangential.turning else 0.0
            old = (memory[at, slip], memory[at, slip + 1], memory[at, slip + 2])
            s, work = dragged(tangential_stiffness(tangential, a), tangential.friction * f, a, had, turn, n, way, old)
            memory[at, slip], memory[at, slip + 1], memory[at, slip + 2], memory[at, slip + 3] = s[0], s[1], s[2], a
            out[k, TWIST] = (dy * s[2] - dz * s[1]) / reach
            out[k, TWIST + 1] = (dz * s[0] - dx * s[2]) / reach
            out[k, TWIST + 2] = (dx * s[1] - dy * s[0]) / reach
            out[k, SHEAR] = work
            gx, gy, gz = gx - s[0], gy - s[1], gz - s[2]
            if rolling is not None:
                turned, arm = floats + TURNED, ri * rj / reach
                old = (memory[at, turned], memory[at, turned + 1], memory[at, turned + 2])
                angle = ((spin[j, 0] - spin[i, 0]) * dt, (spin[j, 1] - spin[i, 1]) * dt, (spin[j, 2] - spin[i, 2]) * dt)
                stiffness = tangential_stiffness(tangential, a) * arm * arm
                moment, work = dragged(stiffness, rolling.friction * arm * f, a, had, turn, n, angle, old)
                memory[at, turned], memory[at, turned + 1], memory[at, turned + 2] = moment
                out[k, ROLL], out[k, ROLL + 1], out[k, ROLL + 2] = moment
                out[k, SHEAR] += work
        if j < count:  # the second remembers the same, seen from its side
            there = slots[k, 1]
            for c in range(memory.shape[1]):
                memory[there, c] = memory[at, c]
            if tangential is not None:
                for c in range(3):
                    memory[there, floats + SLIP + c] = -memory[at, floats + SLIP + c]
                    memory[there, floats + TURNED + c] = -memory[at, floats + TURNED + c]
        out[k, PUSH], out[k, PUSH + 1], out[k, PUSH + 2] = gx, gy, gz
        out[k, HALF], out[k, HALF + 1], out[k, HALF + 2] = 0.5 * dx * gx, 0.5 * dy * gy, 0.5 * dz * gz
        out[k, DEPTH], out[k, ENDED] = share * overlap / (scale * law.radius), 0.0
    return full


@kernel
def sum_up(turning, begin, entry, touching, out, radius, force, torque, sums):  # type: ignore[no-untyped-def]
    """Add what the pairs of each own sphere gave, in the order of the others' numbers; `turning` None: no torque."""
    for i in range(len(begin) - 1):
        fx, fy, fz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        hx, hy, hz, lost, sheared, dashed, deepest = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, sums[i, LARGEST]
        for e in range(begin[i], begin[i + 1]):
            k = entry[e] >> 1
            if not touching[k]:
                continue
            side = -1.0 if entry[e] & 1 == 0 else 1.0
            fx, fy, fz = fx + side * out[k, PUSH], fy + side * out[k, PUSH + 1], fz + side * out[k, PUSH + 2]
            hx, hy, hz = hx + out[k, HALF], hy + out[k, HALF + 1], hz + out[k, HALF + 2]
            deepest = max(deepest, out[k, DEPTH])
            lost += out[k, ENDED]
            if turning is not None:
                r = radius[i]
                tx += r * out[k, TWIST] - side * out[k, ROLL]
                ty += r * out[k, TWIST + 1] - side * out[k, ROLL + 1]
                tz += r * out[k, TWIST + 2] - side * out[k, ROLL + 2]
            if out.shape[1] == ROUGH:
                sheared, dashed = sheared + out[k, SHEAR], dashed + out[k, DASH]
        force[i, 0], force[i, 1], force[i, 2] = fx, fy, fz
        if turning is not None:
            torque[i, 0], torque[i, 1], torque[i, 2] = tx, ty, tz
        sums[i, VIRIAL], sums[i, VIRIAL + 1], sums[i, VIRIAL + 2] = hx, hy, hz
        sums[i, LARGEST] = deepest
        sums[i, LOST] += 0.5 * lost
        sums[i, SHEARED] += 0.5 * sheared
        sums[i, DAMPED] += 0.5 * dashed


@kernel
def forget(law, share, left, radius, partner, memory, sums):  # type: ignore[no-untyped-def]
    """Free the slots `left` of contacts whose spheres went out of each other's reach without being seen to part."""
    for at in left:
        i = at // SLOTS
        scale = pair.pair_scale(law, radius[i], radius[i], share)
        stored, dissipated = pair.pair_energy(law, scale, 0.0, dispatch.load_state(law, memory, at), share)
        sums[i, LOST] += 0.5 * (stored + dissipated)
        partner[at], memory[at] = 0, 0.0


@kernel
def carry(turning, mass, radius, force, torque, velocity, spin, half, fade, stretch, strain, sums):  # type: ignore[no-untyped-def]
    """Between the two half kicks of a step: velocities relative to a box that was stretched in the drift, the drag, the work of the box.

    LAMMPS has kicked for `half` (s) with the last forces and drifted, and will kick for `half` with `force` (N). `stretch` is what each
    edge of the box was multiplied by in the drift. After the second kick velocities and spins are to fade by `fade`: (v + h a) fade is
    reached from v fade + h a (fade - 1). `strain` is the change of each edge in this step and the next, over what it is now.
    """
    for i in range(len(force)):
        before, after, kicked = 0.0, 0.0, 0.0
        for a in range(3):
            v = velocity[i, a]
            relative = v / stretch[a]
            kick = half / mass[i] * force[i, a]
            before, after, kicked = before + v * v, after + relative * relative, kicked + (relative + kick) * (relative + kick)
            velocity[i, a] = relative * fade + kick * (fade - 1.0)
            sums[i, WORK] -= 0.5 * sums[i, VIRIAL + a] * strain[a]
        sums[i, WORK] += 0.5 * mass[i] * (after - before)
        sums[i, DRAGGED] += 0.5 * mass[i] * kicked * (1.0 - fade * fade)
        if turning is not None:
            inertia = 0.4 * mass[i] * radius[i] * radius[i]
            for a in range(3):
                kick = half / inertia * torque[i, a]
                turned = spin[i, a] + kick
                sums[i, DRAGGED] += 0.5 * inertia * turned * turned * (1.0 - fade * fade)
                spin[i, a] = spin[i, a] * fade + kick * (fade - 1.0)


@kernel
def first_kick(turning, mass, radius, velocity, spin, half, fade, strain, sums):  # type: ignore[no-untyped-def]
    """The beginning of an interval's first step, in place of LAMMPS: half of the fading, and the kick for `half` (s) by the last forces."""
    for i in range(len(velocity)):
        for a in range(3):
            v = velocity[i, a]
            sums[i, DRAGGED] += 0.5 * mass[i] * v * v * (1.0 - fade * fade)
            velocity[i, a] = v * fade + half / mass[i] * sums[i, FORCE + a]
            sums[i, WORK] -= 0.5 * sums[i, VIRIAL + a] * strain[a]
        if turning is not None:
            inertia = 0.4 * mass[i] * radius[i] * radius[i]
            for a in range(3):
                w = spin[i, a]
                sums[i, DRAGGED] += 0.5 * inertia * w * w * (1.0 - fade * fade)
                spin[i, a] = w * fade + half / inertia * sums[i, TORQUE + a]
