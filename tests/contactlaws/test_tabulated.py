"""The tabulated law: exact on its data, sensible between them, refused where the data do not suffice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from contactlaws.elastic import Hertz
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw
from contactlaws.path import scan
from contactlaws.tabulate import from_curve
from contactlaws.tabulated_record import Tabulated
from tests.contactlaws.samples import HARD, curve_of, edmans_sinka

SOURCE = edmans_sinka(HARD)
CURVE = curve_of(SOURCE, 0.1, (0.1, 0.3, 1.0), HARD, yield_overlap=5.3e-6)


@pytest.mark.parametrize("branch", range(4))
def test_exact_on_its_own_data(branch: int):
    rows = CURVE.rows(branch)
    path = CURVE.overlap[rows]
    found = scan(from_curve(CURVE), path)
    # round-off in s = (d - d_0)/(d_max - d_0), some 20 times magnified by the small difference below the line
    np.testing.assert_allclose(found.force, CURVE.force[rows], rtol=1e-11, atol=1e-12 * CURVE.force[rows].max())
    np.testing.assert_allclose(
        found.contact_radius**2, CURVE.contact_radius[rows] ** 2, rtol=1e-11, atol=1e-12 * CURVE.contact_radius[rows].max() ** 2
    )


def test_more_unloadings_bring_it_closer_to_where_they_come_from():
    """Between stored states: halving their distance (in the logarithm) leaves less than half the error, as linear mixing should."""
    tops = np.array([0.02, 0.05])
    paths = [np.linspace(top, 0.9 * top, 60) for top in tops]
    errors = []
    for steps in (2, 4, 8):
        fractions = tuple(np.geomspace(0.1, 1.0, steps + 1))
        law = from_curve(curve_of(SOURCE, 0.1, fractions, HARD, rows=600, yield_overlap=5.3e-6))
        errors.append(max(np.max(abs(scan(law, path).force - (truth := scan(SOURCE, path).force))) / truth[0] for path in paths))
    assert errors[1] < 0.5 * errors[0]
    assert errors[2] < 0.5 * errors[1]


def test_a_straight_line_beyond_the_last_row():
    force = scan(from_curve(CURVE), [0.1, 0.11, 0.12]).force
    assert force[2] - force[1] == pytest.approx(force[1] - force[0], rel=1e-10)  # three numbers of which differences are taken


def test_an_elastic_body_needs_no_unloadings_and_has_no_memory():
    curve = curve_of(Hertz(1.0, 50.0), 0.1, (), HARD.elastic)
    path = np.array([0.1, 0.05, 0.01, 0.05])
    found = scan(from_curve(curve), path)
    assert not found.dissipated_energy.any()
    assert found.force[1] == found.force[3]
    np.testing.assert_allclose(found.force, scan(Hertz(1.0, 50.0), path).force, rtol=2e-3)  # cubics through 80 rows over four decades


def test_an_unloading_from_before_first_yield_follows_the_loading():
    late = replace(CURVE, yield_overlap=0.02)
    law = from_curve(late)
    assert law.stored.shape[1] == 3  # the elastic response, and the two unloadings from beyond 0.02
    found = scan(law, [0.02, 0.01, 0.02])
    assert found.force[0] == found.force[2]
    assert not found.dissipated_energy.any()


def test_without_a_contact_radius_it_says_so():
    law = from_curve(replace(CURVE, contact_radius=None))
    assert np.isnan(scan(law, [0.1, 0.0999]).contact_radius).all()
    assert np.isfinite(scan(law, [0.1, 0.0999]).force).all()


TABLE = from_curve(CURVE)


def table(name: str, row: int, column: int, value: float) -> Tabulated:
    changed = getattr(TABLE, name).copy()
    changed[row, column] = value
    return TABLE._replace(**{name: changed})


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (TABLE._replace(loading=np.zeros(3)), r"loading = \(3,\): must be rows"),
        (TABLE._replace(loading=np.zeros((1, 1))), r"loading = \(1, 1\): must have 4 or 6 rows"),
        (TABLE._replace(loading=[[0.0]]), "loading = 'list': must be rows"),
        (TABLE._replace(stored=TABLE.stored[:, :1]), r"stored = \(5, 1\): must have 5 rows of none, or 2"),
        (TABLE._replace(unloading=TABLE.unloading[:4]), "must have the rows of loading"),
        (TABLE._replace(unloading=TABLE.unloading[:, :-1]), "must be whole numbers that divide"),
        (TABLE._replace(yield_overlap=-1.0), "yield_overlap = -1.0: must be positive"),
        (table("loading", 1, 3, np.nan), "loading = 'not finite'"),
        (table("loading", 0, 3, 1.0), "must be positive and increase"),
        (table("loading", 1, 0, -1.0), "must be positive, and rise at first"),
        (table("loading", 3, 5, 1.0), "loading: work = .*must be the integral"),
        (table("loading", 4, 5, -1.0), "contact radius squared = -1.0"),
        (table("stored", 0, 0, 1e-9), "must start at yield_overlap"),
        (table("stored", 1, 1, -1.0), "must be positive, 0 or more in the first"),
        (table("stored", 2, 1, 0.0), "unloading 1: largest slope = 0.0: must be at least"),
        (table("stored", 3, 1, 1e9), "must be whole numbers that divide"),
        (table("stored", 4, 3, 1e9), "must be whole numbers that divide"),
        (table("stored", 3, 0, -5.0), "must be whole numbers that divide"),
        (table("unloading", 0, 0, 0.5), "unloading 0: s = .*from 0 to 1"),
        (table("unloading", 1, 0, 0.5), "unloading 0: force = .*from 0 to 1"),
        (table("unloading", 3, 5, 0.5), "unloading 0: work"),
    ],
)
def test_a_damaged_table_is_refused_before_compiled_code_reads_it(law: Tabulated, expected: str):
    with pytest.raises(InputError, match=expected):
        FittedLaw(law, 0.1)


def cut(rows: slice):
    columns = {name: getattr(CURVE, name)[rows] for name in ("time", "overlap", "force", "branch", "contact_radius")}
    return replace(CURVE, **columns)


def test_refuses_what_it_cannot_be_made_from():
    with pytest.raises(InputError, match="unloadings = 0"):
        from_curve(cut(CURVE.rows(0)))
    with pytest.raises(InputError, match="must run down to separation"):
        from_curve(cut(slice(0, CURVE.rows(1).stop - 5)))
    overlap = CURVE.overlap.copy()
    overlap[CURVE.rows(1)][3:5] = overlap[CURVE.rows(1)][[4, 3]]
    with pytest.raises(InputError, match=r"branch 1 row 4: overlap"):
        from_curve(replace(CURVE, overlap=overlap))
