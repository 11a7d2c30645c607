"""Case files: every error at once, each with value, bound and remedy; a right file becomes frozen SI records."""

from __future__ import annotations

from pathlib import Path

import pytest

from cases.casefile import reading
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw, save

ROOT = Path(__file__).parents[2]

GOOD = """
[materials.nmc]
youngs_modulus = "142 GPa"
poissons_ratio = 0.25
yield_stress = 7.9e9
[curves.plastic]
material = "nmc"
radius = "5 um"
unload_from = [0.05, "10 %"]
"""


def problems(tmp_path: Path, text: str) -> dict[str, str]:
    """What is wrong with a case file: name -> whole message."""
    file = tmp_path / "case.toml"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        reading.read_case(file)
    return {problem.name: str(problem) for problem in caught.value.problems}


def test_units_become_si(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(GOOD)
    case = reading.read_case(tmp_path / "case.toml")
    assert case.materials["nmc"].youngs_modulus == 142e9
    assert case.curves["plastic"].radius == 5e-6
    assert case.curves["plastic"].unload_from == (0.05, 0.1)
    assert case.materials["nmc"].record(elastic=True).yield_stress is None


def test_the_quickstart_is_right() -> None:
    case = reading.read_case(ROOT / "cases" / "quickstart.toml")
    assert {table.fit for table in (*case.impacts.values(), *case.scenes.values())} <= set(case.fits)


def test_the_example_of_a_scene_is_right(tmp_path: Path) -> None:
    save(FittedLaw(Hertz(5e-6, 151e9), max_overlap=5e-7), tmp_path / "law.json")
    scene, law = reading.read_scene(ROOT / "cases" / "scene.toml", tmp_path / "law.json")
    assert (scene.radius, scene.release, law.name) == (5e-6, True, "law.json")


def test_all_problems_of_a_file_come_at_once(tmp_path: Path) -> None:
    found = problems(
        tmp_path,
        """
        titel = "x"
        [materials.a]
        youngs_modulus = "70 mm"
        poissons_ratio = 0.5
        yield_stres = 3
        [materials.b]
        youngs_modulus = 1e9
        poissons_ratio = 0.3
        [curves.first]
        material = "a"
        radius = -1
        unload_from = [0.1, 1.2]
        [curves.second]
        material = "b"
        radius = 1
        [curves.third]
        material = "c"
        radius = 1
        max_overlap = 0.1
        [fits.q]
        law = "hert"
        curves = ["second", "nothing", "measured.csv"]
        """,
    )
    assert "did you mean 'title'?" in found["titel"]
    assert "did you mean 'yield_stress'?" in found["materials.a.yield_stres"]
    assert "is a length" in found["materials.a.youngs_modulus"]
    assert "less than 0.5" in found["materials.a.poissons_ratio"]
    assert "greater than 0" in found["curves.first.radius"]
    assert "less than 1" in found["curves.first.unload_from[1]"]
    assert "elastic = true" in found["materials.b.yield_stress"]
    assert "max_overlap" in found["curves.second.max_overlap"]
    assert "names nothing" in found["curves.third.material"]
    assert "did you mean 'hertz'?" in found["fits.q.law"]
    assert "measured.csv" in found["fits.q.curves"]


@pytest.mark.parametrize(
    ("line", "instead", "name", "words"),
    [
        ('youngs_modulus = "142 GPa"', "youngs_modulus = 0", "materials.nmc.youngs_modulus", "greater than 0"),
        ('youngs_modulus = "142 GPa"', "youngs_modulus = -1e9", "materials.nmc.youngs_modulus", "greater than 0"),
        ('youngs_modulus = "142 GPa"', "youngs_modulus = nan", "materials.nmc.youngs_modulus", "nan"),
        ('youngs_modulus = "142 GPa"', "youngs_modulus = inf", "materials.nmc.youngs_modulus", "finite"),
        ("poissons_ratio = 0.25", "poissons_ratio = -0.1", "materials.nmc.poissons_ratio", "at least 0"),
        ("poissons_ratio = 0.25", "poissons_ratio = 0.5", "materials.nmc.poissons_ratio", "less than 0.5"),
        ("poissons_ratio = 0.25", "", "materials.nmc.poissons_ratio", "is needed"),
        ("yield_stress = 7.9e9", "", "materials.nmc.yield_stress", "7.9 GPa"),
        ('unload_from = [0.05, "10 %"]', "unload_from = [1.2]", "curves.plastic.unload_from[0]", "less than 1"),
        ('unload_from = [0.05, "10 %"]', "unload_from = [0.2]\nmax_overlap = 0.1", "curves.plastic.unload_from", "beyond max_overlap"),
    ],
)
def test_one_wrong_value_is_named_with_its_bound(tmp_path: Path, line: str, instead: str, name: str, words: str) -> None:
    assert line in GOOD
    assert words in problems(tmp_path, GOOD.replace(line, instead))[name]


def test_a_packing_that_cannot_be_reached_is_refused_before_computing(tmp_path: Path) -> None:
    scene = """
    [fits.law]
    law = "thornton"
    curves = ["plastic"]
    [scenes.dense]
    fit = "law"
    radius = "5 um"
    density = "4750 kg/m^3"
    count = 100
    packing_fraction = 0.7
    strain = 0.03
    strain_rate = 1e4
    """
    assert "0.64" in problems(tmp_path, GOOD + scene)["scenes.dense.packing_fraction"]


@pytest.mark.parametrize("text", ["[materials", "a = b", "\x00"])
def test_what_is_no_toml_is_said_so(tmp_path: Path, text: str) -> None:
    (message,) = problems(tmp_path, text).values()
    assert "TOML" in message


def test_a_missing_file_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        reading.read_case(tmp_path / "nowhere.toml")


def test_files_that_a_case_names_are_read_before_computing(tmp_path: Path) -> None:
    """Damaged measured curves and laws are found with all other mistakes, each under the table that names it."""
    (tmp_path / "nan.csv").write_text("overlap,force\n0,0\n1e-7,nan\n2e-7,1\n")
    (tmp_path / "sizeless.csv").write_text("overlap,force\n0,0\n1e-7,0.5\n2e-7,1\n")
    (tmp_path / "empty.json").write_text("{}")
    spheres = "radius = 5e-6\ndensity = 4750\n"
    found = problems(
        tmp_path,
        f"""{GOOD}
        [fits.a]
        law = "hertz"
        curves = ["nan.csv"]
        radius = 5e-6
        [fits.b]
        law = "hert"
        curves = ["sizeless.csv"]
        [impacts.c]
        fit = "empty.json"
        speed = [1]
        {spheres}
        [scenes.d]
        fit = "empty.json"
        count = 20
        packing_fraction = 0.7
        strain = 0.01
        {spheres}""",
    )
    messages = "\n".join(found.values())
    assert any(name.startswith("fits.a: ") and "nan.csv" in name for name in found), messages
    assert "sizeless.csv does not say how large" in found["fits.b: radius"]
    assert "did you mean 'hertz'?" in found["fits.b.law"]
    assert any(name.startswith("impacts.c.fit: ") for name in found), messages
    assert any(name.startswith("scenes.d.fit: ") for name in found), messages
    assert "0.64" in found["scenes.d.packing_fraction"]


def test_the_law_of_a_scene_is_read_before_computing(tmp_path: Path) -> None:
    (tmp_path / "empty.json").write_text("")
    (tmp_path / "scene.toml").write_text(
        "law = 'empty.json'\nradius = 1\ndensity = -1\ncount = 20\npacking_fraction = 0.5\nstrain = 0.01\n"
    )
    with pytest.raises(InputError) as caught:
        reading.read_scene(tmp_path / "scene.toml", None)
    assert {problem.name.split(":")[0] for problem in caught.value.problems} == {"density", "law"}


@pytest.mark.parametrize("second", ["plastic", "same"])
def test_the_same_law_on_the_same_curves_is_refused(tmp_path: Path, second: str) -> None:
    """Also under another name: `same` is the first curve word for word. A curve that goes further is another curve."""
    curves = '[curves.same]\nmaterial = "nmc"\nradius = 5e-6\nunload_from = [0.05, 0.1]\nmax_overlap = 0.1\n'
    fits = f'[fits.a]\nlaw = "thornton"\ncurves = ["plastic"]\n[fits.b]\nlaw = "thornton"\ncurves = ["{second}"]\n'
    assert "same curves as fits.a" in problems(tmp_path, GOOD + curves + fits)["fits.b"]
    (tmp_path / "case.toml").write_text(
        GOOD + curves.replace("max_overlap = 0.1", "max_overlap = 0.2") + fits.replace("plastic", "same", 1)
    )
    if second == "plastic":
        assert set(reading.read_case(tmp_path / "case.toml").fits) == {"a", "b"}
