"""Files for viewers: LAMMPS dump text (OVITO) and .vtu (ParaView)."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from contactlaws.files import write_atomically, write_text
from dem.box import Box, wrapped
from dem.record import Frame
from dem.trajectory import Trajectory

DUMP_COLUMNS = "id type x y z vx vy vz radius contacts pressure"
#: of ellipsoids, as LAMMPS names them: diameters and the quaternion
SHAPE_COLUMNS = "shapex shapey shapez quatw quati quatj quatk"


def dump_text(frame: Frame, step: int) -> str:
    """One frame as LAMMPS dump text, SI units, positions wrapped into the box; of ellipsoids with diameters and quaternions."""
    tilts = frame.box.tilt if any(frame.box.tilt) else None
    bounds = _bounds(frame.box)
    faces = " ".join("pp" if periodic else "ff" for periodic in frame.box.periodic)
    head = f"ITEM: TIMESTEP\n{step}\nITEM: TIME\n{frame.time!r}\nITEM: NUMBER OF ATOMS\n{len(frame.id)}\n"
    lines = [
        f"{number} 1 {x!r} {y!r} {z!r} {vx!r} {vy!r} {vz!r} {radius!r} {contacts} {pressure!r}\n"
        for number, (x, y, z), (vx, vy, vz), radius, contacts, pressure in zip(
            frame.id.tolist(),
            wrapped(frame.position, frame.box).tolist(),
            frame.velocity.tolist(),
            frame.radius.tolist(),
            frame.contacts.tolist(),
            frame.pressure.tolist(),
            strict=True,
        )
    ]
    columns = DUMP_COLUMNS
    if frame.axes is not None and frame.orientation is not None:
        columns = f"{DUMP_COLUMNS} {SHAPE_COLUMNS}"
        shapes = np.concatenate([2.0 * frame.axes, frame.orientation], axis=1).tolist()
        lines = [f"{line[:-1]} {' '.join(map(repr, row))}\n" for line, row in zip(lines, shapes, strict=True)]
    return f"{head}ITEM: BOX BOUNDS {'xy xz yz ' if tilts else ''}{faces}\n{bounds}ITEM: ATOMS {columns}\n{''.join(lines)}"


def write_network(trajectory: Trajectory, path: str | Path) -> Path:
    """The contacts of all frames in one CSV file, SI units; a wall is the second sphere of number 0 and below."""
    lines = ["output,time,id_1,id_2,overlap,normal_force,tangential_force,branch_x,branch_y,branch_z,force_x,force_y,force_z\n"]
    for frame in trajectory.frames:
        net = frame.network
        second = np.where(net.second >= 0, frame.id[np.maximum(net.second, 0)], net.second + 1)
        columns = (net.overlap, net.normal_force, net.tangential_force, *net.branch.T, *net.force.T)
        for one, other, *rest in zip(frame.id[net.first].tolist(), second.tolist(), *(c.tolist() for c in columns), strict=True):
            lines.append(f"{frame.output},{frame.time!r},{one},{other},{','.join(map(repr, rest))}\n")
    return write_text(path, "".join(lines))


def _bounds(box: Box) -> str:
    """Lower and upper bound per axis; of a tilted box those of the cuboid around it, and the tilt, as LAMMPS wants them."""
    if not any(box.tilt):
        return "".join(f"0.0 {length!r}\n" for length in box.lengths)
    (x, y, z), (xy, xz, yz) = box.lengths, box.tilt
    low, high = min(0.0, xy, xz, xy + xz), x + max(0.0, xy, xz, xy + xz)
    return f"{low!r} {high!r} {xy!r}\n{min(0.0, yz)!r} {y + max(0.0, yz)!r} {xz!r}\n0.0 {z!r} {yz!r}\n"


def write_dump(trajectory: Trajectory, path: str | Path) -> Path:
    """All frames in one LAMMPS dump text file, written whole or not at all; raises `InputError` if it cannot be written there."""
    return write_text(path, "".join(dump_text(frame, frame.output) for frame in trajectory.frames))


def write_vtu(trajectory: Trajectory, folder: str | Path) -> tuple[Path, ...]:
    """One .vtu of points per frame, frame_0000.vtu and so on, in `folder`, with a .pvd that gives ParaView their times.

    In ParaView: Glyph, sphere, scale array `diameter`, scale factor 1. Raises `InputError` if it cannot be written there.
    """
    import meshio  # not above: it takes long to load, and few runs write files

    folder, paths = Path(folder), []
    for number, frame in enumerate(trajectory.frames):
        points = wrapped(frame.position, frame.box)
        data = {name: getattr(frame, name) for name in ("id", "velocity", "contacts", "pressure")} | {"diameter": 2.0 * frame.radius}
        if frame.axes is not None and frame.orientation is not None:
            data |= {"half_axes": frame.axes, "quaternion": frame.orientation}
        cells = [("vertex", np.arange(len(points)).reshape(-1, 1))]
        write = partial(meshio.write, mesh=meshio.Mesh(points, cells, point_data=data), file_format="vtu")
        paths.append(write_atomically(folder / f"frame_{number:04d}.vtu", write))
    entries = "".join(f'<DataSet timestep="{f.time!r}" file="{p.name}"/>' for f, p in zip(trajectory.frames, paths, strict=True))
    collection = f'<?xml version="1.0"?><VTKFile type="Collection" version="0.1"><Collection>{entries}</Collection></VTKFile>\n'
    return (*paths, write_text(folder / "frames.pvd", collection))
