"""From the tables of a file to those of a case: grids become members with readable names, and references to grids span them.

A curve whose `material` is a grid is one curve for each of its materials; a fit whose `curves` are grids is one fit for each body, on the
curves of that body; an impact or a scene whose `fit` is a grid is one for each fitted law.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cases.casefile.grid import Block, Column, Raw, block, combinations, size
from cases.casefile.materials_file import NAME, read_materials
from cases.casefile.schema import TABLES, CurveTable
from cases.casefile.validation import Record
from contactlaws.errors import Problem

#: which kind of table a key refers to
REFERS = {"material": "materials", "curves": "curves", "fit": "fits"}
#: a file's name holds this, a key, and an ending; file systems take 255 bytes
LONGEST_NAME = 180


class Member(NamedTuple):
    """One table of the case, and what it is called."""

    name: str  # FAMILY-LABEL
    label: str  # what tells it from the others of its family; empty if it is the only one
    table: Record


class Grid(NamedTuple):
    """One combination of columns; `title` takes the place of the labels (a row of a file that has a name)."""

    block: Block
    title: str | None


Grids = Mapping[str, Mapping[str, Sequence[Grid]]]  # kind, name
Families = dict[str, dict[str, list[Member]]]  # kind, name


def grids_in(values: Mapping[str, Any], folder: Path) -> tuple[dict[str, dict[str, list[Grid]]], list[Problem]]:
    """The grids that are right in themselves, by kind and name, and what is wrong with the others. Files are relative to `folder`."""
    found: dict[str, dict[str, list[Grid]]] = {kind: {} for kind in TABLES}
    problems: list[Problem] = []
    for kind, tables in values.items():
        if kind not in TABLES or not isinstance(tables, dict):
            continue
        for name, content in tables.items():
            raws, wrong = _raws(kind, name, content, folder)
            grids: list[Grid] = []
            for raw in raws:
                title = raw.values.get(NAME) if "file" in content else None
                made, more = block(TABLES[kind], raw._replace(values={k: v for k, v in raw.values.items() if title is None or k != NAME}))
                wrong += more
                if made is not None:
                    grids.append(Grid(made, title))
            problems += wrong
            if not wrong:
                found[kind][name] = grids
    return found, problems


def _raws(kind: str, name: str, content: Any, folder: Path) -> tuple[list[Raw], list[Problem]]:
    place = f"{kind}.{name}"
    if isinstance(content, dict):
        if kind == "materials" and isinstance(content.get("file"), str):
            common = {key: value for key, value in content.items() if key != "file"}
            return read_materials(folder / content["file"], list(TABLES[kind].model_fields), common, f"{place}.")
        return [Raw(f"{place}.", content)], []
    if isinstance(content, list) and content and all(isinstance(item, dict) for item in content):
        return [Raw(f"{place}[{index}].", item) for index, item in enumerate(content)], []
    return [], [Problem(place, str(content)[:60], "is no table", f"write [{place}], or [[{place}]] once for each of several grids")]


def count(grids: Grids) -> int:
    """How many tasks the grids span, without spanning them; where several grids are joined, those of the largest."""
    sizes: dict[str, dict[str, int]] = {}
    for kind, families in grids.items():
        sizes[kind] = {}
        for name, each in families.items():
            sizes[kind][name] = sum(_own(grid.block) * _referred(grid.block, sizes) for grid in each)
    return sum(number for kind in sizes if kind != "materials" for number in sizes[kind].values())


def _own(made: Block) -> int:
    return size([column for column in made.columns if column.key not in REFERS])


def _referred(made: Block, sizes: Mapping[str, Mapping[str, int]]) -> int:
    product = 1
    for column in made.columns:
        if column.key in REFERS and column.values != (None,):
            known = sizes[REFERS[column.key]]
            product *= sum(max(known.get(name, 1) for name in ((value,) if isinstance(value, str) else value)) for value in column.values)
    return product


def families_of(grids: Grids) -> tuple[Families, list[Problem]]:
    """All members of all grids. References that point nowhere stay as they are: the checks between tables name them."""
    families: Families = {kind: {} for kind in TABLES}
    problems: list[Problem] = []
    for kind in TABLES:
        for name, each in grids[kind].items():
            families[kind][name] = list(_members(kind, name, each, families, problems))
        problems += _problems_with_names(kind, families[kind])
    return families, problems


def _members(kind: str, name: str, grids: Sequence[Grid], families: Families, problems: list[Problem]) -> Iterator[Member]:
    blocks = [
        [_resolved(column, f"{kind}.{name}", families, problems) if column.key in REFERS else column for column in grid.block.columns]
        for grid in grids
    ]
    varying = _varying(blocks)
    seen: dict[Record, str] = {}
    for grid, columns in zip(grids, blocks, strict=True):
        for values, labels in combinations(columns):
            parts = (labels[key] for key in labels if key in varying)
            label = grid.title if grid.title is not None else "-".join(part for part in parts if part)
            table = grid.block.model.model_construct(**values)
            member = Member(f"{name}-{label}" if label else name, label, table)
            if len(blocks) > 1 and table in seen:
                problems.append(Problem(f"{kind}.{name}", member.name, f"is the same point as {seen[table]}", "remove one of the two"))
            else:
                seen[table] = member.name
                yield member


def _varying(blocks: Sequence[Sequence[Column]]) -> set[str]:
    """The keys that tell members apart."""
    seen: dict[str, set[str]] = {}
    for columns in blocks:
        for column in columns:
            seen.setdefault(column.key, set()).update(column.labels)
    partly = {key for key in seen if any(key not in {column.key for column in columns} for columns in blocks)}
    return partly | {key for key, labels in seen.items() if len(labels) > 1}


def _resolved(column: Column, place: str, families: Families, problems: list[Problem]) -> Column:
    """A column of references, with the members that they mean."""
    kind = REFERS[column.key]
    alternatives: list[tuple[Any, list[Member]]] = []
    for number, value in enumerate(column.values, 1):
        if isinstance(value, tuple):
            prefix = f"{column.key}{number}" if len(column.values) > 1 else ""
            for joined in _joined(value, f"{place}.{column.key}", families, problems):
                label = "-".join(filter(None, (prefix, _joint_label(joined))))
                alternatives.append((tuple(member.name for member in joined), [Member("", label, joined[0].table)]))
        else:
            alternatives += [(member.name, [member]) for member in _meant(kind, value, families)]
    alone = len(column.values) == 1 or isinstance(column.values[0], tuple)
    labels = [(found[0].label if alone else found[0].name) for _, found in alternatives]
    values = [value for value, _ in alternatives]
    problems += [
        Problem(f"{place}.{column.key}", str(twin), "is meant twice", "name each only once")
        for twin, times in Counter(values).items()
        if times > 1
    ]
    return Column(column.key, tuple(values), tuple(labels))


def _meant(kind: str, name: str | None, families: Families) -> list[Member]:
    """The members of a family, or one member by its whole name; a file or an unknown name stands for itself."""
    if name is None:
        return [Member(None, "", Record())]  # type: ignore[arg-type]
    if name in families[kind]:
        return families[kind][name]
    one = [member for family in families[kind].values() for member in family if member.name == name]
    return one or [Member(name, "", Record())]


def _joined(names: Sequence[str], place: str, families: Families, problems: list[Problem]) -> Iterator[tuple[Member, ...]]:
    """One tuple of curves for each body and each combination of what else differs; measured curves go with every body."""
    found = [_meant("curves", name, families) for name in names]
    grids = [members for members in found if isinstance(members[0].table, CurveTable)]
    if len(grids) < 2:
        yield from itertools.product(*found)
        return
    by_body = [_by_body(members) for members in found]
    bodies = list(dict.fromkeys(body for members in grids for body in _by_body(members)))
    for body in bodies:
        groups = [group.get(body, group.get(None, [])) for group in by_body]
        lacking = [name for name, group in zip(names, groups, strict=True) if not group]
        if lacking:
            shown = f"material {body[0]}, radius {body[1]:g} m, aspect {body[2]:g}"
            problems.append(Problem(place, lacking[0], f"has no curve of {shown}", "fit curves of the same bodies together"))
            return
        yield from itertools.product(*groups)


def _by_body(members: Sequence[Member]) -> dict[Any, list[Member]]:
    groups: dict[Any, list[Member]] = {}
    for member in members:
        table = member.table
        groups.setdefault((table.material, table.radius, table.aspect) if isinstance(table, CurveTable) else None, []).append(member)
    return groups


def _joint_label(members: Sequence[Member]) -> str:
    """The labels of curves that are fitted together, without those that another one says already."""
    labels = list(dict.fromkeys(member.label for member in members if member.label))
    return "-".join(label for label in labels if not any(label != other and other.startswith(label) for other in labels))


def _problems_with_names(kind: str, families: Mapping[str, Sequence[Member]]) -> Iterator[Problem]:
    seen: dict[str, str] = {}
    for family, members in families.items():
        for twin, times in Counter(member.name for member in members).items():
            if times > 1:
                yield Problem(f"{kind}.{family}", twin, "would be the name of several members", "write them into tables of their own")
        for member in members:
            if len(member.name) > LONGEST_NAME:
                remedy = "span fewer keys in one table, or give shorter names"
                yield Problem(f"{kind}.{family}", member.name, f"is longer than {LONGEST_NAME} characters", remedy)
            first = seen.setdefault(member.name, family)
            if first != family:
                yield Problem(f"{kind}.{family}", member.name, f"is also a name in [{kind}.{first}]", "rename one of the two tables")
