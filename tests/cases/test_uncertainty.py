"""Bands and shares: the variance of a two-way layout, and a scene whose stress is in proportion to its law's one parameter."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from cases.command import BAD_INPUT, execute
from cases.report import history
from cases.uncertainty.page import SIDES
from cases.uncertainty.variance import LEVEL, taken_apart
from contactlaws import fitted

LAWS, PACKINGS = 6, 5
CASE = """
[materials.unknown]
youngs_modulus = "1 GPa"
poissons_ratio = 0.3
[fits.law]
law = "hertz"
curves = ["measured.csv"]
radius = "1 mm"
[scenes.pressed]
fit = "law"
radius = "1 mm"
density = "1000 kg/m^3"
count = 20
packing_fraction = 0.64
strain = 0.05
release = false
inertial_number = 1e-3
"""


def layout(chance: np.random.Generator, deviations: tuple[float, float, float], columns: int) -> np.ndarray:
    """Values with normal effects of laws, packings and rest."""
    law, packing, rest = deviations
    return np.asarray(
        10.0
        + law * chance.standard_normal((LAWS, 1, columns))
        + packing * chance.standard_normal((1, PACKINGS, columns))
        + rest * chance.standard_normal((LAWS, PACKINGS, columns))
    )


def test_variances_are_unbiased_and_intervals_hold_what_they_say() -> None:
    """600 layouts: a mean variance is known to 3 % (one has a deviation of .75 of itself at five packings), a share of intervals to .012;
    three of each are allowed. Intervals of variance components are not exact: .02 more.
    """
    deviations, many = (2.0, 1.0, 0.5), 600
    found = taken_apart(layout(np.random.default_rng(1), deviations, many))
    for part, deviation in enumerate(deviations):
        assert found.variance[part].mean() == pytest.approx(deviation**2, rel=0.09)
        inside = ((found.low[part] <= deviation**2) & (deviation**2 <= found.high[part])).mean()
        assert inside == pytest.approx(LEVEL, abs=0.056)
    whole = sum(deviation**2 for deviation in deviations)
    inside = ((found.share_low[0] <= deviations[0] ** 2 / whole) & (deviations[0] ** 2 / whole <= found.share_high[0])).mean()
    assert inside == pytest.approx(LEVEL, abs=0.056)
    assert (abs(found.mean - 10.0) < 2.0 * found.mean_error).mean() > 0.8  # fewer than .95: five packings say little of their variance


def test_what_does_not_vary_has_no_share() -> None:
    """And nothing has one where nothing varies."""
    values = layout(np.random.default_rng(2), (0.0, 1.0, 0.0), 4)
    found = taken_apart(values)
    assert found.deviation[0] == pytest.approx(0.0, abs=1e-6)  # the root of round-off in the squares of values of 10
    assert found.share[1] == pytest.approx(1.0, abs=1e-12)
    assert np.isnan(taken_apart(np.ones((3, 3, 2))).share).all()
    assert (taken_apart(np.ones((3, 3, 2))).whole == 0.0).all()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case whose curve was measured with an error of 3 %, and its propagation over three laws and two packings."""
    folder = tmp_path_factory.mktemp("uncertainty")
    overlap = np.linspace(0.0, 1e-4, 60)
    force = 4.0 / 3.0 * 1.1e9 * np.sqrt(1e-3) * overlap**1.5 * (1.0 + 0.03 * np.sin(9.0 * np.arange(60.0)))
    rows = "\n".join(f"{x!r},{y!r}" for x, y in zip(overlap.tolist(), force.tolist(), strict=True))
    (folder / "measured.csv").write_text(f"overlap,force\n{rows}\n")
    (folder / "case.toml").write_text(CASE)
    assert execute(["uncertainty", str(folder / "case.toml"), *SIZE, "--out", str(folder / "out")]) == 0
    return folder


SIZE = ("--draws", "3", "--packings", "2", "--jobs", "1")


@pytest.mark.compiled_only(reason="six scenes of 20 spheres take minutes interpreted")
def test_stress_in_proportion_to_the_modulus_has_its_variance(place: Path) -> None:
    """Without another stiffness in the scene, all stresses are in proportion to the modulus, so relative deviations are the same.

    A scene of another stiffness is the same one in other units, so only round-off and how it grows in a packing are between: 1e-6.
    """
    out = place / "out"
    moduli = [fitted.load(path).law.reduced_modulus for path in sorted((out / "draws").glob("*.json"))]
    runs = {path.name[:3]: history.read(path)["stress_zz"] for path in (out / "scenes").glob("*.parquet")}
    for packing in (1, 2):
        stress = np.array([runs[f"{law}-{packing}"][-1] for law in (1, 2, 3)])
        assert stress / stress.mean() == pytest.approx(np.array(moduli) / np.mean(moduli), rel=1e-6)
    with (out / "uncertainty.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    # each packing's stress times the modulus: the means of laws vary as the modulus does, and half of the rest is to be taken off
    of_law = float(last["stress_Pa"]) * np.std(moduli, ddof=1) / np.mean(moduli)
    assert float(last["law_deviation_Pa"]) ** 2 == pytest.approx(of_law**2 - float(last["rest_deviation_Pa"]) ** 2 / 2.0, rel=1e-5)
    whole = sum(float(last[f"{part}_deviation_Pa"]) ** 2 for part in ("law", "packing", "rest")) ** 0.5
    assert float(last["band_high_Pa"]) == pytest.approx(float(last["stress_Pa"]) + SIDES * whole, rel=1e-12)


@pytest.mark.compiled_only(reason="six scenes of 20 spheres take minutes interpreted")
def test_more_draws_leave_what_is_there(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = str(place / "out")
    assert execute(["uncertainty", str(place / "case.toml"), *SIZE, "--out", out]) == 0
    assert "12 results: 12 reused, 0 computed" in capfd.readouterr().out
    assert execute(["uncertainty", str(place / "case.toml"), "--draws", "4", *SIZE[2:], "--out", out]) == 0
    assert "15 results: 12 reused, 3 computed" in capfd.readouterr().out
    assert (place / "out" / "uncertainty.html").read_text().count("<svg") == 1
    assert (place / "out" / "uncertainty.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (("", ""), ("--draws", "1"), "--draws = 1: must be at least 2"),
        (("", ""), ("--scene", "presed"), "did you mean 'pressed'?"),
        (('fit = "law"', 'fit = "law.json"'), (), "does not say how its errors hang together"),
        (("[scenes.pressed]", "[impacts.pressed]\nspeed = [1]"), (), "declares none"),
    ],
)
def test_what_cannot_be_propagated_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], options: tuple[str, ...], words: str
) -> None:
    text = CASE.replace(*change)
    if "impacts" in text:
        text = text[: text.index("count =")]
    (tmp_path / "case.toml").write_text(text)
    (tmp_path / "measured.csv").write_text("overlap,force\n" + "".join(f"{x}e-6,{x**1.5}\n" for x in range(9)))
    law = {"format": "fe2dem fitted law 1", "law": "hertz", "parameters": {"radius": 1e-3, "reduced_modulus": 1e9}, "material": None}
    law |= {"max_overlap": 1e-4, "curve_hashes": [], "code_version": "", "standard_errors": {}}
    (tmp_path / "law.json").write_text(json.dumps(law))
    assert execute(["uncertainty", str(tmp_path / "case.toml"), *options, "--out", str(tmp_path / "out")]) == BAD_INPUT
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
