"""The tournament and the trade of laws from the command line, on curves made from laws."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from calibration.tournament import SCORED
from cases.command import execute
from cases.tournament.cost import costs
from cases.tournament.run import curves_in, read_scores
from contactlaws.curve_files import write_curve
from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from contactlaws.errors import InputError
from contactlaws.material import Material
from tests.contactlaws.samples import curve_of

DEPTHS = (0.05, 0.1, 0.2, 0.4, 0.7, 1.0)


def thorntons(stiffness: float, nu: float = 0.3):
    """What Thornton's law makes of a material."""
    material = Material(stiffness, nu, 1.0)
    law = Thornton(1.0, material.reduced_modulus, 2.2)
    limit = (math.pi * 2.2 / (2.0 * law.reduced_modulus)) ** 2
    return curve_of(law, 0.3, DEPTHS, material, yield_overlap=limit)


@pytest.fixture(scope="module")
def curves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("curves")
    for stiffness in (50.0, 100.0):
        write_curve(thorntons(stiffness), folder / f"E{stiffness:g}.parquet")
    return folder


@pytest.fixture(scope="module")
def played(curves: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("tournament")
    assert execute(["tournament", str(curves), "--laws", "hertz", "thornton", "--out", str(out)]) == 0
    return out


def test_writes_every_score_and_standing(played: Path):
    scores, nanoseconds = read_scores(played)
    assert len(scores) == 2 * 2 * len(DEPTHS)
    assert set(nanoseconds) == {"Hertz", "Thornton"}
    with (played / "standings.csv").open(encoding="utf-8") as file:
        rows = {row["entrant"]: row for row in csv.DictReader(file)}
    assert float(rows["Thornton"]["all_force_100"]) < 1e-5  # it made the curves; the fit stops there
    assert float(rows["Hertz"]["all_force_50"]) > 0.1
    assert rows["Thornton"]["constants_per_material"] == "1"
    assert {f"unseen_{name}_points" for name in SCORED} <= set(rows["Hertz"])


def test_the_page_stands_alone(played: Path):
    text = (played / "report.html").read_text(encoding="utf-8")
    assert "http://" not in text.replace("http://www.w3.org", "").replace("http://purl.org", "").replace("http://creativecommons.org", "")
    assert "https://" not in text
    assert "<script" not in text
    assert "Thornton" in text
    assert text.count("<svg") == 4
    assert all((played / f"{name}.png").stat().st_size > 10_000 for name in ("scores", "materials", "curves", "tradeoff"))


def test_a_tolerance_names_the_cheapest_law_that_keeps_it(played: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    picture = tmp_path / "trade.png"
    arguments = ["tradeoff", "law", str(played), "--quantity", "force", "--tolerance", "0.001", "--out", str(picture)]
    assert execute(arguments) == 0
    said = capsys.readouterr().out
    assert "within 0.001 in force at worst: Thornton" in said
    assert picture.stat().st_size > 10_000


def test_a_tolerance_that_no_law_keeps_is_refused(played: Path, capsys: pytest.CaptureFixture[str]):
    assert execute(["tradeoff", "law", str(played), "--quantity", "recovered_energy", "--tolerance", "1e-12"]) == 2
    assert "the best, Thornton" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["tournament", "nowhere"], "is no folder"),
        (["tournament", "."], "holds no curve"),
        (["tournament", ".", "--laws", "hertz", "mdrr"], "mdrr"),
        (["tradeoff", "law", "."], "cannot be read"),
        (["tradeoff", "law", ".", "--quantity", "colour", "--tolerance", "-1", "--max-overlap", "0"], "colour"),
    ],
)
def test_bad_input_is_named(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert execute(arguments) == 2
    assert said in capsys.readouterr().err


def test_all_problems_of_a_trade_are_named_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert execute(["tradeoff", "law", str(tmp_path), "--quantity", "colour", "--tolerance", "-1", "--max-overlap", "0"]) == 2
    said = capsys.readouterr().err
    assert all(name in said for name in ("--quantity", "--tolerance", "--max-overlap"))


def test_a_law_that_fails_on_a_curve_is_told_and_the_rest_goes_on(tmp_path: Path):
    """Poisson's ratio of a curve without a material is known to nobody."""
    mixed = tmp_path / "mixed"
    mixed.mkdir()
    unknown = curve_of(Thornton(1.0, 100.0, 2.0), 0.3, DEPTHS)
    write_curve(unknown, mixed / "unknown.parquet")
    out = tmp_path / "out"
    assert execute(["tournament", str(mixed), "--laws", "kogut_etsion", "thornton", "--out", str(out)]) == 3
    assert "poissons_ratio" in (out / "report.html").read_text(encoding="utf-8")
    scores, _ = read_scores(out)
    assert {score.entrant for score in scores} == {"Thornton"}


def test_files_that_are_no_curves_are_told_and_the_rest_goes_on(tmp_path: Path):
    write_curve(thorntons(100.0), tmp_path / "a.parquet")
    (tmp_path / "b.csv").write_text("colour,taste\nred,sweet\n")
    curves, refused = curves_in(tmp_path)
    assert len(curves) == 1
    assert any("b.csv" in problem.name for problem in refused)


def test_other_folders_are_no_tournament(tmp_path: Path):
    with pytest.raises(InputError, match="cannot be read"):
        read_scores(tmp_path)


def test_costs_are_those_of_contacts_that_press():
    """All pairs of the lattice are in contact while timed, or nothing would be measured."""
    found = costs({"Hertz": Hertz(1.0, 100.0), "Thornton": Thornton(2.0, 100.0, 2.0)}, edge=4, repeats=1)
    values = np.array(list(found.values()))
    assert np.isfinite(values).all()
    assert (values > 0.0).all()
