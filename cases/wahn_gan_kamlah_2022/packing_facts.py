"""What statements about packings are judged by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cases.wahn_gan_kamlah_2022.packing_runs import FRICTIONS, threshold
from cases.wahn_gan_kamlah_2022.packings import Band, Run, Runs, band

#: with friction and without
RUBBING, SMOOTH = max(FRICTIONS), 0.0
#: the paper's long-term stress at 0.3 % (Pa), the strain at which a bed first carries stress, its fraction and its contacts there
PAPER_STRESS, PAPER_ONSET, PAPER_FRACTION, PAPER_CONTACTS = 0.0127e6, 0.07, 0.62, 4.8
#: where curves are compared: far from their first rise
LATE = {"13": 0.01, "14": 0.01, "15": 0.005, "16": 0.003}


class Judged(NamedTuple):
    """A statement in our words, what the paper gives, what was found, and whether it holds; what was found has one line for each case."""

    place: str
    claim: str
    paper: str
    ours: str
    verdict: str
    reason: str


def excess(runs: Runs, figure: str, one: str, other: str, friction: float, strain: float | None = None) -> Band:
    """Stress of one way over that of another, less 1, over packings that already carry some."""
    where, least = LATE[figure] if strain is None else strain, threshold("NMC" if figure == "14" else "PVDF")
    return band(a.at(where) / b.at(where) - 1.0 for a, b in runs.pairs(figure, one, other, friction) if b.at(where) > least)


def percent(found: Band) -> str:
    """A band of relative differences."""
    return found.text("+.1f", " %", 100.0) if found.packings else "no stress at rest yet"


def both(runs: Runs, figure: str, one: str, other: str, strain: float | None = None) -> str:
    """With friction and without."""
    rubbing, smooth = (percent(excess(runs, figure, one, other, f, strain)) for f in (RUBBING, SMOOTH))
    return f"μ = {RUBBING:g}: {rubbing}\nno friction: {smooth}"


def inline(lines: str) -> str:
    """Lines as a part of a sentence."""
    return lines.replace("\n", "; ")


def power(value: float) -> str:
    """A large number by its order of magnitude.

    >>> power(2.76e15)
    '3·10¹⁵'
    """
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}·10" + str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def largest(found: Band) -> float:
    """Largest magnitude in a band; infinite without any."""
    return max(abs(found.least), abs(found.most)) if found.packings else math.inf


def within(found: Band, value: float) -> bool:
    """Whether packings lie on both sides of a value."""
    return found.least <= value <= found.most


def listed(values: Sequence[float]) -> str:
    """Some coefficients."""
    return ", ".join(f"{value:g}" for value in values) or "none of these"


def onsets(runs: Sequence[Run]) -> tuple[Band, Band, Band]:
    """Strain, packing fraction and coordination number at the first stress."""
    rows = [(r, k) for r in runs if (k := r.onset(threshold("PVDF"))) is not None]
    return band(r.strain[k] for r, k in rows), band(r.fraction[k] for r, k in rows), band(r.coordination[k] for r, k in rows)


def from_loose(runs: Runs, friction: float) -> list[Run]:
    """The compressions from .58 with a coefficient."""
    return runs.of("13", "from .58", friction) or runs.of("friction", "13", friction)


def more_contacts(runs: Runs, figure: str, one: str, other: str, friction: float, strain: float) -> Band:
    """Contacts per sphere of one way over those of another at a strain, less 1."""
    pairs = [(a.contacts_at(strain), b.contacts_at(strain)) for a, b in runs.pairs(figure, one, other, friction)]
    return band(own / reference - 1.0 for own, reference in pairs if reference > 0.0)


def long_term(runs: Runs, friction: float) -> Band:
    """Stress in Pa at 0.3 % with the long-term modulus."""
    return band(r.at(LATE["16"]) for r in runs.of("friction", "16", friction))


def overstress(duration: float, time: float) -> float:
    """Share of the overstress that an even ramp of the overlap leaves in d^1.5: 3/2 of the integral of sqrt(s) exp(-(1 - s) T/tau)."""
    share = (np.arange(200_000) + 0.5) / 200_000
    return float(1.5 * np.mean(np.sqrt(share) * np.exp(-(1.0 - share) * duration / time)))
