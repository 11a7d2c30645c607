"""A key changes with what the code does, not with how it is written; and only with code that its result depends on."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cases.batch import sources
from contactlaws.sources import PACKAGES, ROOT

pytestmark = pytest.mark.compiled_only(reason="nothing is compiled here")

CURVES, FITS = "cases.batch.work.curves", "cases.batch.work.fits"


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def meaning(start: str, root: Path) -> str:
    """As of now: what was read of other files before is forgotten."""
    for cached in (sources.meaning_hash, sources._module_hash, sources._tree):
        cached.cache_clear()
    return sources.meaning_hash(start, root)


def append(file: Path, text: str) -> None:
    file.write_text(file.read_text() + text)


def test_a_copy_of_the_sources_means_the_same(copy: Path) -> None:
    assert meaning(CURVES, copy) == meaning(CURVES, ROOT)
    assert meaning(CURVES, copy) != meaning(FITS, copy)


def test_comments_docstrings_and_layout_renew_nothing(copy: Path) -> None:
    before = meaning(CURVES, copy)
    file = copy / "fem" / "newton.py"
    text = file.read_text()
    first = text.index('"""')
    file.write_text('"""Another docstring."""' + text[text.index('"""', first + 3) + 3 :].replace("\n\n", "\n\n\n") + "\n# a comment\n")
    assert file.read_text() != text
    assert meaning(CURVES, copy) == before


def test_an_edit_of_the_solver_renews_curves(copy: Path) -> None:
    before = meaning(CURVES, copy), meaning(FITS, copy)
    append(copy / "fem" / "stress.py", "\nLIMIT = 1.0\n")
    assert meaning(CURVES, copy) != before[0]
    assert meaning(FITS, copy) == before[1] or "fem.stress" in sources.modules_behind(FITS, copy)


@pytest.mark.parametrize(
    "module", ["calibration/fit.py", "contactlaws/edmans_sinka.py", "contactlaws/tabulated.py", "dem/forces.py", "cases/report/page.py"]
)
def test_an_edit_of_a_law_of_the_fit_or_of_the_dem_renews_no_curve(copy: Path, module: str) -> None:
    before = meaning(CURVES, copy)
    append(copy / module, "\nLIMIT = 1.0\n")
    assert meaning(CURVES, copy) == before


@pytest.mark.parametrize("module", ["calibration/fit.py", "contactlaws/elastoplastic.py", "contactlaws/tabulated.py"])
def test_an_edit_of_a_law_or_of_the_fit_renews_fits(copy: Path, module: str) -> None:
    before = meaning(FITS, copy)
    append(copy / module, "\nLIMIT = 1.0\n")
    assert meaning(FITS, copy) != before


@pytest.mark.parametrize("kind", ["impacts", "scenes"])
def test_what_uses_any_law_depends_on_all_of_them(kind: str) -> None:
    """A law comes from a file: nothing else says which one it is."""
    behind = sources.modules_behind(f"cases.batch.work.{kind}")
    assert {"contactlaws.elastic", "contactlaws.elastoplastic", "contactlaws.edmans_sinka", "contactlaws.tabulated"} <= behind


def test_what_pressing_a_body_loads_is_found_by_reading_the_sources() -> None:
    """Against Python itself, with packages whose `__init__` brings nothing along."""
    code = """
import sys, types
from contactlaws.sources import PACKAGES, ROOT
for name in [name for name in sys.modules if name.split(".")[0] in PACKAGES]:
    del sys.modules[name]
for package in ("contactlaws", "fem"):
    sys.modules[package] = types.ModuleType(package)
    sys.modules[package].__path__ = [str(ROOT / package)]
import cases.batch.work.curves
print(*(name for name in sys.modules if name.split(".")[0] in ("contactlaws", "fem", "calibration", "dem")))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = {name for name in done.stdout.split() if "." in name and not sources._without_numbers(name)}
    assert {"fem.press", "fem.newton"} <= loaded <= sources.modules_behind(CURVES)
