"""What may stand in the tables of a case file, with units and bounds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from cases.casefile.validation import Record, in_unit
from contactlaws.errors import Problem
from contactlaws.material import Material

_positive = Field(gt=0, allow_inf_nan=False)
Modulus = Annotated[float, in_unit("Pa"), _positive]
Length = Annotated[float, in_unit("m"), _positive]
Density = Annotated[float, in_unit("kg/m^3"), _positive]
Speed = Annotated[float, in_unit("m/s"), _positive]
Duration = Annotated[float, in_unit("s"), Field(ge=0, allow_inf_nan=False)]
Rate = Annotated[float, in_unit("1/s"), _positive]
Proportion = Annotated[float, in_unit(""), _positive]
Coefficient = Annotated[float, in_unit(""), Field(ge=0, allow_inf_nan=False)]
#: overlap over radius; the body ends at 1, and runs to 0.5 are verified
Depth = Annotated[float, in_unit(""), Field(gt=0, lt=1, allow_inf_nan=False)]
Aspect = Annotated[float, in_unit(""), Field(ge=0.1, le=10, allow_inf_nan=False)]
#: of the mean force; the finest and the coarsest that the solver offers
Tolerance = Annotated[float, in_unit(""), Field(ge=0.001, le=0.2, allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")]


class MaterialTable(Record):
    """[materials.NAME]: isotropic elastic, perfectly plastic if a yield stress is given."""

    youngs_modulus: Modulus = Field(description="Young's modulus, such as '142 GPa'")
    poissons_ratio: Annotated[float, in_unit("")] = Field(
        ge=0, lt=0.5, allow_inf_nan=False, description="Poisson's ratio, such as 0.25, or 0.49 for a nearly incompressible body"
    )
    yield_stress: Modulus | None = Field(None, description="the yield stress, such as '7.9 GPa'")
    density: Density | None = Field(None, description="the density, such as '4750 kg/m^3'")

    def record(self, elastic: bool = False) -> Material:
        """The constants as the solvers take them."""
        return Material(self.youngs_modulus, self.poissons_ratio, None if elastic else self.yield_stress, self.density)


#: E/Y of anything that could be meant: one modulus without its unit is beyond
MODULUS_RATIOS = (1e-2, 1e7)


def modulus_problems(place: str, table: MaterialTable) -> Iterator[Problem]:
    """A Young's modulus and a yield stress that cannot both be meant; `place` stands before the name."""
    if table.yield_stress is None:
        return
    ratio, (low, high) = table.youngs_modulus / table.yield_stress, MODULUS_RATIOS
    if not low <= ratio <= high:
        bound = f"Young's modulus over yield stress must lie between {low:g} and {high:g}"
        yield Problem(
            f"{place}yield_stress", table.yield_stress, bound, f"here it is {ratio:.3g}; write both with a unit, such as '7.9 GPa'"
        )


class Body(Record):
    """What is pressed, how far, and how exactly."""

    radius: Length = Field(description="half the height of the body, such as '5 um'")
    aspect: Aspect = Field(1.0, description="equatorial semi-axis over radius; 1 is a sphere")
    elastic: bool = Field(False, description="true leaves the yield stress out")
    unload_from: tuple[Depth, ...] = Field(
        (), description="overlaps over radius to unload from, such as 0.05 and 0.1; the body ends at 1, and runs to 0.5 are verified"
    )
    max_overlap: Depth | None = Field(None, description="largest overlap over radius; without it the largest of unload_from")
    tolerance: Tolerance = Field(0.01, description="relative error asked for, such as 0.01")


class CurveTable(Body):
    """[curves.NAME]: one finite-element reference curve."""

    material: str = Field(description="the name of a table under [materials]")
    fields: bool = Field(False, description="true writes the deformed bodies, with stress and plastic strain (.vtu), where it unloads")


class CurveOptions(Body, MaterialTable):
    """The options of `fe2dem reference`."""


class InTime(Record):
    """The options of `fe2dem reference --prony`."""

    youngs_modulus: Modulus | None = Field(None, description="instantaneous Young's modulus, such as '1.77 GPa'")
    poissons_ratio: Annotated[float, in_unit("")] | None = Field(
        None, ge=0, lt=0.5, allow_inf_nan=False, description="instantaneous Poisson's ratio, such as 0.43"
    )
    radius: Length = Field(description="half the height of the body, such as '5 um'")
    aspect: Aspect = Field(1.0, description="equatorial semi-axis over radius; 1 is a sphere")
    max_overlap: Depth | None = Field(None, description="overlap over radius at the end of the ramp")
    unload_from: tuple[Depth, ...] = Field((), description="the same, of a body that is released from there")
    ramp: Duration | None = Field(None, description="time to get there, such as '1 s'")
    hold: Duration = Field(0.0, description="time to stay there, such as '10 s'")
    release: Duration | None = Field(None, description="time to go back to overlap 0, such as '1 s'")
    tolerance: Tolerance = Field(0.01, description="error asked for, over the largest force")


class Sample(Record):
    """The options of `fe2dem fit` that say what a measured curve's file leaves out."""

    radius: Length | None = Field(None, description="half the height of the body, such as '5 um'")
    youngs_modulus: Modulus | None = Field(None, description="Young's modulus, such as '142 GPa'")
    poissons_ratio: Annotated[float, in_unit("")] | None = Field(
        None, ge=0, lt=0.5, allow_inf_nan=False, description="Poisson's ratio, such as 0.25"
    )
    yield_stress: Modulus | None = Field(None, description="the yield stress, such as '7.9 GPa'")

    @model_validator(mode="after")
    def _whole(self) -> Sample:
        if (self.youngs_modulus is None) != (self.poissons_ratio is None) or (
            self.yield_stress is not None and self.youngs_modulus is None
        ):
            context = {"name": "material", "bound": "needs Young's modulus and Poisson's ratio", "remedy": "give both, or none"}
            raise PydanticCustomError("unit", "{bound}|{remedy}", context)
        return self

    def material(self) -> Material | None:
        """The constants, if they were given."""
        if self.youngs_modulus is None or self.poissons_ratio is None:
            return None
        return Material(self.youngs_modulus, self.poissons_ratio, self.yield_stress)


class ToleranceOption(Record):
    """`--tolerance` of `fe2dem run`."""

    tolerance: Tolerance = Field(description="relative error asked for, such as 0.01")


class FitTable(Record):
    """[fits.NAME]: one law fitted to one or several curves."""

    law: str = Field(description="a law's name as listed by `fe2dem laws`")
    curves: tuple[str, ...] = Field(min_length=1, description="names of tables under [curves], or paths of curve files")
    # what a measured curve's file doesn't say
    material: str | None = Field(None, description="for measured curves, the name of a table under [materials]")
    radius: Length | None = Field(None, description="for measured curves, the body's radius")


class Spheres(Record):
    """The equal bodies of an impact or a scene."""

    radius: Length = Field(description="the spheres' radius, such as '5 um'")
    density: Density = Field(description="the density, such as '4750 kg/m^3'")


class Impact(Spheres):
    """Two equal spheres that collide head-on, once at each of the speeds."""

    speed: tuple[Speed, ...] = Field(min_length=1, description="closing speeds, such as ['1 m/s', '10 m/s']")


class Scene(Spheres):
    """A random close packing of equal bodies in a periodic box, loaded and unloaded; what is not asked for is absent."""

    count: int = Field(ge=8, le=1_000_000, description="the number of bodies, such as 250")
    shape: tuple[Proportion, Proportion, Proportion] | None = Field(
        None, description="half axes of ellipsoids in proportion, such as [1, 0.8, 0.66]; `radius` is then that of a sphere of their volume"
    )
    packing_fraction: Annotated[float, in_unit("")] = Field(
        gt=0,
        lt=1,
        allow_inf_nan=False,
        description="solid over box volume, such as 0.635",
    )
    strain: Annotated[float, in_unit("")] = Field(
        gt=0, lt=0.5, allow_inf_nan=False, description="the largest compressive strain, such as 0.03"
    )
    strain_rate: Rate | None = Field(
        None, description="the strain rate, such as '100 1/s'; without it, slow enough that inertia hardly shows"
    )
    release: bool = Field(True, description="whether the strain is taken back at the same rate")
    seed: int = Field(1, ge=0, description="the seed of the random packing")
    loading: Literal["uniaxial", "isotropic", "shear"] = Field("uniaxial", description="how: one edge, all edges, or a simple shear")
    routine: Literal["dynamic", "quasi-static"] = Field("dynamic", description="motion in time, or a sequence of states of rest")
    affine: bool = Field(True, description="whether the box carries the particles along (BCT), or only its faces move (BC)")
    friction: Coefficient | None = Field(None, description="coefficient of Mindlin's friction, such as 0.3; without it none")
    rolling_friction: Coefficient | None = Field(None, description="coefficient of rolling resistance, beside friction")
    restitution: Annotated[float, in_unit("")] | None = Field(
        None, gt=0, le=1, allow_inf_nan=False, description="a damper that returns this restitution on elastic contacts, such as 0.5"
    )
    youngs_modulus: Modulus | None = Field(None, description="the bodies' Young's modulus, for friction, restitution and ellipsoids")
    poissons_ratio: Annotated[float, in_unit("")] | None = Field(None, ge=0, lt=0.5, allow_inf_nan=False, description="and Poisson's ratio")
    yield_stress: Modulus | None = Field(None, description="and yield stress, for ellipsoids, which without it are elastic")
    density_scaling: Annotated[float, in_unit("")] = Field(
        1.0, gt=0, allow_inf_nan=False, description="all masses times this, such as 1000"
    )
    inertial_number: Annotated[float, in_unit("")] = Field(
        1e-4, gt=0, le=1, allow_inf_nan=False, description="how slow, where no strain rate is given"
    )
    time_step_fraction: Annotated[float, in_unit("")] = Field(
        0.4, gt=0, le=1, allow_inf_nan=False, description="time step over the critical one"
    )
    threads: int = Field(1, ge=1, le=64, description="threads of one scene")
    carry: tuple[Literal["radius", "mass", "rates", "rotation", "history"], ...] = Field(
        (), description="what to compute though the scene does not need it"
    )

    @model_validator(mode="after")
    def _physics(self) -> Scene:
        material = self.youngs_modulus is not None and self.poissons_ratio is not None
        for name, needs, what in (
            ("rolling_friction", self.friction, "needs friction"),
            ("friction", material, "needs youngs_modulus and poissons_ratio"),
            ("restitution", material, "needs youngs_modulus and poissons_ratio"),
            ("shape", material, "needs youngs_modulus and poissons_ratio, of which the law of ellipsoids is made"),
            ("yield_stress", self.shape, "needs shape: the law of spheres comes from a fit"),
        ):
            if getattr(self, name) is not None and not needs:
                raise PydanticCustomError("unit", "{bound}|{remedy}", {"name": name, "bound": what, "remedy": "give it too"})
        if self.shape is not None:
            for name, other in (("rolling_friction", self.rolling_friction is not None), ("routine", self.routine != "dynamic")):
                if other:
                    context = {"name": name, "bound": "is for spheres", "remedy": "leave it out, or leave out shape"}
                    raise PydanticCustomError("unit", "{bound}|{remedy}", context)
        if self.loading == "shear" and not self.affine:
            context = {"name": "affine", "bound": "a box that shears carries the particles along", "remedy": "leave affine at true"}
            raise PydanticCustomError("unit", "{bound}|{remedy}", context)
        return self


class ImpactTable(Impact):
    """[impacts.NAME]: the restitution curve of a fitted law."""

    fit: str = Field(description="the name of a table under [fits], or the path of a law file")


class SceneTable(Scene):
    """[scenes.NAME]: the compression of a packing on a fitted law, or on the cheapest one that is good enough."""

    fit: str | None = Field(None, description="the name of a table under [fits], or the path of a law file")
    tolerance: Tolerance | None = Field(None, description="instead of a fit: the error of the contact force that is allowed, such as 0.02")
    curves: tuple[str, ...] = Field((), description="with tolerance: names of tables under [curves], or paths of curve files")

    @model_validator(mode="after")
    def _law(self) -> SceneTable:
        if self.shape is not None:
            if self.fit is not None or self.tolerance is not None or self.curves:
                context = {
                    "name": "shape",
                    "bound": "the law of ellipsoids is made of their material",
                    "remedy": "leave out fit, tolerance, curves",
                }
                raise PydanticCustomError("unit", "{bound}|{remedy}", context)
        elif (self.fit is None) == (self.tolerance is None) or (self.tolerance is not None) != bool(self.curves):
            context = {"name": "fit", "bound": "either a fit, or a tolerance with curves", "remedy": "give one of the two"}
            raise PydanticCustomError("unit", "{bound}|{remedy}", context)
        return self


class SceneFile(Scene):
    """A scene on its own, for `fe2dem simulate`: one scene's keys at the top of the file."""

    law: str | None = Field(None, description="the path of a law file, relative to this file; --law takes its place")


class Outline(Record):
    """The tables that a case file may have, before a look inside."""

    title: str = "fe2dem case"
    materials: dict[Name, Any] = Field(min_length=1, description="at least one table [materials.NAME]")
    curves: dict[Name, Any] = Field(default_factory=dict)
    fits: dict[Name, Any] = Field(default_factory=dict)
    impacts: dict[Name, Any] = Field(default_factory=dict)
    scenes: dict[Name, Any] = Field(default_factory=dict)


class Case(Record):
    """What is to be computed, by name; grids are spanned."""

    title: str = "fe2dem case"
    materials: dict[Name, MaterialTable] = Field(default_factory=dict)
    curves: dict[Name, CurveTable] = Field(default_factory=dict)
    fits: dict[Name, FitTable] = Field(default_factory=dict)
    impacts: dict[Name, ImpactTable] = Field(default_factory=dict)
    scenes: dict[Name, SceneTable] = Field(default_factory=dict)


TABLES: dict[str, type[Record]] = {
    "materials": MaterialTable,
    "curves": CurveTable,
    "fits": FitTable,
    "impacts": ImpactTable,
    "scenes": SceneTable,
}


def is_file(reference: str) -> bool:
    """Whether a reference to a curve or a law means a file, not a table of the same case."""
    return reference.endswith((".csv", ".parquet", ".json"))


def depth_problems(prefix: str, unload_from: tuple[float, ...], max_overlap: float | None) -> Iterator[Problem]:
    """A curve needs to know how far to go, and cannot unload from beyond it."""
    if not unload_from and max_overlap is None:
        yield Problem(f"{prefix}max_overlap", None, "is needed where nothing is unloaded", "give an overlap over radius such as 0.1")
    beyond = [depth for depth in unload_from if max_overlap is not None and depth > max_overlap]
    if beyond:
        yield Problem(
            f"{prefix}unload_from",
            beyond[0],
            f"is beyond max_overlap = {max_overlap:g}",
            "unload from a smaller overlap, or raise max_overlap",
        )


def missing_yield_stress(name: str, bound: str) -> Problem:
    """A plastic curve asked for without a yield stress: never silently an elastic one."""
    return Problem(name, None, bound, "give a stress such as '7.9 GPa', or ask for an elastic curve (elastic = true, --elastic)")
