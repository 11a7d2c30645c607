"""What the curves do not hold: the rings of contact along an unloading, and stress inside the body; computed for a few materials and kept.

One run on one mesh for each material, as `fem.press` makes it at its default tolerance, of a body of radius 1 and yield stress 1. The rings
go to `rings.parquet`, the fields at the start and the end of each unloading to .vtu files, all in a folder whose name carries a hash of the
solver's sources: with other sources it is computed again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from cases.batch.sources import meaning_hash
from cases.batch.store import hash_of
from cases.report.judgement import Lacking
from cases.report.plots import Field
from contactlaws.files import write_atomically
from contactlaws.material import Material
from fem.assembly import Discretisation, discretise
from fem.fields import field_writer
from fem.mesh import spheroid
from fem.newton import State
from fem.press import core_size, moduli_of, programme, resolution_for
from fem.walk import walk

FloatArray = npt.NDArray[np.float64]

DEPTHS = (0.01, 0.1, 0.3, 0.5)  # overlaps over the radius that are unloaded from
TOLERANCE = 0.01
FORCE_DROP = 0.03  # of an unloading step, over the largest force: the centre opens near the end
COLUMNS = ("depth", "overlap", "force", "inner", "outer")  # a body of radius 1 and yield stress 1


@dataclass(frozen=True)
class Inside:
    """The deepest unloading of a material: rings of contact, force over its start; radii over the body's. Fields of all `DEPTHS`."""

    modulus: float
    poisson: float
    force: FloatArray
    inner: FloatArray  # 0 while the centre rests on the flat
    outer: FloatArray
    folder: Path

    @property
    def opening(self) -> int | None:
        """The first state at which the centre has left the flat while a ring around it still rests; None: there is none."""
        open_at = np.flatnonzero((self.inner > 0.0) & (self.outer > 0.0))
        return int(open_at[0]) if open_at.size else None

    def equivalent_radius(self) -> FloatArray:
        """Radius of the disc with the area of contact, over that at the start."""
        area = self.outer**2 - self.inner**2
        return np.asarray(np.sqrt(area / area[0]))

    def field(self, name: str, depth: float) -> Body:
        """The body at the start (`loading`) or the end (`unloaded`) of an unloading."""
        path = self.folder / f"{name}_D{depth:.4f}.vtu"
        if not path.exists():
            raise Lacking(f"the field of E/σ_y = {self.modulus:g} at δ/R = {depth:g}")
        return Body(Field(path), self.modulus, self.poisson)


@dataclass(frozen=True)
class Body:
    """A stored state, cell by cell; stresses over the yield stress, lengths over the radius."""

    field: Field
    modulus: float
    poisson: float

    @cached_property
    def stress(self) -> FloatArray:
        """Cauchy stress rr, zz, rz, hoop, shape (cells, 4)."""
        return np.asarray(self.field.cell_data["stress"])

    @property
    def pressure(self) -> FloatArray:
        """Hydrostatic pressure, positive in compression."""
        return np.asarray(-self.stress[:, [0, 1, 3]].mean(axis=1))

    @property
    def von_mises(self) -> FloatArray:
        """Of the mean stress of each cell."""
        return np.asarray(self.field.cell_data["von_mises"]).ravel()

    @cached_property
    def volume(self) -> FloatArray:
        """Of each deformed cell (a ring): area of the quadrilateral times the way of its centre around the axis."""
        x, y = np.moveaxis(self.field.polygons, 2, 0)
        area = 0.5 * np.abs((x[:, 0] - x[:, 2]) * (y[:, 1] - y[:, 3]) - (x[:, 1] - x[:, 3]) * (y[:, 0] - y[:, 2]))
        return np.asarray(2.0 * np.pi * x.mean(axis=1) * area)

    def mean(self, values: FloatArray) -> float:
        """Mean over the volume."""
        return float((self.volume * values).sum() / self.volume.sum())

    def scatter(self, values: FloatArray) -> float:
        """Standard deviation over the volume."""
        return float(np.sqrt(self.mean((values - self.mean(values)) ** 2)))

    def energies(self) -> tuple[float, float]:
        """Stored energy of change of volume and of shape, p^2/2K and q^2/6G integrated."""
        bulk, shear = self.modulus / (3.0 * (1.0 - 2.0 * self.poisson)), self.modulus / (2.0 * (1.0 + self.poisson))
        return (
            float((self.volume * self.pressure**2 / (2.0 * bulk)).sum()),
            float((self.volume * self.von_mises**2 / (6.0 * shear)).sum()),
        )

    def elastic_strain_shares(self) -> FloatArray:
        """Mean squares over the volume of the elastic strains rr, zz, rz (as it stands twice in the tensor), hoop; they sum to 1."""
        trace = self.stress[:, [0, 1, 3]].sum(axis=1)
        strain = ((1.0 + self.poisson) * self.stress - self.poisson * trace[:, None] * np.array([1.0, 1.0, 0.0, 1.0])) / self.modulus
        squares = np.array([self.mean(strain[:, i] ** 2) for i in range(4)]) * np.array([1.0, 1.0, 2.0, 1.0])
        return np.asarray(squares / squares.sum())

    def contact_pressure(self) -> tuple[FloatArray, FloatArray]:
        """Distance from the axis and pressure at the nodes that rest."""
        pressure = np.asarray(self.field.point_data["contact_pressure"])
        rest = np.flatnonzero(pressure > 0.0)
        rest = rest[np.argsort(self.field.points[rest, 0])]
        return np.asarray(self.field.points[rest, 0]), pressure[rest]


def ring(body: Discretisation, state: State) -> tuple[float, float]:
    """Inner and outer radius of the contact, each half way between a node that rests and one that does not; (0, 0): no contact."""
    surface = body.section.surface
    radius = body.section.mesh.p[0, surface] + state.displacement[surface, 0]
    resting = np.flatnonzero(state.active)
    if resting.size == 0:
        return 0.0, 0.0
    first, last = int(resting[0]), int(resting[-1])
    inner = 0.0 if first == 0 else 0.5 * float(radius[first - 1] + radius[first])
    return inner, 0.5 * float(radius[last] + radius[min(last + 1, radius.size - 1)])


def compute(modulus: float, poisson: float, place: Path, depths: Sequence[float] = DEPTHS) -> Inside:
    """The inside of one material, from `place` if it is there, else computed and kept."""
    key = hash_of(modulus, poisson, list(depths), TOLERANCE, FORCE_DROP, meaning_hash("fem.press"))
    folder = place / f"E{modulus:g}_nu{poisson:g}-{key}"
    rings = folder / "rings.parquet"
    if not rings.exists():
        folder.mkdir(parents=True, exist_ok=True)
        _write(rings, _run(modulus, poisson, folder, depths))
    return _read(rings, modulus, poisson)


def compute_all(moduli: Sequence[float], poisson: float, place: Path, say: Callable[[str], None]) -> dict[float, Inside]:
    """The inside of several materials, by modulus."""
    found = {}
    for modulus in moduli:
        say(f"inside of E/Y {modulus:g}, nu {poisson:g}")
        found[modulus] = compute(modulus, poisson, place)
    return found


def _run(modulus: float, poisson: float, folder: Path, depths: Sequence[float]) -> FloatArray:
    asked, resolution = programme(depths, None), resolution_for(TOLERANCE)
    material = Material(modulus, poisson, 1.0)
    body = discretise(spheroid(resolution.divisions, core_size(asked.largest, asked.smallest), 1.0, asked.along))
    write = field_writer(body, 1.0, 1.0, folder)
    rows: list[tuple[float, ...]] = []

    def visit(depth: float, states: list[State]) -> None:
        write(depth, states)
        rows.extend((depth, state.overlap, state.force, *ring(body, state)) for state in states)

    with threadpool_limits(1):
        walk(body, moduli_of(material), asked.largest, asked.unload_from, resolution.steps._replace(force_drop=FORCE_DROP), None, visit)
    return np.array(rows)


def _write(path: Path, rows: FloatArray) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table(dict(zip(COLUMNS, rows.T, strict=True)))
    write_atomically(path, lambda file: pq.write_table(table, file))


def _read(path: Path, modulus: float, poisson: float) -> Inside:
    import pyarrow.parquet as pq

    table = pq.ParquetFile(path).read()
    columns = {name: table[name].to_numpy() for name in COLUMNS}
    deepest = columns["depth"] == columns["depth"].max()
    force = columns["force"][deepest]
    return Inside(modulus, poisson, force / force[0], columns["inner"][deepest], columns["outer"][deepest], path.parent)
