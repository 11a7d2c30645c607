"""MDR (Zunker & Kamrin 2024): a contact mapped to the indentation of an elastic half-space by a rigid ellipse, into large deformation.

The particle between two rigid flats, without adhesion, as in LAMMPS's `normal mdr`; h = R_0 - d the half height, R the apparent radius,
which grows so that plastic flow keeps the volume, D = d + R - R_0 the overlap of a sphere of that radius, G the shear and kappa the bulk
modulus.

    mean pressure on the contact at yield   p = Y (1 + 1.75 exp(-4.4 D/R))
    first yield                             where Hertz's mean pressure 4 E* sqrt(d/R_0)/(3 pi) reaches p
    contact radius                          a^2 = R_0 d before, a^2 = 2 D R - D^2 + d_Y (d_Y - R_0) beyond first yield
    ellipse of height A and width B         A = 4 R_0, B = 2 R_0 before; A = 4 p a/E*, B = 2 a beyond, with p and a at the largest overlap
    force                                   F = E* A B/4 [t - sin t cos t], cos t = 1 - 2 u/A, u the elastic part of the overlap
    before first yield                      u = d
    on the loading beyond                   u = A/2, so that F = pi a^2 p
    unloading                               u = (D - D_max + A/2 + C)/(1 + 2 C/A), z = R - D_max + A/2, r = sqrt(a^2 + z^2),
                                            C = F_max/(2 pi a^2 G r) [2 a^2 (nu - 1) + (1 - 2 nu) z (r - z)]
    apparent radius                         R^2 h - h^3/3 = V/(2 pi), the volume between the flats, V = V_g + V_0 (e - e_g)
                                            with the elastic volume strain e (1 + e) = -2 F h/(3 kappa V_0);
                                            it grows from the overlap g on, where this first asks for it

The published scheme makes R grow by increments; summed up over small steps they are the equation for V above, which makes the force a
function of overlap and largest overlap alone. The confined ("bulk") part of MDR waits until less than half of the surface is free, which
two flats do not reach up to an overlap of 0.5 R_0. At first yield the force jumps from the ellipse's to Hertz's (by 3 d_Y/(40 R_0)) and the
recovered overlap from d_Y to less: both kept as published.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from contactlaws.compiled import kernel
from contactlaws.dispatch import Law, register
from contactlaws.errors import Problem
from contactlaws.rivals.unloading import MARGIN, POINTS, SAMPLES, WEIGHTS

PRESSURE, DECAY = 1.75, 4.4
#: overlap over radius to which the implementation in LAMMPS lets the two sides of a contact go
LAST = 0.75
_PANELS = 8


class Mdr(NamedTuple):
    """One body of a given material, made by `mdr_of`, which finds the last three fields."""

    radius: float  # m; R_0
    youngs_modulus: float  # Pa
    poissons_ratio: float  # -
    yield_stress: float  # Pa
    yield_overlap: float  # m; d_Y, or the radius for a body that never yields
    growth_overlap: float  # m; g, from which the apparent radius grows
    plastic_volume: float  # m3; V_g - V_0 e_g


def mdr_of(radius: float, youngs_modulus: float, poissons_ratio: float, yield_stress: float) -> Mdr:
    """The record of a material.

    >>> law = mdr_of(1.0, 100.0, 0.3, 1.0)
    >>> round(law.yield_overlap, 5)
    0.00341
    """

    def beyond(depth: float) -> float:
        hertz = 4.0 * youngs_modulus / (1.0 - poissons_ratio**2) * math.sqrt(depth) / (3.0 * math.pi)
        return hertz - yield_stress * (1.0 + PRESSURE * math.exp(-DECAY * depth))

    never = Mdr(radius, youngs_modulus, poissons_ratio, yield_stress, radius, radius, 0.0)
    if not beyond(1.0) > 0.0:
        return never
    depth = _root(beyond, 1e-15, 1.0, 1e-15)
    return _with_growth(never._replace(yield_overlap=depth * radius))


def _root(function: Callable[[float], float], low: float, high: float, accuracy: float) -> float:
    """Where `function` changes its sign between `low` and `high`."""
    from scipy.optimize import brentq  # takes as long to load as all laws together

    return float(brentq(function, low, high, xtol=accuracy, rtol=1e-13))


def _with_growth(law: Mdr) -> Mdr:
    """The record with the overlap from which its apparent radius grows: more volume is lost under the flats than elasticity takes up."""
    radius = law.radius
    unit = 4.0 / 3.0 * math.pi * radius**3
    lost = lambda d: 2.0 * math.pi * (2.0 * d * radius - d * d) + unit * _strain_slope(law, d)  # noqa: E731
    if lost(law.yield_overlap) >= 0.0:
        start = law.yield_overlap
    elif lost(0.999 * radius) <= 0.0:
        return law
    else:
        start = _root(lost, law.yield_overlap, 0.999 * radius, 1e-14 * radius)
    height = radius - start
    volume = 2.0 * math.pi * (radius**2 * height - height**3 / 3.0) - unit * float(mdr_volume_strain(law, start, radius))
    return law._replace(growth_overlap=start, plastic_volume=volume)


def _strain_slope(law: Mdr, overlap: float) -> float:
    """Derivative of the elastic volume strain by the overlap in 1/m while the apparent radius is still R_0, by central differences."""
    step = 1e-5 * overlap
    strains = [float(mdr_volume_strain(law, overlap + side, law.radius)) for side in (-step, step)]
    return (strains[1] - strains[0]) / (2.0 * step)


@kernel
def mdr_reduced_modulus(law):  # type: ignore[no-untyped-def]
    """E* in Pa."""
    return law.youngs_modulus / (1.0 - law.poissons_ratio * law.poissons_ratio)


@kernel
def mdr_pressure(law, deep, grown):  # type: ignore[no-untyped-def]
    """p in Pa at the overlap D = `deep` of a sphere of apparent radius `grown`."""
    return law.yield_stress * (1.0 + PRESSURE * math.exp(-DECAY * deep / grown))


@kernel
def mdr_area(law, deep, grown):  # type: ignore[no-untyped-def]
    """a^2 in m2 on the plastic loading."""
    return deep * (2.0 * grown - deep) + law.yield_overlap * (law.yield_overlap - law.radius)


@kernel
def mdr_volume_strain(law, overlap, grown):  # type: ignore[no-untyped-def]
    """e on the plastic loading."""
    deep = overlap + grown - law.radius
    force = math.pi * mdr_area(law, deep, grown) * mdr_pressure(law, deep, grown)
    bulk = law.youngs_modulus / (3.0 * (1.0 - 2.0 * law.poissons_ratio))
    volume = 4.0 / 3.0 * math.pi * law.radius**3
    squeezed = 2.0 * force * (law.radius - overlap) / (3.0 * bulk * volume)
    return 0.5 * (math.sqrt(max(0.0, 1.0 - 4.0 * squeezed)) - 1.0)


@kernel
def mdr_grown(law, height, strain):  # type: ignore[no-untyped-def]
    """R in m for a half height h (m) and an elastic volume strain."""
    volume = law.plastic_volume + 4.0 / 3.0 * math.pi * law.radius**3 * strain
    grown = math.sqrt((volume / (2.0 * math.pi) + height**3 / 3.0) / height)
    return min(max(grown, law.radius), 1.5 * law.radius)


@kernel
def mdr_apparent_radius(law, overlap):  # type: ignore[no-untyped-def]
    """R in m at a largest overlap.

    The elastic strain follows the force, which follows R: from the R without strain three evaluations and a secant step, which leave
    less than 1e-5 of R_0 at E/Y = 5 and 10, less than 1e-9 from 50 on.
    """
    if overlap <= law.growth_overlap:
        return law.radius
    height = law.radius - overlap
    first = mdr_grown(law, height, 0.0)
    second = mdr_grown(law, height, mdr_volume_strain(law, overlap, first))
    third = mdr_grown(law, height, mdr_volume_strain(law, overlap, second))
    if second == first or third - second == second - first:
        return third
    third = second - (third - second) * (second - first) / ((third - second) - (second - first))
    fourth = mdr_grown(law, height, mdr_volume_strain(law, overlap, third))
    return fourth


@kernel
def mdr_ellipse(angle):  # type: ignore[no-untyped-def]
    """t - sin t cos t; by its series where the difference would lose digits."""
    if angle > 0.05:
        return angle - math.sin(angle) * math.cos(angle)
    square = 4.0 * angle * angle
    return angle * square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))


@kernel
def mdr_ellipse_work(angle):  # type: ignore[no-untyped-def]
    """Integral of `mdr_ellipse` over u/A, (sin t - t cos t - sin^3 t/3)/2; by its series where the difference would lose digits."""
    if angle > 0.02:
        sine = math.sin(angle)
        return 0.5 * (sine - angle * math.cos(angle) - sine * sine * sine / 3.0)
    square = angle * angle
    return angle * square * square * (1.0 / 15.0 - square * (11.0 / 630.0 - square * 17.0 / 7560.0))


@kernel
def mdr_angle(part):  # type: ignore[no-untyped-def]
    """t for u/A = `part`, cos t = 1 - 2 u/A."""
    return 2.0 * math.asin(math.sqrt(min(1.0, max(0.0, part))))


@kernel
def mdr_correction(law, height, radius, pressure, centre):  # type: ignore[no-untyped-def]
    """1 + 2 C/A; `height` is A, `centre` is z."""
    nu = law.poissons_ratio
    far = math.sqrt(radius * radius + centre * centre)
    shear = 0.5 * law.youngs_modulus / (1.0 + nu)
    moved = pressure / (2.0 * shear * far) * (2.0 * radius * radius * (nu - 1.0) + (1.0 - 2.0 * nu) * centre * (far - centre))
    return 1.0 + 2.0 * moved / height


@kernel
def mdr_plastic(law, largest):  # type: ignore[no-untyped-def]
    """Of a largest overlap beyond first yield: force (N), contact radius (m), d_max - d_0 (m)."""
    grown = mdr_apparent_radius(law, largest)
    deep = largest + grown - law.radius
    pressure = mdr_pressure(law, deep, grown)
    radius = math.sqrt(mdr_area(law, deep, grown))
    height = 4.0 * pressure * radius / mdr_reduced_modulus(law)
    correction = mdr_correction(law, height, radius, pressure, grown - deep + 0.5 * height)
    return math.pi * radius * radius * pressure, radius, 0.5 * height * correction


@kernel
def mdr_part(recovered, largest, overlap):  # type: ignore[no-untyped-def]
    """u/A on the unloading from `largest`: 1/2 at the start, 0 at separation."""
    return 0.5 * max(0.0, 1.0 - (largest - overlap) / recovered)


@kernel
def mdr_elastic(law, overlap):  # type: ignore[no-untyped-def]
    """Force in N before first yield."""
    return 2.0 * mdr_reduced_modulus(law) * law.radius**2 * mdr_ellipse(mdr_angle(0.25 * overlap / law.radius))


@kernel
def mdr_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Loading, or unloading from the largest overlap (the memory, with what it takes to unload from there)."""
    if overlap <= 0.0:
        return 0.0, (0.0, 0.0, 0.0)
    if overlap < state[0]:
        if state[0] <= law.yield_overlap:
            return mdr_elastic(law, overlap), state
        return state[1] * 2.0 / math.pi * mdr_ellipse(mdr_angle(mdr_part(state[2], state[0], overlap))), state
    if overlap <= law.yield_overlap:
        return mdr_elastic(law, overlap), (overlap, 0.0, 0.0)
    force, _, recovered = mdr_plastic(law, overlap)
    return force, (overlap, force, recovered)


@kernel
def mdr_contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """a on the loading; on the unloading that of the ellipse, a sin t."""
    if overlap <= 0.0:
        return 0.0
    largest = max(overlap, state[0])
    if largest <= law.yield_overlap:
        return math.sqrt(law.radius * overlap)
    _, radius, recovered = mdr_plastic(law, largest)
    return radius * math.sin(mdr_angle(mdr_part(recovered, largest, overlap)))


@kernel
def mdr_work(law, largest):  # type: ignore[no-untyped-def]
    """Integral of the loading in J; Gauss quadrature beyond first yield, with the kink where the radius starts to grow at a panel's end."""
    first = min(largest, law.yield_overlap)
    part = 0.25 * first / law.radius
    work = 8.0 * mdr_reduced_modulus(law) * law.radius**3 * mdr_ellipse_work(mdr_angle(part))
    for low, high in ((law.yield_overlap, min(largest, law.growth_overlap)), (max(law.yield_overlap, law.growth_overlap), largest)):
        if high > low:
            panel = math.log(high / low) / _PANELS
            for i in range(_PANELS):
                for j in range(POINTS.size):
                    depth = low * math.exp(panel * (i + POINTS[j]))
                    work += panel * WEIGHTS[j] * depth * mdr_plastic(law, depth)[0]
    return work


@kernel
def mdr_energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored: the integral of the ellipse's force. Dissipated: work of the loading less what can be got back."""
    largest = max(overlap, state[0])
    if largest <= 0.0:
        return 0.0, 0.0
    if largest <= law.yield_overlap:
        return mdr_work(law, overlap), 0.0
    force, _, recovered = mdr_plastic(law, largest)
    unit = force * 2.0 / math.pi * 2.0 * recovered
    stored = unit * mdr_ellipse_work(mdr_angle(mdr_part(recovered, largest, overlap)))
    return stored, mdr_work(law, largest) - unit * mdr_ellipse_work(0.5 * math.pi)


@kernel
def mdr_stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """The steepest of loading (by differences) and start of unloading, 4 F_max/(pi (d_max - d_0)), at 64 overlaps beyond first yield."""
    top = max(overlap, 0.0)
    first = min(top, law.yield_overlap)
    largest = 2.0 * mdr_reduced_modulus(law) * math.sqrt(law.radius * first)
    if top <= law.yield_overlap:
        return largest
    for i in range(SAMPLES + 1):
        depth = law.yield_overlap * (top / law.yield_overlap) ** (i / SAMPLES) * (1.0 + 1e-6)
        force, _, recovered = mdr_plastic(law, depth)
        loading = (mdr_plastic(law, depth * (1.0 + 1e-6))[0] - force) / (1e-6 * depth)
        largest = max(largest, MARGIN * max(loading, 4.0 / math.pi * force / recovered))
    return largest


def mdr_problems(law: Mdr) -> Iterator[Problem]:
    """The last three fields must be those that `mdr_of` finds; they follow from the others."""
    expected = mdr_of(*law[:4])
    for name in ("yield_overlap", "growth_overlap", "plastic_volume"):
        if not math.isclose(getattr(law, name), getattr(expected, name), rel_tol=1e-6):
            yield Problem(
                name, getattr(law, name), f"must be {getattr(expected, name):.9g} for this material", "make the record with mdr_of"
            )


register(
    Law(
        "mdr",
        Mdr,
        mdr_force,
        mdr_contact_radius,
        mdr_energy,
        mdr_stiffness_bound,
        ("largest_overlap", "force_there", "recovered_overlap"),
        "Zunker & Kamrin 2024, J. Mech. Phys. Solids 183, 105492 and 105493, as documented for LAMMPS's `normal mdr`, without adhesion",
        mdr_problems,
    )
)
