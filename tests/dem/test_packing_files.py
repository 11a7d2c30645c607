"""Packings from files are what the file says, in m; a file that can't be used is refused by name and line, never by another exception."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contactlaws.errors import InputError
from dem.box import Box
from dem.packing import Packing, random_close_packing
from dem.packing_cells import worst_overlap
from dem.packing_files import read_packing, write_packing

DATA = """by hand

2 atoms
1 atom types

-1.0 3.0 xlo xhi
0.0 4.0 ylo yhi
0 8e0 zlo zhi

Atoms # sphere

2 1 1.0 2500 2.5 1.0 1.0 0 0 0
1 1 2.0 2500 1.0 1.0 1.0 0 0 0

Velocities

1 0 0 0
2 0 0 0
"""
DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS pp pp pp
0 1
0 1
0 1
ITEM: ATOMS id x y z radius
1 0.5 0.5 0.5 0.1
ITEM: TIMESTEP
7
ITEM: TIME
1e-3
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp ff
-1 3
0 4
0 8
ITEM: ATOMS id type xs ys zs diameter
2 1 0.875 0.25 0.125 1.0
1 1 0.5 0.25 0.125 2.0
"""
XYZ = """2
Lattice="4 0 0 0 4 0 0 0 8" Origin="-1 0 0" Properties=species:S:1:pos:R:3:force:R:3:radius:R:1 pbc="T T F"
A 1.0 1.0 1.0 0 0 0 1.0
B 2.5 1.0 1.0 0 0 0 0.5
"""
CSV = """# box: 4 4 8
# periodic: 1 1 0
x,y,z,diameter
2.0,1.0,1.0,2.0
3.5,1.0,1.0,1.0
"""
FILES = {"data": DATA, "dump": DUMP, "xyz": XYZ, "csv": CSV}


def read(folder: Path, text: str, **options: object) -> Packing:
    path = folder / "packing.txt"  # the content decides, not the name
    path.write_text(text, encoding="utf-8")
    return read_packing(path, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", FILES)
def test_two_touching_spheres_in_every_format(tmp_path: Path, kind: str) -> None:
    packing = read(tmp_path, FILES[kind])
    np.testing.assert_allclose(packing.position, [[2.0, 1.0, 1.0], [3.5, 1.0, 1.0]], rtol=1e-15)  # from the corner of the box
    np.testing.assert_array_equal(packing.radius, [1.0, 0.5])
    assert packing.box == Box((4.0, 4.0, 8.0), (True, True, kind == "data"))  # a data file does not say
    assert packing.packing_fraction == pytest.approx(4.0 / 3.0 * np.pi * 1.125 / 128.0, rel=1e-15)
    assert packing.worst_overlap == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("kind", FILES)
def test_the_unit_scales_every_length(tmp_path: Path, kind: str) -> None:
    packing = read(tmp_path, FILES[kind], unit="um")
    np.testing.assert_allclose(packing.position[1], [3.5e-6, 1e-6, 1e-6], rtol=1e-15)
    np.testing.assert_allclose(packing.radius, [1e-6, 0.5e-6], rtol=1e-15)
    np.testing.assert_allclose(packing.box.lengths, [4e-6, 4e-6, 8e-6], rtol=1e-15)
    if kind == "csv":
        assert read(tmp_path, "# unit: um\n" + CSV).box == packing.box


def test_frames_are_chosen_by_number(tmp_path: Path) -> None:
    assert len(read(tmp_path, DUMP, frame=0).position) == 1
    plain = "1\n\nA 0.5 0.5 0.5\n" + "2\n\nA 0.5 0.5 0.5\nA 0.75 0.5 0.5\n"
    box = Box((1.0, 1.0, 1.0))
    assert [len(read(tmp_path, plain, radius=0.1, box=box, frame=frame).position) for frame in (0, 1, -1, -2)] == [1, 2, 2, 1]
    with pytest.raises(InputError, match="2 frames"):
        read(tmp_path, plain, radius=0.1, box=box, frame=2)


def test_a_packing_comes_back_to_the_last_digit(tmp_path: Path) -> None:
    packing = random_close_packing(40, 0.5, np.linspace(1e-6, 3e-6, 40), seed=1, edges=(1.0, 2.0, 1.0))
    again = read_packing(write_packing(packing, tmp_path / "packing.data", density=4750.0))
    np.testing.assert_array_equal(again.position, packing.position)
    np.testing.assert_array_equal(again.radius, packing.radius)
    assert again.box == packing.box
    assert again.worst_overlap == pytest.approx(packing.worst_overlap, abs=1e-14)


def test_overlaps_are_measured(tmp_path: Path) -> None:
    packing = read(tmp_path, CSV.replace("3.5", "3.2"))
    assert packing.worst_overlap == pytest.approx(0.2, rel=1e-12)  # 0.3 of 1.5
    assert packing.worst_overlap == worst_overlap(packing.position, packing.radius, packing.box)


@pytest.mark.parametrize(
    ("kind", "old", "new", "match"),
    [
        ("data", "-1.0 3.0 xlo", "xlo", "xlo xhi"),
        ("data", "Atoms # sphere", "Atoms # atomic", "line 10: atom style"),
        ("data", "0 8e0 zlo zhi", "0 8 zlo zhi\n1 0 0 xy xz yz", "line 9: tilt"),
        ("data", "Atoms", "Bonds", "no such section"),
        ("data", "2500 1.0 1.0 1.0 0 0 0", "2500 1.0 1.0", "line 13: z"),
        ("data", "2 atoms", "20 atoms", "line 19: row missing: the file says 20 spheres, but ends after 7"),
        ("data", "2 atoms", "99999999999999999999999 atoms", "cut off"),
        ("data", "1 1 2.0", "1 1 -2.0", "line 13: radius = -1.0"),
        ("data", "1 1 2.0", "2 1 2.0", "stands there twice"),
        ("dump", "ff", "ff xy", "cuboid"),
        ("dump", "BOX BOUNDS pp pp ff\n-1 3", "BOX BOUNDS pp pp ff\n-1 nan", "line 18: bounds"),
        ("dump", "id type xs", "id type vx", "line 21: columns"),
        ("dump", "0.125 2.0", "1.125 2.0", "line 23: z = 9.0: must lie within the open axis"),
        ("dump", "0.125 2.0", "0.125 1e400", "line 23: diameter"),
        ("dump", "diameter", "mass", "radius missing"),
        ("xyz", "4 0 0 0 4", "4 1 0 0 4", "line 2: Lattice"),
        ("xyz", "pos:R:3", "pos:R:2", "pos:R:3"),
        ("xyz", "2.5", "nan", "line 4: x = 'nan'"),
        ("xyz", 'pbc="T T F"', 'pbc="T"', "pbc"),
        ("csv", "# box", "# fox", "box missing"),
        ("csv", "diameter", "mass", "mass"),
        ("csv", "3.5,1.0,1.0,1.0", "3.5,1.0,1.0,0.0", "line 5: radius = 0.0"),
        ("csv", "x,y,z", "x,z", "column y|values"),
        ("csv", "# box: 4 4 8", "# box: 4 4 -8", "box length z"),
        ("csv", "# box: 4 4 8", "# box: 4 4 8e300", "box length z"),
    ],
)
def test_what_is_wrong_is_said_by_name_and_line(tmp_path: Path, kind: str, old: str, new: str, match: str) -> None:
    assert old in FILES[kind]
    with pytest.raises(InputError, match=match) as raised:
        read(tmp_path, FILES[kind].replace(old, new))
    assert "packing.txt" in str(raised.value)


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(sorted(FILES)),
    st.lists(
        st.tuples(
            st.floats(0.0, 1.0),
            st.integers(0, 12),
            st.sampled_from(["", "-", "nan", "inf", "1e308", "-1e-320", "0", " ", "\n", ",", '"', "ITEM: ", "é", "1_0", "9" * 30, "#"]),
        ),
        min_size=1,
        max_size=4,
    ),
)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, kind: str, damage: list[tuple[float, int, str]]) -> None:
    """Pieces cut out and replaced at random: a packing whose numbers are all finite, or an InputError."""
    text = FILES[kind]
    for where, cut, new in damage:
        at = int(where * len(text))
        text = text[:at] + new + text[at + cut :]
    try:
        packing = read(tmp_path, text)
    except InputError:
        return
    assert np.isfinite(packing.position).all()
    assert np.isfinite(packing.packing_fraction)
    assert (np.asarray(packing.radius) > 0.0).all()


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=200))
def test_any_text_is_read_or_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError):
        read(tmp_path, text.replace("\r", ""))


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_packing(tmp_path / "nothing.csv")
    with pytest.raises(InputError, match="unit"):
        read(tmp_path, CSV, unit="furlong")
