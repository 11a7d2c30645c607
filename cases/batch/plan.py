"""From a case to tasks: which results are wanted, what each is made from, and the hash that names it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cases.batch.store import hash_of
from cases.casefile.schema import Case, CurveTable, FitTable, ImpactTable, Scene, SceneTable, is_file
from contactlaws.compiled import source_hash

#: the packages whose sources decide a result of each kind; what it's made from brings its own
SOURCES = {
    "curves": ("contactlaws", "fem"),
    "fits": ("contactlaws", "calibration"),
    "impacts": ("contactlaws", "dem"),
    "packings": ("contactlaws", "dem"),
    "scenes": ("contactlaws", "dem"),
}


@dataclass(frozen=True)
class Task:
    """One result to be computed; `values` are JSON types, `needs` the tasks it is made from, `given` the user's own files."""

    kind: str
    name: str
    values: Mapping[str, Any]
    needs: tuple[str, ...] = ()
    given: tuple[str, ...] = ()
    key: str = field(default="", compare=False)

    @property
    def id(self) -> str:
        """KIND.NAME, unique in a case."""
        return f"{self.kind}.{self.name}"


def plan(case: Case, folder: Path) -> list[Task]:
    """All tasks of a case in an order in which each stands behind what it needs; files are looked up relative to `folder`."""
    tasks = [_curve(name, table, case) for name, table in case.curves.items()]
    tasks += {task.id: task for task in map(_packing, case.scenes.values())}.values()
    tasks += [_fit(name, table, case, folder) for name, table in case.fits.items()]
    tasks += [_impact(name, table, folder) for name, table in case.impacts.items()]
    tasks += [_scene(name, table, folder) for name, table in case.scenes.items()]
    return list(_with_keys(tasks))


def scene_plan(name: str, scene: Scene, law: Path) -> list[Task]:
    """The two tasks of one scene on a law from a file."""
    table = SceneTable(**scene.model_dump(include=set(Scene.model_fields)), fit=str(law))
    return list(_with_keys([_packing(table), _scene(name, table, Path())]))


def _with_keys(tasks: list[Task]) -> Iterator[Task]:
    keys: dict[str, str] = {}
    for task in tasks:
        made_from = [keys[need] for need in task.needs] + [_file_hash(Path(path)) for path in task.given]
        keys[task.id] = hash_of(task.kind, task.values, made_from, source_hash(*SOURCES[task.kind]))
        yield Task(task.kind, task.name, task.values, task.needs, task.given, keys[task.id])


def _file_hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:12]


def _curve(name: str, table: CurveTable, case: Case) -> Task:
    material = case.materials[table.material].record(table.elastic)
    values = table.model_dump(mode="json", exclude={"elastic"}) | {"material": material._replace(density=None)._asdict()}
    return Task("curves", name, values)


def _fit(name: str, table: FitTable, case: Case, folder: Path) -> Task:
    needs = tuple(f"curves.{curve}" for curve in table.curves if not is_file(curve))
    given = tuple(str(folder / curve) for curve in table.curves if is_file(curve))
    material = None if table.material is None else case.materials[table.material].record()._asdict()
    return Task("fits", name, {"law": table.law, "radius": table.radius, "material": material}, needs, given)


def _made_from(fit: str, folder: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The tasks and the files of the user that a law comes from."""
    return ((), (str(folder / fit),)) if is_file(fit) else ((f"fits.{fit}",), ())


def _impact(name: str, table: ImpactTable, folder: Path) -> Task:
    return Task("impacts", name, table.model_dump(mode="json", exclude={"fit"}), *_made_from(table.fit, folder))


def _packing(table: Scene) -> Task:
    values = table.model_dump(mode="json", include={"count", "packing_fraction", "radius", "seed"})
    return Task("packings", f"{table.count}-{table.packing_fraction:g}-{hash_of(values)[:4]}", values)


def _scene(name: str, table: SceneTable, folder: Path) -> Task:
    fits, files = _made_from(table.fit, folder)
    values = table.model_dump(mode="json", include={"radius", "density", "strain", "strain_rate", "release"})
    return Task("scenes", name, values, (*fits, _packing(table).id), files)
