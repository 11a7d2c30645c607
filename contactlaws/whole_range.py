"""One contact law for the elastic-perfectly plastic sphere over the whole range, from first touch to overlaps of half the radius and more.

Loading, contact radius, unloading and energy of any material from its modulus, Poisson's ratio and yield stress; formulas in
`whole_range_loading` and `whole_range_unloading`, global constants fitted to finite-element curves in `whole_range_constants`.

The memory of a contact is its largest overlap and, once it has unloaded, the force there and the overlap it recovers: so a loading step
computes the force alone, and of many unloading steps only the first computes the recovery.
"""

from __future__ import annotations

import math
from typing import Any

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.errors import Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.whole_range_constants import WHOLE
from contactlaws.whole_range_loading import (
    elastic_area,
    elastic_load,
    elastic_slope,
    elastic_work,
    loading,
    loading_area,
    loading_load,
    loading_work,
    plastic_limit,
)
from contactlaws.whole_range_record import Constants, WholeRange, coefficients
from contactlaws.whole_range_unloading import recovered_depth, retreat, shape, shape_slope, shape_terms, shape_work

#: the law is defined below this overlap over the radius; a body pressed further keeps this depth's formulas (they diverge at 1)
DEEPEST = 0.95


def whole_range(material: Material, radius: float) -> WholeRange:
    """The law of one body of `material` (with a yield stress) and `radius` (m). Raises `InputError` for one that is not plastic.

    >>> law = whole_range(Material(142e9, 0.25, 7.9e9), 5e-6)
    >>> 0.0 < law.yield_depth < 0.02
    True
    """
    return WholeRange(*_values(WHOLE, material, radius))


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
def whole_range_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading branch, or unloading from the largest overlap."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    depth = min(overlap / law.radius, DEEPEST)
    if overlap >= state[0]:
        return law.force_unit * loading_load(law, depth), (overlap, 0.0, 0.0)
    largest = min(state[0] / law.radius, DEEPEST)
    if largest <= law.yield_depth:
        return law.force_unit * elastic_load(law, depth), (state[0], 0.0, 0.0)
    if state[2] == 0.0:
        load, phi, upset = loading(law, largest)
        recovered = recovered_depth(law, largest, load, phi, upset, loading_area(law, largest, phi, upset))
    else:
        load, recovered = state[1], state[2]
        phi, upset = load / elastic_load(law, largest), plastic_limit(law, largest)[1]
    s = 1.0 - (largest - depth) / recovered
    after = (state[0], load, recovered)
    if s <= 0.0:
        return 0.0, after
    return law.force_unit * load * shape(shape_terms(law, largest, phi, upset), s), after


@kernel
def unloading(law, depth):  # type: ignore[no-untyped-def]
    """All that unloading from `depth` needs: f, phi, the area, the recovery, the terms of the shape."""
    load, phi, upset = loading(law, depth)
    area = loading_area(law, depth, phi, upset)
    recovered = recovered_depth(law, depth, load, phi, upset, area)
    return load, phi, area, recovered, shape_terms(law, depth, phi, upset)


@kernel
def whole_range_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """See the module; elastic up to first yield."""
    if overlap <= 0.0:
        return 0.0
    depth, largest = min(overlap / law.radius, DEEPEST), min(max(overlap, state[0]) / law.radius, DEEPEST)
    if largest <= law.yield_depth:
        return law.radius * math.sqrt(elastic_area(law, depth))
    _, phi, area, recovered, _ = unloading(law, largest)
    s = max(0.0, 1.0 - (largest - depth) / recovered)
    return law.radius * math.sqrt(area * retreat(law, largest, phi, s))


@kernel
def whole_range_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: what unloading gives back. Dissipated: work of the loading less all that can be got back."""
    largest = min(max(overlap, state[0]) / law.radius, DEEPEST)
    if largest <= 0.0:
        return 0.0, 0.0
    unit = law.force_unit * law.radius
    depth = min(max(overlap, 0.0) / law.radius, DEEPEST)
    if largest <= law.yield_depth:
        return unit * elastic_work(law, depth), 0.0
    load, _, _, recovered, terms = unloading(law, largest)
    s = max(0.0, 1.0 - (largest - depth) / recovered)
    recoverable = load * recovered * shape_work(terms, 1.0)
    return unit * load * recovered * shape_work(terms, s), unit * (loading_work(law, largest) - recoverable)


@kernel
def whole_range_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The steepest of loading and start of unloading, in 64 steps of the largest overlap from first yield to `overlap`.

    Loading, f = f_el phi: over one step no steeper than the largest f_el' times the largest phi, and what a growing phi adds. Unloading is
    steepest where it starts or ends; the 64 steps find the maximum over the largest overlap within a part in a hundred, which is added.
    """
    top = min(max(overlap, 0.0) / law.radius, DEEPEST)
    limit = law.yield_depth
    largest = 0.0
    for i in range(1, 34):
        largest = max(largest, elastic_slope(law, min(top, limit) * i / 33.0))
    if top > limit:
        before, share, stiffness = limit, 1.0, elastic_slope(law, limit)
        for i in range(1, 65):
            depth = limit * (top / limit) ** (i / 64.0)
            load, phi, _, recovered, terms = unloading(law, depth)
            slope = elastic_slope(law, depth)
            growth = max(0.0, phi - share) / (depth - before) * elastic_load(law, depth)
            largest = max(largest, max(stiffness, slope) * max(share, phi) + growth)
            for s in (0.0, 0.25, 0.5, 0.75, 1.0):
                largest = max(largest, 1.01 * load / recovered * shape_slope(terms, s))
            before, share, stiffness = depth, phi, slope
    return law.force_unit / law.radius * largest


def _problems(law: Any) -> list[Problem]:
    names = ("youngs_modulus", "yield_stress", "force_unit", "stiffness", "yield_depth", "yield_load", "compliance", "punch")
    return [
        Problem(name, getattr(law, name), "must be positive and finite", "make the record from its material")
        for name in names
        if not (math.isfinite(getattr(law, name)) and getattr(law, name) > 0.0)
    ]


_FUNCTIONS = (whole_range_force, whole_range_contact_radius, whole_range_energy, whole_range_stiffness_bound)
_MEMORY = ("largest_overlap", "largest_load", "recovered_depth")
_SOURCE = "fitted to this project's finite-element curves; limits of Hertz 1882 and of Mesarovic & Johnson 2000"
register(Law("whole_range", WholeRange, *_FUNCTIONS, _MEMORY, _SOURCE, _problems))
