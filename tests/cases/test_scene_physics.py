"""The physics that a scene's table can ask for, and a tolerance in place of a law."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cases.batch.plan import plan
from cases.batch.work.scenes import contact_of, programme_of
from cases.casefile import reading
from contactlaws.curve import Curve
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw

CASE = """
[materials.nmc]
youngs_modulus = "142 GPa"
poissons_ratio = 0.25
yield_stress = "7.9 GPa"
[curves.plastic]
material = "nmc"
radius = "5 um"
unload_from = [0.05, 0.1]
[scenes.box]
radius = "5 um"
density = "4750 kg/m^3"
count = 50
packing_fraction = 0.6
strain = 0.03
"""


def read(tmp_path: Path, more: str) -> reading.Case:
    (tmp_path / "case.toml").write_text(CASE + more)
    return reading.read_case(tmp_path / "case.toml")


def test_roles_and_programme(tmp_path: Path) -> None:
    more = 'tolerance = 0.05\ncurves = ["plastic"]\nfriction = 0.3\nrestitution = 0.5\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\n'
    case = read(tmp_path, more + 'loading = "shear"\nroutine = "quasi-static"\n')
    tasks = {task.id: task for task in plan(case, tmp_path)}
    fit, scene = tasks["fits.box-law"], tasks["scenes.box"]
    assert (fit.values["tolerance"], fit.values["reach"]) == (0.05, 0.06)  # overlaps up to twice the strain
    assert "fits.box-law" in scene.needs
    contact = contact_of(FittedLaw(Hertz(5e-6, 151e9), max_overlap=5e-7), scene.values)
    assert contact.tangential is not None
    assert contact.tangential.shear_modulus == pytest.approx(142e9 / 2.5 / 3.5)
    assert contact.damping is not None
    assert contact.rolling is None
    assert [stage.shear for stage in programme_of(scene.values)] == [(0.0, 0.03, 0.0), (0.0, 0.0, 0.0)]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("", "either a fit, or a tolerance"),
        ("tolerance = 0.05\n", "either a fit, or a tolerance"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nfriction = 0.3\n', "youngs_modulus"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nrolling_friction = 0.3\n', "friction"),
        ('tolerance = 0.05\ncurves = ["elastic"]\n', "names nothing"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nrestitution = 0\n', "restitution"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nroutine = "fast"\n', "routine"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nloading = "shear"\naffine = false\n', "affine"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, more: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(tmp_path, more)


def test_a_curve_up_to_an_overlap() -> None:
    """Unloadings from beyond are left out, the rest keep their numbers in order."""
    overlap = np.array([0.0, 1.0, 2.0, 3.0, 1.0, 0.5, 3.0, 2.0])
    curve = Curve(np.arange(8.0), overlap, overlap.copy(), np.array([0, 0, 0, 0, 1, 1, 2, 2]), 10.0)
    part = curve.up_to(0.2)
    np.testing.assert_array_equal(part.overlap, [0.0, 1.0, 2.0, 1.0, 0.5])
    np.testing.assert_array_equal(part.branch, [0, 0, 0, 1, 1])
    with pytest.raises(InputError, match=r"ends at 0\.3"):
        curve.up_to(0.5)
