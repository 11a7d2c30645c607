"""A law followed along a path of overlaps: one compiled loop for all laws, the fitter's and the checks' only way to evaluate one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws import dispatch
from contactlaws.compiled import kernel
from contactlaws.errors import InputError, Problem

FloatArray = npt.NDArray[np.float64]


class Scan(NamedTuple):
    """What a law does along a path; one row per overlap."""

    force: FloatArray  # N
    contact_radius: FloatArray  # m
    stored_energy: FloatArray  # J; can be got back
    dissipated_energy: FloatArray  # J; since the start of the path, also by contacts that were opened and forgotten
    states: FloatArray  # shape (rows, floats of state)


class Trace(NamedTuple):
    """The part of `Scan` that costs nothing beyond the force."""

    force: FloatArray  # N
    contact_radius: FloatArray  # m
    states: FloatArray  # shape (rows, floats of state)


@kernel
def _trace(law, overlap, time, memory):  # type: ignore[no-untyped-def]
    size = overlap.size
    force = np.empty(size)
    radius = np.empty(size)
    states = np.empty((size, memory.shape[1]))
    state = dispatch.load_state(law, memory.copy(), 0)
    for i in range(size):
        dt = time[i] - time[i - 1] if i > 0 else 0.0
        rate = (overlap[i] - overlap[i - 1]) / dt if dt > 0.0 else 0.0
        force[i], state = dispatch.normal_force(law, overlap[i], rate, dt, state)
        radius[i] = dispatch.contact_radius(law, overlap[i], state)
        dispatch.store_state(law, states, i, state)
    return force, radius, states


@kernel
def _energies(law, overlap, states, memory):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy; what a contact still had and had dissipated when it opened, and forgot its history, stays in the
    account as dissipated.
    """
    stored = np.empty(overlap.size)
    dissipated = np.empty(overlap.size)
    state = dispatch.load_state(law, memory, 0)
    before = dispatch.energy(law, 0.0, state)[1]
    closed = -before
    for i in range(overlap.size):
        after = dispatch.load_state(law, states, i)
        stored[i], now = dispatch.energy(law, overlap[i], after)
        if overlap[i] <= 0.0:
            left, before = dispatch.energy(law, 0.0, state)
            closed += before + left - now
        before, state = now, after
        dissipated[i] = closed + now
    return stored, dissipated


def trace(law: object, overlap: npt.ArrayLike, time: npt.ArrayLike | None = None, state: tuple[float, ...] | None = None) -> Trace:
    """Follow `law` along `overlap` (m), at `time` (s; one second a row if None), from `state` (never touched if None).

    Raises `InputError` for a path that is empty or not finite, times that decrease, or a state of the wrong length.
    """
    path, times, memory = _prepared(law, overlap, time, state)
    return Trace(*_trace(law, path, times, memory))


def scan(law: object, overlap: npt.ArrayLike, time: npt.ArrayLike | None = None, state: tuple[float, ...] | None = None) -> Scan:
    """`trace` with the energies.

    >>> from contactlaws.elastic import Hertz
    >>> scan(Hertz(1.0, 0.75), [0.0, 0.01, 0.04]).force.tolist()
    [0.0, 0.001, 0.008]
    """
    path, times, memory = _prepared(law, overlap, time, state)
    force, radius, states = _trace(law, path, times, memory)
    stored, dissipated = _energies(law, path, states, memory)
    return Scan(force, radius, stored, dissipated, states)


def _prepared(
    law: object, overlap: npt.ArrayLike, time: npt.ArrayLike | None, state: tuple[float, ...] | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Arrays of one type and layout, so that each law is compiled once."""
    path = np.array(overlap, dtype=np.float64)
    times = np.arange(path.size, dtype=np.float64) if time is None else np.array(time, dtype=np.float64)
    initial = dispatch.initial_state(law) if state is None else state
    _require_path(path, times, initial, dispatch.floats_of_state(law))
    return path, times, np.array(initial, dtype=np.float64).reshape(1, -1)


def _require_path(path: FloatArray, times: FloatArray, state: tuple[float, ...], floats: int) -> None:
    if path.ndim != 1 or path.size == 0 or not np.isfinite(path).all():
        raise InputError(Problem("overlap", path.shape, "must be a row of finite numbers", "remove or repair the rows"))
    if times.shape != path.shape or not np.isfinite(times).all() or np.any(np.diff(times) < 0.0):
        raise InputError(
            Problem("time", times.shape, f"must be {path.size} finite numbers that do not decrease", "give one time per overlap")
        )
    if len(state) != floats:
        raise InputError(Problem("state", state, f"this law remembers {floats} floats", "use a state that the law returned"))
