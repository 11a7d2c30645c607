"""What is to be simulated: bodies, boundary, contact physics by role, loading programme."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from contactlaws.tangential import Damper, Mindlin, Rolling
from dem.box import Box
from dem.particles import Particles


class Contact(NamedTuple):
    """Contact physics by role; None is absent physics."""

    normal: object  # a registered law of contactlaws
    tangential: Mindlin | None = None
    rolling: Rolling | None = None  # only beside friction
    damping: Damper | None = None
    fitted_overlap: float | None = None  # overlap of one body over its radius up to which `normal` was fitted; None: not known
    share: float = 0.5  # of the overlap that is the law's body's, see contactlaws.pair.effective

    @property
    def on_rigid_flat(self) -> Contact:
        """The same sphere on a rigid wall: the law's own case, and twice the moduli of the pair in the other roles."""
        tangential, damping = self.tangential, self.damping
        return self._replace(
            tangential=tangential and tangential._replace(shear_modulus=2.0 * tangential.shear_modulus),
            damping=damping and damping._replace(reduced_modulus=2.0 * damping.reduced_modulus),
            share=1.0,
        )


class Stage(NamedTuple):
    """A part of the loading programme: the edges of the box go linearly to `stretch` times what they were, or follow a stress.

    Stretch and shear count from the box of the scene or, once a stage was under stress control, from the box in which the last such ended.
    """

    stretch: tuple[float, float, float]  # at the end
    duration: float | None = None  # s; None: as slow as the scene's inertial number says
    shear: tuple[float, float, float] = (0.0, 0.0, 0.0)  # at the end: change of tilt xy, xz, yz over the height
    stress: tuple[float | None, float | None, float | None] = (None, None, None)  # Pa, compression positive; None: strain-controlled
    keep: bool = False  # whether stretch and shear are those with which the stage begins

    @property
    def follows_stress(self) -> bool:
        """Whether any edge is under stress control."""
        return any(stress is not None for stress in self.stress)


#: a box as it is
UNCHANGED = Stage((1.0, 1.0, 1.0))


def beginnings(programme: tuple[Stage, ...]) -> tuple[Stage, ...]:
    """The stretch and shear from which each stage goes on, by a stage that ends with them."""
    return tuple(UNCHANGED if before.follows_stress else before for before in (UNCHANGED, *programme[:-1]))[: len(programme)]


def _kept(programme: tuple[Stage, ...]) -> tuple[Stage, ...]:
    """The programme with the stretch and shear that its stages keep written into them."""
    found: tuple[Stage, ...] = ()
    for stage in programme:
        start = beginnings((*found, stage))[-1]
        found = (*found, stage._replace(stretch=start.stretch, shear=start.shear) if stage.keep else stage)
    return found


def uniaxial_compression(strain: float, axis: int = 2, strain_rate: float | None = None, release: bool = True) -> tuple[Stage, ...]:
    """Compress along one axis by an engineering `strain` (0.03 is 3 %), the other edges fixed, and release.

    `strain_rate` is in 1/s; without it the scene's inertial number decides.

    >>> uniaxial_compression(0.03, strain_rate=100.0)[0].stretch
    (1.0, 1.0, 0.97)
    """
    stretch = [1.0, 1.0, 1.0]
    stretch[axis] = 1.0 - strain
    duration = None if strain_rate is None else strain / strain_rate if strain_rate else 0.0
    there = Stage((stretch[0], stretch[1], stretch[2]), duration)
    return (there, Stage((1.0, 1.0, 1.0), duration)) if release else (there,)


def isotropic_compression(strain: float, duration: float | None = None) -> Stage:
    """All edges shortened by the same engineering strain."""
    return Stage((1.0 - strain,) * 3, duration)


def simple_shear(angle: float, duration: float | None = None) -> Stage:
    """The top face moved along x by `angle` times the height, at constant volume."""
    return Stage((1.0, 1.0, 1.0), duration, (0.0, angle, 0.0))


def hold(duration: float, pressure: float | None = None) -> Stage:
    """The box left as it is for `duration` (s); with a `pressure` (Pa), every edge held at that."""
    return UNCHANGED._replace(duration=duration, stress=(pressure,) * 3, keep=True)


def confined(pressure: float, duration: float | None = None) -> Stage:
    """All edges moved until each carries `pressure` (Pa)."""
    return Stage((1.0, 1.0, 1.0), duration, stress=(pressure,) * 3)


class QuasiStatic(NamedTuple):
    """How the quasi-static routine goes: strain steps, and what counts as rest."""

    strain_step: float = 1e-3  # largest change of an edge, or of a shear, between two states of rest
    method: str = "fire"  # or "damped": damped dynamics, for comparison
    force: float = 1e-3  # largest force on a sphere over the mean contact force, or a tenth of that of the largest strain if that is more
    kinetic: float = 1e-5  # kinetic energy of the search over that stored in contacts
    displacement: float = 1e-5  # largest way in the last iteration over the smallest radius
    most: int = 50_000  # iterations
    look: int = 50  # iterations between two looks at whether all is at rest


@dataclass(frozen=True)
class Scene:
    """A whole simulation; two equal scenes give the same result to the last bit on the same number of threads."""

    particles: Particles
    box: Box
    contact: Contact
    programme: tuple[Stage, ...]
    between: tuple[tuple[int, int, Contact], ...] = ()  # kinds of particles that meet by other laws than `contact`
    walls: tuple[bool, bool, bool] = (False, False, False)  # along which open axes the box has a wall at both faces
    wall_contact: tuple[Contact, ...] | None = None  # of each kind; None: its own law on a rigid flat
    moving_walls: float = 0.0  # share of an edge's change that its lower wall makes: 0 the upper moves, 1 the lower, 0.5 both; not affine
    affine: bool = True  # whether the box carries the particles along as it deforms; if not, only its images and walls move
    quasi_static: QuasiStatic | None = None  # a sequence of states of rest; None: motion in time
    outputs: int = 60  # recorded states per stage
    frames: int = 6  # of these, states whose positions are kept
    inertial_number: float = 1e-4  # of stages without a duration; the cost goes with its inverse
    drag: float | None = 2.5  # on velocities relative to a box that deforms: their rate of decay times d sqrt(rho/p); None: no drag
    time_step_fraction: float = 0.4  # of the critical step
    adaptive_step: bool = False  # whether the step follows, from output to output, the deepest contact there is
    density_scaling: float = 1.0  # all masses times this: larger time steps in stages that have a duration
    skin: float = 0.05  # of the Verlet list, over the largest diameter
    threads: int = 1
    neglect: float = 1e-3  # error of the stress for which a relaxing law may give way to an elastic one; 0: none
    carry: tuple[str, ...] = ()  # what is carried though the scene does not need it: see requirements.CARRIED

    def __post_init__(self) -> None:
        object.__setattr__(self, "programme", _kept((self.programme,) if isinstance(self.programme, Stage) else self.programme))

    @property
    def content_hash(self) -> str:
        """Sixteen hexadecimal digits of everything that decides the result, except the code."""
        digest = hashlib.sha256(_bytes_of(self.particles))
        for contact in self.contacts:
            digest.update(law_bytes(contact.normal) + repr(contact[1:]).encode())
        settings = {name: getattr(self, name) for name in self.__dataclass_fields__ if name not in ("particles", "contact", "wall_contact")}
        settings["between"] = [pair[:2] for pair in self.between]
        digest.update(repr(sorted(settings.items())).encode())
        return digest.hexdigest()[:16]

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Every contact's physics."""
        return (self.contact, *(contact for _, _, contact in self.between), *(self.wall_contact or ()))

    @property
    def kinds(self) -> int:
        """How many kinds of particles there are."""
        kind = self.particles.kind
        return 1 if kind is None else int(kind.max(initial=0)) + 1

    def contact_between(self, kind_1: int, kind_2: int) -> Contact:
        """The physics of two kinds of particles."""
        for one, other, contact in self.between:
            if (one, other) in ((kind_1, kind_2), (kind_2, kind_1)):
                return contact
        return self.contact

    def contact_with_wall(self, kind: int) -> Contact:
        """The physics of a kind of particle on a wall."""
        return self.contact_between(kind, kind).on_rigid_flat if self.wall_contact is None else self.wall_contact[kind]

    @property
    def masses(self) -> np.ndarray:
        """kg, shape (n,); with density scaling."""
        return self.particles.mass * self.density_scaling


def law_bytes(law: object) -> bytes:
    """A law's type and parameters, numbers and arrays alike, for hashing."""
    return type(law).__name__.encode() + _bytes_of(law)  # type: ignore[arg-type]


def _bytes_of(fields: Iterable[Any]) -> bytes:
    return b"".join(b"-" if v is None else repr(np.shape(v)).encode() + np.ascontiguousarray(v).tobytes() for v in fields)


class Packed(Protocol):
    """Bodies in a box, whatever their shape: `dem.packing.Packing`, `dem.ellipsoid_packing.EllipsoidPacking`."""

    @property
    def box(self) -> Box:
        """Where they are."""

    def particles(self, density: float) -> Particles:
        """At rest, of one density (kg/m3)."""


def packed_scene(packing: Packed, density: float, contact: Contact, programme: tuple[Stage, ...], **settings: Any) -> Scene:
    """A scene of the bodies of a packing, at rest, of one density (kg/m3). `settings` are those of `Scene`."""
    return Scene(packing.particles(density), packing.box, contact, programme, **settings)
