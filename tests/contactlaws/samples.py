"""One law of each kind, and curves made from laws, for all tests of laws and fits."""

from __future__ import annotations

from typing import Any

import numpy as np

from contactlaws.curve import Curve
from contactlaws.edmans_sinka import FIRST_YIELD, PUBLISHED, EdmansSinka
from contactlaws.elastic import Hertz, HertzFiniteSize
from contactlaws.elastoplastic import Thornton
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.path import scan
from contactlaws.prony import Relaxation
from contactlaws.tabulate import from_curve
from contactlaws.whole_range import whole_range, whole_range_compact
from tests.contactlaws.rival_samples import RIVALS, SLOW

NMC = Material(142e9, 0.25, 7.9e9)
SOFT = Material(20.0, 0.3, 1.0)
HARD = Material(1000.0, 0.3, 1.0)


def edmans_sinka(material: Material, radius: float = 1.0, **changes: float) -> EdmansSinka:
    """A law with a made-up, plausible loading branch."""
    yield_stress = material.yield_stress
    assert yield_stress is not None
    elastic = {"force_1": 0.1, "force_2": 0.8, "force_3": 0.3, "area_1": 0.05, "area_2": 0.6}
    flow = {"flow": 0.22, "flow_decay": -2.5, "flow_decay_2": 2.0, "flow_sharpness": 1.5}
    area = {"plastic_area": 2.7, "plastic_area_decay": 1.2, "area_onset": 1.0}
    unloading = {"exponent": 1.45, "exponent_decay": 2.5, **{f"gamma_{i}": value for i, value in enumerate(PUBLISHED, 1)}}
    eq_5 = dict(zip(("yield_factor", "yield_factor_slope", "yield_power"), FIRST_YIELD["corrected"], strict=True))
    values = {**elastic, **flow, **area, **unloading, **eq_5, **changes}
    return EdmansSinka(radius, material.reduced_modulus, material.poissons_ratio, yield_stress, **values)


def curve_of(
    law: Any,
    max_overlap: float,
    unload_from: tuple[float, ...] = (0.3, 0.6, 1.0),
    material: Material | None = None,
    rows: int = 80,
    **facts: Any,
) -> Curve:
    """What a measurement of `law` without any error would give, unloaded from some fractions of the largest overlap."""
    loading = np.geomspace(1e-4, 1.0, rows) * max_overlap
    branches, scans = [loading], [scan(law, loading)]
    for fraction in unload_from:
        before = loading[loading <= fraction * max_overlap * (1.0 + 1e-12)]
        top = float(before[-1])
        down = np.linspace(top, separation(law, top), rows // 2)
        branches.append(down)
        scans.append(scan(law, np.concatenate((before, down[1:]))))
    tail = [slice(-path.size, None) for path in branches]
    force = [part.force[rows] for part, rows in zip(scans, tail, strict=True)]
    for unloading in force[1:]:
        unloading[-1] = 0.0
    radius = np.concatenate([part.contact_radius[rows] for part, rows in zip(scans, tail, strict=True)])  # some laws do not know it
    return Curve(
        time=np.arange(sum(path.size for path in branches)),
        overlap=np.concatenate(branches),
        force=np.concatenate(force),
        branch=np.concatenate([np.full(path.size, k) for k, path in enumerate(branches)]),
        radius=law.radius,
        contact_radius=None if np.isnan(radius).any() else radius,
        material=material,
        **facts,
    )


def separation(law: Any, top: float) -> float:
    """Where the force of an unloading from `top` vanishes, to a part in 1e12 of `top`."""
    low, high = 0.0, top
    while high - low > 1e-12 * top:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if scan(law, [top, middle]).force[1] > 0.0 else (middle, high)
    return low


TABULATED = from_curve(curve_of(edmans_sinka(HARD), 0.1, (0.1, 0.3, 0.6, 1.0), HARD, yield_overlap=5e-6))

PVDF = Relaxation(2175.3e6, (0.2285,), (1.8,))
BROAD = Relaxation(1000.0, (0.2, 0.3, 0.4), (0.01, 1.0, 30.0))

#: name of the law: records to test it with, and the largest overlap of each; of laws in time, all that matters takes about a second
SAMPLES: dict[str, list[tuple[Any, float]]] = {
    "hertz": [(Hertz(5e-6, NMC.reduced_modulus), 5e-7)],
    "hertz_finite_size": [(HertzFiniteSize(1.0, 50.0, 0.3, 1.0, 0.2, 0.1, 0.4), 0.3)],
    "thornton": [(Thornton(5e-6, NMC.reduced_modulus, 1.6 * 7.9e9), 5e-7), (Thornton(1.0, HARD.reduced_modulus, 2.0), 0.3)],
    "edmans_sinka": [(edmans_sinka(NMC, 5e-6), 5e-7), (edmans_sinka(SOFT), 0.3), (edmans_sinka(HARD), 0.3)],
    "tabulated": [(TABULATED, 0.12)],
    "whole_range": [(whole_range(NMC, 5e-6), 2.5e-6), (whole_range(HARD, 1.0), 0.5)],
    "whole_range_compact": [(whole_range_compact(SOFT, 1.0), 0.5)],
    "maxwell_zener": [(maxwell_zener(PVDF, 5e-6), 5e-7), (maxwell_zener(BROAD, 1.0, 0.3), 0.3)],
    "maxwell_zener_ting": [(maxwell_zener_ting(SLOW, 1.0), 0.1), (maxwell_zener_ting(BROAD, 1.0, 0.3, springs=8), 0.3)],
    **RIVALS,
}
CASES = [(law, deepest) for records in SAMPLES.values() for law, deepest in records]
NAMES = [f"{name}-{number}" for name, records in SAMPLES.items() for number, _ in enumerate(records)]
