"""Prony series on disk: every bit comes back, and what is wrong with a file is said with line, value and remedy."""

from __future__ import annotations

from pathlib import Path

import hypothesis.strategies as st
import pytest
from hypothesis import given

from contactlaws.errors import InputError
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from contactlaws.prony_files import read_series, write_series

PVDF = uniaxial(Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,)), 0.4314, constant_bulk=True)
CONSTANTS = "# youngs_modulus: 1.77e9\n# poissons_ratio: 0.4314\n"
HEADER = "relaxation_time,shear_fraction\n"


@st.composite
def materials(draw):
    terms = draw(st.integers(0, 5))
    times = sorted(draw(st.sets(st.integers(-40, 40), min_size=terms, max_size=terms)))
    shares = st.lists(st.floats(0.0, 0.9 / max(terms, 1)), min_size=terms, max_size=terms).map(tuple)
    nu = draw(st.floats(0.0, 0.4999))
    seconds = tuple(1.1 * 2.0**n for n in times)
    return PronyViscoelastic(draw(st.floats(1.0, 1e12)), nu, seconds, draw(shares), draw(st.none() | shares))


@given(materials())
def test_every_bit_comes_back(tmp_path_factory, material):
    file = tmp_path_factory.mktemp("series") / "series.csv"
    assert read_series(write_series(material, file, {"fit": {"terms": 3}})) == material


def test_a_file_by_hand_leaves_the_constants_to_the_caller(tmp_path: Path):
    file = tmp_path / "series.csv"
    file.write_text("# a remark: of no matter\n" + HEADER + "1.8, 0.2\n\n20,0.1\n")
    assert read_series(file, 2e9, 0.3) == PronyViscoelastic(2e9, 0.3, (1.8, 20.0), (0.2, 0.1))
    with pytest.raises(InputError, match="does not say it; give it, or add the line '# poissons_ratio"):
        read_series(file, 2e9)
    file.write_text(CONSTANTS + file.read_text())
    assert read_series(file, 1.77e9).poissons_ratio == 0.4314
    with pytest.raises(InputError, match=r"youngs_modulus = 2000000000.0: contradicts .* which says 1770000000.0"):
        read_series(file, 2e9)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no header"),
        (CONSTANTS + "relaxation_time\n1\n", "column shear_fraction missing"),
        (CONSTANTS + "relaxation_time,shear_fraction,young\n1,.1,2\n", "line 3: column = 'young'"),
        (CONSTANTS + "relaxation_time,relaxation_time,shear_fraction\n1,1,.1\n", "line 3: column = 'relaxation_time'"),
        (CONSTANTS + HEADER + "-1,0.1\n", "line 4: relaxation_time = -1.0: must be a positive"),
        (CONSTANTS + HEADER + "0,0.1\n", "line 4: relaxation_time = 0.0: must be a positive"),
        (CONSTANTS + HEADER + "1,0.1\n1,0.2\n", "line 5: relaxation_time = 1.0: stands there twice"),
        (CONSTANTS + HEADER + "2,0.1\n1,0.2\n", "line 5: relaxation_time = 1.0: must rise"),
        (CONSTANTS + HEADER + "1,0.5\n2,0.5\n", "shear_fraction = 1.0: must be below 1 in sum"),
        (CONSTANTS + HEADER + "1,-0.1\n", "line 4: shear_fraction = -0.1: must lie in"),
        (CONSTANTS + HEADER + "1,nan\n", "line 4: shear_fraction = 'nan': must be a finite number"),
        (CONSTANTS + HEADER + "1,half\n", "line 4: shear_fraction = 'half': must be a finite number"),
        (CONSTANTS + HEADER + "1,\n", "line 4: shear_fraction missing: must be a finite number"),
        (CONSTANTS + HEADER + "1,0.1\n2\n", "line 5 = '2': must have 2 values"),
        (CONSTANTS + HEADER + '1,"0.1\n', "line 4 = .* is no line of a CSV file"),
        (CONSTANTS.replace("0.4314", "0.5") + HEADER + "1,0.1\n", "poissons_ratio = 0.5: must lie in"),
        (CONSTANTS.replace("0.4314", "rubber") + HEADER + "1,0.1\n", "poissons_ratio = 'rubber': must be a finite number"),
        (CONSTANTS.replace("1.77e9", "-1") + HEADER + "1,0.1\n", "youngs_modulus = -1.0"),
        (CONSTANTS + CONSTANTS + HEADER + "1,0.1\n", "line 3: youngs_modulus = '1.77e9': stands there twice"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(tmp_path: Path, text: str, said: str):
    file = tmp_path / "series.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=said) as raised:
        read_series(file)
    assert len(raised.value.problems) == 1


def test_only_a_sound_material_is_written(tmp_path: Path):
    with pytest.raises(InputError, match=r"below 1 in sum"):
        write_series(PronyViscoelastic(1e9, 0.3, (1.0, 2.0), (0.6, 0.6)), tmp_path / "s.csv")
    with pytest.raises(InputError, match=r"end the name in \.csv"):
        write_series(PVDF, tmp_path / "s.json")
    with pytest.raises(InputError, match="cannot be read"):
        read_series(tmp_path / "none.csv")
    assert list(tmp_path.iterdir()) == []
