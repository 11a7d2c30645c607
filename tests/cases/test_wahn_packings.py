"""The packings of Wahn, Gan & Kamlah: preparation, limits of what is run, and the arithmetic of the statements."""

from __future__ import annotations

import numpy as np
import pytest

from cases.wahn_gan_kamlah_2022 import packing_facts, packing_runs
from cases.wahn_gan_kamlah_2022.jamming import exponents, jamming_fraction
from cases.wahn_gan_kamlah_2022.numbers import half_space, pair_at
from cases.wahn_gan_kamlah_2022.packing_runs import SLOW, Jammed
from cases.wahn_gan_kamlah_2022.packings import (
    DENSITY,
    FRACTION,
    MATERIALS,
    SOFT,
    STIFF,
    VISCOUS,
    Runs,
    Way,
    band,
    compress,
    compression,
    contact,
    contracted,
    dropped,
)

slow_interpreted = pytest.mark.compiled_only(reason="compressions of packings in thousands of steps")
COUNT = 60


def test_moduli_of_table_1_are_the_limits_of_its_relaxation():
    assert MATERIALS["PVDF"].instantaneous.youngs_modulus == pytest.approx(1770.5e6)
    assert MATERIALS["PVDF"].long_term.youngs_modulus == pytest.approx(1365.9e6, rel=1e-12)
    assert MATERIALS["NMC"].long_term.youngs_modulus == pytest.approx(142e9, rel=1e-12)


def test_an_even_ramp_leaves_of_its_overstress_what_the_law_leaves():
    """Closed form against the recurrence of the law: 2000 even steps of d, an error of the second order in the step."""
    law = half_space()
    slow, fast = pair_at(law, 1e9), pair_at(law, 1e-9)
    left = (pair_at(law, 10.0, steps=2000) - slow) / (fast - slow)
    assert packing_facts.overstress(10.0, 1.8) == pytest.approx(left, abs=1e-4)
    assert packing_facts.overstress(10.0, 250.0 / 42.0) == pytest.approx(0.56, abs=0.005)  # Fig. 14


@slow_interpreted
def test_contraction_ends_near_635_without_overlap():
    """On the average of many; a single one of 250 scatters by .002 (measured), five means by half of that."""
    fractions = [contracted(seed).packing_fraction for seed in range(1, 6)]
    assert np.mean(fractions) == pytest.approx(FRACTION, abs=0.004)
    packing = contracted(1, COUNT)
    physics = contact("PVDF", SOFT, 0.0)
    run, _ = compress(packing, DENSITY["PVDF"], physics, compression(1e-6), Way("", "", 1, 0.0, outputs=1))
    assert run.stress[0] == 0.0


@slow_interpreted
def test_a_dropped_bed_has_the_fraction_of_fig_13():
    assert dropped(1, COUNT).packing_fraction == pytest.approx(0.58, rel=1e-9)


@slow_interpreted
def test_relaxation_at_rest_ends_between_the_elastic_limits_and_at_the_slow_one():
    """Frictional, so that no sphere slides without end; 9 s are five relaxation times, e^-5 = .7 % of an overstress of 30 %."""
    packing, programme = contracted(2, COUNT), compression(0.005, 1.0, 9.0)
    way = Way("", "", 2, 0.3, outputs=5)
    soft, stiff = (
        compress(packing, DENSITY["PVDF"], contact("PVDF", kind, 0.3), compression(0.005), way)[0].stress[-1] for kind in (SOFT, STIFF)
    )
    relaxing, _ = compress(packing, DENSITY["PVDF"], contact("PVDF", VISCOUS, 0.3), programme, way)
    assert not relaxing.stopped
    assert soft < relaxing.at(0.005) < stiff
    # friction's path depends on how one came here: a per cent or two
    assert relaxing.stress[-1] == pytest.approx(soft, rel=0.03)


@slow_interpreted
def test_motion_and_rest_agree_when_slow():
    """With friction, inertial number 1e-4: inertia carries about as much of the pressure, the drag 2.5 times that."""
    packing, physics = contracted(2, COUNT), contact("NMC", SOFT, 0.3)
    rest, moved = (
        compress(packing, DENSITY["NMC"], physics, compression(0.01), Way("", "", 2, 0.3, inertial_number=number))[0]
        for number in (None, SLOW)
    )
    assert moved.at(0.01) == pytest.approx(rest.at(0.01), rel=0.02)
    assert moved.balance < 1e-5
    assert moved.kinetic < 1e-3
    assert moved.inertial_number > 0.0
    assert rest.inertial_number == 0.0


@slow_interpreted
def test_no_smooth_packing_carries_pressure_with_fewer_contacts_than_isostatic():
    """3 N - 3 motions apart from the box's own, and one contact more for a pressure; counts are whole, so no tolerance."""
    jammed = packing_runs.unjam(contracted(1, COUNT), 1, most=0.005, outputs=40)
    assert jammed is not None
    held = COUNT * jammed.held
    assert np.all(np.round(0.5 * held * jammed.coordination) >= np.round(3.0 * held) - 2.0)


def test_powers_are_found_in_a_packing_that_obeys_them():
    """p = (phi - phi_J)^1.5 and z - z_iso = 4 (phi - phi_J)^.5, sampled as a run would; the point to a tenth of the spacing."""
    fraction = np.linspace(0.66, 0.6402, 100)
    isostatic = 6.0 - 4.0 / 250
    pressure, contacts = (fraction - 0.64) ** 1.5, isostatic + 4.0 * (fraction - 0.64) ** 0.5
    jammed = Jammed(1, fraction, pressure, contacts, np.ones_like(fraction), (0.6399, 0.6402), 1.0)
    assert jamming_fraction(jammed) == pytest.approx(0.64, abs=2e-5)
    found = exponents(jammed, 250)
    assert found.pressure_exponent == pytest.approx(1.5, abs=0.01)
    assert found.contacts_exponent == pytest.approx(0.5, abs=0.01)
    assert found.coordination == pytest.approx(isostatic, abs=0.01)


def test_a_band_leaves_out_what_is_not_finite():
    found = band([1.0, 3.0, float("nan")])
    assert found == (2.0, 1.0, 3.0, 2)
    assert band([]).text() == "–"


def test_statements_say_when_nothing_was_run():
    assert packing_facts.percent(packing_facts.excess(Runs(()), "14", "one", "other", 0.0)) == "no stress at rest yet"
    assert packing_runs.threshold("NMC") > packing_runs.threshold("PVDF")
