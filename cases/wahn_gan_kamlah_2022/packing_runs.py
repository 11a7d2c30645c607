"""What is run for figures 13 to 16 and around them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from cases.wahn_gan_kamlah_2022.packings import (
    BED_RADIUS,
    DENSITY,
    FRACTION,
    OUTPUTS,
    RADIUS,
    SOFT,
    STIFF,
    STRAIN_STEP,
    VISCOUS,
    Run,
    Runs,
    Way,
    compress,
    compression,
    contact,
    contracted,
    dropped,
)
from dem.packing import Packing, random_close_packing
from dem.scene import Stage

#: friction coefficients: none, and what dry grains have
FRICTIONS = (0.0, 0.3)
#: of the dynamic routine
SLOW, FAST = 1e-4, 1e-3
#: loading times of Fig. 15 in s; the paper's rates are one over them
TIMES = (0.1, 1.0, 2.0, 5.0, 10.0, 50.0)
FEWER_TIMES = (1.0, 10.0)
#: coefficients with which Fig. 13's first stress and Fig. 16's long-term stress are sought
SWEEP = (0.0, 0.01, 0.03, 0.1, 0.3)
#: Pa over the reduced modulus; what counts as stress in a packing
THRESHOLD = 1e-6
#: over the pair's modulus; below it a smooth packing has fallen apart, and what is left fades in the search for rest
NO_PRESSURE = 1e-7
#: what counts as rest where forces vanish; with the usual 1e-3 the last states have too few contacts to carry what pressure they show
REST_AT_JAMMING = 1e-6
#: inertial numbers of the density sweep
INERTIAL = (1e-2, 1e-3, 1e-4, 1e-5)
#: what the paper's density numbers come to in its other units, mm, MPa and s: times the true masses
PRINTED_SCALING = 1e12
#: strains of the figures
STRAIN_13, AFTER_13, STRAIN_14, STRAIN_15, STRAIN_16 = 0.10, 0.01, 0.01, 0.005, 0.003
REST_16 = 9.0


class Effort(NamedTuple):
    """How much is run."""

    seeds: tuple[int, ...]
    spheres: int  # of Figs. 14 to 16
    bed: int  # of Fig. 13
    slowest: float  # inertial number of the density sweep


FULL = Effort((1, 2, 3, 4, 5), 250, 226, 1e-5)
QUICK = Effort((1, 2), 100, 100, 1e-4)

Say = Callable[[str], None]


def everything(effort: Effort, say: Say = lambda words: None) -> Runs:
    """All figures, seed after seed."""
    found: list[Run] = []
    for seed in effort.seeds:
        packing, bed = contracted(seed, effort.spheres), dropped(seed, effort.bed)
        for friction in FRICTIONS:
            found += figure_13(bed, seed, friction)
            found += figure_14(packing, seed, friction)
            found += figure_15(packing, seed, friction)
            found += figure_16(packing, seed, friction)
        found += friction_sweep(packing, bed, seed)
        found += first_stress(random_close_packing(effort.spheres, FRACTION, RADIUS, seed), seed)
        say(f"packings of seed {seed}: {len(found)} runs, {sum(r.cpu for r in found):.0f} CPU seconds")
    found += density_sweep(contracted(effort.seeds[0], effort.spheres), effort.seeds[0], effort.slowest)
    return Runs(tuple(found))


def threshold(material: str) -> float:
    """Pa; what counts as stress in a packing of this material."""
    return THRESHOLD * float(contact(material, SOFT, 0.0).normal.reduced_modulus)  # type: ignore[attr-defined]


def figure_13(bed: Packing, seed: int, friction: float) -> Iterator[Run]:
    """From .58 by 10 %; then from the last state without stress by 1 %, at rest and in motion."""
    physics, density = contact("PVDF", SOFT, friction, BED_RADIUS), DENSITY["PVDF"]
    way = Way("13", "from .58", seed, friction, outputs=100, strain_step=1e-3)
    first, trajectory = compress(bed, density, physics, compression(STRAIN_13), way)
    yield first
    onset = first.onset(threshold("PVDF"))
    if onset is None or onset == 0:
        return
    frame = trajectory.frames[onset - 1]
    compacted = Packing(frame.position, BED_RADIUS, frame.box, float(first.fraction[onset - 1]), 0.0)
    slower = way._replace(outputs=OUTPUTS, strain_step=2.5e-4)
    ways = (slower._replace(name="compacted, at rest"), slower._replace(name="compacted, in motion", inertial_number=SLOW))
    yield from (compress(compacted, density, physics, compression(AFTER_13), w)[0] for w in ways)


def figure_14(packing: Packing, seed: int, friction: float) -> Iterator[Run]:
    """NMC by 1 %: routines, BCT and BC, Hertz and Maxwell-Zener."""
    way = Way("14", "", seed, friction)
    hertz, viscous = contact("NMC", SOFT, friction), contact("NMC", VISCOUS, friction)
    ways = (
        (hertz, 1.0, way._replace(name="HSD, at rest, BCT")),
        (hertz, 1.0, way._replace(name="HSD, at rest, BC", affine=False)),
        (hertz, 1.0, way._replace(name="HSD, in motion, BCT", inertial_number=SLOW)),
        (hertz, 1.0, way._replace(name="HSD, in motion, BC", inertial_number=SLOW, affine=False)),
        (hertz, 1.0, way._replace(name="HSD, in motion, BCT, no drag", inertial_number=SLOW, drag=False)),
        (hertz, 1.0, way._replace(name="HSD, in motion, BCT, printed density", density_scaling=PRINTED_SCALING)),
        (viscous, 10.0, way._replace(name="MZ in 10 s, at rest, BCT")),
        (viscous, 10.0, way._replace(name="MZ in 10 s, in motion, BCT", inertial_number=SLOW)),
    )
    yield from (compress(packing, DENSITY["NMC"], law, compression(STRAIN_14, time), w)[0] for law, time, w in ways)


def figure_15(packing: Packing, seed: int, friction: float) -> Iterator[Run]:
    """PVDF by 0.5 % in different times, between the two limits."""
    way, viscous = Way("15", "", seed, friction), contact("PVDF", VISCOUS, friction)
    times = TIMES if friction else FEWER_TIMES
    ways = [(contact("PVDF", kind, friction), 1.0, way._replace(name=kind)) for kind in (SOFT, STIFF)]
    ways += [(viscous, time, way._replace(name=rated(time))) for time in times]
    ways += [(viscous, 1.0, way._replace(name=f"{rated(1.0)}, in motion", inertial_number=SLOW))]
    yield from (compress(packing, DENSITY["PVDF"], law, compression(STRAIN_15, time), w)[0] for law, time, w in ways)


def rated(time: float) -> str:
    """Name of a Maxwell-Zener run of Fig. 15."""
    return f"MZ in {time:g} s"


def figure_16(packing: Packing, seed: int, friction: float) -> Iterator[Run]:
    """PVDF by 0.3 % in 1 s, then held for 9 s; and what the long-term modulus alone gives."""
    way, density = Way("16", "", seed, friction), DENSITY["PVDF"]
    for kind in (SOFT, STIFF):
        yield compress(packing, density, contact("PVDF", kind, friction), compression(STRAIN_16), way._replace(name=kind))[0]
    viscous, programme = contact("PVDF", VISCOUS, friction), compression(STRAIN_16, 1.0, REST_16)
    ways = [way._replace(name="MZ, at rest"), way._replace(name="MZ, in motion, fast", inertial_number=FAST)]
    if friction:
        ways.append(way._replace(name="MZ, in motion, fast, BC", inertial_number=FAST, affine=False))
        ways.append(way._replace(name="MZ, in motion", inertial_number=SLOW))
    yield from (compress(packing, density, viscous, programme, w)[0] for w in ways)


def friction_sweep(packing: Packing, bed: Packing, seed: int) -> Iterator[Run]:
    """The coefficient that the paper does not give: Fig. 13's first stress, and Fig. 16's long-term stress."""
    for friction in SWEEP:
        law, bed_law = contact("PVDF", SOFT, friction), contact("PVDF", SOFT, friction, BED_RADIUS)
        yield compress(packing, DENSITY["PVDF"], law, compression(STRAIN_16), Way("friction", "16", seed, friction))[0]
        if friction not in FRICTIONS:
            way = Way("friction", "13", seed, friction, outputs=50, strain_step=2e-3)
            yield compress(bed, DENSITY["PVDF"], bed_law, compression(STRAIN_13), way)[0]


def first_stress(packing: Packing, seed: int) -> Iterator[Run]:
    """A packing whose contraction was ended at exactly .635, whether the spheres had jammed or not."""
    for friction in FRICTIONS:
        way = Way("cut", "cut at .635", seed, friction, outputs=30, strain_step=5e-4)
        yield compress(packing, DENSITY["PVDF"], contact("PVDF", SOFT, friction), compression(0.015), way)[0]


def density_sweep(packing: Packing, seed: int, slowest: float) -> Iterator[Run]:
    """Fig. 15's 0.5 % in 1 s with masses scaled by more and more."""
    for friction in FRICTIONS:
        law = contact("PVDF", VISCOUS, friction)
        for number in INERTIAL:
            if number < slowest:
                continue
            way = Way("density", f"{number:g}", seed, friction, inertial_number=number)
            yield compress(packing, DENSITY["PVDF"], law, compression(STRAIN_15), way)[0]
        yield compress(packing, DENSITY["PVDF"], law, compression(STRAIN_15), Way("density", "at rest", seed, friction))[0]


class Jammed(NamedTuple):
    """A frictionless packing let go until it falls apart, isotropically: from the most compressed state down to the last with pressure."""

    seed: int
    fraction: np.ndarray
    pressure: np.ndarray  # Pa
    coordination: np.ndarray  # of spheres that are held
    held: np.ndarray  # share of spheres that are held
    falls_apart: tuple[float, float]  # fractions: the first without pressure, the last with it
    reduced_modulus: float  # Pa; of the pair


def unjam(packing: Packing, seed: int, most: float = 0.01, outputs: int = 160) -> Jammed | None:
    """Compress each edge by `most`, and let go in even steps; None if it found no rest on the way."""
    law = contact("PVDF", SOFT, 0.0)
    programme = (Stage((1.0 - most,) * 3, 1.0), Stage((1.0 - 0.6 * most,) * 3, 1.0), Stage((1.0 + 0.1 * most,) * 3, 1.0))
    way = Way("jamming", "", seed, 0.0, outputs=outputs, strain_step=2.0 * STRAIN_STEP, force=REST_AT_JAMMING)
    _, done = compress(packing, DENSITY["PVDF"], law, programme, way)
    if done.stopped is not None:
        return None
    modulus = 0.5 * float(law.normal.reduced_modulus)  # type: ignore[attr-defined]
    down = np.flatnonzero(done.stage > 0)
    off = np.flatnonzero(done.pressure[down] < NO_PRESSURE * modulus)
    last = int(off[0]) if off.size else down.size
    kept = down[:last]
    first_off = float(done.packing_fraction[down[last]]) if off.size else 0.0
    count = len(packing.position)
    share = 1.0 - done.rattlers[kept] / count
    return Jammed(
        seed, done.packing_fraction[kept], done.pressure[kept], done.coordination_number_held[kept], share,
        (first_off, float(done.packing_fraction[kept[-1]])), modulus,
    )  # fmt: skip
