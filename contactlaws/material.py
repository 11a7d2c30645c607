"""What a body is made of, in SI units: the record that every curve, fit and scene refers to."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from contactlaws.errors import Problem, require


class Material(NamedTuple):
    """Isotropic elastic, elastic-perfectly plastic if a yield stress is given (von Mises, on the true stress).

    >>> nmc = Material(youngs_modulus=142e9, poissons_ratio=0.25, yield_stress=7.9e9, density=4750.0)
    >>> round(nmc.reduced_modulus / 1e9, 2)
    151.47
    """

    youngs_modulus: float  # Pa
    poissons_ratio: float  # -
    yield_stress: float | None = None  # Pa; None: purely elastic
    density: float | None = None  # kg/m3; needed only where there is inertia

    @property
    def reduced_modulus(self) -> float:
        """E/(1 - nu^2) in Pa: the effective modulus of one such body on a rigid flat."""
        return self.youngs_modulus / (1.0 - self.poissons_ratio**2)

    @property
    def elastic(self) -> Material:
        """The same material without its yield stress."""
        return self._replace(yield_stress=None)

    @property
    def stress_unit(self) -> float:
        """The stress in Pa by which results are made dimensionless: the yield stress, else Young's modulus."""
        return self.youngs_modulus if self.yield_stress is None else self.yield_stress


def problems_with(material: Material) -> Iterator[Problem]:
    """Yield one `Problem` for every constant of `material` that no solver here can use."""
    for name, symbol in (("youngs_modulus", "E"), ("yield_stress", "Y"), ("density", "rho")):
        value = getattr(material, name)
        if value is None and name != "youngs_modulus":
            continue
        if value is None or not (math.isfinite(value) and value > 0.0):
            yield Problem(
                name, value, f"{symbol} must be a positive finite number", "give it in SI units, or with a unit such as '142 GPa'"
            )
    nu = material.poissons_ratio
    if nu is None or not 0.0 <= nu < 0.5:
        yield Problem("poissons_ratio", nu, "must lie in [0, 0.5)", "for a nearly incompressible body use 0.49")


def checked(material: Material) -> Material:
    """Return `material` unchanged; raise `InputError` naming all its problems if it has any."""
    require(problems_with(material))
    return material
