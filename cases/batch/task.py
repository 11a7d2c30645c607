"""One result to be computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

KINDS = ("curves", "packings", "fits", "draws", "impacts", "scenes")  # each stands behind what it needs


@dataclass(frozen=True)
class Task:
    """One result to be computed; `values` are JSON types, `needs` the tasks it is made from, `given` the user's own files."""

    kind: str
    name: str
    values: Mapping[str, Any]
    needs: tuple[str, ...] = ()
    given: tuple[str, ...] = ()
    key: str = field(default="", compare=False)  # hexadecimal: of all that the result depends on; tasks with the same key are the same task
    input: str = field(default="", compare=False)  # the same without the sources

    @property
    def id(self) -> str:
        """KIND.NAME, unique in a case."""
        return f"{self.kind}.{self.name}"

    @property
    def weight(self) -> float:
        """About how long it takes, in seconds of one core: for the order of the tasks, and for the time left until some are measured."""
        values = self.values
        if self.kind == "curves":
            return float(self._seconds_of_curve() * (0.01 / values.get("tolerance", 0.01)) ** 1.5)
        if self.kind in ("packings", "scenes"):
            return float(values.get("count", 100)) / (500.0 if self.kind == "packings" else 20.0)
        return 0.3

    def _seconds_of_curve(self) -> float:
        """Of a reference curve at a tolerance of 1 %: stiff bodies take longest, elastic ones unload for nothing."""
        material = self.values.get("material", {})
        if material.get("yield_stress") is None:
            return 0.6
        stiffness = max(1.0, material["youngs_modulus"] / material["yield_stress"])
        return (0.6 + 0.03 * len(self.values.get("unload_from", ()))) * (1.0 + 0.24 * math.log(stiffness))
