"""Units are read at the boundary only, and a wrong dimension is never converted silently."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.casefile.units import si
from contactlaws.errors import InputError


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_bare_numbers_are_si(value: float) -> None:
    assert si(value, "Pa") == value
    assert si(repr(value), "Pa") == value


@given(st.floats(1e-3, 1e3), st.sampled_from([("GPa", "Pa", 1e9), ("um", "m", 1e-6), ("g/cm^3", "kg/m^3", 1e3), ("mm/s", "m/s", 1e-3)]))
def test_prefixes_scale(value: float, unit: tuple[str, str, float]) -> None:
    text, base, factor = unit
    # 15 digits are kept, so that '142 GPa' is exactly 142e9
    assert si(f"{value!r} {text}", base) == pytest.approx(value * factor, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "word"), [("70 mm", "Pa", "a length"), ("3 N", "Pa", "a force"), ("2 GPa", "m", "a stress"), ("5", "Pa", None)]
)
def test_wrong_dimension_names_value_bound_and_remedy(text: str, unit: str, word: str | None) -> None:
    if word is None:
        assert si(text, unit) == 5.0
        return
    with pytest.raises(InputError) as caught:
        si(text, unit, "youngs_modulus")
    problem = caught.value.problems[0]
    assert problem.value == text
    assert word in problem.bound
    assert unit in problem.bound
    assert "write it like" in problem.remedy


@pytest.mark.parametrize("value", ["much", "5 potatoes", "", True, None, [1.0]])
def test_what_is_no_number_is_refused(value: object) -> None:
    with pytest.raises(InputError):
        si(value, "m")
