"""`fe2dem identify`: Young's modulus and yield stress of the particle behind a measured curve, as table, JSON and picture."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field
from rich import box
from rich.markup import escape
from rich.table import Table

from calibration import Identified, read_measured
from calibration import identify as identified_from
from calibration.identify_words import UNITS, WORDS
from cases import console
from cases.batch.store import problems_with_folder
from cases.casefile.schema import Length
from cases.casefile.units import si
from cases.casefile.validation import Record
from cases.options import checked, in_words_of_options
from cases.report import identified, plots
from contactlaws.errors import InputError, Problem
from contactlaws.files import write_text
from contactlaws.version import code_version

FORMAT = "fe2dem identified 1"


class IdentificationOptions(Record):
    """The options of `fe2dem identify` that are single numbers."""

    radius: Length | None = Field(None, description="the particle's radius, such as '5 um'")


def identify(
    path: Path | None,
    options: Mapping[str, Any],
    poissons_ratio: str | None,
    noise: str | None,
    unknown: Mapping[str, bool],
    out: Path | None,
) -> None:
    """Identify, write DIR/identified.json, .csv and .png, and print table and statements. Raises `InputError` before computing."""
    particle, problems = checked(IdentificationOptions, options)
    nu = _ratio(poissons_ratio, problems)
    if path is None:
        problems.append(Problem("MEASURED.csv", None, "is needed", "give a file with the columns overlap,force (m, N)"))
    if out is None:
        problems.append(Problem("--out", None, "is needed", "give a folder for the results"))
    measured = None
    if path is not None and particle is not None:
        try:
            measured = read_measured(path, particle.radius)
        except InputError as error:
            problems += error.problems
    scatter = _noise(noise, None if measured is None else float(measured.force.max()), problems)
    if out is not None:
        problems += problems_with_folder("--out", out)
    if measured is None or nu is None or out is None or problems:
        raise InputError(in_words_of_options(problems))

    try:
        found = identified_from(measured, poissons_ratio=nu, noise=scatter, **unknown)  # type: ignore[arg-type]
    except InputError as error:
        raise InputError(in_words_of_options(error.problems)) from error
    write_text(out / "identified.json", json_text(found))
    write_text(out / "profiles.csv", profiles_csv(found))
    plots.png(identified.picture(found), out / "identified.png")
    show(found, out)


def _ratio(text: str | None, problems: list[Problem]) -> float | tuple[float, float] | None:
    """One number, or two with dots between them."""
    if text is None:
        problems.append(Problem("--poissons-ratio", None, "is needed: a force cannot show it", "give it, or an interval such as 0.2..0.35"))
        return None
    try:
        ends = [si(part, "", "--poissons-ratio") for part in text.split("..")]
    except InputError as error:
        problems += error.problems
        return None
    if len(ends) > 2 or ends != sorted(ends):
        problems.append(Problem("--poissons-ratio", text, "is neither a number nor an interval", "write 0.3, or 0.2..0.35"))
        return None
    return ends[0] if len(ends) == 1 else (ends[0], ends[1])


def _noise(text: str | None, largest: float | None, problems: list[Problem]) -> float | None:
    """A force, or a share of the largest one."""
    if text is None:
        return None
    try:
        if text.strip().endswith("%"):
            share = si(text, "", "--noise")
            return None if largest is None else share * largest
        return si(text, "N", "--noise")
    except InputError as error:
        problems += error.problems
        return None


def json_text(found: Identified) -> str:
    """Estimates, intervals and statements as JSON; lengths, forces and stresses in SI units."""
    content = {
        "format": FORMAT,
        "code_version": code_version(),
        "atlas": found.atlas,
        "measured": found.measured.content_hash,
        "radius": found.measured.radius,
        "rows": int(found.measured.force.size),
        "material": found.material._asdict(),
        "estimates": dict(found.estimates),
        "intervals_95_percent": {name: list(ends) for name, ends in found.intervals.items()},
        "correlation": {"names": list(found.names), "matrix": found.correlation.tolist()},
        "noise": found.noise,
        "misfit": found.misfit,
        "statements": list(found.statements),
    }
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def profiles_csv(found: Identified) -> str:
    """One row per point of a profile: unknown, value (SI), deviance."""
    lines = [f"{name},{x!r},{d!r}" for name, one in found.profiles.items() for x, d in zip(*map(np.ndarray.tolist, one), strict=True)]
    return "\n".join(("unknown,value,deviance", *lines)) + "\n"


def show(found: Identified, folder: Path) -> None:
    """One row per unknown, then one line per statement."""
    table = Table("unknown", "estimate", "95 % interval", "unit", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in found.names:
        low, high = found.intervals[name]
        limits = f"{'no limit' if low is None else console.number(low)} to {'no limit' if high is None else console.number(high)}"
        table.add_row(WORDS[name], console.number(found.estimates[name]), limits, UNITS[name] or "–")
    console.out.print(table)
    console.out.print(f"noise {console.number(found.noise, 3)} N, misfit {console.number(found.misfit, 3)}, atlas {found.atlas}")
    for statement in found.statements:
        console.out.print(f"[yellow]note[/] {escape(statement)}")
    console.out.print(f"written: {folder / 'identified.json'}, profiles.csv, identified.png")
