"""Prony series on disk: a CSV file with one term a row, and the instantaneous constants in its comments.

    # youngs_modulus: 1.77e9
    # poissons_ratio: 0.4314
    relaxation_time,shear_fraction
    1.78,0.237

Times are in s and rise, Young's modulus is in Pa. A third column bulk_fraction says how the bulk modulus relaxes; without it Poisson's
ratio stays as it is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from contactlaws.csv_rows import Rows, finite, read_rows
from contactlaws.errors import Problem, require
from contactlaws.files import write_text
from contactlaws.prony import PronyViscoelastic, Relaxation, problems_with_series, uniaxial
from contactlaws.version import code_version

FORMAT = "fe2dem prony series"
TIME, SHEAR, BULK = "relaxation_time", "shear_fraction", "bulk_fraction"
CONSTANTS = {"youngs_modulus": "Pa", "poissons_ratio": "-"}
REMEDIES = {"youngs_modulus": "1.77e9' (instantaneous, in Pa)", "poissons_ratio": "0.4314' (instantaneous)"}
#: names in the record, and where they stand in the file
PLACES = {"relaxation_times": TIME, "shear_fractions": SHEAR, "bulk_fractions": BULK}


def write_series(material: PronyViscoelastic, path: str | Path, facts: Mapping[str, Any] | None = None) -> Path:
    """Write a .csv file that `read_series` gives back to the last digit; `facts` go into its comments as JSON.

    Raises `InputError` for constants that nothing can use, another ending, or a place that cannot be written.
    """
    require(problems_with_series(material))
    columns = {TIME: material.relaxation_times, SHEAR: material.shear_fractions}
    if material.bulk_fractions is not None:
        columns[BULK] = material.bulk_fractions
    return _write({name: getattr(material, name) for name in CONSTANTS}, columns, path, facts or {})


def write_youngs(modulus: Relaxation, path: str | Path, facts: Mapping[str, Any] | None = None) -> Path:
    """The same for a Young's modulus alone, of a material whose Poisson's ratio stays, and is left to whoever reads the file.

    Raises `InputError` as `write_series` does.
    """
    uniaxial(modulus, 0.0)  # raises where the terms cannot be used
    return _write({"youngs_modulus": modulus.instantaneous}, {TIME: modulus.times, SHEAR: modulus.fractions}, path, facts or {})


def _write(constants: Mapping[str, float], columns: Mapping[str, Sequence[float]], path: str | Path, facts: Mapping[str, Any]) -> Path:
    require(_problems_with_ending(path))
    lines = [f"# format: {FORMAT}", "# units: Pa, s; fractions of the instantaneous moduli", f"# code: {code_version()}"]
    lines += [f"# {name}: {float(value)!r}" for name, value in constants.items()]
    lines += [f"# {name}: {json.dumps(value, allow_nan=False)}" for name, value in facts.items()]
    lines.append(",".join(columns))
    lines += [",".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)]
    return write_text(path, "\n".join(lines) + "\n")


def read_series(path: str | Path, youngs_modulus: float | None = None, poissons_ratio: float | None = None) -> PronyViscoelastic:
    """Read a Prony series. A file without rows is one of an elastic material.

    youngs_modulus (Pa) and poissons_ratio, both instantaneous, stand in for what the file does not say, and must not contradict what it
    does. Raises `InputError` naming file, line, value and remedy.
    """
    require(_problems_with_ending(path))
    rows = read_rows(path, (TIME, SHEAR, BULK), tuple(CONSTANTS))
    given = {"youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio}
    stated = {name: finite(text) for name, text in rows.facts.items()}
    require([*_missing(path, rows), *_problems_with_constants(path, rows, stated, given)])
    modulus, ratio = (given[name] if stated.get(name) is None else stated[name] for name in CONSTANTS)
    times, shear, bulk = (None if name not in rows.columns else tuple(rows.columns[name]) for name in (TIME, SHEAR, BULK))
    made = PronyViscoelastic(modulus, ratio, times, shear, bulk)  # type: ignore[arg-type]  # none of them is missing by now
    require(_placed(problem, path, rows) for problem in problems_with_series(made))
    return made


def _problems_with_ending(path: str | Path) -> Iterator[Problem]:
    if Path(path).suffix.lower() != ".csv":
        yield Problem(str(path), Path(path).suffix, "is no kind of file for a Prony series", "end the name in .csv")


def _missing(path: str | Path, rows: Rows) -> Iterator[Problem]:
    for name in (TIME, SHEAR):
        if name not in rows.columns:
            remedy = f"name the columns '{TIME},{SHEAR}', or add {BULK} to them"
            yield Problem(f"{path}: column {name}", None, f"the header is {','.join(rows.columns)!r}", remedy)


def _problems_with_constants(
    path: str | Path, rows: Rows, stated: Mapping[str, float | None], given: Mapping[str, float | None]
) -> Iterator[Problem]:
    for name in CONSTANTS:
        own, other = stated.get(name), given[name]
        if name in stated and own is None:
            yield Problem(f"{path}: {name}", rows.facts[name], "must be a finite number", "give it in SI units")
        elif own is None and other is None:
            yield Problem(name, None, f"{path} does not say it", f"give it, or add the line '# {name}: {REMEDIES[name]}")
        elif own is not None and other is not None and not math.isclose(own, other, rel_tol=1e-9):
            yield Problem(name, other, f"contradicts {path}, which says {own!r}", "leave it out")


def _placed(problem: Problem, path: str | Path, rows: Rows) -> Problem:
    """A problem of the record, named by file and line."""
    name, _, number = problem.name.removesuffix("]").partition("[")
    line = f" line {rows.lines[int(number) - 1]}" if number else ""
    return problem._replace(name=f"{path}{line}: {PLACES.get(name, name)}")
