"""JSON that strangers wrote: what the parser accepts and arithmetic does not is refused like any other bad JSON."""

from __future__ import annotations

import json
from typing import Any

#: levels of brackets; our own files have 4, and printing many more in an error would fail
DEEPEST = 50


def parsed(text: str, **hooks: Any) -> Any:
    """`json.loads` with its hooks; raises `ValueError`, never `RecursionError`, for a text that is nested too deeply."""
    try:
        content = json.loads(text, **hooks)
    except RecursionError:
        raise ValueError("nested too deeply") from None
    level = [content]
    for _ in range(DEEPEST):
        level = [part for whole in level for part in _parts(whole)]
        if not level:
            return content
    raise ValueError("nested too deeply")


def _parts(whole: Any) -> list[Any]:
    """The lists and mappings inside a list or mapping; a number or text has none."""
    inside = whole.values() if isinstance(whole, dict) else whole if isinstance(whole, list) else ()
    return [part for part in inside if isinstance(part, dict | list)]


def is_number(value: object) -> bool:
    """A finite number that a float can hold; not a truth value.

    >>> is_number(1), is_number(True), is_number(float("inf")), is_number(10**400)
    (True, False, False, False)
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        number = float(value)
    except OverflowError:  # an integer beyond 1.8e308
        return False
    return number - number == 0.0
