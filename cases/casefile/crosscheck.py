"""What no single table of a case can know: names that point nowhere, missing depths, fits that would be made twice."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from cases.casefile.schema import Case, FitTable, Scene, depth_problems, is_file, missing_yield_stress, modulus_problems
from cases.casefile.validation import suggestion
from contactlaws.errors import InputError, Problem


def cross_problems(case: Case, declared: Mapping[str, set[str]], folder: Path) -> Iterator[Problem]:
    """What no single table can know: names that point nowhere, a plastic curve of a material without yield stress, missing depths."""
    for name, material_table in case.materials.items():
        yield from modulus_problems(f"materials.{name}.", material_table)
    for name, curve in case.curves.items():
        yield from _reference(f"curves.{name}.material", curve.material, declared.get("materials", ()))
        material = case.materials.get(curve.material)
        if material and material.yield_stress is None and not curve.elastic:
            yield missing_yield_stress(f"materials.{curve.material}.yield_stress", f"is needed by curves.{name}")
        yield from depth_problems(f"curves.{name}.", curve.unload_from, curve.max_overlap)
    for name, fit in case.fits.items():
        if fit.material is not None:
            yield from _reference(f"fits.{name}.material", fit.material, declared.get("materials", ()))
        yield from _reference(f"fits.{name}.law", fit.law, _laws(), bound="is not a law that can be fitted")
        for curve_name in fit.curves:
            yield from _reference(f"fits.{name}.curves", curve_name, declared.get("curves", ()), folder)
            if is_file(curve_name) and (folder / curve_name).is_file():
                yield from _curve_problems(f"fits.{name}", folder / curve_name, fit, case)
    yield from _twins(case, folder)
    for kind, tables in (("impacts", case.impacts), ("scenes", case.scenes)):
        for name, table in tables.items():
            if table.fit is None:
                continue
            yield from _reference(f"{kind}.{name}.fit", table.fit, declared.get("fits", ()), folder)
            if is_file(table.fit) and (folder / table.fit).is_file():
                yield from law_problems(f"{kind}.{name}.fit", folder / table.fit)
    for name, scene in case.scenes.items():
        for curve_name in scene.curves:
            yield from _reference(f"scenes.{name}.curves", curve_name, declared.get("curves", ()), folder)
        yield from density_problems(f"scenes.{name}.packing_fraction", scene)


def _laws() -> Collection[str]:
    from contactlaws.dispatch import laws  # not above: compiled code takes long to load, and a study of curves needs none of it here

    return laws()


def _curve_problems(name: str, file: Path, fit: FitTable, case: Case) -> Iterator[Problem]:
    """What is wrong with a curve's file, read as the fit will read it."""
    from calibration.recipes import IN_TIME
    from contactlaws.curve_files import read_curve

    material = case.materials.get(fit.material) if fit.material is not None else None
    try:
        record = None if material is None else material.record()
        read_curve(file, radius=fit.radius, material=record, in_time=fit.law in IN_TIME)
    except InputError as error:
        yield from (problem._replace(name=f"{name}: {problem.name}") for problem in error.problems)


def law_problems(name: str, file: Path) -> Iterator[Problem]:
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


def density_problems(name: str, scene: Scene) -> Iterator[Problem]:
    """A packing fraction that no random packing has, and half axes that no law is for."""
    from contactlaws.contact_ellipse import slender_problems
    from dem.ellipsoid_packing import DENSEST
    from dem.packing import DENSEST_RANDOM

    most, kind, enough = (DENSEST_RANDOM, "equal spheres", 0.64) if scene.shape is None else (DENSEST, "ellipsoids", 0.7)
    if scene.packing_fraction > most:
        remedy = f"ask for {enough} or less, and reach more by compressing it"
        yield Problem(name, scene.packing_fraction, f"no random packing of {kind} is denser than {most}", remedy)
    if scene.shape is not None:
        yield from slender_problems(name.replace("packing_fraction", "shape"), scene.shape)


def _reference(
    name: str, value: str, declared: Collection[str], folder: Path | None = None, bound: str = "names nothing in this file"
) -> Iterator[Problem]:
    if folder is not None and is_file(value):
        if not (folder / value).is_file():
            yield Problem(name, value, f"is no file under {folder}", "paths are relative to the case file")
    elif value not in declared:
        yield Problem(name, value, bound, suggestion(value, sorted(declared)))
