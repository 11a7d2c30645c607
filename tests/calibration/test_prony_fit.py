"""From tables to Prony series: what is known comes back, with standard errors that mean what they say."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import cache

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from scipy.integrate import quad

from calibration.prony_basis import TERMS
from calibration.prony_doubts import doubts
from calibration.prony_fit import fit_prony
from calibration.prony_record import PronyFit
from calibration.prony_search import BEYOND
from calibration.prony_table import PronyTable
from contactlaws.errors import InputError
from contactlaws.prony import Creep, Relaxation, uniaxial
from tests.calibration.prony_samples import ONE, PVDF, THREE, TWO, numbers, table_of

KINDS = ("relaxation", "creep", "dynamic")
SEEDS = 40
ONCE = pytest.mark.compiled_only("dozens of fits; nothing of them is compiled, so once is enough")


@pytest.mark.parametrize("kind", KINDS)
def test_terms_are_those_of_the_records_and_their_slopes_their_derivatives(kind):
    place, times = np.geomspace(0.01, 100.0, 9), np.array([0.3, 1.0, 20.0])
    shift = 1e-5
    up, down = (TERMS[kind](place, times * np.exp(sign * shift))[0] for sign in (1.0, -1.0))
    # central differences: 1e-10 from the step, 1e-11 from round-off
    np.testing.assert_allclose(TERMS[kind](place, times)[1], (up - down) / (2.0 * shift), atol=1e-9)
    values = TERMS[kind](place, times)[0]
    if kind == "relaxation":
        np.testing.assert_allclose(0.5 + values @ [0.1, 0.2, 0.2], Relaxation(1.0, (0.1, 0.2, 0.2), tuple(times)).at(place), rtol=1e-14)
    if kind == "creep":
        np.testing.assert_allclose(1.0 + values @ [0.1, 0.2, 0.2], Creep(1.0, (0.1, 0.2, 0.2), tuple(times)).at(place), rtol=1e-14)


@pytest.mark.parametrize("z", [0.1, 1.0, 7.0])
def test_the_dynamic_modulus_of_a_maxwell_element_is_the_transform_of_its_relaxation(z):
    """G* = i omega times the integral of G(t) exp(-i omega t), with G = exp(-t); at omega tau = 1 both parts are one half."""
    storage, loss = TERMS["dynamic"](np.array([z]), np.array([1.0]))[0][:, 0]
    parts = [quad(lambda t: np.exp(-t), 0.0, np.inf, weight=weight, wvar=z, epsabs=1e-12)[0] for weight in ("sin", "cos")]
    np.testing.assert_allclose([storage, loss], z * np.array(parts), atol=1e-10)  # the quadrature's own accuracy
    if z == 1.0:
        assert storage == loss == 0.5


@st.composite
def separated(draw):
    """Up to three terms at least a factor of 8 apart and inside the window, each of a weight that shows."""
    terms = draw(st.integers(1, 3))
    gaps = [draw(st.floats(8.0, 20.0)) for _ in range(terms)]
    times = 0.01 * np.cumprod(gaps)
    weights = np.array([draw(st.floats(0.1, 1.0)) for _ in range(terms)])
    fractions = draw(st.floats(0.3, 0.9)) * weights / max(weights.sum(), 1.0)
    return Relaxation(draw(st.floats(1e3, 1e12)), tuple(fractions), tuple(times))


@settings(max_examples=15)
@given(separated(), st.sampled_from(KINDS))
def test_what_was_measured_exactly_comes_back(modulus, kind):
    found = fit_prony(table_of(modulus, kind))
    assert found.asked == len(modulus.times)
    # the fit is converged to round-off; times that are a factor of 8 apart multiply it by less than 1e6
    np.testing.assert_allclose(found.values, numbers(modulus), rtol=1e-6)


@cache
def draws(modulus: Relaxation, kind: str) -> tuple[PronyFit, ...]:
    return tuple(fit_prony(table_of(modulus, kind, noise=0.01, seed=seed)) for seed in range(SEEDS))


def distance(found: PronyFit, modulus: Relaxation) -> float:
    """Squared distance from the truth in standard errors, correlation minded: chi squared of as many degrees of freedom as numbers."""
    away = found.values - numbers(modulus)
    scale = np.sqrt(np.diag(found.covariance))
    return float((away / scale) @ np.linalg.solve(found.correlation, away / scale))


@ONCE
@pytest.mark.parametrize(
    ("modulus", "kind"),
    [*itertools.product([ONE, TWO, THREE], ["relaxation", "dynamic"]), (TWO, "creep")],
    ids=["one", "one-dynamic", "two", "two-dynamic", "three", "three-dynamic", "two-creep"],
)
class TestOnePercentOfNoise:
    def test_the_number_of_terms_is_found(self, modulus, kind):
        """Two idle unknowns lower chi squared by more than their price of 2 ln n > 8 in 2 % of tables, for any one time tried."""
        right = sum(found.terms == len(modulus.times) for found in draws(modulus, kind))
        assert right >= SEEDS - 3

    def test_standard_errors_are_those_that_are_made(self, modulus, kind):
        """Over the draws the mean squared distance is 1 per number to within 4 of its own standard deviations."""
        right = [found for found in draws(modulus, kind) if found.terms == len(modulus.times)]
        size = right[0].values.size
        mean = np.mean([distance(found, modulus) for found in right]) / size
        assert abs(mean - 1.0) < 4.0 * np.sqrt(2.0 / (size * len(right)))

    def test_nearly_all_numbers_lie_within_three_standard_errors(self, modulus, kind):
        """0.3 % of normal ones do not."""
        right = [found for found in draws(modulus, kind) if found.terms == len(modulus.times)]
        truth = {**dict(zip(right[0].names, numbers(modulus), strict=True)), "long_term": modulus.long_term}
        values = [dict(zip(f.names, f.values, strict=True)) | {"long_term": f.modulus.long_term} for f in right]
        inside = [abs(v[name] - x) < 3.0 * f.standard_errors[name] for f, v in zip(right, values, strict=True) for name, x in truth.items()]
        assert np.mean(inside) > 0.98

    def test_the_noise_is_found(self, modulus, kind):
        """A standard deviation from 50 degrees of freedom or more is known to 10 %; the mean of the draws to a sixth of that."""
        assert np.mean([found.noise for found in draws(modulus, kind)]) == pytest.approx(0.01, rel=0.05)


def test_no_bias_where_the_noise_is_large():
    """Weights by the measured numbers would pull a modulus down by the noise squared twice, here 2 %, against an error of 0.2 %."""
    found = [fit_prony(table_of(ONE, "relaxation", rows=100, noise=0.1, seed=seed), terms=1) for seed in range(SEEDS)]
    away = [(one.modulus.long_term - ONE.long_term) / one.standard_errors["long_term"] for one in found]
    assert abs(np.mean(away)) < 4.0 / np.sqrt(SEEDS)  # four standard deviations of the mean


@ONCE
def test_stated_errors_are_the_weights():
    """Numbers scatter by what is stated for each, the late ones ten times as much."""
    place = np.geomspace(0.01, 30.0, 80)
    errors = PVDF.at(place) * np.where(place > 5.0, 0.02, 0.002)
    away = []
    for seed in range(SEEDS):
        values = PVDF.at(place) + errors * np.random.default_rng(seed).standard_normal(80)
        found = fit_prony(PronyTable("relaxation", place, values, errors), terms=1)
        away.append(distance(found, PVDF) / 3.0)
        assert found.noise is None
    # errors are only ever widened, by the misfit above 1: 4 % of the variance on average with 77 degrees of freedom, so 5 deviations
    assert abs(np.mean(away) - 1.0) < 5.0 * np.sqrt(2.0 / (3 * SEEDS))


def test_noise_given_too_small_is_said_and_widens_the_errors():
    table = table_of(THREE, "relaxation", noise=0.01)
    honest, bold = fit_prony(table, 3), fit_prony(table, 3, noise=0.003)
    assert bold.misfit == pytest.approx(honest.noise * honest.misfit / 0.003)
    np.testing.assert_allclose(bold.covariance, honest.covariance, rtol=1e-9)  # both are what the differences show
    assert any("misses the table by" in doubt for doubt in doubts(bold))
    cautious = fit_prony(table, 3, noise=0.02)
    np.testing.assert_allclose(cautious.covariance, honest.covariance * (0.02 / (honest.noise * honest.misfit)) ** 2, rtol=1e-9)


def test_the_table_of_candidates_holds_its_own_formulas():
    found = fit_prony(table_of(TWO, "dynamic", noise=0.01))
    data = found.table.values.size
    for number, one in enumerate(found.candidates):
        k = 1 + 2 * number
        assert one.terms == number
        assert one.bic - one.chi_squared == pytest.approx(k * np.log(data))
        assert one.aicc - one.chi_squared == pytest.approx(2 * k * data / (data - k - 1))
    squares = [one.chi_squared for one in found.candidates]
    assert all(after <= before for before, after in zip(squares[:-1], squares[1:], strict=True))  # one term more never fits worse
    richest = found.candidates[-1]
    assert richest.chi_squared == pytest.approx(data - 1 - 2 * richest.terms, rel=0.1)  # the noise is what it leaves over


@settings(max_examples=10)
@given(st.integers(-12, 12), st.integers(-9, 9), st.sampled_from(KINDS))
def test_units_change_nothing(modulus_power, time_power, kind):
    """A table in other units gives the same fractions, and moduli and times in these units: powers of 2, so to the accuracy of the fit."""
    table = table_of(TWO, kind, noise=0.01, seed=3)
    stress, time = 4.0**modulus_power, 4.0**time_power
    place = table.place / time if kind == "dynamic" else table.place * time
    values = table.values / stress if kind == "creep" else table.values * stress
    one, other = fit_prony(table), fit_prony(replace(table, place=place, values=values))
    units = np.array([stress, 1.0, 1.0, time, time])
    np.testing.assert_allclose(other.values, one.values * units, rtol=1e-5)
    np.testing.assert_allclose(other.covariance, one.covariance * np.outer(units, units), rtol=1e-3, atol=0.0)


@settings(max_examples=25)
@given(st.lists(st.floats(1e-3, 1e3), min_size=5, max_size=25), st.sampled_from(("relaxation", "creep")))
def test_any_positive_table_gives_a_material_that_can_be(values, kind):
    """Positive moduli, a long-term one above zero, times from where they are sought: also of numbers that mean nothing."""
    found = fit_prony(PronyTable(kind, np.geomspace(0.1, 10.0, len(values)), np.array(values)))
    modulus = found.modulus
    assert modulus.instantaneous > 0.0
    assert modulus.long_term > 0.0
    assert all(fraction > 0.0 for fraction in modulus.fractions)
    assert np.isfinite(found.covariance).all()
    if kind == "relaxation":  # a retardation time is longer than a relaxation time, so those of creep may be below
        assert all(0.1 / BEYOND * (1 - 1e-9) <= time <= 10.0 * BEYOND * (1 + 1e-9) for time in modulus.times)


class TestPvdfOfThePaper:
    def table(self, noise=0.0, seed=0):
        return table_of(PVDF, "relaxation", rows=80, noise=noise, seed=seed, first=0.01, last=30.0)

    def test_a_sampled_curve_gives_its_constants(self):
        found = fit_prony(self.table())
        assert found.modulus.long_term == pytest.approx(1365.9e6, rel=1e-9)
        assert found.modulus.instantaneous - found.modulus.long_term == pytest.approx(404.6e6, rel=1e-9)
        assert found.modulus.times == pytest.approx((1.8,), rel=1e-9)
        assert list(doubts(found)) == []

    def test_constant_bulk_gives_the_shear_series(self):
        """G0 618.45 MPa, g1 .2369, tau1 1.7805 s: the paper's formulas, corrected."""
        made = fit_prony(self.table()).material(0.4314, constant_bulk=True)
        assert made.shear.instantaneous == pytest.approx(618.45e6, abs=5e3)  # the digits that are known
        assert made.shear_fractions == pytest.approx((0.2369,), abs=5e-5)
        assert made.relaxation_times == pytest.approx((1.7805,), abs=5e-5)
        assert made.bulk_fractions == (0.0,)

    def test_errors_of_the_shear_series_are_those_that_are_made(self):
        truth = uniaxial(PVDF, 0.4314, constant_bulk=True)
        away = []
        for seed in range(SEEDS):
            found = fit_prony(self.table(0.01, seed), terms=1)
            made, (fraction, time) = found.material(0.4314, True), found.shear_errors(0.4314, True)
            fraction_off = made.shear_fractions[0] - truth.shear_fractions[0]
            time_off = made.relaxation_times[0] - truth.relaxation_times[0]
            away.append((fraction_off / fraction[0], time_off / time[0]))
        # mean squares of 40 normal numbers, within four of their standard deviations
        np.testing.assert_allclose(np.mean(np.square(away), axis=0), 1.0, atol=4.0 * np.sqrt(2.0 / SEEDS))

    def test_a_shear_modulus_stays_one(self):
        found = fit_prony(replace(self.table(), shear=True))
        for constant in (False, True):
            made = found.material(0.3, constant)
            assert made.shear.instantaneous == pytest.approx(PVDF.instantaneous, rel=1e-9)
            assert made.shear_fractions == pytest.approx(PVDF.fractions, rel=1e-9)
        assert made.bulk.long_term == pytest.approx(made.bulk.instantaneous)

    def test_six_digits_are_noise_too(self):
        table = self.table()
        rounded = np.array([float(f"{value:.6g}") for value in table.values])
        found = fit_prony(replace(table, values=rounded))
        assert found.terms == 1
        # digits of 1e4 Pa are cut at random: uniform noise, known to 8 % from 77 numbers
        assert found.noise * 1.45e9 == pytest.approx(1e4 / np.sqrt(12.0), rel=0.35)


class TestWarnings:
    """Each where it should, and in no table that tells everything."""

    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("modulus", [ONE, TWO], ids=["one", "two"])
    def test_none_where_all_is_seen(self, modulus, kind):
        assert list(doubts(fit_prony(table_of(modulus, kind, noise=0.01, first=1e-4, last=1e4)))) == []

    @pytest.mark.parametrize("kind", KINDS)
    def test_a_time_beyond_the_end(self, kind):
        found = fit_prony(table_of(Relaxation(2e9, (0.8,), (30.0,)), kind, noise=0.001, first=0.01, last=10.0))
        said = " | ".join(doubts(found))
        assert "lies outside the 0.01 to 10 s that the table can see" in said
        assert "not seen to level off" in said

    @pytest.mark.parametrize("kind", KINDS)
    def test_a_time_before_the_beginning(self, kind):
        found = fit_prony(table_of(Relaxation(2e9, (0.8,), (0.008,)), kind, noise=0.001, first=0.02, last=10.0))
        said = " | ".join(doubts(found))
        assert "lies outside the 0.02 to 10 s that the table can see" in said
        assert "the instantaneous modulus is an extrapolation" in said

    def test_times_that_are_too_close(self):
        found = fit_prony(table_of(Relaxation(2e9, (0.3, 0.3), (1.0, 1.5)), "relaxation"), terms=2, noise=0.01)
        assert any("cannot be told apart" in doubt for doubt in doubts(found))
        assert any("hardly determined" in doubt for doubt in doubts(found))

    def test_a_fluid(self):
        found = fit_prony(table_of(Relaxation(2e9, (1.0 - 1e-12,), (1.0,)), "dynamic", noise=0.01))
        assert any("this may be a fluid" in doubt for doubt in doubts(found))

    def test_terms_that_have_no_weight(self):
        found = fit_prony(table_of(ONE, "relaxation"), terms=4)
        assert found.terms < 4
        assert any("of the 4 terms asked for" in doubt for doubt in doubts(found))

    def test_too_few_terms(self):
        found = fit_prony(table_of(THREE, "dynamic", noise=0.01), terms=1)
        assert min(found.candidates, key=lambda one: one.bic).terms == 3  # they are tried all the same
        assert any("misses the table by" in doubt for doubt in doubts(found))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"terms": 29}, "terms = 29: must lie between 0 and 20"),
        ({"terms": -1}, "terms = -1"),
        ({"noise": 0.0}, "noise = 0.0: must lie between 0 and 1"),
        ({"noise": float("nan")}, "noise = nan"),
    ],
)
def test_options_that_cannot_be(options, said):
    with pytest.raises(InputError, match=said):
        fit_prony(table_of(ONE, "relaxation"), **options)


def test_what_is_not_positive_needs_an_error():
    elastic = table_of(Relaxation(2e9), "dynamic")
    with pytest.raises(InputError, match=r"values\[61\] = 0.0: must be positive"):
        fit_prony(elastic)
    assert fit_prony(replace(elastic, errors=np.full(120, 1e7))).terms == 0


def test_noise_is_stated_once():
    table = table_of(ONE, "relaxation")
    with pytest.raises(InputError, match=r"noise = 0\.01: contradicts the table"):
        fit_prony(replace(table, errors=0.01 * table.values), noise=0.01)
