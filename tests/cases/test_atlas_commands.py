"""`fe2dem predict` and `fe2dem identify`: what they write, and that what cannot be used is said at once with exit code 2."""

import json
from dataclasses import replace

import numpy as np
import pytest

from calibration import predict
from cases.command import BAD_INPUT, FAILED, execute
from contactlaws import fitted
from contactlaws.curve_files import read_curve
from contactlaws.material import Material

STEEL = ["--youngs-modulus", "210 GPa", "--poissons-ratio", "0.3", "--yield-stress", "700 MPa", "--radius", "1 mm"]


def test_predict_writes_the_law_or_the_curve_that_its_ending_asks_for(tmp_path, capsys):
    assert execute(["predict", *STEEL, "--unload-from", "0.02", "0.05", "--out", str(tmp_path / "law.json")]) == 0
    assert execute(["predict", *STEEL, "--unload-from", "0.02", "0.05", "--out", str(tmp_path / "curve.parquet")]) == 0
    law, curve = fitted.load(tmp_path / "law.json"), read_curve(tmp_path / "curve.parquet")
    assert law.origin["source"] == "atlas"
    assert law.curve_hashes == (curve.content_hash,)
    assert len(curve.unloadings) == 2
    assert "recovered energy" in capsys.readouterr().out


def test_predict_names_every_bad_option_at_once(tmp_path, capsys):
    options = ["--youngs-modulus", "5 m", "--poissons-ratio", "0.7", "--out", str(tmp_path / "law.txt")]
    assert execute(["predict", *options]) == BAD_INPUT
    said = capsys.readouterr().err
    for name in ("--youngs-modulus", "--poissons-ratio", "--yield-stress", "--out"):
        assert name in said
    assert execute(["predict", *STEEL[:5], "1 MPa", "--out", str(tmp_path / "law.json")]) == BAD_INPUT
    assert "--compute" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def measured(tmp_path):
    """A curve of the atlas itself with a little noise, as a machine would write it."""
    curve = predict(Material(210e9, 0.3, 700e6), radius=1e-3, unload_from=[0.05]).curve
    loading, back = curve.rows(0), curve.rows(1)
    places = np.linspace(2e-6, 5e-5, 25)
    force = np.interp(places, curve.overlap[loading], curve.force[loading])
    overlap = np.concatenate((places, curve.overlap[back][2:-2:2]))
    force = np.concatenate((force, curve.force[back][2:-2:2]))
    force += 0.005 * force.max() * np.random.default_rng(0).standard_normal(force.size)
    path = tmp_path / "measured.csv"
    rows = "".join(f"{d!r},{f!r}\n" for d, f in zip(overlap.tolist(), force.tolist(), strict=True))
    path.write_text("# radius: 1e-3\noverlap,force\n" + rows)
    return path


def test_identify_writes_numbers_profiles_and_a_picture(measured, tmp_path, capsys):
    out = tmp_path / "found"
    assert execute(["identify", str(measured), "--poissons-ratio", "0.3", "--out", str(out)]) == 0
    found = json.loads((out / "identified.json").read_text())
    assert found["code_version"].startswith("fe2dem")
    assert len(found["measured"]) == len(found["atlas"]) == 16
    low, high = found["intervals_95_percent"]["youngs_modulus"]
    assert low < 210e9 < high
    assert (out / "identified.png").read_bytes().startswith(b"\x89PNG")
    assert (out / "profiles.csv").read_text().startswith("unknown,value,deviance\nyoungs_modulus,")
    assert "the yield stress" in capsys.readouterr().out


def test_identify_names_every_bad_option_at_once(measured, tmp_path, capsys):
    assert execute(["identify", str(measured), "--radius", "2 mm", "--poissons-ratio", "0.4..0.2", "--noise", "1 m"]) == BAD_INPUT
    said = capsys.readouterr().err
    for name in ("--radius", "--poissons-ratio", "--noise", "--out"):
        assert name in said
    broken = tmp_path / "broken.csv"
    broken.write_text(measured.read_text().replace("overlap,force", "overlap,load"))
    assert execute(["identify", str(broken), "--poissons-ratio", "0.3", "--out", str(tmp_path / "found")]) == BAD_INPUT
    assert "name the columns" in capsys.readouterr().err


def test_a_run_that_stops_early_says_so(tmp_path, capsys, monkeypatch):
    inside = predict(Material(100.0, 0.3, 1.0), unload_from=[0.1])
    stopped = replace(inside.curve, stopped="the mesh ends")
    monkeypatch.setattr("calibration.predict", lambda *_, **__: replace(inside, curve=stopped, atlas=None))
    options = ["--youngs-modulus", "2e4", "--poissons-ratio", "0.3", "--yield-stress", "1", "--compute", "--out", str(tmp_path / "c.csv")]
    assert execute(["predict", *options]) == FAILED
    assert "stopped early: the mesh ends" in capsys.readouterr().err
    assert (tmp_path / "c.csv").exists()


def test_what_no_law_was_scored_for_is_refused_before_finite_elements_run(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("fem.press", None)
    options = ["--youngs-modulus", "2e4", "--poissons-ratio", "0.3", "--yield-stress", "1", "--compute", "--tolerance", "0.05"]
    assert execute(["predict", *options, "--out", str(tmp_path / "law.json")]) == BAD_INPUT
    assert "laws were scored from 1 to" in capsys.readouterr().err


def test_predict_names_what_was_typed(tmp_path, capsys):
    options = ["--youngs-modulus", "210 GPa", "--poissons-ratio", "0.3", "--yield-stress", "420", "--out", str(tmp_path / "law.json")]
    assert execute(["predict", *options]) == BAD_INPUT
    said = capsys.readouterr().err
    assert "--yield-stress = 420.0" in said
    assert "with a unit" in said
    assert execute(["predict", *STEEL, "--law", "herz", "--out", str(tmp_path / "law.json")]) == BAD_INPUT
    assert "--law = 'herz'" in capsys.readouterr().err
    assert execute(["predict", *STEEL, "--tolerance", "0.05", "--quantity", "weight", "--out", str(tmp_path / "law.json")]) == BAD_INPUT
    assert "--quantity = 'weight'" in capsys.readouterr().err
