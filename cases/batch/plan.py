"""From a case to tasks: which results are wanted, what each is made from, and the hash that names it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cases.batch.sources import meaning_hash
from cases.batch.store import hash_of
from cases.batch.task import Task
from cases.casefile.schema import Case, CurveTable, FitTable, ImpactTable, Scene, SceneTable, is_file

#: overlap of one body over its radius that a scene can reach, over its strain: particles are pushed around
REACH = 2.0


def plan(case: Case, folder: Path) -> list[Task]:
    """All tasks of a case in an order in which each stands behind what it needs; files are looked up relative to `folder`."""
    tasks = [_curve(name, table, case) for name, table in case.curves.items()]
    tasks += {task.id: task for task in map(_packing, case.scenes.values())}.values()
    tasks += [_fit(name, table, case, folder) for name, table in case.fits.items()]
    tasks += [_cheapest(name, table, folder) for name, table in case.scenes.items() if table.tolerance is not None]
    tasks += [_impact(name, table, folder) for name, table in case.impacts.items()]
    tasks += [_scene(name, table, folder) for name, table in case.scenes.items()]
    return list(_with_keys(tasks))


def scene_plan(name: str, scene: Scene, law: Path | None) -> list[Task]:
    """The two tasks of one scene on a law from a file, or of ellipsoids on that of their material."""
    table = SceneTable(**scene.model_dump(include=set(Scene.model_fields)), fit=None if law is None else str(law))
    return list(_with_keys([_packing(table), _scene(name, table, Path())]))


def uncertainty_plan(case: Case, name: str, draws: int, packings: int, folder: Path) -> list[Task]:
    """All tasks of a scene of a case on laws drawn from its fit's errors, each on packings of seeds from the scene's own on.

    Scenes are called LAW-PACKING, draws and packings by their numbers. More draws or packings leave those that are there as they are.
    """
    table = case.scenes[name]
    fit = _cheapest(name, table, folder) if table.fit is None else _fit(table.fit, case.fits[table.fit], case, folder)
    curves = [_curve(need, case.curves[need], case) for need in (need.removeprefix("curves.") for need in fit.needs)]
    laws = [Task("draws", str(number), {"seed": number}, (fit.id,)) for number in range(1, draws + 1)]
    seeds = [table.seed + number for number in range(packings)]
    packed = [_packing(table.model_copy(update={"seed": seed})) for seed in seeds]
    values = {**_scene(name, table, folder).values, "history_only": True}
    runs = [
        Task("scenes", f"{law.name}-{number}", values, (law.id, packing.id))
        for law in laws
        for number, packing in enumerate(packed, start=1)
    ]
    return list(_with_keys([*curves, fit, *packed, *laws, *runs]))


def _with_keys(tasks: list[Task]) -> Iterator[Task]:
    """A key is the hash of the kind, the checked input, the sources, and of what the result is made from; the name is not in it."""
    made: dict[str, Task] = {}
    hashes = {path: _file_hash(Path(path)) for path in {path for task in tasks for path in task.given}}
    for task in tasks:
        given = [hashes[path] for path in task.given]
        wanted = hash_of(task.kind, task.values, [made[need].input for need in task.needs], given)
        key = hash_of(wanted, [made[need].key for need in task.needs], meaning_hash(f"cases.batch.work.{task.kind}"))
        made[task.id] = replace(task, key=key, input=wanted)
        yield made[task.id]


def _file_hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def _curve(name: str, table: CurveTable, case: Case) -> Task:
    values = table.model_dump(mode="json", exclude={"elastic"})
    values |= {"unload_from": sorted({*table.unload_from})}  # the order in which they are written changes nothing
    return Task("curves", name, values | {"material": _constants(case, table.material, table.elastic)})


def _constants(case: Case, material: str, elastic: bool) -> Mapping[str, Any]:
    return case.materials[material].record(elastic)._replace(density=None)._asdict()


def _fit(name: str, table: FitTable, case: Case, folder: Path) -> Task:
    material = None if table.material is None else case.materials[table.material].record()._asdict()
    return Task("fits", name, {"law": table.law, "radius": table.radius, "material": material}, *_made_from("curves", table.curves, folder))


def _cheapest(name: str, table: SceneTable, folder: Path) -> Task:
    """The fit of the cheapest law that is good enough for a scene, up to the overlaps that it can reach."""
    values = {"tolerance": table.tolerance, "reach": REACH * table.strain, "radius": None, "material": None}
    return Task("fits", _law_for(name), values, *_made_from("curves", table.curves, folder))


def _law_for(scene: str) -> str:
    """The name of the fit that is made for a scene with a tolerance."""
    return f"{scene}-law"


def _made_from(kind: str, names: Sequence[str], folder: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The tasks of a kind, and the files of the user, that something is made from."""
    needs = tuple(f"{kind}.{name}" for name in names if not is_file(name))
    return needs, tuple(str(folder / name) for name in names if is_file(name))


def _impact(name: str, table: ImpactTable, folder: Path) -> Task:
    return Task("impacts", name, table.model_dump(mode="json", exclude={"fit"}), *_made_from("fits", (table.fit,), folder))


def _packing(table: Scene) -> Task:
    values = table.model_dump(mode="json", include={"count", "packing_fraction", "radius", "seed", "shape"}, exclude_none=True)
    return Task("packings", f"{table.count}-{table.packing_fraction:g}-{hash_of(values)[:4]}", values)


def _scene(name: str, table: SceneTable, folder: Path) -> Task:
    law = table.fit if table.tolerance is None else _law_for(name)
    fits, files = _made_from("fits", () if law is None else (law,), folder)
    values = table.model_dump(mode="json", exclude={"fit", "tolerance", "curves", "count", "packing_fraction", "seed"})
    return Task("scenes", name, values, (*fits, _packing(table).id), files)
