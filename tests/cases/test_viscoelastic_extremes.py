"""The table of extremes of the viscoelastic laws: everything promised was tried, stays within its bound, and a broken bound shows."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from cases.verification import viscoelastic_extremes as extremes
from cases.verification.viscoelastic_extremes import CREATED, TRIALS, Row, legs, main, markdown, row_of, rows, steps, summary

LONG = pytest.mark.compiled_only("takes minutes")
SOUND = Row("a trial", "maxwell_zener", "a limit", True, 0.0, 1e-5, 1e-6, 1e-4)


@LONG
def test_the_whole_table_is_sound():
    table = rows()
    assert [row.trial for row in table if not row.sound] == []
    assert {row.law for row in table} == set(CREATED)
    assert max(row.tension for row in table) == 0.0


@LONG
def test_the_table_covers_what_is_promised():
    """Ratios and steps from 1e-8 to 1e8 and from 1e-6 to 1e6, terms 12 decades apart, nu to .4999, holds, jumps, tiny and huge overlaps."""
    trials = [trial for make in TRIALS for trial in make()]
    names = {trial.name for trial in trials}
    for text in ("loading time over relaxation time 1e-8", "loading time over relaxation time 1e+8", "steps of 1e-6", "steps of 1e+6"):
        assert any(text in name for name in names)
    for text in (
        "terms 12 decades apart",
        "nu 0.4999",
        "hold of 1e6",
        "jumps every 1e-06",
        "jumps every 1e+06",
        "1e-12 R",
        "0.9 R",
        "cycles",
    ):
        assert any(text in name for name in names)
    spread = max(trial.record.times.max() / trial.record.times.min() for trial in trials)
    assert spread >= 1e12
    held = [trial for trial in trials if "hold" in trial.name]
    assert all((np.diff(trial.path[1]) == 0.0).any() for trial in held)
    assert any((np.diff(trial.path[0]) == 0.0).any() for trial in trials if "jumps" in trial.name)


@LONG
def test_one_trial_by_hand():
    """One step of a million relaxation times: what is left of it is the strain rate's share, tau/dt of the relaxing part."""
    trial = next(trial for trial in steps() if "one step of 1e+6" in trial.name)
    row = row_of(trial)
    assert row.sound
    assert row.error == pytest.approx(0.9 / 0.1 * 1e-6, rel=1e-6)


def test_legs_are_straight_and_keep_their_corners():
    for graded in (False, True):
        time, overlap = legs((0.0, 1.0, 1.0, 3.0), (0.0, 1.0, 0.5, 0.5), 10, graded)
        assert (np.diff(time) >= 0.0).all()
        assert (time[0], overlap[0], time[-1], overlap[-1]) == (0.0, 0.0, 3.0, 0.5)
        np.testing.assert_allclose(overlap[time < 1.0], time[time < 1.0], rtol=1e-15)
        assert 1.0 in overlap


@pytest.mark.parametrize(
    "change", [{"finite": False}, {"tension": 1e-20}, {"created": 0.02}, {"error": 2e-4}, {"error": float("nan"), "finite": False}]
)
def test_a_trial_beyond_its_bound_is_not_sound(change):
    assert SOUND.sound
    broken = SOUND._replace(**change)
    assert not broken.sound
    assert "1 beyond a bound" in summary([SOUND, broken])


def test_tables_are_written_and_a_broken_bound_is_an_exit_code(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(extremes, "rows", lambda only: [SOUND, SOUND._replace(trial="too far", error=0.5)])
    assert main(["--out", str(tmp_path / "new")]) == 1
    assert "BEYOND ITS BOUND: too far" in capsys.readouterr().out
    assert (tmp_path / "new" / "table.md").read_text() == markdown(extremes.rows(""))
    with (tmp_path / "new" / "table.csv").open() as file:
        read = list(csv.DictReader(file))
    assert [row["trial"] for row in read] == ["a trial", "too far"]
    assert float(read[1]["error"]) == 0.5
    monkeypatch.setattr(extremes, "rows", lambda only: [SOUND])
    assert main(["--out", str(tmp_path)]) == 0
    monkeypatch.setattr(extremes, "rows", lambda only: [])
    assert main(["--out", str(tmp_path), "--only", "nothing"]) == 1
