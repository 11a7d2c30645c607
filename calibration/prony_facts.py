"""What a file that holds a fitted Prony series says of its fit."""

from __future__ import annotations

from typing import Any

import numpy as np

from calibration.prony_doubts import doubts
from calibration.prony_record import SeriesFit


def facts_of(found: SeriesFit) -> dict[str, Any]:
    """As JSON types: the numbers with their errors, the candidates, the doubts."""
    return {
        "fit": {
            "values": dict(zip(found.names, found.values.tolist(), strict=True)),
            "standard_errors": dict(found.standard_errors),
            "correlation": np.round(found.correlation, 6).tolist(),
            "scatter": found.scatter,
            "noise_from": found.noise_from,
            "misfit": found.misfit,
            "window": list(found.window),
        },
        "candidates": [one._asdict() for one in found.candidates],
        "warnings": list(doubts(found)),
    }
