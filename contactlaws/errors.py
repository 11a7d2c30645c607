"""The one error that bad input raises, carrying every problem found at once."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple


class Problem(NamedTuple):
    """One thing wrong with an input: what it is, what bound it breaks, and what to do about it."""

    name: str
    value: Any
    bound: str
    remedy: str

    def __str__(self) -> str:
        plain = self.value.item() if getattr(self.value, "ndim", None) == 0 else self.value  # numpy's scalars print their type
        value = "missing" if plain is None else f"= {plain!r}"
        return f"{self.name} {value}: {self.bound}; {self.remedy}"


class InputError(ValueError):
    """Raised before any computing when an input cannot be used; `problems` lists all that is wrong.

    >>> raise InputError([Problem("poissons_ratio", 0.5, "must lie in [0, 0.5)", "use 0.499 or less")])
    Traceback (most recent call last):
    ...
    contactlaws.errors.InputError: poissons_ratio = 0.5: must lie in [0, 0.5); use 0.499 or less
    """

    def __init__(self, problems: Problem | Iterable[Problem]):
        self.problems = (problems,) if isinstance(problems, Problem) else tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))


def require(problems: Iterable[Problem]) -> None:
    """Raise `InputError` with all of them if there are any problems; return silently if there are none."""
    found = tuple(problems)
    if found:
        raise InputError(found)
