"""The law of a contact, of spheres or of ellipsoids: what scenes ask of it before a kernel does."""

from __future__ import annotations

from contactlaws import dispatch, pair, shaped


def known_law(law: object) -> dispatch.Law | shaped.ShapedLaw:
    """The registered law of a record, of either kind; raises `InputError` if there is none."""
    return shaped.shaped_law_of(law) if shaped.is_shaped(law) else dispatch.law_of(law)


def in_time(law: object) -> bool:
    """Whether the force depends on how fast the overlap changes, or on how long it stays."""
    known = known_law(law)
    return isinstance(known, dispatch.Law) and known.in_time


def first_force(law: object, radius_1: float, radius_2: float, overlap: float) -> float:
    """Force in N of a pair that never touched before at `overlap` (m); of ellipsoids, of spheres of their mean radii."""
    if shaped.is_shaped(law):
        flat = 2.0 * radius_1 * radius_2 / (radius_1 + radius_2)
        return float(shaped.force(law, (flat, 1.0, flat), 0.5 * overlap, shaped.untouched(law))[0])
    state = dispatch.initial_state(law)
    return float(pair.pair_force(law, pair.pair_scale(law, radius_1, radius_2), overlap, 0.0, 0.0, state)[0])
