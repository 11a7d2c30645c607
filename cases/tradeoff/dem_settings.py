"""What is varied in a packing under compression: one setting at a time, each against the finest of its kind."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from contactlaws.material import Material
from contactlaws.tangential import Mindlin, mindlin

#: spheres like those of NMC: m, kg/m3
RADIUS, DENSITY = 5e-6, 4750.0
MATERIAL = Material(142e9, 0.25, 7.9e9, DENSITY)
PACKING_FRACTION, STRAIN, FRICTION = 0.635, 0.03, 0.3
#: overlap over the radius up to which laws are fitted; spheres are pressed by a third of it
FITTED_TO = 0.05
#: what every run has in common
SCENE = (RADIUS, *MATERIAL, PACKING_FRACTION, STRAIN, FITTED_TO)
FRICTIONAL = mindlin(FRICTION, MATERIAL)


class Setting(NamedTuple):
    """All choices of a run but the packing; the defaults are the usual run."""

    spheres: int = 250
    time_step_fraction: float = 0.4
    law: str = "whole_range"
    tangential: Mindlin | None = FRICTIONAL
    inertial_number: float = 1e-3  # without density scaling: it sets the strain rate
    density_scaling: float = 1.0
    strain_step: float | None = None  # of the quasi-static routine; None: the dynamic one


class Choice(NamedTuple):
    """A setting by the name that it has on its axis."""

    name: str
    setting: Setting


class Axis(NamedTuple):
    """One kind of choice: what may be taken, and the finest, which the others are measured against on the same packings."""

    name: str
    choices: tuple[Choice, ...]
    finest: Choice


class Plan(NamedTuple):
    """All that is to be measured."""

    axes: tuple[Axis, ...]  # choices of the model
    packings: int  # that every choice of the model runs on
    sizes: tuple[tuple[int, int], ...]  # numbers of spheres, and of packings of so many; the last is the finest
    means: tuple[int, ...]  # numbers of packings that a mean is taken over

    @property
    def runs(self) -> list[tuple[Setting, int]]:
        """Every setting with every seed of its packings once; those of one packing after one another, so that settings take turns."""
        wanted = [(choice.setting, seed) for axis in self.axes for choice in (*axis.choices, axis.finest) for seed in self.seeds]
        wanted += [(Setting(spheres=count), seed) for count, packings in self.sizes for seed in range(1, packings + 1)]
        return sorted(dict.fromkeys(wanted), key=lambda run: (run[0].spheres, run[1]))

    @property
    def seeds(self) -> range:
        """Of the packings of the model axes."""
        return range(1, self.packings + 1)


USUAL = Setting()


def plan(quick: bool) -> Plan:
    """The measurement of some ten minutes, or with `quick` of about one."""
    if quick:
        few = (
            _steps((0.2, 0.4, 0.8), 0.1),
            _laws(("thornton", "hertz")),
            _friction(),
            _slowness((1e-2, 3e-3, 1e-3), 3e-4, (1e-3,)),
            _scaling((10.0, 100.0), 3e-4),
        )
        return Plan(few, 2, ((100, 4), (250, 4), (500, 4)), (1, 2, 4))
    axes = (
        _steps((0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0), 0.05),
        _laws(("whole_range_compact", "tabulated", "mdr", "edmans_sinka", "thornton", "luding", "hertz_finite_size", "hertz")),
        _friction(),
        _coefficient(),
        _slowness((1e-2, 3e-3, 1e-3, 3e-4, 1e-4), 3e-5, (1e-3, 5e-4)),
        _scaling((10.0, 100.0, 1000.0, 1e4), 1e-4),
    )
    return Plan(axes, 4, ((100, 16), (250, 16), (500, 16), (1000, 8), (2000, 8)), (1, 2, 4, 8))


def _steps(fractions: Sequence[float], finest: float) -> Axis:
    choices = [Choice(f"{fraction:g} of critical", USUAL._replace(time_step_fraction=fraction)) for fraction in (*fractions, finest)]
    return Axis("time step", tuple(choices[:-1]), choices[-1])


def _laws(names: Sequence[str]) -> Axis:
    choices = tuple(Choice(name.replace("_", " "), USUAL._replace(law=name)) for name in names)
    return Axis("normal law", choices, Choice("whole range", USUAL))


def _friction() -> Axis:
    """From no friction to all of it."""
    choices = (
        Choice("no friction", USUAL._replace(tangential=None)),
        Choice("not turned with the spheres", USUAL._replace(tangential=FRICTIONAL._replace(turning=False))),
        Choice("not shrunk on unloading", USUAL._replace(tangential=FRICTIONAL._replace(shrinking=False))),
    )
    return Axis("tangential model", choices, Choice("Mindlin, shrinking and turning", USUAL))


def _coefficient() -> Axis:
    """A parameter that is seldom known well, as a yardstick."""
    choices = tuple(Choice(f"friction {value:g}", USUAL._replace(tangential=FRICTIONAL._replace(friction=value))) for value in (0.2, 0.4))
    return Axis("friction coefficient", choices, Choice(f"friction {FRICTION:g}", USUAL))


def _slowness(numbers: Sequence[float], finest: float, strain_steps: Sequence[float]) -> Axis:
    """Motion in time at several rates, and states of rest."""
    moving = [Choice(f"inertial number {number:g}", USUAL._replace(inertial_number=number)) for number in (*numbers, finest)]
    resting = (Choice(f"quasi-static, {100 * step:g} %", USUAL._replace(strain_step=step)) for step in strain_steps)
    return Axis("rate and routine", (*moving[:-1], *resting), moving[-1])


def _scaling(factors: Sequence[float], inertial_number: float) -> Axis:
    """At one strain rate: that of the inertial number without scaling."""
    slow = USUAL._replace(inertial_number=inertial_number)
    choices = tuple(Choice(f"density times {factor:g}", slow._replace(density_scaling=factor)) for factor in factors)
    return Axis("density scaling", choices, Choice("true density", slow))
