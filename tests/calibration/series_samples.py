"""Curves in time of bodies whose series is known exactly, and such curves with noise."""

from __future__ import annotations

import numpy as np

from contactlaws.curve import Curve, branches_in_time
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.path import trace
from contactlaws.prony import Relaxation

RADIUS, RATIO = 5e-6, 0.4
#: well separated times, each seen from start to end by a press in 0.1 s that is held for 300 s
ONE = Relaxation(2e9, (0.4,), (1.0,))
TWO = Relaxation(2e9, (0.3, 0.2), (0.1, 10.0))
THREE = Relaxation(2e9, (0.2, 0.15, 0.25), (0.03, 1.0, 40.0))
#: steps a row in which the law is followed for these curves: what is left of them is below 1e-4 of the force
FINE = 16


def pressed(ramp: float = 0.1, hold: float = 300.0, release: float | None = None, rows: int = 150, depth: float = 0.02):
    """Times in s and overlaps in m of a press to `depth` radii, with 30 rows in the ramp, `rows` in the hold and 20 in the release."""
    time = [np.linspace(0.0, ramp, 30), ramp + np.geomspace(min(0.02 * ramp, 0.1 * hold), hold, rows)]
    knots = [(0.0, 0.0), (ramp, depth), (ramp + hold, depth)]
    if release is not None:
        time.append(ramp + hold + np.linspace(0.05, 1.0, 20) * release)
        knots.append((ramp + hold + release, 0.0))
    places = np.concatenate(time)
    return places, RADIUS * np.interp(places, *np.transpose(knots))


def curve_of(
    modulus: Relaxation, time: np.ndarray, overlap: np.ndarray, noise: float = 0.0, seed: int = 0, ratio: float | None = RATIO, **facts
) -> Curve:
    """What the law gives, followed in fine steps; each force scatters by the same share of itself."""
    share = np.arange(1, FINE + 1) / FINE
    fine = [np.concatenate((x[:1], (x[:-1, None] + share * np.diff(x)[:, None]).ravel())) for x in (overlap, time)]
    force = trace(maxwell_zener_ting(modulus, RADIUS, ratio), *fine).force[::FINE]
    scatter = 1.0 + noise * np.random.default_rng(seed).standard_normal(force.size)
    return Curve(time, overlap, force * scatter, branches_in_time(overlap), RADIUS, in_time=True, **facts)
