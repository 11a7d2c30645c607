"""The physics that a scene's table can ask for, and a tolerance in place of a law."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import dem
from cases.batch.plan import plan, scene_plan
from cases.batch.work.scenes import contact_of, programme_of
from cases.casefile import reading
from cases.report import history
from cases.study import run_tasks
from contactlaws.curve import Curve
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.whole_range_ellipsoid import WholeRangeEllipsoid
from dem.ellipsoid_packing import half_axes, random_ellipsoids

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
        ("shape = [1, 0.8, 0.66]\n", "youngs_modulus"),
        ('shape = [1, 0.8]\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\n', "shape"),
        ('shape = [1, 0.8, -1]\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\n', "shape"),
        ('shape = [1, 0.8, 0.05]\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\n', "up to 10"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nyield_stress = "7.9 GPa"\n', "needs shape"),
        ('tolerance = 0.05\ncurves = ["plastic"]\nshape = [1, 1, 2]\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\n', "leave out fit"),
        ('shape = [1, 1, 2]\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\nroutine = "quasi-static"\n', "is for spheres"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, more: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(tmp_path, more)


ELLIPSOIDS = """
shape = [1.0, 0.8, 0.66]
youngs_modulus = "142 GPa"
poissons_ratio = 0.25
"""


def test_law_of_ellipsoids_is_that_of_their_material(tmp_path: Path) -> None:
    """No fit stands before the scene; plastic where there is a yield stress. The half axes keep the sphere's volume."""
    for more, law in (("", HertzEllipse), ('yield_stress = "7.9 GPa"\n', WholeRangeEllipsoid)):
        tasks = plan(read(tmp_path, ELLIPSOIDS + more), tmp_path)
        packing, scene = (next(task for task in tasks if task.kind == kind) for kind in ("packings", "scenes"))
        assert scene.needs == (packing.id,)
        assert [task.kind for task in tasks if task.kind == "fits"] == []
        assert isinstance(contact_of(None, scene.values).normal, law)
        axes = half_axes(packing.values["shape"], packing.values["radius"])
        assert axes.prod() == pytest.approx(5e-6**3, rel=1e-14)
        assert axes / axes[0] == pytest.approx([1.0, 0.8, 0.66], rel=1e-14)


@pytest.mark.compiled_only("packs ellipsoids")
def test_a_scene_file_of_ellipsoids_runs(tmp_path: Path) -> None:
    """Through `fe2dem simulate`: the history is that of the same scene put together in Python."""
    keys = 'radius = "5 um"\ndensity = "4750 kg/m^3"\ncount = 12\npacking_fraction = 0.6\nstrain = 0.1\nstrain_rate = "1e5 1/s"\n'
    (tmp_path / "bed.toml").write_text(keys + ELLIPSOIDS)
    asked, law = reading.read_scene(tmp_path / "bed.toml", None)
    assert law is None
    records = run_tasks("bed", tmp_path / "bed.toml", scene_plan("bed", asked, law), tmp_path / "out", jobs=1)
    found = history.read(tmp_path / "out" / records["scenes.bed"].files["history"])
    packing = random_ellipsoids(12, 0.6, half_axes((1.0, 0.8, 0.66), 5e-6), seed=1)
    contact = dem.Contact(HertzEllipse(Material(142e9, 0.25).reduced_modulus))
    programme = dem.uniaxial_compression(0.1, strain_rate=1e5)
    expected = dem.run(dem.Scene(packing.particles(4750.0), packing.box, contact, programme, time_step_fraction=0.4))
    assert expected.stress[:, 2, 2].max() > 0.0
    np.testing.assert_array_equal(found["stress_zz"], expected.stress[:, 2, 2])


def test_a_curve_up_to_an_overlap() -> None:
    """Unloadings from beyond are left out, the rest keep their numbers in order."""
    overlap = np.array([0.0, 1.0, 2.0, 3.0, 1.0, 0.5, 3.0, 2.0])
    curve = Curve(np.arange(8.0), overlap, overlap.copy(), np.array([0, 0, 0, 0, 1, 1, 2, 2]), 10.0)
    part = curve.up_to(0.2)
    np.testing.assert_array_equal(part.overlap, [0.0, 1.0, 2.0, 1.0, 0.5])
    np.testing.assert_array_equal(part.branch, [0, 0, 0, 1, 1])
    with pytest.raises(InputError, match=r"ends at 0\.3"):
        curve.up_to(0.5)
