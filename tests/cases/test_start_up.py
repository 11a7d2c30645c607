"""Who needs no compiled code doesn't wait for it: each statement in a process of its own."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytestmark = pytest.mark.compiled_only(reason="nothing is compiled here")


def loaded(statement: str) -> set[str]:
    """The packages that a process has loaded after `statement`."""
    code = f"{statement}\nimport sys; print(*{{name.split('.')[0] for name in sys.modules}})"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


@pytest.mark.parametrize(
    "module", ["contactlaws.errors", "contactlaws.curve", "contactlaws.version", "cases.command", "cases.status", "cases.study"]
)
def test_errors_files_and_the_plan_of_a_study_need_no_compiler(module: str) -> None:
    assert not {"numba", "scipy", "matplotlib", "pyarrow", "pint"} & loaded(f"import {module}")


def test_help_and_status_need_neither_compiler_nor_arrays() -> None:
    assert not {"numba", "numpy", "scipy", "rich", "pydantic"} & loaded("import cases.command")
    assert not {"numba", "numpy", "scipy", "pydantic"} & loaded("import cases.status")


def test_a_worker_loads_no_pictures() -> None:
    assert not {"matplotlib", "pint", "meshio", "pydantic", "rich"} & loaded("import cases.batch.worker, cases.batch.work.curves")


def test_laws_are_known_before_anybody_has_imported_one() -> None:
    code = "from contactlaws import dispatch; print(*dispatch.laws())"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert {"hertz", "thornton", "edmans_sinka", "tabulated", "whole_range", "mdr"} <= set(found)


def test_a_name_of_this_project_is_taken_before_its_law_is_loaded() -> None:
    code = """
from typing import NamedTuple
from contactlaws import dispatch
from contactlaws.errors import InputError
class Mine(NamedTuple):
    radius: float
try:
    dispatch.register(dispatch.Law("mdr", Mine, None, None, None, None, (), "a user"))
except InputError as error:
    print(error.problems[0].bound)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "is registered already"
