"""`fe2dem predict`: curve or law of a material from the atlas, with its error."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field
from rich import box
from rich.table import Table

from cases import console
from cases.casefile.schema import Depth, Length, MaterialTable, missing_yield_stress
from cases.options import checked, in_words_of_options, problems_with_output
from contactlaws.errors import InputError

ENDINGS = (".json", ".csv", ".parquet")


class PredictionOptions(MaterialTable):
    """The options of `fe2dem predict` that are numbers."""

    radius: Length = Field(1.0, description="the radius, such as '5 um'")
    unload_from: tuple[Depth, ...] = Field((), description="overlaps over radius to unload from, such as 0.05 and 0.1")
    max_overlap: Depth | None = Field(None, description="largest overlap over radius, such as 0.1")


def predict(options: Mapping[str, Any], elastic: bool, law: str, compute: bool, out: Path | None) -> None:
    """Predict, write what the ending of `out` asks for, and say how wrong it may be. Raises `InputError` before computing."""
    body, problems = checked(PredictionOptions, options)
    problems += problems_with_output("--out", out, ENDINGS, needed=True)
    if "yield_stress" not in options and not elastic:
        problems.append(missing_yield_stress("--yield-stress", "is needed for a plastic body"))
    if body is None or out is None or problems:
        raise InputError(in_words_of_options(problems))

    import calibration
    from contactlaws import fitted
    from contactlaws.curve_files import write_curve

    asked = {"radius": body.radius, "unload_from": body.unload_from, "max_overlap": body.max_overlap}
    try:
        found = calibration.predict(body.record(elastic), **asked, law=law, compute=compute)  # type: ignore[arg-type]
    except InputError as error:
        raise InputError(in_words_of_options(error.problems)) from error
    if out.suffix == ".json":
        fitted.save(found.law, out)
    else:
        write_curve(found.curve, out)
    show(found, out)


def show(found: Any, path: Path) -> None:
    """Where it is from, and one row per quantity."""
    curve = found.curve
    source = "finite elements, run for this material" if found.atlas is None else f"the atlas {found.atlas}"
    console.out.print(
        f"from {source}: {found.law.name}, overlap to {console.number(float(curve.overlap.max()))} m, {len(curve.unloadings)} unloadings"
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
