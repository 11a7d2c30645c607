"""What statements are judged by, and the record of a judgement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cases.edmans_sinka_2020.data import Points, Study, force_unit
from cases.edmans_sinka_2020.inside import Inside
from cases.edmans_sinka_2020.refit import Refit
from cases.report.judgement import FAILS, HOLDS, PARTLY, UNTESTED, Finding, Lacking, Statement, verdict
from contactlaws.curve import Curve

FloatArray = npt.NDArray[np.float64]

NU = 0.3

__all__ = ["FAILS", "HOLDS", "NU", "PARTLY", "UNTESTED", "Facts", "Finding", "Lacking", "Statement", "span", "verdict"]


class Loading(NamedTuple):
    """The loading of one material, dimensionless as in the paper."""

    depth: FloatArray
    force: FloatArray
    contact_radius: FloatArray


@dataclass(frozen=True)
class Facts:
    """Everything computed."""

    study: Study
    inside: dict[float, Inside]  # by E/Y, at nu = .3
    refits: list[Refit]

    def curve(self, modulus: float, poisson: float = NU) -> Curve:
        """The curve of a material."""
        if (modulus, poisson) not in self.study.curves:
            raise Lacking(f"E/σ_y = {modulus:g}, ν = {poisson:g}")
        return self.study.curves[modulus, poisson]

    def points(self, modulus: float, poisson: float = NU) -> Points:
        """The unloadings of a material."""
        self.curve(modulus, poisson)
        return self.study.of(modulus, poisson)

    def at(self, quantity: str, modulus: float, depth: float, poisson: float = NU) -> float:
        """One number of one unloading."""
        points = self.points(modulus, poisson)
        row = np.flatnonzero(np.isclose(points.depth, depth, rtol=1e-6))
        if row.size == 0:
            raise Lacking(f"an unloading from {depth:g}")
        return float(getattr(points, quantity)[row[0]])

    def loading(self, modulus: float, poisson: float = NU) -> Loading:
        """The loading of a material, without the row at zero."""
        curve = self.curve(modulus, poisson)
        if curve.contact_radius is None:
            raise Lacking("the contact radius")
        rows = slice(curve.rows(0).start + 1, curve.rows(0).stop)
        return Loading(curve.overlap[rows] / curve.radius, curve.force[rows] / force_unit(curve), curve.contact_radius[rows] / curve.radius)

    def radius_at(self, modulus: float, depth: float, poisson: float = NU) -> float:
        """Contact radius over the radius on the loading."""
        found = self.loading(modulus, poisson)
        return float(np.interp(depth, found.depth, found.contact_radius))

    def within(self, modulus: float) -> Inside:
        """The inside of a material."""
        if modulus not in self.inside:
            raise Lacking(f"the inside of E/σ_y = {modulus:g}")
        return self.inside[modulus]

    def refit(self, reading: str, measure: str) -> Refit:
        """One refit of Eq. 3."""
        for found in self.refits:
            if (found.reading, found.measure) == (reading, measure):
                return found
        raise Lacking(f"the refit {reading}, {measure}")


def span(values: FloatArray | list[float], form: str = ".3g") -> str:
    """The range of some values."""
    return f"{min(values):{form}} to {max(values):{form}}"
