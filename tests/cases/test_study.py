"""Studies: lists in a case file span grids, with readable names; what is wrong with a grid is said once, where it was written."""

from __future__ import annotations

from pathlib import Path

import pytest

from cases.casefile import reading
from cases.casefile.schema import Case
from contactlaws.errors import InputError

ROOT = Path(__file__).parents[2]

STUDY = """
[materials.es]
youngs_modulus = [10, 20, 50]
poissons_ratio = [0, 0.3]
yield_stress = 1
[curves.press]
material = "es"
radius = 1
unload_from = [0.05, 0.1]
"""


def study(tmp_path: Path, text: str) -> Case:
    (tmp_path / "study.toml").write_text(text)
    return reading.read_case(tmp_path / "study.toml")


def problems(tmp_path: Path, text: str) -> dict[str, str]:
    with pytest.raises(InputError) as caught:
        study(tmp_path, text)
    said: dict[str, str] = {}
    for problem in caught.value.problems:
        said[problem.name] = f"{said.get(problem.name, '')}{problem}\n"
    return said


def test_the_example_is_right() -> None:
    case = reading.read_case(ROOT / "cases" / "study.toml")
    assert case.materials["powder-nmc"].youngs_modulus == 142e9
    assert case.materials["powder-nmc"].yield_stress == 5e9
    assert len(case.curves) == 2 * len(case.materials)
    assert len(case.fits) == 2 * len(case.curves)


def test_lists_span_every_combination(tmp_path: Path) -> None:
    case = study(tmp_path, STUDY)
    assert list(case.materials)[:3] == ["es-E10-nu0", "es-E10-nu0.3", "es-E20-nu0"]
    assert {(m.youngs_modulus, m.poissons_ratio) for m in case.materials.values()} == {(e, nu) for e in (10, 20, 50) for nu in (0, 0.3)}
    assert case.curves["press-E50-nu0.3"].material == "es-E50-nu0.3"
    assert case.curves["press-E50-nu0.3"].unload_from == (0.05, 0.1)


def test_programmes_shapes_and_laws_are_spanned_too(tmp_path: Path) -> None:
    text = STUDY.replace("radius = 1", 'radius = ["1 um", "2 um"]\naspect = [0.5, 1]\nelastic = [true, false]')
    text = text.replace(
        "unload_from = [0.05, 0.1]", "unload_from = [[0.05], [0.05, 0.1]]\nmax_overlap = [0.1, 0.2]\ntolerance = [0.01, 0.02]"
    )
    case = study(tmp_path, text + '[fits.law]\nlaw = ["hertz", "thornton"]\ncurves = ["press"]\n')
    assert len(case.curves) == 6 * 2**6
    assert len(case.fits) == 2 * len(case.curves)
    assert "press-E10-nu0-R1um-aspect0.5-elastic-D1-d0.1-tol0.01" in case.curves
    fit = case.fits["law-thornton-E10-nu0-R1um-aspect0.5-elastic-D1-d0.1-tol0.01"]
    assert (fit.law, fit.curves) == ("thornton", ("press-E10-nu0-R1um-aspect0.5-elastic-D1-d0.1-tol0.01",))


def test_a_fit_of_several_grids_takes_the_curves_of_one_body(tmp_path: Path) -> None:
    text = STUDY + '[curves.elastic]\nmaterial = "es"\nradius = 1\nelastic = true\nmax_overlap = 0.1\n'
    case = study(tmp_path, text + '[fits.law]\nlaw = "edmans_sinka"\ncurves = ["press", "elastic"]\n')
    assert len(case.fits) == 6
    assert case.fits["law-E20-nu0"].curves == ("press-E20-nu0", "elastic-E20-nu0")
    other = (
        text.replace("elastic = true", "elastic = true\naspect = 2") + '[fits.law]\nlaw = "edmans_sinka"\ncurves = ["press", "elastic"]\n'
    )
    assert "has no curve of material es-E10-nu0" in problems(tmp_path, other)["fits.law.curves"]


def test_several_grids_under_one_name(tmp_path: Path) -> None:
    more = """
[[materials.es]]
youngs_modulus = [10, 20, 50]
poissons_ratio = [0, 0.3]
[[materials.es]]
youngs_modulus = 7
poissons_ratio = 0.2
"""
    text = more + '[curves.press]\nmaterial = "es"\nradius = 1\nelastic = true\nmax_overlap = 0.1\n'
    assert "press-E7-nu0.2" in study(tmp_path, text).curves
    assert "same point" in problems(tmp_path, text.replace("= 7", "= 50").replace("= 0.2", "= 0.3"))["materials.es"]


def test_evenly_spaced_values(tmp_path: Path) -> None:
    text = STUDY.replace("[10, 20, 50]", '{ from = "1 kPa", to = "1 MPa", count = 4, spacing = "log" }')
    assert {m.youngs_modulus for m in study(tmp_path, text.replace('"1 MPa"', '"1000 kPa"')).materials.values()} == {1e3, 1e4, 1e5, 1e6}
    assert "same unit" in problems(tmp_path, text)["materials.es.youngs_modulus"]
    assert "count" in str(problems(tmp_path, text.replace('"1 MPa", count = 4', '"10 kPa", count = 1')))


def test_materials_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "list.csv").write_text("# three\nname,youngs_modulus [GPa],poissons_ratio\nsoft,1,0.3\nhard,100,.2\n")
    text = '[materials.m]\nfile = "list.csv"\nyield_stress = "1 GPa"\n[curves.c]\nmaterial = "m"\nradius = 1\nmax_overlap = 0.1\n'
    case = study(tmp_path, text)
    assert list(case.curves) == ["c-soft", "c-hard"]
    assert case.materials["m-hard"].youngs_modulus == 1e11
    (tmp_path / "list.csv").write_text("youngs_modulus,poissons_ratio\n1 GPa,0.3\n100,0.2\n2 m,0.7\n")
    assert "mixes numbers with and without a unit" in str(problems(tmp_path, text))
    (tmp_path / "list.csv").write_text("youngs_modulus,poissons_ratio,colour,yield_stress\n1 GPa,0.3,red,1 GPa\n")
    found = str(problems(tmp_path, text))
    assert "colour" in found
    assert "stands in the case file too" in found
    (tmp_path / "list.csv").write_text("youngs_modulus,poissons_ratio\n1 GPa,0.3\n2 m,0.7\n")
    found = str(problems(tmp_path, text))
    assert "line 3: youngs_modulus" in found
    assert "less than 0.5" in found
    (tmp_path / "list.csv").write_text("youngs_modulus,poissons_ratio\n")
    assert "lists no material" in str(problems(tmp_path, text))


@pytest.mark.parametrize(
    ("old", "new", "name", "words"),
    [
        ("[10, 20, 50]", "[]", "materials.es.youngs_modulus", "spans nothing"),
        ("[10, 20, 50]", "[10, 20, 10.0]", "materials.es.youngs_modulus[2]", "same point as [0]"),
        ("[10, 20, 50]", '["1 GPa", "1000 MPa"]', "materials.es.youngs_modulus[1]", "same point as [0]"),
        ("[10, 20, 50]", '["1 GPa", 20]', "materials.es.youngs_modulus", "without a unit"),
        ("[10, 20, 50]", '["1 GPa", "20"]', "materials.es.youngs_modulus", "without a unit"),
        ("[10, 20, 50]", '["10 GPa", "20 GPa"]', "materials.es-E10GPa-nu0.yield_stress", "must lie between 0.01 and 1e+07 (and 3 more"),
        ("[10, 20, 50]", '["1 GPa", "2 m"]', "materials.es.youngs_modulus[1]", "is a length"),
        ("[10, 20, 50]", "[10, -20]", "materials.es.youngs_modulus[1]", "greater than 0"),
        ("[0, 0.3]", "[0, 0.7]", "materials.es.poissons_ratio[1]", "less than 0.5"),
        ("[0.05, 0.1]", "[[0.05], [0.1, 1.2]]", "curves.press.unload_from[1][1]", "less than 1"),
        ("[0.05, 0.1]", "[0.05, 0.1]\nmax_overlap = 0.08", "curves.press-E10-nu0.unload_from", "5 more of this grid"),
        ('"es"', '["es", "ess"]', "curves.press-ess.material", "did you mean 'es'?"),
        ('"es"', '["es", "es-E10-nu0"]', "curves.press.material", "is meant twice"),
    ],
)
def test_a_wrong_grid_is_said_where_it_was_written(tmp_path: Path, old: str, new: str, name: str, words: str) -> None:
    assert old in STUDY
    assert words in problems(tmp_path, STUDY.replace(old, new))[name]


def test_an_unknown_law_in_a_list(tmp_path: Path) -> None:
    found = problems(tmp_path, STUDY + '[fits.law]\nlaw = ["thornton", "thorton"]\ncurves = ["press"]\n')
    assert "did you mean 'thornton'?" in str(found)
    assert len(found) == 1  # once, not for each of six curves


def test_ten_million_tasks_ask_first_and_quickly(tmp_path: Path) -> None:
    text = STUDY.replace("[10, 20, 50]", "{ from = 10, to = 1000, count = 5000 }").replace(
        "[0, 0.3]", "{ from = 0, to = 0.4, count = 2000 }"
    )
    asked: list[int] = []
    (tmp_path / "study.toml").write_text(text)
    with pytest.raises(InputError, match="--yes"):
        reading.read_case(tmp_path / "study.toml", lambda number: bool(asked.append(number)))
    assert asked == [10_000_000]
