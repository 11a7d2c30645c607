"""`fe2dem ellipsoid`: force, contact ellipse and residual overlap of an ellipsoid on a flat, or of two, along loading and unloadings."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from cases import console
from cases.casefile.schema import Depth, Length, MaterialTable, missing_yield_stress, modulus_problems
from cases.options import checked, in_words_of_options, problems_with_output
from contactlaws.errors import InputError, Problem
from contactlaws.files import write_text
from contactlaws.version import code_version

#: rows of the loading, and of each unloading
ROWS = 100
#: overlap over the mean radius to which the law is fitted
DEEPEST = 0.2


class EllipsoidOptions(MaterialTable):
    """The options that are numbers; both bodies are of one material."""

    axes: tuple[Length, Length, Length] = Field(description="three semi-axes, that of the load first, such as '5 um' '6 um' '7 um'")
    other_axes: tuple[Length, Length, Length] | None = Field(None, description="those of a second body; without it, a rigid flat")
    unload_from: tuple[Depth, ...] = Field((0.05,), description="overlaps over the mean radius to unload from, such as 0.05 and 0.1")


def ellipsoid(options: Mapping[str, Any], elastic: bool, out: Path | None) -> None:
    """Write the curve and print where each unloading ends. Raises `InputError` before computing."""
    body, problems = checked(EllipsoidOptions, options)
    problems += problems_with_output("--out", out, (".csv",), needed=True)
    if "yield_stress" not in options and not elastic:
        problems.append(missing_yield_stress("--yield-stress", "is needed for a plastic body"))
    if body is not None and not elastic:
        problems += modulus_problems("", body)
    if body is not None and max(body.unload_from) > DEEPEST:
        problems.append(Problem("unload_from", max(body.unload_from), f"the law is fitted up to {DEEPEST}", "ask for less"))
    if body is None or out is None or problems:
        raise InputError(_in_words(problems))
    from contactlaws import shaped
    from contactlaws.ellipsoid_contact import of_pair, on_flat  # not above: kernels take seconds to load

    material = body.record(elastic)
    try:
        contact = on_flat(material, body.axes) if body.other_axes is None else of_pair(material, body.axes, material, body.other_axes)
    except InputError as error:
        raise InputError(_in_words(list(error.problems))) from None
    tops = sorted(depth * contact.mean_radius for depth in body.unload_from)
    rows = [np.column_stack([np.zeros(ROWS), *_columns(contact.along(tops[-1] * np.linspace(0.0, 1.0, ROWS) ** 2))])]
    table = console.sheet("unloaded from (m)", "force (N)", "semi-axes of the contact (m)", "residual overlap (m)")
    for number, top in enumerate(tops, 1):
        path = contact.along(np.concatenate([[top], top * np.linspace(1.0, 0.0, 20 * ROWS)]))
        open_from = np.flatnonzero(path.force[1:] <= 0.0)
        end = 1 + (int(open_from[0]) if open_from.size else 20 * ROWS - 1)
        kept = np.unique(np.linspace(1, end, ROWS).astype(int))
        rows.append(np.column_stack([np.full(kept.size, number), *(column[kept] for column in _columns(path))]))
        numbers = (path.force[0], f"{path.semi_axes[0, 0]:.4g} x {path.semi_axes[0, 1]:.4g}", path.overlap[end])
        table.add_row(console.number(top), console.number(float(numbers[0])), str(numbers[1]), console.number(float(numbers[2])))
    text = io.StringIO()
    np.savetxt(text, np.vstack(rows), delimiter=",", fmt=("%d", "%.9g", "%.9g", "%.9g", "%.9g"), comments="", header=_header(body, elastic))
    write_text(out, text.getvalue())
    console.out.print(table)
    law, blunt = shaped.shaped_law_of(contact.law), contact.shape[0] / contact.shape[2]
    if law.fitted is not None and shaped.beyond_fit(law, blunt, blunt):
        found, sharpest, bluntest = (f"1 : {shaped.flatness(value):.3g}" for value in (blunt, *law.fitted))
        console.out.print(
            f"its contact is that of a spheroid {found}; the law is fitted from {sharpest} to {bluntest}, and takes the nearest"
        )
    console.out.print(f"written: {out}")


def _columns(path: Any) -> tuple[Any, ...]:
    return path.overlap, path.force, path.semi_axes[:, 0], path.semi_axes[:, 1]


def _header(body: EllipsoidOptions, elastic: bool) -> str:
    """Where the numbers are from, as comments, and the names of the columns."""
    law = "hertz_ellipse" if elastic else "whole_range_ellipsoid"
    lines = [f"# {code_version()}; law {law}; branch 0 is the loading, 1, 2 ... the unloadings", f"# {body.record(elastic)}"]
    lines.append(f"# semi-axes {body.axes} m on {'a rigid flat' if body.other_axes is None else f'{body.other_axes} m'}")
    return "\n".join([*lines, "branch,overlap_m,force_N,long_semi_axis_m,short_semi_axis_m"])


def _in_words(problems: list[Problem]) -> list[Problem]:
    named = {"axes": "--axes", "other_axes": "--other-axes"}
    return [problem._replace(name=named.get(problem.name, problem.name)) for problem in in_words_of_options(problems)]
