"""What the shape of a body changes in the whole-range law of the sphere. Nothing of it is left of a sphere, nor of a small contact.

A body meets the flat with the radius of curvature R = 1/(2 sqrt(A B)) and the ratio of curvatures B/A; its mean radius is r. Its shape is
s = 3/4 ln(R/r), which of a spheroid a : b : b pressed along a is ln(b/a). How far it is pressed is t = sqrt(overlap/r), of a sphere the
root of its depth. When the body as a whole gives way depends on the contact over its height, u = t R/r: the sphere's law, which changes
from indentation to upsetting with its depth, is asked for that at the root m of the depth, t + (u - t)/(1 + (u/u_s)^3), between the two.
The corrections are polynomials in m (elastic ones: t) and s that begin with m s.

The elliptical contact is Hertz's, with f1 and f2 of `contactlaws.contact_ellipse`: its mean radius, force and pressure are those of a
circular one with the radius R f1^2/f2 and the modulus E*/(f1 f2). Beyond yield it is still taken for that one, so area and plastic limit go
with f1^2/f2.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import inlined, kernel
from contactlaws.contact_ellipse import fast_mean_factors
from contactlaws.whole_range_loading import INDENTATION, area_beyond_yield, limit_parts, part_of_elastic
from contactlaws.whole_range_unloading import recovered_beyond_yield, retreat, shape_of_terms

FloatArray = npt.NDArray[np.float64]

#: shapes of the curves that the constants were fitted to; a body beyond is taken for the nearest shape with the same curvature
BLUNTEST = 2.0 ** (4.0 / 3.0)  # R/r of 1 : 2 : 2; its inverse is that of 1 : .5 : .5
#: of each correction how many powers of m (elastic ones: the powers 1, 2, 6 of t), of s, and of phi
EXTENTS = {
    "FORCE": (3, 4), "AREA": (3, 4), "YIELD": (3, 4), "LIMIT": (5, 4), "BEND": (3, 3), "LAG": (3, 3), "ONSET": (3, 3),
    "SPREAD": (3, 3, 2), "RESIDUAL": (4, 4, 4), "ROUND": (3, 3, 3), "SATURATION": (1,),
}  # fmt: skip
_STARTS = itertools.accumulate(map(math.prod, EXTENTS.values()), initial=0)
#: where each stands in the array of constants, followed by its extent
FORCE, AREA, YIELD, LIMIT, BEND, LAG, ONSET, SPREAD, RESIDUAL, ROUND, SATURATION = (
    (start, *extent) for start, extent in zip(_STARTS, EXTENTS.values(), strict=False)
)


def constants_of(tables: Mapping[str, FloatArray], nu: float) -> FloatArray:
    """The constants of one material, of Poisson's ratio `nu`: what all functions below take as c, shape (constants,); they have no units.

    `tables` has a polynomial in nu for each of them, under the names of `EXTENTS`: shape (*extent, powers of nu from 0 on).
    """
    return np.concatenate([(tables[name] @ nu ** np.arange(tables[name].shape[-1])).ravel() for name in EXTENTS])


@inlined
def local_geometry(shape):  # type: ignore[no-untyped-def]
    """R (m), R/r, s, f1, f2 of a shape: R, B/A, r (m). A body beyond the flattest is given the mean radius of that."""
    radius, ratio, mean_radius = shape
    blunt = min(max(radius / mean_radius, 1.0 / BLUNTEST), BLUNTEST)
    f1, f2 = fast_mean_factors(ratio)
    return radius, blunt, 0.75 * math.log(blunt), f1, f2


@inlined
def circle(local):  # type: ignore[no-untyped-def]
    """Radius of the circular contact with the same mean radius, force and pressure, over R."""
    return local[3] * local[3] / local[4]


@inlined
def series(c, where, m, s):  # type: ignore[no-untyped-def]
    """Sum of c[j, k] m^(j + 1) s^(k + 1) of the correction that stands at `where`."""
    at, most_m, most_s = where
    total = 0.0
    for j in range(most_m - 1, -1, -1):
        part = 0.0
        for k in range(most_s - 1, -1, -1):
            part = (part + c[at + j * most_s + k]) * s
        total = (total + part) * m
    return total


@inlined
def series_of_phi(c, where, m, s, phi):  # type: ignore[no-untyped-def]
    """Sum of c[j, k, l] m^(j + 1) s^(k + 1) phi^l of the correction that stands at `where`."""
    at, most_m, most_s, most_phi = where
    total = 0.0
    for j in range(most_m - 1, -1, -1):
        part = 0.0
        for k in range(most_s - 1, -1, -1):
            of_phi = 0.0
            for n in range(most_phi - 1, -1, -1):
                of_phi = of_phi * phi + c[at + (j * most_s + k) * most_phi + n]
            part = (part + of_phi) * s
        total = (total + part) * m
    return total


@inlined
def elastic_terms_of(c, where, one, two, three, t, s):  # type: ignore[no-untyped-def]
    """Terms in t, t^2 and t^6 of an elastic factor, from the sphere's."""
    at = where[0]
    add_1, add_2, add_3 = 0.0, 0.0, 0.0
    for k in range(3, -1, -1):
        add_1, add_2, add_3 = (add_1 + c[at + k]) * s, (add_2 + c[at + 4 + k]) * s, (add_3 + c[at + 8 + k]) * s
    one, two, three = one + add_1, two + add_2, three + add_3
    square = t * t
    return one * t, two * square, three * square * square * square


@inlined
def force_terms(law, c, local, t):  # type: ignore[no-untyped-def]
    """Those of the elastic force over Hertz's."""
    return elastic_terms_of(c, FORCE, law.force_1, law.force_2, law.force_3, t, local[2])


@inlined
def hertz_load(law, local, depth):  # type: ignore[no-untyped-def]
    """F/(pi R^2 Y) of Hertz."""
    root = depth / local[4]
    return law.stiffness * root * math.sqrt(root)


@kernel
def shaped_elastic_load(law, c, local, depth):  # type: ignore[no-untyped-def]
    """F/(pi R^2 Y) of a body that never yields; `depth` is the overlap over R, `law` the sphere's record."""
    one, two, three = force_terms(law, c, local, math.sqrt(depth * local[1]))
    return hertz_load(law, local, depth) * (1.0 + one + two + three)


@kernel
def shaped_elastic_work(law, c, local, depth):  # type: ignore[no-untyped-def]
    """Its integral over the depth."""
    one, two, three = force_terms(law, c, local, math.sqrt(depth * local[1]))
    return hertz_load(law, local, depth) * depth * (0.4 + one / 3.0 + two / 3.5 + three / 5.5)


@kernel
def shaped_elastic_area(law, c, local, depth):  # type: ignore[no-untyped-def]
    """Product of the half axes over R^2."""
    t = math.sqrt(depth * local[1])
    one, two, three = elastic_terms_of(c, AREA, law.area_1, law.area_2, law.area_3, t, local[2])
    return depth * circle(local) * max(0.0, 1.0 + one + two + three)


@inlined
def shaped_yield_load(law, c, local):  # type: ignore[no-untyped-def]
    """Elastic force over the plastic limit at first yield."""
    t = math.sqrt(law.yield_depth * local[1])
    return law.yield_load * math.exp(series(c, YIELD, min(t, 0.5), local[2]))


@inlined
def root_of_size(c, local, t):  # type: ignore[no-untyped-def]
    """m."""
    u = t * local[1]
    x = u / c[SATURATION[0]]
    return t + (u - t) / (1.0 + x * x * x)


@inlined
def shaped_limit(law, c, local, depth, m):  # type: ignore[no-untyped-def]
    """Plastic limit of the force."""
    size = m * m
    over, under = limit_parts(law, size, m)
    return INDENTATION * depth * circle(local) * over * math.exp(series(c, LIMIT, m, local[2])) / ((1.0 - size) * under)


@kernel
def shaped_yield_gap(law, c, local, depth):  # type: ignore[no-untyped-def]
    """Logarithm of the elastic force over that at first yield; 0 where the body yields."""
    m = root_of_size(c, local, math.sqrt(depth * local[1]))
    return math.log(shaped_elastic_load(law, c, local, depth) / shaped_limit(law, c, local, depth, m) / shaped_yield_load(law, c, local))


@kernel
def shaped_loading(law, c, local, depth):  # type: ignore[no-untyped-def]
    """F/(pi R^2 Y), and what is left of the elastic force, phi; on the loading branch."""
    t = math.sqrt(depth * local[1])
    one, two, three = force_terms(law, c, local, t)
    elastic = hertz_load(law, local, depth) * (1.0 + one + two + three)
    m = root_of_size(c, local, t)
    size, s = m * m, local[2]
    limit = shaped_limit(law, c, local, depth, m)
    z = elastic / limit - shaped_yield_load(law, c, local)
    if z <= 0.0:
        return elastic, 1.0
    lag, bend = series(c, LAG, m, s), series(c, BEND, m, s)
    part, whole = part_of_elastic(law, size, m, z, bend, lag, math.exp(series(c, ONSET, m, s)))
    return elastic * part / whole, part / whole


@kernel
def shaped_area(law, c, local, depth, phi):  # type: ignore[no-untyped-def]
    """Product of the half axes over R^2 on the loading branch."""
    elastic = shaped_elastic_area(law, c, local, depth)
    if phi >= 1.0:
        return elastic
    m = root_of_size(c, local, math.sqrt(depth * local[1]))
    beyond = math.exp((1.0 - phi) * series_of_phi(c, SPREAD, m, local[2], phi))
    return area_beyond_yield(law, depth, m * m, phi, elastic / circle(local)) * circle(local) * beyond


@kernel
def shaped_recovered(law, c, local, depth, load, phi, area):  # type: ignore[no-untyped-def]
    """The overlap over R that unloading from `depth` gives back: the sphere's residual over recovered overlap, times a factor."""
    if phi >= 1.0:
        return depth
    m = root_of_size(c, local, math.sqrt(depth * local[1]))
    height = 1.0 - depth * math.exp(2.0 * local[2])  # a spheroid's half height is R exp(-2 s)
    circular = recovered_beyond_yield(law, depth, height, m * m, load, phi, area / (local[3] * local[4]) ** 2)
    residual = (depth - circular) / circular * math.exp(series_of_phi(c, RESIDUAL, m, local[2], phi))
    return depth / (1.0 + residual)


@kernel
def shaped_terms(law, c, local, depth, phi):  # type: ignore[no-untyped-def]
    """Terms of the shape of the unloading, see `contactlaws.whole_range_unloading`."""
    t = math.sqrt(depth * local[1])
    m = root_of_size(c, local, t)
    elastic, one, two, three, power, slope = shape_of_terms(law, m * m, phi, force_terms(law, c, local, t))
    if phi < 1.0:
        power = max(1.0, power + (1.0 - phi) * series_of_phi(c, ROUND, m, local[2], phi))
    return elastic, one, two, three, power, slope


@kernel
def shaped_area_left(law, c, local, depth, load, phi, area, recovered, terms, s):  # type: ignore[no-untyped-def]
    """Area over that at `depth` while a share s of the recovery is left, see `contactlaws.whole_range_unloading.retreat`."""
    stiffness, elastic = 1.5 * law.stiffness / (local[3] * local[4]), shaped_elastic_area(law, c, local, depth)
    begun, elastic_begun = (recovered, load, area), (depth, shaped_elastic_load(law, c, local, depth), elastic)
    return retreat(terms, phi, stiffness, begun, elastic_begun, shaped_elastic_area(law, c, local, depth * s) / elastic, s)
