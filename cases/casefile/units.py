"""From what a person writes ("142 GPa", "5 um", 0.05) to SI floats; the only place where units are read."""

from __future__ import annotations

import functools
import re
from typing import Any

from contactlaws.errors import InputError, Problem

#: an example for each SI unit that inputs come in, shown in remedies
EXAMPLES = {"Pa": "142 GPa", "m": "5 um", "kg/m^3": "4750 kg/m^3", "m/s": "0.5 m/s", "1/s": "10 1/s", "s": "1 s", "": "0.25"}


@functools.cache
def _registry() -> Any:
    import pint  # takes a third of a second to load, and most numbers are bare

    return pint.UnitRegistry(on_redefinition="ignore")


def si(value: object, unit: str, name: str = "value") -> float:
    """Return `value` in the SI unit `unit`; bare numbers are SI already. Raises `InputError` on text that is no such quantity.

    >>> si("142 GPa", "Pa"), si("5 um", "m"), si(0.05, "m"), si("3 %", "")
    (142000000000.0, 5e-06, 0.05, 0.03)
    >>> si("70 mm", "Pa", "youngs_modulus")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    contactlaws.errors.InputError: youngs_modulus = '70 mm': is a length, but ...
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, str):
        raise InputError(Problem(name, value, "is not a number", _remedy(unit)))
    try:
        return float(value)
    except ValueError:
        return _quantity(value, unit, name)


@functools.lru_cache(maxsize=1000)
def _factor(text: str, unit: str) -> float | None:
    """What a number before the unit `text` is multiplied by to have it in `unit`; None if that is not all there is to it."""
    try:
        one, two = (_registry().Quantity(number, text.replace("%", " percent")).to(unit).magnitude for number in (1.0, 2.0))
    except Exception:  # no such unit, another dimension: the long way says what is wrong
        return None
    return float(one) if two == 2.0 * one else None


def _quantity(text: str, unit: str, name: str) -> float:
    found = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*?)\s*", text)
    factor = None if found is None else _factor(found[2], unit)  # a list has many numbers in the same unit
    if found is not None and factor is not None:
        return float(f"{float(found[1]) * factor:.15g}")
    registry = _registry()
    try:
        quantity = registry.Quantity(text.replace("%", " percent"))
        wrong = None if quantity.is_compatible_with(unit) else _dimension(quantity)
        # rounded to 15 digits so that '142 GPa' is exactly 142e9
        return (
            float(f"{quantity.to(unit).magnitude:.15g}")
            if wrong is None
            else _fail(name, text, f"is {wrong}, but {unit or 'a pure number'} is needed", unit)
        )
    except InputError:
        raise
    except Exception as error:  # pint raises a dozen kinds, from tokenising to undefined units
        return _fail(name, text, f"is not a quantity that can be read ({str(error).splitlines()[0]})", unit)


def _fail(name: str, text: str, bound: str, unit: str) -> float:
    raise InputError(Problem(name, text, bound, _remedy(unit)))


def _remedy(unit: str) -> str:
    return f"write it like '{EXAMPLES.get(unit, '1 ' + unit)}', or as a bare number{' in ' + unit if unit else ''}"


def _dimension(quantity: Any) -> str:
    """A word for the dimension of a wrong quantity, as in 'a length'."""
    words = {
        "m": "a length",
        "kg": "a mass",
        "s": "a time",
        "": "a pure number",
        "Pa": "a stress",
        "N": "a force",
        "kg/m^3": "a density",
        "m/s": "a speed",
    }
    return next((word for unit, word in words.items() if quantity.is_compatible_with(unit)), f"of dimension {quantity.dimensionality}")


def is_bare(text: str) -> bool:
    """Whether a text is a number without a unit.

    >>> is_bare("1e-3"), is_bare("5 um")
    (True, False)
    """
    try:
        float(text)
    except ValueError:
        return False
    return True
