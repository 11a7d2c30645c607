"""Curves on disk: Parquet with units in its schema, or CSV with a comment block; read back strictly."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from contactlaws import curve_csv
from contactlaws.curve import QUANTITIES, Curve
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import write_atomically
from contactlaws.json_input import is_number, parsed
from contactlaws.material import Material, checked
from contactlaws.prony import PronyViscoelastic, problems_with_series

FORMAT = "fe2dem curve 1"
UNITS = {
    "time": "s",
    "overlap": "m",
    "force": "N",
    "branch": "1",
    "contact_radius": "m",
    "raw_force": "N",
    "stored_energy": "J",
    "dissipated_energy": "J",
}
#: everything about a curve that is no column; `material` is a mapping of its constants
FACTS = curve_csv.FACTS


def write_curve(curve: Curve, path: str | Path) -> Path:
    """Write `curve` to a .parquet file (all of it) or a .csv file (branch, time, overlap, force, contact radius).

    Raises `InputError` for another ending or if the file cannot be written; a file that was there is then untouched.
    """
    if _suffix(path) == ".csv":
        return curve_csv.write(curve, _facts(curve), path)
    return write_atomically(path, lambda file: _write_parquet(curve, file))


def read_curve(path: str | Path, radius: float | None = None, material: Material | None = None, in_time: bool = False) -> Curve:
    """Read a curve from .parquet or .csv, also a measured one that has only overlap and force; with `in_time` also time.

    `radius` (m) and `material` stand in for what a measured file does not say, and must not contradict what it does. Raises `InputError`
    naming file, row, value and remedy.
    """
    columns, facts = curve_csv.read(path, in_time) if _suffix(path) == ".csv" else _read_parquet(Path(path))
    require(_problems_with(facts, path))
    facts = {**facts, **_material_of(facts, material)}
    if facts.get("series") is not None:
        facts["series"] = _series(facts["series"])
        require(problem._replace(name=f"{path}: {problem.name}") for problem in problems_with_series(facts["series"]))
    if facts.get("radius") is None:
        facts["radius"] = radius
    given = Problem("radius", radius, f"contradicts {path}, which says {facts['radius']!r} m", "leave it out")
    require(() if radius is None or np.isclose(radius, facts["radius"], rtol=1e-9, atol=0.0) else (given,))
    if facts["radius"] is None:
        raise InputError(
            Problem("radius", None, f"{path} does not say how large the body is", "give it, or add the line '# radius: 5e-6' (in m)")
        )
    deepest = float(np.max(columns["overlap"], initial=0.0))
    if deepest >= facts["radius"]:
        raise InputError(
            Problem(f"{path}: overlap", deepest, f"must stay below the radius {facts['radius']!r} m", "check that both are in metres")
        )
    if facts.get("yield_place") is not None:
        facts["yield_place"] = tuple(facts["yield_place"])
    try:
        return Curve(**columns, **facts)
    except InputError as error:
        raise InputError(problem._replace(name=f"{path}: {problem.name}") for problem in error.problems) from error


def _suffix(path: str | Path) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in (".csv", ".parquet"):
        raise InputError(Problem(str(path), suffix, "is no kind of curve file", "end the name in .csv or .parquet"))
    return suffix


def _facts(curve: Curve) -> dict[str, Any]:
    facts = {name: getattr(curve, name) for name in FACTS}
    facts["material"] = None if curve.material is None else curve.material._asdict()
    facts["series"] = None if curve.series is None else curve.series._asdict()
    facts["errors"], facts["provenance"] = dict(curve.errors), dict(curve.provenance)
    return facts


def _series(stated: Mapping[str, Any]) -> PronyViscoelastic:
    rows = {name: None if stated[name] is None else tuple(stated[name]) for name in PronyViscoelastic._fields[2:]}
    return PronyViscoelastic(stated["youngs_modulus"], stated["poissons_ratio"], **rows)  # type: ignore[arg-type]


def _material_of(facts: Mapping[str, Any], given: Material | None) -> dict[str, Material | None]:
    stated = facts.get("material")
    found = None if stated is None else checked(Material(**stated))
    if found is not None and given is not None and given != found:
        raise InputError(Problem("material", tuple(given), f"contradicts the curve file, which says {tuple(found)}", "leave it out"))
    return {"material": given if found is None else found}


def _problems_with(facts: Mapping[str, Any], path: str | Path) -> Iterator[Problem]:
    for name in ("radius", "aspect", "yield_overlap"):
        value = facts.get(name)
        if value is not None and not (is_number(value) and value > 0):
            yield Problem(f"{path}: {name}", value, "must be a positive number", "repair it, in SI units")
    constants = facts.get("material")
    if constants is not None:
        if not isinstance(constants, dict) or not {"youngs_modulus", "poissons_ratio"} <= set(constants) <= set(Material._fields):
            yield Problem(f"{path}: material", constants, f"must name {', '.join(Material._fields)}", "the last two may be missing")
        elif not all(value is None or is_number(value) for value in constants.values()):
            yield Problem(f"{path}: material", constants, "must hold numbers", "give them in SI units")
    place = facts.get("yield_place")
    if place is not None and not (isinstance(place, list | tuple) and len(place) == 2 and all(map(is_number, place))):
        yield Problem(f"{path}: yield_place", place, "must be two numbers", "distance from the axis and from the mid-plane, in m")
    errors = facts.get("errors", {})
    if not isinstance(errors, dict) or not set(errors) <= set(QUANTITIES) or not all(is_number(v) and v >= 0 for v in errors.values()):
        yield Problem(f"{path}: errors", errors, f"must be numbers for {', '.join(QUANTITIES)}", "repair or drop the others")
    if not isinstance(facts.get("in_time", False), bool):
        yield Problem(f"{path}: in_time", facts["in_time"], "must be true or false", "repair or drop it")
    if facts.get("series") is not None:
        yield from _problems_with_series(facts["series"], path)
    if not isinstance(facts.get("provenance", {}), dict):
        yield Problem(f"{path}: provenance", facts["provenance"], "must be a mapping", "repair or drop it")


def _problems_with_series(stated: object, path: str | Path) -> Iterator[Problem]:
    names = PronyViscoelastic._fields
    if not isinstance(stated, dict) or set(stated) != set(names):
        yield Problem(f"{path}: series", stated, f"must name {', '.join(names)}", "write it as a curve of this project does")
        return
    for name in names[:2]:
        if not is_number(stated[name]):
            yield Problem(f"{path}: series: {name}", stated[name], "must be a number", "give it in SI units")
    for name in names[2:]:
        row = stated[name]
        if not (isinstance(row, list | tuple) and all(map(is_number, row))) and not (row is None and name == "bulk_fractions"):
            yield Problem(f"{path}: series: {name}", row, "must be a row of numbers", "give one for each term")


def _write_parquet(curve: Curve, file: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    present = [name for name in UNITS if getattr(curve, name) is not None]
    fields = [pa.field(name, pa.int64() if name == "branch" else pa.float64(), False, {"unit": UNITS[name]}) for name in present]
    metadata = {"format": FORMAT, "facts": json.dumps(_facts(curve), allow_nan=False)}
    table = pa.table([pa.array(getattr(curve, name)) for name in present], schema=pa.schema(fields, metadata))
    pq.write_table(table, file)


def _read_parquet(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(path).read()
    except OSError as error:
        raise InputError(Problem(str(path), error.strerror or str(error), "cannot be read", "check the name and the permission")) from error
    except pa.ArrowException as error:
        _broken(path, str(error).splitlines()[0], "is no whole Parquet file", "it may be truncated: write it again")
    metadata = {key.decode(): value for key, value in (table.schema.metadata or {}).items()}
    if metadata.get("format") != FORMAT.encode():
        _broken(path, table.column_names[:8], f"is Parquet, but no {FORMAT!r}", "write it with contactlaws.curve_files.write_curve")
    for field in table.schema:
        unit = (field.metadata or {}).get(b"unit", b"").decode()
        if UNITS.get(field.name) != unit:
            _broken(
                path, f"{field.name} in {unit!r}", f"columns are {', '.join(f'{k} in {v}' for k, v in UNITS.items())}", "convert or drop it"
            )
    missing = {"time", "overlap", "force", "branch"} - set(table.column_names)
    if missing:
        _broken(path, sorted(missing), "these columns are missing", "write the whole curve")
    try:
        facts = parsed(metadata["facts"])
        return {name: table[name].to_numpy() for name in table.column_names}, {name: facts[name] for name in FACTS if name in facts}
    except (KeyError, TypeError, ValueError) as error:
        _broken(path, str(error), "its description is damaged", "write it again")


def _broken(path: Path, value: object, bound: str, remedy: str) -> NoReturn:
    raise InputError(Problem(str(path), value, bound, remedy))
