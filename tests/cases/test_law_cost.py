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
    assert {dispatch.law_of(law).name for law in found.values()} == own
    assert next(iter(found)) == "hertz"
    assert all(label.split(",")[0] == dispatch.law_of(law).name for label, law in found.items())
    assert [law.times.size for label, law in found.items() if label.startswith("maxwell_zener,")] == list(law_cost.TERMS)


def test_each_phase_is_given_as_a_ratio_to_hertz(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"SPHERES": 200, "CONTACTS": 100, "PASSES": 5}.items():
        monkeypatch.setattr(law_cost, name, value)
    laws = law_cost.records(["thornton", "kuwabara_kono"])
    found = law_cost.measure(laws)
    assert list(found) == ["hertz", "kuwabara_kono", "thornton"]
    assert all(value > 0.0 for cost in found.values() for part in cost for value in part)
    head, hertz, damped, thornton = law_cost.rows(found, laws)
    assert head.count("unloading") == 2
    assert hertz.count("as loading") == 4
    assert thornton.count("(") == damped.count("(") == 6


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(InputError, match="must be one of"):
        law_cost.records(["herz"])
