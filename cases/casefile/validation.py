"""From raw tables to frozen records, with every error at once and a remedy for each."""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError
from pydantic_core import PydanticCustomError

from cases.casefile import units
from contactlaws.errors import InputError, Problem


class Record(BaseModel):
    """What every table of a case file is: frozen, without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, str_strip_whitespace=True)


M = TypeVar("M", bound=BaseModel)


def in_unit(unit: str) -> BeforeValidator:
    """Reads text with a unit, such as '142 GPa', as a float in `unit`; a bare number is in `unit` already."""

    def read(value: object) -> float:
        try:
            return units.si(value, unit)
        except InputError as error:
            problem = error.problems[0]
            raise PydanticCustomError("unit", "{bound}|{remedy}", {"bound": problem.bound, "remedy": problem.remedy}) from None

    return BeforeValidator(read)


def validated(model: type[M], values: Mapping[str, Any]) -> M:
    """`values` as a record of type `model`; raises `InputError` with every problem found."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise InputError(problems_in(error, model)) from None


def problems_in(error: ValidationError, model: type[BaseModel]) -> tuple[Problem, ...]:
    """All that pydantic found wrong, in the terms of this project."""
    return tuple(_problem(item, model) for item in error.errors())


def suggestion(word: str, known: Iterable[str]) -> str:
    """The nearest known word, else all of them, if they are not too many."""
    known = list(known)
    shown = ", ".join(known[:12]) + (f" and {len(known) - 12} more" if len(known) > 12 else "")
    close = difflib.get_close_matches(word, known, n=1, cutoff=0.6)
    return f"did you mean '{close[0]}'?" if close else f"use one of: {shown or 'none declared'}"


def _problem(item: Any, model: type[BaseModel]) -> Problem:
    """One pydantic error as name, value, bound and remedy."""
    location, kind, context = item["loc"], item["type"], item.get("ctx", {})
    name = re.sub(r"\.(\d+)(?=\.|$)", r"[\1]", ".".join(str(part) for part in location if part != "[key]"))
    field, owner = _find(model, location)
    remedy = f"give {field.description}" if field is not None and field.description else "see cases/quickstart.toml"
    if kind == "extra_forbidden":
        return Problem(name, _short(item["input"]), "is not a known key", suggestion(str(location[-1]), list(owner.model_fields)))
    if kind == "missing":
        return Problem(name, None, "is needed", remedy)
    if kind == "unit":
        return Problem(name or context["name"], item["input"] if name else None, context["bound"], context["remedy"])
    bounds = {
        "greater_than": "must be greater than {gt:g}",
        "greater_than_equal": "must be at least {ge:g}",
        "less_than": "must be less than {lt:g}",
    }
    bounds |= {"less_than_equal": "must be at most {le:g}", "finite_number": "must be finite"}
    bounds |= {"string_pattern_mismatch": "may hold letters, digits, '.', '_' and '-' only"}
    bound = bounds[kind].format(**context) if kind in bounds else item["msg"][0].lower() + item["msg"][1:]
    return Problem(name, _short(item["input"]), bound, remedy)


def _find(model: type[BaseModel], location: tuple[Any, ...]) -> tuple[Any, type[BaseModel]]:
    """The field that an error's location means, and the model that owns it."""
    field, owner = None, model
    for part in location:
        if isinstance(part, str) and part in owner.model_fields:
            field = owner.model_fields[part]
            inner = _table_in(field.annotation)
            owner = inner or owner
    return field, owner


def _table_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in getattr(annotation, "__args__", ()) if (found := _table_in(part))), None)


def _short(value: object) -> object:
    return value if isinstance(value, (int, float, str)) else json.dumps(value, default=str)[:60]
