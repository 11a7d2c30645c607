"""CalculiX as another code: a cube of known stiffness behind the gaps, where `ccx` is installed, and what is read of its text."""

import numpy as np
import pytest

from cases import calculix

#: what CalculiX writes of two increments
TEXT = """
 total force (fx,fy,fz) for set Z and time  0.5000000E+00

       -1.000000E-07  2.000000E+00 -3.500000E+00

 total force (fx,fy,fz) for set Z and time  0.1000000E+01

        0.000000E+00  4.000000E+00 -7.000000E+00
"""


def test_total_forces_are_read_in_order() -> None:
    moment, force = calculix.total_forces(TEXT)
    assert moment.tolist() == [0.5, 1.0]
    assert force.tolist() == [[-1e-7, 0.0], [2.0, 4.0], [-3.5, -7.0]]


def test_no_increment_is_no_row() -> None:
    moment, force = calculix.total_forces("")
    assert moment.shape == (0,)
    assert force.shape == (3, 0)


def cube(clearance: float) -> str:
    """A unit cube of modulus 1 without lateral strain, which is pushed up by .05 against a flat at this clearance."""
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lines = ["*NODE, NSET=BODY", *(f"{k + 1}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(corners))]
    lines += ["*NODE, NSET=FLAT", *(f"{k + 9}, {x}, {y}, {1.0 + clearance}" for k, (x, y, _) in enumerate(corners[4:]))]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=BODY", "1, 1, 2, 3, 4, 5, 6, 7, 8"]
    lines += calculix.gaps(2, np.arange(4, 8), np.arange(8, 12), np.full(4, clearance), "0., 0., 1.", 1.0)
    lines += calculix.node_set("Z", range(4))
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "1., 0.", "*SOLID SECTION, ELSET=BODY, MATERIAL=M"]
    lines += ["*BOUNDARY", "FLAT, 1, 3", "BODY, 1, 2", "*STEP, NLGEOM", "*STATIC, DIRECT", "0.25, 1.", "*BOUNDARY", "Z, 3, 3, 0.05"]
    return "\n".join([*lines, "*NODE PRINT, NSET=Z, TOTALS=ONLY", "RF", "*END STEP"]) + "\n"


@pytest.mark.skipif(calculix.installed() is None, reason="CalculiX is not installed")
def test_a_cube_is_held_by_the_flat_from_the_clearance_on() -> None:
    found = calculix.run(cube(clearance=0.02), [0.05])
    assert found.finished
    assert found.overlap == pytest.approx([0.0125, 0.025, 0.0375, 0.05])
    # stress in proportion to Green's strain, (stretch^2 - 1)/2, as CalculiX has it; the gaps give way by 1e-5 of the strain,
    # and four open ones pull with 1e-10 each
    stretch = 1.0 - np.maximum(0.0, found.overlap - 0.02)
    assert found.force[2] == pytest.approx(0.5 * stretch * (1.0 - stretch**2), rel=3e-5, abs=5e-10)
