"""Published contact laws to be measured against, each as its authors wrote it, one file a law.

Where a published law jumps, or gives back more energy than it took, it does so here too: `FLAWS` names the checks of `contactlaws.checks`
that it fails for that, and why. Nothing is mended silently.
"""

from collections.abc import Mapping

from contactlaws.rivals import becker_kamlah, eepa, etsion, jackson_green, kogut_etsion, luding, mdr, walton_braun

__all__ = ["FLAWS", "becker_kamlah", "eepa", "etsion", "jackson_green", "kogut_etsion", "luding", "mdr", "walton_braun"]

_POWERS = "its two powers of the overlap do not meet: the force jumps by 3 % at first yield and by 1.7 % at six times that overlap"
_GAIN = "its force exceeds Hertz's up to 1.48 times the overlap of first yield: who turns back there gets up to 3 % more than was put in"
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
}
