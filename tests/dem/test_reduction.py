"""What a scene leaves out against the same scene with it: the same where the physics is absent, within the bound where neglected."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.prony import Relaxation
from dem.packing import Packing, face_centred_cubic
from dem.reduction import overstress, relaxed

RADIUS, DENSITY = 5e-6, 4750.0
LAW = maxwell_zener(Relaxation(2175.3e6, (0.2285,), (1.8,)), RADIUS)


def squeezed(duration: float, **settings: object) -> dem.Trajectory:
    """A lattice, which nothing rearranges, pressed alike along all edges in `duration` (s)."""
    scene = dem.packed_scene(
        face_centred_cubic((1, 1, 1), RADIUS),
        DENSITY,
        dem.Contact(LAW),
        (dem.isotropic_compression(0.01, duration),),
        quasi_static=dem.QuasiStatic(strain_step=2e-4),
        outputs=2,
        frames=1,
        **settings,
    )
    return dem.run(scene)


@pytest.mark.parametrize("duration", [5e3, 1e-4])
def test_an_elastic_law_in_place_of_a_relaxing_one_keeps_its_bound(duration: float) -> None:
    elastic, full = squeezed(duration), squeezed(duration, carry=("history",))
    assert elastic.statistics["law"] == "hertz_finite_size"
    assert full.statistics["law"] == "maxwell_zener"
    bound = min(overstress(LAW, duration), relaxed(LAW, duration))
    assert bound < 1e-3
    assert elastic.pressure[-1] == pytest.approx(full.pressure[-1], rel=bound)
    assert abs(elastic.pressure[-1] / full.pressure[-1] - 1.0) > 0.05 * bound  # the bound is not idle either
    assert any("in place of the relaxing one" in note for note in elastic.notes)


def test_between_the_limits_the_law_stays() -> None:
    assert squeezed(2.0).statistics["law"] == "maxwell_zener"


def test_a_law_in_time_needs_a_time() -> None:
    with pytest.raises(InputError, match="needs the time"):
        squeezed(None)  # type: ignore[arg-type]


@pytest.mark.compiled_only(reason="ten runs of some thousand steps")
@pytest.mark.parametrize("part", ["radius", "mass", "rates", "rotation"])
def test_what_is_carried_for_nothing_changes_nothing(part: str, hertz: Hertz, shaken_crystal: Packing) -> None:
    """To round-off of another order of sums, which collisions amplify."""
    scene = dem.packed_scene(
        shaken_crystal, DENSITY, dem.Contact(hertz), dem.uniaxial_compression(0.02), inertial_number=5e-3, outputs=5, frames=1
    )
    plain, full = dem.run(scene), dem.run(dataclasses.replace(scene, carry=(part,)))
    np.testing.assert_allclose(full.stress, plain.stress, rtol=1e-7, atol=1e-9 * plain.stress.max())
    assert full.statistics["bytes_per_particle"] >= plain.statistics["bytes_per_particle"]
    assert len(full.notes) <= len(plain.notes)
