"""From curves in time to a viscoelastic law: what is known comes back, with errors that mean what they say."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad

import calibration
from calibration import force_errors
from calibration.contact_history import Growing, Whole, path_of
from calibration.prony_doubts import doubts
from calibration.prony_search import BEYOND
from calibration.series_from_curves import ForceFit, fit_series
from contactlaws import fitted
from contactlaws.curve import Curve, branches_in_time
from contactlaws.errors import InputError
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.path import trace
from contactlaws.prony import Relaxation, uniaxial
from tests.calibration.prony_samples import PVDF, numbers
from tests.calibration.series_samples import ONE, RADIUS, RATIO, THREE, TWO, curve_of, pressed

LAWS = ("maxwell_zener", "maxwell_zener_ting")
DRAWS = 20
TOLD = {"poissons_ratio": RATIO}
FITS = pytest.mark.compiled_only("a fit of hundreds of scans takes a minute interpreted")


def growing(curve: Curve, ratio: float | None = RATIO) -> Growing:
    path = path_of(curve)
    return Growing((path,), maxwell_zener(Relaxation(1.0), RADIUS, ratio), np.ones(path.force.size))


def whole(curve: Curve) -> Whole:
    target = growing(curve)
    return Whole(target.paths, target.body, target.scale, maxwell_zener_ting(Relaxation(1.0), RADIUS, RATIO))


class TestWhatIsFitted:
    def test_a_column_is_the_integral_of_lee_and_radok(self):
        """A ramp on Hertz's half-space: f(t) = int exp(-(t - s)/tau) dFe1(d(s)), with d = v s."""
        time = np.linspace(0.0, 1.0, 60)
        target = growing(curve_of(ONE, time, 0.02 * RADIUS * time, ratio=None), None)
        tau = np.array([0.3, 2.0])
        columns, _ = target.columns(tau)
        rate = 4.0 / 3.0 * np.sqrt(RADIUS) * 1.5 * (0.02 * RADIUS) ** 1.5
        for column, one in zip(columns[:, 1:].T, tau, strict=True):
            exact = [rate * quad(lambda s, t=t, one=one: np.exp((s - t) / one) * np.sqrt(s), 0.0, t)[0] for t in time[1:]]
            # the elastic force is straight in steps of h = 1/236 s: h^2/(12 tau) of F' at the end, and as much from the start
            np.testing.assert_allclose(column, exact, rtol=0.0, atol=2e-5 * column.max())

    def test_slopes_are_derivatives(self):
        curve = curve_of(TWO, *pressed(release=1.0, rows=30))
        amplitudes, times, shift = np.array([1e9, 6e8, 4e8]), np.array([0.1, 10.0]), 1e-3
        for target in (growing(curve), whole(curve)):
            slopes = target.slopes(amplitudes, times)
            up, down = (target.misses(amplitudes, times * np.exp([0.0, sign * shift])) for sign in (1.0, -1.0))
            # central differences of a coarser step: its square, times the curvature in the logarithm, which is of order 1
            np.testing.assert_allclose(slopes[:, -1], (up - down) / (2.0 * shift), atol=1e-5 * abs(slopes[:, -1]).max())
            np.testing.assert_allclose(
                slopes[:, :3] @ amplitudes, target.misses(amplitudes, times) + target.force[: len(slopes)], rtol=1e-5
            )

    def test_a_contact_that_only_grows_is_the_same_to_both_laws(self):
        curve = curve_of(TWO, *pressed(rows=30))
        numbers = np.array([1e9, 6e8, 4e8]), np.array([0.1, 10.0])
        # the springs take no part while the contact grows: round-off
        np.testing.assert_allclose(whole(curve).misses(*numbers), growing(curve).misses(*numbers), atol=1e-12 * curve.force.max())

    def test_rows_before_the_touch_and_rows_that_stand_twice_do_not_count(self):
        curve = curve_of(ONE, *pressed(hold=10.0, release=1.0, rows=20))
        turn = int(np.argmax(curve.overlap < curve.overlap.max())) if curve.overlap[0] > 0 else int(np.flatnonzero(curve.branch == 1)[0])
        order = np.sort([*range(curve.overlap.size), turn - 1])
        branch = curve.branch[order].copy()
        branch[turn] = 1
        twice = Curve(curve.time[order], curve.overlap[order], curve.force[order], branch, RADIUS, in_time=True)
        for name, one, two in zip(path_of(curve)._fields, path_of(curve), path_of(twice), strict=True):
            if name != "own":
                np.testing.assert_array_equal(one, two)

    def test_what_a_scatter_is_made_of(self):
        """1e-6 N and 2 % of forces up to 2e-4 N, from 2000 rows: variances are known to 3 % each, and share what they have in common."""
        force = 2e-4 * np.linspace(0.0, 1.0, 2000) ** 1.5
        truth = np.hypot(1e-6, 0.02 * force)
        sizes, (even, relative) = force_errors.scatter(truth * np.random.default_rng(2).standard_normal(2000), force)
        assert even == pytest.approx(1e-6, rel=0.1)
        assert relative == pytest.approx(0.02, rel=0.1)
        np.testing.assert_allclose(sizes, truth, rtol=0.1)


@cache
def draws(modulus: Relaxation) -> tuple[ForceFit, ...]:
    """With a release, but for three terms, which take long."""
    time, overlap = pressed(release=None if modulus is THREE else 1.0)
    curves = [curve_of(modulus, time, overlap, 0.01, seed) for seed in range(DRAWS)]
    return tuple(fit_series([curve], modulus is not THREE, RATIO) for curve in curves)


def distance(found: ForceFit, modulus: Relaxation) -> float:
    """Squared distance from the truth in standard errors, correlation minded: chi squared of as many degrees of freedom as numbers."""
    scale = np.sqrt(np.diag(found.covariance))
    away = (found.values - numbers(modulus)) / scale
    return float(away @ np.linalg.solve(found.correlation, away))


@pytest.mark.compiled_only("twenty fits of hundreds of scans each")
@pytest.mark.parametrize("modulus", [ONE, TWO, THREE], ids=["one", "two", "three"])
class TestOnePercentOfNoise:
    def test_the_number_of_terms_is_found(self, modulus):
        """Two idle unknowns lower chi squared by more than their price of 2 ln 200 = 10.6 in 1 % of curves, for any one time tried."""
        assert sum(found.terms == len(modulus.times) for found in draws(modulus)) >= DRAWS - 2

    def test_standard_errors_are_those_that_are_made(self, modulus):
        """Over the draws the mean squared distance is 1 per number to within 4 of its own standard deviations."""
        right = [found for found in draws(modulus) if found.terms == len(modulus.times)]
        mean = np.mean([distance(found, modulus) for found in right]) / right[0].values.size
        assert abs(mean - 1.0) < 4.0 * np.sqrt(2.0 / (right[0].values.size * len(right)))

    def test_nearly_all_numbers_lie_within_three_standard_errors(self, modulus):
        """0.3 % of normal ones do not."""
        right = [found for found in draws(modulus) if found.terms == len(modulus.times)]
        inside = [abs(found.values - numbers(modulus)) < 3.0 * np.sqrt(np.diag(found.covariance)) for found in right]
        assert np.mean(inside) > 0.97

    def test_nothing_is_doubted_but_what_ends_too_early(self, modulus):
        assert all("outside" not in warning for found in draws(modulus)[:3] for warning in doubts(found))


@pytest.mark.parametrize("law", ["maxwell_zener", pytest.param("maxwell_zener_ting", marks=FITS)])
def test_an_exact_curve_gives_its_series(law):
    found = calibration.fit(curve_of(ONE, *pressed(hold=10.0, release=1.0, rows=25)), law, TOLD)
    # 75 rows are followed in 4 steps each, the curve in 16: forces differ by some 1e-4, most where the ramp begins
    assert found.law.reduced_modulus == pytest.approx(ONE.instantaneous, rel=1e-3)
    assert found.law.fractions == pytest.approx(ONE.fractions, rel=1e-3)
    assert found.law.times == pytest.approx(ONE.times, rel=2e-3)
    assert found.series.asked == 1
    assert found.residuals.force < 1e-4
    assert found.series.noise_from == "they scatter by less, but no law is truer"


@FITS
def test_a_slow_and_a_fast_press_see_together_what_neither_sees_alone():
    fast, slow = curve_of(TWO, *pressed(0.01, 0.5), 0.002, 1), curve_of(TWO, *pressed(10.0, 200.0), 0.002, 2)
    both = calibration.fit([fast, slow], "maxwell_zener_ting", TOLD)
    assert both.series.asked == 2
    assert distance(both.series, TWO) < 30.0  # chi squared of 5 degrees of freedom: once in 70 000
    for one in (fast, slow):
        alone = calibration.fit(one, "maxwell_zener_ting", TOLD, terms=2)
        worse = np.array([alone.standard_errors.get(name, np.inf) / error for name, error in both.standard_errors.items()])
        assert worse.max() > 3.0
    assert both.series.window == (min(path_of(fast).window[0], path_of(slow).window[0]), pytest.approx(210.0))


@FITS
def test_units_change_nothing():
    """In other units of time and modulus the numbers are those, in these units; powers of 2, so to the accuracy of the fit."""
    curve = curve_of(TWO, *pressed(release=1.0), 0.01, 3)
    other = replace(curve, time=curve.time * 2.0**-5, force=curve.force * 2.0**12)
    one, two = (fit_series([c], poissons_ratio=RATIO) for c in (curve, other))
    units = np.array([2.0**12, 1.0, 1.0, 2.0**-5, 2.0**-5])
    np.testing.assert_allclose(two.values, one.values * units, rtol=1e-4)
    np.testing.assert_allclose(two.covariance, one.covariance * np.outer(units, units), rtol=1e-2)


@FITS
def test_a_measured_overlap_may_tremble():
    """0.1 % of noise in the overlap is 0.15 % in the force, and no retreat: nearly all rows of the hold go on counting as growth."""
    time, overlap = pressed(hold=10.0)
    curve = curve_of(ONE, time, overlap)
    trembling = overlap * (1.0 + 0.001 * np.random.default_rng(5).standard_normal(overlap.size))
    noisy = Curve(time, trembling, curve.force, branches_in_time(trembling), RADIUS, in_time=True)
    for law in LAWS:
        found = calibration.fit(noisy, law, TOLD)
        assert found.series.asked == 1
        assert not any("left out" in warning for warning in found.warnings)
        # the law's own step forgets, so noise in the overlap is not only noise in the force: ten standard errors and 1 %
        assert found.law.times[0] == pytest.approx(1.0, rel=0.02)
        assert found.law.fractions[0] == pytest.approx(0.4, rel=0.01)


@pytest.mark.compiled_only("a finite-element curve takes minutes interpreted")
class TestFiniteElements:
    """PVDF of Wahn, Gan & Kamlah (2022), a sphere of 5 um to 2 % in 1 s, held for 6.5 s and released in 1 s."""

    @staticmethod
    @cache
    def curve(constant_bulk: bool) -> Curve:
        import fem
        from fem.programme import ramp_hold_release

        return fem.press_in_time(uniaxial(PVDF, 0.4314, constant_bulk), ramp_hold_release(0.02 * RADIUS, 1.0, 6.5, 1.0), radius=RADIUS)

    @pytest.mark.parametrize("law", LAWS)
    def test_its_series_comes_back(self, law):
        """The aim is 1 % in fractions and times; the curve's own error is 0.25 % in force."""
        curve = self.curve(False)
        found, truth = calibration.fit(curve, law), curve.series.reduced
        assert found.series.asked == 1
        assert found.law.reduced_modulus == pytest.approx(truth.instantaneous, rel=0.0025)
        assert found.law.fractions == pytest.approx(truth.fractions, rel=0.01)
        assert found.law.times == pytest.approx(truth.times, rel=0.01)
        away = abs(numbers(found.series.modulus) - numbers(truth))
        assert (away < 3.0 * np.array(list(found.standard_errors.values()))).all()
        assert found.warnings == () or law == "maxwell_zener"

    @pytest.mark.parametrize("constant_bulk", [False, True])
    def test_its_force_is_met(self, constant_bulk):
        """The aim is half a per cent of the largest force, in loading, holding and release."""
        curve = self.curve(constant_bulk)
        law = calibration.fit(curve, "maxwell_zener_ting").law
        force = trace(law, curve.overlap, curve.time).force
        assert abs(force - curve.force).max() < 0.005 * curve.force.max()

    def test_with_a_constant_bulk_modulus_the_modulus_over_time_comes_back(self):
        """Two times so near each other count as one, and Poisson's ratio rises by 0.016 on the way: still within half a per cent."""
        curve = self.curve(True)
        time = np.linspace(0.0, 8.0, 50)
        found = calibration.fit(curve, "maxwell_zener_ting")
        np.testing.assert_allclose(found.series.modulus.at(time), curve.series.reduced.at(time), rtol=0.005)
        assert found.fitted.origin["poissons_ratio"] == pytest.approx(0.5 * (0.4314 + curve.series.long_term.poissons_ratio))

    def test_what_a_curve_says_of_itself_is_taken(self):
        curve = self.curve(False)
        told = calibration.fit(replace(curve, series=None, material=None), "maxwell_zener_ting", {"poissons_ratio": 0.4314})
        np.testing.assert_array_equal(told.law.times, calibration.fit(curve, "maxwell_zener_ting").law.times)


@FITS
class TestErrorsOfComputedCurves:
    def fitted(self, rows):
        curve = curve_of(ONE, *pressed(hold=10.0, rows=rows), errors={"force": 0.003})
        return fit_series([curve], shrinking=False, poissons_ratio=RATIO, terms=1)

    def test_more_rows_do_not_make_them_smaller(self):
        few, many = self.fitted(25), self.fitted(100)
        for name, error in few.standard_errors.items():
            # as the rows stand elsewhere, so does their weight
            assert many.standard_errors[name] == pytest.approx(error, rel=0.3)

    def test_half_of_the_variance_is_common_and_shifts_the_modulus_alone(self):
        """The modulus inherits no less than the common half of the error, and no more than all of it would be if nothing were common."""
        found = self.fitted(50)
        relative = found.standard_errors["instantaneous"] / found.modulus.instantaneous
        assert 0.003 * np.sqrt(0.5) < relative < 2.0 * 0.003
        assert found.misfit < 0.1
        assert "0.3 % of the largest force so far" in found.scatter


def warnings_of(modulus, *, law="maxwell_zener_ting", noise=0.0, terms=None, told=TOLD, **shape):
    shape = {"hold": 10.0, "rows": 40} | shape
    return " | ".join(calibration.fit(curve_of(modulus, *pressed(**shape), noise, 7), law, told, terms=terms).warnings)


@FITS
class TestWarnings:
    def test_none_where_all_is_seen(self):
        assert warnings_of(ONE, noise=0.002, rows=100, ramp=0.01) == ""

    def test_a_time_of_ten_thousand_durations(self):
        """What it does in 10 s is a slope, which says neither how long nor how much; with noise there is nothing at all."""
        far = Relaxation(2e9, (0.4,), (1e5,))
        assert "lies outside the 0.000617 to 10.1 s that the curves can see" in warnings_of(far, terms=1)
        found = calibration.fit(curve_of(far, *pressed(hold=10.0, rows=40)), "maxwell_zener_ting", TOLD, terms=1)
        assert found.law.times[0] <= 10.1 * BEYOND * (1.0 + 1e-9)
        for noise in (0.0, 0.01):
            assert "no relaxation can be told from the noise" in warnings_of(far, noise=noise)
        said = warnings_of(far, noise=0.01, terms=1)
        assert "lies outside" in said or "only 0 of the 1 terms asked for" in said

    def test_a_time_of_a_few_durations(self):
        said = warnings_of(Relaxation(2e9, (0.8,), (30.0,)), noise=0.0005)
        assert "that the curves can see" in said
        assert "not seen to level off" in said

    def test_a_time_before_the_first_rows(self):
        said = warnings_of(Relaxation(2e9, (0.8,), (2e-3,)), ramp=1.0, terms=1)
        assert "s lies outside the" in said

    def test_an_elastic_body(self):
        assert "no relaxation can be told" in warnings_of(Relaxation(2e9), noise=0.01)

    def test_without_poissons_ratio_the_body_is_a_half_space(self):
        assert "Hertz's half-space" in warnings_of(ONE, told={})

    def test_the_plain_law_says_what_it_leaves_out(self):
        assert "20 of 90 rows are left out" in warnings_of(ONE, law="maxwell_zener", release=1.0)


@FITS
def test_the_plain_law_does_not_look_at_a_contact_that_shrinks():
    curve = curve_of(ONE, *pressed(hold=10.0, release=1.0, rows=25), 0.001)
    spoilt = replace(curve, force=np.where(curve.branch == 1, 3.0 * curve.force.max(), curve.force))
    one, two = (calibration.fit(c, "maxwell_zener", TOLD) for c in (curve, spoilt))
    assert one.law.times == two.law.times
    assert one.residuals == two.residuals


@FITS
def test_a_fitted_law_on_disk(tmp_path):
    found = calibration.fit(curve_of(ONE, *pressed(hold=10.0, rows=25), 0.01), "maxwell_zener_ting", TOLD)
    back = fitted.load(fitted.save(found.fitted, tmp_path / "law.json"))
    assert back.standard_errors == found.standard_errors
    assert set(back.standard_errors) == {"reduced_modulus", "fractions[1]", "times[1]"}
    assert [one["terms"] for one in back.origin["candidates"]] == [one.terms for one in found.series.candidates]
    for one, two in zip(back.law, found.law, strict=True):
        np.testing.assert_array_equal(one, two)


def test_errors_are_those_of_numbers_that_are_there():
    law = maxwell_zener(ONE, RADIUS)
    fitted.FittedLaw(law, 1e-7, standard_errors={"fractions[1]": 0.1, "times": None})
    for name in ("fractions[0]", "fractions[2]", "times[x]", "radius[1]"):
        with pytest.raises(InputError, match=r"must be a positive number for one of"):
            fitted.FittedLaw(law, 1e-7, standard_errors={name: 0.1})


def _curve(**changes) -> Curve:
    return replace(curve_of(ONE, *pressed(hold=10.0, rows=20)), **changes)


def _timeless() -> Curve:
    overlap = np.linspace(0.0, 1e-7, 20)
    return Curve(np.arange(20.0), overlap, overlap**1.5, np.zeros(20), RADIUS)


@pytest.mark.parametrize(
    ("curves", "law", "options", "said"),
    [
        ([], "maxwell_zener", {}, "curves = 0: a fit needs at least one"),
        ([_timeless()], "maxwell_zener_ting", {}, r"curves\[0\] = 'a curve without time'"),
        ([_curve()], "thornton", {}, r"curves\[0\] = 'a curve in time': its force depends on time, of which thornton knows nothing"),
        ([_timeless()], "hertz", {"terms": 1}, "terms = 1: hertz has no relaxation times"),
        ([_curve(aspect=2.0)], "maxwell_zener", {}, r"aspect = 2.0: must be 1"),
        ([_curve(), _curve(radius=2 * RADIUS)], "maxwell_zener", {}, r"curves\[1\] = .* is of another body"),
        ([_curve(series=uniaxial(PVDF, 0.3)), _curve(series=uniaxial(ONE, 0.3))], "maxwell_zener", {}, r"curves\[1\] = 'another series'"),
        ([_curve()], "maxwell_zener", {"terms": 30}, r"terms = 30: must lie between 0 and 20 for \d+ forces"),
        ([_curve()], "maxwell_zener", {"terms": -1}, "terms = -1"),
        ([_curve()], "maxwell_zener", {"fixed": {"poissons_ratio": 0.5}}, r"poissons_ratio = 0.5: must lie in \[0, 0.5\)"),
        ([_curve()], "maxwell_zener", {"fixed": {"reduced_modulus": 1e9}}, r"fixed\[reduced_modulus\]"),
        ([_curve()], "maxwell_zener", {"free": ["times"]}, "times = 'maxwell_zener': has no weights"),
        ([_curve(force=-_curve().force)], "maxwell_zener", {}, "must be positive while the contact grows"),
        (
            [_curve(overlap=np.linspace(1e-7, 1e-9, 50), branch=np.arange(50) > 0)],
            "maxwell_zener_ting",
            {},
            "= '1 rows': must have at least 3",
        ),
    ],
)
def test_what_cannot_be_fitted_is_said(curves, law, options, said):
    with pytest.raises(InputError, match=said):
        calibration.fit(curves, law, **options)


def test_too_few_rows():
    short = Curve([0.0, 1.0, 2.0], [0.0, 1e-8, 1e-8], [0.0, 1e-6, 9e-7], [0, 0, 0], RADIUS, in_time=True)
    with pytest.raises(InputError, match="at least 3 rows in contact"):
        calibration.fit(short, "maxwell_zener_ting")
    four = Curve([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1e-8, 1e-8, 1e-8, 1e-8], [0.0, 1e-6, 9e-7, 8e-7, 8e-7], [0] * 5, RADIUS, in_time=True)
    with pytest.raises(InputError, match="a series needs at least 5"):
        calibration.fit(four, "maxwell_zener_ting")
