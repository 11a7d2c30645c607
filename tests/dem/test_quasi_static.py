"""States of rest one after another: as slow motion, without pressing deeper on the way, and said when there is none."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from dem.measure import network, pair_geometry
from dem.packing import Packing
from dem.quasi_static import step_to
from dem.scene import QuasiStatic
from dem.working import working
from tests.dem.scenes import DENSITY, RADIUS, YIELDS, contact, step_for, walled_crystal


@pytest.mark.compiled_only(reason="thousands of steps")
def test_quasi_static_is_slow_motion(hertz: Hertz, shaken_crystal: Packing) -> None:
    """Elastic and frictionless, a nearly perfect crystal has one state of rest at each strain; the motion misses it by its inertial number.

    Both are within 2 % of the pressure: the slow run's waves (inertial number 1e-3) and drag are as large.
    """
    programme = (dem.isotropic_compression(0.03),)
    made = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), programme, outputs=6, inertial_number=1e-3)
    slow, rest = dem.run(made), dem.run(dataclasses.replace(made, quasi_static=QuasiStatic()))
    assert rest.stopped is None
    np.testing.assert_allclose(rest.pressure[3:], slow.pressure[3:], rtol=0.02)
    assert np.all(rest.energies.kinetic == 0.0)


@pytest.mark.compiled_only(reason="searches for rest")
@pytest.mark.parametrize("method", ["fire", "damped"])
def test_both_searches_find_the_same_rest(method: str, hertz: Hertz, shaken_crystal: Packing) -> None:
    """The energy of an elastic crystal has one minimum nearby; forces are balanced to 1e-5 of the mean."""
    made = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), (dem.isotropic_compression(0.02),), outputs=2)
    fine = QuasiStatic(strain_step=5e-3, force=1e-5, kinetic=1e-10)
    finer = QuasiStatic(strain_step=2e-3, force=1e-5, kinetic=1e-10)
    one = dem.run(dataclasses.replace(made, quasi_static=fine._replace(method=method)))
    other = dem.run(dataclasses.replace(made, quasi_static=finer))
    np.testing.assert_allclose(one.stress[-1], other.stress[-1], rtol=0.0, atol=1e-4 * other.stress[-1].max())


@pytest.mark.compiled_only(reason="searches for rest")
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_the_search_does_not_press_plastic_contacts_deeper(friction: float) -> None:
    """One strain step from a fresh packing: the largest overlap that a contact remembers is its own, to round-off of places."""
    packing = walled_crystal(1.003, 0.001)  # nothing touches yet
    made = dem.packed_scene(packing, DENSITY, contact(friction, law=YIELDS), (dem.hold(1.0),), walls=(False, False, True))
    work = working(made)
    cell = made.box.stretched((1.0, 1.0, 0.99)).cell
    critical = lambda overlap: step_for(made, overlap, 1.0)  # noqa: E731
    work, rest = step_to(work, cell, 1.0, True, critical, 1e-6, QuasiStatic())
    assert rest.found
    assert rest.iterations > 100  # it went to and fro
    touching = 0
    for group in work.groups:
        overlap, memory = pair_geometry(work, group)[1], group.past.memory
        assert memory is not None
        rows = overlap > 0.0
        scale = 1.0 if group.rows.image is None else 0.5  # equal spheres are each a body at half the overlap
        np.testing.assert_allclose(memory[rows, 0], scale * overlap[rows], rtol=1e-12, atol=1e-14 * RADIUS)
        assert not np.any(memory[~rows])
        touching += int(rows.sum())
    assert touching > 60
    assert len(network(work).first) == touching


@pytest.mark.compiled_only(reason="searches for rest")
def test_energy_of_rests_with_friction_and_plasticity() -> None:
    """What the boundary gives is held, dissipated, rubbed or lost in rearrangements, and none of the losses is ever given back."""
    made = dem.packed_scene(
        walled_crystal(), DENSITY, contact(0.3, 0.02, law=YIELDS), dem.uniaxial_compression(0.02),
        walls=(False, False, True), outputs=5, quasi_static=QuasiStatic(strain_step=5e-4),
    )  # fmt: skip
    run = dem.run(made)
    assert run.stopped is None
    np.testing.assert_allclose(run.energies.balance, 0.0, atol=1e-12)  # `damped` is what is left, so only round-off
    work = run.energies.boundary_work.max()
    for lost in (run.energies.dissipated, run.energies.rubbed):
        assert np.diff(lost).min() > -1e-3 * work
    assert run.energies.damped[-1] > -0.02 * work  # beyond the trapezium of forces in steps of 5e-4


def test_a_search_that_may_not_go_on_says_so(hertz: Hertz, shaken_crystal: Packing) -> None:
    """Two iterations are not enough; the state that was reached is kept, with its reason, and nothing of it is NaN."""
    made = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), (dem.isotropic_compression(0.02),), outputs=1)
    run = dem.run(dataclasses.replace(made, quasi_static=QuasiStatic(strain_step=0.02, most=2, look=1)))
    assert run.stopped is not None
    assert "no rest was found" in run.stopped
    assert np.isfinite(run.stress).all()
    assert run.frames[-1].output == 1
