"""From the type of a law's record to its functions, the same in Python and in compiled code.

A law is a frozen record of parameters (a `NamedTuple`; its first field is always `radius`, the radius in m of the body it describes) and
four scalar compiled functions, registered once with `register`. All describe ONE body pressed by its mid-plane against a rigid
frictionless flat, in SI units (a pair is made of it in `contactlaws.pair`):

    force(law, overlap, rate, dt, state) -> (force, state)      N; state is the memory of the contact: a tuple of floats, or a row
    contact_radius(law, overlap, state) -> float                 m
    energy(law, overlap, state) -> (stored, dissipated)          J, both functions of the state alone; stored can be got back
    stiffness_bound(law, overlap) -> float                       N/m; the largest tangent over all histories up to `overlap`

`overlap` below or at zero means no contact: force 0 and the initial state. A law whose memory depends on its record (a viscoelastic one
remembers some floats for each of its terms) keeps it in a row of an array: `state` is then that row itself, which the force function
overwrites. Kernels call `normal_force`, `contact_radius`, `energy`,
`stiffness_bound`, `initial_state` of this module; numba picks the function from the record's type while compiling, so it costs nothing.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from contactlaws.errors import InputError, Problem


class Law(NamedTuple):
    """What is registered for one type of record."""

    name: str  # as in files and on the command line
    record: type
    force: Callable[..., Any]
    contact_radius: Callable[..., Any]
    energy: Callable[..., Any]
    stiffness_bound: Callable[..., Any]
    memory: tuple[str, ...]  # one name per float of state; () for a law without memory; of a row, its parts
    source: str  # paper and equations, as corrected
    #: what makes a record unusable, asked before a kernel sees it; a law made of plain numbers may leave it out
    problems: Callable[[Any], Iterable[Problem]] = lambda law: ()
    #: compiled: floats in the row of a record's memory; None: the memory is a tuple as long as `memory`
    row_size: Callable[[Any], int] | None = None
    #: compiled: `force` of many contacts at once, for a law that remembers a row: see `normal_forces`
    block: Callable[..., Any] | None = None
    #: whether the force depends on how fast the overlap changes, or on how long it stays
    in_time: bool = False


#: rows of a block that a law may use as it likes, beyond overlap, force and energy
SCRATCH = 4
_LAWS: dict[type, Law] = {}
#: the package whose modules bring the laws of this project
OWN = __name__.split(".")[0]


def register(law: Law) -> None:
    """Make a law known to all loops. A record type is registered once; doing it again raises `InputError`."""
    if not law.record.__module__.startswith(f"{OWN}."):
        _load_own()  # whose names are taken
    if law.record in _LAWS or any(law.name == other.name for other in _LAWS.values()):
        raise InputError(Problem("law", law.name, "is registered already", "choose another name and another record"))
    _LAWS[law.record] = law


def _load_own() -> None:
    """This project's laws register themselves when they are imported: not before somebody asks, since that takes a second."""
    for name in importlib.import_module(OWN).__all__:
        importlib.import_module(f"{OWN}.{name}")


def laws() -> dict[str, Law]:
    """All registered laws by name, in alphabetical order: that of registration depends on who was imported first."""
    _load_own()
    return {law.name: law for law in sorted(_LAWS.values(), key=lambda law: law.name)}


def law_of(record: object) -> Law:
    """The registered law of a parameter record (or of its type); raises `InputError` if there is none."""
    found = _LAWS.get(record if isinstance(record, type) else type(record))
    if found is None:
        raise InputError(
            Problem("law", type(record).__name__, f"is no registered law ({', '.join(laws())})", "call contactlaws.register first")
        )
    return found


def normal_force(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    """Force in N and new memory of one body at `overlap` (m), closing at `rate` (m/s), `dt` (s) after `state`."""
    return law_of(law).force(law, overlap, rate, dt, state)


def normal_forces(law, dt, memory, row, size, block, at):  # type: ignore[no-untyped-def]
    """`normal_force` of `size` contacts, of a law that has a `block`.

    memory: shape (floats, contacts), theirs from column `row` on. block: its row `at` holds their overlaps (m), and `at` + 1 gets the
    forces (N), `at` + 2 the energy (J) of each that has just ended, with a memory that is cleared; the next `SCRATCH` rows are free to use.
    """
    law_of(law).block(law, dt, memory, row, size, block, at)


def contact_radius(law, overlap, state):  # type: ignore[no-untyped-def]
    """Contact radius in m."""
    return law_of(law).contact_radius(law, overlap, state)


def energy(law, overlap, state):  # type: ignore[no-untyped-def]
    """Stored and dissipated energy of one body in J."""
    return law_of(law).energy(law, overlap, state)


def stiffness_bound(law, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent stiffness in N/m of one body over all histories that stay at or below `overlap`."""
    return law_of(law).stiffness_bound(law, overlap)


def floats_of_state(law: object) -> int:
    """How many floats a contact of this law (record) remembers."""
    known = law_of(law)
    return len(known.memory) if known.row_size is None else int(known.row_size(law))


def initial_state(law):  # type: ignore[no-untyped-def]
    """Memory of a contact that has never been touched: zeros."""
    return (0.0,) * len(law_of(law).memory) if law_of(law).row_size is None else np.zeros(floats_of_state(law))


def load_state(law, memory, index):  # type: ignore[no-untyped-def]
    """The state kept in row `index` of `memory`, an array of shape (contacts, floats of state): a tuple, or the row itself."""
    return tuple(memory[index, i] for i in range(len(law_of(law).memory))) if law_of(law).row_size is None else memory[index]


def store_state(law, memory, index, state):  # type: ignore[no-untyped-def]
    """Write the state into row `index` of `memory`, an array of shape (contacts, floats of state)."""
    for i in range(len(state)):
        memory[index, i] = state[i]


def put_back(law, memory, index, state):  # type: ignore[no-untyped-def]
    """`store_state` for a state that was loaded from the same place: a row is there already."""
    if law_of(law).row_size is None:
        store_state(law, memory, index, state)


def _numba_law(law: Any) -> Law:
    if not isinstance(law, types.BaseNamedTuple):
        raise InputError(Problem("law", str(law), "must be a registered NamedTuple", "pass the record, not a plain tuple"))
    return law_of(law.instance_class)


# part of its caller: to hand over a record of dozens of values takes longer than the force itself
@overload(normal_force, jit_options={"forceinline": True})
def _(law, overlap, rate, dt, state):  # type: ignore[no-untyped-def]
    function = _numba_law(law).force
    return lambda law, overlap, rate, dt, state: function(law, overlap, rate, dt, state)


@overload(normal_forces, jit_options={"forceinline": True})
def _(law, dt, memory, row, size, block, at):  # type: ignore[no-untyped-def]
    function = _numba_law(law).block
    return lambda law, dt, memory, row, size, block, at: function(law, dt, memory, row, size, block, at)


@overload(contact_radius)
def _(law, overlap, state):  # type: ignore[no-untyped-def]
    function = _numba_law(law).contact_radius
    return lambda law, overlap, state: function(law, overlap, state)


@overload(energy)
def _(law, overlap, state):  # type: ignore[no-untyped-def]
    function = _numba_law(law).energy
    return lambda law, overlap, state: function(law, overlap, state)


@overload(stiffness_bound)
def _(law, overlap):  # type: ignore[no-untyped-def]
    function = _numba_law(law).stiffness_bound
    return lambda law, overlap: function(law, overlap)


@overload(initial_state)
def _(law):  # type: ignore[no-untyped-def]
    size = _numba_law(law).row_size
    if size is not None:
        return lambda law: np.zeros(size(law))
    zeros = (0.0,) * len(_numba_law(law).memory)
    return lambda law: zeros


@overload(load_state)
def _(law, memory, index):  # type: ignore[no-untyped-def]
    if _numba_law(law).row_size is not None:
        return lambda law, memory, index: memory[index]
    # numba builds a tuple only from a written-out expression, so there is one for each length in use
    size = len(_numba_law(law).memory)
    if size == 0:
        return lambda law, memory, index: ()
    if size == 1:
        return lambda law, memory, index: (memory[index, 0],)
    if size == 2:
        return lambda law, memory, index: (memory[index, 0], memory[index, 1])
    if size == 3:
        return lambda law, memory, index: (memory[index, 0], memory[index, 1], memory[index, 2])
    if size == 6:
        return lambda law, memory, index: (
            memory[index, 0],
            memory[index, 1],
            memory[index, 2],
            memory[index, 3],
            memory[index, 4],
            memory[index, 5],
        )
    raise InputError(Problem("memory", size, "must be 0 to 3 or 6 floats per contact", "add a case to load_state"))


@overload(store_state)
def _(law, memory, index, state):  # type: ignore[no-untyped-def]
    if not _numba_law(law).memory:
        return lambda law, memory, index, state: None

    def store(law, memory, index, state):  # type: ignore[no-untyped-def]
        for i in range(len(state)):
            memory[index, i] = state[i]

    return store


@overload(put_back)
def _(law, memory, index, state):  # type: ignore[no-untyped-def]
    if _numba_law(law).row_size is not None or not _numba_law(law).memory:
        return lambda law, memory, index, state: None

    def put(law, memory, index, state):  # type: ignore[no-untyped-def]
        for i in range(len(state)):
            memory[index, i] = state[i]

    return put
