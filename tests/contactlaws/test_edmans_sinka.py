"""Edmans & Sinka's unloading against the numbers of the paper, and the limits it must keep."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from contactlaws.edmans_sinka import FIRST_YIELD, first_yield, loading_force, loading_work, recovered_depth
from contactlaws.elastic import HertzFiniteSize
from contactlaws.material import Material
from contactlaws.path import scan, trace
from tests.contactlaws.samples import HARD, SOFT, edmans_sinka


def with_reading(law, name: str):
    return law._replace(**dict(zip(("yield_factor", "yield_factor_slope", "yield_power"), FIRST_YIELD[name], strict=True)))


def test_the_papers_366_is_the_unsquared_reading():
    """D/D_c at E/Y = 200, D = .01, nu = .3 is quoted as 366."""
    law = with_reading(edmans_sinka(Material(200.0, 0.3, 1.0)), "unsquared")
    assert round(0.01 / first_yield(law)) == 366


@pytest.mark.parametrize(("nu", "exact"), [(0.0, 1.2993), (0.15, 1.4453), (0.3, 1.6128), (0.45, 1.8061)])
def test_first_yield_is_where_hertz_and_von_mises_put_it(nu: float, exact: float):
    """p0/Y at first yield, exact in Hertz's field; K of Chang, Etsion & Bogy is a fit within 2.3 %. D_c = (pi p0/2E*)^2."""
    law = edmans_sinka(Material(1000.0, nu, 1.0))
    pressure = 2.0 * law.reduced_modulus / np.pi * np.sqrt(first_yield(law))
    assert pressure == pytest.approx(exact, rel=0.023)


def test_readings_of_eq_5_matter_for_soft_materials_only():
    """rho at E/Y = 5, nu = .3, D = .5 is 4.75 corrected and 8.81 unsquared; for E/Y >= 50 and D >= .1 they agree within 4 %."""
    soft, stiff = edmans_sinka(Material(5.0, 0.3, 1.0)), edmans_sinka(Material(50.0, 0.3, 1.0))
    rho = lambda law, depth: 1.0 / recovered_depth(law, depth, first_yield(law))  # noqa: E731
    assert rho(soft, 0.5) == pytest.approx(4.75, abs=0.005)
    assert rho(with_reading(soft, "unsquared"), 0.5) == pytest.approx(8.81, abs=0.005)
    assert rho(with_reading(stiff, "unsquared"), 0.1) == pytest.approx(rho(stiff, 0.1), rel=0.04)


@pytest.mark.parametrize("material", [SOFT, HARD], ids=["soft", "hard"])
def test_exactly_elastic_up_to_first_yield(material: Material):
    law = edmans_sinka(material)
    elastic = HertzFiniteSize(*(getattr(law, name) for name in HertzFiniteSize._fields))
    limit = first_yield(law)
    path = limit * np.array([0.2, 1.0, 0.5, 0.1, 0.9])
    for mine, theirs in zip(scan(law, path)[:4], scan(elastic, path)[:4], strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("material", [SOFT, HARD], ids=["soft", "hard"])
def test_unloading_from_first_yield_gives_back_the_elastic_energy(material: Material):
    law = edmans_sinka(material)
    limit = first_yield(law)
    for beyond in (1e-9, 1e-6):
        top = limit * (1.0 + beyond)
        found = scan(law, [top])
        # what is lost starts in proportion to how far first yield is exceeded; the sum of both is the work of the loading
        assert 0.0 <= found.dissipated_energy[0] / found.stored_energy[0] <= 2.0 * beyond + 1e-13


def test_yield_keeps_force_and_slope():
    law = edmans_sinka(HARD)
    limit = first_yield(law)
    for step in (1e-4, 1e-6):
        force = scan(law, limit * (1.0 + step * np.array([-1.0, 0.0, 1.0]))).force
        below, above = np.diff(force)
        # F = F_el (1 - (b z)^m/m) with z = step/2: the slopes differ by some (b step)^(m - 1)
        assert abs(above / below - 1.0) < 2.0 * step ** (law.flow_sharpness - 1.0)


@pytest.mark.parametrize("depth", [1.01, 30.0, 1e4])
def test_work_of_the_loading_is_its_integral(depth: float):
    law = edmans_sinka(HARD)
    limit = first_yield(law)
    corners = limit * np.geomspace(1.0, depth, 12)
    elastic = loading_work(law, limit, limit)
    total = elastic + sum(
        quad(lambda d: loading_force(law, d, limit), a, b, epsabs=0, epsrel=1e-11)[0] for a, b in zip(corners, corners[1:], strict=False)
    )
    assert loading_work(law, limit * depth, limit) == pytest.approx(total, rel=1e-10)  # quad's own tolerance, added over 11 pieces


def test_separates_where_eq_3_says():
    law = edmans_sinka(HARD)
    top = 0.1
    separation = top - recovered_depth(law, top, first_yield(law))
    force = scan(law, [top, separation * (1 + 1e-9), separation]).force
    assert force[1] > 0.0
    assert force[2] == pytest.approx(0.0, abs=1e-12 * force[0])


def test_a_very_sharp_transition_does_not_overflow():
    """Elastic up to where the plastic force is the smaller one, as the sharpness grows; fits may go there."""
    smooth, sharp = (edmans_sinka(Material(100.0, 0.3, 1.0))._replace(flow_sharpness=value) for value in (200.0, 1e8))
    overlaps = smooth.radius * np.geomspace(1e-3, 0.5, 40)
    one, other = trace(smooth, overlaps).force, trace(sharp, overlaps).force
    assert (other > 0.0).all()
    np.testing.assert_allclose(one, other, rtol=1.1 * (2.0 ** (1.0 / 200.0) - 1.0))  # what the smooth minimum lacks where both are equal
