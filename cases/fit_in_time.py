"""`fe2dem fit` with a viscoelastic law: its relaxation times and moduli from curves in time, straight from the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from cases import console
from cases.casefile.schema import Length
from cases.casefile.validation import Record, in_unit
from cases.options import checked, problems_with_output
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError, Problem

#: constants that other laws are told
FITTED = ("youngs_modulus", "yield_stress")


class SeriesOptions(Record):
    """The options of `fe2dem fit` that a viscoelastic law has."""

    radius: Length | None = Field(None, description="half the height of the body, such as '5 um'")
    poissons_ratio: Annotated[float, in_unit("")] | None = Field(None, ge=0, lt=0.5, allow_inf_nan=False, description="such as 0.43")
    terms: int | None = Field(None, ge=0, description="how many, such as 2")


def fit_in_time(paths: Sequence[Path], law: str, out: Path | None, values: Mapping[str, Any]) -> None:
    """Fit, print and save; `values`: options that were given. Raises `InputError` before computing."""
    options, problems = checked(SeriesOptions, {name: value for name, value in values.items() if name not in FITTED})
    foreign = [name for name in FITTED if name in values]
    problems += [Problem(name, values[name], f"is not asked for by {law}: the modulus is fitted", "leave it out") for name in foreign]
    problems = [problem._replace(name="--" + problem.name.replace("_", "-")) for problem in problems]
    problems += problems_with_output("--out", out, (".json",), needed=False)
    if not paths:
        problems.append(Problem("CURVE", None, "is needed", "give one or several curves in time, .csv or .parquet"))
    curves: list[Curve] = []
    for path in paths:
        try:
            curves.append(_read(path, options.radius if options is not None else None))
        except InputError as error:
            problems += [problem._replace(name="--radius") if problem.name == "radius" else problem for problem in error.problems]
    if options is None or problems:
        raise InputError(problems)

    import calibration
    from contactlaws import fitted

    ratio = {} if options.poissons_ratio is None else {"poissons_ratio": options.poissons_ratio}
    try:
        found = calibration.fit(curves, law, fixed=ratio, terms=options.terms)
    except InputError as error:
        raise InputError(_named(problem, paths) for problem in error.problems) from error
    if out is not None:
        fitted.save(found.fitted, out)
    show(found, out)


def _read(path: Path, radius: float | None) -> Curve:
    """A curve in time, also a measured one that has only time, overlap and force."""
    if _computed_without_time(path, radius):
        bound = "was computed of a body whose force knows no time"
        raise InputError(Problem(str(path), "a curve without time", bound, "compute it with --prony, or fit a law such as 'thornton'"))
    return read_curve(path, radius=radius, in_time=True)


def _computed_without_time(path: Path, radius: float | None) -> bool:
    try:
        curve = read_curve(path, radius=radius)
    except InputError:  # with rests, a measured curve is one only in time
        return False
    return bool(curve.provenance) and not curve.in_time


def _named(problem: Problem, paths: Sequence[Path]) -> Problem:
    """With the file in place of the number of a curve, and options as they are typed."""
    for number, path in enumerate(paths):
        if problem.name.startswith(f"curves[{number}]"):
            return problem._replace(name=problem.name.replace(f"curves[{number}]", str(path)))
    return problem._replace(name="--terms") if problem.name == "terms" else problem


def show(found: Any, out: Path | None) -> None:
    """How many terms, the parameters with their errors, and what the curves do not tell."""
    from cases.prony_series import show_candidates, show_trust

    show_candidates(found.series)
    show_trust(found.series)
    modulus, error = found.series.modulus, found.standard_errors["reduced_modulus"]
    late = found.series.standard_errors["long_term"]
    console.out.print(
        f"reduced modulus: {modulus.instantaneous:.6g} Pa (standard error {error:.2g}) at once, "
        f"{modulus.long_term:.6g} Pa ({late:.2g}) in the end"
    )
    console.show_fit(found, out)
