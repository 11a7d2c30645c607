"""Curves in time as something that a Prony series of the reduced modulus is fitted to.

While the contact grows, the force is linear in the long-term modulus and those of the terms (Lee & Radok 1960):
F = E_inf Fe1(d) + sum E_i f_i(t), where Fe1 is the elastic force at unit modulus and f_i its part that a term of time tau_i still holds.
When the contact shrinks, its edge depends on the moduli, and only the law itself knows the force.

Formulas are those of `contactlaws.maxwell_zener` and `contactlaws.maxwell_zener_ting`, scanned along the curves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration.prony_basis import LinearTarget
from contactlaws.curve import Curve
from contactlaws.maxwell_zener import ELASTIC, FIRST, MaxwellZener, frozen
from contactlaws.maxwell_zener_ting import MaxwellZenerTing
from contactlaws.path import trace

FloatArray = npt.NDArray[np.float64]

#: overlap moves evenly from row to row, and the elastic force does not: paths with fewer rows than this are followed in finer steps, up to
#: `FINEST` a row. Steps four times finer then change no force by more than 2e-4 of itself
ROWS, FINEST = 240, 4
#: a contact counts as growing until its overlap has fallen by this part of the largest so far: noise of a measured overlap is no retreat,
#: and the force of one so small is changed by less than its square
SLIP = 0.01
#: of logarithms of times, in central differences: their error is then 1e-8
STEP = 1e-4


class Path(NamedTuple):
    """One curve, from its first touch on, in finer steps: the curve's rows `own` are the steps `rows`."""

    time: FloatArray  # s
    overlap: FloatArray  # m
    rows: npt.NDArray[np.int64]
    own: npt.NDArray[np.int64]
    force: FloatArray  # N, of the curve's rows
    growing: int  # how many of these come before the contact shrinks

    @property
    def window(self) -> tuple[float, float]:
        """The times in s between which it can tell relaxation: the shortest that four rows span, over three, and the whole duration."""
        time = np.unique(self.time[self.rows])
        apart = min(3, time.size - 1)
        return float((time[apart:] - time[:-apart]).min() / apart), float(time[-1] - self.time[0])


def growing_rows(curve: Curve) -> int:
    """How many rows come before the contact shrinks."""
    shrinks = curve.overlap < (1.0 - SLIP) * np.maximum.accumulate(np.maximum(curve.overlap, 0.0))
    return int(np.argmax(shrinks)) if shrinks.any() else curve.overlap.size


def growing_part(curve: Curve) -> Curve:
    """The rows before the contact shrinks, as a curve; raises `InputError` if fewer than three are left."""
    last = growing_rows(curve)
    columns = {name: value[:last] for name in Curve.COLUMNS if (value := getattr(curve, name)) is not None}
    return replace(curve, **columns)


def path_of(curve: Curve) -> Path:
    """The path of a curve in time, without rows before the touch and without those that stand there twice (as turns do)."""
    touched = int(np.argmax(curve.overlap > 0.0))
    first = max(0, touched - 1)
    own = np.arange(first, curve.overlap.size)
    twice = (np.diff(curve.time[own], prepend=-np.inf) == 0.0) & (np.diff(curve.overlap[own], prepend=-np.inf) == 0.0)
    growing = int(np.count_nonzero(~twice[own < growing_rows(curve)]))
    own = own[~twice]
    pieces = int(np.clip(np.ceil(ROWS / own.size), 1, FINEST))
    rows = pieces * np.arange(own.size)
    place = np.arange(rows[-1] + 1)
    kept = curve.overlap[own] > 0.0  # before, and where the flat is off the undeformed body, no law has a force
    return Path(
        np.interp(place, rows, curve.time[own]),
        np.interp(place, rows, curve.overlap[own]),
        rows[kept],
        own[kept],
        curve.force[own][kept],
        int(np.count_nonzero(kept[:growing])),
    )


@dataclass(frozen=True)
class Growing(LinearTarget):
    """Forces of contacts that grow, in the unit of their errors: the rows of all paths before their contact shrinks."""

    paths: tuple[Path, ...]
    body: MaxwellZener  # with a modulus of 1
    scale: FloatArray  # N; for each row of all paths, also later ones

    @property
    def force(self) -> FloatArray:
        """Of all rows of all paths, in N."""
        return np.concatenate([path.force for path in self.paths])

    @property
    def grows(self) -> npt.NDArray[np.bool_]:
        """For each row of all paths whether it comes before the contact shrinks."""
        return np.concatenate([np.arange(path.force.size) < path.growing for path in self.paths])

    @property
    def goal(self) -> FloatArray:
        """Forces over their scale."""
        return np.asarray((self.force / self.scale)[self.grows])

    @property
    def size(self) -> float:
        """The reduced modulus in Pa of an elastic body that comes nearest."""
        columns, _ = self.columns(np.zeros(0))
        return float(np.linalg.norm(self.goal) / np.linalg.norm(columns))

    def columns(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fe1, and f_i of terms of these times and of times a little longer and shorter, which are remembered by the law itself."""
        terms = times.size
        shifted = np.concatenate((times, times * np.exp(STEP), times * np.exp(-STEP)))
        law = self.body._replace(fractions=frozen(np.zeros(3 * terms)), times=frozen(shifted))
        states = [trace(law, *_growing(path)).states[path.rows[: path.growing]] for path in self.paths]
        table = np.concatenate([state[:, [ELASTIC, *range(FIRST, FIRST + 3 * terms)]] for state in states]) / self.scale[self.grows, None]
        up, down = table[:, 1 + terms : 1 + 2 * terms], table[:, 1 + 2 * terms :]
        return table[:, : 1 + terms], (up - down) / (2.0 * STEP)


def _growing(path: Path) -> tuple[FloatArray, FloatArray]:
    """Overlap and time up to where the contact shrinks."""
    end = int(path.rows[path.growing - 1]) + 1
    return path.overlap[:end], path.time[:end]


@dataclass(frozen=True)
class Whole(Growing):
    """Forces of contacts that grow, shrink, part and meet again: all rows of all paths."""

    springs: MaxwellZenerTing  # the same body, with its springs

    @property
    def count(self) -> int:
        """All rows."""
        return self.scale.size

    def misses(self, amplitudes: FloatArray, times: FloatArray) -> FloatArray:
        """Differences of all forces over their scale."""
        total = float(amplitudes.sum())
        law = self.springs._replace(fractions=frozen(amplitudes[1:] / total), times=frozen(times))
        found = np.concatenate([trace(law, path.overlap, path.time).force[path.rows] for path in self.paths])
        return np.asarray((total * found - self.force) / self.scale)

    def slopes(self, amplitudes: FloatArray, times: FloatArray) -> FloatArray:
        """By central differences."""
        # an amplitude that is nearly zero stays positive: a fluid has no law
        steps = np.concatenate((np.minimum(STEP * amplitudes.sum(), 0.5 * amplitudes), np.full(times.size, STEP)))

        def at(step: FloatArray) -> FloatArray:
            return self.misses(amplitudes + step[: amplitudes.size], times * np.exp(step[amplitudes.size :]))

        return np.stack([(at(step) - at(-step)) / (2.0 * h) for step, h in zip(np.diag(steps), steps, strict=True)], axis=1)
