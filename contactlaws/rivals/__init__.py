"""Published contact laws to be measured against, each as its authors wrote it, one file a law.

Where a published law jumps, or gives back more energy than it took, it does so here too: `contactlaws.flaws` names the checks that it
fails for that, and why. Nothing is mended silently.
"""

from contactlaws.rivals import (
    becker_kamlah,
    eepa,
    etsion,
    hertz_spring_dashpot,
    jackson_green,
    kogut_etsion,
    kuwabara_kono,
    luding,
    mdr,
    wahn_gan_kamlah,
    walton_braun,
)

__all__ = [
    "becker_kamlah",
    "eepa",
    "etsion",
    "hertz_spring_dashpot",
    "jackson_green",
    "kogut_etsion",
    "kuwabara_kono",
    "luding",
    "mdr",
    "wahn_gan_kamlah",
    "walton_braun",
]
