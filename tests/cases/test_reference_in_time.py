"""`fe2dem reference --prony`: what cannot be used is said in one line each, before anything is computed or written; and what it writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cases.command import BAD_INPUT, FAILED, execute
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.prony import PronyViscoelastic

CONSTANTS = "# youngs_modulus: 1.77e9\n# poissons_ratio: 0.43\n"
HEADER = "relaxation_time,shear_fraction\n"
SERIES = CONSTANTS + HEADER + "1.8,0.23\n"
RAMP = ("--max-overlap", "0.02", "--ramp", "1 s")
OUT = ("--out", "o.csv")
MATERIAL = PronyViscoelastic(1.77e9, 0.43, (1.8,), (0.23,))


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a series in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.csv").write_text(SERIES)
    return tmp_path


@pytest.fixture
def idle(place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same, where computing is an error."""

    def computed(*_: object, **__: object) -> None:
        raise AssertionError("something was computed")

    monkeypatch.setattr("fem.press_in_time", computed)
    monkeypatch.setattr("fem.press", computed)
    return place


def refused(place: Path, capsys: pytest.CaptureFixture[str], *arguments: str) -> list[str]:
    """Run a command that must be refused and leave nothing behind; the lines it says on stderr."""
    before = sorted(place.iterdir())
    assert execute(["reference", *arguments]) == BAD_INPUT
    assert sorted(place.iterdir()) == before
    said = capsys.readouterr().err
    assert "Traceback" not in said
    return said.splitlines()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (CONSTANTS + HEADER + "-1.8,0.23\n", "series.csv line 4: relaxation_time = -1.8: must be a positive number"),
        (CONSTANTS + HEADER + "0,0.23\n", "series.csv line 4: relaxation_time = 0.0: must be a positive number"),
        (CONSTANTS + HEADER + "1,0.5\n2,0.5\n", "series.csv: shear_fraction = 1.0: must be below 1 in sum"),
        (CONSTANTS + HEADER + "1,0.75\n2,0.75\n", "series.csv: shear_fraction = 1.5: must be below 1 in sum"),
        (CONSTANTS + HEADER + "1,0.2\n1,0.3\n", "series.csv line 5: relaxation_time = 1.0: stands there twice"),
        (CONSTANTS + HEADER + "2,0.2\n1,0.3\n", "series.csv line 5: relaxation_time = 1.0: must rise"),
        (CONSTANTS + HEADER + "1,-0.2\n", "series.csv line 4: shear_fraction = -0.2: must lie in [0, 1)"),
        (CONSTANTS + HEADER + "1,nan\n", "series.csv line 4: shear_fraction = 'nan': must be a finite number"),
        (CONSTANTS.replace("0.43", "0.5") + HEADER + "1,0.2\n", "series.csv: poissons_ratio = 0.5: must lie in [0, 0.5)"),
        (HEADER.join(("# youngs_modulus: 1e9\n", "1,0.2\n")), "--poissons-ratio missing: series.csv does not say it"),
        ("", "series.csv = 'no header'"),
    ],
)
def test_a_series_that_cannot_be_used(idle: Path, capsys: pytest.CaptureFixture[str], text: str, expected: str):
    (idle / "series.csv").write_text(text)
    said = refused(idle, capsys, "--prony", "series.csv", *RAMP, *OUT)
    assert len(said) == 1
    assert said[0].startswith(f"fe2dem: {expected}"), said


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ("time,overlap\n0,0\n2,1e-5\n1,2e-5\n", "p.csv line 4: time = 1.0: must rise, and comes after 2 s"),
        ("time,overlap\n2,1e-5\n1,2e-5\n", "p.csv line 3: time = 1.0: must rise"),
        ("time,overlap\n2,1e-5\n2,1e-5\n", "p.csv line 3: time = 2.0: must rise"),
        ("time,overlap\n-1,1e-5\n2,1e-5\n", "p.csv line 2: time = -1.0: must rise, and comes after 0 s"),
        ("time,overlap\n0,0\n2,-1e-5\n3,0\n", "p.csv = '3 knots': never touches the body"),
        ("time,force\n2,0\n", "p.csv = '2 knots': never touches the body"),
        ("time,overlap,force\n# both\n2,1e-5,3\n", "p.csv line 3 = (2.0, 1e-05, 3.0): must have exactly one of overlap and force"),
        ("time,overlap,force\n2,,\n", "p.csv line 2 = (2.0, None, None): must have exactly one"),
        ("time,overlap\n0,1e-5\n2,2e-5\n", "p.csv line 2 = (0.0, 1e-05, None): must be time 0 and overlap 0"),
        ("time,overlap\n2,2e-3\n", "p.csv line 2 = 0.002: must be smaller than the radius"),
        ("time,overlap\n2,7e-4\n", "p.csv: largest overlap over radius = 0.7: must lie between 1e-07 and 0.6"),
        ("time,force\n1,1e4\n", "p.csv: largest overlap over radius = 2."),
        ("time,force\n1,1e-20\n", "p.csv: largest overlap over radius = "),
        ("time,force\n1,-3\n", "p.csv line 2 = -3.0: must not be negative: the flat does not pull"),
        ("time,overlap\n2,one\n", "p.csv line 2: overlap = 'one': must be a finite number"),
        ("time,overlap\n2,nan\n", "p.csv line 2: overlap = 'nan': must be a finite number"),
        ("time,overlap\n,1e-5\n", "p.csv line 2: time missing: must be a finite number"),
        ("time,overlap\n2\n", "p.csv line 2 = '2': must have 2 values"),
        ('time,overlap\n2,"1e-5\n', "p.csv line 2 = '2,\"1e-5': is no line of a CSV file"),
        ("overlap\n2e-5\n", "p.csv: header = 'overlap': must name time"),
        ("time,overlap,time\n2,1e-5,3\n", "p.csv: header = 'time,overlap,time': must name time"),
        ("time,speed\n2,1e-5\n", "p.csv: header = 'time,speed': must name time"),
        ("time,overlap\n", "p.csv = '1 knots': needs a knot after the start"),
        ("", "p.csv: header missing"),
    ],
)
def test_a_programme_that_cannot_be_followed(idle: Path, capsys: pytest.CaptureFixture[str], rows: str, expected: str):
    (idle / "p.csv").write_text(rows)
    said = refused(idle, capsys, "--prony", "s.csv", "--radius", "1 mm", "--programme", "p.csv", *OUT)
    assert len(said) == 1
    assert said[0].startswith(f"fe2dem: {expected}"), said


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--yield-stress", "1 MPa", *RAMP), "--yield-stress = '1 MPa': is nothing for a viscoelastic body"),
        (("--elastic", *RAMP), "--elastic = True: is nothing for a viscoelastic body"),
        (("--fields", "f", *RAMP), "--fields = 'f': is not there for viscoelastic bodies"),
        (("--profile", "p.csv", *RAMP), "--profile = 'p.csv': is not there for viscoelastic bodies"),
        (("--max-overlap", "0.02"), "--ramp missing: is needed"),
        (("--ramp", "1 s"), "--max-overlap missing: is needed"),
        (("--unload-from", "0.01", *RAMP), "--max-overlap = (0.01, 0.02): must be one overlap"),
        (("--unload-from", "0.01", "0.02", "--ramp", "1 s"), "--max-overlap = (0.01, 0.02): must be one overlap"),
        (("--max-overlap", "0.7", "--ramp", "1 s"), "programme: largest overlap over radius = 0.7: must lie between"),
        (("--max-overlap", "1.2", "--ramp", "1 s"), "--max-overlap = '1.2': must be less than 1"),
        (("--max-overlap", "0.02", "--ramp", "-1"), "--ramp = '-1': must be at least 0"),
        (("--max-overlap", "0.02", "--ramp", "1 GPa"), "--ramp = '1 GPa': is a stress"),
        (("--hold", "nan", *RAMP), "--hold = 'nan'"),
        (("--poissons-ratio", "0.5", *RAMP), "--poissons-ratio = '0.5': must be less than 0.5"),
        (("--poissons-ratio", "0.3", *RAMP), "--poissons-ratio = 0.3: contradicts s.csv"),
        (("--tolerance", "1e-9", *RAMP), "--tolerance = '1e-9': must be at least 0.001"),
        (("--aspect", "30", *RAMP), "--aspect = '30'"),
        (("--programme", "nothing.csv"), "nothing.csv"),
    ],
)
def test_options_that_do_not_go_together(idle: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], expected: str):
    said = refused(idle, capsys, "--prony", "s.csv", *arguments, *OUT)
    assert len(said) == 1
    assert said[0].startswith(f"fe2dem: {expected}"), said


@pytest.mark.parametrize("option", ["--ramp", "--hold", "--release", "--programme"])
def test_times_are_for_viscoelastic_bodies(idle: Path, capsys: pytest.CaptureFixture[str], option: str):
    elastic = ("--youngs-modulus", "1 GPa", "--poissons-ratio", "0.3", "--elastic", "--max-overlap", "0.02")
    said = refused(idle, capsys, *elastic, option, "1", *OUT)
    assert said == [f"fe2dem: {option} = '1': is for viscoelastic bodies; give --prony too, or leave it out"]


@pytest.mark.parametrize("out", [(), ("--out", "o.txt"), ("--out", "nowhere/o.csv")])
def test_a_place_that_cannot_be_written(idle: Path, capsys: pytest.CaptureFixture[str], out: tuple[str, ...]):
    said = refused(idle, capsys, "--prony", "s.csv", *RAMP, *out)
    assert len(said) == 1
    assert said[0].startswith("fe2dem: --out"), said


def test_all_that_is_wrong_is_said_at_once(idle: Path, capsys: pytest.CaptureFixture[str]):
    (idle / "series.csv").write_text(CONSTANTS + HEADER + "-1,0.23\n")
    (idle / "p.csv").write_text("time,overlap\n2,one\n")
    said = refused(idle, capsys, "--prony", "series.csv", "--programme", "p.csv", "--ramp", "1 s", "--hold", "2 s", "--out", "o.txt")
    for word in (
        "series.csv line 4",
        "p.csv line 2",
        "--ramp = 1.0: is in the way of --programme",
        "--hold = 2.0: is in",
        "--out = 'o.txt'",
    ):
        assert any(word in line for line in said), said


def asked_for(monkeypatch: pytest.MonkeyPatch, stopped: str | None = None) -> dict[str, object]:
    """What the solver is asked for, when it gets that far; it answers with some curve."""
    seen: dict[str, object] = {}

    def press(material: PronyViscoelastic, programme: object, **options: object) -> Curve:
        seen.update(options, material=material, programme=[tuple(knot) for knot in programme])  # type: ignore[attr-defined]
        overlap = 1e-6 * np.arange(4.0)
        return Curve(
            overlap,
            overlap,
            overlap,
            np.zeros(4, int),
            radius=1.0,
            series=material,
            in_time=True,
            stopped=stopped,
            provenance={"cpu_seconds": 1.0},
        )

    monkeypatch.setattr("fem.press_in_time", press)
    return seen


@pytest.mark.parametrize(
    ("arguments", "knots"),
    [
        (("--max-overlap", "0.02", "--ramp", "500 ms"), [(0.5, 2e-5)]),
        (("--max-overlap", "0.02", "--ramp", "0"), [(0.0, 2e-5)]),
        (("--max-overlap", "0.02", "--ramp", "1", "--hold", "1 min"), [(1.0, 2e-5), (61.0, 2e-5)]),
        (("--max-overlap", "0.02", "--ramp", "1", "--release", "2"), [(1.0, 2e-5), (3.0, 0.0)]),
        (("--unload-from", "0.02", "--ramp", "1"), [(1.0, 2e-5), (2.0, 0.0)]),
        (("--unload-from", "0.02", "--ramp", "1", "--hold", "3", "--release", "0.5"), [(1.0, 2e-5), (4.0, 2e-5), (4.5, 0.0)]),
        (("--unload-from", "0.02", "--max-overlap", "0.02", "--ramp", "1"), [(1.0, 2e-5), (2.0, 0.0)]),
    ],
)
def test_options_become_a_programme(
    place: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], knots: list[tuple[float, float]]
):
    seen = asked_for(monkeypatch)
    assert execute(["reference", "--prony", "s.csv", "--radius", "1 mm", *arguments, *OUT]) == 0
    assert seen["material"] == MATERIAL
    assert seen["radius"] == 1e-3
    assert seen["programme"] == [(0.0, 0.0, None), *(pytest.approx((*knot, None)) for knot in knots)]
    assert read_curve("o.csv").series == MATERIAL


def test_a_file_becomes_a_programme(place: Path, monkeypatch: pytest.MonkeyPatch):
    seen = asked_for(monkeypatch)
    (place / "p.csv").write_text("# remark\ntime, overlap, force\n\n1,1e-5,\n2,,0.5\n# more\n3,-1e-6,\n")
    assert execute(["reference", "--prony", "s.csv", "--radius", "1 mm", "--programme", "p.csv", *OUT]) == 0
    assert seen["programme"] == [(0.0, 0.0, None), (1.0, 1e-5, None), (2.0, None, 0.5), (3.0, -1e-6, None)]


def test_a_run_that_stops_early(place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    asked_for(monkeypatch, stopped="no equilibrium found beyond 1 s")
    assert execute(["reference", "--prony", "s.csv", *RAMP, *OUT]) == FAILED
    assert "stopped early: no equilibrium found beyond 1 s; the curve up to there is in o.csv" in capsys.readouterr().err
    assert read_curve("o.csv").stopped == "no equilibrium found beyond 1 s"


@pytest.mark.compiled_only("a finite-element curve takes minutes interpreted")
@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_curve_from_the_command_line(place: Path, ending: str):
    out = place / f"o.{ending}"
    arguments = ["--radius", "1 mm", "--unload-from", "0.01", "--ramp", "1 s", "--hold", "2 s", "--out", str(out)]
    assert execute(["reference", "--prony", "s.csv", *arguments]) == 0
    assert sorted(file.name for file in place.iterdir()) == [out.name, "s.csv"]
    curve = read_curve(out)
    assert (curve.series, curve.in_time, curve.stopped, curve.radius) == (MATERIAL, True, None, 1e-3)
    assert curve.branch.max() == 1
    assert curve.force[-1] == 0.0
    # a hold of 2 s at constant Poisson's ratio: Lee & Radok's integral of Hertz's force, which a sphere at .01 R exceeds by some per cent
    ramped, held = (float(np.interp(time, curve.time, curve.force)) for time in (1.0, 3.0))
    shape = np.linspace(0.0, 1.0, 20001)
    rate = 1.5 * np.sqrt(shape)
    share = [np.trapezoid(rate * (1.0 - 0.23 * -np.expm1(-(time - shape) / 1.8)), shape) for time in (1.0, 3.0)]
    assert held / ramped == pytest.approx(share[1] / share[0], rel=5e-3)  # it rises with nearly the same power
