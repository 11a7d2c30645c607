"""`fe2dem simulate --engine lammps`: a scene file on LAMMPS, on one rank in this process or on several that are started for it.

The files are those of any scene: history table, dump, contacts, frames. There are no task records: a run that was stopped goes on, on any
number of ranks, from the checkpoint in its folder.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import contactlaws  # noqa: F401  (all laws: any may stand in the file)
import dem
from cases.batch.work.scenes import scene_of
from cases.casefile.reading import read_scene
from cases.casefile.schema import Scene
from cases.report import history
from contactlaws import fitted
from contactlaws.errors import InputError, Problem, require
from dem import lammps_library, lammps_run, lammps_scope, output
from dem.box import Box
from dem.packing import Packing, random_close_packing


def simulate(scene: Path, law: Path | None, folder: Path, ranks: int) -> str | None:
    """Run a scene file; returns why it stopped early, None if it did not. Raises `InputError`, before computing, for what cannot be."""
    asked, law_file = read_scene(scene, law)
    if law_file is None:
        raise InputError(Problem("shape", asked.shape, "ellipsoids are not for the engine lammps", "leave out --engine"))
    lammps_library.library()
    require(_problems(asked, law_file, ranks))
    (folder / "frames").mkdir(parents=True, exist_ok=True)
    if ranks == 1:
        return run(asked, law_file, folder)
    return _on_ranks(scene, law_file, folder, ranks)


def _problems(asked: Scene, law: Path, ranks: int) -> Iterator[Problem]:
    """What the engine does not do, known before there is a packing."""
    edge = (asked.count * 4.0 / 3.0 * np.pi * asked.radius**3 / asked.packing_fraction) ** (1.0 / 3.0)
    outline = Packing(np.zeros((asked.count, 3)), asked.radius, Box((edge, edge, edge)), asked.packing_fraction, 0.0, 0, 0.0)
    yield from lammps_scope.problems_with(_scene(asked, law, outline))
    if asked.threads > 1:
        yield Problem("threads", asked.threads, "are not for the engine lammps", "ask for --ranks in their place")
    if ranks > 1 and lammps_library.launcher() is None:
        yield Problem("--ranks", ranks, "need the program mpiexec of the MPI that LAMMPS uses", lammps_library.INSTALL)


def _scene(asked: Scene, law: Path, packing: Packing) -> dem.Scene:
    return scene_of(packing.particles(asked.density), packing.box, fitted.load(law), asked.model_dump())


def _on_ranks(scene: Path, law: Path, folder: Path, ranks: int) -> str | None:
    command = [str(lammps_library.launcher()), "-n", str(ranks), sys.executable, "-m", __name__, str(scene), str(law), str(folder)]
    done = subprocess.run(command, env=os.environ | {"OMP_NUM_THREADS": "1"}, check=False)
    return None if done.returncode == 0 else f"the ranks ended with {done.returncode}"


def run(asked: Scene, law: Path, folder: Path) -> str | None:
    """What each rank does; the first tells how it goes, and writes."""
    first = lammps_library.this_rank() == 0
    packing = random_close_packing(asked.count, asked.packing_fraction, asked.radius, seed=asked.seed)
    checkpoint = folder / "checkpoint.npz"
    trajectory = lammps_run.run(_scene(asked, law, packing), _tell if first else None, checkpoint)
    if trajectory is None:
        return None
    history.write(history.columns(trajectory), folder / "history.parquet")
    output.write_dump(trajectory, folder / "scene.dump")
    output.write_network(trajectory, folder / "contacts.csv")
    output.write_vtu(trajectory, folder / "frames")
    lammps_run.forget(checkpoint)
    print("\n".join(f"warning: {line}" for line in trajectory.warnings) or "no warnings")
    print(f"written: {folder}")
    return trajectory.stopped


def _tell(fraction: float, text: str) -> None:
    print(f"{100.0 * fraction:3.0f} %  {text}", flush=True)


def main(arguments: list[str]) -> int:
    """One rank of several."""
    scene, law, folder = (Path(argument) for argument in arguments)
    asked, _ = read_scene(scene, law)
    return 0 if run(asked, law, folder) is None else 3


if __name__ == "__main__":
    code = main(sys.argv[1:])
    lammps_library.finish()
    sys.exit(code)
