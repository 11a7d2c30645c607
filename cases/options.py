"""What every command does with its options: check them as one record, name them as they were typed, and try where output shall go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel

from cases.batch.store import problems_with_writing
from cases.casefile import units
from cases.casefile.schema import CurveOptions, Impact, InTime, Sample
from cases.casefile.validation import validated
from contactlaws.errors import InputError, Problem

M = TypeVar("M", bound=BaseModel)


def checked(model: type[M], values: Mapping[str, Any]) -> tuple[M | None, list[Problem]]:
    """The options as a record, or None and what is wrong with them."""
    try:
        return validated(model, values), []
    except InputError as error:
        return None, list(error.problems)


def in_words_of_options(problems: Sequence[Problem]) -> list[Problem]:
    """Field names as options: youngs_modulus is --youngs-modulus on the command line."""
    options = {*CurveOptions.model_fields, *InTime.model_fields, *Impact.model_fields, *Sample.model_fields, "law", "quantity"}
    return [
        problem._replace(name="--" + problem.name.removeprefix("--").replace("_", "-"))
        if problem.name.removeprefix("--").split("[")[0] in options
        else problem
        for problem in problems
    ]


def read_tolerance(text: str) -> tuple[float, list[Problem]]:
    """The tolerance of a law: above 0, a bare number or with a percent sign.

    >>> read_tolerance("2 %"), read_tolerance("0.02")
    ((0.02, []), (0.02, []))
    """
    try:
        value = units.si(text, "")
    except InputError as error:
        return 0.0, [problem._replace(name="--tolerance") for problem in error.problems]
    if not 0.0 < value < 1.0:
        return value, [Problem("--tolerance", text, "must lie between 0 and 1", "0.01 is 1 %")]
    return value, []


def problems_with_output(name: str, path: Path | None, endings: tuple[str, ...], needed: bool) -> Iterator[Problem]:
    """Whether a file could be written there, found out before hours are spent on what is to stand in it."""
    if path is None:
        if needed:
            yield Problem(name, None, "is needed", f"give a path that ends in {' or '.join(endings)}")
        return
    if path.suffix not in endings:
        yield Problem(name, str(path), f"must end in {' or '.join(endings)}", "give another name")
    folder = path.resolve().parent
    if not folder.is_dir():
        yield Problem(name, str(path), f"there is no folder {folder}", "create it first")
    elif path.is_dir():
        yield Problem(name, str(path), "is a folder", "give the name of a file")
    else:
        yield from problems_with_writing(name, folder)
