"""The section of the page on Eq. 3: its errors and its constants, for three readings of the overlap at first yield."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cases.edmans_sinka_2020 import paper
from cases.edmans_sinka_2020.refit import RESAMPLES, Refit
from cases.edmans_sinka_2020.tables import Row
from cases.edmans_sinka_2020.wording import Block, percents, table, text
from contactlaws.edmans_sinka import PUBLISHED

MADE_SMALL = {"absolute": "|ρ − ρ_FE|", "logarithm": "|ln ρ/ρ_FE|", "logarithm squared": "(ln ρ/ρ_FE)²"}


def blocks(refits: Sequence[Refit], errors: Sequence[Row]) -> Iterator[Block]:
    """Words, errors, constants."""
    yield text(
        "Eq. 3 needs the overlap at first yield, Eq. 5, which has three readings: corrected (K = 0.454 + 0.41ν, as Chang, Etsion & Bogy "
        "have it), printed (its two coefficients exchanged), and unsquared (printed, without the square on the numerator; the only one "
        "that gives the 366 that section 4.5 quotes). The published constants belong to one of the first two: with the third their "
        "errors are about twice the published ones. Fitted again, the third reading is as good as the others, with a γ_5 of a sixth."
    )
    yield text("Absolute relative errors of ρ in per cent at the 50/75/90/100th percentile (in brackets: number of unloadings):")
    sets = {row["unloadings"]: row["count"] for row in errors}
    yield table(("Eq. 5", "constants", *(f"{name} ({count})" for name, count in sets.items())), list(_errors(errors, list(sets))))
    yield text(
        f"Constants fitted again, with standard errors from {RESAMPLES} draws of as many materials with replacement (errors are common to "
        "a curve, so its unloadings are drawn together). Made small is the sum over all unloadings of |ρ − ρ_FE| as in the paper, of |ln "
        "ρ/ρ_FE|, or of its square."
    )
    yield table(("Eq. 5", "made small", *(f"γ_{i}" for i in range(1, 6))), list(_constants(refits)))


def _errors(errors: Sequence[Row], sets: Sequence[str]) -> Iterator[tuple[str, ...]]:
    yield "paper's own", "paper", percents(paper.ERRORS_OF_EQUATION_3), *[""] * (len(sets) - 1)
    for reading, constants in dict.fromkeys((row["first_yield"], row["constants"]) for row in errors):
        here = {row["unloadings"]: row for row in errors if (row["first_yield"], row["constants"]) == (reading, constants)}
        found = (percents([here[name][f"error_{p}th_percentile"] for p in paper.PERCENTILES]) for name in sets)
        yield reading, MADE_SMALL.get(constants, str(constants)), *found


def _constants(refits: Sequence[Refit]) -> Iterator[tuple[str, ...]]:
    yield "paper (Table 1)", MADE_SMALL["absolute"], *(f"{value:.4f}" for value in PUBLISHED)
    for found in refits:
        values = zip(found.gammas, found.standard_errors, strict=True)
        yield found.reading, MADE_SMALL[found.measure], *(f"{gamma:.4f} ± {error:.4f}" for gamma, error in values)
