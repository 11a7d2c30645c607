"""What a scene can do without at the price of a known error: a relaxing law whose times the loading is slow, or fast, against."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np

from contactlaws.elastic import HertzFiniteSize
from contactlaws.maxwell_zener import MaxwellZener
from contactlaws.maxwell_zener_ting import MaxwellZenerTing
from dem.record import COLUMNS
from dem.scene import Contact, Scene

RELAXING = (MaxwellZener, MaxwellZenerTing)


def reduced(scene: Scene, durations: tuple[float, ...]) -> tuple[Scene, tuple[str, ...]]:
    """The scene with elastic laws in place of relaxing ones where the error stays below `scene.neglect`; and a line for each.

    `durations` (s) are those of the stages. "history" in `scene.carry` keeps the laws.
    """
    if scene.neglect == 0.0 or "history" in scene.carry:
        return scene, ()
    contact, line = _elastic(scene.contact, durations, scene.neglect)
    between = [(one, other, _elastic(c, durations, scene.neglect)) for one, other, c in scene.between]
    walls = [_elastic(c, durations, scene.neglect) for c in scene.wall_contact or ()]
    said = (line, *(found[1] for _, _, found in between), *(text for _, text in walls))
    changed = dataclasses.replace(
        scene,
        contact=contact,
        between=tuple((one, other, found[0]) for one, other, found in between),
        wall_contact=None if scene.wall_contact is None else tuple(c for c, _ in walls),
    )
    return changed, tuple(text for text in said if text is not None)


def _elastic(contact: Contact, durations: tuple[float, ...], neglect: float) -> tuple[Contact, str | None]:
    law = contact.normal
    if not isinstance(law, RELAXING):
        return contact, None
    slow, fast = overstress(law, min(durations)), relaxed(law, sum(durations))
    if min(slow, fast) > neglect:
        return contact, None
    left = 1.0 - float(np.sum(law.fractions)) if slow <= fast else 1.0
    elastic = HertzFiniteSize(law.radius, left * law.reduced_modulus, law.force_1, law.force_2, law.force_3, law.area_1, law.area_2)
    when = "slow against every relaxation time: its long-term" if slow <= fast else "fast against every relaxation time: its instantaneous"
    sure = "; for contacts that touch from the start, which the end of the run checks" if slow <= fast else ""
    line = f"loading is {when} elastic law in place of the relaxing one, at most {min(slow, fast):.1g} of the largest stress off{sure}"
    return contact._replace(normal=elastic), line


def overstress(law: MaxwellZener | MaxwellZenerTing, duration: float) -> float:
    """What a straight ramp of this duration (s) leaves above the long-term force at its end, over that force: sum of g t/T (1 - e^(-T/t)).

    Of growing overlaps; for Hertz's power law the rate at the end is 3/2 times the mean one, which is taken account of.
    """
    left = 1.0 - float(np.sum(law.fractions))
    return 1.5 * sum(g * t / duration * -math.expm1(-duration / t) for g, t in zip(law.fractions, law.times, strict=True)) / left


def relaxed(law: MaxwellZener | MaxwellZenerTing, duration: float) -> float:
    """What relaxes at most in this time (s), over the force at once: sum of g (1 - e^(-T/t))."""
    return sum(g * -math.expm1(-duration / t) for g, t in zip(law.fractions, law.times, strict=True))


def faster_than_reckoned(asked: Scene, scene: Scene, rows: Sequence[Sequence[float]]) -> Iterator[str]:
    """What to say if the stress of a finished run changed faster than a long-term law in place of the one asked for allows.

    Above the long-term stress lies sum of g t dp/dt/(1 - sum of g), for times short against those of the loading; `rows` as in
    `record.COLUMNS`.
    """
    time = np.array([row[COLUMNS.index("time")] for row in rows])
    pressure = np.mean([[row[COLUMNS.index(f"stress {axis}{axis}")] for row in rows] for axis in "xyz"], axis=0)
    largest = float(np.abs(pressure).max(initial=0.0))
    if len(rows) < 2 or largest == 0.0:
        return
    rate = float(np.abs(np.diff(pressure) / np.diff(time)).max()) / largest
    for before, after in zip(asked.contacts, scene.contacts, strict=True):
        law, elastic = before.normal, after.normal
        if isinstance(law, RELAXING) and isinstance(elastic, HertzFiniteSize) and elastic.reduced_modulus < law.reduced_modulus:
            error = rate * float(np.sum(law.fractions * law.times)) / (1.0 - float(np.sum(law.fractions)))
            if error > asked.neglect:
                yield f"stress came late: its long-term law is some {error:.2g} of the largest one off; neglect=0 keeps the relaxing law"
