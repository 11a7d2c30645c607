"""Many members from one table: wherever a case file has one value, a list of such values may stand, and every combination is a member.

Also a table of the same name for each of several grids (`[[materials.metal]]`), and evenly spaced values
(`{ from = "10 GPa", to = "1000 GPa", count = 9, spacing = "log" }`).
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic import Field, ValidationError

from cases.casefile.units import is_bare
from cases.casefile.validation import Record, problems_in
from contactlaws.errors import InputError, Problem

#: what stands for a key in the name of a member; a law stands for itself
SYMBOLS = {
    "youngs_modulus": "E",
    "poissons_ratio": "nu",
    "yield_stress": "Y",
    "density": "rho",
    "radius": "R",
    "max_overlap": "d",
    "unload_from": "D",
    "tolerance": "tol",
    "law": "",
}
#: keys of tables whose values name other tables
REFERENCES = ("material", "curves", "fit")


class Column(NamedTuple):
    """One key of a table and its values, checked; those of a reference are still names."""

    key: str
    values: tuple[Any, ...]
    labels: tuple[str, ...]


class Block(NamedTuple):
    """One grid: every combination of its columns."""

    model: type[Record]
    columns: tuple[Column, ...]


class Raw(NamedTuple):
    """One grid as it was written, and what its problems are to be called by."""

    place: str  # ends in a dot or a colon
    values: Mapping[str, Any]


class Evenly(Record):
    """Evenly spaced values between two ends, both included."""

    first: float | str = Field(alias="from", description="the first value, such as '10 GPa'")
    last: float | str = Field(alias="to", description="the last value, such as '1000 GPa'")
    count: int = Field(ge=2, le=1_000_000, description="how many values, both ends included")
    spacing: Literal["linear", "log"] = Field("linear", description="'linear', or 'log' for equal ratios")


def block(model: type[Record], raw: Raw) -> tuple[Block | None, list[Problem]]:
    """The columns of one grid, every value of every column checked; None if anything is wrong."""
    lists, problems = dict[str, list[Any]](), list[Problem]()
    for key, value in raw.values.items():
        try:
            lists[key] = _listed(model, key, value, raw.place)
        except InputError as error:
            problems += error.problems
            lists[key] = []
    problems += [problem for key, values in lists.items() for problem in _mixed(f"{raw.place}{key}", values)]
    checked, found = _checked(model, raw, lists)
    problems += found
    if problems:
        return None, problems
    columns = []
    for key, values in lists.items():
        kept = tuple(checked[key])
        problems += _twins(f"{raw.place}{key}", values, kept)
        columns.append(Column(key, kept, _labels(key, values)))
    return (None if problems else Block(model, tuple(columns))), problems


def is_grid(model: type[Record], key: str, value: object) -> bool:
    """Whether a list stands for several values: one of lists where the value itself is a list."""
    if not isinstance(value, list):
        return False
    field = model.model_fields.get(key)
    many = field is not None and any(get_origin(kind) is tuple for kind in (field.annotation, *get_args(field.annotation)))
    return any(isinstance(item, list) for item in value) if many else field is not None


def _listed(model: type[Record], key: str, value: object, place: str) -> list[Any]:
    if isinstance(value, dict) and key in model.model_fields and {"from", "to", "count", "spacing"} & set(value):
        return _evenly(value, f"{place}{key}")
    if not is_grid(model, key, value):
        return [value]
    assert isinstance(value, list)
    if not value:
        raise InputError(Problem(f"{place}{key}", "[]", "an empty list spans nothing", "give at least one value"))
    return value


def _evenly(table: Mapping[str, Any], name: str) -> list[float | str]:
    try:
        spaced = Evenly.model_validate(table)
    except ValidationError as error:
        raise InputError(problem._replace(name=f"{name}.{problem.name}") for problem in problems_in(error, Evenly)) from None
    (first, unit), (last, other) = _parts(spaced.first, name), _parts(spaced.last, name)
    if unit != other:
        raise InputError(Problem(name, f"{spaced.first} to {spaced.last}", "mixes units", "write both ends in the same unit"))
    if spaced.spacing == "log" and min(first, last) <= 0.0:
        raise InputError(Problem(name, min(first, last), "must be positive for equal ratios", "use spacing = 'linear'"))
    shares = [i / (spaced.count - 1) for i in range(spaced.count)]
    values = [first * (last / first) ** x if spaced.spacing == "log" else first + (last - first) * x for x in shares]
    texts = [f"{value:.6g}" for value in values]  # short in names, and the same to the bit on every machine
    return [f"{text} {unit}" if unit else float(text) for text in texts]


def _parts(value: float | str, name: str) -> tuple[float, str]:
    """A number and the unit behind it.

    >>> _parts("10 GPa", "youngs_modulus"), _parts(0.25, "poissons_ratio")
    ((10.0, 'GPa'), (0.25, ''))
    """
    found = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*)", str(value))
    if found is None or not math.isfinite(float(found[1])):
        raise InputError(Problem(name, value, "is not a number with a unit behind it", "write it like '10 GPa', or bare in SI units"))
    return float(found[1]), found[2].strip()


def _checked(model: type[Record], raw: Raw, lists: Mapping[str, list[Any]]) -> tuple[dict[str, list[Any]], list[Problem]]:
    """Every value of every column, read by the model of the table; as many readings as the longest column has values."""
    found: dict[tuple[str, str], Problem] = {}
    checked: dict[str, list[Any]] = {key: [] for key in lists}
    grids = {key for key, value in raw.values.items() if is_grid(model, key, value) or len(lists[key]) > 1}
    full = {key: values for key, values in lists.items() if values}
    for turn in range(max(map(len, full.values()), default=1)):
        row = {key: values[min(turn, len(values) - 1)] for key, values in full.items()}
        try:
            table = model.model_validate(row)
        except ValidationError as error:
            for problem in problems_in(error, model):
                placed = _placed(problem, raw.place, grids, full, turn)
                found[placed.name, placed.bound] = placed
            continue
        for key, values in full.items():
            if turn < len(values):
                checked[key].append(getattr(table, key))
    missing = {f"{raw.place}{key}" for key, values in lists.items() if not values}  # already said to be empty
    return checked, [problem for problem in found.values() if problem.name not in missing]


def _placed(problem: Problem, place: str, grids: set[str], lists: Mapping[str, list[Any]], turn: int) -> Problem:
    key, rest = re.match(r"([^.\[]*)(.*)", problem.name).groups()  # type: ignore[union-attr]
    index = f"[{min(turn, len(lists[key]) - 1)}]" if key in grids and key in lists else ""
    return problem._replace(name=f"{place}{key}{index}{rest}")


def _mixed(name: str, values: Sequence[Any]) -> Iterator[Problem]:
    """Bare numbers are SI: beside others that carry a unit, one is most likely meant in that unit."""
    bare = [value for value in values if not isinstance(value, bool) and (isinstance(value, (int, float)) or is_bare(str(value)))]
    texts = [value for value in values if isinstance(value, str) and re.search(r"\d\s*[A-Za-zµ]", value) and not is_bare(value)]
    if bare and texts:
        remedy = "write all of them with a unit, or all of them bare, in SI units"
        yield Problem(name, f"{texts[0]!r} and {bare[0]!r}", "mixes numbers with and without a unit in one list", remedy)


def _twins(name: str, written: Sequence[Any], values: Sequence[Any]) -> Iterator[Problem]:
    seen: dict[Any, int] = {}
    for index, (text, value) in enumerate(zip(written, values, strict=True)):
        first = seen.setdefault(value, index)
        if first != index:
            shown = text if isinstance(text, (int, float, str)) else str(text)
            yield Problem(f"{name}[{index}]", shown, f"is the same point as [{first}]", "remove one of the two")


def _labels(key: str, written: Sequence[Any]) -> tuple[str, ...]:
    """What tells the values of a column apart in the names of members.

    >>> _labels("youngs_modulus", ["50 GPa", "0.1 TPa"]), _labels("poissons_ratio", [0.0, 0.3]), _labels("law", ["hertz", "thornton"])
    (('E50GPa', 'E0.1TPa'), ('nu0', 'nu0.3'), ('hertz', 'thornton'))
    >>> _labels("unload_from", [[0.1], [0.1, 0.2, 0.3]]), _labels("elastic", [True, False])
    (('D1', 'D2'), ('elastic', 'plastic'))
    """
    if key == "elastic":
        return tuple("elastic" if value is True else "plastic" for value in written)
    symbol = SYMBOLS.get(key, key)
    if any(isinstance(value, list) for value in written):
        return tuple(f"{symbol}{number}" for number in range(1, len(written) + 1))
    for digits in (6, 12, 17):
        labels = [symbol + _plain(value, digits) for value in written]
        if len(set(labels)) == len(labels):
            return tuple(labels)
    return tuple(f"{symbol}{number}" for number in range(1, len(written) + 1))


def _plain(value: object, digits: int) -> str:
    text = f"{value:.{digits}g}" if isinstance(value, (int, float)) else str(value).replace(" ", "")
    return re.sub(r"[^A-Za-z0-9_.-]+", "_", text)


def size(columns: Sequence[Column]) -> int:
    """How many members a grid has."""
    return math.prod(len(column.values) for column in columns)


def combinations(columns: Sequence[Column]) -> Iterator[tuple[dict[str, Any], dict[str, str]]]:
    """Values and labels of every member of a grid, the last column running fastest."""
    for picked in itertools.product(*(range(len(column.values)) for column in columns)):
        pairs = list(zip(columns, picked, strict=True))
        yield {column.key: column.values[i] for column, i in pairs}, {column.key: column.labels[i] for column, i in pairs}
