"""Reading case and scene files: unknown keys are errors, and all errors come at once, before anything is computed."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cases.casefile.crosscheck import cross_problems, density_problems, law_problems
from cases.casefile.schema import TABLES, Case, Outline, Scene, SceneFile
from cases.casefile.span import Families, count, families_of, grids_in
from cases.casefile.validation import problems_in
from contactlaws.errors import InputError, Problem, require

#: a grid that spans more tasks is only begun after a yes
MANY = 10_000


def ask_first(tasks: int) -> bool:
    """What happens to many tasks where nobody can be asked: they are refused."""
    return False


def read_case(path: str | Path, accept: Callable[[int], bool] = ask_first) -> Case:
    """Read and check a case file and span its grids. Raises `InputError` with all its problems, before anything is computed.

    accept: asked with the number of tasks if the grids span more than `MANY`.
    """
    values, folder = read_toml(path), Path(path).resolve().parent
    grids, problems = grids_in(values, folder)
    problems = [*_problems_with_outline(values), *problems]
    tasks = count(grids)
    if tasks > MANY:
        require(problems)  # the many are not spanned to find more mistakes
        if not accept(tasks):
            remedy = "span fewer values, or say --yes if they are meant"
            raise InputError(Problem("grid", f"{tasks:,} tasks", f"more than {MANY:,} are only begun after a yes", remedy))
    families, found = families_of(grids)
    tables: dict[str, Any] = {kind: {member.name: member.table for grid in families[kind].values() for member in grid} for kind in TABLES}
    case = Case.model_construct(title=values.get("title", Outline.model_fields["title"].default), **tables)
    declared = {kind: {*tables[kind], *named} for kind, named in values.items() if isinstance(named, dict) and kind in tables}
    require([*problems, *found, *_once_for_each_grid(cross_problems(case, declared, folder), families)])
    return case


def _problems_with_outline(values: dict[str, Any]) -> tuple[Problem, ...]:
    try:
        Outline.model_validate(values)
    except ValidationError as error:
        return problems_in(error, Outline)
    return ()


def _once_for_each_grid(problems: Iterable[Problem], families: Families) -> Iterator[Problem]:
    """What is wrong with all members of a grid is said once, of the first."""
    family_of = {f"{kind}.{member.name}": f"{kind}.{name}" for kind in families for name, grid in families[kind].items() for member in grid}
    alike: dict[tuple[str, str], list[Problem]] = {}
    for problem in problems:
        owner, _, key = problem.name.rpartition(".")
        alike.setdefault((family_of.get(owner, owner), key), []).append(problem)
    for group in alike.values():
        if len(group) < 4:
            yield from group
        else:
            yield group[0]._replace(bound=f"{group[0].bound} (and {len(group) - 1} more of this grid)")


def read_scene(path: str | Path, law: Path | None) -> tuple[Scene, Path | None]:
    """Read and check a scene file and where its law is; `law` takes the place of the one that the file names. Raises `InputError`.

    A scene of ellipsoids has no file of a law: it is made of the material in the scene file.
    """
    values = read_toml(path)
    scene: SceneFile | None = None
    problems: list[Problem] = []
    try:
        scene = SceneFile.model_validate(values)
        problems += density_problems("packing_fraction", scene)
    except ValidationError as error:
        problems += problems_in(error, SceneFile)
    named = values.get("law")
    file = law or (Path(path).parent / named if isinstance(named, str) else None)
    if "shape" in values:
        if file is not None:
            bound = "is for spheres: the law of ellipsoids is made of their material"
            problems.append(Problem("law", str(file), bound, "leave it out, and give youngs_modulus, poissons_ratio and yield_stress"))
    elif file is None:
        problems.append(Problem("law", None, "is needed", "give --law LAW.json, or law = 'LAW.json' in the scene file"))
    elif not file.is_file():
        problems.append(Problem("law", str(file), "is no file", "make one with `fe2dem fit CURVE --law NAME --out LAW.json`"))
    else:
        problems += law_problems("law", file)
    if scene is None or problems:
        raise InputError(problems)
    return scene, None if file is None else file.resolve()


def read_toml(path: str | Path) -> dict[str, Any]:
    """The tables of a TOML file; raises `InputError` where it is missing or no TOML."""
    try:
        with Path(path).open("rb") as file:
            return tomllib.load(file)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise InputError(Problem("file", str(path), f"cannot be read ({reason})", "give the path of a TOML file")) from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(Problem("file", str(path), f"is not valid TOML ({error})", "repair that line; text values need quotes")) from None
