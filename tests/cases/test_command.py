"""The command line: what cannot be used is said at once, with value, bound and remedy, exit code 2, before anything is computed."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cases.command import BAD_INPUT, execute
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw, save
from contactlaws.path import scan
from contactlaws.version import code_version
from fem.profile import load_gmsh

HERTZ = Hertz(radius=1.0, reduced_modulus=1e9)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a Hertzian curve and law; computing in it is an error."""

    def computed(*_: object, **__: object) -> None:
        raise AssertionError("something was computed")

    monkeypatch.setattr("fem.press", computed)
    monkeypatch.setattr("dem.run", computed)
    monkeypatch.setattr("cases.batch.runner.run", computed)
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
        ("--yield-stress", "7.9", ("--yield-stress = 7.9", "between 0.01 and 1e+07", "with a unit")),
        ("--radius", "5 GPa", ("--radius", "is a stress", "5 um")),
        ("--unload-from", "1.5", ("--unload-from[0] = '1.5'", "less than 1", "the body ends at 1")),
        ("--max-overlap", "0.01", ("--unload-from", "beyond max_overlap")),
        ("--tolerance", "1e-9", ("--tolerance", "at least 0.001")),
        ("--out", "x.txt", ("--out = 'x.txt'", ".csv or .parquet")),
        ("--out", "nowhere/x.csv", ("there is no folder",)),
        ("--fields", "good.csv", ("--fields", "cannot be created")),
        ("--profile", "nothing.csv", ("nothing.csv", "cannot be read")),
        ("--profile", "good.csv", ("header", "must be r,z")),
    ],
)
def test_a_material_that_cannot_be_pressed(
    place: Path, capsys: pytest.CaptureFixture[str], option: str, value: str | None, words: tuple[str, ...]
) -> None:
    options = {name: text for name, text in (MATERIAL | {option: value}).items() if text is not None}
    said = refused(capsys, "reference", *(part for pair in options.items() for part in pair))
    assert all(word in said for word in words), said
    assert not (place / "x.csv").exists()


def test_fields_without_an_unloading_are_refused(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = {name: text for name, text in MATERIAL.items() if name != "--unload-from"} | {"--max-overlap": "0.05", "--fields": "fields"}
    said = refused(capsys, "reference", *(part for pair in options.items() for part in pair))
    assert "--fields = 'fields'" in said
    assert "give --unload-from" in said
    assert not (place / "fields").exists()


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ("r,z\n0,1\n0.5,x\n1,0\n", ("point 2 = '0.5,x'", "two numbers")),
        ("r,z\n0,1\n0.5,nan\n1,0\n", ("points[1]", "finite")),
        ("r,z\n0.1,1\n0.9,0.9\n1,0.5\n", ("points[0]", "pole", "mid-plane")),
    ],
)
def test_a_profile_that_cannot_be_pressed(place: Path, capsys: pytest.CaptureFixture[str], points: str, words: tuple[str, ...]) -> None:
    (place / "points.csv").write_text(points)
    options = MATERIAL | {"--profile": "points.csv", "--aspect": "2", "--radius": "5 um"}
    said = refused(capsys, "reference", *(part for pair in options.items() for part in pair))
    assert all(word in said for word in (*words, "--aspect = '2'", "--radius = '5 um'", "leave it out")), said


def sphere_profile(folder: Path) -> None:
    """points.csv: a unit sphere's meridian, every five degrees."""
    angle = np.linspace(0.0, np.pi / 2.0, 19)
    rows = [f"{r!r},{z!r}" for r, z in zip(np.sin(angle).tolist(), [*np.cos(angle[:-1]).tolist(), 0.0], strict=True)]
    (folder / "points.csv").write_text("\n".join(("# a sphere", "r,z", *rows)) + "\n")


def test_a_profile_without_gmsh(place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gmsh", None)
    sphere_profile(place)
    options = MATERIAL | {"--profile": "points.csv"}
    assert "pip install gmsh" in refused(capsys, "reference", *(part for pair in options.items() for part in pair))


def gmsh_is_missing() -> str:
    """Why gmsh does not load here; empty if it does."""
    try:
        load_gmsh()
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.compiled_only(reason="a finite-element curve takes minutes interpreted")
@pytest.mark.skipif(bool(gmsh_is_missing()), reason=gmsh_is_missing())
def test_a_profile_is_pressed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sphere given as points obeys Hertz, but for a/2R from its being finite (1.6 % at this overlap) and the tolerance."""
    monkeypatch.chdir(tmp_path)
    sphere_profile(tmp_path)
    options = ["--youngs-modulus", "1000", "--poissons-ratio", "0.3", "--elastic", "--max-overlap", "0.001", "--tolerance", "0.2"]
    assert execute(["reference", "--profile", "points.csv", *options, "--out", "curve.csv"]) == 0
    curve = read_curve("curve.csv")
    assert (curve.radius, curve.aspect) == (1.0, pytest.approx(1.0))
    hertz = 4.0 / 3.0 * 1000.0 / (1.0 - 0.3**2) * curve.overlap[-1] ** 1.5
    assert curve.force[-1] / hertz == pytest.approx(1.016, abs=0.02)


def test_speeds_at_which_nothing_collides(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(capsys, "impact", "law.json", "--radius", "1", "--density", "1000", "--speed", "1", "1e6", "1e-30")
    assert "--speed = 1000000.0: so fast" in said
    assert "--speed = 1e-30: so slow" in said


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
    shape = "shape = [1, 0.8, 0.66]\nyoungs_modulus = '142 GPa'\npoissons_ratio = 0.25\n"
    (place / "scene.toml").write_text(f"radius = '5 um'\ndensity = 4750\ncount = 50\npacking_fraction = 0.8\nstrain = 0.03\n{shape}")
    said = refused(capsys, "simulate", "scene.toml", "--law", "law.json")
    assert "is for spheres" in said
    assert "0.76" in said


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

    monkeypatch.setattr("cases.batch.store.tempfile.TemporaryFile", full)
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


def test_a_table_of_restitution_says_what_it_is_from(place: Path) -> None:
    assert execute(["impact", "law.json", "--radius", "1", "--density", "1000", "--speed", "0.1", "0.2", "--out", "e.csv"]) == 0
    lines = (place / "e.csv").read_text().splitlines()
    facts = dict(line.removeprefix("# ").split(": ", 1) for line in lines if line.startswith("#"))
    law = json.loads((place / "law.json").read_text())
    assert facts["law"] == law["law"]
    assert facts["law_curves"] == " ".join(law["curve_hashes"])
    assert facts["code"] == code_version()
    assert len([line for line in lines if not line.startswith("#")]) == 3  # header, two speeds


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


def test_a_finished_result_comes_with_its_warnings(capfd: pytest.CaptureFixture[str]) -> None:
    """Off a terminal too; a warning stands there for new results and for reused ones, a note once for all scenes."""
    from cases.batch.store import Record
    from cases.batch.task import Task
    from cases.progress import Progress

    statistics = {
        "energy_balance": 2e-4,
        "dt_over_critical": [0.4, 0.3],
        "time_step_over_critical_at_largest_overlap": 0.45,
        "steps": 100,
    }
    scene = {"notes": ["periodic: no walls"], "warnings": ["inertia [shows]"], "statistics": statistics}
    tasks = [Task("fits", "law", {}), Task("scenes", "a", {}), Task("scenes", "b", {})]
    records = [
        Record("fits.law", "k", "done", cpu_seconds=100.0, summary={"warnings": ["parameter x is not determined"]}),
        Record("scenes.a", "k", "done", cpu_seconds=2.0, summary=scene),
        Record("scenes.b", "k", "done", cpu_seconds=3.0, summary=scene),
    ]
    with Progress(tasks) as progress:
        progress.reused(tasks[0], records[0])
        for task, record in zip(tasks[1:], records[1:], strict=True):
            progress.started(task)
            progress.advanced(task, 0.0, "periodic: no walls")
            progress.finished(task, record)
        progress.summarise(records)
    said, err = capfd.readouterr()
    assert "this run took 5.0 CPU s" in said
    assert err.count("periodic: no walls") == 1
    assert "fits.law: parameter x is not determined" in err
    assert err.count("inertia [shows]") == 2
    assert "scenes.b: energy balance closes to 0.0002; time step up to 0.4 of the critical one (0.45 at" in err
