"""Scripts for Slurm, checked as text and by bash; `python -m cases.verification.batch_faults slurm` runs them with stand-ins."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cases.command import BAD_INPUT, execute

STUDY = """
[materials.m]
youngs_modulus = ["1 GPa", "2 GPa"]
poissons_ratio = 0.3
[curves.press]
material = "m"
radius = 1
elastic = true
max_overlap = 0.01
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a study, its name with a blank in it."""
    folder = tmp_path / "my studies"
    folder.mkdir()
    (folder / "study.toml").write_text(STUDY)
    monkeypatch.chdir(folder)
    return folder


def test_the_scripts_say_what_was_asked_for(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("dask_jobqueue", reason="the extra `cluster` is not installed")
    options = (
        "--workers",
        "64",
        "--memory",
        "2 GB",
        "--time",
        "1-12:00:00",
        "--queue",
        "long",
        "--account",
        "dem",
        "--setup",
        "module load x",
    )
    assert execute(["slurm", "study.toml", *options]) == 0
    assert "never run on Slurm" in capsys.readouterr().out
    run, workers = ((place / "slurm-study" / name).read_text() for name in ("run.sh", "workers.sbatch"))
    directives = {line.removeprefix("#SBATCH ") for line in workers.splitlines() if line.startswith("#SBATCH")}
    assert {"-p long", "-A dem", "-n 1", "--cpus-per-task=1", "-t 1-12:00:00", "--array=1-64"} <= directives
    assert any(line.startswith("--mem=") for line in directives)
    command = workers.rstrip().splitlines()[-1]
    assert "--nthreads 1 " in command
    assert '"$FE2DEM_SCHEDULER"' in command
    assert "$SLURM_ARRAY_TASK_ID" in command  # two workers of one name are refused
    assert f"fe2dem run '{place / 'study.toml'}' --out '{place / 'results' / 'study'}'" in run
    for script in (run, workers):
        assert script.startswith("#!")
        assert "never run on Slurm" in script
        assert "\nmodule load x\n" in script
        before = script[: script.index("\nmodule load x\n")]
        assert script.count("#SBATCH") == before.count("#SBATCH")  # Slurm reads none behind the first command


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_reads_them(place: Path) -> None:
    pytest.importorskip("dask_jobqueue", reason="the extra `cluster` is not installed")
    assert execute(["slurm", "study.toml"]) == 0
    for name in ("run.sh", "workers.sbatch"):
        done = subprocess.run(["bash", "-n", place / "slurm-study" / name], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


def test_what_cannot_be_meant_is_refused_all_at_once(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ("--workers", "0", "--memory", "lots", "--time", "soon", "--queue", "a b", "--account", "x;rm")
    assert execute(["slurm", "study.toml", *options]) == BAD_INPUT
    said = capsys.readouterr().err
    for name in ("--workers", "--memory", "--time", "--queue", "--account"):
        assert f"{name} = " in said
    assert not (place / "slurm-study").exists()


def test_a_study_that_cannot_be_run_gets_no_scripts(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (place / "study.toml").write_text(STUDY.replace("radius = 1", "radius = -1"))
    assert execute(["slurm", "study.toml"]) == BAD_INPUT
    assert "must be greater than 0" in capsys.readouterr().err


def test_without_the_extra_it_says_what_to_install(
    place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "dask_jobqueue.slurm", None)
    assert execute(["slurm", "study.toml"]) == BAD_INPUT
    assert "pip install 'fe2dem[cluster]'" in capsys.readouterr().err
