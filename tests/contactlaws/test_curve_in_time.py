"""Curves whose force depends on time: their branches, on disk to the last digit, and what is wrong with one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contactlaws.curve import Curve, branches_in_time
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.errors import InputError
from contactlaws.foundation import follow, springs_of
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from tests.contactlaws.samples import HARD, curve_of, edmans_sinka

MODULUS = Relaxation(1.77e9, (0.2, 1.0 / 3.0), (0.1, 7.0 / 3.0))
MATERIAL = uniaxial(MODULUS, 0.43, constant_bulk=True)
RADIUS = 5e-6


def viscoelastic_curve() -> Curve:
    """Up, hold, back half way, and up again: what springs on Hertz's curve do."""
    time = np.array([0.0, *np.linspace(0.1, 1.0, 10), 2.0, 4.0, *np.linspace(4.1, 4.5, 5), 4.5, *np.linspace(4.7, 6.0, 7)])
    overlap = 1e-7 * np.interp(time, [0.0, 1.0, 4.0, 4.5, 6.0], [0.0, 1.0, 1.0, 0.5, 1.2])
    springs = springs_of(lambda d: 4.0 / 3.0 * 1e9 * np.sqrt(RADIUS) * d**1.5, 2e-7, 200)
    found = follow(springs, MODULUS, time, overlap)
    branch = branches_in_time(overlap)
    branch[np.flatnonzero(np.diff(time) == 0.0) + 1] += 1  # the row at which it turns stands there twice
    return Curve(
        time=time,
        overlap=overlap,
        force=found.force,
        raw_force=1.001 * found.force,
        contact_radius=np.sqrt(RADIUS * found.edge),
        branch=branch,
        radius=RADIUS,
        material=MATERIAL.instantaneous,
        series=MATERIAL,
        in_time=True,
        errors={"force": 0.0025},
        stopped="no reason",
        provenance={"cpu_seconds": 0.7},
    )


CURVE = viscoelastic_curve()
HEADER = "time,overlap,force\n"
MEASURED = HEADER + "0,0,0\n1,1e-7,1e-3\n5,1e-7,8e-4\n5.5,5e-8,1e-4\n6,8e-8,5e-4\n"


@given(st.lists(st.floats(-1.0, 1.0, width=32), min_size=1, max_size=30))
def test_branches_follow_the_overlap(overlap: list[float]):
    branch = branches_in_time(overlap)
    # off the undeformed body the flat counts as resting
    steps, turns = np.diff(np.maximum(overlap, 0.0), prepend=0.0), np.diff(branch, prepend=0)
    # growing is even and shrinking odd, resting goes on as before, and no number is left out
    assert (branch[steps > 0.0] % 2 == 0).all()
    assert (branch[steps < 0.0] % 2 == 1).all()
    assert (turns[steps == 0.0] == 0).all()
    assert np.isin(turns, (0, 1)).all()


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_every_bit_comes_back(tmp_path: Path, ending: str):
    again = read_curve(write_curve(CURVE, tmp_path / f"curve.{ending}"))
    for name in Curve.COLUMNS if ending == "parquet" else ("time", "overlap", "force", "branch", "contact_radius"):
        np.testing.assert_array_equal(getattr(again, name), getattr(CURVE, name))
    for name in ("in_time", "series", "material", "radius", "aspect", "errors", "stopped", "provenance"):
        assert getattr(again, name) == getattr(CURVE, name), name
    assert isinstance(again.series, PronyViscoelastic)
    if ending == "parquet":
        assert again.content_hash == CURVE.content_hash
    else:
        assert again.content_hash == replace(CURVE, raw_force=None).content_hash  # a column that a CSV file leaves out


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_series_whose_moduli_relax_together_comes_back(tmp_path: Path, ending: str):
    together = replace(CURVE, series=uniaxial(MODULUS, 0.43))
    again = read_curve(write_curve(together, tmp_path / f"curve.{ending}"))
    assert again.series == together.series
    assert again.series is not None
    assert again.series.bulk_fractions is None


def test_a_curve_is_known_by_its_series_and_its_time():
    others = [
        replace(CURVE, series=MATERIAL._replace(relaxation_times=(0.1, 7.1 / 3.0))),
        replace(CURVE, series=uniaxial(MODULUS, 0.43)),
        replace(CURVE, series=None),
        replace(CURVE, time=2.0 * CURVE.time),
        replace(CURVE, in_time=False, overlap=np.arange(CURVE.time.size) * 1e-9, branch=0 * CURVE.branch),
    ]
    assert len({CURVE.content_hash, *(other.content_hash for other in others)}) == 1 + len(others)
    # how it was computed is not what it is
    assert replace(CURVE, provenance={}, stopped=None).content_hash == CURVE.content_hash


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_files_without_time_are_what_they_were(tmp_path: Path, ending: str):
    old = curve_of(edmans_sinka(HARD), 0.1, (0.3, 1.0), HARD, rows=20)
    file = write_curve(old, tmp_path / f"old.{ending}")
    if ending == "csv":
        text = file.read_text()
        assert "series" not in text
        assert "in_time" not in text
    else:  # as such a file was before these facts were known
        table = pq.read_table(file)
        metadata = {k: v.replace(b'"in_time": false, "series": null, "stopped": null, ', b"") for k, v in table.schema.metadata.items()}
        assert metadata != table.schema.metadata
        pq.write_table(table.replace_schema_metadata(metadata), file)
    again = read_curve(file)
    assert (again.in_time, again.series, again.stopped) == (False, None, None)
    assert again.content_hash == old.content_hash


def test_a_measured_path_is_cut_at_its_turns(tmp_path: Path):
    file = tmp_path / "measured.csv"
    file.write_text(MEASURED)
    curve = read_curve(file, radius=RADIUS, in_time=True)
    assert curve.in_time
    assert curve.branch.tolist() == [0, 0, 0, 1, 2]
    assert curve.time.tolist() == [0.0, 1.0, 5.0, 5.5, 6.0]
    file.write_text("# in_time: true\n# radius: 5e-6\n" + MEASURED)
    assert read_curve(file).content_hash == curve.content_hash


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("overlap,force\n0,0\n1e-7,1\n2e-7,2\n", r"column time missing: is needed where the force depends on it"),
        (HEADER + "0,0,0\n2,1e-7,1\n1,2e-7,2\n", r"line 4: time = 1.0: must not fall below 2 s"),
        (HEADER + "0,0,0\nnan,1e-7,1\n2,2e-7,2\n", r"line 3: time = 'nan': must be a finite number"),
        (HEADER + "0,0,0\n,1e-7,1\n2,2e-7,2\n", r"line 3: time missing: has no value"),
        (HEADER + "0,0,0\n1,1e-7,inf\n2,2e-7,2\n", r"line 3: force = 'inf': must be a finite number"),
        (HEADER + "0,0,0\n1,1e-7,1\n", r"at least 3"),
        ("branch," + HEADER + "0,0,0,0\n0,1,1e-7,1\n0,2,5e-8,1\n", r"row 2: overlap = 5e-08: must not fall on an even branch"),
        ("branch," + HEADER + "0,0,0,0\n1,1,1e-7,1\n1,2,2e-7,1\n", r"row 2: overlap = 2e-07: .*nor rise on an odd one"),
        ("branch," + HEADER + "0,0,0,0\n2,1,1e-7,1\n2,2,2e-7,1\n", r"branch = \[0, 2, 2\]: must start at 0 and go up by 0 or 1"),
        ("branch," + HEADER + "1,0,0,0\n1,1,0,1\n2,2,2e-7,1\n", r"branch = \[1, 1, 2\]: must start at 0"),
        (HEADER + "0,0,0\n1,1e-7,1\n2,6e-6,2\n", r"must stay below the radius"),
        ("# in_time: maybe\n" + MEASURED, r"line 1: in_time = 'maybe'"),
        ("# in_time: 3\n" + MEASURED, None),  # the option says it; a file alone does not get away with it, see below
    ],
)
def test_what_is_wrong_with_a_measured_path_is_said_once(tmp_path: Path, content: str, expected: str | None):
    file = tmp_path / "bad.csv"
    file.write_text(content)
    if expected is None:
        with pytest.raises(InputError, match="in_time = 3: must be true or false"):
            read_curve(file, radius=RADIUS)
        return
    with pytest.raises(InputError, match=expected) as error:
        read_curve(file, radius=RADIUS, in_time=True)
    assert len(error.value.problems) == 1
    assert error.value.problems[0].remedy


GOOD = '{"youngs_modulus": 1e9, "poissons_ratio": 0.3, "relaxation_times": [1.0], "shear_fractions": [0.5], "bulk_fractions": null}'


@pytest.mark.parametrize(
    ("series", "expected"),
    [
        ("{", "line 1: series"),
        ("7", "series = 7: must name youngs_modulus"),
        ('{"youngs_modulus": 1e9}', "must name youngs_modulus, poissons_ratio, relaxation_times"),
        (GOOD.replace("1e9", '"stiff"'), "series: youngs_modulus = 'stiff': must be a number"),
        (GOOD.replace("[1.0]", "1.0"), "series: relaxation_times = 1.0: must be a row of numbers"),
        (GOOD.replace("[1.0]", "[null]"), r"series: relaxation_times = \[None\]: must be a row of numbers"),
        (GOOD.replace("[1.0]", "[-1.0]"), r"relaxation_times\[1\] = -1.0: must be a positive number of seconds"),
        (GOOD.replace("[1.0]", "[1.0, 2.0]"), "shear_fractions = 1: must be 2, one for each relaxation time"),
        (GOOD.replace("[0.5]", "[1.5]"), r"shear_fractions\[1\] = 1.5: must lie in \[0, 1\)"),
        (GOOD.replace("0.3,", "0.5,"), "poissons_ratio = 0.5"),
        (GOOD.replace("1e9", "1" + 400 * "0"), "youngs_modulus = 10+: must be a number"),
    ],
)
def test_a_damaged_series_is_said_once(tmp_path: Path, series: str, expected: str):
    file = tmp_path / "bad.csv"
    file.write_text(f"# series: {series}\n# in_time: true\n{MEASURED}")
    with pytest.raises(InputError, match=expected) as error:
        read_curve(file, radius=RADIUS)
    assert len(error.value.problems) == 1
    assert "bad.csv" in error.value.problems[0].name


def test_a_damaged_series_in_parquet(tmp_path: Path):
    file = write_curve(CURVE, tmp_path / "c.parquet")
    table = pq.read_table(file)
    metadata = {key: value.replace(b'"shear_fractions": [', b'"shear_fractions": [0.9, ') for key, value in table.schema.metadata.items()}
    pq.write_table(table.replace_schema_metadata(metadata), file)
    with pytest.raises(InputError, match=r"c\.parquet: shear_fractions = 3: must be 2"):
        read_curve(file)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda c: {"time": c.time[::-1]}, "must not fall below"),
        (lambda c: {"branch": np.zeros_like(c.branch)}, "must not fall on an even branch"),
        (lambda c: {"time": np.where(c.time == 1.0, np.nan, c.time)}, r"time\[row 10\] = nan: must be finite"),
        (lambda c: {"time": c.time[:-1]}, r"^time = \(25,\): must have 26 rows like overlap; [^\n]*$"),
    ],
)
def test_a_curve_that_is_no_path_in_time(change: Callable[[Curve], dict[str, Any]], expected: str):
    with pytest.raises(InputError, match=expected):
        replace(CURVE, **change(CURVE))
