"""Laws against finite elements along histories: growing, resting, shrinking, met again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from cases.wahn_gan_kamlah_2022.material import CONSTANT_BULK, HISTORIES, RADIUS, TOGETHER, scaled
from contactlaws.curve import Curve, FloatArray
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.path import scan
from contactlaws.prony import PronyViscoelastic
from contactlaws.rivals.kuwabara_kono import kuwabara_kono
from contactlaws.rivals.wahn_gan_kamlah import wahn_gan_kamlah
from fem.press_in_time import press_in_time

#: overlaps over the radius at which histories turn
DEPTHS = (0.02, 0.05, 0.1)
MATERIALS: dict[str, PronyViscoelastic] = {"nu constant": TOGETHER, "K constant": CONSTANT_BULK}
#: steps of a law for each row of a curve
FINER = 20
KINDS = ("growing", "resting", "shrinking", "again")
OURS, RIVAL, PLAIN, TING = "maxwell_zener_ting", "wahn_gan_kamlah", "maxwell_zener, half-space", "maxwell_zener_ting, half-space"


class Compared(NamedTuple):
    """One law along one history: largest difference of the force, over the largest force of the continuum, in each kind of row."""

    law: str
    material: str
    depth: float
    history: str
    growing: float | None
    resting: float | None
    shrinking: float | None
    again: float | None  # growing or resting after a first retreat
    lowest: float  # smallest force over the largest: below 0 it pulls

    @property
    def worst(self) -> float:
        """Of all rows."""
        return max(value for value in (self.growing, self.resting, self.shrinking, self.again) if value is not None)


def mean_ratio(material: PronyViscoelastic) -> float:
    """Poisson's ratio for the finite-size part of a law: half way between the instantaneous and the long-term one."""
    return 0.5 * (material.poissons_ratio + material.long_term.poissons_ratio)


def laws(material: PronyViscoelastic, radius: float = RADIUS) -> dict[str, Any]:
    """Ours, without its parts, and rivals."""
    modulus = material.reduced
    ratio = mean_ratio(material)
    found = {
        OURS: maxwell_zener_ting(modulus, radius, ratio),
        "maxwell_zener": maxwell_zener(modulus, radius, ratio),
        TING: maxwell_zener_ting(modulus, radius),
        PLAIN: maxwell_zener(modulus, radius),
        "kuwabara_kono": kuwabara_kono(modulus, radius),
    }
    if len(modulus.times) == 1:
        found[RIVAL] = wahn_gan_kamlah(modulus, radius)
    return found


def followed(law: Any, curve: Curve) -> FloatArray:
    """Force of a law at the rows of a curve in time, in finer steps between them."""
    time, overlap = curve.time, curve.overlap
    share = np.arange(1, FINER + 1) / FINER
    fine = [np.concatenate([row[:1], (row[:-1, None] + share * np.diff(row)[:, None]).ravel()]) for row in (time, overlap)]
    return scan(law, fine[1], fine[0]).force[::FINER]


def compare(name: str, law: Any, curve: Curve, material: str, depth: float, history: str) -> Compared:
    """One row of the table."""
    force = followed(law, curve)
    error = abs(force - curve.force) / curve.force.max()
    moved = np.diff(curve.overlap, prepend=0.0)
    first = curve.branch == 0
    kinds = (first & (moved > 0.0), (moved == 0.0) & first, curve.branch % 2 == 1, ~first & (curve.branch % 2 == 0))
    growing, resting, shrinking, again = (float(error[kind].max()) if kind.any() else None for kind in kinds)
    return Compared(name, material, depth, history, growing, resting, shrinking, again, float(force.min() / curve.force.max()))


def reference(material: PronyViscoelastic, depth: float, history: str, tolerance: float) -> Curve:
    """The continuum along one history."""
    return press_in_time(material, scaled(HISTORIES[history], depth * RADIUS), radius=RADIUS, tolerance=tolerance)


def table(curves: Mapping[tuple[str, float, str], Curve]) -> list[Compared]:
    """Every law along every curve; keys: material, overlap over the radius, history."""
    return [
        compare(name, law, curve, material, depth, history)
        for (material, depth, history), curve in curves.items()
        for name, law in laws(MATERIALS[material]).items()
    ]


def worst(rows: Sequence[Compared], law: str, depth: float, material: str | None = None) -> float:
    """Largest error of a law at a depth, over histories (and materials)."""
    return max(row.worst for row in rows if row.law == law and row.depth == depth and material in (None, row.material))
