"""Published laws to be put through the checks of every law: records, and the largest overlap of each."""

from __future__ import annotations

from typing import Any

from contactlaws.material import Material
from contactlaws.prony import Relaxation
from contactlaws.rivals.becker_kamlah import PUBLISHED, BeckerKamlah
from contactlaws.rivals.eepa import Eepa
from contactlaws.rivals.etsion import Etsion
from contactlaws.rivals.hertz_spring_dashpot import hertz_spring_dashpot
from contactlaws.rivals.jackson_green import JacksonGreen
from contactlaws.rivals.kogut_etsion import KogutEtsion
from contactlaws.rivals.kuwabara_kono import kuwabara_kono
from contactlaws.rivals.luding import Luding
from contactlaws.rivals.mdr import mdr_of
from contactlaws.rivals.wahn_gan_kamlah import wahn_gan_kamlah
from contactlaws.rivals.walton_braun import WaltonBraun

NMC = Material(142e9, 0.25, 7.9e9)
HARD = Material(1000.0, 0.3, 1.0)
#: laws in time: relaxation times, and the time of a collision, are about a second
LIGHT = Material(910.0, 0.3, None, 1.0)
SLOW = Relaxation(1000.0, (0.5,), (1.0,))
_HARD = (1.0, HARD.reduced_modulus, 0.3, 1.0)

RIVALS: dict[str, list[tuple[Any, float]]] = {
    "kogut_etsion": [(KogutEtsion(*_HARD), 0.1)],
    "etsion": [(Etsion(*_HARD), 0.1)],
    "jackson_green": [(JacksonGreen(*_HARD), 0.08)],
    "walton_braun": [(WaltonBraun(1.0, 10.0, 4.0, 0.0), 0.3), (WaltonBraun(5e-6, 1e6, 1.5, 3e5), 5e-7)],
    "luding": [(Luding(1.0, 10.0, 5.0, 0.2), 0.3)],
    "eepa": [(Eepa(1.0, 10.0, 4.0, 1.5), 0.3)],
    "becker_kamlah": [
        (BeckerKamlah(5e-6, NMC.reduced_modulus, 7.9e9, **PUBLISHED), 5e-7),
        (BeckerKamlah(1.0, HARD.reduced_modulus, 1.0, 5.0, 12.0, 2.0), 0.1),
    ],
    "hertz_spring_dashpot": [(hertz_spring_dashpot(LIGHT, 1.0, e, pull), 0.1) for e, pull in ((0.5, False), (0.05, False), (0.5, True))],
    "kuwabara_kono": [(kuwabara_kono(SLOW, 1.0), 0.1)],
    "wahn_gan_kamlah": [(wahn_gan_kamlah(SLOW, 1.0), 0.1)],
    "mdr": [(mdr_of(1.0, 100.0, 0.3, 1.0), 0.5), (mdr_of(5e-6, 142e9, 0.25, 7.9e9), 2.5e-6)],
}
