"""A law for ellipsoids that costs nothing and does nothing: what is left of a step is the search for contacts.

In a module of its own, since compiled kernels on the disk name the module of the record that they were compiled for.
"""

from __future__ import annotations

from typing import NamedTuple

from contactlaws.compiled import inlined
from contactlaws.shaped import ShapedLaw, register


class NoForce(NamedTuple):
    """A law that costs nothing and does nothing: what is left is the search."""

    reduced_modulus: float  # Pa; for the looks of it


@inlined
def _none(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """No force."""
    return 0.0, memory


@inlined
def _nothing(law, shape, overlap, memory):  # type: ignore[no-untyped-def]
    """No energy, no radius."""
    return 0.0


@inlined
def _slack(law, shape, overlap):  # type: ignore[no-untyped-def]
    """No stiffness."""
    return 0.0


register(ShapedLaw("no_force", NoForce, _none, _nothing, _nothing, _slack, (), "for benchmarks"))
