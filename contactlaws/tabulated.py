"""A law made straight from a curve with its unloadings: exact on its own data, interpolated between them.

Loading: a power law up to the first row, then a monotone cubic (Fritsch & Carlson 1980) through all rows, then a straight line. Unloading from a
stored state: the rows of that branch, by the same cubic, as force over the force at its start against s = (d - d_0)/(d_max - d_0), d_0 the separation.
Between two stored states both curves are taken at the same s and mixed linearly in the logarithm of d_max; what plasticity adds to the unloading
stiffness, 1/(d_max - d_0) - 1/d_max, is a power of d_max. Between first yield and the first stored state the shape is mixed with the elastic one,
and that addition goes as phi d_max^-1/2: phi of Edmans & Sinka 2020 (Eq. 4) from 0 at first yield, the power that of similar plastic indentation. Beyond the last stored state the shape stays and (d_max - d_0) grows with the force.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register

FloatArray = npt.NDArray[np.float64]
GAMMA_5 = 0.3429  # Edmans & Sinka 2020, Table 1


class Tabulated(NamedTuple):
    """The tables; made by `contactlaws.tabulate.from_curve`, which says what each curve must have.

    All unloadings stand one after the other in `unload_*`; unloading k in the rows `start[k]` to `start[k + 1]`. Without unloadings the body is
    elastic. The contact radius is NaN where the curve has none.
    """

    radius: float  # m
    yield_overlap: float  # m; up to here unloading follows the loading
    overlap: FloatArray  # m; of the loading
    force: FloatArray  # N
    slope: FloatArray  # N/m
    work: FloatArray  # J; integral of the force up to each row
    area: FloatArray  # m2; contact radius squared; empty if not known
    area_slope: FloatArray  # m
    largest: FloatArray  # m; overlap at the start of each unloading
    stiffening: FloatArray  # 1/m; 1/(d_max - d_0) - 1/d_max of each
    start: FloatArray  # first row of each in what follows, and the number of all rows at the end
    unload_left: FloatArray  # s, from 0 at separation to 1
    unload_force: FloatArray  # over the force at the start
    unload_slope: FloatArray
    unload_steepest: FloatArray  # largest slope of each unloading
    unload_work: FloatArray  # integral of unload_force from 0
    unload_area: FloatArray  # over the area at the start; empty if not known
    unload_area_slope: FloatArray
    last_work: float  # J; the same as work[-1], to keep the straight line's account


@kernel
def row_below(x, first, last, value):  # type: ignore[no-untyped-def]
    """The row i in [first, last - 2] with x[i] <= value < x[i + 1], by bisection."""
    low, high = first, last - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x[middle] <= value:
            low = middle
        else:
            high = middle
    return low


@kernel
def cubic(x, y, slope, i, value):  # type: ignore[no-untyped-def]
    """Cubic Hermite interpolation between rows i and i + 1; gives y exactly at both."""
    h = x[i + 1] - x[i]
    t = (value - x[i]) / h
    if t >= 1.0:
        return y[i + 1]
    chord = (y[i + 1] - y[i]) / h
    curvature = (3.0 * chord - 2.0 * slope[i] - slope[i + 1]) * h
    twist = (slope[i] + slope[i + 1] - 2.0 * chord) * h
    return y[i] + t * (slope[i] * h + t * (curvature + t * twist))


@kernel
def steepest(x, y, slope, i):  # type: ignore[no-untyped-def]
    """Largest derivative of `cubic` between rows i and i + 1; it is a parabola in between."""
    chord = (y[i + 1] - y[i]) / (x[i + 1] - x[i])
    curvature = 3.0 * chord - 2.0 * slope[i] - slope[i + 1]
    twist = slope[i] + slope[i + 1] - 2.0 * chord
    found = max(slope[i], slope[i + 1])
    if twist < 0.0 and 0.0 < -curvature / (3.0 * twist) < 1.0:
        found = max(found, slope[i] - curvature * curvature / (3.0 * twist))
    return found


@kernel
def cubic_integral(x, y, slope, i, value):  # type: ignore[no-untyped-def]
    """Integral of `cubic` from x[i] to `value`."""
    h = x[i + 1] - x[i]
    t = (value - x[i]) / h
    chord = (y[i + 1] - y[i]) / h
    curvature = (3.0 * chord - 2.0 * slope[i] - slope[i + 1]) * h
    twist = (slope[i] + slope[i + 1] - 2.0 * chord) * h
    return h * t * (y[i] + t * (slope[i] * h / 2.0 + t * (curvature / 3.0 + t * twist / 4.0)))


@kernel
def tabulated_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N of the first loading."""
    x, y, slope, last = law.overlap, law.force, law.slope, law.overlap.size - 1
    if overlap < x[0]:
        return y[0] * (overlap / x[0]) ** (slope[0] * x[0] / y[0])
    if overlap >= x[last]:
        return y[last] + slope[last] * (overlap - x[last])
    return cubic(x, y, slope, row_below(x, 0, x.size, overlap), overlap)


@kernel
def tabulated_work(law, overlap):  # type: ignore[no-untyped-def]
    """Integral of `tabulated_loading` from 0."""
    x, y, slope, last = law.overlap, law.force, law.slope, law.overlap.size - 1
    if overlap < x[0]:
        power = slope[0] * x[0] / y[0]
        return y[0] * x[0] * (overlap / x[0]) ** (power + 1.0) / (power + 1.0)
    if overlap >= x[last]:
        beyond = overlap - x[last]
        return law.last_work + beyond * (y[last] + 0.5 * slope[last] * beyond)
    row = row_below(x, 0, x.size, overlap)
    return law.work[row] + cubic_integral(x, y, slope, row, overlap)


@kernel
def tabulated_area(law, overlap):  # type: ignore[no-untyped-def]
    """Contact radius squared on the loading; NaN if not known."""
    if law.area.size == 0:
        return math.nan
    x, last = law.overlap, law.overlap.size - 1
    if overlap < x[0]:
        return law.area[0] * overlap / x[0]
    if overlap >= x[last]:
        return law.area[last] + law.area_slope[last] * (overlap - x[last])
    return cubic(x, law.area, law.area_slope, row_below(x, 0, x.size, overlap), overlap)


@kernel
def stored_before(law, largest):  # type: ignore[no-untyped-def]
    """The stored unloading k and the share of the next one for a largest overlap; k = -1 is the elastic response at first yield.

    The share is 0 at and beyond the last.
    """
    count = law.largest.size
    if largest >= law.largest[count - 1]:
        return count - 1, 0.0
    if largest < law.largest[0]:
        return -1, math.log(largest / law.yield_overlap) / math.log(law.largest[0] / law.yield_overlap)
    k = row_below(law.largest, 0, count, largest)
    return k, math.log(largest / law.largest[k]) / math.log(law.largest[k + 1] / law.largest[k])


@kernel
def plastic_part(law, largest):  # type: ignore[no-untyped-def]
    """phi, Eq. 4 with the published gamma_5."""
    return 1.0 - law.yield_overlap / (GAMMA_5 * largest + (1.0 - GAMMA_5) * law.yield_overlap)


@kernel
def recovered_overlap(law, largest):  # type: ignore[no-untyped-def]
    """d_max - d_0 in m."""
    k, share = stored_before(law, largest)
    last = law.largest.size - 1
    if k == last:
        top = law.largest[last]
        return tabulated_loading(law, largest) / tabulated_loading(law, top) / (1.0 / top + law.stiffening[last])
    if k < 0:
        onset = plastic_part(law, largest) / plastic_part(law, law.largest[0])
        return 1.0 / (1.0 / largest + law.stiffening[0] * onset * math.sqrt(law.largest[0] / largest))
    return 1.0 / (1.0 / largest + law.stiffening[k] ** (1.0 - share) * law.stiffening[k + 1] ** share)


@kernel
def stored_shape(law, k, left):  # type: ignore[no-untyped-def]
    """Force over the force at the start of unloading k at s = `left`."""
    if k < 0:
        return tabulated_loading(law, left * law.yield_overlap) / tabulated_loading(law, law.yield_overlap)
    row = row_below(law.unload_left, int(law.start[k]), int(law.start[k + 1]), left)
    return cubic(law.unload_left, law.unload_force, law.unload_slope, row, left)


@kernel
def stored_shape_work(law, k, left):  # type: ignore[no-untyped-def]
    """Integral of `shape` over s from 0 to `left`."""
    if k < 0:
        return tabulated_work(law, left * law.yield_overlap) / (tabulated_loading(law, law.yield_overlap) * law.yield_overlap)
    row = row_below(law.unload_left, int(law.start[k]), int(law.start[k + 1]), left)
    return law.unload_work[row] + cubic_integral(law.unload_left, law.unload_force, law.unload_slope, row, left)


@kernel
def stored_shape_area(law, k, left):  # type: ignore[no-untyped-def]
    """Contact area over the area at the start of unloading k."""
    if k < 0:
        return tabulated_area(law, left * law.yield_overlap) / tabulated_area(law, law.yield_overlap)
    row = row_below(law.unload_left, int(law.start[k]), int(law.start[k + 1]), left)
    return cubic(law.unload_left, law.unload_area, law.unload_area_slope, row, left)


@kernel
def shape(law, largest, left):  # type: ignore[no-untyped-def]
    """Force over the force at the start of the unloading from `largest`, mixed from its two stored neighbours."""
    k, share = stored_before(law, largest)
    value = stored_shape(law, k, left)
    if share > 0.0:
        value += share * (stored_shape(law, k + 1, left) - value)
    return value


@kernel
def shape_work(law, largest, left):  # type: ignore[no-untyped-def]
    """Integral of `shape` over s from 0 to `left`, mixed from its two stored neighbours."""
    k, share = stored_before(law, largest)
    value = stored_shape_work(law, k, left)
    if share > 0.0:
        value += share * (stored_shape_work(law, k + 1, left) - value)
    return value


@kernel
def shape_area(law, largest, left):  # type: ignore[no-untyped-def]
    """Contact area over the area at the start of the unloading, mixed from its two stored neighbours."""
    k, share = stored_before(law, largest)
    value = stored_shape_area(law, k, left)
    if share > 0.0:
        value += share * (stored_shape_area(law, k + 1, left) - value)
    return value


@kernel
def tabulated_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """The tables; the memory is the largest overlap."""
    if overlap <= 0.0:
        return 0.0, (0.0,)
    largest = max(overlap, state[0])
    if overlap >= largest or law.largest.size == 0 or largest <= law.yield_overlap:
        return tabulated_loading(law, overlap), (largest,)
    left = 1.0 - (largest - overlap) / recovered_overlap(law, largest)
    if left <= 0.0:
        return 0.0, (largest,)
    return tabulated_loading(law, largest) * shape(law, largest, left), (largest,)


@kernel
def tabulated_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """Square root of the tabulated area."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    if overlap >= largest or law.largest.size == 0 or largest <= law.yield_overlap:
        return math.sqrt(max(0.0, tabulated_area(law, overlap)))
    if law.area.size == 0 or law.unload_area.size == 0:
        return math.nan
    left = 1.0 - (largest - overlap) / recovered_overlap(law, largest)
    if left <= 0.0:
        return 0.0
    return math.sqrt(max(0.0, tabulated_area(law, largest) * shape_area(law, largest, left)))


@kernel
def tabulated_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: integral of the unloading below `overlap`; dissipated: work of the loading less the integral of the whole unloading."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    if law.largest.size == 0 or largest <= law.yield_overlap:
        return tabulated_work(law, max(overlap, 0.0)), 0.0
    recovered = recovered_overlap(law, largest)
    scale = tabulated_loading(law, largest) * recovered
    left = max(0.0, 1.0 - (largest - overlap) / recovered)
    stored = scale * shape_work(law, largest, left) if left > 0.0 else 0.0
    return stored, tabulated_work(law, largest) - scale * shape_work(law, largest, 1.0)


@kernel
def steepest_loading(law, overlap):  # type: ignore[no-untyped-def]
    """Largest slope of the loading up to the first row from `overlap`."""
    found = law.slope[0]
    for i in range(law.overlap.size - 1):
        if law.overlap[i] < overlap:
            found = max(found, steepest(law.overlap, law.force, law.slope, i))
    return found


@kernel
def steepest_unloading(law, k):  # type: ignore[no-untyped-def]
    """Largest slope of the stored shape k; of the elastic one, with as much as the steepest loading up to first yield."""
    if k >= 0:
        return law.unload_steepest[k]
    return steepest_loading(law, law.yield_overlap) * law.yield_overlap / tabulated_loading(law, law.yield_overlap)


@kernel
def unloading_slope(law, largest):  # type: ignore[no-untyped-def]
    """No unloading from `largest` is steeper than this over the force at its start, per m: slopes mix like the shapes."""
    k, share = stored_before(law, largest)
    slope = steepest_unloading(law, k)
    if share > 0.0:
        slope = max(slope, steepest_unloading(law, k + 1))
    return slope / recovered_overlap(law, largest)


@kernel
def tabulated_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Between two rows of the loading the largest force and the steepest unloading are at either end, so their product is a bound."""
    if overlap <= 0.0:
        return 0.0
    found = steepest_loading(law, overlap)
    if law.largest.size == 0 or overlap <= law.yield_overlap:
        return found
    before = law.yield_overlap
    for i in range(law.overlap.size + 1):
        after = min(overlap, law.overlap[i]) if i < law.overlap.size else overlap
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
    )
)
