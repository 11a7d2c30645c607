"""Tables of relaxation, creep and DMA on disk: read as they are meant, and what is wrong is said with line, value and remedy."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from calibration.prony_table import read_table
from contactlaws.errors import InputError

ROWS = "0.1,5\n1,4\n10,3\n100,2\n1000,2\n"
RELAXATION = "time,modulus\n" + ROWS
DYNAMIC = "frequency,storage,loss\n0.1,2,.1\n1,3,.2\n10,4,.1\n"


def table(folder: Path, text: str):
    file = folder / "table.csv"
    file.write_text(text)
    return read_table(file)


def test_the_header_says_what_it_is(tmp_path):
    found = table(tmp_path, "# taken: on a Tuesday\n" + RELAXATION)
    assert (found.kind, found.shear, found.errors, found.name) == ("relaxation", False, None, "table.csv")
    assert found.place.tolist() == [0.1, 1.0, 10.0, 100.0, 1000.0]
    assert found.values.tolist() == [5.0, 4.0, 3.0, 2.0, 2.0]
    assert found.window == (0.1, 1000.0)
    assert found.sha256 == hashlib.sha256((tmp_path / "table.csv").read_bytes()).hexdigest()
    assert table(tmp_path, "# modulus: shear\n" + RELAXATION).shear
    assert table(tmp_path, RELAXATION.replace("modulus", "compliance")).kind == "creep"
    assert table(tmp_path, "modulus,time\n5,1\n4,2\n3,3\n2,4\n2,5\n").values.tolist() == [5.0, 4.0, 3.0, 2.0, 2.0]


def test_frequencies_see_the_inverse_of_their_times(tmp_path):
    found = table(tmp_path, DYNAMIC)
    assert found.values.tolist() == [2.0, 3.0, 4.0, 0.1, 0.2, 0.1]
    np.testing.assert_allclose(found.place, 2.0 * np.pi * np.array([0.1, 1.0, 10.0]))
    assert found.window == pytest.approx((1.0 / (20.0 * np.pi), 1.0 / (0.2 * np.pi)))
    assert table(tmp_path, DYNAMIC.replace("frequency", "angular_frequency")).place.tolist() == [0.1, 1.0, 10.0]


def test_errors_of_every_number(tmp_path):
    rows = "".join(f"{line},.1\n" for line in ROWS.split())
    assert table(tmp_path, "time,modulus,error\n" + rows).errors.tolist() == [0.1] * 5
    dynamic = "frequency,storage,loss,storage_error,loss_error\n0.1,2,-.1,.2,.3\n1,3,.2,.2,.3\n10,4,.1,.2,.3\n"
    found = table(tmp_path, dynamic)
    assert found.errors.tolist() == [0.2] * 3 + [0.3] * 3
    assert found.values[3] == -0.1  # a loss near zero may scatter below it, where it is said how far


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no header"),
        ("# only remarks\n", "no header"),
        ("time,modulus\n", "'0 rows': a series needs at least 5"),
        ("time,modulus\n1,2\n2,1\n", "'2 rows': a series needs at least 5"),
        ("frequency,storage,loss\n1,2,.1\n2,2,.1\n", "'2 rows': a series needs at least 3"),
        (RELAXATION.replace("modulus", "stress"), "line 1: column = 'stress': each of time, modulus"),
        (RELAXATION.replace("time", "modulus"), "line 1: column = 'modulus'"),
        (DYNAMIC.replace("frequency", "time"), "header = 'time,storage,loss': is no table"),
        ("frequency,storage,loss,loss_error\n1,2,.1,.1\n", "is no table"),
        ("# modulus: bulk\n" + RELAXATION, "modulus = 'bulk': must be one of uniaxial, shear"),
        ("# modulus: shear\n# modulus: shear\n" + RELAXATION, "line 2: modulus = 'shear': stands there twice"),
        (RELAXATION.replace("10,3", "10,nan"), "line 4: modulus = 'nan': must be a finite number"),
        (RELAXATION.replace("10,3", "10,inf"), "line 4: modulus = 'inf': must be a finite number"),
        (RELAXATION.replace("10,3", "10,soft"), "line 4: modulus = 'soft': must be a finite number"),
        (RELAXATION.replace("10,3", "10,"), "line 4: modulus missing: must be a finite number"),
        (RELAXATION.replace("10,3", "10"), "line 4 = '10': must have 2 values"),
        (RELAXATION.replace("10,3", "10,3,3"), "line 4 = '10,3,3': must have 2 values"),
        (RELAXATION.replace("10,3", "1,3"), "line 4: time = 1.0: must rise"),
        (RELAXATION.replace("10,3", "0.5,3"), "line 4: time = 0.5: must rise"),
        (RELAXATION.replace("0.1,5", "0,5"), "line 2: time = 0.0: must be positive"),
        (RELAXATION.replace("0.1,5", "-1,5"), "line 2: time = -1.0: must be positive"),
        (RELAXATION.replace("10,3", "10,-3"), "line 4: modulus = -3.0: must be positive"),
        (RELAXATION.replace("10,3", "10,0"), "line 4: modulus = 0.0: must be positive"),
        (DYNAMIC.replace("1,3,.2", "1,3,-.2"), "line 3: loss = -0.2: must be positive"),
        (DYNAMIC.replace("10,4", "1,4"), "line 4: frequency = 1.0: must rise"),
        ("time,modulus,error\n" + "".join(f"{line},0\n" for line in ROWS.split()), "line 2: error = 0.0: must be positive"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path, text, said):
    with pytest.raises(InputError, match=said) as raised:
        table(tmp_path, text)
    assert len(raised.value.problems) == 1


def test_every_bad_line_is_said_at_once(tmp_path):
    with pytest.raises(InputError) as raised:
        table(tmp_path, RELAXATION.replace("10,3", "10,nan").replace("100,2", "a hundred,2"))
    assert [problem.name.split(" ", 1)[1] for problem in raised.value.problems] == ["line 4: modulus", "line 5: time"]
