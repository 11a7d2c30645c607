"""The command line: what cannot be used is said at once, with value, bound and remedy, exit code 2, before anything is computed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cases.command import BAD_INPUT, execute
from contactlaws.curve import Curve
from contactlaws.curve_files import write_curve
from contactlaws.elastic import Hertz
from contactlaws.fitted import FittedLaw, save
from contactlaws.path import scan

HERTZ = Hertz(radius=1.0, reduced_modulus=1e9)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a Hertzian curve and law; computing in it is an error."""

    def computed(*_: object, **__: object) -> None:
        raise AssertionError("something was computed")

    monkeypatch.setattr("fem.press", computed)
    monkeypatch.setattr("dem.run", computed)
    monkeypatch.setattr("cases.runner.run", computed)
    monkeypatch.chdir(tmp_path)
    overlap = np.linspace(0.0, 0.05, 20)
    curve = Curve(np.arange(20.0), overlap, scan(HERTZ, overlap).force, np.zeros(20, np.int64), radius=1.0)
    write_curve(curve, tmp_path / "good.csv")
    write_curve(curve, tmp_path / "good.parquet")
    save(FittedLaw(HERTZ, max_overlap=0.05), tmp_path / "law.json")
    return tmp_path


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must be refused; returns what it says on stderr."""
    assert execute(list(arguments)) == BAD_INPUT
    said = capsys.readouterr().err
    assert "Traceback" not in said
    return said


MATERIAL = {
    "--youngs-modulus": "142 GPa",
    "--poissons-ratio": "0.25",
    "--yield-stress": "7.9 GPa",
    "--unload-from": "0.05",
    "--out": "x.csv",
}


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--youngs-modulus", "0", ("--youngs-modulus = '0'", "greater than 0", "142 GPa")),
        ("--youngs-modulus", "-1e9", ("-1e9", "greater than 0")),
        ("--youngs-modulus", "70 mm", ("70 mm", "is a length", "142 GPa")),
        ("--youngs-modulus", "nan", ("--youngs-modulus", "nan")),
        ("--youngs-modulus", None, ("--youngs-modulus missing", "is needed")),
        ("--poissons-ratio", "0.5", ("--poissons-ratio = 0.5", "less than 0.5", "0.49")),
        ("--poissons-ratio", "-0.1", ("-0.1", "at least 0")),
        ("--yield-stress", None, ("--yield-stress missing", "7.9 GPa", "--elastic")),
        ("--yield-stress", "0 Pa", ("--yield-stress", "greater than 0")),
        ("--radius", "5 GPa", ("--radius", "is a stress", "5 um")),
        ("--unload-from", "1.5", ("--unload-from[0] = '1.5'", "less than 1", "the body ends at 1")),
        ("--max-overlap", "0.01", ("--unload-from", "beyond max_overlap")),
        ("--tolerance", "1e-9", ("--tolerance", "at least 0.001")),
        ("--out", "x.txt", ("--out = 'x.txt'", ".csv or .parquet")),
        ("--out", "nowhere/x.csv", ("there is no folder",)),
        ("--fields", "good.csv", ("--fields", "cannot be created")),
    ],
)
def test_a_material_that_cannot_be_pressed(
    place: Path, capsys: pytest.CaptureFixture[str], option: str, value: str | None, words: tuple[str, ...]
) -> None:
    options = {name: text for name, text in (MATERIAL | {option: value}).items() if text is not None}
    said = refused(capsys, "reference", *(part for pair in options.items() for part in pair))
    assert all(word in said for word in words), said
    assert not (place / "x.csv").exists()


def test_all_problems_of_one_call_come_at_once(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(
        capsys, "reference", "--youngs-modulus", "70 mm", "--poissons-ratio", "0.7", "--unload-from", "0.05", "2", "x", "--out", "x.txt"
    )
    for name in ("--youngs-modulus", "--poissons-ratio", "--yield-stress", "--unload-from[1]", "--unload-from[2]", "--out"):
        assert f"fe2dem: {name} " in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("branch,time,overlap,force\n0,0,0,0\n0,1,nan,1\n0,2,0.2,2\n", ("line 3", "nan")),
        ("overlap,force\n0,0\n0.2,1\n0.1,2\n0.3,3\n", ("line", "overlap")),
        ("overlap,load\n0,0\n", ("force",)),
        ("", ("no rows",)),
    ],
)
def test_a_measured_curve_that_is_damaged(place: Path, capsys: pytest.CaptureFixture[str], text: str, words: tuple[str, ...]) -> None:
    (place / "bad.csv").write_text(text)
    said = refused(capsys, "fit", "bad.csv", "--law", "hertz", "--radius", "1")
    assert "bad.csv" in said
    assert all(word in said for word in words), said


def test_a_parquet_file_that_is_truncated_or_foreign(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = (place / "good.parquet").read_bytes()
    (place / "half.parquet").write_bytes(whole[: len(whole) // 2])
    pq.write_table(pa.table({"a": [1, 2]}), place / "foreign.parquet")
    said = refused(capsys, "fit", "half.parquet", "foreign.parquet", "--law", "hertz", "--out", "new.json")
    assert "half.parquet" in said
    assert "foreign.parquet" in said
    assert not (place / "new.json").exists()


def test_an_unknown_law_or_key_comes_with_a_suggestion(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "did you mean 'thornton'?" in refused(capsys, "fit", "good.csv", "--law", "thorton")
    (place / "case.toml").write_text("[materials.a]\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\nyeild_stress = 1e7\n")
    assert "did you mean 'yield_stress'?" in refused(capsys, "run", "case.toml")
    assert "did you mean" in refused(capsys, "refrence").lower()


def test_a_scene_that_cannot_be_packed(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "scene.toml").write_text("radius = '5 um'\ndensity = '3 GPa'\ncount = 50\npacking_fraction = 0.8\nstrain = 0.03\n")
    said = refused(capsys, "simulate", "scene.toml", "--law", "no.json")
    assert "density" in said
    assert "no.json" in said
    (place / "scene.toml").write_text("radius = '5 um'\ndensity = 4750\ncount = 50\npacking_fraction = 0.8\nstrain = 0.03\n")
    assert "0.64" in refused(capsys, "simulate", "scene.toml", "--law", "law.json")


def test_no_place_to_write(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "case.toml").write_text("[materials.a]\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n")
    said = refused(capsys, "run", "case.toml", "--out", "good.csv/results")
    assert "cannot be created" in said
    assert "choose another folder" in said


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a device that is always full")
def test_a_full_disk_is_said_in_one_line(place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        with open("/dev/full", "w") as file:
            file.write("x")

    monkeypatch.setattr("cases.store.tempfile.TemporaryFile", full)
    (place / "case.toml").write_text("[materials.a]\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\n")
    assert "No space left" in refused(capsys, "run", "case.toml", "--out", "results")


def test_missing_and_foreign_files(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "foreign.json").write_text("{}")
    assert "nothing.toml" in refused(capsys, "run", "nothing.toml")
    assert "format" in refused(capsys, "impact", "foreign.json", "--radius", "1", "--density", "1", "--speed", "1")
    assert "--speed missing" in refused(capsys, "impact", "law.json", "--radius", "1", "--density", "1")
    assert "holds no results" in refused(capsys, "status", ".")
    assert "holds no results" in refused(capsys, "report", ".")


def test_a_law_used_outside_its_range_says_so(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["impact", "law.json", "--radius", "1", "--density", "1000", "--speed", "0.1", "500"]) == 0
    shown = capsys.readouterr()
    assert "from 500 m/s on" in shown.err
    assert "0.05" in shown.err
    assert "extrapolated" in shown.err


def test_a_fit_of_a_measured_curve(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["fit", "good.csv", "--law", "hertz", "--out", "new.json"]) == 0
    assert "reduced_modulus" in capsys.readouterr().out
    assert (place / "new.json").exists()


def test_help_and_laws(capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["--help"]) == 0
    assert execute(["laws"]) == 0
    assert "thornton" in capsys.readouterr().out
    assert execute(["--version"]) == 0
    assert capsys.readouterr().out.startswith("fe2dem ")


@pytest.mark.compiled_only(reason="starts a process of its own that compiles nothing")
def test_help_loads_nothing_heavy() -> None:
    code = "import sys; from cases.command import execute; execute(['--help']); sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], stdout=subprocess.DEVNULL, check=False).returncode == 0
