"""What is read off a state: contacts, homogenised stress and fabric, coordination, energies and their balance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.compiled import kernel
from dem.ellipsoid_forces import AXIS, BEFORE, ellipsoid_energies
from dem.forces import DAMPED, DRAGGED, LOST, PRESSED, SHEARED, WORK, contact_energies
from dem.rotation import rotational_energy
from dem.working import Group, Working, forces_between

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

#: a frictionless sphere in three dimensions needs as many contacts to be held
FEWEST_TO_HOLD = 4


class Network(NamedTuple):
    """All contacts that carry force; one row each. `second` is negative for walls: -1 the first, and so on."""

    first: IntArray  # row of the state, shape (m,)
    second: IntArray
    branch: FloatArray  # m, from the first centre to the second or to the wall, shape (m, 3)
    overlap: FloatArray  # m, shape (m,)
    depth: FloatArray  # overlap of one body over its radius, shape (m,)
    force: FloatArray  # N, on the second, shape (m, 3)
    group: IntArray  # of `Working.groups`
    common: FloatArray | None = None  # unit normals of both surfaces in the contact, shape (m, 3); None: of spheres, along the branch

    @property
    def normal(self) -> FloatArray:
        """Unit vectors from the first to the second, shape (m, 3)."""
        if self.common is not None:
            return self.common
        return self.branch / np.maximum(np.linalg.norm(self.branch, axis=1, keepdims=True), np.finfo(float).tiny)

    @property
    def normal_force(self) -> FloatArray:
        """N, repulsion positive."""
        return np.asarray((self.force * self.normal).sum(axis=1))

    @property
    def tangential_force(self) -> FloatArray:
        """N, its magnitude."""
        return np.asarray(np.linalg.norm(self.force - self.normal_force[:, None] * self.normal, axis=1))

    @property
    def fabric(self) -> FloatArray:
        """Mean of n n over contacts of spheres, shape (3, 3); a third on the diagonal if all directions are alike."""
        normal = self.normal[self.second >= 0]
        return normal.T @ normal / max(len(normal), 1)


def pair_geometry(work: Working, group: Group) -> tuple[FloatArray, FloatArray]:
    """Branch vectors and overlaps in m of all listed pairs of a group."""
    first, partner, position, radii = group.rows.first, group.rows.partner, work.bodies.position, work.radii
    if work.shapes is not None:
        return _branches(work, group), group.memory[:, BEFORE]  # type: ignore[index]
    if group.rows.image is None:
        axis, place = work.walls[partner, 0].astype(int), work.walls[partner, 2]
        branch = np.zeros((len(first), 3))
        branch[np.arange(len(first)), axis] = place - position[first, axis]
        return branch, radii[first] - np.abs(branch).max(axis=1, initial=0.0)
    branch = position[partner] + (work.listed.images @ work.cell)[group.rows.image] - position[first]
    return branch, radii[first] + radii[partner] - np.linalg.norm(branch, axis=1)


def _branches(work: Working, group: Group) -> FloatArray:
    """Branch vectors in m of all listed pairs of ellipsoids; on a wall, to the plane straight across from the centre."""
    first, partner, position = group.rows.first, group.rows.partner, work.bodies.position
    if group.rows.image is not None:
        return position[partner] + (work.listed.images @ work.cell)[group.rows.image] - position[first]
    axis, place = work.walls[partner, 0].astype(int), work.walls[partner, 2]
    branch = np.zeros((len(first), 3))
    branch[np.arange(len(first)), axis] = place - position[first, axis]
    return branch


def force_distribution(found: Network, edges: FloatArray) -> FloatArray:
    """Probability density of the normal force over its mean, between `edges`, shape (len(edges) - 1,); 0 without contacts."""
    force = found.normal_force
    if not len(force):
        return np.zeros(len(edges) - 1)
    counts, _ = np.histogram(force / force.mean(), edges)
    return np.asarray(counts / (len(force) * np.diff(edges)))


def network(work: Working) -> Network:
    """The contacts of a state, which stays as it is."""
    parts, normals = [], []
    for number, (group, force) in enumerate(zip(work.groups, forces_between(work), strict=True)):
        branch, overlap = pair_geometry(work, group)
        rows = np.flatnonzero((overlap > 0.0) & force.any(axis=1))
        first, partner, radii = group.rows.first[rows].astype(np.int64), group.rows.partner[rows].astype(np.int64), work.radii
        if group.rows.image is None:
            radius, second = radii[first], -1 - partner
        else:
            radius, second = radii[first] * radii[partner] / (radii[first] + radii[partner]) / group.roles.share, partner
        depth = overlap[rows] * group.roles.share / radius
        if work.shapes is not None and group.memory is not None:
            normals.append(group.memory[rows, AXIS : AXIS + 3])
        parts.append((first, second, branch[rows], overlap[rows], depth, force[rows], np.full(len(rows), number)))
    found = Network(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    return found._replace(common=np.concatenate(normals)) if normals else found


def largest_overlap(work: Working) -> float:
    """Deepest overlap in m of any contact; 0 if nothing touches."""
    return max((float(pair_geometry(work, group)[1].max(initial=0.0)) for group in work.groups), default=0.0)


class Energies(NamedTuple):
    """In J, one value per output."""

    kinetic: FloatArray  # of the motion relative to the box, spins included
    stored: FloatArray  # in contacts by their normal laws, recoverable
    sheared: FloatArray  # in tangential springs and rolling
    dissipated: FloatArray  # in contacts by their normal laws, living and ended
    rubbed: FloatArray  # by friction and rolling
    dashed: FloatArray  # by dampers
    damped: FloatArray  # by the drag
    boundary_work: FloatArray  # put in by the moving box since the start

    @property
    def balance(self) -> FloatArray:
        """What is missing: change of the energy held and lost less the work, over the most that it ever came to."""
        held = sum(self[:-1])
        assert isinstance(held, np.ndarray)
        most = float(np.max(held, initial=0.0))
        return (held - held[:1] - self.boundary_work) / (most or 1.0)


def energies(work: Working) -> tuple[float, ...]:
    """The terms of `Energies`, in J, of one state."""
    stored, dissipated, sheared = 0.0, 0.0, 0.0
    radii = work.radii
    for group in work.groups:
        _, overlap = pair_geometry(work, group)
        if work.shapes is not None:
            one, three = ellipsoid_energies(*_of_ellipsoids(work, group))
            stored, dissipated, sheared = stored + one, dissipated - one, sheared + three
            continue
        first, walls = radii[group.rows.first], group.rows.image is None
        second = first if walls else radii[group.rows.partner]
        roles, past = group.roles, group.past
        terms = (roles.normal, roles.tangential, roles.rolling, roles.share, group.memory, past.slip, past.roll)
        one, two, three = contact_energies(*terms, overlap, first, second, walls)
        stored, dissipated, sheared = stored + one, dissipated + two, sheared + three
    tally = work.tally.sum(axis=0)
    rubbed = tally[SHEARED] - sheared
    return (
        kinetic_energy(work),
        stored,
        sheared,
        dissipated + tally[LOST] + tally[PRESSED],
        rubbed,
        tally[DAMPED],
        tally[DRAGGED],
        tally[WORK],
    )


def _of_ellipsoids(work: Working, group: Group) -> tuple:
    """What `ellipsoid_energies` takes."""
    roles, rows, past, radii = group.roles, group.rows, group.past, work.radii
    first, walls = radii[rows.first], rows.image is None
    return roles.normal, roles.tangential, roles.share, past.memory, past.slip, first, first if walls else radii[rows.partner], walls


def stress_tensor(work: Working, with_motion: bool = True) -> FloatArray:
    """Homogenised stress in Pa, shape (3, 3), compression positive: (sum of r F over contacts + sum of m v v over particles)/volume."""
    velocity = work.bodies.velocity
    motion = np.einsum("i,ia,ib->ab", work.masses, velocity, velocity) if with_motion else 0.0
    return np.asarray((work.virial.sum(axis=0) + motion) / work.box.volume)


def kinetic_energy(work: Working) -> float:
    """In J, relative to the box, spins included."""
    energy = 0.5 * np.sum(work.masses[:, None] * work.bodies.velocity**2)
    if work.shapes is not None:
        energy += rotational_energy(work.shapes)
    elif work.bodies.spin is not None:
        energy += 0.2 * np.sum((work.masses * work.radii**2)[:, None] * work.bodies.spin**2)
    return float(energy)


@kernel
def _holding(count, first, second, needed):  # type: ignore[no-untyped-def]
    """Contacts of each particle after those with fewer than `needed` have been taken out, again and again."""
    alive = np.ones(count, np.bool_)
    contacts = np.zeros(count, np.int64)
    changed = True
    while changed:
        contacts[:] = 0
        for row in range(len(first)):
            i, j = first[row], second[row]
            if alive[i] and (j < 0 or alive[j]):
                contacts[i] += 1
                if j >= 0:
                    contacts[j] += 1
        changed = False
        for i in range(count):
            if alive[i] and contacts[i] < needed:
                alive[i] = False
                changed = True
    return contacts, alive


def contacts_per_sphere(found: Network, count: int) -> IntArray:
    """How many contacts that carry force each sphere has, walls included."""
    return np.bincount(found.first, minlength=count) + np.bincount(found.second[found.second >= 0], minlength=count)


def coordination(found: Network, count: int, needed: int = FEWEST_TO_HOLD) -> tuple[float, float, int]:
    """Mean number of force-carrying contacts of all spheres; of those that are held; and the number of rattlers, which are not."""
    if count == 0:
        return 0.0, 0.0, 0
    contacts, alive = _holding(count, found.first, found.second, needed)
    held = int(alive.sum())
    return float(contacts_per_sphere(found, count).mean()), float(contacts[alive].mean()) if held else 0.0, count - held
