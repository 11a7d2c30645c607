"""Files for viewers hold what the trajectory holds."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from dem.box import Box
from dem.measure import Network
from dem.output import DUMP_COLUMNS, dump_text, write_dump, write_vtu
from dem.packing import Packing
from dem.record import Frame
from dem.trajectory import Trajectory


@pytest.fixture(scope="module")
def trajectory(hertz: Hertz, shaken_crystal: Packing) -> Trajectory:
    programme = dem.uniaxial_compression(0.02)
    return dem.run(dem.packed_scene(shaken_crystal, 4750.0, dem.Contact(hertz), programme, inertial_number=2e-2, outputs=4, frames=2))


def test_dump_reads_back(trajectory: Trajectory, tmp_path: Path) -> None:
    text = write_dump(trajectory, tmp_path / "a.dump").read_text()
    frames = text.split("ITEM: TIMESTEP\n")[1:]
    assert len(frames) == len(trajectory.frames) == 5
    for block, frame in zip(frames, trajectory.frames, strict=True):
        head, rows = block.split(f"ITEM: ATOMS {DUMP_COLUMNS}\n")
        assert f"ITEM: NUMBER OF ATOMS\n{len(frame.id)}\n" in head
        bounds = head.split("ITEM: BOX BOUNDS pp pp pp\n")[1].split("\n")[:3]
        assert [float(line.split()[1]) for line in bounds] == list(frame.box.lengths)
        table = np.loadtxt(rows.splitlines())
        np.testing.assert_array_equal(table[:, 0], frame.id)
        lengths = np.array(frame.box.lengths)
        assert np.all((table[:, 2:5] >= 0.0) & (table[:, 2:5] < lengths))
        away = (table[:, 2:5] - frame.position) / lengths
        np.testing.assert_allclose(away, np.rint(away), atol=1e-12)  # the same places but for whole boxes
        np.testing.assert_array_equal(table[:, 8], frame.radius)


def test_vtu_reads_back(trajectory: Trajectory, tmp_path: Path) -> None:
    *frames, collection = write_vtu(trajectory, tmp_path)
    assert collection.name == "frames.pvd"
    for path, frame in zip(frames, trajectory.frames, strict=True):
        mesh = meshio.read(path)
        np.testing.assert_array_equal(mesh.point_data["diameter"], 2.0 * frame.radius)
        np.testing.assert_array_equal(mesh.point_data["contacts"], frame.contacts)
        np.testing.assert_allclose(mesh.point_data["pressure"], frame.pressure)
        assert path.name in collection.read_text()


def test_particle_pressures_average_to_the_stress(trajectory: Trajectory) -> None:
    """Each contact's virial is shared by its two spheres, so the solid-weighted mean is the pressure but for its kinetic part."""
    row = trajectory.frames[2].output
    frame = trajectory.frames[2]
    solid = 4.0 / 3.0 * np.pi * frame.radius**3
    volume = np.prod(frame.box.lengths)
    kinetic = 2.0 / 3.0 * trajectory.energies.kinetic[row] / volume
    assert trajectory.pressure[row] - kinetic == pytest.approx(np.sum(frame.pressure * solid) / volume, rel=1e-9)


def test_no_such_folder(trajectory: Trajectory, tmp_path: Path) -> None:
    for write in (lambda place: write_dump(trajectory, place / "a.dump"), lambda place: write_vtu(trajectory, place)):
        with pytest.raises(InputError):
            write(tmp_path / "nowhere")


def test_ellipsoids_are_dumped_with_diameters_and_quaternions() -> None:
    """As LAMMPS names them: columns after those of spheres, one value for each."""
    half = np.array([[3.0, 2.0, 1.0], [1.5, 1.0, 0.5]])
    turns = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])
    nothing = np.zeros(0, np.int64)
    net = Network(nothing, nothing, np.zeros((0, 3)), np.zeros(0), np.zeros(0), np.zeros((0, 3)), nothing)
    places = (np.arange(6.0).reshape(2, 3), np.zeros((2, 3)), np.zeros(2, np.int64), np.zeros(2))
    frame = Frame(0, 0.0, Box((10.0, 10.0, 10.0)), np.array([1, 2]), np.cbrt(half.prod(axis=1)), *places, net, half, turns)
    head, *rows = dump_text(frame, 0).split("ITEM: ATOMS ")[1].splitlines()
    assert head.split()[-7:] == ["shapex", "shapey", "shapez", "quatw", "quati", "quatj", "quatk"]
    for row, axes, turn in zip(rows, half, turns, strict=True):
        assert len(row.split()) == len(head.split())
        assert [float(value) for value in row.split()[-7:]] == [*(2.0 * axes), *turn]
