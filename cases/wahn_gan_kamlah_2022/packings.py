"""The packings of section 5, their materials, and one compression of one of them.

Frictionless or with a friction coefficient: the paper has Coulomb's limit, but no coefficient. Radii as in its captions.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cases.wahn_gan_kamlah_2022.material import TOGETHER
from contactlaws.elastic import Hertz
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.prony import PronyViscoelastic, Relaxation, uniaxial
from contactlaws.tangential import mindlin
from dem import requirements
from dem.box import Box
from dem.drop_and_roll import drop_and_roll, periodic_in_height
from dem.jodrey_tory import push_apart
from dem.packing import Packing
from dem.packing_cells import cells_for
from dem.scene import Contact, QuasiStatic, Scene, Stage, packed_scene
from dem.simulation import run
from dem.timestep import scene_time_step
from dem.trajectory import Trajectory

FloatArray = npt.NDArray[np.float64]

#: m; of the 250 spheres of Figs. 14 to 16, and of the 226 of Fig. 13
RADIUS, BED_RADIUS = 2.5e-7, 2.5e-6
COUNT, BED_COUNT = 250, 226
FRACTION, BED_FRACTION = 0.635, 0.58
#: the rate at which the contraction of Jodrey & Tory ends, all spheres jammed, at .635 on the average over seeds
CONTRACTION = 5e-4
#: spheres dropped for 226 between floor and surface
DROPPED = 700
#: kg/m3; Table 1 has these numbers as g/mm3
DENSITY = {"PVDF": 1800.0, "NMC": 4750.0}
#: NMC of Table 1: E_1 = 42 GPa, E_2 = 142 GPa, eta = 250 GPa s
NMC = uniaxial(Relaxation(184e9, (42.0 / 184.0,), (250.0 / 42.0,)), 0.25)
MATERIALS: dict[str, PronyViscoelastic] = {"PVDF": TOGETHER, "NMC": NMC}
SOFT, STIFF, VISCOUS = "E_soft", "E_stiff", "MZ"
#: strain between two states of rest
STRAIN_STEP = 2.5e-4
OUTPUTS = 20
#: of the pair list in the dynamic routine: below jamming smooth spheres go far
SKIN = 0.4


def contracted(seed: int, count: int = COUNT, radius: float = RADIUS) -> Packing:
    """Jodrey & Tory's packing as the paper has it: the contraction decides at which fraction it ends, about .635, not the user."""
    solid = 4.0 / 3.0 * math.pi * count
    nominal, edges = np.full(count, solid ** (-1.0 / 3.0)), np.ones(3)
    position = np.random.default_rng(seed).random((count, 3))
    ratio, moves = push_apart(position, nominal, cells_for(nominal, edges), math.inf, CONTRACTION, int(4.0 * count / CONTRACTION))
    edge = radius / (nominal[0] * ratio)
    return Packing(position * edge, radius, Box((edge, edge, edge)), ratio**3, 0.0, moves, CONTRACTION)


def dropped(seed: int, count: int = BED_COUNT, radius: float = BED_RADIUS) -> Packing:
    """Spheres dropped and rolled into a cube at .58, made periodic in height."""
    width = radius * (4.0 / 3.0 * math.pi * count / BED_FRACTION) ** (1.0 / 3.0)
    return periodic_in_height(drop_and_roll(max(DROPPED, 3 * count), radius, seed, width), count, BED_FRACTION)


def contact(material: str, kind: str, friction: float, radius: float = RADIUS) -> Contact:
    """Hertz with either modulus or the Maxwell-Zener law of a half-space, as in the paper; tangential springs are elastic.

    Those of the Maxwell-Zener law have the long-term modulus.
    """
    body = MATERIALS[material]
    elastic: Material = body.instantaneous if kind == STIFF else body.long_term
    normal: Any = maxwell_zener(body.reduced, radius) if kind == VISCOUS else Hertz(radius, elastic.reduced_modulus)
    return Contact(normal, None if friction == 0.0 else mindlin(friction, elastic))


def compression(strain: float, duration: float = 1.0, rest: float = 0.0) -> tuple[Stage, ...]:
    """Along z by `strain` in `duration` (s), then held for `rest` (s)."""
    stage = Stage((1.0, 1.0, 1.0 - strain), duration)
    return (stage, stage._replace(duration=rest)) if rest else (stage,)


class Run(NamedTuple):
    """One compression, or one compression and rest, of one packing."""

    figure: str
    name: str  # law and routine
    seed: int
    friction: float
    strain: FloatArray
    stress: FloatArray  # Pa; along z
    pressure: FloatArray  # Pa
    time: FloatArray  # s
    fraction: FloatArray
    coordination: FloatArray  # of all spheres
    held: FloatArray  # of those held, if no friction holds them
    kinetic: float  # over the stored energy at the peak
    inertial_number: float  # at the top, with the pressure there; 0 in the quasi-static routine
    density_scaling: float
    steps: int
    cpu: float  # s
    balance: float  # of energy
    stopped: bool

    def at(self, strain: float) -> float:
        """Stress in Pa at a strain of the first loading."""
        top = int(np.argmax(self.strain)) + 1
        return float(np.interp(strain, self.strain[:top], self.stress[:top]))

    def contacts_at(self, strain: float) -> float:
        """Contacts per sphere at a strain of the first loading."""
        top = int(np.argmax(self.strain)) + 1
        return float(np.interp(strain, self.strain[:top], self.coordination[:top]))

    def onset(self, pressure: float) -> int | None:
        """First output at which a pressure (Pa) is reached; None if never."""
        rows = np.flatnonzero(self.pressure >= pressure)
        return int(rows[0]) if rows.size else None


class Way(NamedTuple):
    """Where a run belongs and how it is done."""

    figure: str
    name: str
    seed: int
    friction: float
    inertial_number: float | None = None  # of the dynamic routine, wanted at the top; None: quasi-static
    affine: bool = True  # BCT; else BC
    drag: bool = True  # in the dynamic routine
    density_scaling: float | None = None  # of the dynamic routine, in place of the inertial number
    outputs: int = OUTPUTS
    strain_step: float = STRAIN_STEP
    force: float = QuasiStatic().force  # of a state of rest, as there


def scene_of(packing: Packing, density: float, physics: Contact, programme: tuple[Stage, ...], way: Way) -> Scene:
    """The scene; density scaling is what gives a stage of this physical duration the inertial number that is wanted."""
    settings: dict[str, Any] = {"outputs": way.outputs, "frames": way.outputs, "affine": way.affine}
    if way.inertial_number is None and way.density_scaling is None:
        return packed_scene(
            packing, density, physics, programme, quasi_static=QuasiStatic(strain_step=way.strain_step, force=way.force), **settings
        )
    scene = packed_scene(packing, density, physics, programme, skin=SKIN, drag=2.5 if way.drag else None, **settings)
    scaling = way.density_scaling
    if scaling is None:
        rate = requirements.changes(scene)[0] / requirements.durations(scene)[0]
        scaling = ((way.inertial_number or 0.0) / (rate * requirements.inertial_time(scene))) ** 2
    return packed_scene(packing, density, physics, programme, skin=SKIN, drag=scene.drag, density_scaling=scaling, **settings)


def compress(packing: Packing, density: float, physics: Contact, programme: tuple[Stage, ...], way: Way) -> tuple[Run, Trajectory]:
    """Do one run."""
    scene = scene_of(packing, density, physics, programme, way)
    done = run(scene)
    ratio, number = (done.statistics[name] for name in ("kinetic_over_stored_at_peak", "inertial_number_at_peak"))
    record = Run(
        way.figure, way.name, way.seed, way.friction, done.strain[:, 2], done.stress[:, 2, 2], done.pressure, done.time,
        done.packing_fraction, done.coordination_number, done.coordination_number_held, float(ratio or 0.0),
        float(number or 0.0) if scene.quasi_static is None else 0.0, scene.density_scaling, int(done.statistics["steps"]),
        float(done.statistics["cpu_seconds"]), float(done.statistics["energy_balance"]), done.stopped is not None,
    )  # fmt: skip
    return record, done


def itasca_scaling(density: float, physics: Contact, packing: Packing, strain: float, step: float) -> float:
    """By what masses must be multiplied for Itasca's time step (Eq. 2.8) to be `step` (s) at overlaps of `strain` of the diameter."""
    scene = packed_scene(packing, density, physics, compression(strain))
    return (step / scene_time_step(scene, 2.0 * RADIUS * strain, 1.0).itasca) ** 2


class Runs(NamedTuple):
    """Everything that was run."""

    all: tuple[Run, ...]

    def of(self, figure: str, name: str, friction: float) -> list[Run]:
        """By seed; runs that found no rest are left out."""
        found = (r for r in self.all if (r.figure, r.name, r.friction) == (figure, name, friction) and not r.stopped)
        return sorted(found, key=lambda r: r.seed)

    def pairs(self, figure: str, one: str, other: str, friction: float) -> list[tuple[Run, Run]]:
        """Runs of the same packings in two ways."""
        second = {r.seed: r for r in self.of(figure, other, friction)}
        return [(r, second[r.seed]) for r in self.of(figure, one, friction) if r.seed in second]

    @property
    def frictions(self) -> list[float]:
        """All coefficients of the main figures."""
        return sorted({r.friction for r in self.all if r.figure == "14"})


def signed(value: float, form: str) -> str:
    """A number with a proper minus, and none before a zero.

    >>> signed(-0.04, "+.1f"), signed(-0.24, ".1f")
    ('0.0', '\u22120.2')
    """
    shown = f"{value:{form}}"
    return shown.replace("-", "\u2212") if shown.strip("+-0.") else shown.lstrip("+-")


class Band(NamedTuple):
    """Mean, least and most over seeds."""

    mean: float
    least: float
    most: float
    packings: int

    def text(self, form: str = ".3g", unit: str = "", factor: float = 1.0) -> str:
        """For a table."""
        if not self.packings:
            return "–"
        mean, least, most = (signed(factor * value, form) for value in (self.mean, self.least, self.most))
        return f"{mean}{unit} ({least} to {most}; {self.packings})"


def band(values: Iterable[float]) -> Band:
    """Of finite values."""
    array = np.array([v for v in values if math.isfinite(v)])
    if not array.size:
        return Band(math.nan, math.nan, math.nan, 0)
    return Band(float(array.mean()), float(array.min()), float(array.max()), int(array.size))
