"""One unloading is measured as it is: a power law gives back its constants, an elastic body its whole overlap and its work."""

import csv
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibration.unloadings import power_law, table_rows, unloading, unloadings
from contactlaws.curve import Curve
from contactlaws.errors import InputError
from contactlaws.material import Material
from contactlaws.unloading_table import UNITS, heading, write_table

STEEL = Material(200e9, 0.3, 1e9)


def power_law_curve(alpha=1.4, recovered=0.02, rows=30, radius=2e-3, **facts):
    """Loading F ~ d^1.5 to d = R/10, and one unloading that is a power law."""
    largest, force = 0.1 * radius, 50.0
    loading = np.linspace(0.0, largest, 20)
    s = np.linspace(1.0, 0.0, rows)
    overlap = np.concatenate([loading, largest - recovered * radius * (1.0 - s)])
    values = np.concatenate([force * (loading / largest) ** 1.5, force * s**alpha])
    branch = np.repeat([0, 1], [20, rows])
    return Curve(np.arange(overlap.size, dtype=float), overlap, values, branch, radius, **{"material": STEEL, **facts})


@given(alpha=st.floats(1.0, 3.0), rows=st.integers(8, 60), origin=st.floats(0.0, 0.9))
def test_a_power_law_is_found_wherever_its_rows_stand(alpha, rows, origin):
    """Interpolation of the logarithms is exact for a power law: what is left is round-off, magnified by the offset of the overlap."""
    s = np.linspace(1.0, 0.0, rows) ** 1.3
    found = power_law(origin + 0.1 * s, 7.0 * s**alpha)
    assert found.exponent == pytest.approx(alpha, abs=1e-6)
    assert found.r2 == pytest.approx(1.0, abs=1e-9)


def test_flat_punch_recovery_has_its_known_exponent():
    """Mesarovic & Johnson's recovery, F/F_max = (2/pi)(arccos t - t sqrt(1 - t^2)), t = (d_max - d)/(d_max - d_0): exponent 1.357 +- .001.

    The figure is a best fit over equal steps of the overlap; over equal steps of the force it moves by less than .01.
    """
    t = np.linspace(0.0, 1.0, 400)
    force = 2.0 / np.pi * (np.arccos(t) - t * np.sqrt(1.0 - t * t))
    assert power_law(1.0 - t, force).exponent == pytest.approx(1.357, abs=0.01)


def test_the_exponent_does_not_depend_on_how_the_curve_was_sampled():
    """Same unloading, rows in equal steps of the overlap or crowded at either end; 1e-4 is what interpolating 40 rows leaves."""
    exponents = []
    for crowding in (0.5, 1.0, 2.0):
        t = np.linspace(0.0, 1.0, 40) ** crowding
        force = 2.0 / np.pi * (np.arccos(t) - t * np.sqrt(1.0 - t * t))
        exponents.append(power_law(1.0 - t, force).exponent)
    assert np.ptp(exponents) < 1e-4


def test_measures_of_a_known_unloading():
    """rho = R/(d_max - d_0); the work given back is F_max (d_max - d_0)/(alpha + 1), to the error of a cubic through 200 rows."""
    curve = power_law_curve(alpha=1.4, recovered=0.02, rows=200)
    found = unloading(curve, 1)
    assert found.stiffness == pytest.approx(50.0, rel=1e-12)
    assert found.separation_overlap == pytest.approx(0.08 * curve.radius, rel=1e-12)
    assert found.exponent == pytest.approx(1.4, abs=1e-6)
    assert found.recovered_energy == pytest.approx(50.0 * 0.02 * curve.radius / 2.4, rel=1e-5)
    assert found.contact_radius is found.stored_energy is found.dissipated_energy is None


def test_an_elastic_hertz_contact_recovers_everything():
    """rho = 1/D, alpha = 1.5, and the work given back is the work done, 2/5 F d."""
    curve = power_law_curve(alpha=1.5, recovered=0.1, rows=200)
    found = unloading(curve, 1)
    assert found.stiffness == pytest.approx(1.0 / 0.1, rel=1e-12)
    assert found.exponent == pytest.approx(1.5, abs=1e-6)
    assert found.recovered_energy == pytest.approx(0.4 * 50.0 * 0.1 * curve.radius, rel=1e-5)


@pytest.mark.parametrize(
    ("facts", "plastic"),
    [({}, False), ({"yield_overlap": 1e-4}, True), ({"yield_overlap": 3e-4}, False), ({"material": None}, None)],
)
def test_an_unloading_is_plastic_if_it_starts_beyond_first_yield(facts, plastic):
    assert unloading(power_law_curve(**facts), 1).plastic is plastic


def test_noise_near_the_separation_changes_little():
    """A force that wanders by 1e-3 of its start: rows out of order are left out, the exponent moves by no more than ten times that."""
    curve = power_law_curve(alpha=1.4, rows=120)
    rows = curve.rows(1)
    overlap, force = curve.overlap[rows], curve.force[rows].copy()
    force[1:-1] += 0.05 * np.random.default_rng(1).uniform(-1.0, 1.0, force.size - 2)
    assert power_law(overlap, force).exponent == pytest.approx(1.4, abs=1e-2)


def test_an_unloading_that_stops_half_way_has_no_separation():
    whole = power_law_curve()
    columns = {name: getattr(whole, name)[:35] for name in ("time", "overlap", "force", "branch")}
    half = Curve(**columns, radius=whole.radius, material=STEEL)
    assert unloading(half, 1) is None
    assert unloadings(half) == ()


def test_table_holds_every_unloading_with_units(tmp_path):
    """CSV and Parquet hold the same numbers; a column says its unit, and absence is an empty cell."""
    import pyarrow.parquet as pq

    curves = [power_law_curve(alpha=a) for a in (1.2, 1.4)]
    rows = list(table_rows(curves))
    table = pq.read_table(write_table(rows, tmp_path / "t.parquet"))
    assert table.num_rows == len(rows) == 2
    assert table.schema.field("force_N").metadata == {b"unit": b"N"}
    assert table["exponent"].to_pylist() == [row["exponent"] for row in rows]
    assert table["stored_energy_J"].to_pylist() == [None, None]
    with write_table(rows, tmp_path / "t.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert list(read[0]) == [heading(name) for name in UNITS]
    assert [float(row["overlap_m"]) for row in read] == [row["overlap"] for row in rows]
    assert read[0]["stored_energy_J"] == ""
    assert math.isclose(float(read[0]["modulus_over_yield_stress"]), 200.0)


def test_a_table_of_another_kind_is_refused(tmp_path):
    with pytest.raises(InputError, match="no kind of table file"):
        write_table([], tmp_path / "t.xlsx")
