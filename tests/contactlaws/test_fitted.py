"""Fitted laws on disk: every bit comes back, everything else is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw, load, save
from tests.contactlaws.samples import CASES, NAMES, NMC


@pytest.mark.parametrize(("law", "deepest"), CASES, ids=NAMES)
def test_every_bit_comes_back(tmp_path: Path, law: Any, deepest: float):
    fitted = FittedLaw(law, deepest * (1 + 1e-16) / 3, NMC, ("abc",), {"radius": 1e-300 / 3, law._fields[1]: None})
    again = load(save(fitted, tmp_path / "law.json"))
    assert type(again.law) is type(law)
    for one, two in zip(again.law, law, strict=True):
        np.testing.assert_array_equal(one, two)
    assert (again.max_overlap, again.material, again.curve_hashes) == (fitted.max_overlap, NMC, ("abc",))
    assert dict(again.standard_errors) == dict(fitted.standard_errors)
    assert again.code_version == fitted.code_version
    assert again.source


def changed(path: Path, old: str, new: str) -> Path:
    law, deepest = CASES[NAMES.index("thornton-0")]
    text = save(FittedLaw(law, deepest, NMC, ("abc",), {"yield_pressure": 1e8}), path).read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return path


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"thornton"', '"thorton"', "did you mean 'thornton'"),
        ('"law": "thornton",', "", "law missing"),
        ('"max_overlap"', '"max_overlapp"', "did you mean 'max_overlap'"),
        ('"max_overlap": 5e-07', '"max_overlap": NaN', "finite numbers only"),
        ('"max_overlap": 5e-07', '"max_overlap": 1e999', "max_overlap = inf: must be a finite number"),
        ('"max_overlap": 5e-07', '"max_overlap": 6e-06', r"must lie in \(0, radius"),
        ('"max_overlap": 5e-07', '"max_overlap": true', "must be a finite number"),
        ('"radius": 5e-06', '"radius": "5 um"', "radius = '5 um': must be a finite number"),
        ('"radius": 5e-06', '"radius": 0.0', "radius = 0.0: must be positive"),
        ('"radius": 5e-06', '"radius": 5e-06, "radius": 1.0', "stands there twice"),
        ('"reduced_modulus": 151', '"reduced_modulus": -151', "must push, with a finite force"),
        ('"poissons_ratio": 0.25', '"poissons_ratio": 0.5', r"must lie in \[0, 0.5\)"),
        ('"yield_pressure": 100000000.0', '"yield_presure": 1.0', r"standard_errors\[yield_presure\]"),
        ('"curve_hashes": [\n    "abc"\n  ]', '"curve_hashes": "abc"', "must be a list of texts"),
        ("{", "", "is no JSON"),
        ('"law": "thornton"', '"law": {"a": 1}', "law = {'a': 1}: must be one of"),
        ('"law": "thornton"', '"law": ["thornton"]', "must be one of"),
        ('"law": "thornton"', '"law": ' + 60 * "[" + 60 * "]", "nested too deeply"),
        ('"law": "thornton"', '"law": ' + 99999 * "[", "nested too deeply"),
        ('"max_overlap": 5e-07', '"max_overlap": 1' + 400 * "0", "max_overlap = 10+: must be a finite number"),
        ('"max_overlap": 5e-07', '"max_overlap": 1' + 9999 * "0", "is no JSON of a law"),
        ('"radius": 5e-06', '"radius": 1' + 400 * "0", "radius = 10+: must be a finite number"),
        ('"yield_pressure": 100000000.0', '"yield_pressure": 1' + 400 * "0", "must map parameters to numbers"),
        ("fe2dem fitted law 1", "fe2dem fitted law 9", "read it with the release that wrote it"),
    ],
)
def test_anything_else_is_refused(tmp_path: Path, old: str, new: str, expected: str):
    with pytest.raises(InputError, match=expected):
        load(changed(tmp_path / "law.json", old, new))


def test_a_file_of_something_else(tmp_path: Path):
    file = tmp_path / "law.json"
    file.write_text(json.dumps([1, 2]))
    with pytest.raises(InputError, match="must be a mapping"):
        load(file)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="no text in UTF-8"):
        load(file)
    with pytest.raises(InputError, match="check the name"):
        load(tmp_path / "none.json")
