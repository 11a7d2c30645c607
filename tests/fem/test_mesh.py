"""The structured mesh of the meridian section, and the band layout made from it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fem.assembly import discretise
from fem.mesh import FloatArray, Section, spheroid

#: what press() and the verification ask for, and beyond
divisions = st.integers(3, 24)
cores = st.floats(1e-4, 0.2)
aspects = st.floats(0.2, 5.0)
some = settings(max_examples=40, deadline=None)


def corners(section: Section) -> tuple[FloatArray, FloatArray]:
    """Jacobian (elements, 4) and inner angle in degrees at the corners of every quadrilateral."""
    x = np.moveaxis(section.mesh.p[:, section.mesh.t.T], 0, -1)
    ahead, back = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    jacobian = ahead[..., 0] * back[..., 1] - ahead[..., 1] * back[..., 0]
    cosine = (ahead * back).sum(axis=-1) / np.linalg.norm(ahead, axis=-1) / np.linalg.norm(back, axis=-1)
    return jacobian, np.degrees(np.arccos(cosine))


def half_surface(aspect: float) -> float:
    """Area of half a spheroid with axial semi-axis 1 and equatorial semi-axis `aspect`."""
    if aspect == 1.0:
        return 2.0 * math.pi
    if aspect > 1.0:
        e = math.sqrt(1.0 - 1.0 / aspect**2)
        return math.pi * aspect**2 * (1.0 + (1.0 - e * e) / e * math.atanh(e))
    e = math.sqrt(1.0 - aspect**2)
    return math.pi * aspect**2 * (1.0 + math.asin(e) / (aspect * e))


def meshed_surface(section: Section) -> float:
    """Area of the surface of revolution of the polygon through the surface nodes."""
    r, z = section.mesh.p[:, section.surface]
    return float((math.pi * (r[1:] + r[:-1]) * np.hypot(np.diff(r), np.diff(z))).sum())


@some
@given(divisions, cores, aspects, st.sampled_from([1.0, 2.0]))
def test_no_element_is_folded(m: int, core: float, aspect: float, along: float):
    """All counter-clockwise, and on a sphere no corner flatter than the core's own: 90 + 45 degrees and what is curved of it."""
    section = spheroid(m, core, aspect, along)
    jacobian, _ = corners(section)
    assert jacobian.min() > 0.0
    _, angle = corners(spheroid(m, core, 1.0, along))
    assert angle.max() < 145.0
    assert angle.min() > 45.0


@some
@given(divisions, cores, aspects)
def test_boundary_nodes(m: int, core: float, aspect: float):
    """Axis, mid-plane and surface hold exactly the nodes that lie on them, together the whole boundary; the surface starts at the pole."""
    section = spheroid(m, core, aspect)
    r, z = section.mesh.p
    assert set(section.axis) == set(np.flatnonzero(r == 0.0))
    assert set(section.midplane) == set(np.flatnonzero(z == 0.0))
    on_surface = np.abs((r / aspect) ** 2 + z**2 - 1.0) < 1e-12  # round-off
    assert set(section.surface) == set(np.flatnonzero(on_surface))
    assert set(section.axis) | set(section.midplane) | set(section.surface) == set(section.mesh.boundary_nodes())
    assert (np.diff(r[section.surface]) > 0.0).all()
    assert section.mesh.p[:, section.surface[0]] == pytest.approx((0.0, 1.0), abs=1e-15)
    assert section.mesh.p[:, section.surface[-1]] == pytest.approx((aspect, 0.0), abs=1e-12)
    assert section.height == 1.0


@pytest.mark.parametrize("aspect", [0.2, 1.0, 5.0])
def test_right_angles_where_boundaries_meet(aspect: float):
    """Pole, equator and centre: 90 degrees, as the map keeps them, but for the elements' straight edges (first order in their size)."""
    errors = []
    for m in (8, 16):
        section = spheroid(m, 0.1, aspect)
        _, angle = corners(section)
        ends = [section.surface[0], section.surface[-1], np.flatnonzero((section.mesh.p == 0.0).all(axis=0))[0]]
        at = [angle[np.equal(section.mesh.t.T, node)] for node in ends]
        assert all(a.size == 1 for a in at)
        errors.append(np.abs(np.concatenate(at) - 90.0).max())
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("aspect", [0.2, 1.0, 5.0])
def test_volume_and_surface_converge_at_second_order(aspect: float):
    volume, surface = [], []
    for m in (6, 12, 24):
        body = discretise(spheroid(m, 0.1, aspect))
        volume.append(abs(body.volumes.sum() / (2.0 / 3.0 * math.pi * aspect**2) - 1.0))
        surface.append(abs(meshed_surface(body.section) / half_surface(aspect) - 1.0))
    for errors in (volume, surface):
        assert math.log2(errors[0] / errors[2]) / 2.0 == pytest.approx(2.0, abs=0.1)


def test_elements_are_as_fine_as_their_distance_from_the_pole_asks():
    """The same number of surface nodes per factor in contact radius, wherever the contact edge is (until the surface turns down)."""
    section = spheroid(8, 0.01)
    r = section.mesh.p[0, section.surface]
    growth = r[1:] / np.maximum(r[:-1], 1e-300)
    graded = (r[:-1] > 0.03) & (r[1:] < 0.3)
    np.testing.assert_allclose(growth[graded], growth[graded].mean(), rtol=0.05)  # the sphere's curvature at r = 0.3


@some
@given(divisions, cores, st.sampled_from([1.0, 2.0]))
def test_band_is_as_narrow_as_two_rings(m: int, core: float, along: float):
    """Nodes in layers around the pole: coupling reaches no further than the next layer (2 m + 1 nodes each, two components a node)."""
    body = discretise(spheroid(m, core, 1.0, along))
    assert body.half_bandwidth <= 2 * (2 * m + 4) + 1
    assert body.slots.min() >= 0
    assert body.slots.max() < body.band_shape[0] * body.band_shape[1]


def test_each_entry_of_the_stiffness_has_its_own_slot():
    body = discretise(spheroid(4, 0.1))
    dofs = (2 * body.cells[:, :, None] + np.arange(2)).reshape(-1, 8)
    pairs = np.stack([np.repeat(dofs, 8, axis=1).ravel(), np.tile(dofs, (1, 8)).ravel()])
    found: dict[int, tuple[int, int]] = {}
    for slot, row, column in zip(body.slots.ravel(), *pairs, strict=True):
        assert found.setdefault(int(slot), (int(row), int(column))) == (row, column)
    assert len(found) == np.unique(pairs, axis=1).shape[1]
