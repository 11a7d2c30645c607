"""Which checks of `contactlaws.checks` a law fails because its own mathematics break them, and why: laws are kept as they are published."""

from __future__ import annotations

from collections.abc import Mapping

_POWERS = "its two powers of the overlap do not meet: the force jumps by 3 % at first yield and by 1.7 % at six times that overlap"
_GAIN = "its force exceeds Hertz's up to 1.48 times the overlap of first yield: who turns back there gets up to 3 % more than was put in"
_RETREAT = "while the contact shrinks, it counts dampers as if it grew: in the end more than was put in, set right when it opens"
#: law: failed check: reason
FLAWS: Mapping[str, Mapping[str, str]] = {
    "kogut_etsion": {
        "loading is continuous": _POWERS,
        "stiffness bound holds": "a jump has no stiffness: " + _POWERS,
        "dissipation never falls": _GAIN,
        "no energy from a closed path": _GAIN,
    },
    "etsion": {
        "loading is continuous": _POWERS,
        "stiffness bound holds": "a jump has no stiffness: " + _POWERS,
        "dissipation never falls": _GAIN,
        "no energy from a closed path": _GAIN,
    },
    "jackson_green": {
        "loading is continuous": "the force jumps by half a per cent from Hertz's to the fit, at 1.9 times the overlap of first yield",
        "stiffness bound holds": "a jump has no stiffness",
        "dissipation never falls": "the force that jumps up takes with it what can be got back",
    },
    "mdr": {
        "loading is continuous": "at first yield the force jumps from that of an ellipse to Hertz's, by 3 d_Y/(40 R)",
        "stiffness bound holds": "a jump has no stiffness",
    },
    "maxwell_zener": {"dissipation never falls": _RETREAT},
    "wahn_gan_kamlah": {
        "no tension": "nothing ends the contact before the overlap does: as it shrinks, the Maxwell branch pulls",
        "reloading returns to the loading": "increments of other steps add up to another force: it drifts",
        "dissipation never falls": "relaxing as if it had grown, a contact pulled and pressed again gives back more than it kept",
    },
    "hertz_spring_dashpot": {"no tension": "only with pull: the damper as published pulls at the end of a collision"},
}
