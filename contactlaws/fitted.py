"""A fitted law on disk: its record, what it was fitted to, how far it is good, and how sure its parameters are."""

from __future__ import annotations

import difflib
import json
import math
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from contactlaws import dispatch
from contactlaws.errors import InputError, Problem, require
from contactlaws.files import read_text, write_text
from contactlaws.json_input import is_number, parsed
from contactlaws.material import Material, problems_with
from contactlaws.path import trace
from contactlaws.version import code_version

FORMAT = "fe2dem fitted law 1"
KEYS = ("format", "law", "parameters", "material", "max_overlap", "curve_hashes", "code_version", "standard_errors")
#: may be left out: where the law comes from if from no fit to curves, how it was chosen, and how wrong it may be
OPTIONAL_KEYS = ("origin",)


@dataclass(frozen=True)
class FittedLaw:
    """A law record and its papers. Raises `InputError` if they cannot be true (a law that pulls, a range beyond the body, ...).

    `standard_errors` names only parameters that were free in the fit, those of a row as "times[1]", "times[2]" ...; None is one that the
    curves say nothing about.
    """

    law: Any  # a record of a registered law
    max_overlap: float  # m; the largest overlap of the curves: the law is good up to there
    material: Material | None = None
    curve_hashes: tuple[str, ...] = ()
    standard_errors: Mapping[str, float | None] = field(default_factory=dict)  # in the unit of the parameter
    code_version: str = field(default_factory=code_version)
    origin: Mapping[str, Any] = field(default_factory=dict)  # JSON types; such as the atlas, its hash, and the law's errors

    def __post_init__(self) -> None:
        require(_problems(self))

    @property
    def name(self) -> str:
        """The law's name, as on the command line."""
        return dispatch.law_of(self.law).name

    @property
    def source(self) -> str:
        """Paper and equations of the law."""
        return dispatch.law_of(self.law).source


def to_json(fitted: FittedLaw) -> dict[str, Any]:
    """The record as JSON types; floats keep every bit."""
    return {
        "format": FORMAT,
        "law": fitted.name,
        "parameters": {name: _plain(value) for name, value in zip(fitted.law._fields, fitted.law, strict=True)},
        "material": None if fitted.material is None else fitted.material._asdict(),
        "max_overlap": fitted.max_overlap,
        "curve_hashes": list(fitted.curve_hashes),
        "code_version": fitted.code_version,
        "standard_errors": dict(fitted.standard_errors),
        **({"origin": dict(fitted.origin)} if fitted.origin else {}),
    }


def save(fitted: FittedLaw, path: str | Path) -> Path:
    """Write `fitted` as JSON; raises `InputError` if the file cannot be written."""
    return write_text(path, json.dumps(to_json(fitted), indent=2, allow_nan=False) + "\n")


def load(path: str | Path) -> FittedLaw:
    """Read what `save` wrote; raises `InputError` for anything else, naming key, value and remedy."""
    return from_text(read_text(path), str(path))


def from_text(text: str, place: str) -> FittedLaw:
    """`load` for a text that was read from `place`."""

    def refuse(value: str) -> float:
        raise InputError(Problem(place, value, "must hold finite numbers only", "repair or refit the law"))

    try:
        content = parsed(text, parse_constant=refuse, object_pairs_hook=lambda pairs: _without_twins(pairs, place))
    except json.JSONDecodeError as error:
        raise InputError(
            Problem(f"{place} line {error.lineno}", error.msg, "is no JSON", "give a file written by fitting a law")
        ) from error
    except InputError:
        raise
    except ValueError as error:  # nested too deeply, or a number of thousands of digits
        raise InputError(Problem(place, str(error), "is no JSON of a law", "give a file written by fitting a law")) from error
    return from_json(content, place)


def from_json(content: object, place: str) -> FittedLaw:
    """The record from JSON types; `place` is named in errors."""
    require(_problems_with_keys(content, KEYS, place, OPTIONAL_KEYS))
    assert isinstance(content, dict)
    if content["format"] != FORMAT:
        raise InputError(
            Problem(f"{place}: format", content["format"], f"must be {FORMAT!r}", "read it with the release that wrote it, or refit")
        )
    known = dispatch.laws()
    if not isinstance(content["law"], str) or content["law"] not in known:
        near = difflib.get_close_matches(str(content["law"]), known, 1)
        remedy = f"did you mean {near[0]!r}?" if near else "register the law before loading it"
        raise InputError(Problem(f"{place}: law", content["law"], f"must be one of {', '.join(known)}", remedy))
    record = known[content["law"]].record
    require(_problems_with_keys(content["parameters"], record._fields, f"{place}: parameters"))  # type: ignore[attr-defined]
    require(_problems_with_values(content, record, place))
    material = None if content["material"] is None else Material(**{k: _exact(v) for k, v in content["material"].items()})
    try:
        return FittedLaw(
            law=record(**{name: _exact(value) for name, value in content["parameters"].items()}),
            max_overlap=float(content["max_overlap"]),
            material=material,
            curve_hashes=tuple(content["curve_hashes"]),
            standard_errors={name: _exact(value) for name, value in content["standard_errors"].items()},
            code_version=content["code_version"],
            origin=content.get("origin", {}),
        )
    except InputError as error:
        raise InputError(problem._replace(name=f"{place}: {problem.name}") for problem in error.problems) from error


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else float(value)


def _exact(value: Any) -> Any:
    """Floats and arrays of floats, as the law was compiled for; None stays."""
    if value is None:
        return None
    if isinstance(value, list):
        array = np.array(value, dtype=np.float64)
        array.flags.writeable = False
        return array
    return float(value)


def _without_twins(pairs: list[tuple[str, Any]], place: str) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    require(Problem(f"{place}: {name}", name, "stands there twice", "remove one") for name in sorted(set(names)) if names.count(name) > 1)
    return dict(pairs)


def _problems_with_keys(content: object, wanted: tuple[str, ...], place: str, optional: tuple[str, ...] = ()) -> Iterator[Problem]:
    if not isinstance(content, dict):
        yield Problem(place, type(content).__name__, f"must be a mapping with {', '.join(wanted)}", "give a file written by fitting a law")
        return
    for name in wanted:
        if name not in content:
            yield Problem(f"{place}: {name}", None, f"the keys are {', '.join(wanted)}", "add it, or refit the law")
    for name in content:
        if name not in (*wanted, *optional):
            near = difflib.get_close_matches(name, wanted, 1)
            yield Problem(f"{place}: {name}", content[name], "is not a known key", f"did you mean {near[0]!r}?" if near else "remove it")


def _is_table(value: object) -> bool:
    if not isinstance(value, list):
        return False
    if any(isinstance(row, list) for row in value):
        return all(isinstance(row, list) and len(row) == len(value[0]) and all(map(is_number, row)) for row in value)
    return all(map(is_number, value))


def _problems_with_values(content: dict[str, Any], record: Any, place: str) -> Iterator[Problem]:
    kinds = typing.get_type_hints(record)
    for name, value in content["parameters"].items():
        if kinds[name] is float and not is_number(value):
            yield Problem(f"{place}: {name}", value, "must be a finite number", "repair or refit the law")
        if kinds[name] is not float and not _is_table(value):
            yield Problem(
                f"{place}: {name}", value, "must be a list of finite numbers, or of such lists of one length", "repair or refit the law"
            )
    if not is_number(content["max_overlap"]):
        yield Problem(f"{place}: max_overlap", content["max_overlap"], "must be a finite number of metres", "repair or refit the law")
    material = content["material"]
    if material is not None:
        yield from _problems_with_keys(material, Material._fields, f"{place}: material")
        if isinstance(material, dict):
            yield from (
                Problem(f"{place}: {name}", value, "must be a number or null", "give it in SI units")
                for name, value in material.items()
                if value is not None and not is_number(value)
            )
    hashes = content["curve_hashes"]
    if not (isinstance(hashes, list) and all(isinstance(value, str) for value in hashes)):
        yield Problem(f"{place}: curve_hashes", hashes, "must be a list of texts", "repair or refit the law")
    if not isinstance(content.get("origin", {}), dict):
        yield Problem(f"{place}: origin", content["origin"], "must be a mapping", "repair or drop it")
    if not isinstance(content["code_version"], str):
        yield Problem(f"{place}: code_version", content["code_version"], "must be a text", "repair or refit the law")
    errors = content["standard_errors"]
    if not (isinstance(errors, dict) and all(value is None or is_number(value) for value in errors.values())):
        yield Problem(f"{place}: standard_errors", errors, "must map parameters to numbers or null", "repair or refit the law")


def _names(name: str, value: Any) -> Iterator[str]:
    """A parameter that is a number is called by its name, the numbers of a row by their place in it as well."""
    yield name
    if np.ndim(value) == 1:
        yield from (f"{name}[{place}]" for place in range(1, np.size(value) + 1))


def _problems(fitted: FittedLaw) -> Iterator[Problem]:
    """What holds for any law: a body of positive size, a push at the largest overlap, errors of parameters that exist."""
    law = fitted.law
    registered = dispatch.law_of(law)
    if not (math.isfinite(law.radius) and law.radius > 0.0):
        yield Problem("radius", law.radius, "must be positive", "give it in m")
        return
    if not (math.isfinite(fitted.max_overlap) and 0.0 < fitted.max_overlap < law.radius):
        yield Problem("max_overlap", fitted.max_overlap, f"must lie in (0, radius = {law.radius!r})", "give it in m")
        return
    if fitted.material is not None:
        yield from problems_with(fitted.material)
    known = {number for name, value in zip(law._fields, law, strict=True) for number in _names(name, value)}
    for name, value in fitted.standard_errors.items():
        if name not in known or (value is not None and not (math.isfinite(value) and value >= 0.0)):
            yield Problem(f"standard_errors[{name}]", value, f"must be a positive number for one of {', '.join(law._fields)}", "drop it")
    damaged = tuple(registered.problems(law))
    yield from damaged
    if damaged:
        return  # compiled code would read beyond the ends of damaged tables
    forces = trace(law, fitted.max_overlap * np.array([0.01, 0.1, 0.5, 1.0])).force
    if not (np.isfinite(forces).all() and (forces >= 0.0).all() and forces[-1] > 0.0):
        yield Problem(
            f"law {fitted.name}", forces.tolist(), "must push, with a finite force, within its range", "check moduli and other parameters"
        )
