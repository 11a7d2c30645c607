"""What a scene cannot do is refused, and what went otherwise than asked for is told."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.hertz_ellipse import HertzEllipse
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.prony import Relaxation
from contactlaws.whole_range_ellipsoid import whole_range_ellipsoid
from dem.packing import Packing, face_centred_cubic
from dem.probes import moduli
from dem.scene import QuasiStatic
from tests.dem.scenes import DENSITY, RADIUS

NMC = Material(142e9, 0.25, 7.9e9)


def scene(hertz: Hertz, *programme: dem.Stage, **settings: object) -> dem.Scene:
    """A lattice that touches."""
    contact = dem.Contact(hertz, fitted_overlap=settings.pop("fitted_overlap", None))  # type: ignore[arg-type]
    return dem.packed_scene(face_centred_cubic((2, 2, 2), RADIUS), DENSITY, contact, programme, **settings)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"moving_walls": 0.5}, "moving_walls"),
        ({"quasi_static": QuasiStatic(strain_step=0.0)}, "strain_step"),
        ({"quasi_static": QuasiStatic(strain_step=float("nan"))}, "strain_step"),
        ({"quasi_static": QuasiStatic(method="fir")}, "method"),
        ({"quasi_static": QuasiStatic(most=0)}, "most"),
        ({"outputs": 2.5}, "outputs"),
        ({"between": ((0, 7, dem.Contact(Hertz(RADIUS, 1e9))),)}, "between"),
        ({"fitted_overlap": -1.0}, "fitted_overlap"),
    ],
)
def test_settings_that_would_do_nothing_or_harm_are_refused(hertz: Hertz, settings: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        dem.run(scene(hertz, dem.isotropic_compression(0.01), **settings))


def test_scaled_masses_that_save_nothing(hertz: Hertz) -> None:
    """Steps and the time that the inertial number gives grow alike; with a duration there are fewer steps."""
    free, timed = (scene(hertz, dem.isotropic_compression(0.01, duration), outputs=2) for duration in (None, 1e-7))
    heavy = [dem.run(dataclasses.replace(made, density_scaling=100.0)) for made in (free, timed)]
    assert any("saves nothing" in text for text in heavy[0].warnings)
    assert not any("saves nothing" in text for text in heavy[1].warnings)
    assert heavy[1].statistics["steps"] < 0.2 * dem.run(timed).statistics["steps"]


@pytest.mark.compiled_only(reason="thousands of steps")
def test_a_stress_that_is_not_reached_is_told(hertz: Hertz, shaken_crystal: Packing) -> None:
    pressure = 1e-3 * hertz.reduced_modulus
    for duration, told in ((1e-9, True), (None, False)):
        stages = (dem.confined(pressure, duration), dem.confined(pressure, duration))
        run = dem.run(dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), stages, outputs=5, inertial_number=2e-3))
        assert any("in place of" in text for text in run.warnings) == told


def test_a_contact_beyond_its_range_between_outputs_is_told(hertz: Hertz) -> None:
    """Two spheres that have met and parted again by the next output."""
    bodies = dem.spheres([[0.0, 0.0, 0.0], [2.1 * RADIUS, 0.0, 0.0]], RADIUS, DENSITY, [[50.0, 0.0, 0.0], [-50.0, 0.0, 0.0]])
    contact = dem.Contact(hertz, fitted_overlap=1e-3)
    run = dem.run(dem.Scene(bodies, dem.Box((40.0 * RADIUS,) * 3), contact, (dem.hold(1e-6),), outputs=1))
    assert run.statistics["largest_overlap"] > 1e-3
    assert not run.contacts_beyond.any()
    assert any("between outputs" in text for text in run.warnings)


def test_stress_that_comes_late_is_held_against_the_bound_of_the_long_term_law() -> None:
    """A lattice with gaps, pressed as slowly as the bound asks of one without: contacts grow in the last tenth of the way."""
    law = maxwell_zener(Relaxation(1e9, (0.5,), (1.0,)), RADIUS)
    lattice = face_centred_cubic((1, 1, 1), RADIUS)
    for gap, late in ((0.0, False), (0.018, True)):
        bodies = dem.spheres(lattice.position * (1.0 + gap), RADIUS, DENSITY)
        box = lattice.box.stretched((1.0 + gap,) * 3)
        programme = (dem.isotropic_compression(0.02, 2500.0),)
        made = dem.Scene(bodies, box, dem.Contact(law), programme, outputs=40, quasi_static=QuasiStatic())
        run, full = dem.run(made), dem.run(dataclasses.replace(made, neglect=0.0))
        assert run.statistics["law"] == "hertz_finite_size"
        missed = float(np.abs(run.pressure - full.pressure).max() / full.pressure.max())
        assert (missed > made.neglect) == late
        assert any("came late" in text for text in run.warnings) == late


@pytest.mark.compiled_only(reason="searches for rest")
def test_moduli_after_a_run_whose_law_gave_way(tmp_path: Path) -> None:
    """The state of the run is that of the elastic law; its moduli are those of a lattice pressed as far at once, with the long-term law."""
    relaxing, long_term = maxwell_zener(Relaxation(1e9, (0.5,), (1.0,)), RADIUS), Hertz(RADIUS, 0.5e9)
    path, programme = tmp_path / "state.npz", (dem.isotropic_compression(0.01, 1e5),)
    made = dem.packed_scene(face_centred_cubic((1, 1, 1), RADIUS), DENSITY, dem.Contact(relaxing), programme, quasi_static=QuasiStatic())
    assert dem.run(made, None, path).stopped is None
    lattice = face_centred_cubic((1, 1, 1), RADIUS)
    bodies, box = dem.spheres(lattice.position * 0.99, RADIUS, DENSITY), lattice.box.stretched((0.99,) * 3)
    expected = moduli(dem.Scene(bodies, box, dem.Contact(long_term), programme))
    np.testing.assert_allclose(moduli(made, checkpoint=path), expected, rtol=1e-6, atol=1e-6 * expected.max())


@pytest.mark.parametrize(
    ("axes", "law", "told"),
    [
        ((1.0, 0.8, 0.66), whole_range_ellipsoid(NMC), False),
        ((1.0, 2.0, 2.0), whole_range_ellipsoid(NMC), False),
        ((1.0, 2.1, 2.1), whole_range_ellipsoid(NMC), True),
        ((3.0, 1.0, 1.0), whole_range_ellipsoid(NMC), True),
        ((3.0, 1.0, 1.0), HertzEllipse(NMC.reduced_modulus), False),
    ],
)
def test_ellipsoids_beyond_the_shapes_that_a_law_was_fitted_to_are_told(axes: tuple[float, float, float], law: object, told: bool) -> None:
    """The whole-range law was fitted to spheroids from 1 : .5 : .5 to 1 : 2 : 2; Hertz's is for any."""
    bodies = dem.ellipsoids([[20.0 * RADIUS] * 3, [10.0 * RADIUS] * 3], [axes * np.array(RADIUS), (RADIUS,) * 3], DENSITY)
    run = dem.run(dem.Scene(bodies, dem.Box((40.0 * RADIUS,) * 3), dem.Contact(law), (dem.hold(1e-9),), outputs=1, frames=1))
    assert any("1 of 2 ellipsoids" in text and "1 : 0.5 : 0.5 to 1 : 2 : 2" in text for text in run.warnings) == told
