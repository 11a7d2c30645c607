"""The quick rows of the table of extremes, and what the command says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cases.verification import dem_extremes
from cases.verification.dem_extreme_trial import Trial, judged, refused

#: rows of a second each, once compiled
QUICK = ("overlaps", "one-point", "speeds", "sizes", "narrow", "across", "borders")


@pytest.mark.compiled_only(reason="thousands of steps")
@pytest.mark.parametrize("row", QUICK)
def test_quick_rows(row: str) -> None:
    missed = [trial for trial in dem_extremes.ROWS[row]() if not trial.sound]
    assert not missed, missed


@pytest.mark.compiled_only(reason="thousands of steps")
def test_the_command_writes_its_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert dem_extremes.main(["narrow", "borders", "--out", str(tmp_path)]) == 0
    table = (tmp_path / "table.md").read_text()
    assert "one clear error" in table
    assert "0 beyond a bound" in capsys.readouterr().out


def test_what_is_wrong_is_called_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A NaN, a value beyond its bound, an error that does not come and a crash all fail."""

    def crash() -> list[Trial]:
        raise ZeroDivisionError

    assert not judged("", np.nan, 1.0).sound
    assert not judged("", 2.0, 1.0).sound
    assert judged("", -1.0, 1.0).sound
    assert not refused("", lambda: None, "words").sound
    assert not refused("", crash, "words").sound
    monkeypatch.setitem(dem_extremes.ROWS, "crash", crash)
    assert dem_extremes.main(["crash"]) == 1
    assert "ZeroDivisionError" in capsys.readouterr().out


def test_an_unknown_row_is_refused() -> None:
    with pytest.raises(SystemExit):
        dem_extremes.main(["nothing"])
