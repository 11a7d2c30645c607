"""The benchmark of laws: that all are there, not how fast they are."""

from __future__ import annotations

import pytest

from cases.benchmarks import law_cost
from contactlaws import dispatch
from contactlaws.errors import InputError

pytestmark = pytest.mark.compiled_only(reason="it times compiled code")


def test_every_law_of_this_project_is_measured() -> None:
    own = {name for name, law in dispatch.laws().items() if law.record.__module__.startswith("contactlaws.")}
    found = law_cost.records()
    assert set(found) == own
    assert next(iter(found)) == "hertz"
    assert all(dispatch.law_of(law).name == name for name, law in found.items())


def test_each_phase_is_given_as_a_ratio_to_hertz(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"SPHERES": 200, "CONTACTS": 100, "PASSES": 5}.items():
        monkeypatch.setattr(law_cost, name, value)
    found = law_cost.measure(law_cost.records(["thornton"]))
    assert list(found) == ["hertz", "thornton"]
    assert all(value > 0.0 for cost in found.values() for part in cost for value in part)
    head, hertz, thornton = law_cost.rows(found, {"hertz": 0, "thornton": 1})
    assert head.count("unloading") == 2
    assert hertz.count("as loading") == 4
    assert thornton.count("(") == 6


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(InputError, match="must be one of"):
        law_cost.records(["herz"])
