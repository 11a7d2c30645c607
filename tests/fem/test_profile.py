"""Bodies given as points: what is refused, what gmsh makes of the rest, and that the curves are those of analysis and of `fem.press`."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from contactlaws.errors import InputError
from contactlaws.material import Material
from fem import press, press_profile
from fem.assembly import discretise
from fem.profile import GMSH_PACKAGES, load_gmsh, meridian, profile_section

try:
    load_gmsh()
    REASON = ""
except InputError as error:
    REASON = str(error)
needs_gmsh = pytest.mark.skipif(bool(REASON), reason=REASON)
slow_interpreted = pytest.mark.compiled_only(reason="minutes per curve, and the solver is not run differently for a body of another shape")


def sphere(count: int = 91) -> np.ndarray:
    angle = np.linspace(0.0, np.pi / 2, count)
    points = np.column_stack([np.sin(angle), np.cos(angle)])
    points[-1, 1] = 0.0
    return points


def superellipse(power: float) -> np.ndarray:
    """r^power + z^power = 1, points close together at the pole."""
    r = 0.8 * np.linspace(0.0, 1.0, 301) ** 2
    z = (1.0 - r**power) ** (1.0 / power)
    side = z[-1] * np.linspace(1.0, 0.0, 100)[1:]
    return np.column_stack([np.concatenate([r, (1.0 - side**power) ** (1.0 / power)]), np.concatenate([z, side])])


@pytest.mark.parametrize(
    ("points", "named"),
    [
        (sphere()[[0, -1]], "at least 3"),
        (np.zeros((5, 3)), "at least 3"),
        ("sphere.csv", "must be numbers"),
        (np.where(np.arange(91)[:, None] == 7, np.nan, sphere()), "points[7]"),
        (sphere()[1:], "must be the pole"),
        (sphere()[:-1], "must lie on the mid-plane"),
        (sphere()[::-1], "ordered|order the points"),
        ([(0, 1), (0.5, 0.9), (0.4, 0.5), (1, 0)], "turns back"),
        ([(0, 1), (0.3, 1.1), (0.6, 0.5), (1, 0)], "crosses itself"),
        ([(0, 1), (0.5, 0.9), (0.5, 0.9), (1, 0)], "the same as the point before"),
        (-sphere(), "must be the pole"),
    ],
)
def test_a_profile_that_cannot_be_pressed_is_refused_with_its_reason(points, named):
    with pytest.raises(InputError) as error:
        meridian(points)
    assert any(part in str(error.value) for part in named.split("|"))


def test_all_problems_of_a_profile_are_named_at_once():
    with pytest.raises(InputError) as error:
        meridian([(0.1, 1), (0.5, 0.9), (0.4, 0.95), (1, 0.2)])
    assert [p.name for p in error.value.problems] == ["points[0]", "points[3]", "points[2]"]


def test_points_on_a_circle_give_a_circle_in_any_unit():
    shape = meridian(5e-6 * sphere())
    # points 1 degree apart: local interpolation is good to the fourth power of their distance
    assert np.abs(np.hypot(shape.radius, shape.height) - 1.0).max() < math.radians(1.0) ** 4
    # chords of 20000 places
    assert shape.length[-1] == pytest.approx(np.pi / 2, rel=1e-7)


def test_a_flat_top_stays_flat_and_a_straight_side_straight():
    shape = meridian(
        [(0.0, 1.0), (0.1, 1.0), (0.2, 1.0), (0.5, 0.8), (0.6, 0.7), (0.7, 0.6), (0.8, 0.5), (0.9, 0.3), (0.9, 0.1), (0.9, 0.0)]
    )
    assert (shape.height[shape.radius <= 0.2] == 1.0).all()
    straight = (shape.radius > 0.6) & (shape.radius < 0.7)
    np.testing.assert_allclose(shape.radius[straight] + shape.height[straight], 1.3, atol=1e-12)  # round-off
    assert shape.radius_at_depth(0.0) == pytest.approx(0.2, abs=1e-4)  # between two tabulated places


def test_without_gmsh_the_error_names_the_packages(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(InputError, match=GMSH_PACKAGES):
        press_profile(sphere(), Material(100.0, 0.3), max_overlap=0.01)


def test_bad_material_and_overlap_are_found_before_gmsh_is_asked_for(monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(InputError) as error:
        press_profile(sphere(), Material(-1.0, 0.3), unload_from=[1.5])
    assert {p.name for p in error.value.problems} == {"youngs_modulus", "unload_from"}


@needs_gmsh
@pytest.mark.parametrize("core", [0.2, 0.02])
def test_the_section_is_made_of_convex_quadrilaterals_that_fill_the_body(core):
    shape = meridian(sphere())
    volumes = []
    for divisions in (3, 6, 12):
        section = profile_section(shape, divisions, core)
        points, surface = section.mesh.p, section.surface
        assert section.height == 1.0
        assert (points[0, section.axis] == 0.0).all()
        assert (points[1, section.midplane] == 0.0).all()
        assert {surface[0]} <= set(section.axis)
        assert {surface[-1]} <= set(section.midplane)
        assert (np.diff(points[0, surface]) > 0.0).all()
        np.testing.assert_allclose(np.hypot(*points[:, surface]), 1.0, atol=1e-7)  # the meridian of points 1 degree apart
        volumes.append(discretise(section).volumes.sum())
        assert (surface.size - 1) * 12 == (profile_section(shape, 12, core).surface.size - 1) * divisions
    # chords for arcs: the missing volume falls with the square of the size
    missing = 1.0 - np.array(volumes) / (2.0 * np.pi / 3.0)
    np.testing.assert_allclose(missing[:-1] / missing[1:], 4.0, rtol=0.15)


@needs_gmsh
@slow_interpreted
@pytest.mark.parametrize("material", [Material(200e9, 0.3, 1e9), Material(50e9, 0.3, 1e9)])
def test_a_sphere_of_points_is_the_sphere_of_the_structured_mesh(material):
    structured = press(material, radius=2e-6, unload_from=[0.05])
    meshed = press_profile(2e-6 * sphere(), material, unload_from=[0.05])
    assert (meshed.radius, meshed.aspect) == pytest.approx((2e-6, 1.0))
    overlap = np.linspace(0.01, 0.05, 30) * 2e-6
    for name in ("force", "contact_radius"):
        one, other = (np.interp(overlap, c.overlap[c.rows(0)], getattr(c, name)[c.rows(0)]) for c in (structured, meshed))
        # the estimates are of the mean along the path
        assert abs((other / one - 1.0).mean()) < structured.errors[name] + meshed.errors[name]
    recovered = [c.overlap[c.rows(1)][0] - c.overlap[c.rows(1)][-1] for c in (structured, meshed)]
    bound = structured.errors["unloading_stiffness"] + meshed.errors["unloading_stiffness"]
    assert abs(recovered[1] / recovered[0] - 1.0) < bound


@needs_gmsh
@slow_interpreted
def test_a_quartic_tip_follows_the_solution_for_punches_of_power_law_shape():
    """Galin 1946, Sneddon 1965: z = A r^n gives F = 2 E* n/(n+1) a d with d = A a^n sqrt(pi) Gamma(n/2 + 1)/Gamma(n/2 + 1/2)."""
    n, material = 4, Material(1e9, 0.3)
    curve = press_profile(superellipse(n), material, max_overlap=1e-6)
    shape = 0.25 * math.sqrt(math.pi) * math.gamma(n / 2 + 1) / math.gamma(n / 2 + 0.5)
    rows = np.flatnonzero(curve.overlap >= 0.2e-6)
    radius = (curve.overlap[rows] / shape) ** (1 / n)
    force = 2.0 * material.reduced_modulus * n / (n + 1) * radius * curve.overlap[rows]
    # a is 0.035 in the end, and the body being finite stiffens it by about 0.6 a; the mesh adds 0.3 %
    np.testing.assert_allclose(curve.force[rows] / force, 1.0 + 0.6 * radius, atol=0.006)
    np.testing.assert_allclose(curve.contact_radius[rows] / radius, 1.0, atol=0.015)  # a quarter of an element
