"""Partial unloading and reloading by finite elements: what must hold whatever the material, and what a law may count on."""

from __future__ import annotations

import numpy as np
import pytest

from contactlaws.errors import InputError
from contactlaws.material import Material
from fem.cycle import CycleCurve, Leg, measures, onward_difference, press_cycle
from fem.newton import RESIDUAL

pytestmark = pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")

#: the forces of two legs differ by the residual of Newton's method, which is of the norm of all nodal forces
SOLVED = 100.0 * RESIDUAL


@pytest.fixture(scope="module")
def elastic() -> CycleCurve:
    return press_cycle(Material(1000.0, 0.3), 0.02, (0.3, 0.0), tolerance=0.01)


@pytest.fixture(scope="module")
def plastic() -> CycleCurve:
    """Well beyond first yield at .0006 R; in SI units of a real body."""
    return press_cycle(Material(142e9, 0.25, 2e9), 0.02, (0.5, 0.0, 0.0), radius=5e-6)


def legs(curve: CycleCurve) -> list[Leg]:
    """In the order of the path, without the virgin loading."""
    return [leg for loop in curve.loops for leg in (loop.down, loop.up)] + [curve.onward]


def test_an_elastic_body_forgets_its_cycles(elastic: CycleCurve):
    for number in range(2):
        assert np.abs(measures(elastic, number)).max() < SOLVED
    assert onward_difference(elastic) < SOLVED
    assert abs(elastic.loops[1].down.overlap[-1]) < 1e-6 * elastic.start_overlap


def test_legs_join(plastic: CycleCurve):
    path = legs(plastic)
    for before, after in zip(path[:-1], path[1:], strict=True):
        assert [column[0] for column in after] == [column[-1] for column in before]
    np.testing.assert_allclose(plastic.onward.overlap, plastic.virgin.overlap, rtol=1e-12)  # round-off
    assert plastic.loops[0].down.force[-1] == pytest.approx(0.5 * plastic.start_force, rel=0.01)  # of an interpolation over one step
    assert plastic.loops[1].down.force[-1] == 0.0


def test_work_is_stored_or_dissipated(plastic: CycleCurve):
    """Along every leg between landings of the edge: by trapezoids, whose error at 4 % of the force a step is some .3 %."""
    for loop in plastic.loops:
        for leg in (loop.down, loop.up):
            work = float(np.trapezoid(leg.force, leg.overlap))
            change = leg.stored_energy[-1] - leg.stored_energy[0] + leg.dissipated_energy[-1] - leg.dissipated_energy[0]
            assert work == pytest.approx(change, rel=0.01)


def test_dissipation_never_falls(plastic: CycleCurve):
    dissipated = np.concatenate([leg.dissipated_energy for leg in legs(plastic)])
    assert (np.diff(dissipated) >= 0.0).all()


def test_reloading_follows_the_unloading_back_to_the_envelope(plastic: CycleCurve):
    """What laws that reload along their unloading curve count on; the bounds are those of the verification, which looks at 12 bodies."""
    for number in range(3):
        found = measures(plastic, number)
        assert 0.0 <= found.hysteresis < 0.01
        assert found.departure < 1e-3
        assert abs(found.back) < 1e-3
    assert onward_difference(plastic) < 2e-3


def test_what_cannot_be_cycled_is_refused_at_once():
    with pytest.raises(InputError) as caught:
        press_cycle(Material(100.0, 0.3, 1.0), 0.9, (1.0,), beyond=0.5)
    assert [problem.name for problem in caught.value.problems] == ["shares", "beyond"]
    with pytest.raises(InputError, match="no cycle"):
        press_cycle(Material(100.0, 0.3, 1.0), 0.1, ())
