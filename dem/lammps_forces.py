"""The contact forces of spheres that LAMMPS moves: own spheres have slots for what their contacts remember, which LAMMPS carries along.

What a contact remembers lies with both spheres. A contact of two spheres of one rank is computed once, for both; one that reaches across
the border of two ranks twice, on each from its side, by the same kernel from the same numbers: so nothing has to be sent between steps.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws import dispatch, pair
from contactlaws.compiled import inlined, kernel
from contactlaws.tangential import damper_force, dragged, tangential_stiffness

#: columns of each sphere's sums: its share of d F per axis over its contacts in J; largest overlap of one body over its radius, at any
#: time; its share of the J used up by contacts that have ended, that tangential forces and moments took up, and that dampers took; J taken
#: by the drag; J given by the moving box; force in N and torque in N m at the end of an interval; s since the rank began that has the
#: sphere; deepest overlap in m of any contact of that rank at the end of an interval; its share of d F in J of the axes `ACROSS`, at the
#: end of an interval, of the first three in each step if the box leans. Its share is half of a contact of two spheres, and all of one with
#: a wall
VIRIAL, LARGEST, LOST, SHEARED, DAMPED, DRAGGED, WORK, FORCE, TORQUE, CLOCK, OVERLAP, LEANING = 0, 3, 4, 5, 6, 7, 8, 9, 12, 15, 16, 17
SUMS = 23
#: what comes after that where walls move by themselves: force in N on walls per axis, times the share of the edge's change that each makes
PRESSED = SUMS
#: or where the box leans: position in m at the end of an interval
PLACE = SUMS
#: contacts that one sphere remembers at a time; equal spheres that do not overlap leave room for twelve
SLOTS = 20
#: in place of the second's slot: it is a ghost, a wall, or looks after itself in another pair
ONE_SIDED = -2
#: the axes of d and F in the columns from `LEANING` on
ACROSS = ((1, 0), (2, 0), (2, 1), (0, 1), (0, 2), (1, 2))
#: columns of what a pair gives: force on the second; the share of d F per axis; overlap of one body over its radius; energy of the
#: contact, if it has just ended; and with friction or a damper: torque on both, over their radii; rolling moment on the first; work of
#: these two; of the damper; and where the box leans: the share of d F of y with x, z with x and z with y
PUSH, HALF, DEPTH, ENDED, TWIST, ROLL, SHEAR, DASH = 0, 3, 6, 7, 8, 11, 14, 15
LEAN = 16
SMOOTH, ROUGH, LEANED = 8, 16, 19
#: the finer unit of `round_off_apart` over the coarser: each of 2^30 spheres may leave half of that one, in numbers of 53 bits
FINER = 2.0**-23
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
def _taken(partner, i, other):  # type: ignore[no-untyped-def]
    """A free slot of own sphere i, now for sphere number `other`, or, negative, a wall; -1 if there is none."""
    for s in range(i * SLOTS, (i + 1) * SLOTS):
        if partner[s] == 0:
            partner[s] = other
            return s
    return -1


@kernel
def pair_forces(  # type: ignore[no-untyped-def]
    law, tangential, rolling, damper, share, leaning, first, second, slots, touching, walls,
    tag, position, radius, mass, velocity, spin, back, gradient, images, edges, dt, floats, partner, memory, out,
):  # fmt: skip
    """What each pair gives, into its row of `out`, where `touching` says so.

    partner, memory: one row per slot of the own spheres, of which the law has the first columns and what is beyond it those from `floats`
    on; `velocity` None: nothing asks for speeds; `spin` None: no friction; `leaning` None: the box is a cuboid. The velocities are those
    before the box was stretched by the inverse of `back`, with the `gradient` (1/s); `images` None: it carries the spheres along. If not,
    they say by how many edges the second lies off, and `edges` how fast these change, in m/s. With `walls` (see `forces.Frame`) the second
    of each pair is one of them. Returns the number of a sphere with more contacts than slots, 0 if there is none. It is long because it is
    the loop that costs.
    """
    full, part = 0, 0.5 if walls is None else 1.0
    for k in range(len(first)):
        i, j = first[k], second[k]
        if walls is None:
            dx, dy, dz = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1], position[j, 2] - position[i, 2]
            reach = radius[i] + radius[j]
        else:
            axis, reach = int(walls[j, 0]), radius[i]
            off = walls[j, 2] - position[i, axis]
            dx, dy, dz = off if axis == 0 else 0.0, off if axis == 1 else 0.0, off if axis == 2 else 0.0
        square = dx * dx + dy * dy + dz * dz
        at = slots[k, 0]
        open_ = square >= reach * reach
        if open_ and at < 0:
            touching[k] = False
            continue
        touching[k] = True
        scale = pair.pair_scale(law, radius[i], radius[j], share) if walls is None else pair.wall_scale(law, radius[i])
        distance = math.sqrt(square)
        vx, vy, vz, rate = 0.0, 0.0, 0.0, 0.0
        if velocity is not None:
            ux, uy, uz = -velocity[i, 0], -velocity[i, 1], -velocity[i, 2]
            if walls is None:
                ux, uy, uz = velocity[j, 0] + ux, velocity[j, 1] + uy, velocity[j, 2] + uz
            vx = ux * back[0, 0] + uy * back[1, 0] + uz * back[2, 0] + dx * gradient[0, 0] + dy * gradient[1, 0] + dz * gradient[2, 0]
            vy = uy * back[1, 1] + uz * back[2, 1] + dx * gradient[0, 1] + dy * gradient[1, 1] + dz * gradient[2, 1]
            vz = uz * back[2, 2] + dx * gradient[0, 2] + dy * gradient[1, 2] + dz * gradient[2, 2]
            if images is not None:
                vx, vy, vz = vx + images[k, 0] * edges[0], vy + images[k, 1] * edges[1], vz + images[k, 2] * edges[2]
            if walls is not None:
                speed = walls[j, 3]
                vx, vy, vz = vx + (speed if axis == 0 else 0.0), vy + (speed if axis == 1 else 0.0), vz + (speed if axis == 2 else 0.0)
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
            both = slots[k, 1] != ONE_SIDED
            at = _taken(partner, i, tag[j] if walls is None else -1 - j)
            slots[k, 0] = at
            if both:
                slots[k, 1] = _taken(partner, j, tag[i])
            if at < 0 or (both and slots[k, 1] < 0):
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
            m = mass[i] * mass[j] / (mass[i] + mass[j]) if walls is None else mass[i]
            held = max(f + damper_force(damper, a, m, rate), 0.0) - f
            out[k, DASH] = 0.5 * (held + memory[at, floats + HELD]) * rate * dt
            memory[at, floats + HELD] = held
            f += held
        inverse = 1.0 / distance
        push = f * inverse
        gx, gy, gz = push * dx, push * dy, push * dz
        if tangential is not None:
            n = (dx * inverse, dy * inverse, dz * inverse)
            cx, cy, cz, arm = spin[i, 0], spin[i, 1], spin[i, 2], radius[i]
            if walls is None:
                ri, rj = radius[i], radius[j]
                arm = ri * rj / reach
                cx, cy, cz = (ri * cx + rj * spin[j, 0]) / reach, (ri * cy + rj * spin[j, 1]) / reach, (ri * cz + rj * spin[j, 2]) / reach
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
                turned = floats + TURNED
                old = (memory[at, turned], memory[at, turned + 1], memory[at, turned + 2])
                angle = (-spin[i, 0] * dt, -spin[i, 1] * dt, -spin[i, 2] * dt)
                if walls is None:
                    angle = ((spin[j, 0] - spin[i, 0]) * dt, (spin[j, 1] - spin[i, 1]) * dt, (spin[j, 2] - spin[i, 2]) * dt)
                stiffness = tangential_stiffness(tangential, a) * arm * arm
                moment, work = dragged(stiffness, rolling.friction * arm * f, a, had, turn, n, angle, old)
                memory[at, turned], memory[at, turned + 1], memory[at, turned + 2] = moment
                out[k, ROLL], out[k, ROLL + 1], out[k, ROLL + 2] = moment
                out[k, SHEAR] += work
        if slots[k, 1] != ONE_SIDED:  # the second remembers the same, seen from its side
            there = slots[k, 1]
            for c in range(memory.shape[1]):
                memory[there, c] = memory[at, c]
            if tangential is not None:
                for c in range(3):
                    memory[there, floats + SLIP + c] = -memory[at, floats + SLIP + c]
                    memory[there, floats + TURNED + c] = -memory[at, floats + TURNED + c]
        out[k, PUSH], out[k, PUSH + 1], out[k, PUSH + 2] = gx, gy, gz
        out[k, HALF], out[k, HALF + 1], out[k, HALF + 2] = part * dx * gx, part * dy * gy, part * dz * gz
        out[k, DEPTH], out[k, ENDED] = share * overlap / (scale * law.radius), 0.0
        if leaning is not None:
            out[k, LEAN], out[k, LEAN + 1], out[k, LEAN + 2] = part * dy * gx, part * dz * gx, part * dz * gy
        if walls is not None and walls[j, 1] * off >= 0.0:  # it went through: nothing that follows means anything
            out[k, DEPTH] = math.inf
    return full


@kernel
def sum_up(turning, leaning, begin, entry, touching, out, part, begun, radius, force, torque, sums):  # type: ignore[no-untyped-def]
    """Add what the pairs of each own sphere gave, in the order of the others' numbers; `turning` None: no torque; `leaning`: see there.

    part: of what a pair takes up that is this sphere's. begun: whether there are sums of other pairs to add to.
    """
    for i in range(len(begin) - 1):
        fx, fy, fz, tx, ty, tz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        hx, hy, hz, lost, sheared, dashed, deepest = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, sums[i, LARGEST]
        yx, zx, zy = 0.0, 0.0, 0.0
        if begun:
            fx, fy, fz, hx, hy, hz = force[i, 0], force[i, 1], force[i, 2], sums[i, VIRIAL], sums[i, VIRIAL + 1], sums[i, VIRIAL + 2]
            if turning is not None:
                tx, ty, tz = torque[i, 0], torque[i, 1], torque[i, 2]
            if leaning is not None:
                yx, zx, zy = sums[i, LEANING], sums[i, LEANING + 1], sums[i, LEANING + 2]
        for e in range(begin[i], begin[i + 1]):
            k = entry[e] >> 1
            if not touching[k]:
                continue
            side = -1.0 if entry[e] & 1 == 0 else 1.0
            fx, fy, fz = fx + side * out[k, PUSH], fy + side * out[k, PUSH + 1], fz + side * out[k, PUSH + 2]
            hx, hy, hz = hx + out[k, HALF], hy + out[k, HALF + 1], hz + out[k, HALF + 2]
            deepest = max(deepest, out[k, DEPTH])
            lost += out[k, ENDED]
            if leaning is not None:
                yx, zx, zy = yx + out[k, LEAN], zx + out[k, LEAN + 1], zy + out[k, LEAN + 2]
            if out.shape[1] >= ROUGH:
                sheared, dashed = sheared + out[k, SHEAR], dashed + out[k, DASH]
                if turning is not None:
                    r = radius[i]
                    tx += r * out[k, TWIST] - side * out[k, ROLL]
                    ty += r * out[k, TWIST + 1] - side * out[k, ROLL + 1]
                    tz += r * out[k, TWIST + 2] - side * out[k, ROLL + 2]
        force[i, 0], force[i, 1], force[i, 2] = fx, fy, fz
        if turning is not None:
            torque[i, 0], torque[i, 1], torque[i, 2] = tx, ty, tz
        sums[i, VIRIAL], sums[i, VIRIAL + 1], sums[i, VIRIAL + 2] = hx, hy, hz
        if leaning is not None:
            sums[i, LEANING], sums[i, LEANING + 1], sums[i, LEANING + 2] = yx, zx, zy
        sums[i, LARGEST] = deepest
        sums[i, LOST] += part * lost
        sums[i, SHEARED] += part * sheared
        sums[i, DAMPED] += part * dashed


@kernel
def sum_up_across(begin, entry, first, second, touching, out, walls, part, begun, position, sums):  # type: ignore[no-untyped-def]
    """d F of one axis with another of each own sphere, into its columns from `LEANING` on; arguments as those of `sum_up`."""
    d = np.zeros(3)
    for i in range(len(begin) - 1):
        if not begun:
            for c in range(6):
                sums[i, LEANING + c] = 0.0
        for e in range(begin[i], begin[i + 1]):
            k = entry[e] >> 1
            if not touching[k]:
                continue
            for a in range(3):
                d[a] = 0.0
                if walls is None:
                    d[a] = part * (position[second[k], a] - position[first[k], a])
            if walls is not None:
                axis = int(walls[second[k], 0])
                d[axis] = walls[second[k], 2] - position[first[k], axis]
            for c, (a, b) in enumerate(ACROSS):
                sums[i, LEANING + c] += d[a] * out[k, PUSH + b]


@kernel
def press(first, second, touching, out, walls, moving, sums):  # type: ignore[no-untyped-def]
    """Add what walls that move by themselves are pressed with to the columns `PRESSED` of their spheres."""
    for k in range(len(first)):
        if touching[k]:
            axis = int(walls[second[k], 0])
            sums[first[k], PRESSED + axis] += out[k, PUSH + axis] * (-moving if walls[second[k], 1] > 0.0 else 1.0 - moving)


@kernel
def deepest(first, second, touching, walls, position, radius):  # type: ignore[no-untyped-def]
    """Deepest overlap in m of any of the pairs."""
    most = 0.0
    for k in range(len(first)):
        if touching[k]:
            i, j, square = first[k], second[k], 0.0
            if walls is None:
                for a in range(3):
                    square += (position[j, a] - position[i, a]) ** 2
                most = max(most, radius[i] + radius[j] - math.sqrt(square))
            else:
                most = max(most, radius[i] - abs(walls[j, 2] - position[i, int(walls[j, 0])]))
    return most


@kernel
def round_off_apart(sums, unit, shares):  # type: ignore[no-untyped-def]
    """The virials of the own spheres as two numbers each per axis, multiples of `unit` (a power of two, in J) and of a power of two less.

    Such numbers add up without any rounding, so that their sum over all spheres is the same however these are spread over ranks.
    """
    for i in range(len(sums)):
        for a in range(3):
            whole = unit * np.rint(sums[i, VIRIAL + a] / unit)
            rest = FINER * unit * np.rint((sums[i, VIRIAL + a] - whole) / (FINER * unit))
            shares[i, a], shares[i, 3 + a] = whole, rest


@kernel
def forget(law, share, left, radius, partner, memory, sums):  # type: ignore[no-untyped-def]
    """Free the slots `left` of contacts whose spheres went out of each other's reach without being seen to part."""
    for at in left:
        i = at // SLOTS
        walls = partner[at] < 0
        scale = pair.wall_scale(law, radius[i]) if walls else pair.pair_scale(law, radius[i], radius[i], share)
        stored, dissipated = pair.pair_energy(law, scale, 0.0, dispatch.load_state(law, memory, at), share)
        sums[i, LOST] += (1.0 if walls else 0.5) * (stored + dissipated)
        partner[at], memory[at] = 0, 0.0


@inlined
def _worked(i, strain, leaning, walled, unwrapped, force, first, sums):  # type: ignore[no-untyped-def]
    """J that the boundary gives in the half of a step, which strains the box by `strain`, by contacts that sphere i has part in.

    Where the box carries nothing along, that is what is left of the virial without the way of the sphere itself (`unwrapped`), in images;
    or what moving walls do (`walled`; there `strain` is the change of the edges in m). `force` is found in the columns from `first` on.
    """
    work = 0.0
    for a in range(3):
        tension = sums[i, VIRIAL + a]
        if walled is not None:
            tension = sums[i, PRESSED + a]
        if unwrapped is not None:
            tension -= unwrapped[i, a] * force[i, first + a]
        work -= 0.5 * tension * strain[a, a]
    if leaning is not None:
        sheared = sums[i, LEANING] * strain[1, 0] + sums[i, LEANING + 1] * strain[2, 0] + sums[i, LEANING + 2] * strain[2, 1]
        work -= 0.5 * sheared
    return work


@kernel
def carry(  # type: ignore[no-untyped-def]
    turning, leaning, walled, mass, radius, force, torque, position, velocity, spin, half, fade, back, strain, unwrapped, now, after, sums
):
    """Between the two half kicks of a step: velocities relative to a box that was stretched in the drift, the drag, the work of the box.

    LAMMPS has kicked for `half` (s) with the last forces and drifted, and will kick for `half` with `force` (N). `back` is the inverse of
    what the box was stretched by in the drift. After the second kick velocities and spins are to fade by `fade`: (v + h a) fade is reached
    from v fade + h a (fade - 1). `strain` is the change of the box in this step and the next, over what it is now. `unwrapped` None: the
    box carries the spheres along, or nothing but walls moves. If not, LAMMPS's own positions follow their image in the box that goes from
    the edges `now` to `after` (m).
    """
    for i in range(len(force)):
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        rx, ry, rz = vx * back[0, 0] + vy * back[1, 0] + vz * back[2, 0], vy * back[1, 1] + vz * back[2, 1], vz * back[2, 2]
        h = half / mass[i]
        kx, ky, kz = h * force[i, 0], h * force[i, 1], h * force[i, 2]
        kicked = (rx + kx) * (rx + kx) + (ry + ky) * (ry + ky) + (rz + kz) * (rz + kz)
        given = rx * rx + ry * ry + rz * rz - (vx * vx + vy * vy + vz * vz)
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = (
            rx * fade + kx * (fade - 1.0),
            ry * fade + ky * (fade - 1.0),
            rz * fade + kz * (fade - 1.0),
        )
        if unwrapped is not None:
            for a in range(3):
                image = np.rint((unwrapped[i, a] - position[i, a]) / now[a, a])
                unwrapped[i, a] = position[i, a] + image * now[a, a]
                position[i, a] -= image * (after[a, a] - now[a, a])
        sums[i, WORK] += 0.5 * mass[i] * given + _worked(i, strain, leaning, walled, unwrapped, force, 0, sums)
        sums[i, DRAGGED] += 0.5 * mass[i] * kicked * (1.0 - fade * fade)
        if turning is not None:
            inertia = 0.4 * mass[i] * radius[i] * radius[i]
            for a in range(3):
                kick = half / inertia * torque[i, a]
                turned = spin[i, a] + kick
                sums[i, DRAGGED] += 0.5 * inertia * turned * turned * (1.0 - fade * fade)
                spin[i, a] = spin[i, a] * fade + kick * (fade - 1.0)


@kernel
def first_kick(  # type: ignore[no-untyped-def]
    turning, leaning, walled, mass, radius, position, velocity, spin, half, fade, strain, unwrapped, now, after, sums
):
    """The beginning of an interval's first step, in place of LAMMPS: half of the fading, and the kick for `half` (s) by the last forces.

    The other arguments are those of `carry`.
    """
    for i in range(len(velocity)):
        for a in range(3):
            v = velocity[i, a]
            sums[i, DRAGGED] += 0.5 * mass[i] * v * v * (1.0 - fade * fade)
            velocity[i, a] = v * fade + half / mass[i] * sums[i, FORCE + a]
            if unwrapped is not None:
                position[i, a] -= np.rint((unwrapped[i, a] - position[i, a]) / now[a, a]) * (after[a, a] - now[a, a])
        sums[i, WORK] += _worked(i, strain, leaning, walled, unwrapped, sums, FORCE, sums)
        if turning is not None:
            inertia = 0.4 * mass[i] * radius[i] * radius[i]
            for a in range(3):
                w = spin[i, a]
                sums[i, DRAGGED] += 0.5 * inertia * w * w * (1.0 - fade * fade)
                spin[i, a] = w * fade + half / inertia * sums[i, TORQUE + a]
