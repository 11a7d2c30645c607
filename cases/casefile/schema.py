"""The case file: what may stand in it, with units and bounds. Unknown keys are errors, and all errors come at once."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from cases.casefile.validation import Record, in_unit, problems_in, suggestion
from contactlaws.errors import InputError, Problem
from contactlaws.material import Material

_positive = Field(gt=0, allow_inf_nan=False)
Modulus = Annotated[float, in_unit("Pa"), _positive]
Length = Annotated[float, in_unit("m"), _positive]
Density = Annotated[float, in_unit("kg/m^3"), _positive]
Speed = Annotated[float, in_unit("m/s"), _positive]
Rate = Annotated[float, in_unit("1/s"), _positive]
#: overlap over radius; the body ends at 1, and runs to 0.5 are verified
Depth = Annotated[float, in_unit(""), Field(gt=0, lt=1, allow_inf_nan=False)]
Aspect = Annotated[float, in_unit(""), Field(ge=0.1, le=10, allow_inf_nan=False)]
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


class Body(Record):
    """What is pressed, how far, and how exactly."""

    radius: Length = Field(description="half the height of the body, such as '5 um'")
    aspect: Aspect = Field(1.0, description="equatorial semi-axis over radius; 1 is a sphere")
    elastic: bool = Field(False, description="true leaves the yield stress out")
    unload_from: tuple[Depth, ...] = Field(
        (), description="overlaps over radius to unload from, such as 0.05 and 0.1; the body ends at 1, and runs to 0.5 are verified"
    )
    max_overlap: Depth | None = Field(None, description="largest overlap over radius; without it the largest of unload_from")
    tolerance: Annotated[float, in_unit("")] = Field(
        0.01, ge=0.001, le=0.2, allow_inf_nan=False, description="relative error asked for, such as 0.01"
    )


class CurveTable(Body):
    """[curves.NAME]: one finite-element reference curve."""

    material: str = Field(description="the name of a table under [materials]")


class CurveOptions(Body, MaterialTable):
    """The options of `fe2dem reference`."""


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
    """A random close packing of equal spheres in a periodic box, compressed along one axis and released."""

    count: int = Field(ge=8, le=1_000_000, description="the number of spheres, such as 250")
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


class ImpactTable(Impact):
    """[impacts.NAME]: the restitution curve of a fitted law."""

    fit: str = Field(description="the name of a table under [fits], or the path of a law file")


class SceneTable(Scene):
    """[scenes.NAME]: the compression of a packing on a fitted law."""

    fit: str = Field(description="the name of a table under [fits], or the path of a law file")


class SceneFile(Scene):
    """A scene on its own, for `fe2dem simulate`: one scene's keys at the top of the file."""

    law: str | None = Field(None, description="the path of a law file, relative to this file; --law takes its place")


class Case(Record):
    """A case file: what is to be computed, by name."""

    title: str = "fe2dem case"
    materials: dict[Name, MaterialTable] = Field(min_length=1, description="at least one table [materials.NAME]")
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


def read_case(path: str | Path) -> Case:
    """Read and check a case file. Raises `InputError` with all its problems, before anything is computed."""
    values, folder = read_toml(path), Path(path).resolve().parent
    try:
        case, problems = Case.model_validate(values), []
    except ValidationError as error:
        case, problems = _sound_part(values), list(problems_in(error, Case))
    declared = {kind: set(tables) for kind, tables in values.items() if isinstance(tables, dict)}
    problems += _cross_problems(case, declared, folder)
    if problems:
        raise InputError(problems)
    return case


def read_scene(path: str | Path, law: Path | None) -> tuple[Scene, Path]:
    """Read and check a scene file and where its law is; `law` takes the place of the one that the file names. Raises `InputError`."""
    values = read_toml(path)
    scene: SceneFile | None = None
    problems: list[Problem] = []
    try:
        scene = SceneFile.model_validate(values)
        problems += _density_problems("packing_fraction", scene.packing_fraction)
    except ValidationError as error:
        problems += problems_in(error, SceneFile)
    named = values.get("law")
    file = law or (Path(path).parent / named if isinstance(named, str) else None)
    if file is None:
        problems.append(Problem("law", None, "is needed", "give --law LAW.json, or law = 'LAW.json' in the scene file"))
    elif not file.is_file():
        problems.append(Problem("law", str(file), "is no file", "make one with `fe2dem fit CURVE --law NAME --out LAW.json`"))
    else:
        problems += _law_problems("law", file)
    if scene is None or file is None or problems:
        raise InputError(problems)
    return scene, file.resolve()


def read_toml(path: str | Path) -> dict[str, Any]:
    """The tables of a TOML file; raises `InputError` where it is missing or no TOML."""
    try:
        with Path(path).open("rb") as file:
            return tomllib.load(file)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise InputError(Problem("file", str(path), f"cannot be read ({reason})", "give the path of a TOML file")) from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(Problem("file", str(path), f"is not valid TOML ({error})", "repair that line; text values need quotes")) from None


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


def _sound_part(values: Mapping[str, Any]) -> Case:
    """The tables that are right in themselves, so that what is wrong between tables is found in the same pass."""
    sound: dict[str, Any] = {}
    for kind, field in Case.model_fields.items():
        if kind != "title":
            reader = TypeAdapter(TABLES[kind])
            tables = values.get(kind)
            sound[kind] = (
                dict(_readable(reader, tables)) if isinstance(tables, dict) else field.get_default(call_default_factory=True) or {}
            )
    return Case.model_construct(**sound)


def _readable(reader: TypeAdapter[Any], tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, table in tables.items():
        try:
            yield name, reader.validate_python(table)
        except ValidationError:
            continue


def _cross_problems(case: Case, declared: Mapping[str, set[str]], folder: Path) -> Iterator[Problem]:
    """What no single table can know: names that point nowhere, a plastic curve of a material without yield stress, missing depths."""
    from contactlaws.dispatch import laws as known_laws

    for name, curve in case.curves.items():
        yield from _reference(f"curves.{name}.material", curve.material, declared.get("materials", ()))
        material = case.materials.get(curve.material)
        if material and material.yield_stress is None and not curve.elastic:
            yield missing_yield_stress(f"materials.{curve.material}.yield_stress", f"is needed by curves.{name}")
        yield from depth_problems(f"curves.{name}.", curve.unload_from, curve.max_overlap)
    for name, fit in case.fits.items():
        if fit.material is not None:
            yield from _reference(f"fits.{name}.material", fit.material, declared.get("materials", ()))
        yield from _reference(f"fits.{name}.law", fit.law, known_laws(), bound="is not a law that can be fitted")
        for curve_name in fit.curves:
            yield from _reference(f"fits.{name}.curves", curve_name, declared.get("curves", ()), folder)
            if is_file(curve_name) and (folder / curve_name).is_file():
                yield from _curve_problems(f"fits.{name}", folder / curve_name, fit, case)
    yield from _twins(case, folder)
    for kind, tables in (("impacts", case.impacts), ("scenes", case.scenes)):
        for name, table in tables.items():
            yield from _reference(f"{kind}.{name}.fit", table.fit, declared.get("fits", ()), folder)
            if is_file(table.fit) and (folder / table.fit).is_file():
                yield from _law_problems(f"{kind}.{name}.fit", folder / table.fit)
    for name, scene in case.scenes.items():
        yield from _density_problems(f"scenes.{name}.packing_fraction", scene.packing_fraction)


def _curve_problems(name: str, file: Path, fit: FitTable, case: Case) -> Iterator[Problem]:
    """What is wrong with a curve's file, read as the fit will read it."""
    from contactlaws.curve_files import read_curve

    material = case.materials.get(fit.material) if fit.material is not None else None
    try:
        read_curve(file, radius=fit.radius, material=None if material is None else material.record())
    except InputError as error:
        yield from (problem._replace(name=f"{name}: {problem.name}") for problem in error.problems)


def _law_problems(name: str, file: Path) -> Iterator[Problem]:
    """What is wrong with a law's file."""
    from contactlaws import fitted

    try:
        fitted.load(file)
    except InputError as error:
        yield from (problem._replace(name=f"{name}: {problem.name}") for problem in error.problems)


def _twins(case: Case, folder: Path) -> Iterator[Problem]:
    """Fits that would give the same law twice: a table of laws has one row for each law and set of curves."""
    seen: dict[Any, str] = {}
    for name, fit in case.fits.items():
        curves = tuple(sorted(_identity(curve, fit, case, folder) for curve in fit.curves))
        first = seen.setdefault((fit.law, curves), name)
        if first != name:
            yield Problem(f"fits.{name}", fit.law, f"the same law on the same curves as fits.{first}", f"remove it, and use fits.{first}")


def _identity(curve: str, fit: FitTable, case: Case, folder: Path) -> str:
    """Text that two curves share if they are the same one, under whatever name."""
    if is_file(curve):
        material = case.materials.get(fit.material or "")
        return f"{(folder / curve).resolve()} {fit.radius} {material and material.record()}"
    table = case.curves.get(curve)
    material = case.materials.get(table.material) if table is not None else None
    if table is None or material is None:
        return curve
    depths = sorted({*table.unload_from}), max((*table.unload_from, table.max_overlap or 0.0))
    return f"{material.record(table.elastic)._replace(density=None)} {table.radius} {table.aspect} {table.tolerance} {depths}"


def _density_problems(name: str, packing_fraction: float) -> Iterator[Problem]:
    from dem.packing import DENSEST_RANDOM

    if packing_fraction > DENSEST_RANDOM:
        remedy = "ask for 0.64 or less, and reach more by compressing it"
        yield Problem(name, packing_fraction, f"no random packing of equal spheres is denser than {DENSEST_RANDOM}", remedy)


def missing_yield_stress(name: str, bound: str) -> Problem:
    """A plastic curve asked for without a yield stress: never silently an elastic one."""
    return Problem(name, None, bound, "give a stress such as '7.9 GPa', or ask for an elastic curve (elastic = true, --elastic)")


def _reference(
    name: str, value: str, declared: Collection[str], folder: Path | None = None, bound: str = "names nothing in this file"
) -> Iterator[Problem]:
    if folder is not None and is_file(value):
        if not (folder / value).is_file():
            yield Problem(name, value, f"is no file under {folder}", "paths are relative to the case file")
    elif value not in declared:
        yield Problem(name, value, bound, suggestion(value, sorted(declared)))
