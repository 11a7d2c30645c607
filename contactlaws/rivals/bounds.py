"""What the constants of a rival must keep to, or its formulas mean nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from contactlaws.errors import Problem

#: of a law that follows from its material
MATERIAL = {"reduced_modulus": 0.0, "yield_stress": 0.0}


def at_least(least: Mapping[str, float]) -> Callable[[Any], Iterator[Problem]]:
    """A check of records: the named fields are finite and not below these values (above, where the value is 0).

    >>> from contactlaws.rivals.luding import Luding
    >>> [problem.name for problem in at_least({"stiffness_ratio": 1.0})(Luding(1.0, 10.0, 0.5, 0.1))]
    ['stiffness_ratio']
    """

    def problems(law: Any) -> Iterator[Problem]:
        for name, bound in least.items():
            value = getattr(law, name)
            if not (math.isfinite(value) and (value > bound if bound == 0.0 else value >= bound)):
                said = "must be positive" if bound == 0.0 else f"must be {bound:g} or more"
                yield Problem(name, value, said, "fit the law, or repair its constants")

    return problems
