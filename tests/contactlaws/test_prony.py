"""Prony series: what relaxation and creep say of one another, and of isotropic bodies, alone and in contact.

Most of it in Laplace space, where the relations between moduli are plain algebra: s times the transform of a series, without cancellation.
"""

from __future__ import annotations

import math

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from contactlaws.errors import InputError
from contactlaws.prony import Creep, PronyViscoelastic, Relaxation, checked_series, problems_with_modulus, together, uniaxial

#: 1/s, from faster than every term to slower
FREQUENCIES = np.geomspace(1e-9, 1e9, 73)
#: where compliances are added, a term of 1e-17 may lie beside the zero that another one makes: a double zero leaves half the digits (6000
#: random pairs: 3e-8)
HALF_THE_DIGITS = 1e-7
#: of the relations in Laplace space: some hundred roundings, and roots to 1e-13 in the logarithm of a distance
ROUND_OFF = 1e-12

PVDF = Relaxation(1770.5e6, (404.6 / 1770.5,), (1.8,))


def relaxation_in_laplace(modulus: Relaxation) -> np.ndarray:
    """s M(s) for all `FREQUENCIES`: the long-term modulus, and what each term adds at speed."""
    st_ = FREQUENCIES[:, None] * np.array(modulus.times)
    return modulus.long_term + modulus.instantaneous * (np.array(modulus.fractions) * st_ / (1.0 + st_)).sum(axis=1)


def creep_in_laplace(compliance: Creep) -> np.ndarray:
    """s J(s) for all `FREQUENCIES`."""
    return compliance.instantaneous + (np.array(compliance.jumps) / (1.0 + FREQUENCIES[:, None] * np.array(compliance.times))).sum(axis=1)


@st.composite
def relaxations(draw, most=6, times=None):
    """Up to six terms over 12 decades, of which from 1e-9 to .999 of the modulus relaxes; neighbours 0.1 % apart or more."""
    if times is None:
        places = draw(st.lists(st.integers(-6000, 6000), min_size=0, max_size=most, unique=True))
        times = tuple(sorted(10.0 ** (place / 1000.0) for place in places))
    shares = [10.0 ** draw(st.floats(-8.0, 0.0)) for _ in times]
    total = 10.0 ** draw(st.floats(-9.0, math.log10(0.999)))
    fractions = tuple(total * share / sum(shares) for share in shares)
    return Relaxation(10.0 ** draw(st.floats(-3.0, 12.0)), tuple(max(g, 1e-9) if total > 1e-6 else g for g in fractions), times)


@given(relaxations())
def test_compliance_is_the_reciprocal_of_the_modulus(modulus):
    np.testing.assert_allclose(relaxation_in_laplace(modulus) * creep_in_laplace(modulus.creep()), 1.0, rtol=ROUND_OFF)


@given(relaxations(most=4), st.floats(-5.0, 5.0))
def test_a_creeping_body_under_constant_force_holds_that_force(modulus, decades):
    """int_0^t M(t - s) dJ(s) = 1, by Gauss's rule on panels that halve towards both ends, where the terms are fast."""
    time = 10.0**decades
    compliance = modulus.creep()
    half = np.concatenate(([0.0], 0.5 ** np.arange(48.0, 0.0, -1.0)))
    x, w = np.polynomial.legendre.leggauss(10)
    ends = time * np.concatenate((half, 1.0 - half[-2::-1]))
    past = (0.5 * (ends[1:] + ends[:-1])[:, None] + 0.5 * np.diff(ends)[:, None] * x).ravel()
    left = (time * (half[1:] + half[:-1])[:, None] * 0.5 + 0.5 * time * np.diff(half)[:, None] * x)[::-1, ::-1].ravel()
    left = np.concatenate(((time - past[: left.size]), left))
    weight = (0.5 * np.diff(ends)[:, None] * w).ravel()
    rate = (np.array(compliance.jumps) / np.array(compliance.times) * np.exp(-past[:, None] / np.array(compliance.times))).sum(axis=1)
    held = modulus.at(time) * compliance.instantaneous + float((weight * modulus.at(left) * rate).sum())
    assert held == pytest.approx(1.0, abs=1e-9)  # of the panels, the last of which is 2^-48 of the time


@given(relaxations())
def test_there_and_back_again(modulus):
    """Terms of less than 1e-9 may drown in the round-off of greater ones; what is left of a modulus is known to 1e-16 of the whole."""
    again = modulus.creep().relaxation()
    time = np.geomspace(1e-8, 1e8, 65)
    left = modulus.long_term / modulus.instantaneous
    np.testing.assert_allclose(again.at(time), modulus.at(time), rtol=3.0 * ROUND_OFF / left)
    if min(modulus.fractions, default=1.0) > 1e-6:
        np.testing.assert_allclose(again.times, modulus.times, rtol=1e-6)  # a time is known as well as the share of its term: 1e-12/1e-6
        np.testing.assert_allclose(again.fractions, modulus.fractions, rtol=1e-6)


@given(relaxations())
def test_times_of_creep_and_relaxation_take_turns(modulus):
    """tau_1 < lambda_1 < tau_2 < ...: retardation is slower than relaxation, and by no more than to the next term (Gross 1953)."""
    creep = modulus.creep()
    assert len(creep.times) == len(modulus.times)
    assert all(jump > 0.0 for jump in creep.jumps)
    assert all(early <= late for early, late in zip(modulus.times, creep.times, strict=True))
    assert all(late <= early for late, early in zip(creep.times, modulus.times[1:], strict=False))
    assert creep.instantaneous * modulus.instantaneous == pytest.approx(1.0, rel=ROUND_OFF)
    assert (creep.instantaneous + sum(creep.jumps)) * modulus.long_term == pytest.approx(1.0, rel=ROUND_OFF)


def test_one_term_is_the_textbooks_standard_solid():
    """lambda = tau/(1 - g), J_1 = J_0 g/(1 - g)."""
    for g in (1e-9, 0.2, 0.999):
        creep = Relaxation(2.0, (g,), (3.0,)).creep()
        assert creep.times[0] == pytest.approx(3.0 / (1.0 - g), rel=ROUND_OFF)
        assert creep.jumps[0] == pytest.approx(0.5 * g / (1.0 - g), rel=ROUND_OFF)


def test_small_terms_far_apart_keep_their_sizes():
    """Their zeros lie at 1e-9 of their poles, of which the slow one is 11 decades away."""
    modulus = Relaxation(1.0, (9e-9, 5e-9), (2.5e-6, 8e5))
    creep = modulus.creep()
    np.testing.assert_allclose(creep.jumps, modulus.fractions, rtol=1e-7)  # to first order in the fractions
    np.testing.assert_allclose(creep.relaxation().fractions, modulus.fractions, rtol=1e-7)


def test_terms_of_no_size_change_nothing():
    full, sparse = Relaxation(3.0, (0.0, 0.4, 0.0), (0.1, 1.0, 10.0)), Relaxation(3.0, (0.4,), (1.0,))
    assert full.creep() == sparse.creep()
    assert Relaxation(3.0, (0.0,), (1.0,)).creep() == Creep(1.0 / 3.0)
    assert Creep(0.5, (0.0,), (1.0,)).relaxation() == Relaxation(2.0)


def test_limits_in_time():
    modulus = Relaxation(2.0, (0.25, 0.5), (1e-3, 10.0))
    assert modulus.at([0.0, 1e9]).tolist() == [2.0, modulus.long_term]
    assert modulus.creep().at([0.0]).tolist() == [0.5]
    assert modulus.at(1e-1) == pytest.approx(2.0 * (0.75 - 0.5 * (1.0 - math.exp(-0.01))), rel=1e-15)  # the first term is gone: e^-100


@given(relaxations(most=4), relaxations(most=4))
def test_two_bodies_in_contact_add_their_compliances(one, two):
    both = relaxation_in_laplace(together(one, two))
    expected = 1.0 / (1.0 / relaxation_in_laplace(one) + 1.0 / relaxation_in_laplace(two))
    np.testing.assert_allclose(both, expected, rtol=HALF_THE_DIGITS)
    np.testing.assert_allclose(both, relaxation_in_laplace(together(two, one)), rtol=1e-12)


@given(relaxations(most=4), st.floats(-3.0, 12.0))
def test_an_elastic_body_in_contact_with_a_viscoelastic_one(modulus, decades):
    elastic = Relaxation(10.0**decades)
    expected = 1.0 / (1.0 / elastic.instantaneous + 1.0 / relaxation_in_laplace(modulus))
    np.testing.assert_allclose(relaxation_in_laplace(together(modulus, elastic)), expected, rtol=HALF_THE_DIGITS)
    assert together(elastic, elastic).instantaneous == pytest.approx(0.5 * elastic.instantaneous, rel=1e-15)  # one rounding each way


def test_two_equal_bodies_are_one_of_half_the_modulus():
    both = together(PVDF, PVDF)
    assert both.instantaneous == pytest.approx(0.5 * PVDF.instantaneous, rel=1e-15)
    np.testing.assert_allclose((*both.fractions, *both.times), (*PVDF.fractions, *PVDF.times), rtol=1e-12)


@given(relaxations(most=4), st.floats(0.0, 0.4999))
def test_uniaxial_relaxation_with_a_bulk_modulus_that_stays(modulus, nu):
    """9 K G/(3 K + G) is Young's modulus, with the G found and the instantaneous K."""
    material = uniaxial(modulus, nu, constant_bulk=True)
    bulk, shear = relaxation_in_laplace(material.bulk), relaxation_in_laplace(material.shear)
    np.testing.assert_allclose(bulk, modulus.instantaneous / (3.0 - 6.0 * nu), rtol=1e-15)
    np.testing.assert_allclose(9.0 * bulk * shear / (3.0 * bulk + shear), relaxation_in_laplace(modulus), rtol=1e-9)
    assert material.poissons_ratio <= material.long_term.poissons_ratio + 1e-12 < 0.5 + 1e-12


@given(relaxations(most=4), st.floats(0.0, 0.4999))
def test_uniaxial_relaxation_at_constant_poissons_ratio(modulus, nu):
    material = uniaxial(modulus, nu)
    assert material.long_term.poissons_ratio == pytest.approx(nu, abs=1e-12)
    assert material.long_term.youngs_modulus == pytest.approx(modulus.long_term, rel=1e-12)
    expected = relaxation_in_laplace(modulus) / (1.0 - nu**2)
    np.testing.assert_allclose(relaxation_in_laplace(material.reduced), expected, rtol=1e-12)


@st.composite
def materials(draw):
    shear = draw(relaxations(most=4))
    bulk = draw(relaxations(times=shear.times))
    return PronyViscoelastic(shear.instantaneous, draw(st.floats(0.0, 0.4999)), shear.times, shear.fractions, bulk.fractions)


@given(materials())
def test_reduced_modulus_is_that_of_an_elastic_body_at_each_frequency(material):
    """E/(1 - nu^2) = 4 G (3 K + G)/(3 K + 4 G)."""
    shear, bulk = relaxation_in_laplace(material.shear), relaxation_in_laplace(material.bulk)
    expected = 4.0 * shear * (3.0 * bulk + shear) / (3.0 * bulk + 4.0 * shear)
    np.testing.assert_allclose(relaxation_in_laplace(material.reduced), expected, rtol=HALF_THE_DIGITS)
    assert material.reduced.instantaneous == pytest.approx(material.instantaneous.reduced_modulus, rel=1e-12)
    assert material.reduced.long_term == pytest.approx(material.long_term.reduced_modulus, rel=HALF_THE_DIGITS)


def test_pvdf_of_wahn_gan_and_kamlah():
    """Recomputed from E1, E2, tau and nu of their Table 1: their G0 is 617.5 MPa, and k1 = g1 would lower Young's modulus further."""
    consistent = uniaxial(PVDF, 0.4314, constant_bulk=True)
    assert consistent.bulk.instantaneous / 1e6 == pytest.approx(4301.5, abs=0.05)
    assert consistent.shear.instantaneous / 1e6 == pytest.approx(618.45, abs=0.005)
    assert consistent.shear_fractions[0] == pytest.approx(0.2369, abs=5e-5)
    assert consistent.relaxation_times[0] == pytest.approx(1.7805, abs=5e-5)
    assert consistent.long_term.youngs_modulus / 1e6 == pytest.approx(1365.9, abs=0.05)
    theirs = consistent._replace(shear_fractions=(0.237,), bulk_fractions=None)
    assert theirs.long_term.youngs_modulus / 1e6 == pytest.approx(1350.9, abs=0.05)
    alike = uniaxial(PVDF, 0.4314)
    assert alike.relaxation_times == (1.8,)
    assert alike.shear_fractions[0] == alike.bulk.fractions[0] == pytest.approx(0.2285, abs=5e-5)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"relaxation_times": (-1.0, 2.0)}, r"relaxation_times\[1\] = -1.0: must be a positive"),
        ({"relaxation_times": (0.0, 2.0)}, r"relaxation_times\[1\] = 0.0: must be a positive"),
        ({"relaxation_times": (1.0, math.nan)}, r"relaxation_times\[2\] = nan: must be a positive"),
        ({"relaxation_times": (1.0, math.inf)}, r"relaxation_times\[2\] = inf: must be a positive"),
        ({"relaxation_times": (2.0, 2.0)}, r"relaxation_times\[2\] = 2.0: stands there twice"),
        ({"relaxation_times": (2.0, 1.0)}, r"relaxation_times\[2\] = 1.0: must rise, and comes after 2"),
        ({"shear_fractions": (0.5, 0.5)}, r"shear_fractions = 1.0: must be below 1 in sum"),
        ({"shear_fractions": (0.5, 0.6)}, r"shear_fractions = 1.1: must be below 1 in sum"),
        ({"shear_fractions": (1.0, 0.0)}, r"shear_fractions\[1\] = 1.0: must lie in \[0, 1\)"),
        ({"shear_fractions": (-0.1, 0.1)}, r"shear_fractions\[1\] = -0.1: must lie in \[0, 1\)"),
        ({"shear_fractions": (math.nan, 0.1)}, r"shear_fractions\[1\] = nan: must lie in \[0, 1\)"),
        ({"shear_fractions": (0.1,)}, "shear_fractions = 1: must be 2, one for each relaxation time"),
        ({"bulk_fractions": (0.1, 0.95)}, "bulk_fractions = 1.0.*: must be below 1 in sum"),
        ({"poissons_ratio": 0.5}, r"poissons_ratio = 0.5: must lie in \[0, 0.5\)"),
        ({"poissons_ratio": math.nan}, r"poissons_ratio = nan"),
        ({"youngs_modulus": math.nan}, "youngs_modulus = nan"),
        ({"youngs_modulus": 0.0}, "youngs_modulus = 0.0"),
    ],
)
def test_impossible_constants_are_refused_with_one_reason(changes, said):
    good = PronyViscoelastic(1e9, 0.3, (1.0, 2.0), (0.1, 0.2))
    assert checked_series(good) is good
    with pytest.raises(InputError, match=said) as raised:
        checked_series(good._replace(**changes))
    assert len(raised.value.problems) == 1


@pytest.mark.parametrize(
    ("modulus", "said"),
    [
        (Relaxation(1.0, (0.5, 0.5), (1.0, 2.0)), "below 1 in sum"),
        (Relaxation(1.0, (0.1, 0.1), (2.0, 1.0)), "must rise"),
        (Relaxation(1.0, (0.1, 0.1), (1.0,)), "must be 1, one for each"),
        (Relaxation(-1.0, (0.1,), (1.0,)), "modulus = -1.0: must be a positive"),
        (Relaxation(math.nan), "modulus = nan: must be a positive"),
    ],
)
def test_impossible_moduli_are_refused_wherever_they_are_used(modulus, said):
    assert len(list(problems_with_modulus(modulus))) == 1
    for use in (modulus.creep, lambda: together(PVDF, modulus), lambda: together(modulus, PVDF)):
        with pytest.raises(InputError, match=said):
            use()


def test_a_uniaxial_test_that_no_material_gives():
    with pytest.raises(InputError, match=r"poissons_ratio = 0.5: must lie in \[0, 0.5\)"):
        uniaxial(PVDF, 0.5)
    with pytest.raises(InputError, match="below 1 in sum"):
        uniaxial(Relaxation(1.0, (0.6, 0.6), (1.0, 2.0)), 0.3, constant_bulk=True)
