"""The curves of spheroids, each with its contact as the paper has it; by material, then by shape.

A spheroid a : b : b pressed along a stands for the pair with its mirror image: R_e/(r_I + r_J) = (b/a)^(4/3)/4 goes from .1 to .63, the
whole axis of the paper's Fig. 12. Curves have half height 1 and yield stress 1 (elastic ones: Young's modulus 1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cached_property
from multiprocessing import get_context
from pathlib import Path

from calibration.spheroid_curves import NMC, Spheroid, compute_one, spheroids
from cases.report.judgement import Lacking
from contactlaws.contact_ellipse import Factors
from contactlaws.curve import Curve, FloatArray
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError, Problem
from contactlaws.material import Material
from contactlaws.rivals.becker_kamlah import BeckerKamlah, becker_kamlah_loading, becker_kamlah_yield_overlap
from contactlaws.rivals.becker_kamlah_ellipsoid import BeckerKamlahEllipsoid, becker_kamlah_circle, relative_radius

Key = tuple[float, float]  # E/Y (infinite: elastic), nu

#: of the authors' finite elements: to 15 % of the mean radius
REACH = 0.15
#: a body of revolution touches in a circle
CIRCLE = Factors(1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Body:
    """A spheroid and its curve."""

    curve: Curve

    @property
    def material(self) -> Material:
        """Of the curve."""
        assert self.curve.material is not None
        return self.curve.material

    @property
    def aspect(self) -> float:
        """b/a, equatorial over axial."""
        return self.curve.aspect

    @property
    def radius(self) -> float:
        """R of the pole, b^2/a, in m."""
        return self.curve.radius * self.aspect**2

    @property
    def mean_radius(self) -> float:
        """(a b^2)^(1/3) in m."""
        return self.curve.radius * self.aspect ** (2.0 / 3.0)

    @property
    def relative(self) -> float:
        """R_e/(r_I + r_J) of the body and its mirror image."""
        return relative_radius(self.radius, self.mean_radius)

    @property
    def name(self) -> str:
        """Axial to equatorial semi-axis, as on pages."""
        return f"1:{self.aspect:.3g}"

    @cached_property
    def law(self) -> BeckerKamlah:
        """The published law of this body on the flat, with the constants of Eq. 53."""
        return self.law_with(BeckerKamlahEllipsoid(self.material.reduced_modulus, self.material.stress_unit))

    def law_with(self, constants: BeckerKamlahEllipsoid) -> BeckerKamlah:
        """The same law with other constants."""
        return BeckerKamlah(*becker_kamlah_circle(constants, self.radius, self.relative, CIRCLE.mean_radius, CIRCLE.approach))

    @cached_property
    def yield_overlap(self) -> float:
        """delta_Y in m of the paper: the largest pressure is 1.6 Y."""
        return float(becker_kamlah_yield_overlap(self.law))

    @cached_property
    def yield_force(self) -> float:
        """F_pY in N of the paper."""
        return float(becker_kamlah_loading(self.law, self.yield_overlap))

    @property
    def overlap(self) -> FloatArray:
        """Of the loading, in m, without the row at zero."""
        return self.curve.overlap[self._loading]

    @property
    def force(self) -> FloatArray:
        """Of the loading, in N."""
        return self.curve.force[self._loading]

    @property
    def contact_radius(self) -> FloatArray:
        """Of the loading, in m."""
        assert self.curve.contact_radius is not None
        return self.curve.contact_radius[self._loading]

    @property
    def _loading(self) -> slice:
        rows = self.curve.rows(0)
        return slice(rows.start + 1, rows.stop)

    def hertz(self, overlap: FloatArray) -> FloatArray:
        """Hertz's force in N of the undeformed pole."""
        return 4.0 / 3.0 * self.material.reduced_modulus * math.sqrt(self.radius) * overlap**1.5


@dataclass(frozen=True)
class Study:
    """All bodies."""

    bodies: dict[Key, dict[float, Body]]  # by material, then by aspect

    @property
    def nmc(self) -> list[Body]:
        """The authors' material, from the sharp to the blunt body."""
        return self.of(nmc_key())

    def of(self, key: Key) -> list[Body]:
        """The shapes of one material; raises `Lacking`."""
        if key not in self.bodies:
            raise Lacking(f"E/Y = {key[0]:g}, ν = {key[1]:g}")
        return [body for _, body in sorted(self.bodies[key].items())]

    def body(self, key: Key, aspect: float) -> Body:
        """One body; raises `Lacking`."""
        for body in self.of(key):
            if math.isclose(body.aspect, aspect, rel_tol=1e-6):
                return body
        raise Lacking(f"the body 1:{aspect:.3g} of E/Y = {key[0]:g}, ν = {key[1]:g}")

    @property
    def plastic(self) -> list[Key]:
        """The materials that yield, by Poisson's ratio, then E/Y."""
        return sorted((key for key in self.bodies if math.isfinite(key[0])), key=lambda key: (key[1], key[0]))

    @property
    def elastic(self) -> list[Key]:
        """Poisson's ratios of the elastic bodies, as keys."""
        return sorted((key for key in self.bodies if math.isinf(key[0])), key=lambda key: key[1])


def key_of(material: Material) -> Key:
    """E/Y, infinite for an elastic material, and nu, to nine digits.

    >>> key_of(Material(1.0, 0.3))
    (inf, 0.3)
    """
    ratio = math.inf if material.yield_stress is None else material.youngs_modulus / material.yield_stress
    return float(f"{ratio:.9g}"), float(f"{material.poissons_ratio:.9g}")


def nmc_key() -> Key:
    """The authors' material."""
    return key_of(NMC)


def wanted(nmc_alone: bool) -> list[Spheroid]:
    """The bodies of a study."""
    return [body for body in spheroids() if not nmc_alone or body.material == NMC]


def compute_missing(folder: Path, bodies: Sequence[Spheroid], jobs: int, say: Callable[[str], None]) -> None:
    """Curves that are not in `folder` yet, each written when it is complete."""
    folder.mkdir(parents=True, exist_ok=True)
    missing = [body for body in bodies if not (folder / body.file_name).exists()]
    if not missing:
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(compute_one, body, folder) for body in missing]
        for number, future in enumerate(as_completed(futures), 1):
            say(f"{number}/{len(missing)} {future.result()}")


def load(folder: Path) -> Study:
    """All curves of spheroids in a folder; raises `InputError` if the authors' material is not among them."""
    return collect((read_curve(path) for path in sorted(folder.glob("*.parquet"))), str(folder))


def collect(curves: Iterable[Curve], place: str = "curves") -> Study:
    """A study of curves that have a material and a contact radius; one for each body, the authors' material among them."""
    found: dict[Key, dict[float, Body]] = {}
    for curve in _usable(curves):
        assert curve.material is not None
        bodies = found.setdefault(key_of(curve.material), {})
        twin = bodies.setdefault(curve.aspect, Body(curve))
        if twin.curve.content_hash != curve.content_hash:
            raise InputError(Problem(f"{place}: {twin.name}", 2, "has curves that differ", "keep the curves of one run"))
    if nmc_key() not in found:
        raise InputError(Problem(place, len(found), "holds no curve of the authors' material", "compute them, or name another folder"))
    return Study(found)


def _usable(curves: Iterable[Curve]) -> Iterator[Curve]:
    return (curve for curve in curves if curve.material is not None and curve.contact_radius is not None)
