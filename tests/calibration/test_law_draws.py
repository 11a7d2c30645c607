"""Laws drawn from the errors of a fit have those errors, and only those."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import calibration
from calibration.law_draws import draw
from contactlaws.curve import Curve
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw
from contactlaws.material import Material
from contactlaws.path import scan
from contactlaws.whole_range import whole_range

MANY = 400


def curve(noise: float = 0.02) -> Curve:
    """Hertz with an error of its force, of a material that is not told."""
    law = Hertz(1.0, 1e9)
    overlap = np.linspace(0.0, 0.01, 40)
    force = scan(law, overlap).force * (1.0 + noise * np.sin(9.0 * np.arange(40.0)))
    return Curve(np.arange(40.0), overlap, force, np.zeros(40, np.int64), radius=1.0, errors={"force": noise})


def test_a_modulus_is_drawn_with_its_standard_error() -> None:
    """Mean and deviation of 400 draws are known to 5 % and 3.5 % of the deviation; three of these are allowed."""
    fit = calibration.fit(curve(), law="hertz")
    (error,) = fit.standard_errors.values()
    assert error is not None
    assert error > 0.0
    moduli = np.array([draw(fit.fitted, fit.free, fit.correlation, seed).law.reduced_modulus for seed in range(MANY)])
    relative = error / fit.law.reduced_modulus
    logarithms = np.log(moduli / fit.law.reduced_modulus)
    assert logarithms.std() == pytest.approx(relative, rel=3 / np.sqrt(2 * MANY))
    assert abs(logarithms.mean()) < 3.0 * relative / np.sqrt(MANY)


def test_parameters_are_drawn_with_their_correlation() -> None:
    """Of 400 draws, a correlation of .9 is known to .01; three of these are allowed."""
    law = calibration.fit(curve(), law="hertz").law
    fitted = FittedLaw(calibration.recipes.recipe_for("thornton").build((), {**law._asdict(), "yield_pressure": 1e7}), 0.01)
    fitted = replace(fitted, standard_errors={"reduced_modulus": 1e7, "yield_pressure": 1e5})
    correlation = np.array([[1.0, 0.9], [0.9, 1.0]])
    drawn = [draw(fitted, ("reduced_modulus", "yield_pressure"), correlation, seed).law for seed in range(MANY)]
    found = np.corrcoef([[np.log(one.reduced_modulus) for one in drawn], [np.log(one.yield_pressure) for one in drawn]])[0, 1]
    assert found == pytest.approx(0.9, abs=0.03)


def test_without_errors_every_draw_is_the_fitted_law() -> None:
    fit = calibration.fit(curve(), law="hertz")
    sure = replace(fit.fitted, standard_errors={"reduced_modulus": 0.0})
    law = draw(sure, fit.free, fit.correlation, 7).law
    assert law.reduced_modulus == pytest.approx(fit.law.reduced_modulus, rel=1e-14)  # through a logarithm and back
    assert draw(replace(fit.fitted, standard_errors={}), (), np.zeros((0, 0)), 7).law == fit.law


def test_the_same_seed_gives_the_same_law() -> None:
    fit = calibration.fit(curve(), law="hertz")
    first, again, other = (draw(fit.fitted, fit.free, fit.correlation, seed).law for seed in (3, 3, 4))
    assert first == again
    assert first != other


def test_what_is_not_known_is_refused() -> None:
    fit = calibration.fit(curve(), law="hertz")
    with pytest.raises(InputError, match="no standard error"):
        draw(replace(fit.fitted, standard_errors={"reduced_modulus": None}), fit.free, np.array([[np.nan]]), 1)


def test_constants_that_follow_from_what_is_drawn_follow_it() -> None:
    """The whole-range law's constants all follow from the material: a draw of one changes them all."""
    law = whole_range(Material(1e9, 0.3, 1e7), 1.0)
    drawn = draw(FittedLaw(law, 0.1, standard_errors={"yield_stress": 1e6}), ("yield_stress",), np.eye(1), 1).law
    assert drawn.yield_stress != law.yield_stress
    assert drawn == whole_range(Material(1e9, 0.3, drawn.yield_stress), 1.0)


def test_what_is_no_parameter_of_the_fit_is_refused() -> None:
    fit = calibration.fit(curve(), law="hertz")
    with pytest.raises(InputError, match="is no parameter that a fit of hertz finds"):
        draw(replace(fit.fitted, standard_errors={"radius": 0.1}), ("radius",), np.eye(1), 1)
