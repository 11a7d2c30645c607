"""The entry for viscoelastic bodies: take one through a programme in time, and read the reference curve."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from threadpoolctl import threadpool_limits

from contactlaws.curve import Curve, branches_in_time
from contactlaws.errors import InputError, Problem, require
from contactlaws.foundation import History, Springs, follow, springs_of, springs_through
from contactlaws.prony import PronyViscoelastic, Relaxation, problems_with_series
from contactlaws.version import code_version
from fem import readout
from fem.assembly import Discretisation, discretise
from fem.compose import SMALLEST_ERROR, Scales, first_row, rows_with
from fem.march import extrapolated
from fem.mesh import FloatArray, IntArray, spheroid
from fem.newton import ByOverlap, Equilibrium, Moduli, NoEquilibrium, State
from fem.press import ALONG_IF_DEEP, DEEP, SMALLEST_OVERLAP, Progress, core_size, moduli_of, problems_with_run, resolution_for
from fem.programme import Programme, problems_with_programme, rows
from fem.walk import Walk, walk
from fem.walk_in_time import HALVINGS, TimeWalk, walk_in_time

#: steps a segment for each tolerance
STEPS = ((0.01, 20), (0.005, 28), (0.0025, 40), (0.001, 64))
#: springs of the smooth contact, and how many steps it takes for each of the body's
SPRINGS, FINER = 400, 8
#: powers of the root of the overlap by which the elastic force exceeds Hertz's, and the area R d
FORCE_POWERS, AREA_POWERS = (1, 2, 3, 4, 6), (1, 2, 3, 4, 6)
#: a programme in force is first estimated by Hertz's law, which is too soft; beyond this overlap over the radius nothing is promised
DEEPEST = 0.6


class ElasticContact(NamedTuple):
    """The body as it is at once, without a past: smooth force and contact radius, from both meshes; lengths over the half height."""

    force_factors: FloatArray  # of powers of the root of the overlap: force over Hertz's, less 1
    area_factors: FloatArray  # area over pi R d, less 1
    hertz: float  # Hertz's force at overlap 1
    curvature: float  # radius at the pole
    rest: PchipInterpolator  # what the readout's force is above this, less 1, over the logarithm of the overlap; it begins at `first`
    first: float
    error: float  # of the readout's force

    def force(self, overlap: FloatArray) -> FloatArray:
        """Force at overlaps from 0 on."""
        root = np.sqrt(np.maximum(overlap, 0.0))
        rest = self.rest(np.log(np.maximum(overlap, self.first))) * np.minimum(1.0, root / np.sqrt(self.first))
        return np.asarray(self.hertz * root**3 * (1.0 + powers(root, FORCE_POWERS) @ self.force_factors) * (1.0 + rest))

    def contact_radius(self, overlap: FloatArray) -> FloatArray:
        """Contact radius at overlaps from 0 on."""
        root = np.sqrt(np.maximum(overlap, 0.0))
        return root * np.sqrt(self.curvature * np.maximum(0.0, 1.0 + powers(root, AREA_POWERS) @ self.area_factors))


def powers(root: FloatArray, exponents: tuple[int, ...]) -> FloatArray:
    """One column for each exponent."""
    return np.stack([root**p for p in exponents], axis=-1)


def press_in_time(
    material: PronyViscoelastic,
    programme: Programme,
    *,
    radius: float = 1.0,
    aspect: float = 1.0,
    tolerance: float = 0.01,
    progress: Progress | None = None,
) -> Curve:
    """Reference curve of a viscoelastic sphere (or spheroid; `radius` half its height in m) taken through `programme`, in SI units.

    The nominal stress is the hereditary integral of that of the elastic body (`fem.relaxing`; the elastic law as in `fem.press`). Landing
    nodes make the force of any mesh ripple. What a row of relaxing springs on the elastic curve of the same mesh does in the same steps
    (`contactlaws.foundation`) ripples alike, and does nearly the same: the curve is that of springs on the smooth elastic curve, in fine
    steps, and what the body on the mesh does differently from the springs on the mesh. This difference is in the provenance; `raw_force`
    is the mesh's. The contact radius is that of the springs.

    Rows after the last contact are left out, unless the flat is kept touching. tolerance: on the force over its largest value. Raises
    `InputError` for what cannot be computed; if the solver gives up on the way, the curve up to there comes back with `stopped` set.
    """
    require(problems_with_press_in_time(material, programme, radius, aspect, tolerance))
    began = time.process_time()
    largest = largest_overlap(material, programme, radius, aspect)
    divisions = resolution_for(tolerance).divisions
    core = core_size(largest, largest)
    plan = [
        row._replace(target=row.target / unit, start=None if row.start is None else row.start / unit)
        for row in rows(programme, min(material.relaxation_times, default=1.0), steps_for(tolerance))
        for unit in (material.youngs_modulus * radius * radius if row.by_force else radius,)
    ]
    elastic: list[Walk] = []
    found: list[TimeWalk] = []
    bodies = []
    moduli = moduli_of(material.instantaneous)
    with threadpool_limits(1):
        for number, count in enumerate((divisions // 2, divisions)):
            body = discretise(spheroid(count, core, aspect, ALONG_IF_DEEP if largest > DEEP else 1.0))
            elastic.append(walk(body, moduli, largest, (), resolution_for(tolerance).steps))
            found.append(walk_in_time(body, moduli, material, plan, _part(progress, number)))
            bodies.append(body)
    found = both_up_to_their_end(found, elastic)
    contact = elastic_contact(elastic[1], elastic[0], material, aspect, divisions)
    return _composed(material, contact, elastic, found, bodies, radius, aspect, largest, began)


def steps_for(tolerance: float) -> int:
    """Steps a segment."""
    return next((steps for promised, steps in STEPS if promised <= tolerance), STEPS[-1][1])


def problems_with_press_in_time(
    material: PronyViscoelastic, programme: Programme, radius: float, aspect: float, tolerance: float
) -> Iterator[Problem]:
    """What is wrong with a run of `press_in_time`, one `Problem` each."""
    # both look at the instantaneous constants; what is wrong is said once
    of_body = [*problems_with_series(material), *problems_with_run(material.instantaneous, radius, aspect, (), 0.01, tolerance)]
    yield from dict.fromkeys(of_body)
    of_programme = list(problems_with_programme(programme, radius if radius > 0.0 else math.inf))
    yield from of_programme
    if of_body or of_programme:
        return
    overlap = largest_overlap(material, programme, radius, aspect)
    if not SMALLEST_OVERLAP <= overlap <= DEEPEST:
        remedy = "press less: the body ends there" if overlap > DEEPEST else "press more: so small a contact is not resolved"
        bound = f"must lie between {SMALLEST_OVERLAP:g} and {DEEPEST:g}, about"
        yield Problem("programme: largest overlap over radius", float(f"{overlap:.3g}"), bound, remedy)


def largest_overlap(material: PronyViscoelastic, programme: Programme, radius: float, aspect: float) -> float:
    """Over the half height: what the programme prescribes, or what its largest force leads to in the end by Hertz's law, if that is more.

    A finite body is stiffer, so it gets less far.
    """
    overlap = max(knot.overlap or 0.0 for knot in programme)
    force = max(knot.force or 0.0 for knot in programme)
    reduced = material.reduced.long_term
    by_force = (0.75 * force / (reduced * aspect * math.sqrt(radius))) ** (2.0 / 3.0)
    return 1.02 * max(overlap, by_force) / radius if by_force > overlap else overlap / radius


def _part(progress: Progress | None, number: int) -> Progress | None:
    if progress is None:
        return None
    low, span, name = ((0.0, 0.2, "coarse mesh"), (0.2, 0.8, "fine mesh"))[number]
    return lambda fraction, text: progress(low + span * fraction, f"{name}: {text}")


def both_up_to_their_end(found: list[TimeWalk], elastic: list[Walk]) -> list[TimeWalk]:
    """The runs on both meshes up to where the first of them stopped, or was pressed beyond what is known of the elastic contact; the reason
    goes with them. Raises `InputError` where there is no contact until then."""
    first = min(found, key=lambda run: float(run.time[-1]))
    end, reason = float(first.time[-1]), first.stopped or found[1].stopped or found[0].stopped
    for run in elastic:
        known = run.landing_overlap.max(initial=0.0)
        beyond = found[1].time[found[1].overlap > known]
        if run.stopped and beyond.size and beyond[0] <= end:
            end, reason = float(np.nextafter(beyond[0], -np.inf)), f"of the elastic body: {run.stopped}"
    found = [run.up_to(end, reason) for run in found]
    if min(np.count_nonzero(run.force > 0.0) for run in found) < 2:
        bound = f"the solver stops before the contact is resolved: {reason}"
        raise InputError(Problem("programme: time reached", end, bound, "press less, or keep Poisson's ratio at 0.499 or below"))
    return found


def elastic_contact(fine: Walk, coarse: Walk, material: PronyViscoelastic, aspect: float, divisions: int) -> ElasticContact:
    """Smooth elastic contact from the landings of two meshes (see `fem.readout`), with Hertz's limit at overlap 0."""
    first, last = first_row(fine, coarse, divisions), min(run.landing_overlap[-1] for run in (fine, coarse))
    overlap = np.geomspace(first, last, 60)
    read = [readout.reader(run, rows_with(run, n // 2 + 1))(overlap) for run, n in ((fine, divisions), (coarse, divisions // 2))]
    smooth, root = readout.extrapolated(*read), np.sqrt(overlap)
    at_once = material.instantaneous
    curvature = aspect * aspect
    hertz = 4.0 / 3.0 * at_once.reduced_modulus / at_once.stress_unit * aspect
    force, area = smooth.force / (hertz * root**3), smooth.contact_radius**2 / (curvature * overlap)
    force_factors = np.linalg.lstsq(powers(root, FORCE_POWERS) / force[:, None], (force - 1.0) / force, rcond=None)[0]
    area_factors = np.linalg.lstsq(powers(root, AREA_POWERS), area - 1.0, rcond=None)[0]
    rest = PchipInterpolator(np.log(overlap), force / (1.0 + powers(root, FORCE_POWERS) @ force_factors) - 1.0)
    error = max(SMALLEST_ERROR / divisions**2, 0.5 * float(np.abs(smooth.force / read[0].force - 1.0).mean()))
    return ElasticContact(np.asarray(force_factors), np.asarray(area_factors), hertz, curvature, rest, float(overlap[0]), error)


def springs_on_mesh(body: Discretisation, material: PronyViscoelastic, run: Walk, found: TimeWalk) -> Springs:
    """Springs that touch where nodes land, and where a step of the growing contact ended; their elastic force is that of the mesh."""
    grown = np.flatnonzero(found.overlap > np.concatenate([[0.0], np.maximum.accumulate(found.overlap)[:-1]]))
    if material.bulk_fractions is None:  # the body takes on the elastic shapes
        force = found.elastic[grown]
    else:
        force = elastic_forces(body, moduli_of(material.instantaneous), found.overlap[grown])
    inside = run.path_overlap < found.overlap.max()
    overlap = np.concatenate([[0.0], found.overlap[grown], run.path_overlap[inside]])
    force = np.concatenate([[0.0], force, run.path_force[inside]])
    order = np.argsort(overlap)
    overlap, force = overlap[order], force[order]
    apart = np.concatenate([[True], np.diff(overlap) > 1e-3 * overlap[1:]])
    return springs_through(overlap[apart], force[apart])


def elastic_forces(body: Discretisation, moduli: Moduli, overlaps: FloatArray) -> FloatArray:
    """Force of the elastic body at rising overlaps; raises `NoEquilibrium`."""
    solver = Equilibrium(body, moduli)
    states, force = [solver.start()], np.empty(overlaps.size)
    for row, overlap in enumerate(overlaps.tolist()):
        states = pressed_on(solver, states, overlap, HALVINGS)
        force[row] = states[-1].force
    return force


def pressed_on(solver: Equilibrium, states: list[State], overlap: float, halvings: int) -> list[State]:
    """The last state and that at `overlap`, to which the body goes on from the last of `states`; in halves where that fails."""
    before, state = states[-2:] if len(states) > 1 else (None, states[-1])
    guess = None
    if before is not None:
        guess = extrapolated(solver, before, state, (overlap - state.overlap) / (state.overlap - before.overlap))
    try:
        return [state, solver.step(state, ByOverlap(overlap), state.force, guess)]
    except NoEquilibrium:
        if halvings == 0:
            raise
    half = pressed_on(solver, states, 0.5 * (state.overlap + overlap), halvings - 1)
    return pressed_on(solver, half, overlap, halvings - 1)


def finer(values: FloatArray) -> FloatArray:
    """Rows with `FINER` even steps in place of each."""
    share = np.arange(1, FINER + 1) / FINER
    return np.concatenate([values[:1], (values[:-1, None] + share * np.diff(values)[:, None]).ravel()])


def smooth_history(springs: Springs, modulus: Relaxation, found: TimeWalk) -> History:
    """The springs in finer steps; rows as in `finer`."""
    control = np.where(found.by_force, found.control, found.overlap)
    # where the kind of control changes, the step starts from what the other kind had come to: that is not known here, so it is one jump
    jump = np.flatnonzero(np.diff(found.by_force.astype(int)) != 0) + 1
    fine = finer(control)
    for row in jump:
        fine[(row - 1) * FINER + 1 : row * FINER + 1] = control[row]
    return follow(springs, modulus, finer(found.time), fine, np.concatenate([found.by_force[:1], np.repeat(found.by_force[1:], FINER)]))


def _composed(
    material: PronyViscoelastic,
    contact: ElasticContact,
    elastic: list[Walk],
    found: list[TimeWalk],
    bodies: list[Discretisation],
    radius: float,
    aspect: float,
    largest: float,
    began: float,
) -> Curve:
    """The curve from the runs on both meshes, coarse and fine, to the last contact."""
    fine = found[1]
    modulus = material.reduced._replace(instantaneous=1.0)
    most = max(largest, float(fine.overlap.max()))
    dense = smooth_history(springs_of(contact.force, 1.2 * most, SPRINGS), modulus, fine)
    top = float(dense.force.max())
    differences = []
    for body, run, own in zip(bodies, elastic, found, strict=True):
        meshed = follow(
            springs_on_mesh(body, material, run, own), modulus, own.time, np.where(own.by_force, own.control, own.overlap), own.by_force
        )
        differences.append((own.force - meshed.force, own.overlap - meshed.overlap))
    force = np.where(fine.by_force, fine.control, np.maximum(0.0, dense.force[::FINER] + differences[1][0]))
    force[~fine.by_force & (dense.force[::FINER] <= 0.0)] = 0.0
    overlap = np.where(fine.by_force, dense.overlap[::FINER] + differences[1][1], fine.overlap)
    columns = {
        "time": fine.time,
        "overlap": overlap,
        "force": force,
        "raw_force": fine.force,
        "contact_radius": contact.contact_radius(dense.edge[::FINER]) * (force > 0.0),
    }
    columns = _to_last_contact(_with_separations(columns, dense, finer(fine.time)), fine)
    scale = Scales(radius, material.instantaneous.stress_unit)
    for name, unit in (("overlap", scale.length), ("force", scale.force), ("raw_force", scale.force), ("contact_radius", scale.length)):
        columns[name] = columns[name] * unit
    order, branch = _with_turns(columns["overlap"])
    apart = _between_meshes(found, differences, top)
    return Curve(
        time=columns["time"][order],
        overlap=columns["overlap"][order],
        force=columns["force"][order],
        raw_force=columns["raw_force"][order],
        contact_radius=columns["contact_radius"][order],
        branch=branch,
        radius=radius,
        aspect=aspect,
        material=material.instantaneous,
        series=material,
        in_time=True,
        errors={"force": contact.error + apart, "contact_radius": 1.0 / bodies[1].section.surface.size},
        stopped=fine.stopped,
        provenance={
            "code": code_version(),
            "mesh": bodies[1].section.recipe,
            "elements": int(bodies[1].cells.shape[0]),
            "coarse_mesh": bodies[0].section.recipe,
            "statistics": {"fine": vars(fine.statistics), "coarse": vars(found[0].statistics)},
            "beyond_springs": {
                "force": float(np.abs(differences[1][0][~fine.by_force]).max(initial=0.0) / top),
                "overlap": float(np.abs(differences[1][1]).max() / most),
                "between_meshes": apart,
            },
            "cpu_seconds": time.process_time() - began,
        },
    )


def _between_meshes(found: list[TimeWalk], differences: list[tuple[FloatArray, FloatArray]], top: float) -> float:
    """By how much the two meshes disagree in what goes beyond the springs: root mean square over the largest force, halved."""
    coarse = np.interp(found[1].time, found[0].time, differences[0][0])
    apart = (differences[1][0] - coarse)[~found[1].by_force]
    return 0.5 * float(np.sqrt(np.mean(apart**2))) / top if apart.size else 0.0


def _with_separations(columns: dict[str, FloatArray], dense: History, times: FloatArray) -> dict[str, FloatArray]:
    """Rows put in at the instants at which the force ends, or begins again, as the smooth springs have it."""
    carries = dense.force > 1e-9 * dense.force.max()
    changes = np.flatnonzero(carries[1:] != carries[:-1])
    for k in changes[changes > 0]:
        # the force ends like the power 3/2 of the distance
        near = (k, k - 1) if carries[k] else (k + 1, min(k + 2, times.size - 1))
        one, two = (dense.force[i] ** (2.0 / 3.0) for i in near)
        share = one / (two - one) if two > one else 0.0
        at = times[near[0]] + share * (times[near[0]] - times[near[1]])
        at = float(np.clip(at, times[k], times[k + 1]))
        row = int(np.searchsorted(columns["time"], at))
        if not 0 < row < columns["time"].size or columns["time"][row - 1] == at or columns["time"][row] == at:
            continue
        part = (at - columns["time"][row - 1]) / (columns["time"][row] - columns["time"][row - 1])
        there = {"time": at, "force": 0.0, "contact_radius": 0.0}
        for name in ("overlap", "raw_force"):
            there[name] = float(columns[name][row - 1] + part * (columns[name][row] - columns[name][row - 1]))
        columns = {name: np.insert(values, row, there[name]) for name, values in columns.items()}
    return columns


def _to_last_contact(columns: dict[str, FloatArray], run: TimeWalk) -> dict[str, FloatArray]:
    """Without the rows after the body has left the flat for good, but for the first of them. To prescribe a force of 0 is to touch."""
    last = int(np.flatnonzero(columns["force"] > 0.0)[-1]) + 2
    if run.by_force.any():
        last = max(last, int(np.searchsorted(columns["time"], run.time[run.by_force][-1], side="right")))
    return {name: values[:last] for name, values in columns.items()}


def _with_turns(overlap: FloatArray) -> tuple[IntArray, IntArray]:
    """The rows in their order, those at which the overlap turns twice, and their branches: each starts where the one before ends."""
    branch = branches_in_time(overlap)
    turns = np.flatnonzero(np.diff(branch))
    order = np.sort(np.concatenate([np.arange(branch.size), turns]))
    numbers = branch[order]
    again = np.flatnonzero(np.diff(order) == 0) + 1
    numbers[again] = branch[order[again] + 1]
    return order, numbers
