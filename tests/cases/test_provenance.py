"""Tables that leave their folder still say which code made them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from cases.report import history
from cases.tradeoff import page
from contactlaws import unloading_table
from contactlaws.version import code_version


def _unloadings(folder: Path) -> Path:
    return unloading_table.write_table([dict.fromkeys(unloading_table.UNITS)], folder / "table.parquet")


def _scene(folder: Path) -> Path:
    return history.write({name: np.zeros(2) for name in history.UNITS}, folder / "table.parquet")


def _scores(folder: Path) -> Path:
    return page.write_table([{"law": "hertz", "force": 0.1}], folder / "table")[1]


@pytest.mark.parametrize("write", [_unloadings, _scene, _scores], ids=["unloadings", "scene", "scores"])
def test_a_table_in_parquet_names_its_code(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    assert pq.read_schema(write(tmp_path)).metadata[b"code"].decode() == code_version()
