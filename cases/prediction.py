"""`fe2dem predict`: curve or law of a material from the atlas, with its error."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field
from rich import box
from rich.table import Table

from cases import console
from cases.casefile.schema import Depth, Length, MaterialTable, missing_yield_stress, modulus_problems
from cases.options import checked, in_words_of_options, problems_with_output, read_tolerance
from contactlaws.errors import InputError, Problem

#: which of a prediction's own differences between law and curve belongs to a score of laws; the others are not known there
SAME_AS = {"unloading_shape": "unloading_force"}
ENDINGS = (".json", ".csv", ".parquet")


class PredictionOptions(MaterialTable):
    """The options of `fe2dem predict` that are numbers."""

    radius: Length = Field(1.0, description="the radius, such as '5 um'")
    unload_from: tuple[Depth, ...] = Field((), description="overlaps over radius to unload from, such as 0.05 and 0.1")
    max_overlap: Depth | None = Field(None, description="largest overlap over radius, such as 0.1")


class LawOption(NamedTuple):
    """Which law is wanted: by name, or by what it may be wrong."""

    law: str | None = None
    tolerance: str | None = None
    quantity: str = "force"


def predict(options: Mapping[str, Any], elastic: bool, wanted: LawOption, compute: bool, out: Path | None) -> str | None:
    """Predict, write what the ending of `out` asks for, and say how wrong it may be; returns why finite elements stopped early, if so.

    Raises `InputError` before computing.
    """
    body, problems = checked(PredictionOptions, options)
    problems += problems_with_output("--out", out, ENDINGS, needed=True)
    if "yield_stress" not in options and not elastic:
        problems.append(missing_yield_stress("--yield-stress", "is needed for a plastic body"))
    if body is not None and not elastic:
        problems += modulus_problems("", body)
    share = None
    if wanted.tolerance is not None:
        share, wrong = read_tolerance(wanted.tolerance)
        problems += wrong
        if wanted.law is not None:
            problems.append(Problem("--law", wanted.law, "leaves nothing to choose for --tolerance", "give one of them"))
    if body is None or out is None or problems:
        raise InputError(in_words_of_options(problems))

    import calibration
    from contactlaws import fitted
    from contactlaws.curve_files import write_curve

    asked = {"radius": body.radius, "unload_from": body.unload_from, "max_overlap": body.max_overlap, "compute": compute}
    try:
        with console.bar("finite elements") if compute else nullcontext() as progress:
            make = partial(calibration.predict, body.record(elastic), **asked, progress=progress)  # type: ignore[arg-type]
            found = make(law=wanted.law or "tabulated") if share is None else _within(make, body, elastic, share, wanted.quantity)
    except InputError as error:
        raise InputError(in_words_of_options(error.problems)) from error
    if out.suffix == ".json":
        fitted.save(found.law, out)
    else:
        write_curve(found.curve, out)
    show(found, out)
    return None if found.curve.stopped is None else str(found.curve.stopped)


def _within(make: Callable[..., Any], body: PredictionOptions, elastic: bool, tolerance: float, quantity: str) -> Any:
    """The prediction with the cheapest law that keeps a tolerance, both on the reference curves around and on the predicted curve."""
    from calibration import law_choice
    from calibration.predict import deepest_asked

    known = law_choice.candidates(quantity, body.record(elastic), deepest_asked(body.unload_from, body.max_overlap))
    good = law_choice.good_enough(known, tolerance, quantity)
    table = console.sheet("law, from the cheapest on", "ns per contact", f"{quantity.replace('_', ' ')}: worst on curves around", "here")
    for candidate in known:
        if candidate not in good:
            table.add_row(candidate.law, f"{candidate.nanoseconds:.0f}", _worst(candidate.error), "")
            continue
        found = make(law=candidate.law)
        here = found.law_errors.get(SAME_AS.get(quantity, quantity))
        table.add_row(candidate.law, f"{candidate.nanoseconds:.0f}", _worst(candidate.error), console.percent(here))
        if here is None or here <= tolerance:
            console.out.print(table)
            console.out.print(f"{candidate.law} taken: the cheapest within {console.percent(tolerance)}")
            return found
    bound = "no law that keeps it on the reference curves around keeps it on this one"
    raise InputError(Problem("--tolerance", tolerance, bound, "ask for less, or take --law tabulated"))


def _worst(error: float) -> str:
    return console.percent(error) if error < math.inf else "not fitted everywhere"


def show(found: Any, path: Path) -> None:
    """Where it is from, and one row per quantity."""
    curve = found.curve
    source = "finite elements, run for this material" if found.atlas is None else f"the atlas {found.atlas}"
    console.out.print(
        f"from {source}: {found.law.name}, overlap to {console.number(float(curve.overlap.max()))} m, {len(curve.unloadings)} unloading"
        + ("" if len(curve.unloadings) == 1 else "s")
    )
    table = Table("largest error to be expected", "interpolation", "finite elements", "together", box=box.SIMPLE_HEAD, pad_edge=False)
    for name, total in found.errors.items():
        shown = _absolute if name == "unloading_exponent" else console.percent
        table.add_row(
            name.replace("_", " "), *(shown(part.get(name)) for part in (found.interpolation, found.finite_elements)), shown(total)
        )
    console.out.print(table)
    differences = ", ".join(f"{name.replace('_', ' ')} {console.percent(value)}" for name, value in found.law_errors.items())
    console.out.print(f"the law differs from the curve by at most: {differences}")
    console.out.print(f"written: {path}")


def _absolute(value: float | None) -> str:
    return "–" if value is None else f"±{value:.2g}"
