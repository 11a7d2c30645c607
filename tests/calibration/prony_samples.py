"""Materials whose tables are known exactly, and the tables with noise."""

from __future__ import annotations

import numpy as np

from calibration.prony_table import Kind, PronyTable
from contactlaws.prony import Relaxation

#: well separated times, each seen from start to end by a table from 0.003 s to 400 s
ONE = Relaxation(2e9, (0.4,), (1.0,))
TWO = Relaxation(2e9, (0.3, 0.2), (0.1, 10.0))
THREE = Relaxation(2e9, (0.2, 0.15, 0.25), (0.03, 1.0, 40.0))
#: Wahn, Gan & Kamlah (2022): E1 404.6 MPa, E2 1365.9 MPa, 1.8 s
PVDF = Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,))
FIRST, LAST = 0.003, 400.0


def exact(modulus: Relaxation, kind: Kind, place: np.ndarray) -> np.ndarray:
    """What a perfect test measures; the complex modulus is M_inf + sum M_i i z/(1 + i z)."""
    if kind == "relaxation":
        return modulus.at(place)
    if kind == "creep":
        return modulus.creep().at(place)
    z = 1j * place[:, None] * np.array(modulus.times)
    complex_modulus = modulus.long_term + modulus.instantaneous * (z / (1.0 + z)) @ np.array(modulus.fractions)
    return np.concatenate((complex_modulus.real, complex_modulus.imag))


def places(kind: Kind, rows: int, first: float = FIRST, last: float = LAST) -> np.ndarray:
    """Times, or the frequencies that see the same times."""
    return np.geomspace(1.0 / last, 1.0 / first, rows) if kind == "dynamic" else np.geomspace(first, last, rows)


def table_of(modulus: Relaxation, kind: Kind, rows: int = 60, noise: float = 0.0, seed: int = 0, **window: float) -> PronyTable:
    """A table each number of which scatters by the same share of itself."""
    place = places(kind, rows, **window)
    values = exact(modulus, kind, place)
    return PronyTable(kind, place, values * (1.0 + noise * np.random.default_rng(seed).standard_normal(values.size)))


def numbers(modulus: Relaxation) -> np.ndarray:
    """In the order of a fit's names."""
    return np.array([modulus.instantaneous, *modulus.fractions, *modulus.times])
