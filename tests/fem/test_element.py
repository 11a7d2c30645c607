"""The compiled element: consistent tangent, patch test, invariance, forces from the energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from fem.banded import pad
from fem.element import assemble_forces, deform
from fem.mesh import FloatArray
from fem.newton import Moduli
from tests.fem.bodies import ELASTIC, NEARLY_INCOMPRESSIBLE, PLASTIC, Material, displacements, middle_node, patch, slope, von_mises

BODY = patch()
ON_AXIS = patch(inner=0.0)
# few examples, since each is many evaluations; drawing big arrays is no fault
thorough = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])

#: far enough from the yield limit that differences don't step over it
MARGIN = 0.05
#: squeezed flat by a third, which is beyond yield at every point of PLASTIC
SQUEEZED = np.stack([0.1 * BODY.section.mesh.p[0], -0.3 * BODY.section.mesh.p[1]], axis=1)


def tangent_error(material: Material, displacement: FloatArray, e: int) -> float:
    """Largest difference of the stiffness from that of the forces, over the largest entry."""
    _, stiffness = material.element(displacement, e)
    columns = []
    for k in range(8):
        direction = np.zeros_like(displacement)
        direction[material.body.cells[e, k // 2], k % 2] = 1.0
        columns.append(slope(lambda h, way=direction: material.element(displacement + h * way, e)[0]))
    return float(np.abs(np.stack(columns, axis=1) - stiffness).max() / np.abs(stiffness).max())


def trial_over_limit(material: Material, displacement: FloatArray, e: int) -> FloatArray:
    """Trial von Mises stress over the yield limit at the four points of an element, from the material made elastic."""
    trial = Material(material.body, (*material.moduli[:2], np.inf))
    trial.history = material.history
    trial.go(displacement)
    return von_mises(trial.stress[e]) / material.moduli[2]


def dilatation(displacement: FloatArray, e: int) -> float:
    """Deformed over undeformed volume of an element of `BODY`, not positive if it is turned inside out."""
    b = BODY
    return float(deform(displacement, b.cells, b.gradients, b.hoops, b.volumes, e, np.empty((4, 5)))[0])


def sound(displacement: FloatArray) -> bool:
    return all(dilatation(displacement, e) > 0.3 for e in range(4))


@thorough
@given(displacements)
@example(np.zeros((9, 2)))
@example(np.stack([0.1 * BODY.section.mesh.p[0], 0.1 * BODY.section.mesh.p[1]], axis=1))  # all principal stretches equal
def test_elastic_tangent_is_the_derivative_of_the_forces(displacement: FloatArray):
    for body in (BODY, ON_AXIS):
        material = Material(body, ELASTIC)
        assert max(tangent_error(material, displacement, e) for e in range(4)) < 1e-8


@thorough
@given(displacements, st.sampled_from([PLASTIC, NEARLY_INCOMPRESSIBLE]))
def test_plastic_tangent_is_the_derivative_of_the_forces(displacement: FloatArray, moduli: Moduli):
    """A third of the height squeezed out puts every point beyond yield; on top a random displacement, then another with that history."""
    material = Material(BODY, moduli)
    for u in (SQUEEZED + 0.3 * displacement, SQUEEZED * 1.3 - 0.3 * displacement):
        for e in range(4):
            ratio = trial_over_limit(material, u, e)
            assume(np.all(np.abs(ratio - 1.0) > MARGIN))
            assert tangent_error(material, u, e) < 1e-8
        material.go(u)
    assert material.plastic_strain.min() > 0.0


@thorough
@given(displacements)
def test_unloading_tangent_is_the_derivative_of_the_forces(displacement: FloatArray):
    """Back by a thirtieth of the path, which is elastic from a plastic history, with the yield limit out of reach of the differences."""
    material = Material(BODY, PLASTIC)
    material.go(SQUEEZED + 0.3 * displacement)
    back = (1.0 - 1.0 / 30.0) * (SQUEEZED + 0.3 * displacement)
    for e in range(4):
        ratio = trial_over_limit(material, back, e)
        assume(np.all(ratio < 1.0 - MARGIN))
        assert tangent_error(material, back, e) < 1e-8


@thorough
@given(displacements)
def test_tangent_of_partly_plastic_elements(displacement: FloatArray):
    material = Material(BODY, PLASTIC)
    for e in range(4):
        ratio = trial_over_limit(material, displacement, e)
        if np.all(np.abs(ratio - 1.0) > MARGIN) and sound(displacement):
            assert tangent_error(material, displacement, e) < 1e-8


def homogeneous(radial: float, axial: float) -> FloatArray:
    """Displacements of `patch` under two stretches."""
    return np.stack([(radial - 1.0) * BODY.section.mesh.p[0], (axial - 1.0) * BODY.section.mesh.p[1]], axis=1)


@given(st.floats(0.6, 1.6), st.floats(0.6, 1.6))
@settings(deadline=None)
def test_patch_homogeneous_stretch(radial: float, axial: float):
    """Equal stress everywhere, K ln J + 2 G dev(ln stretch)/J, and no force on the inner node of an irregular patch, to round-off."""
    material = Material(BODY, ELASTIC)
    bulk, shear, _ = ELASTIC
    displacement = homogeneous(radial, axial)
    material.go(displacement)
    volume = radial * radial * axial
    deviator = np.log([radial, axial, radial]) - np.log(volume) / 3.0
    expected = bulk * np.log(volume) + 2.0 * shear * deviator / volume
    np.testing.assert_allclose(material.stress[..., [0, 1, 3]], np.broadcast_to(expected, (4, 4, 3)), rtol=0, atol=1e-13)
    np.testing.assert_allclose(material.stress[..., 2], 0.0, atol=1e-13)
    forces = material.forces(displacement)
    np.testing.assert_allclose(forces[middle_node(BODY)], 0.0, atol=1e-13)
    # the flat ends are pressed with stress times deformed area
    top = BODY.section.surface
    assert forces[top, 1].sum() == pytest.approx(expected[1] * np.pi * (1.5**2 - 0.5**2) * radial**2, rel=1e-12, abs=1e-12)


@given(displacements, st.floats(-10.0, 10.0))
@settings(deadline=None)
def test_axial_translation_changes_nothing(displacement: FloatArray, lift: float):
    assume(sound(displacement))
    material = Material(BODY, ELASTIC)
    still, moved = material.forces(displacement), material.forces(displacement + np.array([0.0, lift]))
    # round-off of a lift of 10 in strains, times the moduli
    np.testing.assert_allclose(moved, still, rtol=0, atol=1e-12)
    np.testing.assert_allclose(still[:, 1].sum(), 0.0, atol=1e-13)  # internal forces have no axial resultant


def test_undeformed_body_has_no_forces():
    assert np.abs(Material(BODY, ELASTIC).forces(np.zeros((9, 2)))).max() == 0.0


@thorough
@given(displacements, displacements)
def test_elastic_forces_are_the_slope_of_the_stored_energy(displacement: FloatArray, direction: FloatArray):
    assume(sound(displacement))
    material = Material(BODY, ELASTIC)

    def stored(h: float) -> FloatArray:
        material.go(displacement + h * direction)  # an elastic history stays the unit tensor
        return np.array(material.stored)

    work = float((Material(BODY, ELASTIC).forces(displacement) * direction).sum())
    assert float(slope(stored)) == pytest.approx(work, rel=1e-8, abs=1e-10)  # as good as the differences are


@thorough
@given(displacements)
def test_band_matrix_holds_the_tangent_of_the_whole_patch(displacement: FloatArray):
    """The assembled band, unrolled into a dense matrix, against differences of the assembled forces; symmetric while elastic."""
    assume(sound(displacement))
    material = Material(BODY, ELASTIC)
    _, band = material.assembled(displacement)
    half, size = BODY.half_bandwidth, BODY.dofs
    dense = np.zeros((size, size))
    for column in range(size):
        for row in range(max(0, column - half), min(size, column + half + 1)):
            dense[row, column] = band[row, pad(half) + column - row]
    scale = np.abs(dense).max()
    np.testing.assert_allclose(dense, dense.T, rtol=0, atol=1e-13 * scale)
    rng = np.random.default_rng(1)
    direction = rng.standard_normal(displacement.shape)
    by_differences = slope(lambda h: material.forces(displacement + h * direction).ravel())
    np.testing.assert_allclose(dense @ direction.ravel(), by_differences, rtol=0, atol=1e-8 * scale)


@thorough
@given(displacements)
def test_forces_alone_are_those_that_come_with_the_stiffness(displacement: FloatArray):
    """Two formulas, the spatial and the material one, elastic and beyond yield, to round-off of the moduli's size."""
    assume(sound(displacement))
    for moduli in (ELASTIC, PLASTIC, NEARLY_INCOMPRESSIBLE):
        material, b = Material(BODY, moduli), BODY
        alone = np.empty(b.dofs)
        assert assemble_forces(displacement, b.cells, b.gradients, b.hoops, b.volumes, material.history, moduli, alone)
        np.testing.assert_allclose(alone, material.forces(displacement).ravel(), rtol=0, atol=1e-13 * moduli[0])


def test_inside_out_element_is_refused():
    turned = np.zeros((9, 2))
    turned[middle_node(BODY)] = [0.0, 0.7]  # beyond the upper edge
    assert min(dilatation(turned, e) for e in range(4)) < 0.0
