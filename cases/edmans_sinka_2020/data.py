"""The curves of a folder, by material, and their unloadings as columns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt

from calibration.unloadings import Unloading, unloadings
from cases.batch.results import load_case
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError, Problem, require

FloatArray = npt.NDArray[np.float64]
Key = tuple[float, float]  # E/Y, nu


@dataclass(frozen=True)
class Points:
    """Unloadings as columns, one row each; D is the overlap over the radius, forces are over pi R^2 Y."""

    material: npt.NDArray[np.int64]  # number of the material, in the order of `Study.keys`
    modulus: FloatArray  # E/Y
    poisson: FloatArray
    depth: FloatArray  # D_max
    force: FloatArray
    stiffness: FloatArray  # rho
    exponent: FloatArray  # alpha
    exponent_r2: FloatArray
    plastic: npt.NDArray[np.bool_]

    def where(self, rows: npt.NDArray[np.bool_]) -> Points:
        """Some of them."""
        return Points(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


@dataclass(frozen=True)
class Study:
    """One curve for each material (E/Y, nu)."""

    curves: dict[Key, Curve]

    @property
    def keys(self) -> list[Key]:
        """The materials, by Poisson's ratio, then modulus."""
        return sorted(self.curves, key=lambda key: (key[1], key[0]))

    @property
    def poisson(self) -> list[float]:
        """All Poisson's ratios."""
        return sorted({nu for _, nu in self.curves})

    def moduli(self, poisson: float) -> list[float]:
        """E/Y of all materials with this Poisson's ratio."""
        return sorted(modulus for modulus, nu in self.curves if nu == poisson)

    @cached_property
    def unloadings(self) -> dict[Key, tuple[Unloading, ...]]:
        """The unloadings of each material."""
        return {key: unloadings(self.curves[key]) for key in self.keys}

    @cached_property
    def points(self) -> Points:
        """All unloadings."""
        rows = []
        for number, key in enumerate(self.keys):
            curve = self.curves[key]
            for found in self.unloadings[key]:
                measured = (
                    found.overlap / curve.radius,
                    found.force / force_unit(curve),
                    found.stiffness,
                    found.exponent,
                    found.exponent_r2,
                )
                rows.append((number, *key, *measured, bool(found.plastic)))
        columns = [np.array(column) for column in zip(*rows, strict=True)]
        return Points(*columns)

    def of(self, modulus: float, poisson: float) -> Points:
        """The unloadings of one material."""
        return self.points.where((self.points.modulus == modulus) & (self.points.poisson == poisson))


def force_unit(curve: Curve) -> float:
    """pi R^2 Y in N."""
    if curve.material is None or curve.material.yield_stress is None:
        raise InputError(Problem("material", curve.material, "must have a yield stress", "the study is of elastic-plastic bodies"))
    return float(np.pi * curve.radius**2 * curve.material.yield_stress)


def load(folder: Path) -> Study:
    """The curves of a folder of results (those of its last run), or of all .parquet files in `folder`.

    Raises `InputError` if there is nothing to use.
    """
    if (folder / "case.json").exists():
        _, records = load_case(folder)
        paths = [folder / item.files["curve"] for item in records if item is not None and item.usable and item.kind == "curves"]
    else:
        paths = sorted(folder.glob("*.parquet"))
    return collect([read_curve(path) for path in paths], str(folder))


def collect(curves: Iterable[Curve], place: str = "curves") -> Study:
    """A study of the plastic spheres with unloadings among `curves`; others are left aside."""
    usable = [c for c in curves if c.material is not None and c.material.yield_stress is not None and c.aspect == 1.0 and c.unloadings]
    keyed = [(_key(curve), curve) for curve in usable]
    found = dict(keyed)
    require(_problems(keyed, found, place))
    return Study(found)


def _problems(keyed: Sequence[tuple[Key, Curve]], found: dict[Key, Curve], place: str) -> Iterable[Problem]:
    if not keyed:
        yield Problem(place, 0, "holds no curve of a plastic sphere with unloadings", "run cases/edmans_sinka_2020/study.toml")
    for key, curve in found.items():
        twins = {other.content_hash for name, other in keyed if name == key} - {curve.content_hash}
        if twins:
            bound = "has curves that differ"
            yield Problem(f"{place}: E/Y {key[0]:g}, nu {key[1]:g}", len(twins) + 1, bound, "keep the curves of one run")


def _key(curve: Curve) -> Key:
    material = curve.material
    assert material is not None
    assert material.yield_stress is not None
    return float(f"{material.youngs_modulus / material.yield_stress:.9g}"), float(f"{material.poissons_ratio:.9g}")
