"""One step of a contact that shrinks, or has shrunk and not yet grown back: the springs of `contactlaws.remembered_springs` one by one.

Those that would pull let go, relax by themselves and are met again. Where the contact ends between two springs, the force of those in
contact is followed on to a spring that is made to stick to the flat: so few springs give the edge rightly on a first retreat, fast or slow.
"""

from __future__ import annotations

from contactlaws.compiled import inlined, kernel
from contactlaws.maxwell_element import decay
from contactlaws.maxwell_zener import OVERLAP
from contactlaws.remembered_springs import (
    DEEPEST,
    EDGE,
    FIRST,
    KEPT,
    NEXT,
    SCALE,
    SHARE,
    TOUCHED,
    elastic_point,
    interval,
    spring_energy,
    spring_place,
    squared,
    weights,
)


@inlined
def move_spring(fractions, place, at, overlap, onset_overlap, long_term, at_once, touched, state):  # type: ignore[no-untyped-def]
    """Take one spring through a step: its force over stiffness, or, where it is off the flat, minus the gap; and its new length."""
    terms = fractions.size
    past, left = 0.0, 0.0
    for i in range(terms):
        past += fractions[i] * state[place + i]
        left += fractions[i] * state[FIRST + i] * state[place + i]
    length = at - onset_overlap
    if not touched:
        length = 0.0
    elif long_term * length + past <= 0.0:
        length = -past / long_term  # it was off the flat: nothing held it
    added = overlap - onset_overlap - length
    push = long_term * length + left + at_once * added
    if push <= 0.0:
        push /= at_once
        added -= push
    for i in range(terms):
        state[place + i] = state[FIRST + i] * state[place + i] + state[FIRST + terms + i] * added
    return push, length + added


@inlined
def move_springs(law, fractions, times, onsets, overlap, dt, end, state):  # type: ignore[no-untyped-def]
    """Take all springs through a step to `overlap`; what each then pushes is noted in front of its state, that of the first is given back.

    Given back too: the springs' energy. end: the elastic point at the largest overlap, where a spring has no energy.
    """
    terms, at, touched = fractions.size, state[OVERLAP], int(state[TOUCHED])
    long_term, at_once = 1.0, 1.0
    for i in range(terms):
        e, h = decay(dt / times[i])
        state[FIRST + i], state[FIRST + terms + i] = e, h
        long_term -= fractions[i]
        at_once -= fractions[i] * (1.0 - h)
    place, row, energy = spring_place(terms, -1), 0, 0.0
    first, length = move_spring(fractions, place, at, overlap, 0.0, long_term, at_once, True, state)
    before, _ = spring_energy(fractions, place, long_term, length, 0.0, state)
    while row < onsets.shape[1] and onsets[0, row] < end[0]:
        place, previous = place + terms + 1, length
        state[place - 1], length = move_spring(fractions, place, at, overlap, onsets[0, row], long_term, at_once, row < touched, state)
        own, shared = spring_energy(fractions, place, long_term, length, previous, state)
        energy += squared(onsets[1, row], onsets[2, row], onsets[3, row], before, shared, own)
        before = own
        row += 1
    state[TOUCHED] = row
    early, late, late_square = interval(law, onsets, row, end)
    return first, 0.5 * (energy + squared(early, late, late_square, before, 0.0, 0.0))


@inlined
def stuck_pull(fractions, onsets, first, overlap, moved, gap_before, state):  # type: ignore[no-untyped-def]
    """What the spring next beyond the contact would pull, over its stiffness, if it had stuck to the flat when that moved away.

    The force of those in contact goes on smoothly into this pull, so where a straight line from one to the other meets zero the force ends.
    While the gap closes again the edge comes nearer as the gap does, and the spring is taken to stick as is needed for that edge.
    gap_before: at the start of the step.
    """
    row = int(state[TOUCHED])
    while row >= 0 and pushed(fractions.size, onsets, first, row - 1, overlap, state)[1] <= 0.0:
        row -= 1
    if row < 0:
        state[NEXT] = -1.0
        return 0.0
    (low, left), (high, push) = (
        pushed(fractions.size, onsets, first, row - 1, overlap, state),
        pushed(fractions.size, onsets, first, row, overlap, state),
    )
    terms = fractions.size
    place, stuck = spring_place(terms, row), spring_place(terms, onsets.shape[1]) - 1
    long_term, pull = 1.0, 0.0
    for i in range(terms):
        if row == state[NEXT]:
            state[stuck + i] = state[FIRST + i] * state[stuck + i] + state[FIRST + terms + i] * moved
        elif row == state[TOUCHED]:
            state[stuck + i] = 0.0
        else:  # what it has grown since it left, in this step, is taken back
            state[stuck + i] = state[place + i] + state[FIRST + terms + i] * push
        pull += fractions[i] * state[stuck + i]
        long_term -= fractions[i]
    pull += long_term * (overlap - high)
    wanted = pull
    if row > state[NEXT]:
        wanted = push
    elif row == state[NEXT] and -push < gap_before:
        beyond = (high - max(state[EDGE], low)) * (-push / gap_before)
        wanted = -left * beyond / max(high - beyond - low, 1e-300)
    wanted = min(max(wanted, push), long_term * push)
    if wanted != pull and long_term < 1.0:
        for i in range(terms):
            state[stuck + i] += (wanted - pull) / (1.0 - long_term)
    state[NEXT] = row
    return wanted


@inlined
def pushed(terms, onsets, first, row, overlap, state):  # type: ignore[no-untyped-def]
    """Onset and push of a spring; the one after the last that was touched lies at the largest overlap."""
    if row < 0:
        return 0.0, first
    if row < int(state[TOUCHED]):
        return onsets[0, row], state[spring_place(terms, row) - 1]
    deepest = max(state[DEEPEST], overlap)
    return deepest, overlap - deepest


@inlined
def springs_force(law, terms, onsets, first, pull, overlap, end, state):  # type: ignore[no-untyped-def]
    """Force of the springs, and the onset up to which they push; first: what the first one pushes, pull: the one beyond the contact."""
    total, edge = 0.0, 0.0
    low, left = 0.0, first
    for row in range(int(state[TOUCHED]) + 1):
        high, right = pushed(terms, onsets, first, row, overlap, state)
        if left > 0.0 and right > 0.0:
            early, late, _ = interval(law, onsets, row, end)
            total += early * left + late * right
            edge = high
        elif left > 0.0:
            edge = low + (high - low) * left / (left - (pull if row == state[NEXT] else right))
            total += left * weights(elastic_point(law, low), elastic_point(law, edge))[0]
        elif right > 0.0:
            edge = high
            begins = high - (high - low) * right / (right - left)
            total += right * weights(elastic_point(law, begins), elastic_point(law, high))[1]
        low, left = high, right
    return max(0.0, total), edge


@kernel
def retreat(law, overlap, dt, state):  # type: ignore[no-untyped-def]
    """Take all springs through a step to `overlap`: force in N. Notes the edge and the springs' energy."""
    fractions, times, onsets = law.fractions, law.times, law.onsets  # once: each look into a record of arrays counts a reference
    terms, following = fractions.size, int(state[NEXT])
    gap = state[DEEPEST] - state[OVERLAP] if following == int(state[TOUCHED]) else -state[spring_place(terms, max(following, 0)) - 1]
    end = elastic_point(law, max(state[DEEPEST], overlap))
    first, energy = move_springs(law, fractions, times, onsets, overlap, dt, end, state)
    pull = stuck_pull(fractions, onsets, first, overlap, overlap - state[OVERLAP], gap, state)
    force, state[EDGE] = springs_force(law, terms, onsets, first, pull, overlap, end, state)
    state[KEPT] = state[SHARE] * energy
    return state[SCALE] * force
