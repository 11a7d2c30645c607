"""A rigid sphere pressed into a body by finite elements: the curved interface of a hard body on a soft one.

The solver of `fem` presses bodies against a plane. Here the obstacle is a sphere, met by a penalty on the depth to which surface nodes
enter it: depth times area times a stiffness that keeps it near a thousandth of the overlap. One mesh, without the readout that removes
the ripple of landing nodes: forces are smoothed by a polynomial. Against a flat they are within 2 % of `fem.press` up to .1 R, 6 % to .3 R.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from contactlaws.curve import FloatArray
from contactlaws.material import Material
from fem.assembly import Discretisation, discretise
from fem.banded import pad
from fem.mesh import spheroid
from fem.newton import ByOverlap, Equilibrium, Moduli, NoEquilibrium, State
from fem.press import core_size, moduli_of

DIVISIONS = 8
#: the run starts at this share of its largest overlap, and goes up by the same factor each step
START, STEPS = 0.005, 60
#: share of the force that an unloading step takes off, and of the largest force at which it ends
DROP, LEFT = 0.1, 0.02
#: pressure in the contact over yield stress, and times what the penalty exceeds the pressure over the overlap
PRESSURE, PENALTY = 3.0, 1e3


class Indentation(NamedTuple):
    """Loading, smoothed, and the overlap left after unloading from its end; lengths over the body's radius, force over Y R^2."""

    overlap: FloatArray
    force: FloatArray
    left: float


class OnSphere(Equilibrium):
    """A body against a rigid sphere on its axis; the flat of the base class is not used (`contact=False`)."""

    def __init__(self, body: Discretisation, moduli: Moduli, radius: float):
        super().__init__(body, moduli)
        self.radius, self.stiffness_per_area = radius, 0.0
        surface = body.section.surface
        r, z = body.section.mesh.p[:, surface]
        ring = np.pi * np.hypot(np.diff(r), np.diff(z)) / 3.0
        self.area = np.zeros(surface.size)
        self.area[:-1] += ring * (2.0 * r[:-1] + r[1:])
        self.area[1:] += ring * (r[:-1] + 2.0 * r[1:])

    def evaluate(self, displacement: FloatArray, history: FloatArray) -> bool:
        """The body's forces, and those of the penalty on the surface nodes that have entered the sphere."""
        sound = super().evaluate(displacement, history)
        self._add_penalty(displacement, tangent=False)
        return sound

    def linearise(self, displacement: FloatArray, history: FloatArray, moduli: Moduli | None = None) -> bool:
        """The same with their tangent."""
        sound = super().linearise(displacement, history, moduli)
        self._add_penalty(displacement, tangent=True)
        return sound

    def _add_penalty(self, displacement: FloatArray, tangent: bool) -> None:
        nodes = self.body.section.surface
        below = self.gaps(displacement)  # under the plane that touches the sphere: no cancellation for a nearly flat one
        place = np.stack([self.body.section.mesh.p[0, nodes] + displacement[nodes, 0], -(self.radius + below)])
        distance = np.hypot(*place)
        gap = (place[0] ** 2 + below * (below + 2.0 * self.radius)) / (distance + self.radius)
        inside = gap < 0.0
        nodes, normal = nodes[inside], (place / distance)[:, inside]
        factor = self.stiffness_per_area * self.area[inside]
        force = factor * gap[inside]
        turning = force / distance[inside]
        for a in (0, 1):
            self.forces[2 * nodes + a] += force * normal[a]
            for c in (0, 1) if tangent else ():
                entry = (factor - turning) * normal[a] * normal[c] + (turning if a == c else 0.0)
                self.band[2 * nodes + a, pad(self.body.half_bandwidth) + c - a] += entry


def _reach(solver: OnSphere, state: State, overlap: float, largest_force: float) -> State:
    """The state at `overlap`, in steps as short as need be; raises `NoEquilibrium`."""
    step = overlap - state.overlap
    while state.overlap != overlap:
        target = state.overlap + step if abs(state.overlap + step - overlap) > 1e-12 else overlap
        try:
            state = solver.step(state, ByOverlap(target), largest_force, contact=False)
            step = overlap - state.overlap
        except NoEquilibrium:
            step *= 0.3
            if abs(step) < 1e-5 * abs(overlap):
                raise
    return state


def indent(material: Material, sphere_radius: float, largest: float) -> Indentation:
    """Press a body of radius 1 and a yield stress into a rigid sphere up to the overlap `largest`, and release it.

    Raises `NoEquilibrium` where the solver gives up.
    """
    along = 1.5 if largest > 0.15 else 1.0
    body = discretise(spheroid(DIVISIONS, core_size(largest, 2.0 * START * largest), along=along))
    solver = OnSphere(body, moduli_of(material), sphere_radius)
    state = replace(solver.start(), active=np.zeros(body.section.surface.size, dtype=bool))
    ratio, rows = material.youngs_modulus / material.stress_unit, [(0.0, 0.0)]
    with threadpool_limits(1):
        for overlap in np.geomspace(START, 1.0, STEPS) * largest:
            pressure = min(PRESSURE, ratio * float(np.sqrt(overlap)))
            solver.stiffness_per_area = PENALTY * pressure / overlap
            state = _reach(solver, state, float(overlap), rows[-1][1])
            rows.append((state.overlap, state.force))
        overlap, force = np.array(rows[1:]).T
        # that of a punch of about the contact's radius
        left = _left(solver, state, 2.0 * ratio * float(np.sqrt(2.0 * largest * sphere_radius / (1.0 + sphere_radius))))
    kept = overlap > largest / 30.0  # the contact has enough elements
    smooth = np.polyfit(np.log(overlap[kept]), np.log(force[kept]), 4)
    return Indentation(overlap[kept], np.exp(np.polyval(smooth, np.log(overlap[kept]))), left)


def _left(solver: OnSphere, start: State, stiffness: float) -> float:
    """Overlap at which the force has gone, from a first guess of the stiffness: F^(2/3) is all but straight at the end, so its last rows
    are carried on to 0."""
    state, rows = start, [(start.overlap, start.force)]
    while rows[-1][1] > LEFT * start.force:
        step = min(DROP * start.force, 0.4 * rows[-1][1]) / stiffness
        new = _reach(solver, state, state.overlap - step, start.force)
        stiffness = max((rows[-1][1] - new.force) / step, 0.5 * stiffness)
        if new.force > 0.5 * LEFT * start.force:
            state = new
            rows.append((state.overlap, state.force))
    overlap, force = np.array(rows[-3:]).T
    return float(np.polyfit(force ** (2.0 / 3.0), overlap, 1)[1])
