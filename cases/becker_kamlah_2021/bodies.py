"""Bodies that the paper names: that of Figs. 9 to 11 with the pressure on its contact, and the two pairs of the validation.

The pairs are triaxial, which a solver of bodies of revolution cannot press. Their law knows them by R_e/r alone, apart from units: in
d/d_Y and F/F_pY it is the law of every pair with the same lambda_max, epsilon_max. Beside it stands the spheroid with the same R_e/r.
Runs are kept in a folder whose name carries a hash of the solver's sources: with other sources they are made again.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

import fem
from calibration.spheroid_curves import NMC, TOLERANCE
from cases.batch.sources import meaning_hash
from cases.batch.store import hash_of
from cases.becker_kamlah_2021.data import Body
from cases.edmans_sinka_2020.inside import Body as Pressed
from cases.report.plots import fields_in
from contactlaws.curve import FloatArray
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.ellipsoid import Gap, curvature, gap
from contactlaws.files import write_text
from contactlaws.material import Material
from contactlaws.rivals.becker_kamlah import BeckerKamlah, becker_kamlah_loading, becker_kamlah_yield_overlap
from contactlaws.rivals.becker_kamlah_ellipsoid import BeckerKamlahEllipsoid, EllipseContact, contact_of, relative_radius
from fem.cycle import Measures, measures, press_cycle

Axes = tuple[float, float, float]

#: b/a of both bodies of Figs. 10 and 11; Fig. 9 does not say
PAPERS_ASPECT = 0.66
#: overlaps of the pressure profiles, over that of first yield by the paper's measure: two elastic ones, then to 15 % of the mean radius
PROFILES = (0.4, 0.85, 1.5, 3.0, 6.0, 15.0)
#: of the run with profiles, finer than the curves'
PROFILE_TOLERANCE = 0.001
#: the paper's material
PAPERS = Material(142e9, 0.25, 7.9e9)


class Profile(NamedTuple):
    """Pressure over the contact of one overlap; lengths over c_Y, pressures over Y."""

    depth: float  # overlap over delta_Y
    place: FloatArray
    pressure: FloatArray

    @property
    def largest(self) -> float:
        """At or near the centre, where the innermost node's share of the surface is too small to be read."""
        return float(self.pressure[1:].max())


class Case(NamedTuple):
    """One pair of the validation: proportions of both bodies, pressed along the first axis of each."""

    number: str  # of the figure
    first: Axes
    second: Axes
    mean_radius: float  # m; of each
    turns: tuple[float, float]  # overlaps at which it turns back, over the mean radius of both
    papers_error: float  # mean error that the paper states

    @property
    def gap(self) -> Gap:
        """Between the undeformed bodies, their other axes parallel."""
        tensors = [curvature(axes, (axes[0], 0.0, 0.0)).tensor for axes in (self.scaled(self.first), self.scaled(self.second))]
        return gap(tensors[0], tensors[1], np.array([1.0, 0.0, 0.0]))

    def scaled(self, proportions: Axes) -> Axes:
        """Semi-axes in m."""
        unit = self.mean_radius / math.cbrt(math.prod(proportions))
        return proportions[0] * unit, proportions[1] * unit, proportions[2] * unit

    @property
    def relative(self) -> float:
        """R_e/(r_I + r_J)."""
        return relative_radius(self.gap.effective_radius, self.mean_radius, self.mean_radius)

    @property
    def contact(self) -> EllipseContact:
        """The published law."""
        law = BeckerKamlahEllipsoid(0.5 * PAPERS.reduced_modulus, PAPERS.stress_unit)
        return contact_of(law, self.gap, self.mean_radius, self.mean_radius)

    @property
    def spheres(self) -> BeckerKamlah:
        """The law of two spheres with the same mean radius."""
        law = BeckerKamlahEllipsoid(0.5 * PAPERS.reduced_modulus, PAPERS.stress_unit)
        return contact_of(law, Gap(1.0 / self.mean_radius, 1.0 / self.mean_radius, np.eye(3)[:2]), self.mean_radius, self.mean_radius).law

    @property
    def aspect(self) -> float:
        """b/a of the spheroid with the same R_e/r."""
        return (4.0 * self.relative) ** 0.75

    @property
    def unit(self) -> tuple[float, float]:
        """delta_Y in m and F_pY in N."""
        limit = float(becker_kamlah_yield_overlap(self.contact.law))
        return limit, float(becker_kamlah_loading(self.contact.law, limit))


CASES = (
    Case("13", (1.0, 1.25, 1.5), (1.0, 0.5, 0.8), 4.675e-6, (0.045, 0.1), 0.0101),
    Case("15", (1.0, 1.0, 0.8), (1.0, 1.25, 1.25), 10e-6, (0.1, 0.13), 0.0059),
)


class Named(NamedTuple):
    """What was computed of the bodies that the paper names."""

    papers: Body
    profiles: list[Profile]
    cases: list[tuple[Case, Body]]  # with the spheroid of the same R_e/r
    cycles: list[Measures]  # two to separation, from the first turn, of each of these spheroids


def compute(place: Path, say: Callable[[str], None]) -> Named:
    """All of it, from `place` where it is there."""
    folder = place / hash_of(PROFILES, PROFILE_TOLERANCE, TOLERANCE, [case.turns for case in CASES], meaning_hash("fem.cycle"))
    folder.mkdir(parents=True, exist_ok=True)
    papers = _pressed(folder, PAPERS_ASPECT, profile_overlaps(), PROFILE_TOLERANCE, say, fields=folder / "fields")
    spheroids = [
        (case, _pressed(folder, case.aspect, tuple(turn * case.aspect ** (2.0 / 3.0) for turn in case.turns), TOLERANCE, say))
        for case in CASES
    ]
    return Named(papers, profiles(papers, folder / "fields"), spheroids, [loop for case in CASES for loop in _cycles(folder, case)])


def _cycles(folder: Path, case: Case) -> list[Measures]:
    """Unloaded and reloaded twice from its first turn."""
    path = folder / f"cycles_b{case.aspect:.5g}.json"
    if not path.exists():
        curve = press_cycle(NMC, case.turns[0] * case.aspect ** (2.0 / 3.0), (0.0, 0.0), aspect=case.aspect)
        write_text(path, json.dumps([measures(curve, number) for number in range(2)]))
    return [Measures(*row) for row in json.loads(path.read_text())]


def profile_overlaps() -> tuple[float, ...]:
    """Over half the height."""
    ratio = 0.5 * math.pi * 1.6 / NMC.reduced_modulus
    return tuple(depth * (ratio * PAPERS_ASPECT) ** 2 for depth in PROFILES)


def profiles(body: Body, folder: Path) -> list[Profile]:
    """The pressures that a run has left in `folder`."""
    unit = math.sqrt(body.radius * body.yield_overlap)
    found = []
    for field in fields_in(folder, "loading"):
        place, pressure = Pressed(field, *_numbers(body.material)).contact_pressure()
        edge = float(np.interp(field.depth, body.overlap, body.contact_radius))
        place, pressure = np.append(place, max(edge, place[-1])), np.append(pressure, 0.0)
        found.append(Profile(field.depth / body.yield_overlap, place / unit, pressure / body.material.stress_unit))
    return found


def _numbers(material: Material) -> tuple[float, float]:
    return material.youngs_modulus / material.stress_unit, material.poissons_ratio


def _pressed(
    folder: Path, aspect: float, starts: tuple[float, ...], tolerance: float, say: Callable[[str], None], fields: Path | None = None
) -> Body:
    path = folder / f"b{aspect:.5g}.parquet"
    if not path.exists():
        say(f"spheroid 1:{aspect:.4g} of the authors' material")
        if fields is not None:
            fields.mkdir(exist_ok=True)
        write_curve(fem.press(NMC, aspect=aspect, unload_from=starts, tolerance=tolerance, fields=fields), path)
    return Body(read_curve(path))
