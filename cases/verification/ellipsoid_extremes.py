"""Ellipsoids far from everyday use: no contact missed or invented, finite and right, or refused with one clear error.

Each row of the table is a command. What is "right" comes from an independent criterion (Perram & Wertheim's contact function, by numpy),
from dense search over directions, from closed forms, and from what collisions conserve.

    python -m cases.verification.ellipsoid_extremes [ROW ...] [--pairs 1000000] [--out FOLDER]

Exit code 1 if a trial misses its bound, gives NaN, or stops without saying why.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

import dem
from cases.verification import rows
from cases.verification.dem_extreme_trial import DENSITY, MATERIAL, RADIUS, Trial, judged, refused
from cases.verification.dem_extremes import run
from contactlaws.compiled import kernel
from contactlaws.ellipsoid_gap import closest, meeting, surface_tensor
from contactlaws.hertz_ellipse import HertzEllipse
from dem.ellipsoid_packing import half_axes, random_ellipsoids, random_turns
from dem.measure import energies
from dem.motion import Deformation
from dem.rotation import matrices, rotational_energy, shapes_of, turn
from dem.timestep import scene_time_step
from dem.working import follow, working

FloatArray = npt.NDArray[np.float64]

LAW = HertzEllipse(MATERIAL.reduced_modulus)
NO_TURN = (1.0, 0.0, 0.0, 0.0)
HALF = math.sqrt(0.5)
#: quarter turns that bring the first axis to y and to z
TO_Y, TO_Z = (HALF, 0.0, 0.0, HALF), (HALF, 0.0, -HALF, 0.0)
NEEDLE, PLATE, TRIAXIAL = (10.0, 1.0, 1.0), (10.0, 10.0, 1.0), (1.25, 1.0, 0.8)
#: pairs at a time, halvings of the golden section
CHUNK, GOLDEN_STEPS = 100_000, 60


def contact_function(one: FloatArray, other: FloatArray, branch: FloatArray) -> FloatArray:
    """Perram & Wertheim's of many pairs, shape (n,): they overlap if and only if it is below 1."""

    def value(x: FloatArray) -> FloatArray:
        mixed = (1.0 - x)[:, None, None] * one + x[:, None, None] * other
        found = x * (1.0 - x) * np.einsum("na,na->n", branch, np.linalg.solve(mixed, branch[:, :, None])[:, :, 0])
        return np.asarray(found)

    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    low, high = np.zeros(len(branch)), np.ones(len(branch))
    left, right = high - golden, low + golden
    at_left, at_right = value(left), value(right)
    for _ in range(GOLDEN_STEPS):
        down = at_left > at_right
        low, high = np.where(down, low, left), np.where(down, right, high)
        new = np.where(down, high - golden * (high - low), low + golden * (high - low))
        there = value(new)
        left, right = np.where(down, new, right), np.where(down, left, new)
        at_left, at_right = np.where(down, there, at_right), np.where(down, at_left, there)
    return np.maximum(at_left, at_right)


def tensors(axes: FloatArray, turns: FloatArray) -> FloatArray:
    """Q diag(a^2) Q^T of many, shape (n, 3, 3)."""
    q = matrices(turns)
    return np.asarray(np.einsum("nab,nb,ncb->nac", q, axes**2, q))


@kernel
def _overlaps(axes, turns, branch, overlap):  # type: ignore[no-untyped-def]
    """The engine's overlap of many pairs that it has never seen before."""
    for i in range(len(branch)):
        sharpest = 0.0
        for j in range(2):
            a, b, c = axes[i, j, 0], axes[i, j, 1], axes[i, j, 2]
            sharpest += min(a, min(b, c)) ** 2 / max(a, max(b, c))
        one = surface_tensor((axes[i, 0, 0], axes[i, 0, 1], axes[i, 0, 2]), turns[i, 0])
        other = surface_tensor((axes[i, 1, 0], axes[i, 1, 1], axes[i, 1, 2]), turns[i, 1])
        _, overlap[i] = closest(one, other, (branch[i, 0], branch[i, 1], branch[i, 2]), (0.0, 0.0, 0.0), sharpest, False, False)


def random_pairs(count: int, seed: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Half axes (volume 1), turns, branches, and the contact function of each: half of them within 1e-9 to .1 of touching."""
    rng = np.random.default_rng(seed)
    axes = 10.0 ** rng.random((count, 2, 3))
    axes /= np.cbrt(axes.prod(axis=2, keepdims=True))
    turns = random_turns(2 * count, seed).reshape(count, 2, 4)
    branch = rng.normal(size=(count, 3))
    one, other = (tensors(axes[:, k], turns[:, k]) for k in (0, 1))
    near = 1.0 + rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-9.0, -1.0, count)
    wanted = np.where(rng.random(count) < 0.5, near, rng.uniform(1e-3, 3.0, count))
    branch *= np.sqrt(wanted / contact_function(one, other, branch))[:, None]
    return axes, turns, branch, wanted


def pairs(count: int) -> list[Trial]:
    """No contact is missed, none invented: aspect ratios to 10."""
    missed, invented, slender = 0, 0, 1.0
    for seed in range(math.ceil(count / CHUNK)):
        axes, turns, branch, wanted = random_pairs(min(CHUNK, count - seed * CHUNK), seed)
        overlap = np.zeros(len(branch))
        _overlaps(axes, turns, branch, overlap)
        missed += int(np.sum((wanted < 1.0) & ~(overlap > 0.0)))
        invented += int(np.sum((wanted > 1.0) & ~(overlap < 0.0)))
        slender = max(slender, float((axes.max(axis=2) / axes.min(axis=2)).max()))
    done = f"{count} random pairs, aspect ratios to {slender:.3g}, half of them within 1e-9 to .1 of touching"
    return [judged(f"{done}: contacts missed", missed, 0.0), judged(f"{done}: invented", invented, 0.0)]


def depth(count: int) -> list[Trial]:
    """The depth against 40,000 directions: none may be shallower."""
    k = np.arange(40_000)
    z = 1.0 - (2.0 * k + 1.0) / len(k)
    n = np.stack([np.sqrt(1.0 - z * z) * np.cos(2.399963 * k), np.sqrt(1.0 - z * z) * np.sin(2.399963 * k), z], axis=1)
    axes, turns, branch, wanted = random_pairs(2000, 12345)
    deep = np.flatnonzero(wanted < 0.99)[:400]
    overlap, worst = np.zeros(len(branch)), 0.0
    _overlaps(axes, turns, branch, overlap)
    for i in deep.tolist():
        one, other = (tensors(axes[i : i + 1, side], turns[i : i + 1, side])[0] for side in (0, 1))
        g = np.sqrt(np.einsum("ka,ab,kb->k", n, one, n)) + np.sqrt(np.einsum("ka,ab,kb->k", n, other, n)) - n @ branch[i]
        worst = max(worst, float(overlap[i] / g.min()) - 1.0)
    return [judged(f"{len(deep)} pairs up to one centre in the other: deeper than the best of 40,000 directions, over it", worst, 1e-9)]


def shapes(count: int) -> list[Trial]:
    """Needles and plates 10:1, edge to edge, vertex on face, spheres and near-spheres: overlaps in closed form."""
    found = []
    for name, axes in (("needles", NEEDLE), ("plates", PLATE)):
        a, b, c = axes
        cases = (
            ("end to end", NO_TURN, (2.0 * a - 0.01, 0.0, 0.0)),
            ("side by side", NO_TURN, (0.0, 2.0 * b - 0.01, 0.0)),
            ("face to face", NO_TURN, (0.0, 0.0, 2.0 * c - 0.01)),
            ("crossed", TO_Y, (0.0, 0.0, 2.0 * c - 0.01)),
            ("edge or vertex on a face", TO_Z, (0.0, 0.0, a + c - 0.01)),
            ("a face on an edge or vertex", TO_Z, (a + c - 0.01, 0.0, 0.0)),
            ("rim to rim across", TO_Z, (0.0, 2.0 * b - 0.01, 0.0)),
        )
        for how, turned, branch in cases:
            overlap = meeting(axes, NO_TURN, axes, turned, branch).overlap
            found.append(judged(f"{name} 10:1 {how}: error of the overlap of .01", overlap - 0.01, 1e-12))
    for change in (1e-6, 1e-9, 1e-12):
        near = meeting((1.0, 1.0 + change, 1.0), random_turns(1, 1)[0], (1.0, 1.0, 1.0), NO_TURN, (0.0, 1.2, 1.5))
        expected = 2.0 - math.hypot(1.2, 1.5)
        found.append(judged(f"near-sphere 1:1+{change:g} on a sphere: overlap less the sphere's", near.overlap - expected, 2.0 * change))
        found.append(judged(f"near-sphere 1:1+{change:g} on a sphere: radius less the sphere's", near.radius - 0.5, 5.0 * change + 1e-14))
    return found


def faces(count: int) -> list[Trial]:
    """Nearly parallel flat faces: plates 10:1 tilted by 1e-12 to 1e-2, displaced along the face; the contact is where g says."""
    found = []
    for tilt in (0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2):
        turned = (math.cos(0.5 * tilt), math.sin(0.5 * tilt), 0.0, 0.0)
        worst: float = 0.0
        for aside in (0.0, 1e-9, 0.1, 5.0):
            place = meeting(PLATE, NO_TURN, PLATE, turned, (aside, 0.3 * aside, 1.5))
            h = math.sqrt(place.normal @ tensors(np.array([PLATE]), np.array([NO_TURN]))[0] @ place.normal)
            h += math.sqrt(place.normal @ tensors(np.array([PLATE]), np.array([turned]))[0] @ place.normal)
            worst = max(worst, float(abs(h - place.normal @ [aside, 0.3 * aside, 1.5] - place.overlap)))
            level = np.linalg.inv(tensors(np.array([PLATE]), np.array([NO_TURN]))[0])
            point = place.point + 0.5 * place.overlap * place.normal
            worst = max(worst, float(abs(point @ level @ point - 1.0)))
        found.append(judged(f"plates 10:1 tilted by {tilt:g}, displaced by 0 to 5: overlap and contact point off", worst, 1e-10))
    return found


def deep(count: int) -> list[Trial]:
    """From touching to centres in one place: overlaps grow, and are finite."""
    found = []
    for name, axes in (("needles", NEEDLE), ("plates", PLATE), ("triaxial bodies", TRIAXIAL)):
        turned = random_turns(1, 3)[0]
        direction = np.array([0.3, -0.5, 0.7]) / math.sqrt(0.83)
        values = [meeting(axes, NO_TURN, axes, turned, direction * x).overlap for x in np.linspace(25.0, 0.0, 501)]
        steps = np.diff(values)
        found.append(judged(f"{name} from apart to centres in one place, 501 states: not finite", int(np.sum(~np.isfinite(values))), 0.0))
        # g falls at each n by no more than the way
        found.append(judged(f"{name}: overlap grows by less than 0 or more than the way", max(-steps.min(), steps.max() - 0.05, 0.0), 1e-9))
    return found


def _collision(
    axes: tuple[float, float, float], turns: FloatArray, spin: float, speed: float, aside: float, fraction: float = 0.05
) -> tuple[float, float, float]:
    """Of two bodies (half axes in 5 um) that fly at each other: error of the energy, of the angular momentum, and the deepest D."""
    half = half_axes(axes, RADIUS)
    reach = 1.05 * float(half.max())
    position = np.array([[0.0, 0.0, -reach], [aside * RADIUS, 0.3 * aside * RADIUS, reach]]) + 50.0 * RADIUS
    rates = spin * np.array([[0.6, 0.0, 0.8], [0.0, -0.8, 0.6]])
    bodies = dem.ellipsoids(position, half, DENSITY, turns, [[0.0, 0.0, speed], [0.0, 0.0, -speed]], rates)
    made = dem.Scene(bodies, dem.Box((100.0 * RADIUS,) * 3, (False,) * 3), dem.Contact(LAW), (), skin=0.2)
    dt = min(scene_time_step(made, 0.02 * RADIUS, fraction).dt, 0.02 / spin if spin else math.inf)
    work = working(made)
    start, turning = energies(work), _angular_momentum(work)
    touched, largest = False, 0.0
    for _ in range(20_000):
        work, _ = follow(work, Deformation(work.cell.copy(), work.cell.copy(), 10**9, dt), 0, 50)
        touches = bool(work.force.any())
        largest = max(largest, float(work.tally[0, 3]))
        if touched and not touches:
            break
        touched = touched or touches
    end = energies(work)
    scale = float(np.abs(turning).max()) + float(work.masses[0]) * speed * RADIUS
    return end[0] / start[0] - 1.0, float(np.abs(_angular_momentum(work) - turning).max()) / scale, largest if touched else math.nan


def _angular_momentum(work: object) -> FloatArray:
    """kg m2/s about the middle."""
    w = work
    orbital = np.cross(w.bodies.position - 50.0 * RADIUS, w.masses[:, None] * w.bodies.velocity)  # type: ignore[attr-defined]
    return np.asarray((orbital + w.shapes.momentum).sum(axis=0))  # type: ignore[attr-defined]


def collisions(count: int) -> list[Trial]:
    """Two bodies meet at 40 m/s and fly apart: elastic, so energy comes back but for what a contact spends that changes its shape."""
    found = []
    along = np.array([NO_TURN, NO_TURN])
    for name, axes, turns, aside in (
        ("needles end to end, a little aside", NEEDLE, np.array([TO_Z, TO_Z]), 0.05),
        ("needles crossed", NEEDLE, np.array([NO_TURN, TO_Y]), 0.3),
        ("needles anyhow", NEEDLE, random_turns(2, 5), 0.2),
        ("plates face to face, nearly parallel", PLATE, np.array([NO_TURN, (math.cos(1e-4), math.sin(1e-4), 0.0, 0.0)]), 0.1),
        ("plates edge to edge", PLATE, np.array([TO_Z, TO_Z]), 0.02),
        ("plates anyhow", PLATE, random_turns(2, 8), 0.2),
        ("near-spheres 1:1.000001", (1.0, 1.000001, 1.0), along, 0.3),
    ):
        energy, turning, largest = _collision(axes, turns, 0.0, 40.0, aside)
        what = f"{name}, to D = {largest:.2g}"
        found.append(judged(f"{what}: energy gained", max(energy, 0.0) if math.isfinite(energy) else energy, 1e-4))
        found.append(judged(f"{what}: energy lost", min(energy, 0.0) if math.isfinite(energy) else energy, 1e-4))
        found.append(judged(f"{what}: angular momentum", turning, 1e-10))
    return found


def spin(count: int) -> list[Trial]:
    """A million radians a second: a free top for 1e6 steps, and a collision."""
    axes = np.array([TRIAXIAL]) * RADIUS
    mass = np.array([DENSITY * 4.0 / 3.0 * math.pi * axes.prod()])
    rate = np.array([[3e5, 9e5, 3e5]])
    top = shapes_of(axes, np.array([NO_TURN]), mass, rate)
    start, momentum, load = rotational_energy(top), top.momentum.copy(), np.zeros((1, 1, 3))
    state = (top.orientation, top.momentum, top.ease, top.axes, top.surface, rate)
    worst = 0.0
    for _ in range(100):
        for _ in range(10_000):
            turn(*state, load, 0.0, 1.0, 0.0, 2e-9, 0, 1)
        worst = max(worst, abs(rotational_energy(top) / start - 1.0))
    found = [
        judged("1e6 rad/s, 1e6 steps of 2e-3 rad: energy", worst, 1e-5),
        judged("the same: length of the quaternion", float(np.linalg.norm(top.orientation)) - 1.0, 1e-14),
        judged("the same: angular momentum", float(np.abs(top.momentum - momentum).max()), 0.0),
    ]
    energy, turning, largest = _collision(TRIAXIAL, random_turns(2, 5), 1e6, 20.0, 0.3)
    found.append(judged(f"two at 1e6 rad/s collide, to D = {largest:.2g}: energy", energy, 1e-4))
    found.append(judged("the same: angular momentum", turning, 1e-10))
    return found


def said(count: int) -> list[Trial]:
    """What cannot be done is one clear error."""
    box, touch, still = dem.Box((100.0 * RADIUS,) * 3), dem.Contact(LAW), (dem.hold(1e-9),)
    half = np.array(TRIAXIAL) * RADIUS

    def two_in(distance: float) -> Callable[[], object]:
        bodies = dem.ellipsoids([[1e-4] * 3, [1e-4, 1e-4, 1e-4 + distance]], half, DENSITY, random_turns(2, 1))
        return lambda: dem.run(dem.Scene(bodies, box, touch, still))

    return [
        refused("centres in one place", two_in(0.0), "lie deeper"),
        refused("centres a tenth of a radius apart", two_in(0.1 * RADIUS), "lie deeper"),
        refused("a needle 11:1", lambda: dem.ellipsoids([[0.0] * 3], (11.0, 1.0, 1.0), 1.0), "less slender"),
        refused("a half axis of 0", lambda: dem.ellipsoids([[0.0] * 3], (1.0, 1.0, 0.0), 1.0), "positive"),
        refused("a quaternion of 0", lambda: dem.ellipsoids([[0.0] * 3], (1.0, 1.0, 1.0), 1.0, [[0.0] * 4]), "other than 0"),
        refused("a packing denser than they jam", lambda: random_ellipsoids(30, 0.76, TRIAXIAL, 1), "jam before"),
    ]


ROWS: dict[str, Callable[[int], list[Trial]]] = {
    "pairs": pairs,
    "depth": depth,
    "shapes": shapes,
    "faces": faces,
    "deep": deep,
    "collisions": collisions,
    "spin": spin,
    "said": said,
}


def main(arguments: list[str] | None = None) -> int:
    """Run the rows asked for, or all; 0, or 1 if one is not as it should be."""
    parser = rows.parser_of("ellipsoid_extremes", __doc__, ROWS)
    parser.add_argument("--pairs", type=int, default=100_000, help="random pairs of the first row")
    parser.add_argument("--out", type=Path, help="folder for table.md; none if left out")
    given = rows.asked(parser, ROWS, arguments)
    return run({name: partial(ROWS[name], given.pairs) for name in given.row}, given.out)


if __name__ == "__main__":
    sys.exit(main())
