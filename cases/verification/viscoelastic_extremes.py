"""How far the viscoelastic laws go: speeds, times, steps, overlaps and reversals that no simulation should ask for, and what comes of each.

Every trial takes a law along a path and says whether all it gives is finite, the largest pull, how much energy its account makes from
nothing, and how far its force is at worst from the limit or from the exact history (`contactlaws.foundation`), over the largest force. The
law of a growing contact, which cuts its force off at zero on retreat, is held against it while the contact first grows.

    python -m cases.verification.viscoelastic_extremes [--out FOLDER] [--only TEXT]

Writes table.md and table.csv. Exit code 1 if a trial breaks its bound.
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from contactlaws.elastic import HertzFiniteSize, finite_size_energy, finite_size_factors, finite_size_force
from contactlaws.files import write_text
from contactlaws.foundation import Springs, follow, springs_of
from contactlaws.maxwell_zener import FIRST, LOST, maxwell_zener
from contactlaws.maxwell_zener_ting import maxwell_zener_ting
from contactlaws.path import Scan, scan
from contactlaws.prony import Relaxation
from contactlaws.remembered_springs import FIRST as FIRST_WITH_SPRINGS

FloatArray = npt.NDArray[np.float64]
TimedPath = tuple[FloatArray, FloatArray]

#: reduced modulus; with the radius, 1: forces scale with it
UNIT = 1.0
#: mild as PVDF, and a body of which nine tenths relax
MILD, STRONG = (0.2285,), (0.9,)
#: overlap over radius where nothing else is said: the law's springs end there
USUAL = 0.3
#: springs of the exact history
SPRINGS = 500
#: rows from corner to corner
ROWS = 200
#: energy from nothing, over the largest work: for the law without springs what trapezoids leave of it on 100 rows, for the one with them
#: what straight lines between twelve springs leave where the last one lets go
CREATED = {"maxwell_zener": 5e-3, "maxwell_zener_ting": 1e-2}


class Trial(NamedTuple):
    """A law's name, its record, the path, what its force must be, on which rows, and how near."""

    name: str
    law: str
    record: Any
    path: TimedPath
    against: str
    expected: FloatArray
    bound: float
    rows: slice = slice(None)


class Row(NamedTuple):
    """What came of a trial; `tension`, `created`, `error` over the largest force or work."""

    trial: str
    law: str
    against: str
    finite: bool
    tension: float
    created: float
    error: float
    bound: float

    @property
    def sound(self) -> bool:
        """Finite, without pull, nothing from nothing, near enough."""
        return self.finite and self.tension == 0.0 and self.created <= CREATED[self.law] and self.error <= self.bound


def legs(time: npt.ArrayLike, overlap: npt.ArrayLike, rows: int = ROWS, graded: bool = False) -> TimedPath:
    """Straight lines from corner to corner; graded: and rows that get ever shorter towards the corner left."""
    share = np.arange(rows) / rows
    if graded:
        share = np.union1d(share, np.geomspace(1e-12, 1.0, rows, endpoint=False))
    corners = [np.asarray(column, dtype=np.float64) for column in (time, overlap)]
    t, d = (np.append((c[:-1, None] + np.diff(c)[:, None] * share).ravel(), c[-1]) for c in corners)
    return t, d


def elastic_springs(nu: float | None = None, largest: float = USUAL, count: int = SPRINGS) -> Springs:
    """Of the instantaneous modulus."""
    factors = (0.0,) * 5 if nu is None else finite_size_factors(nu)
    body = HertzFiniteSize(1.0, UNIT, *factors)
    return springs_of(lambda overlap: np.array([finite_size_force(body, d) for d in overlap.tolist()]), largest, count)


def trials_of(
    name: str, modulus: Relaxation, path: TimedPath, bound: float, nu: float | None = None, largest: float = USUAL
) -> Iterator[Trial]:
    """Both laws against the exact history, the law without springs while the contact first grows."""
    time, overlap = path
    true = follow(elastic_springs(nu, max(largest, overlap.max())), modulus, time, overlap).force
    plain = maxwell_zener(modulus, 1.0, nu)
    yield Trial(name, "maxwell_zener", plain, path, "exact history while growing", true, GROWING, growing(overlap))
    yield Trial(name, "maxwell_zener_ting", maxwell_zener_ting(modulus, 1.0, nu), path, "exact history", true, bound)


def growing(overlap: FloatArray) -> slice:
    """The rows before the contact first shrinks."""
    turn = np.flatnonzero(np.diff(overlap) < 0.0)
    return slice(0, int(turn[0]) + 1 if turn.size else None)


#: of a growing contact: springs of the exact history, and steps in which the one counts as straight the overlap, the other the force; on
#: 100 rows of a body that relaxes by 99 %
GROWING = 4e-4


def material(fractions: tuple[float, ...], *times: float) -> Relaxation:
    """With the modulus `UNIT`."""
    return Relaxation(UNIT, fractions, times)


def speeds() -> Iterator[Trial]:
    """Press and release in 1e-8 to 1e8 relaxation times; the ends of that range are the elastic bodies of both moduli."""
    for decade in (-8, -6, -4, -2, -1, 0, 1, 2, 3, 4, 6, 8):
        for fractions, bound in ((MILD, 2.5e-3), (STRONG, 2e-2)):
            modulus = material(fractions, 10.0**-decade)
            path = legs((0.0, 1.0, 2.0), (0.0, USUAL, 0.0))
            name = f"loading time over relaxation time 1e{decade:+d}, {fractions[0]:.0%} relaxing"
            yield from trials_of(name, modulus, path, bound)
    for decade, share in ((-8, 1.0), (8, 1.0 - MILD[0])):
        time, overlap = legs((0.0, 1.0, 2.0), (0.0, USUAL, 0.0))
        law, name = maxwell_zener_ting(material(MILD, 10.0**-decade), 1.0), f"loading time over relaxation time 1e{decade:+d}"
        limit = share * 4.0 / 3.0 * UNIT * overlap**1.5
        yield Trial(name, "maxwell_zener_ting", law, (time, overlap), "elastic limit", limit, 1e-6)


def decades_apart() -> Iterator[Trial]:
    """Terms at 1e-6, 1 and 1e6 s, in programmes of 1e-8 to 1e8 s."""
    modulus = material((0.25, 0.25, 0.25), 1e-6, 1.0, 1e6)
    for decade in (-8, -4, 0, 4, 8):
        path = legs(10.0**decade * np.array((0.0, 1.0, 3.0, 4.0)), (0.0, USUAL, USUAL, 0.0), graded=True)
        yield from trials_of(f"terms 12 decades apart, programme of 1e{decade:+d} s", modulus, path, 1e-2)


def poissons_ratios() -> Iterator[Trial]:
    """The finite-size correction up to nearly incompressible."""
    for nu in (0.0, 0.3, 0.4999):
        path = legs((0.0, 1.0, 2.0, 3.0), (0.0, USUAL, USUAL, 0.0))
        yield from trials_of(f"finite sphere, nu {nu:g}", material(MILD, 1.0), path, 2.5e-3, nu)


def steps() -> Iterator[Trial]:
    """Press and release in 2 x 200 steps of 1e-6 to 1e6 relaxation times."""
    for decade in range(-6, 7, 2):
        path = legs((0.0, ROWS * 10.0**decade, 2.0 * ROWS * 10.0**decade), (0.0, USUAL, 0.0))
        yield from trials_of(f"steps of 1e{decade:+d} relaxation times", material(MILD, 1.0), path, 2.5e-3)
    one = maxwell_zener_ting(material(STRONG, 1.0), 1.0)
    for decade in (3, 6):
        path = (np.array([0.0, 10.0**decade]), np.array([0.0, USUAL]))
        limit = np.array([0.0, 0.1 * 4.0 / 3.0 * USUAL**1.5])
        yield Trial(
            f"one step of 1e{decade:+d} relaxation times", "maxwell_zener_ting", one, path, "long-term limit", limit, 10.0 * 10.0**-decade
        )


def holds() -> Iterator[Trial]:
    """At rate 0: 1e6 relaxation times in steps of all lengths, then away in no time, and slowly."""
    for fractions, bound in ((MILD, 2.5e-3), (STRONG, 1e-2)):
        modulus = material(fractions, 1.0)
        rest = np.geomspace(1e-8, 1e6, 300)
        for name, away in (("and away at once", 0.0), ("and away in 1e6 more", 1e6)):
            time = np.concatenate(([0.0, 0.0], rest, np.linspace(1e6, 1e6 + away, ROWS)[1:]))
            overlap = np.concatenate(([0.0], np.full(301, USUAL), np.linspace(USUAL, 0.0, ROWS)[1:]))
            yield from trials_of(f"hold of 1e6 relaxation times, {fractions[0]:.0%} relaxing, {name}", modulus, (time, overlap), bound)


def reversals() -> Iterator[Trial]:
    """Jumps to and fro in no time, before, while and after the body relaxes, and re-contact before it has recovered."""
    for pause in (1e-6, 1e-2, 1.0, 1e2, 1e6):
        time = pause * np.repeat(np.arange(5.0), 2)
        overlap = USUAL * np.array((0.0, 1.0, 1.0, 0.5, 0.5, 0.9, 0.9, 0.4, 0.4, 1.0))
        path = legs(time, overlap, graded=True)
        for fractions, bound in ((MILD, 5e-3), (STRONG, 2.5e-2)):
            yield from trials_of(
                f"jumps every {pause:g} relaxation times, {fractions[0]:.0%} relaxing", material(fractions, 1.0), path, bound
            )
    for fractions, bound in ((MILD, 2.5e-3), (STRONG, 1e-2)):
        path = legs((0.0, 1.0, 1.7, 2.2, 3.0, 4.0), USUAL * np.array((0.0, 1.0, 0.02, 0.02, 1.0, 0.0)))
        yield from trials_of(f"re-contact before recovery, {fractions[0]:.0%} relaxing", material(fractions, 1.0), path, bound)


def overlaps() -> Iterator[Trial]:
    """Below the first remembered spring there is one straight line, above the last one another."""
    for largest, bound in ((1e-12, 6e-2), (1e-6, 6e-2), (1e-3, 2.5e-3), (0.6, 5e-3), (0.9, 1e-2)):
        path = legs((0.0, 1.0, 2.0), (0.0, largest, 0.0))
        yield from trials_of(f"overlap of {largest:g} R", material(MILD, 1.0), path, bound, largest=largest)


def shares() -> Iterator[Trial]:
    """Next to nothing relaxes, and next to everything."""
    for fraction, bound in ((1e-9, 1e-9), (0.999, 5e-2)):
        path = legs((0.0, 1.0, 2.0, 3.0), (0.0, USUAL, 0.5 * USUAL, USUAL))
        yield from trials_of(f"{fraction:.10g} of the modulus relaxing", material((fraction,), 1.0), path, max(bound, 2e-6))


def cycles() -> Iterator[Trial]:
    """20 000 cycles between .6 and 1 of the overlap, then rest: the long-term force, and no energy gathered on the way."""
    count, rows = 20_000, 20
    phase = np.arange(count * rows) / rows
    overlap = np.concatenate(([0.0], USUAL * (0.8 - 0.2 * np.cos(2.0 * np.pi * phase)), np.full(3, USUAL)))
    time = np.concatenate(([0.0], phase + 1.0, count + np.array([1e2, 1e3, 1e6])))
    limit = np.full(time.size, (1.0 - STRONG[0]) * 4.0 / 3.0 * UNIT * USUAL**1.5)
    for name, law in (("maxwell_zener", maxwell_zener), ("maxwell_zener_ting", maxwell_zener_ting)):
        record = law(material(STRONG, 1.0), 1.0)  # type: ignore[operator]
        yield Trial("20 000 cycles, then rest", name, record, (time, overlap), "long-term limit", limit, 1e-9, slice(-1, None))


def random_histories(count: int = 100) -> Iterator[Trial]:
    """Two to eight turns at any speed, of materials of one to three terms, some of which relax by 99 %."""
    random = np.random.default_rng(1)
    for number in range(count):
        terms, turns = int(random.integers(1, 4)), int(random.integers(2, 9))
        shares = random.uniform(0.1, 1.0, terms)
        fractions = random.choice([0.2285, 0.5, 0.9, 0.99]) * shares / shares.sum()
        times = np.sort(10.0 ** random.uniform(-3.0, 3.0, terms))
        depths = np.where(random.random(turns) < 0.5, random.random(turns), 10.0 ** random.uniform(-3.0, 0.0, turns)) * USUAL
        path = legs(np.append(0.0, np.cumsum(10.0 ** random.uniform(-4.0, 4.0, turns))), np.append(0.0, depths), 100, graded=True)
        yield from trials_of(f"random history {number}", material(tuple(fractions.tolist()), *times.tolist()), path, 0.1)


TRIALS: tuple[Callable[[], Iterator[Trial]], ...] = (
    speeds,
    decades_apart,
    poissons_ratios,
    steps,
    holds,
    reversals,
    overlaps,
    shares,
    cycles,
)


def energy_made(trial: Trial, found: Scan) -> float:
    """Energy from nothing, over the largest work: by which the account says more than was put in, or takes back what it said was lost.

    While the contact first grows, the springs' free energy is known from the strains that the law keeps (the long-term one in closed form,
    q_i/2 of each term), and is held with the loss against the work. After that: stored energy below zero, work back beyond all work in.
    """
    record, states, (_, overlap) = trial.record, found.states, trial.path
    done = np.concatenate(([0.0], np.cumsum(0.5 * (found.force[1:] + found.force[:-1]) * np.diff(overlap))))
    place = (FIRST if trial.law == "maxwell_zener" else FIRST_WITH_SPRINGS) + record.fractions.size
    elastic = np.array([finite_size_energy(record, max(d, 0.0)) for d in overlap.tolist()])
    free = (1.0 - record.fractions.sum()) * elastic + 0.5 * states[:, place : place + record.fractions.size] @ record.fractions
    grown = growing(overlap)
    made = (free + states[:, LOST] - done)[grown]
    closed = overlap > 0.0
    back = np.diff(states[:, LOST])[closed[1:]]
    worst = max(float(made.max()), float(-found.stored_energy[closed].min()), float(-done.min()), float(-back.min(initial=0.0)), 0.0)
    return worst / max(float(done.max()), 1e-300)


def row_of(trial: Trial) -> Row:
    """Run a trial."""
    time, overlap = trial.path
    found = scan(trial.record, overlap, time)
    finite = all(bool(np.isfinite(column).all()) for column in found)
    largest = float(trial.expected.max())
    pull, error = float(-found.force.min()) / largest, float(abs(found.force - trial.expected)[trial.rows].max()) / largest
    return Row(trial.name, trial.law, trial.against, finite, max(0.0, pull), energy_made(trial, found), error, trial.bound)


def rows(only: str = "") -> list[Row]:
    """The whole table, or the trials whose name contains `only`; of the random histories the worst of each column."""
    table = [row_of(trial) for make in TRIALS for trial in make() if only in trial.name]
    random = [row_of(trial) for trial in random_histories() if only in trial.name]
    return [*table, *(worst for law in CREATED if (worst := worst_of([row for row in random if row.law == law])))]


def worst_of(table: list[Row]) -> Row | None:
    """One row for all; None if there are none."""
    if not table:
        return None
    finite = all(row.finite for row in table)
    tension, created, error = (max(column) for column in zip(*(row[4:7] for row in table), strict=True))
    name = f"the worst of {len(table)} random histories"
    return table[0]._replace(trial=name, finite=finite, tension=tension, created=created, error=error)


HEADER = ("trial", "law", "against", "finite", "largest pull", "energy from nothing", "error", "bound")


def cells(row: Row) -> list[str]:
    """As shown."""
    numbers = [f"{value:.1e}" if value else "0" for value in (row.tension, row.created, row.error, row.bound)]
    return [row.trial, row.law, row.against, "yes" if row.finite else "NO", *numbers]


def markdown(table: list[Row]) -> str:
    """The table, and what was worst."""
    lines = ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
    lines += ["| " + " | ".join(cells(row)) + " |" for row in table]
    return "\n".join([*lines, "", summary(table), ""])


def summary(table: list[Row]) -> str:
    """In one sentence."""
    worst = max(table, key=lambda row: row.error)
    made = max(table, key=lambda row: row.created)
    return (
        f"{len(table)} trials, {sum(not row.sound for row in table)} beyond a bound; all finite: {all(row.finite for row in table)}; "
        f"largest pull {max(row.tension for row in table):g}; most energy from nothing {made.created:.1e} of the work ({made.trial}); "
        f"largest error {worst.error:.1e} of the largest force ({worst.trial}, {worst.law})."
    )


def comma_separated(table: list[Row]) -> str:
    """CSV with all digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Row._fields)
    writer.writerows(table)
    return text.getvalue()


def main(arguments: list[str] | None = None) -> int:
    """Run the table; 0, or 1 if a trial breaks a bound."""
    parser = argparse.ArgumentParser(prog="python -m cases.verification.viscoelastic_extremes", description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--out", type=Path, default=Path("results/viscoelastic_extremes"), help="folder for table.md and table.csv")
    parser.add_argument("--only", default="", help="only trials whose name contains this text")
    given = parser.parse_args(arguments)
    table = rows(given.only)
    if not table:
        print("no trial has such a name")
        return 1
    given.out.mkdir(parents=True, exist_ok=True)
    write_text(given.out / "table.md", markdown(table))
    write_text(given.out / "table.csv", comma_separated(table))
    for row in table:
        print(f"{'' if row.sound else 'BEYOND ITS BOUND: '}{'; '.join(cells(row))}")
    print(summary(table))
    return 0 if all(row.sound for row in table) else 1


if __name__ == "__main__":
    sys.exit(main())
