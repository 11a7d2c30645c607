"""Every output says which code made it, and on which libraries."""

from __future__ import annotations

import importlib.metadata

import pytest

from contactlaws import version
from contactlaws.sources import PACKAGES, source_hash


def test_release_sources_and_libraries_are_named() -> None:
    said = version.code_version()
    assert said.startswith(f"fe2dem {version.__version__} (sources {source_hash(*PACKAGES)})")
    for name in ("numpy", "scipy", "numba"):
        assert f"{name} {importlib.metadata.version(name)}" in said


def test_other_libraries_are_another_version_of_the_same_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    here = version.code_version()
    monkeypatch.setattr(version, "_version", lambda name: "0.0")
    elsewhere = version.code_version.__wrapped__()
    assert elsewhere != here
    assert version.sources_alone(elsewhere) == version.sources_alone(here)
