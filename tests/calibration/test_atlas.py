"""The atlas gives back what it is made of, is refused when it is damaged, and its reduction is exact where the answer is known."""

import dataclasses

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from calibration import atlas as atlas_file
from calibration import atlas_build
from calibration.atlas_columns import (
    EDGE,
    SHAPE,
    SHARES,
    area_exponent,
    elastic_columns,
    fitted_edge,
    fitted_shape,
    hertz_force,
    shape_exponent,
)
from calibration.atlas_response import Interpolator
from calibration.atlas_splines import NEAR_YIELD, evaluate, from_onset
from contactlaws.curve import QUANTITIES, Curve
from contactlaws.errors import InputError
from contactlaws.material import Material

ATLAS = atlas_file.shipped()
INTERPOLATOR = Interpolator(ATLAS)


def test_the_shipped_file_is_small_and_says_what_it_is_from():
    assert atlas_file.SHIPPED.stat().st_size < 2e6
    assert len(ATLAS.hashes) == ATLAS.poissons_ratios.size * (ATLAS.modulus_ratios.size + 1)
    assert len(set(ATLAS.hashes)) == len(ATLAS.hashes)
    assert ATLAS.provenance["code"].startswith("fe2dem ")
    assert ATLAS.provenance["curves_code"]


def test_its_range_is_the_promised_one():
    assert ATLAS.modulus_ratios[0] == 1.0
    assert ATLAS.modulus_ratios[-1] >= 1000.0
    assert ATLAS.poissons_ratios[0] == 0.0
    assert ATLAS.depths[-1] >= 0.5


@given(st.integers(0, ATLAS.modulus_ratios.size - 1), st.integers(0, ATLAS.poissons_ratios.size - 1))
def test_interpolation_is_exact_at_the_nodes(i, j):
    """Wherever the body has yielded by more than what is passed over as too near; the table itself has no error there but round-off."""
    found = INTERPOLATOR(float(ATLAS.modulus_ratios[i]), float(ATLAS.poissons_ratios[j]))
    for name, overlaps in (("loading", ATLAS.depths), ("unloading", ATLAS.starts)):
        onset = INTERPOLATOR.prepared.onset[0 if name == "loading" else 1][j]
        yielded = np.log(ATLAS.modulus_ratios[i]) - onset > NEAR_YIELD
        values = getattr(found, name)[found.below.size :]
        assert values[yielded] == pytest.approx(getattr(ATLAS, name)[i, j][yielded], abs=1e-9)
        assert (values[np.log(ATLAS.modulus_ratios[i]) <= onset] == 0.0).all(), overlaps


def test_written_and_read_back_it_is_the_same(tmp_path):
    again = atlas_file.read(atlas_file.write(ATLAS, tmp_path / "again.parquet"))
    assert again.content_hash == ATLAS.content_hash
    assert again.hashes == ATLAS.hashes
    for name in atlas_file.ARRAYS:
        np.testing.assert_array_equal(getattr(again, name), getattr(ATLAS, name))


def test_a_changed_number_is_found(tmp_path):
    table = pq.read_table(atlas_file.SHIPPED)
    column = table.column_names.index("yield_depth")
    values = [None if value is None else value * 1.001 for value in table["yield_depth"].to_pylist()]
    pq.write_table(table.set_column(column, table.schema.field(column), pa.array(values)), tmp_path / "changed.parquet")
    with pytest.raises(InputError, match="not those it was written with"):
        atlas_file.read(tmp_path / "changed.parquet")


@pytest.mark.parametrize("damage", ["missing", "truncated", "other"])
def test_a_damaged_file_is_refused(tmp_path, damage):
    path = tmp_path / "atlas.parquet"
    if damage == "truncated":
        path.write_bytes(atlas_file.SHIPPED.read_bytes()[:5000])
    elif damage == "other":
        pq.write_table(pa.table({"x": [1.0]}), path)
    with pytest.raises(InputError, match=r"atlas\.parquet"):
        atlas_file.read(path)


@given(st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=8), st.floats(-0.9, 0.9))
def test_splines_are_flat_before_the_onset_and_the_natural_cubic_beyond(values, onset):
    """scipy's cubic spline with the same ends is the reference; both are exact, so only round-off is between them."""
    nodes = np.arange(1.0, len(values) + 1.0)
    table = np.array(values)[:, None]
    query = np.linspace(0.0, nodes[-1] - onset, 40)
    reference = CubicSpline(np.append(0.0, nodes - onset), np.append(0.0, values), bc_type=((1, 0.0), (2, 0.0)))
    assert evaluate(from_onset(np.array(onset), nodes, table), query)[:, 0] == pytest.approx(reference(query), abs=1e-9)
    assert (evaluate(from_onset(np.array(onset), nodes, table), np.linspace(-3.0, 0.0, 7)) == 0.0).all()


def test_nodes_before_the_onset_count_for_nothing():
    nodes, onset = np.array([0.0, 1.0, 2.0, 3.0]), np.array(1.5)
    one, other = (from_onset(onset, nodes, np.array([[x], [x], [1.0], [2.0]])) for x in (0.0, 7.0))
    query = np.linspace(-1.0, 2.0, 30)
    np.testing.assert_array_equal(evaluate(one, query), evaluate(other, query))


def hertz_curve(nu=0.3, **facts):
    overlap = np.append(0.0, np.geomspace(1e-4, 0.5, 60))
    force = hertz_force(overlap, 1.0 / (1.0 - nu**2))
    return Curve(np.arange(61.0), overlap, force, np.zeros(61, np.int64), 1.0, np.sqrt(overlap), material=Material(1.0, nu), **facts)


def test_a_hertzian_body_is_zero_everywhere():
    """F = Hertz's, a^2 = R d; unloading along s^1.5 with an area proportional to s."""
    loading, unloading = elastic_columns(hertz_curve(), ATLAS.depths, ATLAS.starts)
    assert loading == pytest.approx(0.0, abs=1e-10)
    assert unloading[:, 0] == pytest.approx(1.5, abs=1e-9)
    assert unloading[:, 1:3] == pytest.approx(0.0, abs=1e-8)
    assert unloading[:, 3:] == pytest.approx(1.0, abs=1e-4)  # a weak smoothing of the area is part of its fit


@given(st.floats(1.0, 1.8), st.floats(-0.2, 0.2), st.floats(-0.1, 0.1))
def test_the_shape_of_an_unloading_is_found_again(first, second, third):
    share = np.linspace(0.01, 0.99, 40)
    wanted = np.array([first, second, third])
    assert fitted_shape(share, share ** shape_exponent(wanted, share)) == pytest.approx(wanted, abs=1e-7)


def test_the_retreat_of_the_contact_is_found_again():
    share, wanted = np.linspace(0.004, 0.99, 60), np.linspace(0.9, 0.1, SHARES.size)
    area = share ** area_exponent(wanted, share)
    assert share ** area_exponent(fitted_edge(share, area), share) == pytest.approx(area, abs=2e-3)  # the same weak smoothing


def test_leaving_a_node_out_changes_little_but_something():
    """Stated errors come from there: they are neither nothing nor more than a crude reading of the table would have."""
    assert ATLAS.leave_out.shape == (2, *ATLAS.yield_depth.shape, ATLAS.starts.size, len(QUANTITIES))
    assert np.isfinite(ATLAS.leave_out).all()
    assert 1e-5 < np.median(ATLAS.leave_out[0]) < 0.02


def test_an_atlas_needs_every_material_whole():
    one = hertz_curve()
    with pytest.raises(InputError, match="at least 4 moduli"):
        atlas_build.build([one])
    plastic = [dataclasses.replace(hertz_curve(nu), material=Material(e, nu, 1.0)) for e in (1.0, 2.0, 3.0, 4.0) for nu in (0.0, 0.2, 0.4)]
    with pytest.raises(InputError) as found:
        atlas_build.build([*plastic[1:], dataclasses.replace(hertz_curve(0.2), stopped="too deep")])
    text = str(found.value)
    assert "(1.0, 0.0): of this E/Y and Poisson's ratio is missing" in text
    assert "elastic curve = 0.4" in text
    assert "ends early: too deep" in text


def test_the_command_says_what_is_missing_and_takes_curves_by_material(tmp_path, capsys):
    from contactlaws.curve_files import write_curve

    write_curve(hertz_curve(), tmp_path / "any name.parquet")
    assert atlas_build.main([str(tmp_path), "--list"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert "elastic_nu0.3.parquet" in listed
    assert "elastic_nu0.parquet  missing" in listed
    assert len(listed) == len(ATLAS.hashes) or ATLAS.modulus_ratios.tolist() != list(atlas_build.MODULUS_RATIOS)
    assert atlas_build.main([str(tmp_path), "--out", str(tmp_path / "out.parquet")]) == 2
    assert not (tmp_path / "out.parquet").exists()


def test_columns_have_their_places():
    assert SHAPE.stop == EDGE.start
    assert ATLAS.unloading.shape[-1] == EDGE.stop
