"""The entry: press a body of revolution by its mid-plane against a rigid frictionless flat, and read the reference curve."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from threadpoolctl import threadpool_limits

from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem, require
from contactlaws.material import Material, problems_with
from contactlaws.version import code_version
from fem.assembly import Discretisation, discretise
from fem.compose import compose, first_row, rows_with
from fem.fields import field_writer
from fem.first_yield import FirstYield, resolved, small_run
from fem.march import Steps
from fem.mesh import spheroid
from fem.newton import Moduli
from fem.walk import Walk, balance, walk

Progress = Callable[[float, str], None]


class Resolution(NamedTuple):
    """Mesh and steps of a run; a second run on half the divisions serves extrapolation and the error estimate."""

    divisions: int  # elements across the core, half of those across the quarter circle; even
    steps: Steps


#: cheapest resolution for a tolerance on the mean force; measured against runs twice as fine in the verification
RESOLUTIONS = (
    (0.01, Resolution(8, Steps(first=0.15, growth=3.0))),
    (0.005, Resolution(12, Steps(first=0.1, growth=2.0, force_drop=0.2, tail=0.5))),
    (0.0025, Resolution(16, Steps(first=0.08, growth=2.0, force_drop=0.2, tail=0.5))),
    (0.001, Resolution(24, Steps(first=0.06, growth=2.0, force_drop=0.2, tail=0.5))),
)
#: beyond this overlap over the half height, a landing takes a quarter of the overlap in a mesh of square cells: there they are made shorter
DEEP, ALONG_IF_DEEP = 0.15, 1.5
#: overlaps below are lost in the round-off of the coordinates
SMALLEST_OVERLAP = 1e-7


def resolution_for(tolerance: float) -> Resolution:
    """The cheapest resolution that keeps `tolerance` (relative, mean force), at least the finest on offer."""
    return next((resolution for promised, resolution in RESOLUTIONS if promised <= tolerance), RESOLUTIONS[-1][1])


class Programme(NamedTuple):
    """What a run is asked for; overlaps over the half height."""

    unload_from: tuple[float, ...]  # ascending
    largest: float

    @property
    def smallest(self) -> float:
        """The smallest overlap that must be resolved."""
        return min((self.largest, *self.unload_from))

    @property
    def along(self) -> float:
        """Elements along the surface for each one across."""
        return ALONG_IF_DEEP if self.largest > DEEP else 1.0


def programme(unload_from: Sequence[float], max_overlap: float | None) -> Programme:
    """Each unloading once, in order, and the largest overlap of all."""
    overlaps = sorted({float(d) for d in unload_from})
    return Programme(tuple(overlaps), max([*overlaps, *(() if max_overlap is None else (float(max_overlap),))]))


def problems_with_run(
    material: Material, radius: float, aspect: float, unload_from: Sequence[float], max_overlap: float | None, tolerance: float
) -> Iterator[Problem]:
    """What is wrong with a run of `fem.press`, one `Problem` each."""
    yield from problems_with(material)
    for name, value, low, high in (("radius", radius, 0.0, math.inf), ("aspect", aspect, 0.0999, 10.001)):
        if not (math.isfinite(value) and low < value < high):
            bound = "must be a positive length" if name == "radius" else "must lie between 0.1 and 10"
            yield Problem(
                name, value, bound, "give metres" if name == "radius" else "aspect is equatorial over axial semi-axis; 1 is a sphere"
            )
    for name, overlaps in (("unload_from", unload_from), ("max_overlap", () if max_overlap is None else (max_overlap,))):
        for value in overlaps:
            if not SMALLEST_OVERLAP <= value < 1.0:
                bound = f"overlap over radius must lie in [{SMALLEST_OVERLAP:g}, 1): the body ends there"
                yield Problem(name, value, bound, "runs from 1e-5 to 0.5 are verified")
    if not unload_from and max_overlap is None:
        yield Problem("unload_from", tuple(unload_from), "nothing to do without an overlap", "give unload_from or max_overlap")
    finest = RESOLUTIONS[-1][0]
    if not tolerance >= finest:
        yield Problem("tolerance", tolerance, f"the finest on offer is {finest}", f"ask for {finest} or more")


def moduli_of(material: Material) -> Moduli:
    """Bulk modulus, shear modulus and yield stress over the material's stress unit."""
    e, nu = material.youngs_modulus / material.stress_unit, material.poissons_ratio
    return e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)), math.inf if material.yield_stress is None else 1.0


def core_size(max_overlap: float, smallest: float) -> float:
    """Radius of the fine core: a contact of the first reported overlap fills it. Overlaps over the half height."""
    return min(0.15 * math.sqrt(max_overlap), 0.8 * math.sqrt(smallest), 0.2)


def press(
    material: Material,
    *,
    radius: float = 1.0,
    aspect: float = 1.0,
    unload_from: Sequence[float] = (),
    max_overlap: float | None = None,
    tolerance: float = 0.01,
    fields: Path | None = None,
    progress: Progress | None = None,
) -> Curve:
    """Reference curve of a sphere (or spheroid) of `material` (SI), `radius` (m) being half its height, `aspect` its width over its height.

    The elastic law is Hencky's in the deviator and K ln J in the Cauchy pressure, the yield limit is on the Cauchy stress; other choices
    change the force by some per cent where elastic strains are large (E/Y below 10), by nothing where they are small.
    unload_from, max_overlap: overlap over radius; the loading goes to the largest of them. tolerance: on the mean force; chooses mesh and
    steps.
    fields: folder for the deformed body with stress and plastic strain (.vtu) at the beginning and end of each unloading.
    Raises `InputError` for what cannot be computed. If the solver gives up on the way, the curve up to there comes back with `stopped` set.

    On `press(Material(1000.0, 0.3), max_overlap=1e-3)` the last force is 1.2 % above Hertz's: the sphere is finite.
    """
    require(problems_with_run(material, radius, aspect, unload_from, max_overlap, tolerance))
    asked = programme(unload_from, max_overlap)
    core = core_size(asked.largest, asked.smallest)

    def body(divisions: int) -> Discretisation:
        return discretise(spheroid(divisions, core, aspect, asked.along))

    early_yield = partial(small_run, material, aspect, moduli_of(material))
    return press_body(body, material, radius, aspect, asked, resolution_for(tolerance), early_yield, fields, progress)


def press_body(
    body: Callable[[int], Discretisation],
    material: Material,
    radius: float,
    aspect: float,
    asked: Programme,
    resolution: Resolution,
    early_yield: Callable[[], FirstYield | None],
    fields: Path | None = None,
    progress: Progress | None = None,
) -> Curve:
    """Run the fine and the coarse mesh of a body (`body(divisions)`) and put their curve together; see `press`.

    early_yield: finds first yield where it comes before the contact is resolved.
    """
    began = time.process_time()
    moduli, divisions = moduli_of(material), resolution.divisions
    coarse_body, fine_body = body(divisions // 2), body(divisions)
    with threadpool_limits(1):
        coarse = walk(coarse_body, moduli, asked.largest, asked.unload_from, resolution.steps, _part(progress, 0.0, 0.15, "coarse mesh"))
        visit = None if fields is None else field_writer(fine_body, material.stress_unit, radius, fields)
        fine = walk(fine_body, moduli, asked.largest, asked.unload_from, resolution.steps, _part(progress, 0.15, 0.99, "fine mesh"), visit)
        _enough(fine, coarse, divisions)
        found = resolved(fine, coarse, first_row(fine, coarse, divisions))
        if found is None and fine.yield_overlap is not None:
            found = early_yield()
    provenance = {
        "code": code_version(),
        "mesh": fine_body.section.recipe,
        "elements": int(fine_body.cells.shape[0]),
        "coarse_mesh": coarse_body.section.recipe,
        "resolution": {"divisions": divisions, **resolution.steps._asdict()},
        "statistics": {"fine": vars(fine.statistics), "coarse": vars(coarse.statistics)},
        "balance": balance(fine),
        "cpu_seconds": time.process_time() - began,
    }
    curve = compose(fine, coarse, material, radius, aspect, asked.largest, divisions, found, provenance)
    if progress:
        progress(1.0, "done")
    return curve


def _part(progress: Progress | None, low: float, high: float, name: str) -> Progress | None:
    """A progress callback for one part of the work."""
    if progress is None:
        return None
    return lambda fraction, text: progress(low + fraction * (high - low), f"{name}: {text}")


def _enough(fine: Walk, coarse: Walk, divisions: int) -> None:
    """A run that stopped before the contact was resolved is worth nothing."""
    for run, nodes in ((fine, divisions), (coarse, divisions // 2)):
        if run.landing_overlap.size < rows_with(run, nodes) + 4:
            reached = float(run.landing_overlap[-1]) if run.landing_overlap.size else 0.0
            bound = f"the solver stops before the contact is resolved: {run.stopped}"
            remedy = "ask for a smaller overlap, or keep Poisson's ratio at 0.499 or below"
            raise InputError(Problem("overlap reached", reached, bound, remedy))
