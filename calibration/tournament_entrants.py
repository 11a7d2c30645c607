"""Who enters the tournament of laws: each law with what is fitted, over which part of the curve, and the range that its authors claim."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from calibration.recipes import recipe_for
from contactlaws import dispatch
from contactlaws.curve import Curve
from contactlaws.errors import InputError, Problem
from contactlaws.path import trace
from contactlaws.rivals import becker_kamlah, etsion, jackson_green, kogut_etsion, mdr
from contactlaws.whole_range_record import Constants

#: law record, curve, overlap (m) -> whether the authors claim that their law holds there
Inside = Callable[[Any, Curve, float], bool]


def _everywhere(law: Any, curve: Curve, overlap: float) -> bool:
    return True


@dataclass(frozen=True)
class Entrant:
    """One row of the tournament."""

    name: str
    law: str  # as registered
    how: str  # how it was fitted to each curve, in words
    claim: str = "none stated"  # range in the authors' words
    inside: Inside = _everywhere
    universal: int | None = None  # constants that hold for all materials; None: not known here
    free: tuple[str, ...] = ()  # fitted although the material gives it
    fixed: Mapping[str, float] = field(default_factory=dict)  # held although the recipe would fit it
    weights: Mapping[str, float] = field(default_factory=dict)  # as in `calibration.fit`
    deepest: float | None = None  # overlap over radius up to which the curve is fitted; None: all of it


def _elastic(law: Any, curve: Curve, overlap: float) -> bool:
    """Hertz: before first yield, and the contact small against the body."""
    return (curve.yield_overlap is None or overlap <= curve.yield_overlap) and overlap <= 0.01 * curve.radius


def _kogut_etsion(law: Any, curve: Curve, overlap: float) -> bool:
    return bool(overlap <= kogut_etsion.LAST * kogut_etsion.kogut_etsion_critical(law))


def _etsion(law: Any, curve: Curve, overlap: float) -> bool:
    return bool(overlap <= etsion.LAST * kogut_etsion.kogut_etsion_critical(law))


def _jackson_green(law: Any, curve: Curve, overlap: float) -> bool:
    return bool(trace(law, [overlap]).contact_radius[0] <= jackson_green.LARGEST_RADIUS * law.radius)


def _small_contact(law: Any, curve: Curve, overlap: float) -> bool:
    return overlap <= 0.01 * curve.radius


def _becker_kamlah(law: Any, curve: Curve, overlap: float) -> bool:
    return overlap <= becker_kamlah.LAST * curve.radius * (1.0 + 1e-9)


def _one_material(law: Any, curve: Curve, overlap: float) -> bool:
    """NMC has E/Y = 18."""
    strength = None if curve.material is None else curve.material.yield_stress
    if curve.material is None or strength is None:
        return False
    return _becker_kamlah(law, curve, overlap) and 10.0 <= curve.material.youngs_modulus / strength <= 35.0


def _mdr(law: Any, curve: Curve, overlap: float) -> bool:
    return overlap <= mdr.LAST * curve.radius


def _edmans_sinka(law: Any, curve: Curve, overlap: float) -> bool:
    stiffness = law.reduced_modulus * (1.0 - law.poissons_ratio**2) / law.yield_stress
    return 1.0 - 1e-9 <= stiffness <= 1000.0 * (1.0 + 1e-9) and 0.01 - 1e-9 <= overlap / curve.radius <= 0.5 + 1e-9


def _whole_range(law: Any, curve: Curve, overlap: float) -> bool:
    return 0.01 - 1e-9 <= overlap / curve.radius <= 0.5 + 1e-9


_MATERIAL = "nothing fitted: all from E, ν, Y"
_STRENGTH = "Y fitted as an effective one, to the whole curve"
_WHOLE = "fitted to the whole curve"

#: in the order of the table
ENTRANTS: tuple[Entrant, ...] = (
    Entrant("Hertz", "hertz", "nothing fitted: from E, ν", "elastic, a/R < 0.1", _elastic, 0),
    Entrant("Thornton", "thornton", f"limiting pressure {_WHOLE}", "small contacts, taken as a/R < 0.1", _small_contact, 0),
    Entrant("Kogut–Etsion", "kogut_etsion", _MATERIAL, "δ/δ_c ≤ 110", _kogut_etsion, 11),
    Entrant("Kogut–Etsion, Y fitted", "kogut_etsion", _STRENGTH, "δ/δ_c ≤ 110", _kogut_etsion, 11, ("yield_stress",)),
    Entrant("Etsion et al.", "etsion", _MATERIAL, "δ/δ_c ≤ 170", _etsion, 15),
    Entrant("Etsion et al., Y fitted", "etsion", _STRENGTH, "δ/δ_c ≤ 170", _etsion, 15, ("yield_stress",)),
    Entrant("Jackson–Green", "jackson_green", _MATERIAL, "a/R ≤ 0.41", _jackson_green, 11),
    Entrant("Jackson–Green, Y fitted", "jackson_green", _STRENGTH, "a/R ≤ 0.41", _jackson_green, 11, ("yield_stress",)),
    Entrant("Walton–Braun", "walton_braun", f"k1, k2/k1 and its growth {_WHOLE}", universal=0),
    Entrant("Luding", "luding", f"k1, k_p/k1 and δ* {_WHOLE}", universal=0),
    Entrant("EEPA", "eepa", f"k1, k2/k1 and the exponent {_WHOLE}", universal=0),
    Entrant(
        "Becker–Kamlah, published",
        "becker_kamlah",
        "nothing fitted: constants of Eq. 54 for equal spheres",
        "E/Y = 18 (taken as 10 to 35), δ/R ≤ 0.15",
        _one_material,
        7,
        fixed=becker_kamlah.PUBLISHED,
    ),
    Entrant(
        "Becker–Kamlah",
        "becker_kamlah",
        "λ_max, ε_max fitted to the force up to δ/R = 0.15 (n = 1.8)",
        "δ/R ≤ 0.15",
        _becker_kamlah,
        2,
        fixed={"exponent": becker_kamlah.PUBLISHED["exponent"]},
        weights={"contact_radius": 0.0, "unloading": 0.0},
        deepest=becker_kamlah.LAST,
    ),
    Entrant("MDR", "mdr", _MATERIAL, "δ/R ≤ 0.75", _mdr, 2),
    Entrant("MDR, Y fitted", "mdr", _STRENGTH, "δ/R ≤ 0.75", _mdr, 2, ("yield_stress",)),
    Entrant(
        "Edmans–Sinka",
        "edmans_sinka",
        "loading, contact area and exponent fitted to the whole curve; ρ as published (Eqs. 3 to 5, K corrected)",
        "1 ≤ E/Y ≤ 1000, 0.01 ≤ δ/R ≤ 0.5",
        _edmans_sinka,
        8,
    ),
    Entrant(
        "whole range",
        "whole_range",
        "nothing fitted: all from E, ν, Y, with constants fitted once to the study's curves",
        "1 ≤ E/Y, 0.01 ≤ δ/R ≤ 0.5",
        _whole_range,
        len(Constants._fields),
    ),
    Entrant("tabulated", "tabulated", "made of the curve without every second unloading; its loading is the curve's own", universal=0),
)


def entrants(names: Iterable[str] | None = None) -> tuple[Entrant, ...]:
    """The entrants of the named laws, or of all that can be fitted; a registered law that is not listed here enters as its recipe says.

    Raises `InputError` for names that are no fittable law.
    """
    listed = {entrant.law for entrant in ENTRANTS}
    known = [name for name in dispatch.laws() if _is_fittable(name)]
    unlisted = [name for name in known if name not in listed and name != "hertz_finite_size"]
    field_of = (
        *(entrant for entrant in ENTRANTS if entrant.law in known),
        *(Entrant(name.replace("_", " "), name, "as its recipe says, to the whole curve") for name in unlisted),
    )
    if names is None:
        return field_of
    wanted = list(names)
    unknown = [name for name in wanted if name not in known]
    if unknown:
        raise InputError(Problem("--laws", name, f"must be one of {', '.join(known)}", "choose among these") for name in unknown)
    return tuple(entrant for entrant in field_of if entrant.law in wanted) + tuple(
        Entrant(name.replace("_", " "), name, "as its recipe says, to the whole curve") for name in wanted if name == "hertz_finite_size"
    )


def _is_fittable(name: str) -> bool:
    """To the tournament's curves, which know no time."""
    try:
        recipe_for(name)
    except InputError:
        return False
    return not dispatch.laws()[name].in_time


def constants_of(law: Any, free: int) -> int:
    """Numbers that belong to one material: what was fitted, or the entries of a table."""
    tables = [value for value in law if hasattr(value, "size") and not isinstance(value, float)]
    return free + int(sum(math.prod(table.shape) for table in tables))
