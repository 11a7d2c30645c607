"""The rigid sphere of the pairs' verification: against a flat, and a smaller sphere."""

from __future__ import annotations

import numpy as np
import pytest

import fem
from cases.verification.rigid_sphere import indent
from contactlaws.material import Material

pytestmark = pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")


def test_a_very_large_sphere_is_a_flat():
    """Force and overlap left within the 2 % (of one mesh and its ripple) that the module states, the latter over the overlap."""
    material, overlap = Material(100.0, 0.3, 1.0), 0.02
    found, curve = indent(material, 1e9, overlap), fem.press(material, unload_from=(overlap,))
    rows = curve.rows(0)
    force = np.exp(np.interp(np.log(found.overlap), np.log(curve.overlap[rows][1:]), np.log(curve.force[rows][1:])))
    beyond = found.overlap >= curve.overlap[rows][1]
    assert np.abs(found.force / force - 1.0)[beyond].max() < 0.03
    assert found.left == pytest.approx(float(curve.overlap[-1]), abs=0.02 * overlap)


def test_elastic_sphere_on_a_rigid_one_is_hertz():
    """Both curvatures: a body that hardly yields (E/Y = 5 does at .06 R), within the ripple and the finite size at .005 R."""
    material = Material(5.0, 0.3, 1.0)
    found = indent(material, 0.5, 0.005)
    hertz = 4.0 / 3.0 * material.reduced_modulus * np.sqrt(0.5 / 1.5) * found.overlap**1.5
    middle = found.force.size // 2
    assert found.force[middle:] / hertz[middle:] == pytest.approx(1.0, abs=0.05)
