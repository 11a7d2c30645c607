"""What is to be simulated: bodies, boundary, contact physics by role, loading programme."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import NamedTuple

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
    duration: float | None = None  # s; None: quasi-static, as slow as the scene's inertial number says and with its drag


def uniaxial_compression(strain: float, axis: int = 2, strain_rate: float | None = None, release: bool = True) -> tuple[Stage, ...]:
    """Compress along one axis by an engineering `strain` (0.03 is 3 %), the other edges fixed, and release.

    Quasi-static, unless a `strain_rate` (1/s) is given: then nothing but the contacts takes energy out.

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
    inertial_number: float = 3e-4  # of quasi-static stages; the cost goes with its inverse
    drag: float | None = 2.5  # of quasi-static stages, on velocities relative to the box: their rate of decay times d sqrt(rho/p)
    time_step_fraction: float = 0.4  # of the critical step
    skin: float = 0.05  # of the Verlet list, over the largest diameter

    @property
    def content_hash(self) -> str:
        """Sixteen hexadecimal digits of everything that decides the result, except the code."""
        digest = hashlib.sha256()
        for array in self.particles:
            digest.update(np.ascontiguousarray(array).tobytes())
        rest = (self.box, self.contact, self.programme, self.outputs, self.frames)
        digest.update(repr((*rest, self.inertial_number, self.drag, self.time_step_fraction, self.skin)).encode())
        return digest.hexdigest()[:16]


def packed_scene(packing: Packing, density: float, contact: Contact, programme: tuple[Stage, ...], **settings: float) -> Scene:
    """A scene of the spheres of a packing, at rest, of one density (kg/m3). `settings` are those of `Scene`."""
    return Scene(spheres(packing.position, packing.radius, density), packing.box, contact, programme, **settings)  # type: ignore[arg-type]
