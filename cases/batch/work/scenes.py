"""Packings compressed and released on a law."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import contactlaws  # noqa: F401  (all laws: any may stand in the file)
import dem
from cases.batch.store import hash_of
from cases.batch.task import Task
from cases.batch.work.place import Made, Outcome, Report, empty_folder, law_file, place, relative
from cases.report import history
from contactlaws import fitted
from contactlaws.ellipsoid_contact import ellipsoid_law
from contactlaws.fitted import FittedLaw
from contactlaws.material import Material
from contactlaws.tangential import damper, mindlin, rolling
from contactlaws.version import code_version
from contactlaws.whole_range_ellipsoid import FARTHEST
from dem import output
from dem.box import Box


def make(task: Task, folder: Path, made: Made, report: Report) -> Outcome:
    """A packing compressed and released on a law: history table, LAMMPS dump, contacts, .vtu frames; with `history_only` just the first."""

    values = task.values
    bodies, box = next(_packed(folder / made[need].files["packing"], values) for need in task.needs if need.startswith("packings."))
    scene = scene_of(bodies, box, None if values["shape"] else fitted.load(law_file(folder, task, made)), values)
    # a run can only be continued by the code that began it, so the code is in the checkpoint's name
    checkpoint = place(folder, task, f"-{hash_of(code_version())}.checkpoint.npz")
    trajectory = dem.run(scene, progress=report, checkpoint=checkpoint)
    places = {"history": history.write(history.columns(trajectory), place(folder, task, ".parquet"))}
    if not values.get("history_only"):
        places |= _states(trajectory, task, folder)
    checkpoint.unlink(missing_ok=True)
    files = {name: relative(path, folder) for name, path in places.items()}
    summary = {"notes": list(trajectory.notes), "warnings": list(trajectory.warnings), "statistics": dict(trajectory.statistics)}
    return files, summary, trajectory.stopped


def _states(trajectory: dem.Trajectory, task: Task, folder: Path) -> dict[str, Path]:
    """Where the spheres are in every frame, and their contacts."""
    frames = empty_folder(folder / "frames" / f"{task.name}-{task.key}")
    output.write_vtu(trajectory, frames)
    contacts = output.write_network(trajectory, place(folder, task, "-contacts.csv"))
    return {"dump": output.write_dump(trajectory, place(folder, task, ".dump")), "contacts": contacts, "frames": frames}


def scene_of(bodies: dem.Particles, box: Box, fit: FittedLaw | None, values: Mapping[str, Any]) -> dem.Scene:
    """A packing with the physics, the programme and the settings that a scene's values ask for; without a fit, of ellipsoids."""
    return dem.Scene(
        bodies,
        box,
        contact_of(fit, values),
        programme_of(values),
        quasi_static=dem.QuasiStatic() if values["routine"] == "quasi-static" else None,
        **{name: values[name] for name in ("affine", "density_scaling", "inertial_number", "time_step_fraction", "threads")},
        carry=tuple(values["carry"]),
    )


def contact_of(fit: FittedLaw | None, values: Mapping[str, Any]) -> dem.Contact:
    """The physics that the scene asks for; without a fit, of ellipsoids."""
    contact = _of_ellipsoids(values) if fit is None else dem.Contact(fit.law, fitted_overlap=fit.max_overlap / fit.law.radius)
    if values["youngs_modulus"] is None:
        return contact
    material = Material(values["youngs_modulus"], values["poissons_ratio"])
    friction, resistance, restitution = values["friction"], values["rolling_friction"], values["restitution"]
    return contact._replace(
        tangential=None if friction is None else mindlin(friction, material),
        rolling=None if resistance is None else rolling(resistance),
        damping=None if restitution is None else damper(restitution, material),
    )


def _of_ellipsoids(values: Mapping[str, Any]) -> dem.Contact:
    """The whole-range law of their material, as far as its curves went; Hertz's if they don't yield."""
    material = Material(values["youngs_modulus"], values["poissons_ratio"], values["yield_stress"])
    return dem.Contact(ellipsoid_law(material), fitted_overlap=None if material.yield_stress is None else FARTHEST)


def programme_of(values: Mapping[str, Any]) -> tuple[dem.Stage, ...]:
    """There, and back if it is released."""
    duration = None if values["strain_rate"] is None else values["strain"] / values["strain_rate"]
    if values["loading"] == "uniaxial":
        return dem.uniaxial_compression(values["strain"], strain_rate=values["strain_rate"], release=values["release"])
    there = (dem.isotropic_compression if values["loading"] == "isotropic" else dem.simple_shear)(values["strain"], duration)
    return (there, dem.Stage((1.0, 1.0, 1.0), duration)) if values["release"] else (there,)


def _packed(path: Path, values: Mapping[str, Any]) -> tuple[dem.Particles, Box]:
    """The bodies of a packing, at rest, and their box."""
    with np.load(path, allow_pickle=False) as file:
        box = Box(tuple(float(value) for value in file["lengths"]))  # type: ignore[arg-type]
        if values["shape"]:
            return dem.ellipsoids(file["position"], file["axes"], values["density"], file["orientation"]), box
        return dem.spheres(file["position"], float(file["radius"]), values["density"]), box
