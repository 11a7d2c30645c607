"""What `fe2dem prony` does: read a table, fit a Prony series, show how good it is, write it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field
from rich.markup import escape

from calibration.prony_doubts import doubts
from calibration.prony_facts import facts_of
from calibration.prony_fit import fit_prony
from calibration.prony_record import PronyFit, SeriesFit
from calibration.prony_table import PronyTable, read_table
from cases import console
from cases.casefile.validation import Record, in_unit
from cases.options import checked, problems_with_output
from contactlaws.errors import InputError, Problem
from contactlaws.prony_files import write_series, write_youngs

UNITS = {"instantaneous": "Pa", "long_term": "Pa", "fractions": "–", "times": "s"}


class PronyOptions(Record):
    """The options of `fe2dem prony`."""

    poissons_ratio: Annotated[float, in_unit("")] | None = Field(None, ge=0, lt=0.5, allow_inf_nan=False, description="such as 0.3")
    bulk: Literal["constant", "with-shear"] = Field("with-shear", description="'constant' or 'with-shear'")
    terms: int | None = Field(None, ge=0, description="how many, such as 3")
    noise: Annotated[float, in_unit("")] | None = Field(None, gt=0, lt=1, allow_inf_nan=False, description="such as 0.01, or '1 %'")

    @property
    def constant_bulk(self) -> bool:
        """Whether the bulk modulus stays, and Poisson's ratio rises."""
        return self.bulk == "constant"


def fit(path: Path | None, values: Mapping[str, Any], out: Path | None) -> None:
    """Fit, print and write. Raises `InputError` before computing."""
    options, problems = checked(PronyOptions, values)
    problems = [problem._replace(name="--" + problem.name.replace("_", "-")) for problem in problems]
    problems += problems_with_output("--out", out, (".csv",), needed=True)
    table = None
    if path is None:
        problems.append(Problem("TABLE.csv", None, "is needed", "give a table with the columns time,modulus or frequency,storage,loss"))
    else:
        try:
            table = read_table(path)
        except InputError as error:
            problems += error.problems
    if table is not None and options is not None:
        problems += _unknown_ratio(table, options)
    if table is None or options is None or out is None or problems:
        raise InputError(problems)
    try:
        found = fit_prony(table, options.terms, options.noise)
    except InputError as error:
        raise InputError(problem._replace(name=f"--{problem.name}") for problem in error.problems) from error
    show(found)
    write(found, options, out)


def _unknown_ratio(table: PronyTable, options: PronyOptions) -> list[Problem]:
    """Without Poisson's ratio one modulus says nothing of another."""
    if options.poissons_ratio is not None or not (table.shear or options.constant_bulk):
        return []
    bound = "is needed to know Young's modulus from that of shear" if table.shear else "is needed to know the bulk modulus that stays"
    return [Problem("--poissons-ratio", None, bound, "give the instantaneous one, such as 0.43")]


def write(found: PronyFit, options: PronyOptions, out: Path) -> None:
    """Write the series with the facts of its fit, and say where."""
    comments = facts(found)
    ratio = options.poissons_ratio
    if ratio is None:
        write_youngs(found.modulus, out, comments)
    else:
        material = found.material(ratio, options.constant_bulk)
        fractions, times = found.shear_errors(ratio, options.constant_bulk)
        comments["standard_errors"] = {"shear_fraction": list(fractions), "relaxation_time": list(times)}
        write_series(material, out, comments)
        after = material.long_term
        console.out.print(
            f"Young's modulus {material.youngs_modulus:.6g} Pa, Poisson's ratio {ratio:.4g} at once; "
            f"in the end {after.youngs_modulus:.6g} Pa, {after.poissons_ratio:.4g}"
        )
    console.out.print(f"saved: {out}")


def facts(found: PronyFit) -> dict[str, Any]:
    """What goes into the file's comments: the table, and the fit of its own modulus."""
    table, fit = found.table, facts_of(found)
    of_table = {"name": table.name, "sha256": table.sha256, "kind": table.kind, "modulus": "shear" if table.shear else "uniaxial"}
    return {"table": of_table, **fit, "fit": {**fit["fit"], "noise": found.noise}}


def show(found: PronyFit) -> None:
    """Candidates, the numbers of the table's own modulus with their errors, and what the table does not tell."""
    show_candidates(found)
    console.out.print(_numbers(found))
    show_trust(found)
    console.out.print(console.correlations(found.names, found.correlation))
    for warning in doubts(found):
        console.log.print(f"[yellow]warning[/] {escape(warning)}")


def show_candidates(found: SeriesFit) -> None:
    """The best series of each number of terms, and which was taken."""
    best = min(found.candidates, key=lambda one: one.bic).terms
    candidates = console.sheet("terms", "chi squared", "AICc", "BIC", "")
    for one in found.candidates:
        remark = ["smallest BIC"] * (one.terms == best) + ["taken"] * (one.terms == found.asked)
        candidates.add_row(str(one.terms), f"{one.chi_squared:.6g}", f"{one.aicc:.6g}", f"{one.bic:.6g}", ", ".join(remark))
    candidates.columns[4].justify = "left"
    console.out.print(candidates)


def show_trust(found: SeriesFit) -> None:
    """Noise, misfit and window."""
    low, high = found.window
    console.out.print(f"noise: {found.scatter} ({found.noise_from}); misfit {console.number(found.misfit, 3)} times that")
    verb = "sees" if found.source == "table" else "see"
    console.out.print(f"the {found.source} {verb} relaxation times from {low:.4g} to {high:.4g} s")


def _numbers(found: PronyFit) -> Any:
    table = console.sheet(f"{'shear' if found.table.shear else 'Young’s'} modulus", "value", "standard error", "unit")
    values = dict(zip(found.names, found.values.tolist(), strict=True)) | {"long_term": found.modulus.long_term}
    for name, value in values.items():
        table.add_row(escape(name), console.number(value, 7), console.number(found.standard_errors[name], 2), UNITS[name.split("[")[0]])
    return table
