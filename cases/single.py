"""One curve, one fit, one restitution table, straight from the command line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cases import console
from cases.batch.store import problems_with_folder
from cases.casefile.profile_file import read_profile
from cases.casefile.schema import CurveOptions, Impact, Sample, depth_problems, missing_yield_stress, modulus_problems
from cases.casefile.validation import suggestion
from cases.options import checked, in_words_of_options, problems_with_output, read_tolerance
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem
from contactlaws.files import write_text
from contactlaws.version import code_version

if TYPE_CHECKING:
    from contactlaws.fitted import FittedLaw

CURVE_FILES = (".csv", ".parquet")


def reference(options: Mapping[str, Any], out: Path | None, fields: Path | None, profile: Path | None = None) -> str | None:
    """Compute and write one curve; returns why it stopped early, if it did. Raises `InputError` before computing.

    `profile`: a file with the meridian of a body of revolution, in place of radius and aspect.
    """
    body, problems = checked(CurveOptions, options)
    problems += problems_with_output("--out", out, CURVE_FILES, needed=True)
    if body is not None:
        problems += [*depth_problems("--", body.unload_from, body.max_overlap), *modulus_problems("", body)]
    elif not options["unload_from"] and "max_overlap" not in options:
        problems += depth_problems("--", (), None)
    if "yield_stress" not in options and not options.get("elastic"):
        problems.append(missing_yield_stress("--yield-stress", "is needed for a plastic body"))
    if fields is not None:
        problems += problems_with_fields(fields, options["unload_from"])
    points: list[tuple[float, float]] = []
    if profile is not None:
        points, found = read_profile(profile)
        problems += [*found, *_rivals_of_a_profile(options)]
    if body is None or out is None or problems:
        raise InputError(in_words_of_options(problems))

    import fem
    from contactlaws.curve_files import write_curve

    press = partial(fem.press, radius=body.radius, aspect=body.aspect) if profile is None else partial(fem.press_profile, points)
    with console.bar("reference curve") as progress:
        curve = press(
            material=body.record(body.elastic),
            unload_from=body.unload_from,
            max_overlap=body.max_overlap,
            tolerance=body.tolerance,
            fields=fields,
            progress=progress,
        )
    write_curve(curve, out)
    console.show_curve(curve, out)
    return curve.stopped


def problems_with_fields(folder: Path, unload_from: Sequence[Any]) -> Iterator[Problem]:
    """Fields are those of the states at both ends of each unloading: without one there are none."""
    if unload_from:
        yield from problems_with_folder("--fields", folder)
    else:
        yield Problem("--fields", str(folder), "fields are written where the body is unloaded, and it never is", "give --unload-from too")


def _rivals_of_a_profile(options: Mapping[str, Any]) -> Iterator[Problem]:
    for name in ("radius", "aspect"):
        if options.get(name, "1") != "1":
            yield Problem(f"--{name}", options[name], "a profile says itself how large and how wide the body is", "leave it out")


def fit(curves: Sequence[Path], law: str | None, out: Path | None, sample: Mapping[str, Any], terms: str | None = None) -> None:
    """Fit a law to curves from files and say how well it went. `sample`: radius and constants that measured files leave out.

    `terms`: how many relaxation times, of a viscoelastic law.
    """
    from calibration.recipes import IN_TIME
    from contactlaws.dispatch import laws

    if law in IN_TIME:
        from cases.fit_in_time import fit_in_time

        return fit_in_time(curves, law, out, {**sample, **({} if terms is None else {"terms": terms})})
    found, problems = _curves(curves, sample)
    if terms is not None:
        problems.append(Problem("--terms", terms, "is for laws with relaxation times", f"leave it out, or use {' or '.join(IN_TIME)}"))
    if law is None:
        problems.append(Problem("--law", None, "is needed", f"use one of: {', '.join(laws())}"))
    elif law not in laws():
        problems.append(Problem("--law", law, "is not a known law", suggestion(law, laws())))
    problems += problems_with_output("--out", out, (".json",), needed=False)
    if law is None or problems:
        raise InputError(in_words_of_options(problems))

    import calibration
    from contactlaws import fitted

    result = calibration.fit(found, law=law)
    if out is not None:
        fitted.save(result.fitted, out)
    console.show_fit(result, out)


def fit_within(curves: Sequence[Path], law: str | None, tolerance: str, quantity: str, out: Path | None, sample: Mapping[str, Any]) -> None:
    """Fit the cheapest law that differs from the curves by no more than `tolerance`, and say which were tried and how good they are."""
    found, problems = _curves(curves, sample)
    if law is not None:
        problems.append(Problem("--law", law, "leaves nothing to choose for --tolerance", "give one of them"))
    share, wrong = read_tolerance(tolerance)
    problems += [*wrong, *problems_with_output("--out", out, (".json",), needed=False)]
    if problems:
        raise InputError(in_words_of_options(problems))

    from calibration import law_choice
    from contactlaws import fitted

    with console.bar("laws, from the cheapest on") as progress:
        choice = law_choice.fit_within(found, share, quantity, progress=progress)
    if out is not None:
        fitted.save(choice.fit.fitted, out)
    console.show_trials(choice.trials, quantity, share)
    console.show_fit(choice.fit, out)


def _curves(paths: Sequence[Path], sample: Mapping[str, Any]) -> tuple[list[Curve], list[Problem]]:
    """The curves of some files, as far as they can be read, and what is wrong."""
    from contactlaws.curve_files import read_curve

    known, problems = checked(Sample, sample)
    if not paths:
        problems.append(Problem("CURVE", None, "is needed", "give one or several curve files, .csv or .parquet"))
    material = known.material() if known is not None else None
    found = []
    for path in paths:
        try:
            found.append(read_curve(path, radius=known.radius if known is not None else None, material=material))
        except InputError as error:
            problems += error.problems
    return found, problems


def impact(law: Path | None, options: Mapping[str, Any], out: Path | None) -> None:
    """Restitution of two equal spheres on a fitted law, as a table. Raises `InputError` before computing."""
    from contactlaws import fitted

    spheres, problems = checked(Impact, options)
    problems += problems_with_output("--out", out, (".csv",), needed=False)
    if law is None:
        problems.append(Problem("LAW.json", None, "is needed", "make one with `fe2dem fit CURVE --law NAME --out LAW.json`"))
    else:
        try:
            record = fitted.load(law)
        except InputError as error:
            problems += error.problems
    if spheres is None or law is None or problems:
        raise InputError(in_words_of_options(problems))

    from cases.batch.work.impacts import range_warnings
    from dem.impact import restitution

    try:
        table = restitution(record.law, spheres.radius, spheres.density, spheres.speed)
    except InputError as error:
        raise InputError(in_words_of_options(error.problems)) from error
    if out is not None:
        write_text(out, _restitution_csv(table, record, spheres))
    console.show_impact(table, record.name, range_warnings(record, table.speed, table.largest_overlap, spheres.radius))


def _restitution_csv(table: Any, law: FittedLaw, spheres: Impact) -> str:
    """One row per speed, SI units, below comment lines that say what it was made from."""
    facts = {"law": law.name, "law_curves": " ".join(law.curve_hashes), "law_code": law.code_version}
    facts |= {"radius": repr(spheres.radius), "density": repr(spheres.density), "code": code_version()}
    rows = zip(*(column.tolist() for column in table), strict=True)
    lines = (*(f"# {key}: {value}" for key, value in facts.items()), ",".join(table._fields), *(",".join(map(repr, row)) for row in rows))
    return "\n".join(lines) + "\n"
