"""Which law to take for a tolerance: the cheapest whose error was measured to be small enough, from a shipped table of scores.

The table holds the scores of a tournament (see `calibration.tournament`) for the laws that a fit by name gives, with their nanoseconds per
contact. What counts for a material is how good a law was on the reference curves around it, up to the overlap that is asked for.
"""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from calibration.fit import Fit, fit
from calibration.residuals import Measures
from calibration.tournament import SCORED, Score
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem
from contactlaws.files import write_atomically
from contactlaws.material import Material

FORMAT = "fe2dem law scores 1"
SHIPPED = Path(__file__).with_name("data") / "tradeoff_law.parquet"
#: of a score, in the table; the error is absolute
COLUMNS = ("law", "modulus_over_yield_stress", "poissons_ratio", "overlap_over_radius")


class LawScores(NamedTuple):
    """What was measured: scores by law, and what a contact costs."""

    scores: tuple[Score, ...]  # their `entrant` is the name of the law
    nanoseconds: Mapping[str, float]  # of one contact in one step of a scene while loading, by law
    code: str  # which code measured it


class Candidate(NamedTuple):
    """A law with its measured error."""

    law: str
    nanoseconds: float
    error: float  # the worst on the curves that count; infinite if it could not be fitted to one of them, or says nothing


class Trial(NamedTuple):
    """A law that was fitted, and whether it was good enough."""

    law: str
    nanoseconds: float
    error: float | None  # None: not fitted, or it has no such quantity
    reason: str | None  # why there is no error


class Choice(NamedTuple):
    """The fit that was taken, and all that were tried, from the cheapest on."""

    fit: Fit
    trials: tuple[Trial, ...]


def save(path: Path, scores: Iterable[Score], nanoseconds: Mapping[str, float], code: str) -> Path:
    """Write a table of scores (Parquet); each score's `entrant` must be the law's name."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = list(scores)
    columns = {name: pa.array([getattr(row, name) for row in rows], pa.string() if name == "law" else pa.float32()) for name in COLUMNS}
    columns |= {name: pa.array([_size(getattr(row, name)) for row in rows], pa.float32()) for name in SCORED}
    facts = {"format": FORMAT, "nanoseconds": json.dumps(dict(nanoseconds)), "code": code}
    table = pa.table(columns).replace_schema_metadata(facts)
    return write_atomically(path, lambda file: pq.write_table(table, file, compression="zstd", use_dictionary=["law"]))


def _size(value: float | None) -> float | None:
    return None if value is None else abs(value)


@functools.cache
def shipped(path: Path = SHIPPED) -> LawScores:
    """The table that comes with the package, or another one; raises `InputError` if it cannot be read."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(path).read()
        facts = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
        if facts.get("format") != FORMAT:
            raise ValueError("is no table of law scores")
        missing = dict.fromkeys(Score._fields)
        scores = tuple(Score(**{**missing, **row, "entrant": row["law"]}) for row in table.to_pylist())
        return LawScores(scores, json.loads(facts["nanoseconds"]), facts["code"])
    except (OSError, pa.ArrowException, ValueError, TypeError, KeyError) as error:
        remedy = "make it again with fe2dem tournament and fe2dem tradeoff law --save-scores"
        raise InputError(Problem(str(path), str(error).splitlines()[0], "cannot be read", remedy)) from error


def candidates(quantity: str, material: Material, largest_overlap: float, table: LawScores | None = None) -> list[Candidate]:
    """All laws of the table from the cheapest on, with their worst error on the curves around `material`, up to `largest_overlap`.

    Around: the nearest moduli over yield stress and Poisson's ratios on both sides, so up to four curves. largest_overlap: over the radius;
    scores up to the next larger one count. Raises `InputError` for an unknown quantity, a material outside the curves, or one that never
    yields.
    """
    known = shipped() if table is None else table
    if quantity not in SCORED:
        raise InputError(Problem("quantity", quantity, f"must be one of {', '.join(SCORED)}", "choose one"))
    counted = _around(known.scores, material, largest_overlap)
    errors: dict[str, list[float]] = {name: [] for name in known.nanoseconds}
    for score in counted:
        value = getattr(score, quantity)
        errors[score.entrant].append(math.inf if value is None else abs(value))
    points = len({(s.modulus_over_yield_stress, s.poissons_ratio, s.overlap_over_radius) for s in counted})
    found = [
        Candidate(name, known.nanoseconds[name], max(values) if len(values) == points else math.inf) for name, values in errors.items()
    ]
    return sorted(found, key=lambda candidate: candidate.nanoseconds)


def _around(scores: Sequence[Score], material: Material, largest_overlap: float) -> list[Score]:
    if material.yield_stress is None:
        raise InputError(Problem("yield_stress", None, "is needed: laws were scored on plastic materials", "name a law"))
    ratios = _neighbours((s.modulus_over_yield_stress for s in scores), material.youngs_modulus / material.yield_stress, "E/Y")
    nus = _neighbours((s.poissons_ratio for s in scores), material.poissons_ratio, "Poisson's ratio")
    overlaps = np.unique([s.overlap_over_radius for s in scores])
    if largest_overlap > overlaps[-1] * (1.0 + 1e-6):
        bound = f"laws were scored up to an overlap of {overlaps[-1]:g} of the radius"
        raise InputError(Problem("largest overlap", largest_overlap, bound, "ask for less, or name a law"))
    last = overlaps[np.searchsorted(overlaps, largest_overlap * (1.0 - 1e-6))]
    return [s for s in scores if s.modulus_over_yield_stress in ratios and s.poissons_ratio in nus and s.overlap_over_radius <= last]


def _neighbours(known: Iterable[float | None], value: float, name: str) -> set[float]:
    """The nearest values on both sides; the value itself if it is there."""
    values = np.unique([one for one in known if one is not None])
    if not values[0] * (1.0 - 1e-6) <= value <= values[-1] * (1.0 + 1e-6):
        bound = f"laws were scored from {values[0]:g} to {values[-1]:g}"
        raise InputError(Problem(name, value, bound, "name a law"))
    close = values[np.isclose(values, value, rtol=1e-6)]
    if close.size:
        return set(close.tolist())
    place = int(np.searchsorted(values, value))
    return {float(values[place - 1]), float(values[place])}


def good_enough(found: Sequence[Candidate], tolerance: float, quantity: str) -> list[Candidate]:
    """Those of the candidates that keep the tolerance; raises `InputError` that names the best if none does."""
    if not tolerance > 0.0:
        raise InputError(Problem("tolerance", tolerance, "must be above 0", "0.01 is 1 %"))
    good = [candidate for candidate in found if candidate.error <= tolerance]
    if not good:
        best = min(found, key=lambda candidate: candidate.error)
        raise InputError(_nothing(tolerance, quantity, best.law, best.error))
    return good


def _nothing(tolerance: float, quantity: str, law: str, error: float) -> Problem:
    bound = f"no law is that good in {quantity.replace('_', ' ')}: the best, {law}, is at {error:.3g}"
    return Problem("tolerance", tolerance, bound, "ask for less, or for smaller overlaps")


def fit_within(
    curves: Sequence[Curve],
    tolerance: float,
    quantity: str = "force",
    table: LawScores | None = None,
    progress: Callable[[float, str], None] = lambda fraction, text: None,
    also: tuple[str, ...] = (),
) -> Choice:
    """Fit laws to curves, from the cheapest on, until one differs from them by no more than `tolerance` in `quantity`.

    quantity: one of `calibration.residuals.Measures`; `also`: others that must keep the tolerance where the curves have them. Raises
    `InputError` that names the best if none does.
    """
    if quantity not in Measures._fields:
        raise InputError(Problem("quantity", quantity, f"must be one of {', '.join(Measures._fields)}", "choose one"))
    if not tolerance > 0.0:
        raise InputError(Problem("tolerance", tolerance, "must be above 0", "0.01 is 1 %"))
    if any(curve.in_time for curve in curves):
        bound = "leaves nothing to choose: a curve in time is for laws with relaxation times"
        raise InputError(Problem("tolerance", tolerance, bound, "name the law: maxwell_zener_ting"))
    order = sorted((shipped() if table is None else table).nanoseconds.items(), key=lambda item: item[1])
    trials: list[Trial] = []
    for number, (law, nanoseconds) in enumerate(order):
        progress(number / len(order), law)
        found, reason = _tried(curves, law)
        error = None if found is None else getattr(found.residuals, quantity)
        if found is not None and error is not None:
            error = max([error, *(getattr(found.residuals, name) or 0.0 for name in also)])
        if found is not None and error is None:
            reason = f"the law or the curves say nothing of the {quantity.replace('_', ' ')}"
        trials.append(Trial(law, nanoseconds, error, reason))
        if found is not None and error is not None and error <= tolerance:
            return Choice(found, tuple(trials))
    measured = [trial for trial in trials if trial.error is not None]
    if not measured:
        reasons = "; ".join(f"{trial.law}: {trial.reason}" for trial in trials)
        raise InputError(Problem("tolerance", tolerance, f"no law can be fitted: {reasons}", "name a law to see more"))
    best = min(measured, key=lambda trial: trial.error or 0.0)
    raise InputError(_nothing(tolerance, quantity, best.law, best.error or 0.0))


def _tried(curves: Sequence[Curve], law: str) -> tuple[Any, str | None]:
    try:
        with np.errstate(all="ignore"):  # a law that does not suit the curves may leave the range of numbers
            return fit(curves, law=law), None
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        return None, str(error)
