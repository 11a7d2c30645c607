"""A law made straight from a curve with its unloadings: exact on its own data, interpolated between them.

Loading: a power law up to the first row, then a monotone cubic (Fritsch & Carlson 1980) through all rows, then a straight line. Unloading
from a stored state: the rows of that branch, by the same cubic, as force over the force at its start against s = (d - d_0)/(d_max - d_0),
d_0 the separation. Between two stored states both curves are taken at the same s and mixed linearly in the logarithm of d_max; what
plasticity adds to the unloading stiffness, 1/(d_max - d_0) - 1/d_max, is a power of d_max. Between first yield and the first stored state
the shape is mixed with the elastic one, and that addition goes as phi d_max^-1/2: phi of Edmans & Sinka 2020 (Eq. 4) from 0 at first
yield, the power that of similar plastic indentation. Beyond the last stored state the shape stays and (d_max - d_0) grows with the force.
"""

from __future__ import annotations

import math

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.tabulated_record import AREA, END, FIRST, FORCE, LARGEST, OVERLAP, STEEPEST, STIFFENING, WORK, Tabulated, problems_with

GAMMA_5 = 0.3429  # Edmans & Sinka 2020, Table 1


@kernel
def column_below(table, first, end, value):  # type: ignore[no-untyped-def]
    """The column i in [first, end - 2] with x[i] <= value < x[i + 1], by bisection; x is the first row."""
    low, high = first, end - 1
    while high - low > 1:
        middle = (low + high) // 2
        if table[0, middle] <= value:
            low = middle
        else:
            high = middle
    return low


@kernel
def cubic(table, row, i, value):  # type: ignore[no-untyped-def]
    """Cubic Hermite interpolation of a row between columns i and i + 1; exact at both."""
    h = table[0, i + 1] - table[0, i]
    t = (value - table[0, i]) / h
    if t >= 1.0:
        return table[row, i + 1]
    chord = (table[row, i + 1] - table[row, i]) / h
    left, right = table[row + 1, i], table[row + 1, i + 1]
    return table[row, i] + h * t * (left + t * (3.0 * chord - 2.0 * left - right + t * (left + right - 2.0 * chord)))


@kernel
def cubic_integral(table, row, i, value):  # type: ignore[no-untyped-def]
    """Integral of `cubic` from column i to `value`."""
    h = table[0, i + 1] - table[0, i]
    t = (value - table[0, i]) / h
    chord = (table[row, i + 1] - table[row, i]) / h
    left, right = table[row + 1, i], table[row + 1, i + 1]
    bend = (3.0 * chord - 2.0 * left - right) / 3.0 + t * (left + right - 2.0 * chord) / 4.0
    return h * t * (table[row, i] + h * t * (left / 2.0 + t * bend))


@kernel
def steepest(table, row, i):  # type: ignore[no-untyped-def]
    """Largest derivative, up or down, of `cubic` between columns i and i + 1; it is a parabola in between."""
    chord = (table[row, i + 1] - table[row, i]) / (table[0, i + 1] - table[0, i])
    left, right = table[row + 1, i], table[row + 1, i + 1]
    curvature = 3.0 * chord - 2.0 * left - right
    twist = left + right - 2.0 * chord
    found = max(abs(left), abs(right))
    if twist != 0.0 and 0.0 < -curvature / (3.0 * twist) < 1.0:
        found = max(found, abs(left - curvature * curvature / (3.0 * twist)))
    return found


@kernel
def tabulated_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N of the first loading."""
    table, last = law.loading, law.loading.shape[1] - 1
    if overlap < table[OVERLAP, 0]:
        return table[FORCE, 0] * (overlap / table[OVERLAP, 0]) ** first_power(law)
    if overlap >= table[OVERLAP, last]:
        return table[FORCE, last] + table[FORCE + 1, last] * (overlap - table[OVERLAP, last])
    return cubic(table, FORCE, column_below(table, 0, last + 1, overlap), overlap)


@kernel
def first_power(law):  # type: ignore[no-untyped-def]
    """Power of the overlap that the force follows up to the first row."""
    return law.loading[FORCE + 1, 0] * law.loading[OVERLAP, 0] / law.loading[FORCE, 0]


@kernel
def tabulated_work(law, overlap):  # type: ignore[no-untyped-def]
    """Integral of `tabulated_loading` from 0."""
    table, last = law.loading, law.loading.shape[1] - 1
    if overlap < table[OVERLAP, 0]:
        power = first_power(law) + 1.0
        return table[FORCE, 0] * table[OVERLAP, 0] * (overlap / table[OVERLAP, 0]) ** power / power
    if overlap >= table[OVERLAP, last]:
        beyond = overlap - table[OVERLAP, last]
        return table[WORK, last] + beyond * (table[FORCE, last] + 0.5 * table[FORCE + 1, last] * beyond)
    column = column_below(table, 0, last + 1, overlap)
    return table[WORK, column] + cubic_integral(table, FORCE, column, overlap)


@kernel
def tabulated_area(law, overlap):  # type: ignore[no-untyped-def]
    """Contact radius squared on the loading, where it is known."""
    table, last = law.loading, law.loading.shape[1] - 1
    if overlap < table[OVERLAP, 0]:
        return table[AREA, 0] * overlap / table[OVERLAP, 0]
    if overlap >= table[OVERLAP, last]:
        return table[AREA, last] + table[AREA + 1, last] * (overlap - table[OVERLAP, last])
    return cubic(table, AREA, column_below(table, 0, last + 1, overlap), overlap)


@kernel
def stored_before(law, largest):  # type: ignore[no-untyped-def]
    """The stored unloading k and the share of the next one for a largest overlap beyond first yield; the share is 0 at and beyond the
    last.
    """
    table, count = law.stored, law.stored.shape[1]
    if largest >= table[LARGEST, count - 1]:
        return count - 1, 0.0
    k = column_below(table, 0, count, largest)
    return k, math.log(largest / table[LARGEST, k]) / math.log(table[LARGEST, k + 1] / table[LARGEST, k])


@kernel
def onset(law, largest):  # type: ignore[no-untyped-def]
    """phi, Eq. 4 with the published gamma_5."""
    return 1.0 - law.yield_overlap / (GAMMA_5 * largest + (1.0 - GAMMA_5) * law.yield_overlap)


@kernel
def recovered_overlap(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 in m."""
    k, share = stored_before(law, largest)
    stiffening, last = law.stored[STIFFENING], law.stored.shape[1] - 1
    if k == last:
        top = law.stored[LARGEST, last]
        return tabulated_loading(law, largest) / tabulated_loading(law, top) / (1.0 / top + stiffening[last])
    if k == 0:
        first = law.stored[LARGEST, 1]
        return 1.0 / (1.0 / largest + stiffening[1] * onset(law, largest) / onset(law, first) * math.sqrt(first / largest))
    return 1.0 / (1.0 / largest + stiffening[k] ** (1.0 - share) * stiffening[k + 1] ** share)


@kernel
def stored_shape(law, quantity, k, left):  # type: ignore[no-untyped-def]
    """FORCE or AREA over its value at the start of unloading k, or WORK as the integral of the former, at s = `left`."""
    column = column_below(law.unloading, int(law.stored[FIRST, k]), int(law.stored[END, k]), left)
    if quantity == WORK:
        return law.unloading[WORK, column] + cubic_integral(law.unloading, FORCE, column, left)
    return cubic(law.unloading, quantity, column, left)


@kernel
def shape(law, quantity, largest, left):  # type: ignore[no-untyped-def]
    """`stored_shape` for an unloading from `largest`, mixed from its two stored neighbours."""
    k, share = stored_before(law, largest)
    value = stored_shape(law, quantity, k, left)
    if share > 0.0:
        value += share * (stored_shape(law, quantity, k + 1, left) - value)
    return value


@kernel
def tabulated_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """The tables; the memory is the largest overlap."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    if overlap >= largest or law.stored.shape[1] == 0 or largest <= law.yield_overlap:
        return tabulated_loading(law, overlap), (largest,)
    left = 1.0 - (largest - overlap) / recovered_overlap(law, largest)
    if left <= 0.0:
        return 0.0, (largest,)
    return tabulated_loading(law, largest) * shape(law, FORCE, largest, left), (largest,)


@kernel
def tabulated_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """Square root of the tabulated area."""
    if overlap <= 0.0:
        return 0.0
    if law.loading.shape[0] <= AREA:
        return math.nan
    largest = max(overlap, state[0])
    if overlap >= largest or law.stored.shape[1] == 0 or largest <= law.yield_overlap:
        return math.sqrt(max(0.0, tabulated_area(law, overlap)))
    left = 1.0 - (largest - overlap) / recovered_overlap(law, largest)
    if left <= 0.0:
        return 0.0
    return math.sqrt(max(0.0, tabulated_area(law, largest) * shape(law, AREA, largest, left)))


@kernel
def tabulated_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: integral of the unloading below `overlap`; dissipated: work of the loading less the integral of the whole unloading."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    if law.stored.shape[1] == 0 or largest <= law.yield_overlap:
        return tabulated_work(law, max(overlap, 0.0)), 0.0
    recovered = recovered_overlap(law, largest)
    scale = tabulated_loading(law, largest) * recovered
    left = max(0.0, 1.0 - (largest - overlap) / recovered)
    stored = scale * shape(law, WORK, largest, left) if left > 0.0 else 0.0
    return stored, tabulated_work(law, largest) - scale * shape(law, WORK, largest, 1.0)


@kernel
def steepest_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Largest slope of the loading up to the first row from `overlap`."""
    found = law.loading[FORCE + 1, 0]
    for i in range(law.loading.shape[1] - 1):
        if law.loading[OVERLAP, i] < overlap:
            found = max(found, steepest(law.loading, FORCE, i))
    return found


@kernel
def unloading_slope(law, largest):  # type: ignore[no-untyped-def]
    """No unloading from `largest` is steeper than this over the force at its start, per m: slopes mix like the shapes."""
    k, share = stored_before(law, largest)
    slope = law.stored[STEEPEST, k]
    if share > 0.0:
        slope = max(slope, law.stored[STEEPEST, k + 1])
    return slope / recovered_overlap(law, largest)


@kernel
def tabulated_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Between two rows of the loading the largest force and the steepest unloading are at either end, so their product is a bound."""
    if overlap <= 0.0:
        return 0.0
    found = steepest_loading(law, overlap)
    if law.stored.shape[1] == 0 or overlap <= law.yield_overlap:
        return found
    before, rows = law.yield_overlap, law.loading.shape[1]
    for i in range(rows + 1):
        after = min(overlap, law.loading[OVERLAP, i]) if i < rows else overlap
        if after > before:
            slope = max(unloading_slope(law, before), unloading_slope(law, after))
            found = max(found, slope * max(tabulated_loading(law, before), tabulated_loading(law, after)))
            before = after
    return found


register(
    Law(
        "tabulated",
        Tabulated,
        tabulated_force,
        tabulated_contact_radius,
        tabulated_energy,
        tabulated_stiffness_bound,
        ("largest_overlap",),
        "monotone cubics through the rows of a curve and its unloadings",
        problems_with,
    )
)
