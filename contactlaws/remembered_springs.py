"""A few springs of a contact: what `contactlaws.maxwell_zener_ting` remembers, and how a contact that grows notes it.

Between the springs, force and strain are straight in the onset, and F_e'' is integrated exactly against straight lines and their products:
the table `onsets` of a law holds, for each spring, its overlap and the `weights` of the interval before it.
While the contact grows, one only notes when the springs in its way are touched; `begin_retreat` and `begin_growth` lead from there to
the springs' own states and back.
"""

from __future__ import annotations

import math

from contactlaws.compiled import inlined, kernel
from contactlaws.elastic import finite_size_energy, finite_size_force, finite_size_stiffness
from contactlaws.maxwell_element import decay
from contactlaws.maxwell_zener import ELASTIC, FORCE, LOST, OVERLAP, WORK

#: after the first five floats of `maxwell_zener`: time since the contact began (s), largest overlap and edge (m), number of springs that
#: have touched; the scale of the springs' force, 0 while the contact grows; the scale of their energy, and that energy (J) so scaled;
#: which spring is the next beyond the contact; and the overlap up to which a contact that grows touches no further spring, -1 for one that
#: has turned. Largest overlap and edge are those of a contact that has turned.
#: Then for each term f_i and q_i as there (while the springs are followed: exp(-dt/tau_i) and the share held), and the state of the first
#: spring (m); then for each spring, while the contact grows, the time at which it touched and the state of the first one then, and while
#: they are followed its force over stiffness, or minus the gap, and its own state; at last the state that the spring next beyond the
#: contact would have if it stuck to the flat.
TIME, DEEPEST, EDGE, TOUCHED, SCALE, SHARE, KEPT, NEXT, AHEAD, FIRST = range(5, 15)
#: between springs as near as this, over their overlap, F_e'' counts as even: differences of energies would lose all digits
NARROW = 1e-3


@kernel
def note_touching(times, onsets, overlap, dt, state):  # type: ignore[no-untyped-def]
    """While the contact grows through a step: when the springs in its way are touched, and the first spring's state then."""
    terms, before = times.size, state[OVERLAP]
    moved, own = overlap - before, FIRST + 2 * terms
    row = int(state[TOUCHED])
    while row < onsets.shape[1] and onsets[0, row] < overlap:
        part = (onsets[0, row] - before) / moved
        place = own + terms + row * (terms + 1)
        state[place] = state[TIME] + part * dt
        for i in range(terms):
            e, h = decay(part * dt / times[i])
            state[place + 1 + i] = e * state[own + i] + h * part * moved
        row += 1
    state[TOUCHED] = row


@inlined
def elastic_point(law, overlap):  # type: ignore[no-untyped-def]
    """Overlap, elastic force, slope and energy."""
    return overlap, finite_size_force(law, overlap), finite_size_stiffness(law, overlap), finite_size_energy(law, overlap)


@inlined
def weights(low, high):  # type: ignore[no-untyped-def]
    """Integrals of F_e'' times 1 - x, x and x^2, where x goes from 0 at the elastic point `low` to 1 at `high`.

    So a straight line has the integral `early` left + `late` right, whatever F_e is.
    """
    width, whole = high[0] - low[0], high[2] - low[2]
    if width <= NARROW * high[0]:
        return 0.5 * whole, 0.5 * whole, whole / 3.0
    mean = (high[1] - low[1]) / width
    return mean - low[2], high[2] - mean, high[2] - 2.0 / width * (high[1] - (high[3] - low[3]) / width)


@inlined
def squared(early, late, late_square, before, shared, own):  # type: ignore[no-untyped-def]
    """Integral of F_e'' times the product of two straight lines, of which the products at the ends and across are given."""
    across = late - late_square
    return (early - across) * before + 2.0 * across * shared + late_square * own


@inlined
def interval(law, onsets, row, end):  # type: ignore[no-untyped-def]
    """`weights` of the interval that ends at a remembered spring, or at the elastic point `end` beyond the last that was touched."""
    if row < onsets.shape[1] and onsets[0, row] < end[0]:
        return onsets[1, row], onsets[2, row], onsets[3, row]
    return weights(elastic_point(law, onsets[0, row - 1] if row > 0 else 0.0), end)


@inlined
def spring_place(terms, row):  # type: ignore[no-untyped-def]
    """Where in the state a spring's own state begins."""
    return FIRST + 2 * terms if row < 0 else FIRST + 3 * terms + row * (terms + 1) + 1


@inlined
def spring_energy(fractions, place, long_term, length, before, state):  # type: ignore[no-untyped-def]
    """Twice the energy of a spring over its stiffness, and the same of the product with the spring before it; their lengths are given."""
    terms = fractions.size
    own, shared = long_term * length * length, long_term * length * before
    for i in range(terms):
        z = state[place + i]
        own += fractions[i] * z * z
        shared += fractions[i] * z * state[place - terms - 1 + i]
    return own, shared


@kernel
def begin_retreat(law, state):  # type: ignore[no-untyped-def]
    """Turn times of touching into the springs' states, and scale their sum to the force at hand."""
    terms, own = law.fractions.size, FIRST + 2 * law.fractions.size
    for row in range(int(state[TOUCHED])):
        place = spring_place(terms, row)
        past = state[TIME] - state[place - 1]
        for i in range(terms):
            state[place + i] = state[own + i] - math.exp(-past / law.times[i]) * state[place + i]
    force, energy = springs_at_turn(law, state)
    state[SCALE], state[NEXT] = state[FORCE] / force if force > 0.0 else 1.0, state[TOUCHED]
    for i in range(terms):
        state[spring_place(terms, law.onsets.shape[1]) - 1 + i] = 0.0
    held = (state[WORK] - state[LOST]) / energy if energy > 0.0 else 1.0
    state[SHARE] = max(held, state[SCALE])  # what is scaled up gives as much more back


@kernel
def springs_at_turn(law, state):  # type: ignore[no-untyped-def]
    """Force and energy of the springs, all of which touch the flat up to its overlap."""
    terms, overlap, touched = law.fractions.size, state[OVERLAP], int(state[TOUCHED])
    long_term = 1.0
    for i in range(terms):
        long_term -= law.fractions[i]
    end = elastic_point(law, overlap)
    force, energy, left, before, length = 0.0, 0.0, 0.0, 0.0, 0.0
    for row in range(-1, touched + 1):
        right, own, shared = 0.0, 0.0, 0.0  # of the spring at the overlap
        if row < touched:
            place, previous = spring_place(terms, row), length
            length = overlap - (law.onsets[0, row] if row >= 0 else 0.0)
            own, shared = spring_energy(law.fractions, place, long_term, length, previous, state)
            right = long_term * length
            for i in range(terms):
                right += law.fractions[i] * state[place + i]
        if row >= 0:
            early, late, late_square = interval(law, law.onsets, row, end)
            force += early * left + late * right
            energy += 0.5 * squared(early, late, late_square, before, shared, own)
        left, before = right, own
    return force, energy


@kernel
def begin_growth(law, force, state):  # type: ignore[no-untyped-def]
    """Turn the springs' states into times of touching and forces of the terms, at the largest overlap, where `force` acts."""
    terms, own, touched = law.fractions.size, FIRST + 2 * law.fractions.size, int(state[TOUCHED])
    end = elastic_point(law, state[OVERLAP])
    for i in range(2 * terms):
        state[FIRST + i] = 0.0
    for row in range(touched + 1):
        early, late, late_square = interval(law, law.onsets, row, end)
        for i in range(terms):
            left = state[spring_place(terms, row - 1) + i]
            right = state[spring_place(terms, row) + i] if row < touched else 0.0
            state[FIRST + i] += early * left + late * right
            state[FIRST + terms + i] += squared(early, late, late_square, left * left, left * right, right * right)
    relaxing, found = 0.0, 0.0
    for i in range(terms):
        relaxing += law.fractions[i]
        found += law.fractions[i] * state[FIRST + i]
    missing = (force - (1.0 - relaxing) * end[1] - found) / relaxing if relaxing > 0.0 else 0.0
    for i in range(terms):
        state[FIRST + i] += missing
    for row in range(touched):
        place = spring_place(terms, row)
        state[place - 1] = state[TIME]
        for i in range(terms):
            state[place + i] = state[own + i] - state[place + i]
    state[ELASTIC], state[SCALE] = end[1], 0.0
