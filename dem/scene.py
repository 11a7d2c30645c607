"""What is to be simulated: bodies, boundary, contact physics by role, loading programme."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from dem.box import Box
from dem.packing import Packing
from dem.particles import Particles, spheres


class Contact(NamedTuple):
    """Contact physics by role; None is absent physics. Only the normal role is supported so far."""

    normal: object  # a registered law of contactlaws
    tangential: object | None = None
    rolling: object | None = None
    damping: object | None = None
    fitted_overlap: float | None = None  # overlap of one body over its radius up to which `normal` was fitted; None: not known


class Stage(NamedTuple):
    """A part of the loading programme: the edges of the box go linearly to `stretch` times the initial ones."""

    stretch: tuple[float, float, float]  # at the end, over the box of the scene
    duration: float | None = None  # s; None: as slow as the scene's inertial number says


def uniaxial_compression(strain: float, axis: int = 2, strain_rate: float | None = None, release: bool = True) -> tuple[Stage, ...]:
    """Compress along one axis by an engineering `strain` (0.03 is 3 %), the other edges fixed, and release.

    `strain_rate` is in 1/s; without it the scene's inertial number decides.

    >>> uniaxial_compression(0.03, strain_rate=100.0)[0]
    Stage(stretch=(1.0, 1.0, 0.97), duration=0.0003)
    """
    stretch = [1.0, 1.0, 1.0]
    stretch[axis] = 1.0 - strain
    duration = None if strain_rate is None else strain / strain_rate if strain_rate else 0.0
    there = Stage((stretch[0], stretch[1], stretch[2]), duration)
    return (there, Stage((1.0, 1.0, 1.0), duration)) if release else (there,)


@dataclass(frozen=True)
class Scene:
    """A whole simulation; two equal scenes give the same result to the last bit on one thread."""

    particles: Particles
    box: Box
    contact: Contact
    programme: tuple[Stage, ...]
    outputs: int = 60  # recorded states per stage
    frames: int = 6  # of these, states whose positions are kept
    inertial_number: float = 1e-4  # of stages without a duration; the cost goes with its inverse
    drag: float | None = 2.5  # on velocities relative to a box that deforms: their rate of decay times d sqrt(rho/p); None: no drag
    time_step_fraction: float = 0.4  # of the critical step
    skin: float = 0.05  # of the Verlet list, over the largest diameter

    @property
    def content_hash(self) -> str:
        """Sixteen hexadecimal digits of everything that decides the result, except the code."""
        settings = (self.outputs, self.frames, self.inertial_number, self.drag, self.time_step_fraction, self.skin)
        rest = (self.box, self.contact.fitted_overlap, self.programme, settings)
        return hashlib.sha256(_bytes_of(self.particles) + law_bytes(self.contact.normal) + repr(rest).encode()).hexdigest()[:16]


def law_bytes(law: object) -> bytes:
    """A law's type and parameters, numbers and arrays alike, for hashing."""
    return type(law).__name__.encode() + _bytes_of(law)  # type: ignore[arg-type]


def _bytes_of(fields: Iterable[Any]) -> bytes:
    return b"".join(repr(np.shape(value)).encode() + np.ascontiguousarray(value).tobytes() for value in fields)


def packed_scene(packing: Packing, density: float, contact: Contact, programme: tuple[Stage, ...], **settings: float) -> Scene:
    """A scene of the spheres of a packing, at rest, of one density (kg/m3). `settings` are those of `Scene`."""
    return Scene(spheres(packing.position, packing.radius, density), packing.box, contact, programme, **settings)  # type: ignore[arg-type]
