"""Predictions obey mechanics, meet curves that the atlas is not made of, and are refused outside its range."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration import atlas as atlas_file
from calibration import predict
from calibration.atlas_check import COLUMNS, differences, random_materials, report
from calibration.atlas_check import main as check_atlas
from calibration.atlas_errors import expected
from calibration.atlas_response import Interpolator
from calibration.predict import DEFAULT_STARTS
from contactlaws import checks, fitted
from contactlaws.curve_files import read_curve
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.path import trace

ATLAS = atlas_file.shipped()
RESPONSE = Interpolator(ATLAS)
SMALLEST, DEEPEST = float(ATLAS.depths[0]), float(ATLAS.depths[-1])
UNSEEN = sorted((Path(__file__).parent / "unseen").glob("*.parquet"))
DEPTHS = np.geomspace(1e-3 * SMALLEST, DEEPEST, 120)

ratios = st.floats(0.0, float(np.log(ATLAS.modulus_ratios[-1]))).map(lambda t: float(np.exp(t)))
poisson = st.floats(0.0, float(ATLAS.poissons_ratios[-1]))


@settings(deadline=None, max_examples=25)
@given(poisson)
def test_a_touch_is_hertzian(nu):
    """At d = 1e-6 R a sphere is a paraboloid to sqrt(d)/2 or so, and no material of the atlas with E/Y = 1 has yielded."""
    found, touch = RESPONSE(1.0, nu), np.array([1e-8, 1e-6])
    hertz = trace(Hertz(1.0, Material(1.0, nu).reduced_modulus), touch)
    assert found.force(touch) == pytest.approx(hertz.force, rel=1e-3)
    assert np.sqrt(found.area(touch)) == pytest.approx(hertz.contact_radius, rel=1e-3)


@settings(deadline=None, max_examples=25)
@given(ratios, poisson)
def test_before_first_yield_a_body_is_elastic(ratio, nu):
    """Exactly: nothing is added to the elastic body there."""
    plastic, elastic = RESPONSE(ratio, nu), RESPONSE(None, nu)
    below = DEPTHS[(plastic.yield_depth or np.inf) >= DEPTHS]
    same = plastic.elastic
    np.testing.assert_array_equal(plastic.force(below), same.force(below))
    assert plastic.recovered(below) == pytest.approx(below, rel=1e-14)
    assert plastic.force(below) == pytest.approx(elastic.force(below), rel=1e-4)  # their rows below the atlas stand elsewhere


@settings(deadline=None, max_examples=10)
@given(ratios, poisson, st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_forces_scale_with_stress_and_area(ratio, nu, stress, length):
    """No length or stress of its own stands in the mechanics: only round-off is left."""
    one = predict(Material(ratio, nu, 1.0), unload_from=[0.05, 0.2])
    other = predict(Material(ratio * stress, nu, stress), radius=length, unload_from=[0.05, 0.2])
    assert other.curve.overlap == pytest.approx(one.curve.overlap * length, rel=1e-9, abs=1e-14)
    assert other.curve.force == pytest.approx(one.curve.force * stress * length**2, rel=1e-9, abs=1e-14)
    assert other.curve.contact_radius == pytest.approx(one.curve.contact_radius * length, rel=1e-9, abs=1e-14)


@settings(deadline=None, max_examples=25)
@given(ratios, poisson)
def test_a_deeper_contact_pushes_harder_is_wider_and_gives_back_no_more_than_it_took(ratio, nu):
    found = RESPONSE(ratio, nu)
    force, recovered = found.force(DEPTHS), found.recovered(DEPTHS)
    assert (np.diff(force) > 0.0).all()
    assert (np.diff(found.area(DEPTHS)) > 0.0).all()
    assert (recovered <= DEPTHS * (1.0 + 1e-12)).all()
    share = np.linspace(0.0, 1.0, 50)
    given_back = force[-1] * recovered[-1] * np.trapezoid(found.shape(DEEPEST, share), share)
    assert given_back <= np.trapezoid(force, DEPTHS) * (1.0 + 2e-3)  # the trapezoids' own error
    assert (np.diff(found.shape(DEEPEST, share)) > 0.0).all()
    assert (np.diff(found.edge(DEEPEST, share)) >= 0.0).all()


@settings(deadline=None, max_examples=25)
@given(st.floats(0.0, float(np.log(ATLAS.modulus_ratios[-1] / 1.3))), poisson)
def test_a_stiffer_and_a_stronger_body_push_harder(t, nu):
    """At one yield stress the force rises with the modulus; at one modulus with the yield stress; by no more than in proportion.

    Where the force hardly depends on one of them the interpolation error, a few parts in a thousand, is left to it.
    """
    ratio = float(np.exp(t))
    soft, stiff = RESPONSE(ratio, nu).force(DEPTHS) * ratio, RESPONSE(1.3 * ratio, nu).force(DEPTHS) * 1.3 * ratio
    assert (stiff >= soft * (1.0 - 3e-3)).all()
    assert (stiff <= 1.3 * soft * (1.0 + 3e-3)).all()


@settings(deadline=None, max_examples=25)
@given(ratios, poisson)
def test_below_the_smallest_overlap_only_the_overlap_over_that_of_first_yield_counts(ratio, nu):
    """Continuous where the two meet; elastic in the limit."""
    found = RESPONSE(ratio, nu)
    around = SMALLEST * np.array([1.0 - 1e-7, 1.0 + 1e-7])
    for values in (found.force(around), found.area(around), found.recovered(around)):
        assert values[0] == pytest.approx(values[1], rel=1e-5)


@pytest.mark.parametrize("path", UNSEEN, ids=lambda path: path.stem)
def test_curves_that_the_atlas_is_not_made_of_are_met(path):
    """Promised at worst: force 1 %, contact radius 1.5 %, stiffness 2.5 %, exponent 1.5 %."""
    curve = read_curve(path)
    assert curve.content_hash not in ATLAS.hashes
    rows = list(differences(ATLAS, curve))
    assert len(rows) == len(curve.unloadings)
    for name, bound in zip(COLUMNS, (0.01, 0.015, 0.025, 0.015, 0.03, 0.01), strict=True):
        assert max(abs(getattr(row, name)) for row in rows) < bound, name


def test_stated_errors_hold_on_unseen_curves():
    """Nine of ten numbers within what is stated for them."""
    text = report(ATLAS, [read_curve(path) for path in UNSEEN])
    assert float(text.splitlines()[-1].split(":")[1].split("%")[0]) >= 90.0


def test_the_stated_error_is_that_of_the_finite_elements_at_a_node_and_grows_between():
    nu = float(ATLAS.poissons_ratios[1])
    low, high = ATLAS.modulus_ratios[3:5]
    node, between = (expected(ATLAS, float(ratio), nu, 0.3) for ratio in (low, np.sqrt(low * high)))
    assert node.interpolation["force"] == pytest.approx(0.0, abs=1e-12)
    assert between.interpolation["force"] > 0.0
    assert between.total["force"] == between.interpolation["force"] + between.finite_elements["force"]


def test_the_law_is_the_curve_and_its_file_says_where_it_is_from(tmp_path):
    found = predict(Material(70e9, 0.2, 1e9), radius=5e-6, unload_from=[0.03, 0.12])
    assert max(found.law_errors.values()) < 1e-3  # monotone cubics through the same rows
    again = fitted.load(fitted.save(found.law, tmp_path / "law.json"))
    assert again.origin == found.law.origin
    assert again.origin["atlas"] == ATLAS.content_hash == found.atlas
    assert again.origin["errors"]["interpolation"]["force"] == found.interpolation["force"]
    assert again.max_overlap == pytest.approx(0.12 * 5e-6)
    assert found.curve.errors == found.errors
    assert found.curve.yield_overlap is not None


@pytest.mark.compiled_only(reason="a thousand paths of a table; interpreted it takes a minute")
@pytest.mark.parametrize("ratio", [3.0, 40.0, 700.0])
def test_the_law_is_safe(ratio):
    """What any law must satisfy: no tension, no energy from closed paths, continuity, a stiffness that is bounded."""
    found = predict(Material(ratio * 1e8, 0.3, 1e8), radius=1e-3)
    assert [finding for finding in checks.check(found.law.law, found.law.max_overlap, paths=4) if not finding.passed] == []


def test_an_elastic_material_has_an_elastic_law():
    found = predict(Material(5e9, 0.3), radius=1e-3)
    assert found.curve.yield_overlap is None
    assert found.law.law.stored.shape[1] == 0
    for branch in found.curve.unloadings:
        assert found.curve.overlap[found.curve.rows(branch)][-1] == pytest.approx(0.0, abs=1e-15)


def test_a_closed_law_states_how_far_it_is_from_the_curve():
    found = predict(Material(50e9, 0.3, 1e9), law="whole_range", max_overlap=0.3)
    assert found.law.name == "whole_range"
    assert 0.0 < found.law_errors["force"] < 0.2


def test_everything_outside_is_refused_at_once():
    with pytest.raises(InputError) as caught:
        predict(Material(1e9, 0.4999, 1e4), unload_from=[0.1, 0.7], max_overlap=0.8)
    names = [problem.name for problem in caught.value.problems]
    assert names == ["youngs_modulus / yield_stress", "poissons_ratio", "unload_from", "max_overlap"]
    assert all("compute" in problem.remedy for problem in caught.value.problems)
    with pytest.raises(InputError) as caught:
        predict(Material(-1e9, 0.7, 1e4), radius=0.0, unload_from=[-0.1], law="no such law")
    assert [problem.name for problem in caught.value.problems] == ["youngs_modulus", "poissons_ratio", "radius", "unload_from", "law"]


def test_materials_for_the_check_lie_in_the_range_and_stay_the_same():
    drawn = random_materials()
    assert drawn == random_materials()
    assert all(1.0 <= one.youngs_modulus <= 1e4 and 0.0 <= one.poissons_ratio <= 0.49 for one in drawn)


@pytest.mark.compiled_only(reason="finite elements; interpreted they take minutes")
def test_outside_the_atlas_finite_elements_are_run_once_for_all_laws(monkeypatch):
    import fem

    pressed, said = [], []
    press = fem.press
    monkeypatch.setattr(fem, "press", lambda material, **options: pressed.append((material, options)) or press(material, **options))
    material, programme = Material(2e13, 0.3, 1e9), {"radius": 1e-3, "unload_from": [0.01], "compute": True}
    listen = lambda fraction, text: said.append(fraction)  # noqa: E731
    exact, fitted_one = (predict(material, **programme, law=law, progress=listen) for law in ("tabulated", "thornton"))
    assert [one for one, _ in pressed] == [material, material.elastic]
    assert said
    assert max(said) == 1.0
    assert exact.atlas is None
    assert exact.curve.content_hash == fitted_one.curve.content_hash == exact.law.curve_hashes[0]
    assert exact.law.origin["source"] == "finite elements"
    assert exact.errors == exact.finite_elements == exact.curve.errors
    # a stiff body is pressed in its fully plastic state: Tabor's mean pressure, 2.8 to 3 times the yield stress, less what a finite
    # overlap takes off
    mean = exact.curve.force[exact.curve.rows(1)][0] / (np.pi * exact.curve.contact_radius[exact.curve.rows(1)][0] ** 2)
    assert 2.6 < mean / 1e9 < 3.0
    assert max(exact.law_errors.values()) < 1e-3 < fitted_one.law_errors["force"]


@pytest.mark.parametrize(
    ("unload_from", "max_overlap", "starts", "deepest"),
    [
        (None, None, DEFAULT_STARTS, 0.5),
        (None, 0.03, (0.01, 0.02, 0.03), 0.03),
        (None, 0.005, (0.005,), 0.005),
        ((0.1, 0.6), 0.2, (0.1, 0.6), 0.6),
    ],
)
def test_finite_elements_go_as_deep_as_was_asked(monkeypatch, unload_from, max_overlap, starts, deepest):
    class Asked(Exception):
        pass

    def press(material, **options):
        raise Asked(options)

    monkeypatch.setattr("fem.press", press)
    with pytest.raises(Asked) as caught:
        predict(Material(3e4, 0.3, 1.0), unload_from=unload_from, max_overlap=max_overlap, compute=True)
    options = caught.value.args[0]
    assert options["unload_from"] == starts
    assert options["max_overlap"] == deepest


def test_the_check_of_the_atlas_wants_folders_that_are_there(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("")
    assert check_atlas([str(tmp_path / "nowhere")]) == 2
    assert "is no folder" in capsys.readouterr().err
    assert not (tmp_path / "nowhere").exists()
    assert check_atlas([str(file / "inside"), "--compute"]) == 2
    assert "cannot be created" in capsys.readouterr().err
    assert check_atlas([str(UNSEEN[0].parent)]) == 0
    assert "within the stated error" in capsys.readouterr().out
