"""What is varied: materials and depths, and for each the mesh, the steps, and the levels of tolerance that the solver offers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from contactlaws.material import Material
from fem.march import Steps
from fem.press import RESOLUTIONS, Resolution

#: E/Y and Poisson's ratio
MATERIALS = ((10.0, 0.3), (100.0, 0.3), (1000.0, 0.3), (100.0, 0.45))
LEVELS = "levels of tolerance"
USUAL = "mesh, usual steps"


class Programme(NamedTuple):
    """One body and its unloadings; overlaps over the radius."""

    modulus_over_yield_stress: float
    poissons_ratio: float
    unload_from: tuple[float, ...]

    @property
    def material(self) -> Material:
        """In units of the yield stress."""
        return Material(self.modulus_over_yield_stress, self.poissons_ratio, 1.0)

    @property
    def largest(self) -> float:
        """The largest overlap."""
        return max(self.unload_from)

    @property
    def name(self) -> str:
        """For people."""
        return f"E/Y {self.modulus_over_yield_stress:g}, ν {self.poissons_ratio:g}, to {self.largest:g} R"


class Setting(NamedTuple):
    """One choice of mesh and steps, and what it is there to show."""

    group: str
    name: str
    resolution: Resolution


class Plan(NamedTuple):
    """All that is to be measured down to one depth."""

    depth: float
    programmes: tuple[Programme, ...]
    settings: tuple[Setting, ...]
    finest: Setting  # what the others are measured against

    @property
    def everything(self) -> list[tuple[Programme, Setting]]:
        """All runs, those of one setting after one another."""
        return [(programme, setting) for setting in (*self.settings, self.finest) for programme in self.programmes]


def plans(quick: bool, finest: int | None = None) -> list[Plan]:
    """The runs: in minutes, or with `quick` in about one. `finest`: divisions of the mesh that the others are measured against."""
    if quick:
        return [_plan((0.03, 0.1), MATERIALS[1:3], (4, 6, 8), finest or 12)]
    return [_plan((0.03, 0.1), MATERIALS, (4, 6, 8, 12), finest or 20), _plan((0.15, 0.5), MATERIALS, (4, 6, 8, 12), finest or 16)]


def steps_plan() -> Plan:
    """One knob of the steps after the other, on the mesh of the coarsest level; against all of them short, on that same mesh."""
    programmes = tuple(Programme(ratio, nu, (0.03, 0.1)) for ratio, nu in MATERIALS[1:3])
    divisions, steps = RESOLUTIONS[0][1]
    settings = [Setting("as the coarsest level has them", "usual", RESOLUTIONS[0][1])]
    for knob in ("first", "growth", "force_drop"):
        value = getattr(steps, knob)
        for new in (value**2, value**0.5) if knob == "growth" else (2.0 * value, 0.5 * value):
            name = f"{knob.replace('_', ' ')} {new:.3g}"
            settings.append(Setting(knob.replace("_", " "), name, Resolution(divisions, steps._replace(**{knob: new}))))
    return Plan(0.1, programmes, tuple(settings), Setting("finest", "all short", Resolution(divisions, shorter(shorter(steps)))))


def _plan(unload_from: tuple[float, ...], materials: tuple[tuple[float, float], ...], meshes: tuple[int, ...], finest: int) -> Plan:
    programmes = tuple(Programme(ratio, nu, unload_from) for ratio, nu in materials)
    settings = [*_meshes(meshes), *_levels(finest)]
    reference = Setting("finest", f"{finest} divisions, short steps", Resolution(finest, shorter(usual())))
    return Plan(max(unload_from), programmes, tuple(_once(settings)), reference)


def usual() -> Steps:
    """The steps of the coarsest level of tolerance."""
    return RESOLUTIONS[0][1].steps


def shorter(steps: Steps) -> Steps:
    return steps._replace(first=0.5 * steps.first, growth=steps.growth**0.5, force_drop=0.5 * steps.force_drop)


def longer(steps: Steps) -> Steps:
    return steps._replace(first=2.0 * steps.first, growth=steps.growth**2, force_drop=2.0 * steps.force_drop)


def _levels(finest: int) -> Iterator[Setting]:
    """Those of the solver that are coarser than the finest mesh here."""
    for tolerance, resolution in RESOLUTIONS:
        if resolution.divisions < finest:
            yield Setting(LEVELS, f"level {100 * tolerance:g} %", resolution)


def _meshes(meshes: tuple[int, ...]) -> Iterator[Setting]:
    """With the steps of the coarsest level, and with longer ones where the mesh is too coarse for anything else to matter."""
    for divisions in meshes:
        yield Setting(USUAL, f"{divisions}", Resolution(divisions, usual()))
        if divisions <= 8:
            yield Setting("mesh, long steps", f"{divisions} long", Resolution(divisions, longer(usual())))


def _once(settings: list[Setting]) -> Iterator[Setting]:
    """Each resolution once, under all of its names."""
    names: dict[Resolution, list[str]] = {}
    for setting in settings:
        names.setdefault(setting.resolution, []).append(setting.name)
    for setting in settings:
        if setting.name == names[setting.resolution][0]:
            yield setting._replace(name=", ".join(names[setting.resolution]))
