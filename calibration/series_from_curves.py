"""From curves in time to the reduced modulus of their body as a Prony series, with as many terms as the curves support."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration import force_errors
from calibration.contact_history import Growing, Path, Whole, growing_part, path_of
from calibration.prony_outcome import candidates_of, inverse, left_over, left_vectors, of_modulus, tidied
from calibration.prony_record import SeriesFit
from calibration.prony_search import SMALLEST, Found, grid, most_terms, search, spectrum, unknowns
from contactlaws.curve import Curve
from contactlaws.errors import Problem, require
from contactlaws.maxwell_zener import MaxwellZener, maxwell_zener
from contactlaws.maxwell_zener_ting import MaxwellZenerTing, maxwell_zener_ting
from contactlaws.prony import Relaxation

FloatArray = npt.NDArray[np.float64]

#: rounds until the weights of measured forces fit the scatter they show
ROUNDS = 3
#: forces that a fit needs: one term has three unknowns, and their scatter must show
FEWEST = 5


@dataclass(frozen=True)
class ForceFit(SeriesFit):
    """The series of the reduced modulus that explains the force of curves."""

    law: MaxwellZener | MaxwellZenerTing
    curves: tuple[Curve, ...]  # what was fitted to: of a law that knows growing contacts only, these parts
    condition_number: float  # of the Jacobian by moduli and logarithms of times, columns of unit length


def fit_series(curves: Sequence[Curve], shrinking: bool = True, poissons_ratio: float | None = None, terms: int | None = None) -> ForceFit:
    """Fit E*(t) to all curves together; its number of terms is the one of smallest BIC, or `terms`.

    shrinking: the contact may shrink, and the law is `maxwell_zener_ting`; else the curves count up to where it first does, and the law is
    `maxwell_zener`. poissons_ratio: of the finite-size factors; None: Hertz's half-space. The curves must be of one body, and checked.

    Where every curve states the error of its force, differences are measured by that, and standard errors are those of an error which is
    correlated along a curve: more rows do not make them smaller. Else the scatter of the forces takes its place, independent from row to
    row. Errors are wider where the law misses the curves by more. They don't cover that the number of terms was chosen.

    Raises `InputError` for curves with too few rows, and for more terms than they have rows for.
    """
    used = tuple(curves) if shrinking else tuple(growing_part(curve) for curve in curves)
    paths = tuple(path_of(curve) for curve in used)
    window = min(path.window[0] for path in paths), max(path.window[1] for path in paths)
    target = _target(used, paths, shrinking, poissons_ratio)
    require(_problems(target, terms))
    noise = _stated(used, paths) if force_errors.all_state_errors(used) else _shown(target, window)
    target = replace(target, scale=noise.scale)
    found = search(target, window, terms)
    level, words, origin = _level(found, target, noise)
    candidates = candidates_of(found, level, target.count)
    asked = min(candidates, key=lambda one: one.bic).terms if terms is None else terms
    chosen = tidied(found[asked])
    freedom = target.count - unknowns(chosen.times.size)
    misfit = math.sqrt(chosen.squares / freedom) / level
    modulus, change = of_modulus(chosen)
    jacobian = target.slopes(chosen.amplitudes, chosen.times)
    half = change @ inverse(jacobian)
    shared = force_errors.inherited(paths, left_vectors(jacobian)) if noise.stated else np.eye(half.shape[1])
    return ForceFit(
        modulus=modulus,
        covariance=(level * max(1.0, misfit)) ** 2 * half @ shared @ half.T,
        candidates=candidates,
        scatter=words,
        noise_from=origin,
        misfit=misfit,
        freedom=freedom,
        asked=asked,
        window=window,
        source="curves",
        law=_law(modulus, used[0].radius, poissons_ratio, shrinking),
        curves=used,
        condition_number=float(np.linalg.cond(jacobian / np.linalg.norm(jacobian, axis=0))),
    )


class Noise(NamedTuple):
    """What each force may be off by."""

    scale: FloatArray  # N
    stated: bool  # by the curves; else it is what their scatter is like, up to a factor
    even: float  # the part that all rows have, N
    relative: float  # the part that is in proportion to the force


def _stated(curves: Sequence[Curve], paths: Sequence[Path]) -> Noise:
    scale = np.concatenate([force_errors.stated(curve, path) for curve, path in zip(curves, paths, strict=True)])
    return Noise(scale, True, 0.0, max(curve.errors["force"] for curve in curves))


def _shown(target: Growing, window: tuple[float, float]) -> Noise:
    """From what the best series on the grid of times leaves over; its weights follow from that, so a few rounds are needed."""
    times, scale = grid(window), np.full(target.scale.size, float(abs(target.force).max()))
    noise = Noise(scale, False, 0.0, 0.0)
    for _ in range(ROUNDS):
        weighted = replace(target, scale=noise.scale)
        amplitudes, _ = spectrum(weighted, times)
        kept = amplitudes[1:] > 0.0
        lines = np.array([max(amplitudes[0], SMALLEST * target.size), *amplitudes[1:][kept]])
        differences = weighted.misses(lines, times[kept]) * noise.scale
        sizes, parts = force_errors.scatter(differences, target.force + differences)
        noise = Noise(sizes, False, *parts)
    return noise


def _level(found: Sequence[Found], target: Growing, noise: Noise) -> tuple[float, str, str]:
    """What the scale is to be multiplied by to be the noise; the noise in words, and how it is known."""
    if noise.stated:
        return 1.0, f"{100.0 * noise.relative:.3g} % of the largest force so far", "stated by the curves, and common to the rows of each"
    level, origin = left_over(found, target.count)
    least = force_errors.TRUEST * float(abs(target.force).max() / np.median(target.scale))
    if level < least:
        return least, f"{100.0 * force_errors.TRUEST:.3g} % of the largest force", "they scatter by less, but no law is truer"
    return level, f"{level * noise.even:.3g} N and {100.0 * level * noise.relative:.3g} % of the force", origin


def _target(curves: Sequence[Curve], paths: tuple[Path, ...], shrinking: bool, poissons_ratio: float | None) -> Growing:
    unit, radius = Relaxation(1.0), curves[0].radius
    scale = np.ones(sum(path.force.size for path in paths))
    body = maxwell_zener(unit, radius, poissons_ratio)
    return Whole(paths, body, scale, maxwell_zener_ting(unit, radius, poissons_ratio)) if shrinking else Growing(paths, body, scale)


def _law(modulus: Relaxation, radius: float, poissons_ratio: float | None, shrinking: bool) -> MaxwellZener | MaxwellZenerTing:
    return (maxwell_zener_ting if shrinking else maxwell_zener)(modulus, radius, poissons_ratio)


def _problems(target: Growing, terms: int | None) -> Iterator[Problem]:
    if target.count < FEWEST:
        yield Problem("curves", f"{target.count} rows in contact", f"a series needs at least {FEWEST}", "measure more of them")
    elif not target.grows.any():
        yield Problem("curves", "no row", "must grow from the touch on", "let a curve begin where the flat touches the body")
    if terms is not None and not 0 <= terms <= most_terms(target.count):
        bound = f"must lie between 0 and {most_terms(target.count)} for {target.count} forces"
        yield Problem("terms", terms, bound, "ask for fewer, or leave it out")
