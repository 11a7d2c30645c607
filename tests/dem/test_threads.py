"""Threads, and runs that are killed: the same bits again, for friction, rolling, damper, walls and two threads at once, both ways."""

from __future__ import annotations

import dataclasses
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import dem
from dem.scene import QuasiStatic
from dem.trajectory import Trajectory
from tests.dem.scenes import DENSITY, YIELDS, contact, walled_crystal

ROOT = Path(__file__).parents[2]
WAYS = ["dynamic", "quasi-static"]


def everything(way: str, threads: int, outputs: int = 12) -> dem.Scene:
    """Plastic spheres between walls with every role, compressed and released."""
    settings = {"quasi_static": QuasiStatic(strain_step=5e-4)} if way == "quasi-static" else {"inertial_number": 5e-3}
    touch, programme = contact(0.3, 0.02, 0.8, YIELDS), dem.uniaxial_compression(0.02)
    made = dem.packed_scene(walled_crystal(), DENSITY, touch, programme, walls=(False, False, True), outputs=outputs, frames=3, **settings)
    return dataclasses.replace(made, threads=threads)


def assert_same(one: Trajectory, other: Trajectory) -> None:
    """To the last bit."""
    for name in ("time", "stage", "strain", "stress", "fabric", "coordination_number", "rattlers", "contacts_beyond"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for a, b in zip(one.energies, other.energies, strict=True):
        np.testing.assert_array_equal(a, b)
    assert len(one.frames) == len(other.frames)
    for a, b in zip(one.frames, other.frames, strict=True):
        for name in ("position", "velocity", "contacts", "pressure", "radius", "id"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


@pytest.mark.compiled_only(reason="threads are the compiler's")
@pytest.mark.parametrize("way", WAYS)
def test_two_threads_twice_give_the_same_bits(way: str) -> None:
    """Each thread has its share of the pairs and adds up its own forces, which are added in the order of the threads."""
    made = everything(way, 2)
    one = dem.run(made)
    assert one.stopped is None
    assert one.energies.rubbed[-1] > 0.0
    assert one.energies.dissipated[-1] > 0.0
    assert_same(one, dem.run(made))


@pytest.mark.compiled_only(reason="threads are the compiler's")
def test_one_and_two_threads_differ_by_round_off() -> None:
    """Over a few hundred steps: sums of the same numbers in another order, which collisions amplify later."""
    made = dataclasses.replace(everything("dynamic", 1), programme=(dem.Stage((1.0, 1.0, 0.998)),))
    one, two = dem.run(made), dem.run(dataclasses.replace(made, threads=2))
    assert one.stress.max() > 0.0
    np.testing.assert_allclose(two.stress, one.stress, rtol=0.0, atol=1e-8 * one.stress.max())
    np.testing.assert_allclose(two.energies.boundary_work, one.energies.boundary_work, rtol=1e-8, atol=1e-10 * one.energies.stored.max())


SCRIPT = """
import sys
import dem
import dem.simulation
from tests.dem.test_threads import everything
dem.simulation.CHECKPOINT_EVERY = 0.0
for path in sys.argv[3:]:
    dem.run(everything(sys.argv[1], int(sys.argv[2])), lambda fraction, text: print(fraction, text, flush=True), path)
"""


def started(way: str, threads: int, *paths: Path) -> subprocess.Popen[str]:
    """A process that runs the scene once for each checkpoint, and says how far it is."""
    command = [sys.executable, "-c", SCRIPT, way, str(threads), *map(str, paths)]
    return subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(ROOT)}, cwd=ROOT, stdout=subprocess.PIPE, text=True)


@pytest.mark.compiled_only(reason="runs in processes of their own")
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("way", WAYS)
def test_a_run_that_is_killed_goes_on_to_the_same_bits(way: str, threads: int, tmp_path: Path) -> None:
    """A real kill -9, in the middle of the loading; what is found afterwards is a whole file, and leads to the same end.

    All in processes that find the kernels compiled: the one that compiles them may round otherwise. The ends are read back.
    """
    killed, straight, made = tmp_path / "killed.npz", tmp_path / "straight.npz", everything(way, threads)
    dem.run(made)  # so that all is compiled
    with started(way, threads, killed) as process:
        assert process.stdout is not None
        next(line for line in process.stdout if float(line.split()[0]) > 0.3)
        process.send_signal(signal.SIGKILL)
        assert process.wait(60) == -signal.SIGKILL
    with started(way, threads, killed, straight) as process:
        said = process.communicate(timeout=300)[0]
    assert process.returncode == 0
    where = [float(line.split()[0]) for line in said.splitlines() if "going on from" in line]
    assert len(where) == 1
    assert 0.2 < where[0] < 1.0
    assert_same(dem.run(made, None, killed), dem.run(made, None, straight))
    assert sorted(p for p in tmp_path.iterdir() if p.suffix == ".npz") == [killed, straight]


def test_a_scene_knows_its_threads() -> None:
    """The sums are in another order, so it is another result: the checkpoint of one is refused to the other."""
    assert everything("dynamic", 1).content_hash != everything("dynamic", 2).content_hash
