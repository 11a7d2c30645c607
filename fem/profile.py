"""Bodies of revolution of any shape: a meridian given as points, meshed by gmsh, whose file meshio reads.

The same philosophy as the structured mesh: element size proportional to the distance from the pole, with a floor at the smallest contact
radius to be resolved. gmsh is used as a separate program would be: it is loaded only here and only when such a body is asked for, and what
comes back is a file.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import Akima1DInterpolator
from skfem import MeshQuad

from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem, require
from contactlaws.material import Material
from fem.assembly import Discretisation, discretise
from fem.mesh import FloatArray, IntArray, Section
from fem.press import Progress, press_body, problems_with_run, programme, resolution_for

if TYPE_CHECKING:
    import meshio

#: Debian's packages with the shared libraries that gmsh's wheel links to
GMSH_PACKAGES = "libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libxfixes3 libfontconfig1 libgomp1"
#: element size over distance from the pole, times divisions: what the structured mesh has
GRADING = math.pi / 4
#: size of the core over the radius at which the undeformed surface lies one overlap below the pole: as the structured mesh has it
CORE_AT_SMALLEST, CORE_AT_LARGEST, LARGEST_CORE = 0.57, 0.085, 0.2
ROUND_OFF = 1e-9  # of lengths over the half height
#: two irregular meshes may agree by chance, so no error estimate is below this share of the tolerance; measured on spheres: 0.5 of it
SMALLEST_ERROR = 0.6
PLACES = 20000  # at which the meridian is tabulated


class Meridian(NamedTuple):
    """A smooth meridian from the pole to the mid-plane, tabulated along its length; lengths over the half height."""

    radius: FloatArray  # increasing or constant
    height: FloatArray  # decreasing or constant, from 1 to 0
    length: FloatArray  # from the pole, increasing

    def radius_at_depth(self, depth: float) -> float:
        """Largest radius at which the surface lies no more than `depth` below the pole."""
        return float(self.radius[np.searchsorted(-self.height, depth - 1.0, side="right") - 1])

    def _number(self, core: float) -> FloatArray:
        """Elements of one division from the pole to each tabulated place."""
        size = np.hypot(core, GRADING * np.hypot(self.radius, 1.0 - self.height))
        return np.concatenate([[0.0], np.cumsum(np.diff(self.length) * 0.5 * (1.0 / size[1:] + 1.0 / size[:-1]))])

    def edges(self, core: float, divisions: int) -> tuple[int, float]:
        """Number of elements along the meridian, and by what to multiply their sizes for it; twice the divisions are twice the elements."""
        wanted = float(self._number(core)[-1])
        each = 2 * max(1, round(0.5 * wanted))
        return divisions * each, wanted / each

    def spread(self, core: float, edges: int) -> tuple[FloatArray, FloatArray]:
        """Radius and height of the ends of `edges` elements whose lengths keep the ratio of the sizes wanted there."""
        number = self._number(core)
        at = np.interp(np.linspace(0.0, number[-1], edges + 1), number, self.length)
        return np.interp(at, self.length, self.radius), np.interp(at, self.length, self.height)


def _shape_problems(points: FloatArray) -> Iterator[Problem]:
    shape = "points (r, z), r the distance from the axis, z from the mid-plane"
    if points.ndim != 2 or points.shape[1] != 2 or points.shape[0] < 3:
        yield Problem("points", f"array of shape {points.shape}", f"must be at least 3 {shape}", "give one pair of lengths per point")
        return
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        yield Problem(f"points[{row}]", points[row].tolist(), "must be finite", "remove or repair the point")
        return
    (r, z), rows = points.T, points.tolist()
    nought = ROUND_OFF * float(np.abs(points).max())
    if abs(r[0]) > nought or z[0] <= nought:
        yield Problem("points[0]", rows[0], "must be the pole: r = 0, z > 0", f"give {shape}, starting on the axis")
    if abs(z[-1]) > nought or r[-1] <= nought:
        yield Problem(f"points[{r.size - 1}]", rows[-1], "must lie on the mid-plane: z = 0, r > 0", f"give {shape}, the pole first")
    for k in range(1, r.size):
        if r[k] < r[k - 1] or z[k] > z[k - 1]:
            bound = "r must not decrease nor z increase from point to point, so that the profile neither turns back nor crosses itself"
            yield Problem(f"points[{k}]", rows[k], bound, "order the points from the pole; waists and dimples cannot be pressed")
        elif r[k] - r[k - 1] <= nought and z[k - 1] - z[k] <= nought:
            yield Problem(f"points[{k}]", rows[k], "the same as the point before", "remove one of them")


def meridian(points: npt.ArrayLike) -> Meridian:
    """The smooth curve through `points` (r, z), any unit, from the pole to the mid-plane; raises `InputError` with all that is wrong.

    Akima's interpolation along the chords, continued by symmetry beyond both ends: horizontal at the pole, vertical at the mid-plane;
    three or more points in line stay in line, and a corner is rounded between it and its neighbours.

    >>> angle = np.linspace(0.0, np.pi / 2, 91)
    >>> sphere = meridian(5e-6 * np.column_stack([np.sin(angle), np.cos(angle)]))
    >>> round(float(sphere.length[-1]), 4), round(sphere.radius_at_depth(0.005), 3)
    (1.5708, 0.1)
    """
    try:
        given = np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(Problem("points", type(points).__name__, "must be numbers", "give pairs (r, z)")) from None
    require(_shape_problems(given))
    given = given / given[0, 1]
    given[0, 0], given[-1, 1] = 0.0, 0.0
    extended = np.concatenate([given[:0:-1] * [-1.0, 1.0], given, given[-2::-1] * [1.0, -1.0]])
    chord = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(extended, axis=0).T))])
    start, end = chord[given.shape[0] - 1], chord[2 * given.shape[0] - 2]
    # finer towards the pole, where the contacts are small
    r, z = Akima1DInterpolator(chord, extended)(start + (end - start) * np.linspace(0.0, 1.0, PLACES) ** 2).T
    turned = np.flatnonzero((np.diff(r) < -ROUND_OFF) | (np.diff(z) > ROUND_OFF))
    if turned.size:
        place = (float(r[turned[0]]), float(z[turned[0]]))
        raise InputError(Problem("points", place, "the smooth curve through the points turns back there", "give more points around it"))
    r, z = np.maximum.accumulate(np.maximum(r, 0.0)), np.minimum.accumulate(np.minimum(z, 1.0))
    r[0], z[0], z[-1] = 0.0, 1.0, 0.0
    return Meridian(r, z, np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(r), np.diff(z)))]))


def load_gmsh() -> Any:
    """The gmsh module; raises `InputError` saying what to install where it does not load."""
    try:
        import gmsh
    except (ImportError, OSError) as error:
        remedy = f"pip install gmsh; Debian: apt-get install {GMSH_PACKAGES}; spheres and spheroids need no gmsh"
        raise InputError(Problem("gmsh", None, f"needed to mesh a profile, but does not load ({error})", remedy)) from None
    return gmsh


def _write_mesh(shape: Meridian, core: float, divisions: int, file: Path) -> None:
    """Let gmsh mesh the section with quadrilaterals alone and write it; groups 1 to 4: axis, mid-plane, surface, body."""
    gmsh = load_gmsh()
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        for name, value in (
            ("General.Terminal", 0),
            ("General.NumThreads", 1),
            ("Mesh.MeshSizeFromPoints", 0),
            ("Mesh.MeshSizeExtendFromBoundary", 0),
            ("Mesh.Algorithm", 8),  # frontal-Delaunay for quadrilaterals
            ("Mesh.RecombinationAlgorithm", 3),  # blossom, then every cell in four: no triangle is left
            ("Mesh.Smoothing", 5),
            ("Mesh.RandomSeed", 1),
            ("Mesh.MshFileVersion", 2.2),
        ):
            gmsh.option.setNumber(name, value)
        model = gmsh.model
        edges, factor = shape.edges(core, divisions)
        # half an element of slack: gmsh takes the next larger even number
        factor *= edges / (edges - 0.5)
        places = [model.geo.addPoint(r, z, 0.0) for r, z in zip(*shape.spread(core, 4 * edges), strict=True)]
        centre = model.geo.addPoint(0.0, 0.0, 0.0)
        surface = model.geo.addSpline(places)
        midplane, axis = model.geo.addLine(places[-1], centre), model.geo.addLine(centre, places[0])
        body = model.geo.addPlaneSurface([model.geo.addCurveLoop([surface, midplane, axis])])
        model.geo.synchronize()
        for tag, (dimension, entity) in enumerate(((1, axis), (1, midplane), (1, surface), (2, body)), start=1):
            model.addPhysicalGroup(dimension, [entity], tag)
        field = model.mesh.field.add("MathEval")
        model.mesh.field.setString(field, "F", f"{factor / divisions:.17g}*sqrt({core:.17g}^2 + {GRADING:.17g}^2*(x^2 + (y - 1)^2))")
        model.mesh.field.setAsBackgroundMesh(field)
        model.mesh.setRecombine(2, body)
        model.mesh.generate(2)
        gmsh.write(str(file))
    finally:
        gmsh.finalize()


def _groups(mesh: meshio.Mesh) -> dict[int, IntArray]:
    """Cells by the number of their physical group."""
    found: dict[int, list[IntArray]] = {}
    for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"], strict=True):
        for tag in np.unique(tags):
            if tag == 4 and block.type != "quad":
                raise RuntimeError(f"gmsh left {np.count_nonzero(tags == tag)} cells of type {block.type} in the mesh")
            found.setdefault(int(tag), []).append(block.data[tags == tag].astype(np.int64))
    return {tag: np.concatenate(blocks) for tag, blocks in found.items()}


def _corner_areas(points: FloatArray, cells: IntArray) -> FloatArray:
    """Twice the signed area of the triangle at each corner of each quadrilateral (4, cells); all positive: convex and counter-clockwise."""
    corner = points[:, cells]
    ahead, behind = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    return np.asarray(ahead[0] * behind[1] - ahead[1] * behind[0])


def profile_section(shape: Meridian, divisions: int, core: float) -> Section:
    """Mesh the body with the meridian `shape`; `divisions` and `core` as in `fem.mesh.spheroid`. Raises `InputError` without gmsh."""
    import meshio  # not above: it takes long to load, and most bodies need none of it

    with tempfile.TemporaryDirectory() as folder:
        _write_mesh(shape, core, divisions, Path(folder) / "section.msh")
        read = meshio.read(Path(folder) / "section.msh", file_format="gmsh")
    groups = _groups(read)
    used, cells = np.unique(groups[4], return_inverse=True)
    cells, points = cells.reshape(groups[4].shape).T, read.points[used, :2].T.copy()
    axis, midplane, surface = (np.searchsorted(used, np.unique(groups[k])) for k in (1, 2, 3))
    # along a profile that never turns back r - z only grows
    surface = surface[np.argsort(points[0, surface] - points[1, surface])]
    points[:, surface] = shape.spread(core, surface.size - 1)
    points[0, axis] = 0.0
    points[1, midplane] = 0.0
    areas = _corner_areas(points, cells)
    cells = np.where(areas.sum(axis=0) < 0.0, cells[::-1], cells)
    smallest = float(_corner_areas(points, cells).min())
    if smallest <= 0.0:
        raise RuntimeError(f"gmsh's mesh has a quadrilateral that is not convex (corner area {smallest:.1e})")
    recipe = f"gmsh profile, {cells.shape[1]} quadrilaterals, {divisions} divisions, core {core:.3g}"
    return Section(MeshQuad(points, np.ascontiguousarray(cells)), axis, midplane, surface, recipe)


def core_for(shape: Meridian, max_overlap: float, smallest: float) -> float:
    """Radius of the fine core for a body of this shape; the structured mesh's choice if it is a sphere. Overlaps over the half height."""
    at_largest, at_smallest = (shape.radius_at_depth(d) for d in (max_overlap, smallest))
    return min(CORE_AT_LARGEST * at_largest, CORE_AT_SMALLEST * at_smallest, LARGEST_CORE)


def press_profile(
    points: npt.ArrayLike,
    material: Material,
    *,
    unload_from: Sequence[float] = (),
    max_overlap: float | None = None,
    tolerance: float = 0.01,
    fields: Path | None = None,
    progress: Progress | None = None,
) -> Curve:
    """Reference curve of a body of revolution whose meridian is given as `points` (n, 2): (r, z) in m from the pole to the mid-plane.

    All else as in `fem.press`, the curve's `radius` being the half height `points[0][1]`. First yield is reported only where the mesh
    resolves it. Raises `InputError` for a profile that cannot be pressed, and where gmsh does not load.
    """
    shape = meridian(points)
    radius, aspect = float(np.asarray(points, dtype=np.float64)[0, 1]), float(shape.radius[-1])
    require(problems_with_run(material, radius, aspect, unload_from, max_overlap, tolerance))
    asked = programme(unload_from, max_overlap)
    core = core_for(shape, asked.largest, asked.smallest)
    load_gmsh()

    def body(divisions: int) -> Discretisation:
        return discretise(profile_section(shape, divisions, core))

    curve = press_body(body, material, radius, aspect, asked, resolution_for(tolerance), lambda: None, fields, progress)
    return replace(curve, errors={name: max(value, SMALLEST_ERROR * tolerance) for name, value in curve.errors.items()})
