"""One contact law for the elastic-perfectly plastic sphere over the whole range, from first touch to overlaps of half the radius and more.

Loading, contact radius, unloading and energy of any material from its modulus, Poisson's ratio and yield stress; formulas in
`whole_range_loading` and `whole_range_unloading`, global constants fitted to finite-element curves in `whole_range_constants`.

The memory of a contact is its largest overlap and, once it has unloaded, the force there, the overlap it recovers and the shape of the
branch: so a loading step computes the force alone, and of many unloading steps only the first computes the recovery and the shape, whose
powers cost more than all the rest.
"""

from __future__ import annotations

import math
from typing import Any

from contactlaws.compiled import inlined, kernel
from contactlaws.dispatch import Law, register
from contactlaws.errors import Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.whole_range_constants import COMPACT, WHOLE
from contactlaws.whole_range_loading import (
    elastic_area,
    elastic_load,
    elastic_slope,
    elastic_work,
    loading,
    loading_area,
    loading_load,
    loading_work,
)
from contactlaws.whole_range_record import Constants, WholeRange, WholeRangeCompact, coefficients
from contactlaws.whole_range_unloading import area_left, elastic_terms, recovered_depth, shape, shape_slope, shape_terms, shape_work

#: overlap over the radius up to which the formulas are held against curves and guarded in the fit
DEEPEST = 0.6
#: a body pressed to more than this overlap over the radius is kept there: at 1 nothing of it is left
END = 0.99


def whole_range(material: Material, radius: float) -> WholeRange:
    """The law of one body of `material` (with a yield stress) and `radius` (m). Raises `InputError` for one that is not plastic.

    >>> law = whole_range(Material(142e9, 0.25, 7.9e9), 5e-6)
    >>> 0.0 < law.yield_depth < 0.02
    True
    """
    return WholeRange(*_values(WHOLE, material, radius))


def whole_range_compact(material: Material, radius: float) -> WholeRangeCompact:
    """`whole_range` made from 20 constants, for loading and unloading stiffness: the same formulas, less accurate."""
    return WholeRangeCompact(*_values(COMPACT, material, radius))


def _values(constants: dict[str, float], material: Material, radius: float) -> tuple[float, ...]:
    problems = list(problems_with(material))
    if material.yield_stress is None:
        problems.append(Problem("yield_stress", None, "this law is of bodies that yield", "give it, or use 'hertz_finite_size'"))
    if not (math.isfinite(radius) and radius > 0.0):
        problems.append(Problem("radius", radius, "must be positive", "give it in m"))
    require(problems)
    assert material.yield_stress is not None
    record = Constants(**constants)
    return tuple(
        coefficients(record, float(radius), float(material.youngs_modulus), float(material.poissons_ratio), float(material.yield_stress))
    )


@kernel
def stretch(depth):  # type: ignore[no-untyped-def]
    """Beyond `DEEPEST` force and area grow as those of a bar of constant volume, by this factor; the recovery falls by it."""
    return (1.0 - DEEPEST) / (1.0 - depth) if depth > DEEPEST else 1.0


@kernel
def unloading(law, depth):  # type: ignore[no-untyped-def]
    """All that unloading from `depth` needs: f, phi, the area, the recovery, the terms of the shape."""
    at, factor = min(depth, DEEPEST), stretch(depth)
    load, phi = loading(law, at)
    area = loading_area(law, at, phi)
    recovered = recovered_depth(law, at, load, phi, area)
    return load * factor, phi, area * factor, recovered / factor, shape_terms(law, at, phi)


@inlined
def whole_range_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading branch, or unloading from the largest overlap."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    depth = overlap / law.radius
    if overlap >= state[0]:
        return law.force_unit * any_load(law, depth), (overlap, 0.0, 0.0, 0.0, 0.0, 0.0)
    largest = min(state[0] / law.radius, END)
    if largest <= law.yield_depth:
        return law.force_unit * elastic_load(law, depth), (state[0], 0.0, 0.0, 0.0, 0.0, 0.0)
    after = state
    if state[2] == 0.0:
        load, _, _, recovered, terms = unloading(law, largest)
        after = (state[0], load, recovered, terms[0], terms[4], terms[5])
    s = 1.0 - (largest - depth) / after[2]
    if s > 1.0:  # round-off; an overlap that is not a number stays one
        s = 1.0
    if s <= 0.0:
        return 0.0, after
    at = min(largest, DEEPEST)
    one, two, three = elastic_terms(law, at)
    return law.force_unit * after[1] * shape((after[3], one, two, three, after[4], after[5]), s), after


@inlined
def any_load(law, depth):  # type: ignore[no-untyped-def]
    """f on the loading branch, at any depth."""
    if depth <= DEEPEST:
        return loading_load(law, depth)
    return loading_load(law, DEEPEST) * stretch(min(depth, END))


@kernel
def whole_range_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """See the module; elastic up to first yield."""
    if overlap <= 0.0:
        return 0.0
    depth, largest = min(overlap / law.radius, END), min(max(overlap, state[0]) / law.radius, END)
    if largest <= law.yield_depth:
        return law.radius * math.sqrt(elastic_area(law, depth))
    load, phi, area, recovered, terms = unloading(law, largest)
    s = max(0.0, 1.0 - (largest - depth) / recovered)
    return law.radius * math.sqrt(area * area_left(law, min(largest, DEEPEST), load, phi, area, recovered, terms, s))


@kernel
def whole_range_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: what unloading gives back. Dissipated: work of the loading less all that can be got back."""
    reached = max(overlap, state[0]) / law.radius
    if reached <= 0.0:
        return 0.0, 0.0
    unit, largest, depth = law.force_unit * law.radius, min(reached, END), max(overlap / law.radius, 0.0)
    if largest <= law.yield_depth:
        return unit * elastic_work(law, depth), 0.0
    load, _, _, recovered, terms = unloading(law, largest)
    s = max(0.0, 1.0 - (largest - min(depth, END)) / recovered)
    work = loading_work(law, min(largest, DEEPEST))
    if largest > DEEPEST:
        work += loading_load(law, DEEPEST) * (1.0 - DEEPEST) * math.log((1.0 - DEEPEST) / (1.0 - largest))
    lost = work - load * recovered * shape_work(terms, 1.0)
    # beyond the end the force stays, and is got back
    return unit * load * (recovered * shape_work(terms, s) + max(0.0, depth - END)), unit * lost


@kernel
def whole_range_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The steepest of loading and start of unloading, in 64 steps of the largest overlap from first yield to `overlap`.

    Loading, f = f_el phi: over one step no steeper than the largest f_el' times the largest phi, and what a growing phi adds. Unloading is
    steepest where it starts or ends; the 64 steps find the maximum over the largest overlap within a part in a hundred, which is added.
    """
    top = min(max(overlap, 0.0) / law.radius, END)
    limit = law.yield_depth
    largest = 0.0
    for i in range(1, 34):
        largest = max(largest, elastic_slope(law, min(top, limit) * i / 33.0))
    if top > limit:
        before, share, stiffness = limit, 1.0, elastic_slope(law, limit)
        for i in range(1, 65):
            depth = limit * (top / limit) ** (i / 64.0)
            at, factor = min(depth, DEEPEST), stretch(depth)
            load, phi, _, recovered, terms = unloading(law, depth)
            slope = elastic_slope(law, at)
            growth = max(0.0, phi - share) / (depth - before) * elastic_load(law, at)
            largest = max(largest, factor * (max(stiffness, slope) * max(share, phi) + growth) + load / (1.0 - depth) * (factor > 1.0))
            for s in (0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0):
                largest = max(largest, 1.01 * load / recovered * shape_slope(terms, s))
            before, share, stiffness = depth, phi, slope
    return law.force_unit / law.radius * largest


def _problems(law: Any) -> list[Problem]:
    names = ("youngs_modulus", "yield_stress", "force_unit", "stiffness", "yield_depth", "yield_load", "compliance")
    return [
        Problem(name, getattr(law, name), "must be positive and finite", "make the record from its material")
        for name in names
        if not (math.isfinite(getattr(law, name)) and getattr(law, name) > 0.0)
    ]


_FUNCTIONS = (whole_range_force, whole_range_contact_radius, whole_range_energy, whole_range_stiffness_bound)
_MEMORY = ("largest_overlap", "largest_load", "recovered_depth", "elastic_share", "power", "power_slope")
_SOURCE = "fitted to this project's finite-element curves; limits of Hertz 1882 and of Mesarovic & Johnson 2000"
register(Law("whole_range", WholeRange, *_FUNCTIONS, _MEMORY, _SOURCE, _problems))
register(Law("whole_range_compact", WholeRangeCompact, *_FUNCTIONS, _MEMORY, _SOURCE, _problems))
