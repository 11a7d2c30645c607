"""`fe2dem reference --prony SERIES.csv`: one viscoelastic curve through a programme in time, straight from the command line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases import console
from cases.casefile.programme_file import ProgrammeFile, read_programme
from cases.casefile.schema import InTime
from cases.options import checked, in_words_of_options, problems_with_output
from contactlaws.errors import InputError, Problem

if TYPE_CHECKING:
    from fem.programme import Programme

#: what only a body that yields, or needs no time, is asked for
FOREIGN = ("yield_stress", "elastic")


def reference_in_time(options: Mapping[str, Any], prony: Path, programme: Path | None, out: Path | None) -> str | None:
    """Compute and write one curve; returns why it stopped early, if it did. Raises `InputError` before computing.

    options: those of `InTime`, as they were typed; prony: a file of `contactlaws.prony_files`; programme: knots in time, in place of a ramp
    (a hold, a release).
    """
    from contactlaws.prony_files import read_series
    from fem.press_in_time import problems_with_press_in_time

    asked, problems = checked(InTime, {name: value for name, value in options.items() if name in InTime.model_fields})
    problems += [
        Problem(f"--{name}", options[name], "is nothing for a viscoelastic body", "leave it out, or leave --prony out")
        for name in FOREIGN
        if options.get(name)
    ]
    problems += problems_with_output("--out", out, (".csv", ".parquet"), needed=True)
    material, knots = None, None
    try:
        given = (asked.youngs_modulus, asked.poissons_ratio) if asked else (None, None)
        material = read_series(prony, *given)
    except InputError as error:
        problems += error.problems
    from_file = None
    if asked is not None and programme is not None:
        from_file, found = _from_file(asked, programme)
        knots = from_file.knots if from_file else None
        problems += found
    elif asked is not None:
        knots, found = _ramp(asked)
        problems += found
    if asked is not None and material is not None and knots is not None:
        wrong = problems_with_press_in_time(material, knots, asked.radius, asked.aspect, asked.tolerance)
        problems += [from_file.placed(p) if from_file and p.name.startswith("programme") else p for p in wrong]
    if problems or asked is None or material is None or knots is None or out is None:
        raise InputError(in_words_of_options(problems))

    import fem
    from contactlaws.curve_files import write_curve

    with console.bar("reference curve") as progress:
        curve = fem.press_in_time(material, knots, radius=asked.radius, aspect=asked.aspect, tolerance=asked.tolerance, progress=progress)
    write_curve(curve, out)
    console.show_curve(curve, out)
    return curve.stopped


def _ramp(asked: InTime) -> tuple[Programme | None, list[Problem]]:
    """The knots of the ramp, hold and release asked for."""
    problems = list(_problems_with_ramp(asked))
    if problems or asked.ramp is None:
        return None, problems
    from fem.programme import ramp_hold_release

    depth = asked.max_overlap if asked.max_overlap is not None else asked.unload_from[0]
    release = asked.release if asked.release is not None else asked.ramp if asked.unload_from else None
    return ramp_hold_release(depth * asked.radius, asked.ramp, asked.hold, release), []


def _from_file(asked: InTime, file: Path) -> tuple[ProgrammeFile | None, list[Problem]]:
    named = [name for name in ("ramp", "release", "max_overlap") if getattr(asked, name) is not None]
    named += [name for name in ("hold", "unload_from") if getattr(asked, name)]
    problems = [Problem(f"--{name}", getattr(asked, name), "is in the way of --programme", "leave one of them out") for name in named]
    try:
        return read_programme(file), problems
    except InputError as error:
        return None, [*problems, *error.problems]


def _problems_with_ramp(asked: InTime) -> Iterator[Problem]:
    depths = [*asked.unload_from, *(() if asked.max_overlap is None else (asked.max_overlap,))]
    if not depths:
        remedy = "give --max-overlap, --unload-from for a body that is released, or --programme"
        yield Problem("--max-overlap", None, "is needed: how far the body is pressed", remedy)
    elif len(set(depths)) > 1:
        bound = "must be one overlap: what went before is in the body's memory"
        remedy = "give --max-overlap, or --unload-from for one that is released; --programme for anything else"
        yield Problem("--max-overlap", tuple(depths), bound, remedy)
    if asked.ramp is None:
        yield Problem("--ramp", None, "is needed: the force depends on how fast it is pressed", "give a time such as '1 s', or --programme")
