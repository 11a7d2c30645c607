"""`fe2dem fit` with a viscoelastic law: measured and computed curves in time, and that what cannot be used is said with exit code 2."""

from __future__ import annotations

import numpy as np
import pytest

from cases.command import BAD_INPUT, execute
from contactlaws import fitted
from contactlaws.curve_files import write_curve
from tests.calibration.series_samples import ONE, RADIUS, curve_of, pressed


def measured(file, noise=0.005, columns=("time", "overlap", "force"), **changes):
    """A file as an instrument would leave it."""
    curve = curve_of(ONE, *pressed(hold=10.0, release=1.0, rows=30), noise)
    rows = np.column_stack([changes.get(name, getattr(curve, name)) for name in columns])
    file.write_text("\n".join((",".join(columns), *(",".join(map(repr, row)) for row in rows.tolist()))) + "\n")
    return str(file)


FITS = pytest.mark.compiled_only("a fit of hundreds of scans takes a minute interpreted")
GIVEN = ("--radius", "5 um", "--poissons-ratio", "0.4")


@FITS
@pytest.mark.parametrize("law", ["maxwell_zener", "maxwell_zener_ting"])
def test_a_measured_curve_becomes_a_law(tmp_path, capsys, law):
    out = tmp_path / "law.json"
    assert execute(["fit", measured(tmp_path / "curve.csv"), "--law", law, *GIVEN, "--out", str(out)]) == 0
    found = fitted.load(out)
    for value, truth, name in (
        (found.law.reduced_modulus, ONE.instantaneous, "reduced_modulus"),
        (found.law.fractions[0], ONE.fractions[0], "fractions[1]"),
        (found.law.times[0], ONE.times[0], "times[1]"),
    ):
        # four standard errors: one curve in 10 000 is further off
        assert abs(value - truth) < 4.0 * found.standard_errors[name]
    said = capsys.readouterr()
    assert "smallest BIC, taken" in said.out
    assert "relaxation times from" in said.out
    assert ("left out" in said.err) == (law == "maxwell_zener")


@FITS
@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_curve_of_our_own_says_itself_what_it_is(tmp_path, ending):
    curve = curve_of(ONE, *pressed(hold=10.0, rows=30), errors={"force": 0.003})
    file = write_curve(curve, tmp_path / f"curve.{ending}")
    assert execute(["fit", str(file), "--law", "maxwell_zener_ting", "--poissons-ratio", "0.4", "--out", str(tmp_path / "law.json")]) == 0
    found = fitted.load(tmp_path / "law.json")
    assert found.curve_hashes == (curve.content_hash,)
    assert found.origin["fit"]["noise_from"].startswith("stated by the curves")


@FITS
def test_two_spheres_collide_on_a_fitted_law(tmp_path, capsys):
    """A collision that lasts a ten-millionth of the relaxation time loses nothing."""
    out = tmp_path / "law.json"
    execute(["fit", measured(tmp_path / "curve.csv"), "--law", "maxwell_zener_ting", "--terms", "1", *GIVEN, "--out", str(out)])
    assert execute(["impact", str(out), "--radius", "5 um", "--density", "1780 kg/m^3", "--speed", "1"]) == 0
    assert "1.00000" in capsys.readouterr().out


def timeless(file, provenance="{}"):
    """A curve of a body that knows no time, computed if it has a provenance."""
    overlap = np.linspace(0.0, 1e-7, 20)
    force = overlap**1.5
    rows = "\n".join(f"0,{i},{d!r},{f!r}," for i, (d, f) in enumerate(zip(overlap.tolist(), force.tolist(), strict=True)))
    file.write_text(f"# radius: {RADIUS}\n# provenance: {provenance}\nbranch,time,overlap,force,contact_radius\n{rows}\n")
    return str(file)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "CURVE missing: is needed"),
        (("{good}",), "radius missing"),
        (("{good}", *GIVEN, "--terms", "-1"), "--terms = '-1'"),
        (("{good}", *GIVEN, "--terms", "60"), "--terms = 60: must lie between 0 and 20"),
        (("{good}", *GIVEN, "--youngs-modulus", "1 GPa"), "--youngs-modulus = '1 GPa': is not asked for"),
        (("{good}", "--radius", "5 um", "--poissons-ratio", "0.5"), "--poissons-ratio = '0.5'"),
        (("{good}", *GIVEN, "--out", "law.txt"), "--out = 'law.txt': must end in .json"),
        (("{untimed}", *GIVEN), "column time missing: is needed where the force depends on it"),
        (("{backwards}", *GIVEN), "keep the rows in their order in time"),
        (("{computed}", *GIVEN), "was computed of a body whose force knows no time"),
        (("{pulled}", *GIVEN), "pulled.csv: force = "),
    ],
)
def test_what_cannot_be_used(tmp_path, capsys, arguments, said):
    time = pressed(hold=10.0, release=1.0, rows=30)[0]
    files = {
        "good": measured(tmp_path / "good.csv"),
        "untimed": measured(tmp_path / "untimed.csv", columns=("overlap", "force")),
        "backwards": measured(tmp_path / "backwards.csv", time=time[::-1]),
        "computed": timeless(tmp_path / "computed.csv", '{"code": "x"}'),
        "pulled": measured(tmp_path / "pulled.csv", force=-np.ones(time.size)),
    }
    line = [argument.format(**files) for argument in arguments]
    assert execute(["fit", *line, "--law", "maxwell_zener_ting"]) == BAD_INPUT
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("{curve}", "--law", "thornton"), "its force depends on time, of which thornton knows nothing"),
        (("{curve}", "--tolerance", "0.01"), "a curve in time is for laws with relaxation times"),
        (("{curve}", "--law", "thornton", "--terms", "1"), "--terms = '1': is for laws with relaxation times"),
        (("{curve}", "--tolerance", "0.01", "--terms", "1"), "--terms = '1': is for a law that is named"),
    ],
)
def test_a_curve_in_time_is_for_a_law_in_time(tmp_path, capsys, arguments, said):
    curve = write_curve(curve_of(ONE, *pressed(hold=10.0, rows=30)), tmp_path / "curve.csv")
    assert execute(["fit", *(argument.format(curve=curve) for argument in arguments)]) == BAD_INPUT
    assert said in capsys.readouterr().err
