"""The whole-range law for ellipsoids: elastic-perfectly plastic bodies of any two curvatures, from first touch to .2 of the mean radius.

What it is for a sphere is `contactlaws.whole_range`, exactly; what the shape changes is in `contactlaws.whole_range_shape`. Fitted to
spheroids from 1 : .5 : .5 to 1 : 2 : 2; a body of three axes counts as the spheroid with its height, volume and effective radius, and its
elliptical contact as Hertz's. Beyond .2 of the mean radius force and area grow in proportion to the overlap.

The memory of a contact is its largest overlap and, once it has unloaded, the force there, the overlap over R that it recovers and the shape
of the branch: these follow from the largest overlap and the shape, and are computed once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import whole_range_shape_constants
from contactlaws.compiled import inlined, kernel
from contactlaws.errors import Problem
from contactlaws.material import Material
from contactlaws.shaped import ShapedLaw, register
from contactlaws.whole_range import whole_range
from contactlaws.whole_range_record import WholeRange
from contactlaws.whole_range_shape import (
    BLUNTEST,
    constants_of,
    force_terms,
    local_geometry,
    shaped_area,
    shaped_area_left,
    shaped_elastic_load,
    shaped_elastic_work,
    shaped_loading,
    shaped_recovered,
    shaped_terms,
)
from contactlaws.whole_range_unloading import shape as shape_of
from contactlaws.whole_range_unloading import shape_slope, shape_work

FloatArray = npt.NDArray[np.float64]

#: overlap over the mean radius to which the curves go that the constants were fitted to
FARTHEST = 0.2
#: overlaps at which the stiffness is looked at; between two of them it is larger by less than the margin
STEPS, MARGIN = 64, 1.02


class WholeRangeEllipsoid(NamedTuple):
    """One material; make it with `whole_range_ellipsoid`."""

    sphere: WholeRange  # of radius 1 m
    constants: FloatArray  # of the corrections, for this Poisson's ratio


def whole_range_ellipsoid(material: Material) -> WholeRangeEllipsoid:
    """The law of ellipsoids of `material` (with a yield stress), of any size. Of a pair of unlike bodies: that of `pair.effective`.

    Raises `InputError` for a material that is not plastic.

    >>> from contactlaws.whole_range import whole_range_force
    >>> law = whole_range_ellipsoid(Material(142e9, 0.25, 7.9e9))
    >>> sphere = whole_range(Material(142e9, 0.25, 7.9e9), 5e-6)
    >>> force, _ = whole_range_ellipsoid_force(law, (5e-6, 1.0, 5e-6), 0.5e-6, (0.0,) * 6)
    >>> bool(abs(force / whole_range_force(sphere, 0.5e-6, 0.0, 0.0, (0.0,) * 6)[0] - 1.0) < 1e-12)
    True
    """
    return WholeRangeEllipsoid(whole_range(material, 1.0), constants_of(vars(whole_range_shape_constants), material.poissons_ratio))


@inlined
def within(local, depth):  # type: ignore[no-untyped-def]
    """The depth that the formulas are asked for, and by what factor the real one is beyond."""
    end = FARTHEST / local[1]
    return (depth, 1.0) if depth <= end else (end, depth / end)


@kernel
def begun_unloading(law, local, largest):  # type: ignore[no-untyped-def]
    """All that unloading from the depth `largest` needs: force, phi, area, recovered depth, terms of the shape."""
    sphere, c = law.sphere, law.constants
    at, beyond = within(local, largest)
    load, phi = shaped_loading(sphere, c, local, at)
    area = shaped_area(sphere, c, local, at, phi)
    recovered = shaped_recovered(sphere, c, local, at, load, phi, area)
    terms = shaped_terms(sphere, c, local, at, phi)
    if phi >= 1.0:
        return load * beyond, phi, area * beyond, largest, terms
    return load * beyond, phi, area * beyond, min(largest, recovered * math.sqrt(beyond)), terms


@inlined
def elastic_force(law, local, depth):  # type: ignore[no-untyped-def]
    """F/(pi R^2 Y) of a contact that has never yielded."""
    at, beyond = within(local, depth)
    return shaped_elastic_load(law.sphere, law.constants, local, at) * beyond


@inlined
def whole_range_ellipsoid_force(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """Loading branch, or unloading from the largest overlap."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    local = local_geometry(shape)
    radius = local[0]
    unit, depth = math.pi * radius * radius * law.sphere.yield_stress, overlap / radius
    if overlap >= memory[0]:
        at, beyond = within(local, depth)
        load, _ = shaped_loading(law.sphere, law.constants, local, at)
        return unit * load * beyond, (overlap, 0.0, 0.0, 0.0, 0.0, 0.0)
    largest, after = memory[0] / radius, memory
    if memory[1] == 0.0:
        load, phi, _, recovered, terms = begun_unloading(law, local, largest)
        after = (memory[0], load, 0.0 if phi >= 1.0 else recovered, terms[0], terms[4], terms[5])
    if after[2] == 0.0:
        return unit * elastic_force(law, local, depth), after
    left = min(1.0, 1.0 - (largest - depth) / after[2])
    if left <= 0.0:
        return 0.0, after
    at, _ = within(local, largest)
    one, two, three = force_terms(law.sphere, law.constants, local, math.sqrt(at * local[1]))
    return unit * after[1] * shape_of((after[3], one, two, three, after[4], after[5]), left), after


@kernel
def whole_range_ellipsoid_contact_radius(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """Root of the product of the half axes."""
    if overlap <= 0.0:
        return 0.0
    local = local_geometry(shape)
    depth, largest = overlap / local[0], max(overlap, memory[0]) / local[0]
    load, phi, area, recovered, terms = begun_unloading(law, local, largest)
    left = max(0.0, 1.0 - (largest - depth) / recovered)
    at, _ = within(local, largest)
    return local[0] * math.sqrt(area * shaped_area_left(law.sphere, law.constants, local, at, load, phi, area, recovered, terms, left))


@kernel
def whole_range_ellipsoid_stored(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """What unloading gives back."""
    if overlap <= 0.0:
        return 0.0
    local = local_geometry(shape)
    radius = local[0]
    unit = math.pi * radius * radius * radius * law.sphere.yield_stress
    depth, largest = overlap / radius, max(overlap, memory[0]) / radius
    load, phi, _, recovered, terms = begun_unloading(law, local, largest)
    if phi < 1.0:
        return unit * load * recovered * shape_work(terms, max(0.0, 1.0 - (largest - depth) / recovered))
    at, beyond = within(local, depth)
    work = shaped_elastic_work(law.sphere, law.constants, local, at)
    return unit * (work + 0.5 * shaped_elastic_load(law.sphere, law.constants, local, at) * at * (beyond * beyond - 1.0))


@kernel
def whole_range_ellipsoid_stiffness_bound(law, shape, overlap):  # type: ignore[no-untyped-def]
    """The steepest of loading and unloading, in steps of the largest overlap up to `overlap`."""
    local, steepest = local_geometry(shape), 0.0
    top = max(overlap, 0.0) / local[0]
    for i in range(STEPS + 1):
        depth = top * 1e-4 ** (1.0 - i / STEPS)
        at, _ = within(local, depth)
        less = at * (1.0 - 1e-4)
        load, phi = shaped_loading(law.sphere, law.constants, local, at)
        steepest = max(steepest, (load - shaped_loading(law.sphere, law.constants, local, less)[0]) / (at - less), load / at)
        if phi < 1.0:
            load, phi, _, recovered, terms = begun_unloading(law, local, depth)
            for k in range(9):
                steepest = max(steepest, load / recovered * shape_slope(terms, k / 8.0))
    return MARGIN * steepest * math.pi * local[0] * law.sphere.yield_stress


def _problems(law: Any) -> Iterator[Problem]:
    if not np.isfinite(law.constants).all():
        yield Problem("constants", "not finite", "must be numbers", "make the record from its material")
    if not (math.isfinite(law.sphere.force_unit) and law.sphere.force_unit > 0.0):
        yield Problem("sphere", law.sphere.force_unit, "its force unit must be positive and finite", "make the record from its material")


register(
    ShapedLaw(
        "whole_range_ellipsoid",
        WholeRangeEllipsoid,
        whole_range_ellipsoid_force,
        whole_range_ellipsoid_contact_radius,
        whole_range_ellipsoid_stored,
        whole_range_ellipsoid_stiffness_bound,
        ("largest_overlap", "largest_load", "recovered_depth", "elastic_share", "power", "power_slope"),
        "fitted to this project's finite-element curves of spheroids; spheres: contactlaws.whole_range",
        _problems,
        (1.0 / BLUNTEST, BLUNTEST),
    )
)
