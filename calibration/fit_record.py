"""A fitted law with everything that says how good it is; and what any fit asks of its curves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from calibration.prony_record import SeriesFit
from calibration.residuals import Measures
from contactlaws.curve import Curve
from contactlaws.errors import Problem
from contactlaws.fitted import FittedLaw

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Fit:
    """A fitted law and everything that says how good it is."""

    fitted: FittedLaw  # the record, its range, its standard errors: what `contactlaws.fitted.save` writes
    free: tuple[str, ...]  # the fitted parameters, in the order of `correlation`
    correlation: FloatArray  # NaN for a parameter that the curves say nothing about
    condition_number: float  # of the scaled Jacobian; infinite with such a parameter
    misfit: float  # residuals over the curves' own error; above 1 the law is the limit
    residuals: Measures
    warnings: tuple[str, ...]
    evaluations: int | None  # of the law along all curves, without those for derivatives; None: not counted
    series: SeriesFit | None = None  # of a viscoelastic law: how its relaxation times were found

    @property
    def law(self) -> Any:
        """The law record."""
        return self.fitted.law

    @property
    def standard_errors(self) -> Mapping[str, float | None]:
        """In the unit of each free parameter; None: the curves say nothing about it."""
        return self.fitted.standard_errors


def stops(curves: Sequence[Curve]) -> Iterator[str]:
    """One sentence for each curve that ends before its programme does."""
    for curve in curves:
        if curve.stopped:
            yield f"curve {curve.content_hash} ends early: {curve.stopped}"


def problems_with_bodies(curves: Sequence[Curve]) -> Iterator[Problem]:
    """All curves must be of one body and one material."""
    first = curves[0]
    for number, curve in enumerate(curves[1:], 1):
        if not math.isclose(curve.radius, first.radius, rel_tol=1e-9) or curve.aspect != first.aspect:
            yield Problem(
                f"curves[{number}]", (curve.radius, curve.aspect), "is of another body (radius, aspect)", "fit each body on its own"
            )
        if not _same_elasticity(curve, first):
            yield Problem(
                f"curves[{number}]", curve.material, f"is of another material than {first.material}", "fit each material on its own"
            )


def _same_elasticity(curve: Curve, other: Curve) -> bool:
    """The same material, or its elastic version."""
    if curve.material is None or other.material is None:
        return curve.material is other.material
    one, two = curve.material, other.material
    same = math.isclose(one.youngs_modulus, two.youngs_modulus, rel_tol=1e-9) and math.isclose(
        one.poissons_ratio, two.poissons_ratio, abs_tol=1e-12
    )
    return same and (one.yield_stress is None or two.yield_stress is None or math.isclose(one.yield_stress, two.yield_stress, rel_tol=1e-9))
