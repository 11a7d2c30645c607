"""What the choice of the stress that remembers is worth: hereditary integrals of the first and of the second Piola-Kirchhoff stress.

`fem.relaxing` sums up the nominal (first) stress of the past, which does not turn with the material. Summed up as the second one, which
turns and stretches with it, the same body carries another force. To first order the difference is what the work of the two stresses on the
elastic motion says, so no second solver is needed.
"""

from __future__ import annotations

import numpy as np

from contactlaws.prony import Relaxation, uniaxial
from fem.assembly import Discretisation, discretise
from fem.mesh import FloatArray, spheroid
from fem.newton import ByOverlap, Equilibrium, State
from fem.press import core_size, moduli_of
from fem.relaxing import held_share


def turned_force(modulus: Relaxation, poissons_ratio: float, depth: float, steps: int = 24, divisions: int = 12) -> tuple[float, float]:
    """Force at the end of an even ramp to `depth` (over the radius) that lasts the first relaxation time: as solved for, and with the
    second Piola-Kirchhoff stress in the integral. Poisson's ratio is constant."""
    material = uniaxial(modulus, poissons_ratio)
    body = discretise(spheroid(divisions, core_size(depth, depth), 1.0, 1.0))
    solver = Equilibrium(body, moduli_of(material.instantaneous))
    overlaps = depth * np.arange(1, steps + 1) / steps
    states = [solver.start()]
    for overlap in (*overlaps, depth * (1.0 + 1e-4)):
        states.append(solver.step(states[-1], ByOverlap(float(overlap)), states[-1].force))
    motion = (gradients(body, states[-1].displacement) - gradients(body, states[-2].displacement)) / (1e-4 * depth)
    first, second = zip(*(stresses(body, state) for state in states[:-1]), strict=True)
    duration = modulus.times[0]
    ours = hereditary(np.array(first), modulus, duration)
    with_body = gradients(body, states[-2].displacement) @ hereditary(np.array(second), modulus, duration)
    work = [float((body.volumes[..., None, None] * stress * motion).sum()) for stress in (ours, with_body)]
    return work[0], work[1]


def gradients(body: Discretisation, displacement: FloatArray) -> FloatArray:
    """Deformation gradients (elements, 4, 3, 3) in the order r, z, hoop."""
    nodal = displacement[body.cells]
    found = np.zeros((*body.volumes.shape, 3, 3))
    found[..., :2, :2] = np.eye(2) + np.einsum("eni,egnj->egij", nodal, body.gradients)
    found[..., 2, 2] = 1.0 + np.einsum("en,egn->eg", nodal[..., 0], body.hoops)
    return found


def stresses(body: Discretisation, state: State) -> tuple[FloatArray, FloatArray]:
    """First and second Piola-Kirchhoff stress at the Gauss points."""
    deformation = gradients(body, state.displacement)
    cauchy = np.zeros_like(deformation)
    cauchy[..., 0, 0], cauchy[..., 1, 1], cauchy[..., 2, 2] = state.stress[..., 0], state.stress[..., 1], state.stress[..., 3]
    cauchy[..., 0, 1] = cauchy[..., 1, 0] = state.stress[..., 2]
    back = np.linalg.inv(deformation)
    first = np.linalg.det(deformation)[..., None, None] * cauchy @ np.swapaxes(back, -1, -2)
    return first, back @ first


def hereditary(stress: FloatArray, modulus: Relaxation, duration: float) -> FloatArray:
    """The integral over rows that are even in time, each term exact for straight growth in between."""
    step = duration / (len(stress) - 1)
    total = stress[-1] * (1.0 - sum(modulus.fractions))
    for g, left, held in zip(modulus.fractions, *held_share(step, np.array(modulus.times)), strict=True):
        term = np.zeros_like(stress[0])
        for change in np.diff(stress, axis=0):
            term = left * term + held * change
        total = total + g * term
    return np.asarray(total)
