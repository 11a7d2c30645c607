"""How the viscoelastic laws are fitted: their reduced modulus as a Prony series, from curves in time (`calibration.series_from_curves`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from calibration.contact_history import growing_rows
from calibration.fit_record import Fit, problems_with_bodies, stops
from calibration.prony_doubts import doubts
from calibration.prony_facts import facts_of
from calibration.residuals_in_time import measures_in_time
from calibration.series_from_curves import ForceFit, fit_series
from contactlaws.curve import Curve
from contactlaws.errors import Problem, require
from contactlaws.fitted import FittedLaw

#: rows of growing contact that a curve needs to be one
FEWEST = 3


def fit_viscoelastic(
    curves: Sequence[Curve], law: str, fixed: Mapping[str, float], weights: Mapping[str, float], free: tuple[str, ...], terms: int | None
) -> Fit:
    """Fit one of `calibration.recipes.IN_TIME` to curves in time of one body; raises `InputError`.

    fixed: poissons_ratio, of the finite-size factors; without it that of the curves' material holds (the mean of its first and its last,
    where it changes), and Hertz's half-space where there is none.
    """
    require(_problems(curves, law, fixed, weights, free))
    ratio = fixed["poissons_ratio"] if "poissons_ratio" in fixed else poissons_ratio_of(curves[0])
    found = fit_series(curves, law == "maxwell_zener_ting", ratio, terms)
    names = tuple(name.replace("instantaneous", "reduced_modulus") for name in found.names)
    fitted = FittedLaw(
        law=found.law,
        max_overlap=max(float(curve.overlap.max()) for curve in found.curves),
        material=curves[0].material,
        curve_hashes=tuple(curve.content_hash for curve in curves),
        standard_errors={name: found.standard_errors[own] for name, own in zip(names, found.names, strict=True)},
        origin={"poissons_ratio": ratio, **facts_of(found)},
    )
    return Fit(
        fitted=fitted,
        free=names,
        correlation=found.correlation,
        condition_number=found.condition_number,
        misfit=found.misfit,
        residuals=measures_in_time(found.law, found.curves),
        warnings=(*doubts(found), *_remarks(curves, found, ratio), *stops(curves)),
        evaluations=None,
        series=found,
    )


def poissons_ratio_of(curve: Curve) -> float | None:
    """That of the curve's body, if it is known; where it changes, the mean of the instantaneous and the long-term one."""
    if curve.series is not None:
        return 0.5 * (curve.series.poissons_ratio + curve.series.long_term.poissons_ratio)
    return None if curve.material is None else curve.material.poissons_ratio


def _remarks(curves: Sequence[Curve], found: ForceFit, ratio: float | None) -> Iterator[str]:
    left_out = sum(whole.overlap.size - used.overlap.size for whole, used in zip(curves, found.curves, strict=True))
    if left_out:
        rows = sum(whole.overlap.size for whole in curves)
        yield f"{left_out} of {rows} rows are left out, where the contact has shrunk: maxwell_zener_ting is the law that knows them"
    if ratio is None:
        yield "no Poisson's ratio is known: the body counts as Hertz's half-space, and the modulus takes up what a finite sphere adds to it"


def _problems(
    curves: Sequence[Curve], law: str, fixed: Mapping[str, float], weights: Mapping[str, float], free: tuple[str, ...]
) -> Iterator[Problem]:
    if not curves:
        yield Problem("curves", 0, "a fit needs at least one", "give a curve")
        return
    for name, value in fixed.items():
        if name != "poissons_ratio":
            yield Problem(f"fixed[{name}]", value, f"of {law}, only poissons_ratio can be given", "drop it")
        elif not 0.0 <= value < 0.5:
            yield Problem("poissons_ratio", value, "must lie in [0, 0.5)", "0.4999 is nearly incompressible")
    for name in (*weights, *free):
        yield Problem(name, law, "has no weights, and is free in all its moduli and times alike", "leave it out")
    for number, curve in enumerate(curves):
        yield from _problems_with_curve(f"curves[{number}]", curve, law)
        if curve.series != curves[0].series:
            yield Problem(
                f"curves[{number}]", "another series", "its material relaxes otherwise than the first one's", "fit each on its own"
            )
    yield from problems_with_bodies(curves)


def _problems_with_curve(name: str, curve: Curve, law: str) -> Iterator[Problem]:
    if not curve.in_time:
        bound = f"{law} needs to know how fast the overlap changed"
        yield Problem(name, "a curve without time", bound, "give one in time, or fit a law without time, such as 'thornton'")
    if curve.aspect != 1.0:
        yield Problem(f"{name}: aspect", curve.aspect, f"must be 1: {law} describes a sphere", "fit a curve of a sphere")
    growing = slice(0, growing_rows(curve))
    touching = int((curve.overlap[growing] > 0.0).sum())
    if touching < FEWEST:
        bound = f"must have at least {FEWEST} rows in contact before it shrinks"
        yield Problem(f"{name}: overlap", f"{touching} rows", bound, "let it begin where the flat touches the body")
    elif not curve.force[growing].max() > 0.0:
        bound = "must be positive while the contact grows"
        yield Problem(f"{name}: force", float(curve.force[growing].max()), bound, "check its sign and zero: compression is positive")
