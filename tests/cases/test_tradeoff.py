"""What a tolerance promises holds on materials that it was not set by; elements converge as they should; what cannot be kept is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import calibration
import fem
from calibration import law_choice
from cases.command import execute
from cases.tradeoff import elements, kept
from cases.tradeoff.fe_errors import Choice, Verdict
from cases.tradeoff.fe_settings import MATERIALS, plans, usual
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.path import scan
from fem.press import RESOLUTIONS, Resolution

UNSEEN = Path(__file__).parents[1] / "calibration" / "unseen"
#: E/Y and Poisson's ratio of materials that no resolution was chosen on
STRANGE = ((27.0, 0.21), (340.0, 0.37), (4.3, 0.12))


@pytest.mark.compiled_only("presses six bodies")
@pytest.mark.parametrize(("ratio", "nu"), STRANGE)
def test_the_promised_tolerance_holds_against_four_times_the_elements(ratio, nu):
    """1 % in the mean force, on the largest nine tenths of the loading; the reference is a run with twice the divisions."""
    assert (ratio, nu) not in MATERIALS
    material, largest = Material(ratio, nu, 1.0), 0.01
    curve, finer = (fem.press(material, max_overlap=largest, tolerance=tolerance) for tolerance in (0.01, 0.0025))
    assert finer.provenance["elements"] >= 4 * curve.provenance["elements"]
    at = np.log(np.geomspace(0.1 * largest, largest, 30))
    one, two = (CubicSpline(np.log(c.overlap[1:]), np.log(c.force[1:]))(at) for c in (curve, finer))
    assert np.exp(abs(one - two)).mean() - 1.0 <= 0.01


@pytest.mark.parametrize("name", ["E1.5_nu0.4", "E70_nu0.2", "E300_nu0.4"])
@pytest.mark.parametrize("tolerance", [0.05, 0.02])
def test_the_chosen_law_keeps_its_promise_on_a_curve_of_an_unseen_material(name, tolerance):
    """The law is made from the material's constants alone and compared with finite elements of that very material."""
    curve = read_curve(UNSEEN / f"{name}.parquet")
    starts = np.array([curve.overlap[curve.rows(branch)][0] for branch in curve.unloadings])
    forces = np.array([curve.force[curve.rows(branch)][0] for branch in curve.unloadings])
    largest = 0.1 * curve.radius * (1.0 + 1e-9)
    assert (starts <= largest).sum() >= 2
    known = law_choice.candidates("force", curve.material, 0.1)
    law = law_choice.good_enough(known, tolerance, "force")[0].law
    found = calibration.predict(curve.material, radius=curve.radius, max_overlap=0.1, law=law)
    error = scan(found.law.law, starts[starts <= largest]).force / forces[starts <= largest] - 1.0
    assert abs(error).max() <= tolerance


def test_a_looser_tolerance_never_costs_more():
    known = law_choice.candidates("force", Material(27.0, 0.21, 1.0), 0.1)
    costs = [law_choice.good_enough(known, tolerance, "force")[0].nanoseconds for tolerance in (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)]
    assert costs == sorted(costs)


def test_errors_grow_with_the_overlap_that_counts():
    """They are the worst up to it."""
    material = Material(27.0, 0.21, 1.0)
    shallow, deep = (law_choice.candidates("recovered_energy", material, overlap) for overlap in (0.05, 0.5))
    assert all(one.error <= two.error for one, two in zip(shallow, deep, strict=True))


@pytest.mark.parametrize(
    ("quantity", "material", "overlap", "named"),
    [
        ("colour", Material(27.0, 0.2, 1.0), 0.1, "quantity"),
        ("force", Material(27.0, 0.2), 0.1, "yield_stress"),
        ("force", Material(0.1, 0.2, 1.0), 0.1, "E/Y"),
        ("force", Material(27.0, 0.2, 1.0), 0.9, "largest overlap"),
    ],
)
def test_laws_are_not_chosen_where_none_was_scored(quantity, material, overlap, named):
    with pytest.raises(InputError) as caught:
        law_choice.candidates(quantity, material, overlap)
    assert [problem.name for problem in caught.value.problems] == [named]


def test_a_damaged_table_of_scores_is_refused(tmp_path):
    (tmp_path / "scores.parquet").write_bytes(b"PAR1 nothing")
    with pytest.raises(InputError, match="cannot be read"):
        law_choice.shipped(tmp_path / "scores.parquet")


@pytest.mark.compiled_only("fits laws")
def test_fit_takes_the_cheapest_law_within_the_tolerance(tmp_path, capsys):
    curve, law = str(UNSEEN / "E70_nu0.2.parquet"), tmp_path / "law.json"
    assert execute(["fit", curve, "--tolerance", "50 %", "--out", str(law)]) == 0
    shown = capsys.readouterr().out
    assert "taken" in shown
    cheapest = min(law_choice.shipped().nanoseconds.items(), key=lambda item: item[1])[0]
    assert cheapest in shown
    assert json.loads(law.read_text())


def test_what_no_law_keeps_is_refused_and_names_the_best(tmp_path, capsys):
    options = ["--youngs-modulus", "27", "--poissons-ratio", "0.2", "--yield-stress", "1", "--max-overlap", "0.1"]
    options += ["--quantity", "recovered_energy", "--tolerance", "1e-6", "--out", str(tmp_path / "law.json")]
    assert execute(["predict", *options]) == 2
    assert "the best, " in capsys.readouterr().err
    assert not (tmp_path / "law.json").exists()


@pytest.mark.parametrize("text", ["5", "-1", "half", "1e-9"])
def test_a_tolerance_that_is_not_on_offer_is_refused_before_anything_runs(text, tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text(
        "[materials.m]\nyoungs_modulus = 100\npoissons_ratio = 0.3\nyield_stress = 1\n"
        '[curves.c]\nmaterial = "m"\nradius = 1\nmax_overlap = 0.01\n'
    )
    assert execute(["run", str(case), "--tolerance", text, "--out", str(tmp_path / "out")]) == 2
    assert "tolerance" in capsys.readouterr().err
    assert not (tmp_path / "out" / "curves").exists()


def test_elements_converge_to_hertz_with_the_square_of_their_size():
    """Both bilinear elements where nothing locks; order 2 within 0.3, the coarser mesh not being quite in the asymptotic range."""
    for name in ("bilinear, full integration", "bilinear, mean dilatation"):
        coarse, fine = (elements.measure(name, 0.3, divisions).error for divisions in (4, 8))
        assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.3)


def test_mean_dilatation_does_not_lock_and_full_integration_does():
    """At nu = 0.4999: as good as at 0.3 within a half, against several times the force."""
    name = "bilinear, mean dilatation"
    assert elements.measure(name, 0.4999, 4).error < 1.5 * elements.measure(name, 0.3, 4).error
    assert elements.measure("bilinear, full integration", 0.4999, 4).error > 1.0


def test_forces_between_body_and_flat_never_pull_and_gaps_never_overlap():
    """One node of unit compliance that is touched, one that is out of reach."""
    assert elements.press(np.eye(2), np.array([0.0, 5.0]), 2.0) == pytest.approx(2.0, rel=1e-12)


def test_a_verdict_names_the_cheaper_choice_and_the_broken_promise():
    level, other = RESOLUTIONS[0][1], Resolution(6, usual())
    own, cheap = Choice("level", level, 0.002, 2.0), Choice("6", other, 0.004, 1.0)
    assert "6 divisions" in Verdict(0.01, level, own, cheap).words
    assert "nothing measured here keeps it for clearly less" in Verdict(0.01, level, own, own).words
    assert Verdict(0.001, level, own, None).words.startswith("broken")
    assert Verdict(0.001, level, None, None).words.startswith("not measured")


def test_no_run_is_planned_twice_and_none_is_finer_than_the_finest():
    for plan in (*plans(True), *plans(False)):
        resolutions = [setting.resolution for setting in plan.settings]
        assert len(resolutions) == len(set(resolutions))
        assert max(resolution.divisions for resolution in resolutions) < plan.finest.resolution.divisions


def test_a_result_is_made_once_and_again_if_its_file_is_torn(tmp_path):
    made = []

    def make():
        made.append(1)
        return [1.5]

    values = (tmp_path, elements.__name__, ("a", 1))
    assert kept.kept(*values, make) == kept.kept(*values, make) == [1.5]
    assert len(made) == 1
    kept.place(tmp_path, elements.__name__, "a", 1).write_text("[1.")
    assert kept.kept(*values, make) == [1.5]
    assert len(made) == 2
