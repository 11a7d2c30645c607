"""Fits recover what the curves were made from, and say what the curves do not tell."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import calibration
from calibration.trust import Trust, doubts
from contactlaws.curve import Curve
from contactlaws.elastic import Hertz, HertzFiniteSize
from contactlaws.elastoplastic import Thornton
from contactlaws.errors import InputError
from tests.contactlaws.samples import HARD, NMC, SOFT, curve_of, edmans_sinka

ERRORS = {"force": 0.005, "contact_radius": 0.01, "unloading_stiffness": 0.01}
THORNTON = Thornton(5e-6, NMC.reduced_modulus, 1.6 * 7.9e9)


def test_recovers_thornton():
    found = calibration.fit(curve_of(THORNTON, 5e-7, material=NMC, errors=ERRORS), "thornton")
    assert found.free == ("yield_pressure",)
    assert found.law.yield_pressure == pytest.approx(THORNTON.yield_pressure, rel=1e-6)  # perfect data: the optimiser's own tolerance
    assert found.misfit < 1e-4
    assert not found.warnings
    assert found.fitted.max_overlap == 5e-7
    assert max(abs(value) for value in found.residuals if value is not None) < 1e-3  # the trapezoid of the energy over 40 rows


def test_a_measured_curve_has_only_overlap_and_force():
    curve = dataclasses.replace(curve_of(THORNTON, 5e-7), contact_radius=None)
    found = calibration.fit(curve, "thornton")
    assert set(found.free) == {"reduced_modulus", "yield_pressure"}
    assert found.law.yield_pressure == pytest.approx(THORNTON.yield_pressure, rel=1e-6)
    assert found.law.reduced_modulus == pytest.approx(THORNTON.reduced_modulus, rel=1e-6)
    assert found.residuals.contact_radius is None


def shifted(curve: Curve, force: float, ripple: float) -> Curve:
    """A systematic error of the force and a ripple along the loading, the same relative error where unloading starts."""
    factor = 1.0 + force + ripple * np.sin(2.0 * np.log(curve.overlap))
    return dataclasses.replace(curve, force=curve.force * np.where(curve.branch == 0, factor, 1.0 + force))


@pytest.mark.parametrize(("force", "ripple"), [(0.005, 0.0), (-0.005, 0.0), (0.0, 0.005)])
def test_standard_errors_cover_a_curve_that_is_off_by_its_own_error(force: float, ripple: float):
    curve = curve_of(THORNTON, 5e-7, material=NMC, errors=ERRORS)
    found = calibration.fit(shifted(curve, force, ripple), "thornton", free=("reduced_modulus",))
    for name in found.free:
        error = found.standard_errors[name]
        assert error is not None
        assert abs(getattr(found.law, name) - getattr(THORNTON, name)) < 2.0 * error


def test_more_rows_and_more_unloadings_do_not_make_the_errors_small():
    """The error of a curve is one systematic error: four times the rows change the standard errors by no more than the shares of their
    rows.
    """
    few = calibration.fit(curve_of(THORNTON, 5e-7, material=NMC, rows=80, errors=ERRORS))
    many = calibration.fit(curve_of(THORNTON, 5e-7, tuple(np.linspace(0.3, 1.0, 12)), material=NMC, rows=320, errors=ERRORS))
    one, two = few.standard_errors["yield_pressure"], many.standard_errors["yield_pressure"]
    assert one is not None
    assert two is not None
    assert two > 0.7 * one  # the common half of the variance alone is 0.7


def test_hertz_data_say_nothing_about_a_yield_pressure():
    found = calibration.fit(curve_of(Hertz(5e-6, 150e9), 5e-7, ()), "thornton")
    assert any("yield_pressure" in warning for warning in found.warnings)
    assert found.law.reduced_modulus == pytest.approx(150e9, rel=1e-4)


def test_parameters_that_cannot_be_told_apart_are_named():
    """An elastic factor and the modulus that it multiplies, over a tenth of the overlaps that would tell them apart."""
    law = HertzFiniteSize(1.0, 50.0, 0.3, 1.0, 6.0, 0.0, 0.0)
    found = calibration.fit(curve_of(law, 0.05, (), HARD.elastic, errors=ERRORS), "hertz_finite_size", free=("reduced_modulus",))
    assert any("cannot be told apart" in warning or "hardly determined" in warning for warning in found.warnings)
    assert found.condition_number > 30


def test_recovers_the_finite_size_factor():
    law = HertzFiniteSize(1.0, 50.0, 0.3, 1.0, 6.0, 0.1, 0.8)
    found = calibration.fit(curve_of(law, 0.5, (), material=elastic_material(50.0), errors=ERRORS), "hertz_finite_size")
    for name in found.free:
        assert getattr(found.law, name) == pytest.approx(getattr(law, name), rel=1e-5)  # linear in all of them


def elastic_material(reduced: float):
    """An elastic material of that reduced modulus."""
    return SOFT.elastic._replace(youngs_modulus=reduced * (1.0 - SOFT.poissons_ratio**2))


def test_recovers_edmans_sinka_with_its_elastic_factor_from_an_elastic_curve():
    law = edmans_sinka(SOFT, flow_decay_2=0.0)
    elastic = HertzFiniteSize(*(getattr(law, name) for name in HertzFiniteSize._fields))
    curves = [curve_of(law, 0.14, (0.3, 0.6, 1.0), SOFT, errors=ERRORS), curve_of(elastic, 0.14, (), SOFT.elastic, errors=ERRORS)]
    found = calibration.fit(curves, "edmans_sinka")
    assert found.misfit < 1e-3
    assert found.residuals.force < 1e-5
    # three unloadings, an area, overlaps below those of the whole body flowing: all that then is free must come back
    loading, area = {"flow", "flow_decay", "flow_sharpness"}, {"plastic_area", "plastic_area_decay", "area_onset"}
    assert set(found.free) == loading | area | {"exponent", "exponent_decay"}
    for name in found.free:
        assert found.standard_errors[name] is not None
        # perfect data; a condition number of 76 (of 6000 for the squares) leaves that much of the optimiser's 1e-12
        assert getattr(found.law, name) == pytest.approx(getattr(law, name), rel=1e-6)
    assert not any("elastic curve" in warning for warning in found.warnings)


def test_tabulated_takes_one_curve_and_leaves_no_residual():
    curve = curve_of(edmans_sinka(HARD), 0.1, material=HARD, yield_overlap=5.3e-6)
    found = calibration.fit(curve, "tabulated")
    assert found.residuals.force < 1e-12
    with pytest.raises(InputError, match="made from one curve"):
        calibration.fit([curve, curve], "tabulated")


def test_hertz_on_a_plastic_curve_is_held_to_the_part_before_yield():
    curve = curve_of(THORNTON, 5e-7, material=NMC, yield_overlap=8e-8)
    found = calibration.fit(curve, "hertz")
    assert found.fitted.max_overlap <= 8e-8
    assert found.residuals.force < 1e-12


def test_a_law_that_cannot_do_it_says_that_it_is_the_limit():
    found = calibration.fit(curve_of(edmans_sinka(HARD), 0.1, material=HARD, errors=ERRORS), "thornton")
    assert found.misfit > 5
    assert any("the law, not the curves" in warning for warning in found.warnings)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"law": "hertzz"}, "no recipe"),
        ({"fixed": {"yeld_pressure": 1.0}}, r"fixed\[yeld_pressure\]"),
        ({"fixed": {"yield_pressure": float("nan")}}, "must be a finite number"),
        ({"fixed": {"yield_pressure": -1.0}}, r"fixed\[yield_pressure\] = -1.0: must be above 0"),
        ({"free": ("colour",)}, r"free\[colour\]"),
        ({"weights": {"force": -1.0}}, r"weights\[force\]"),
        ({"weights": {"colour": 1.0}}, r"weights\[colour\]"),
    ],
)
def test_bad_requests_are_refused(arguments: dict, expected: str):
    with pytest.raises(InputError, match=expected):
        calibration.fit(curve_of(THORNTON, 5e-7, material=NMC), **arguments)


def test_curves_of_different_bodies_are_refused():
    curve = curve_of(THORNTON, 5e-7, material=NMC)
    with pytest.raises(InputError, match="another material"):
        calibration.fit([curve, dataclasses.replace(curve, material=HARD)])
    with pytest.raises(InputError, match="another body"):
        calibration.fit([curve, dataclasses.replace(curve, radius=6e-6)])
    with pytest.raises(InputError, match="at least one"):
        calibration.fit([])


def test_edmans_sinka_on_a_measured_curve_must_be_told_poissons_ratio():
    curve = dataclasses.replace(curve_of(edmans_sinka(SOFT), 0.1), contact_radius=None)
    with pytest.raises(InputError, match="poissons_ratio missing"):
        calibration.fit(curve, "edmans_sinka")
    found = calibration.fit(curve, "edmans_sinka", fixed={"poissons_ratio": 0.3})
    assert found.residuals.force < 0.01
    assert any("no elastic curve was given: force_1, force_2, force_3, area_1, area_2 are 0" in warning for warning in found.warnings)


SPHEROID = dataclasses.replace(curve_of(Hertz(4.0, 50.0), 0.01, (), SOFT.elastic), radius=1.0, aspect=2.0)


@pytest.mark.parametrize("law", ["hertz_finite_size", "thornton", "edmans_sinka"])
def test_laws_of_spheres_refuse_a_spheroid(law: str):
    with pytest.raises(InputError, match=r"aspect = 2.0: must be 1: .*; fit 'hertz' for small overlaps"):
        calibration.fit(SPHEROID, law)


def test_hertz_takes_the_curvature_at_the_pole_of_a_spheroid():
    """Semi-axes 2 (equator) and 1: 2^2/1 = 4 m, the radius that the curve was made with."""
    found = calibration.fit(dataclasses.replace(SPHEROID, material=None), "hertz")
    assert found.law.radius == 4.0
    assert found.law.reduced_modulus == pytest.approx(50.0, rel=1e-6)  # perfect data: the optimiser's own tolerance
    assert any("pole of a spheroid of aspect 2" in warning for warning in found.warnings)


def test_a_table_of_a_spheroid_says_that_it_is_none_of_spheres():
    assert any("NOT ONE OF SPHERES" in warning for warning in calibration.fit(SPHEROID, "tabulated").warnings)
    assert not calibration.fit(dataclasses.replace(SPHEROID, aspect=1.0), "tabulated").warnings


@pytest.mark.parametrize("factor", [0.0, -1.0])
@pytest.mark.parametrize("law", ["hertz", "thornton", "tabulated"])
def test_a_curve_that_never_pushes_is_refused(law: str, factor: float):
    curve = curve_of(Hertz(1.0, 50.0), 0.1, ())
    with pytest.raises(InputError, match="must be positive at the end of the loading"):
        calibration.fit(dataclasses.replace(curve, force=factor * curve.force), law)


def test_doubts_about_a_logarithm_are_said_as_a_factor():
    found = Trust(np.array([0.6, 20.0, 0.4, 0.6, 9.0]), np.eye(5), 1.0, 0.0, np.zeros(5))
    assert list(doubts(found, ["one", "two", "three", "four", "any"], [0.0, 0.0, 0.0, 1.0, None])) == [
        "one is known to within a factor of 1.82 only",  # exp(0.6)
        "two is not determined",
        "four - 1 is known to within a factor of 1.82 only",
    ]
