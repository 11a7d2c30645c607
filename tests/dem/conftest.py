"""Real sizes: spheres of NMC, 5 um, in SI units, so that nothing passes because numbers are near one."""

from __future__ import annotations

import numpy as np
import pytest

from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from dem.packing import Packing, face_centred_cubic

RADIUS, DENSITY, REDUCED_MODULUS = 5e-6, 4750.0, 142e9 / (1.0 - 0.25**2)


@pytest.fixture(scope="session")
def hertz() -> Hertz:
    return Hertz(RADIUS, REDUCED_MODULUS)


@pytest.fixture(scope="session")
def soft_plastic() -> Thornton:
    """Yields at an overlap of 2.5e-5 R, so that everything below is plastic."""
    return Thornton(RADIUS, REDUCED_MODULUS, REDUCED_MODULUS / 314.0)


@pytest.fixture(scope="session")
def shaken_crystal() -> Packing:
    """32 spheres of a face-centred lattice, 1 % apart and moved at random by less than that: compressed, they rearrange."""
    crystal = face_centred_cubic((2, 2, 2), RADIUS)
    edge = crystal.box.lengths[0] * 1.01
    moved = crystal.position * 1.01 + np.random.default_rng(0).uniform(-0.004, 0.004, crystal.position.shape) * RADIUS
    return crystal._replace(position=moved, box=crystal.box._replace(lengths=(edge, edge, edge)))
