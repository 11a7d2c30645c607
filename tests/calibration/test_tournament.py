"""The tournament on curves made from laws: who made a curve wins it, whoever cannot be fitted says why."""

from __future__ import annotations

import math

import numpy as np
import pytest

from calibration import fit
from calibration.tournament import (
    SCORED,
    Score,
    cheapest_law,
    elastic_companion,
    measurements,
    play,
    seen,
    standings,
    training,
    up_to,
    work_of_loading,
)
from calibration.tournament_entrants import ENTRANTS, Entrant, entrants
from contactlaws.curve import Curve
from contactlaws.elastoplastic import Thornton
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.rivals.luding import Luding
from contactlaws.rivals.mdr import mdr_of
from contactlaws.rivals.walton_braun import WaltonBraun
from contactlaws.whole_range import whole_range
from tests.contactlaws.samples import curve_of

MATERIAL = Material(100.0, 0.3, 1.0)
DEPTHS = (0.02, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0)
BY_NAME = {entrant.name: entrant for entrant in ENTRANTS}


@pytest.fixture(scope="module")
def thorntons() -> Curve:
    law = Thornton(1.0, MATERIAL.reduced_modulus, 2.2)
    return curve_of(law, 0.3, DEPTHS, MATERIAL, rows=200, yield_overlap=(math.pi * 2.2 / (2.0 * law.reduced_modulus)) ** 2)


def test_the_law_that_made_the_curve_wins(thorntons: Curve):
    played = play([thorntons], [BY_NAME["Hertz"], BY_NAME["Thornton"], BY_NAME["Luding"]])
    table = standings(played.scores, ["Hertz", "Thornton", "Luding"])
    for quantity in SCORED:
        found = table["Thornton", quantity].percentiles
        assert found is not None
        # energies of the curve are integrals through 200 rows; all else is known to the fit's own tolerance
        assert found[-1] < (2e-3 if quantity in ("recovered_energy", "restitution") else 1e-5)
    hertz = table["Hertz", "force"].percentiles
    assert hertz is not None
    assert hertz[0] > 0.1
    assert table["Luding", "contact_radius"].percentiles is None


def test_hertz_is_scored_as_simple_arithmetic_says(thorntons: Curve):
    """A Hertzian body gives back all of its overlap and its energy."""
    played = play([thorntons], [BY_NAME["Hertz"]])
    for score, one in zip(played.scores, measurements(thorntons), strict=True):
        top = one.unloading.overlap
        assert score.force == pytest.approx(4.0 / 3.0 * MATERIAL.reduced_modulus * top**1.5 / one.unloading.force - 1.0, rel=1e-12)
        assert score.residual_overlap == pytest.approx(-one.unloading.separation_overlap, abs=1e-6)  # seen at 1e-9 of the force
        assert score.restitution == pytest.approx(1.0 - one.restitution, abs=1e-12)


def test_half_of_the_unloadings_are_kept_for_scoring(thorntons: Curve):
    taken = training(thorntons)
    assert len(taken.unloadings) == 4
    deepest = [thorntons.overlap[thorntons.rows(branch)][0] for branch in seen(thorntons)]
    assert max(deepest) == thorntons.overlap.max()
    assert taken.overlap[taken.rows(0)][0] >= min(thorntons.overlap[thorntons.rows(branch)][0] for branch in thorntons.unloadings) * 0.999
    played = play([thorntons], [BY_NAME["Hertz"]])
    assert sum(score.unseen for score in played.scores) == 4


def test_a_curve_is_cut_at_an_overlap(thorntons: Curve):
    cut = up_to(thorntons, 0.13)
    assert cut.overlap.max() <= 0.13
    assert [round(float(cut.overlap[cut.rows(k)][0]), 3) for k in cut.unloadings] == sorted(
        round(float(d), 3) for k in thorntons.unloadings if (d := thorntons.overlap[thorntons.rows(k)][0]) <= 0.13
    )


def test_a_law_that_cannot_be_fitted_is_a_result_with_its_reason(thorntons: Curve):
    """A curve of unknown material: nothing gives Poisson's ratio to Kogut & Etsion."""
    nameless = Curve(**{name: getattr(thorntons, name) for name in ("time", "overlap", "force", "branch", "radius", "contact_radius")})
    played = play([nameless], [BY_NAME["Kogut–Etsion"], BY_NAME["Walton–Braun"]])
    reasons = {one.entrant: one.reason for one in played.fits}
    assert "poissons_ratio" in (reasons["Kogut–Etsion"] or "")
    assert reasons["Walton–Braun"] is None
    assert {score.entrant for score in played.scores} == {"Walton–Braun"}


def test_curves_without_unloadings_are_refused():
    loading = curve_of(Thornton(1.0, 100.0, 2.0), 0.1, ())
    with pytest.raises(InputError, match="no unloading"):
        play([loading], [BY_NAME["Hertz"]])


def test_unknown_laws_are_named():
    with pytest.raises(InputError, match="mdrr"):
        entrants(["mdr", "mdrr"])
    assert [entrant.name for entrant in entrants(["luding"])] == ["Luding"]


def test_any_registered_law_with_a_recipe_enters():
    fittable = {entrant.law for entrant in entrants()}
    assert {"hertz", "thornton", "kogut_etsion", "etsion", "jackson_green", "walton_braun", "luding", "eepa"} <= fittable
    assert {"becker_kamlah", "mdr", "edmans_sinka", "tabulated", "whole_range"} <= fittable
    assert [entrant.how for entrant in entrants(["hertz_finite_size"])] == ["as its recipe says, to the whole curve"]


@pytest.mark.parametrize(
    "law",
    [WaltonBraun(1.0, 9.0, 3.0, 20.0), Luding(1.0, 9.0, 30.0, 0.3)],
    ids=["walton_braun", "luding"],
)
def test_constants_are_found_again(law: WaltonBraun | Luding):
    name = "walton_braun" if isinstance(law, WaltonBraun) else "luding"
    found = fit(curve_of(law, 0.5, DEPTHS, MATERIAL), name).law
    np.testing.assert_allclose(found, law, rtol=1e-4)  # the least squares stop at 1e-12 of squares


def test_mdr_follows_from_the_material_and_its_strength_is_found_again():
    law = mdr_of(1.0, 100.0, 0.3, 1.0)
    curve = curve_of(law, 0.4, DEPTHS, MATERIAL)
    assert fit(curve, "mdr").law == law
    found = fit(curve, "mdr", fixed={"yield_stress": 1.2}).law
    assert found.yield_stress == 1.2
    assert fit(curve, "mdr", free=("yield_stress",)).law.yield_stress == pytest.approx(1.0, rel=1e-6)


def test_the_whole_range_law_follows_from_the_material():
    law = whole_range(MATERIAL, 1.0)
    assert fit(curve_of(law, 0.4, DEPTHS, MATERIAL), "whole_range").law == law


def test_work_of_a_loading_is_its_integral(thorntons: Curve):
    """Hertz up to first yield, then Thornton's line; 200 rows in logarithmic steps leave 1e-5."""
    law = Thornton(1.0, MATERIAL.reduced_modulus, 2.2)
    limit = (math.pi * 2.2 / (2.0 * law.reduced_modulus)) ** 2
    at_yield = 4.0 / 3.0 * law.reduced_modulus * limit**1.5
    exact = 0.4 * at_yield * limit + at_yield * (0.3 - limit) + 0.5 * math.pi * 2.2 * (0.3 - limit) ** 2
    assert work_of_loading(thorntons)(0.3) == pytest.approx(exact, rel=1e-4)


def test_elasticity_is_lent_by_the_body_that_yields_last(thorntons: Curve):
    """Forces go with the modulus, at the same overlap over radius."""
    soft = Material(2.0, 0.3, 1.0)
    law = Thornton(2.0, soft.reduced_modulus, 2.2)
    lender = curve_of(law, 0.4, (1.0,), soft, yield_overlap=0.3)
    lent = elastic_companion(thorntons, [thorntons, lender])
    assert lent is not None
    assert lent.material == MATERIAL.elastic
    assert 0.1 < lent.overlap.max() <= 0.15
    expected = 4.0 / 3.0 * MATERIAL.reduced_modulus * lent.overlap**1.5
    np.testing.assert_allclose(lent.force[1:], expected[1:], rtol=1e-12)


def score(entrant: str, error: float | None, depth: float) -> Score:
    """A score of the force alone."""
    return Score(entrant, entrant, "c", 100.0, 0.3, depth, True, True, True, error, *(None,) * 6)


def test_a_tolerance_chooses_the_cheapest_law_that_keeps_it():
    scores = [score("fast", 0.05, 0.1), score("fast", -0.3, 0.5), score("slow", 0.01, 0.1), score("slow", -0.02, 0.5)]
    cost = {"fast": 10.0, "slow": 40.0}
    assert cheapest_law(0.1, "force", scores, cost).entrant == "slow"
    assert cheapest_law(0.1, "force", scores, cost, largest_overlap=0.2).entrant == "fast"
    assert cheapest_law(0.5, "force", scores, cost) == ("fast", 0.3, 10.0)
    with pytest.raises(InputError, match=r"slow, is at 0\.02"):
        cheapest_law(0.001, "force", scores, cost)
    with pytest.raises(InputError, match="must be one of force"):
        cheapest_law(0.1, "colour", scores, cost)


def test_a_law_that_does_not_say_is_never_good_enough():
    scores = [score("silent", None, 0.1), score("good", 0.01, 0.1)]
    assert cheapest_law(0.1, "force", scores, {"silent": 1.0, "good": 9.0}).entrant == "good"


def test_who_claims_what(thorntons: Curve):
    """Kogut & Etsion up to 110 times the critical overlap: at E/Y = 100 that is 0.057 of the radius."""
    played = play([thorntons], [BY_NAME["Kogut–Etsion"], Entrant("anywhere", "hertz", "")])
    claimed = {s.overlap_over_radius for s in played.scores if s.entrant == "Kogut–Etsion" and s.inside}
    limit = 110.0 * (math.pi * 2.8 * (0.454 + 0.41 * 0.3) / (2.0 * MATERIAL.reduced_modulus)) ** 2
    assert claimed == {s.overlap_over_radius for s in played.scores if s.overlap_over_radius <= limit}
    assert all(s.inside for s in played.scores if s.entrant == "anywhere")
