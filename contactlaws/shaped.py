"""Laws of bodies whose local geometry is an input: one record serves every contact of an ellipsoid, wherever it is touched.

A shaped law is a frozen record of parameters and four scalar compiled functions, registered once. As in `contactlaws.dispatch` they
describe ONE body pressed on a rigid frictionless flat, but the geometry comes with every call, and stays the same as long as the contact
lasts:

    force(law, shape, overlap, memory) -> (force, memory)       N; memory is a tuple of floats, as many as `ShapedLaw.memory` has names:
                                                                 the first is the largest overlap (m), and all others follow from it
                                                                 and the shape: zeros bring them anew
    contact_radius(law, shape, overlap, memory) -> float         m; sqrt(a b) of the contact ellipse
    stored(law, shape, overlap, memory) -> float                 J; what can be got back
    stiffness_bound(law, shape, overlap) -> float                N/m; the largest tangent over all histories up to `overlap`

`shape` is (radius, ratio, mean radius): 1/(2 sqrt(A B)) in m of the gap A x^2 + B y^2 of body and flat; B/A, at least 1; and (a b c)^(1/3)
of the body in m. A contact that rolls changes its shape under a stored history: `shaped_force` sees to it that this creates no energy.

Two bodies are one body on a flat at the `share` of their overlap, as in `contactlaws.pair`: its radius is that of the pair's gap over the
share, its mean radius r1 r2/((r1 + r2) share), the force the pair's, and energies count 1/share times. Two equal bodies at share 1/2 are
each a body on a flat at half the overlap; of spheres, radius and mean radius are the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import types
from numba.extending import overload
from numba.np.unsafe.ndarray import to_fixed_tuple

from contactlaws.compiled import inlined, inner, kernel
from contactlaws.errors import InputError, Problem

#: change of radius or ratio, over what they were, from which on a contact is counted as of another shape. Forces go with the root of the
#: radius, so they are late by half of it at most; a smaller one changes no stress, and costs
TOLERANCE = 0.01
#: what the wrapper keeps beside a law's own memory: reference radius (m) and ratio, the factor of the force, the largest overlap (m)
ROLLED = ("reference radius", "reference ratio", "factor", "largest overlap")
#: a contact never touched
UNTOUCHED = (0.0, 0.0, 0.0, 0.0)
#: of bodies at the border of those that a law was fitted to
ROUND_OFF = 1e-9
#: how often a largest overlap is doubled, and then halved to round-off, until a dent is as deep as it has to be
DOUBLINGS, HALVINGS = 30, 52


class ShapedLaw(NamedTuple):
    """What is registered for one type of record."""

    name: str
    record: type
    force: Callable[..., Any]
    contact_radius: Callable[..., Any]
    stored: Callable[..., Any]
    stiffness_bound: Callable[..., Any]
    memory: tuple[str, ...]  # one name per float; () for a law without memory
    source: str  # paper and equations, as corrected
    #: what makes a record unusable, asked before a kernel sees it
    problems: Callable[[Any], Iterable[Problem]] = lambda law: ()
    #: radius over mean radius (of `shape`) of the bodies that it was fitted to, from and to: others count as the nearest. None: of any
    fitted: tuple[float, float] | None = None


_LAWS: dict[type, ShapedLaw] = {}


def register(law: ShapedLaw) -> None:
    """Make a law known to all loops; raises `InputError` for a record or a name that is taken."""
    if law.record in _LAWS or any(law.name == other.name for other in _LAWS.values()):
        raise InputError(Problem("shaped law", law.name, "is registered already", "choose another name and another record"))
    _LAWS[law.record] = law


def shaped_laws() -> dict[str, ShapedLaw]:
    """Those that have been imported, by name."""
    return {law.name: law for law in sorted(_LAWS.values(), key=lambda law: law.name)}


def is_shaped(record: object) -> bool:
    """Whether this is a record (or a type) of a registered shaped law."""
    return (record if isinstance(record, type) else type(record)) in _LAWS


def shaped_law_of(record: object) -> ShapedLaw:
    """The registered law of a record (or of its type); raises `InputError` if there is none."""
    found = _LAWS.get(record if isinstance(record, type) else type(record))
    if found is None:
        names = ", ".join(shaped_laws()) or "none yet"
        raise InputError(Problem("law", type(record).__name__, f"is no law for ellipsoids ({names})", "see contactlaws.hertz_ellipse"))
    return found


def beyond_fit(law: ShapedLaw, least: npt.ArrayLike, largest: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Whether contacts with a radius over mean radius from `least` to `largest` are beyond those that a law was fitted to."""
    low, high = law.fitted or (0.0, math.inf)
    return (np.asarray(least) < low * (1.0 - ROUND_OFF)) | (np.asarray(largest) > high * (1.0 + ROUND_OFF))


def flatness(blunt: float) -> float:
    """b/a of the spheroid a : b : b that is as blunt at the end of a: `blunt` is its radius over mean radius there.

    >>> round(flatness(2.0 ** (4.0 / 3.0)), 12)
    2.0
    """
    return blunt**0.75


# What follows is the same in Python and in compiled code, where numba picks the function from the record's type.


def force(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """Force in N and new memory of one body at `overlap` (m), its shape being what it always was."""
    return shaped_law_of(law).force(law, shape, overlap, memory)


def contact_radius(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """sqrt(a b) of the contact ellipse in m."""
    return shaped_law_of(law).contact_radius(law, shape, overlap, memory)


def stored(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """What can be got back, in J."""
    return shaped_law_of(law).stored(law, shape, overlap, memory)


def stiffness_bound(law, shape, overlap):  # type: ignore[no-untyped-def]
    """Largest tangent stiffness in N/m over all histories that stay at or below `overlap`."""
    return shaped_law_of(law).stiffness_bound(law, shape, overlap)


def untouched(law):  # type: ignore[no-untyped-def]
    """Memory of a contact that has never been touched: zeros."""
    return (0.0,) * len(shaped_law_of(law).memory)


def remembered(law, array, row, column):  # type: ignore[no-untyped-def]
    """The law's memory from an array: from `row` on in `column`."""
    return tuple(array[row + k, column] for k in range(len(shaped_law_of(law).memory)))


def remember(law, array, row, column, memory):  # type: ignore[no-untyped-def]
    """Write the law's memory into an array: from `row` on in `column`."""
    for k in range(len(memory)):
        array[row + k, column] = memory[k]


def kept(law, memory):  # type: ignore[no-untyped-def]
    """What lasts of a memory when the contact becomes one of another shape: its first float."""
    return memory[:1] + (0.0,) * (len(memory) - 1)


def pressed_to(law, memory, largest):  # type: ignore[no-untyped-def]
    """What lasts of a memory if its largest overlap (m) were this one; a law without memory has none to change."""
    return (largest,)[: len(memory)] + (0.0,) * (len(memory) - 1)


def _numba_law(law: Any) -> ShapedLaw:
    if not isinstance(law, types.BaseNamedTuple):
        raise InputError(Problem("law", str(law), "must be a registered NamedTuple", "pass the record, not a plain tuple"))
    return shaped_law_of(law.instance_class)


@overload(force, jit_options={"forceinline": True})
def _(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    function = _numba_law(law).force
    return lambda law, shape, overlap, memory: function(law, shape, overlap, memory)


@overload(contact_radius, jit_options={"forceinline": True})
def _(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    function = _numba_law(law).contact_radius
    return lambda law, shape, overlap, memory: function(law, shape, overlap, memory)


@overload(stored)
def _(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    function = _numba_law(law).stored
    return lambda law, shape, overlap, memory: function(law, shape, overlap, memory)


@overload(stiffness_bound)
def _(law, shape, overlap):  # type: ignore[no-untyped-def]
    function = _numba_law(law).stiffness_bound
    return lambda law, shape, overlap: function(law, shape, overlap)


@overload(untouched)
def _(law):  # type: ignore[no-untyped-def]
    zeros = (0.0,) * len(_numba_law(law).memory)
    return lambda law: zeros


@overload(remembered, jit_options={"forceinline": True})
def _(law, array, row, column):  # type: ignore[no-untyped-def]
    size = len(_numba_law(law).memory)
    if size == 0:
        return lambda law, array, row, column: ()
    return lambda law, array, row, column: to_fixed_tuple(array[row : row + size, column], size)


@overload(remember, jit_options={"forceinline": True})
def _(law, array, row, column, memory):  # type: ignore[no-untyped-def]
    if not _numba_law(law).memory:
        return lambda law, array, row, column, memory: None

    def write(law, array, row, column, memory):  # type: ignore[no-untyped-def]
        for k in range(len(memory)):
            array[row + k, column] = memory[k]

    return write


@overload(kept, jit_options={"forceinline": True})
def _(law, memory):  # type: ignore[no-untyped-def]
    size = len(_numba_law(law).memory)
    if size == 0:
        return lambda law, memory: memory
    zeros = (0.0,) * (size - 1)
    return lambda law, memory: (memory[0], *zeros)


@overload(pressed_to)
def _(law, memory, largest):  # type: ignore[no-untyped-def]
    size = len(_numba_law(law).memory)
    if size == 0:
        return lambda law, memory, largest: memory
    zeros = (0.0,) * (size - 1)
    return lambda law, memory, largest: (largest, *zeros)


@inlined
def same_shape(shape, rolled):  # type: ignore[no-untyped-def]
    """Whether a contact still has, within the tolerance, the shape that it is counted with."""
    return abs(shape[0] - rolled[0]) <= TOLERANCE * rolled[0] and abs(shape[1] - rolled[1]) <= TOLERANCE * rolled[1]


@inlined
def counted(shape, rolled):  # type: ignore[no-untyped-def]
    """The shape that a contact is counted with."""
    return rolled[0], rolled[1], shape[2]


@kernel
def recovered(law, reference, overlap, memory, factor, largest):  # type: ignore[no-untyped-def]
    """The factor of a contact on its way from the `largest` overlap (m) to a larger one: what the way puts in may be stored again.

    The work from one to the other is at least the force there times the way; so much may the stored energy grow, and no more.
    """
    push, at = force(law, reference, largest, memory)
    _, there = force(law, reference, overlap, at)
    held, now = stored(law, reference, largest, at), stored(law, reference, overlap, there)
    if not now > 0.0:
        return factor
    return max(factor, min(1.0, factor * (held + push * (overlap - largest)) / now))


@inner
def sunk(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """The memory with the least largest overlap (m) from which unloading ends at `overlap`, so that nothing is stored there."""
    low = high = overlap
    for _ in range(DOUBLINGS):
        low, high = high, 2.0 * high
        if not stored(law, shape, overlap, pressed_to(law, memory, high)) > 0.0:
            break
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if stored(law, shape, overlap, pressed_to(law, memory, middle)) > 0.0:
            low = middle
        else:
            high = middle
    return pressed_to(law, memory, high)


@kernel
def reshaped(law, shape, overlap, memory, rolled):  # type: ignore[no-untyped-def]
    """Force, memory and `rolled` of a contact that has become one of another shape, no energy put in: less force if it would store more.

    One that lies in its dent and stores nothing is not scaled, or it would bear nothing ever again: its dent is as deep in the new shape.
    """
    _, memory = force(law, counted(shape, rolled), overlap, memory)
    held = rolled[2] * stored(law, counted(shape, rolled), overlap, memory)
    push, memory = force(law, shape, overlap, kept(law, memory))
    now = stored(law, shape, overlap, memory)
    if now > 0.0 and not held > 0.0:
        push, memory = force(law, shape, overlap, sunk(law, shape, overlap, memory))
        now = stored(law, shape, overlap, memory)
    factor = min(1.0, held / now) if now > 0.0 else 1.0
    return factor * push, memory, (shape[0], shape[1], factor, max(rolled[3], overlap))


@inlined
def begun(shape, rolled):  # type: ignore[no-untyped-def]
    """`rolled` of a contact, of a new one from the shape it has."""
    new = rolled[0] == 0.0
    return shape[0] if new else rolled[0], shape[1] if new else rolled[1], 1.0 if new else rolled[2], rolled[3]


@inlined
def lasting(shape, overlap, rolled):  # type: ignore[no-untyped-def]
    """Whether a contact that has begun keeps its shape and its factor: then `lasting_force` is all there is to know."""
    return same_shape(shape, rolled) & ((rolled[2] >= 1.0) | (overlap <= rolled[3]))


@inlined
def lasting_force(law, shape, overlap, memory, rolled):  # type: ignore[no-untyped-def]
    """Force, memory and `rolled` of a contact that keeps its shape and its factor; no branch but the law's, so for many at once."""
    push, memory = force(law, counted(shape, rolled), overlap, memory)
    return rolled[2] * push, memory, (rolled[0], rolled[1], rolled[2], max(rolled[3], overlap))


@inlined
def shaped_force(law, shape, overlap, memory, rolled):  # type: ignore[no-untyped-def]
    """Force in N, memory and `rolled` (see `ROLLED`) of one body at `overlap` (m) where it has `shape` now.

    The law is evaluated with the shape that the contact had when it began, until it differs by more than `TOLERANCE`. Then the present one
    takes its place, at the present overlap, and if more energy could be got back from it, the force is less by that factor from then on.
    So whatever a contact does, it gives back no more than was put in. At no overlap everything is forgotten.
    """
    if overlap <= 0.0:
        return 0.0, untouched(law), UNTOUCHED
    rolled = begun(shape, rolled)
    if not same_shape(shape, rolled):
        return reshaped(law, shape, overlap, memory, rolled)
    factor = rolled[2]
    if factor < 1.0 and overlap > rolled[3]:
        factor = recovered(law, counted(shape, rolled), overlap, memory, factor, rolled[3])
    return lasting_force(law, shape, overlap, memory, (rolled[0], rolled[1], factor, rolled[3]))


@kernel
def shaped_stored(law, mean_radius, overlap, memory, rolled):  # type: ignore[no-untyped-def]
    """What can be got back in J of a contact in the state that `shaped_force` left."""
    return rolled[2] * stored(law, (rolled[0], rolled[1], mean_radius), overlap, memory) if overlap > 0.0 else 0.0
