"""A material is found again from its own curve, intervals cover the truth as often as they say, and what a curve cannot tell is said."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.stats import binom

from calibration import atlas as atlas_file
from calibration import identify
from calibration.identify_data import Measured, read_measured
from calibration.identify_model import Setting, reading
from calibration.identify_search import LIMIT, Task, best
from calibration.predict import interpolator
from contactlaws.curve_files import read_curve
from contactlaws.errors import InputError

ATLAS = interpolator(atlas_file.shipped())
STEEL = Setting(210e9, 700e6, 0.3, 0.0, 0.0)
RADIUS = 1e-3
ONCE = pytest.mark.compiled_only(reason="least squares upon least squares; nothing of them is compiled, so once is enough")


def grid(deepest=0.06, recovered=0.4, unloading=True, zero=0.0, rows=(30, 16)):
    """Where a machine takes its readings: up to `deepest` (overlap over radius) and back by a share of it; the forces come later."""
    up = np.linspace(0.0, deepest, rows[0] + 1)[1:]
    down = np.linspace(deepest, deepest * (1.0 - recovered), rows[1] + 1)[1:] if unloading else np.zeros(0)
    overlap = np.concatenate((up, down)) * RADIUS + zero
    return Measured(overlap, np.linspace(1.0, 2.0, overlap.size), np.repeat([0, 1], [up.size, down.size]), RADIUS)


def measured_by(setting, places, noise=0.0, seed=0):
    """What the machine reads: overlaps with its own deflection in them, forces with noise (a share of the largest)."""
    true = reading(ATLAS, places, setting._replace(zero=0.0, compliance=0.0)).force
    scatter = noise * true.max() * np.random.default_rng(seed).standard_normal(true.size)
    return Measured(places.overlap + setting.zero + setting.compliance * true, true + scatter, places.branch, RADIUS)


@pytest.mark.parametrize("compliance", [0.0, 2e-8])
def test_a_deflecting_machine_reads_the_same_forces_at_larger_overlaps(compliance):
    places = grid()
    seen = measured_by(STEEL._replace(compliance=compliance, zero=3e-6), places)
    again = reading(ATLAS, seen, STEEL._replace(compliance=compliance, zero=3e-6)).force
    assert again == pytest.approx(seen.force, rel=2e-4, abs=2e-4 * seen.force.max())  # the deflection is tabulated at 300 overlaps


def test_without_noise_the_material_is_found_again():
    found = identify(measured_by(STEEL, grid()), poissons_ratio=0.3)
    assert found.estimates["youngs_modulus"] == pytest.approx(210e9, rel=1e-4)
    assert found.estimates["yield_stress"] == pytest.approx(700e6, rel=1e-4)
    assert found.statements == ()
    assert found.material.yield_stress == found.estimates["yield_stress"]
    assert found.atlas == ATLAS.atlas.content_hash
    for name, profile in found.profiles.items():
        low, high = found.intervals[name]
        assert low < found.estimates[name] < high
        assert (np.diff(profile.values) > 0.0).all()
        assert profile.deviance.min() < 1e-6


@ONCE
def test_zero_and_compliance_are_found_with_it():
    setting = STEEL._replace(zero=2e-6, compliance=1e-8)
    found = identify(measured_by(setting, grid(rows=(20, 10)), 1e-3), poissons_ratio=0.3, zero_unknown=True, compliance_unknown=True)
    assert found.names == ("youngs_modulus", "yield_stress", "zero", "compliance")
    for name in found.names:
        low, high = found.intervals[name]
        assert low < getattr(setting, name) < high, name
    # the stiffness of the unloading is that of body and machine in a row, so the two are hard to tell apart
    assert found.correlation[0, 3] > 0.8


def coverage(setting, places, noise, trials):
    """How often the deviance of the truth, the other unknowns at their best, is within the limit; independent noise, a perfect model."""
    held = []
    for seed in range(trials):
        seen = measured_by(setting, places, noise, seed)
        scatter = noise * reading(ATLAS, places, setting._replace(zero=0.0, compliance=0.0)).force.max()
        task = Task(seen, ATLAS, (0.3, 0.3), False, False, np.eye(seen.force.size) * scatter)
        found = best(task, setting)
        for first in ("youngs_modulus", "yield_stress"):
            fixed = best(task, setting, first, (0, float(np.log(getattr(setting, first)))))
            held.append(fixed.deviance - found.deviance < LIMIT)
    return np.array(held).reshape(trials, 2).sum(axis=0)


@ONCE
def test_intervals_cover_the_truth_as_often_as_they_say():
    """Of 20 realisations of the noise, a 95 % interval misses so many only once in a thousand times."""
    counts = coverage(STEEL, grid(rows=(16, 8)), 0.01, 20)
    fewest = binom.ppf(1e-3, 20, 0.95)
    assert (counts >= fewest).all(), counts


def finite_elements(name, branch, noise, seed):
    """A curve that the atlas has not seen, up to one of its unloadings, with noise; stresses as for Y = 400 MPa, radius 1 mm."""
    curve = read_curve(Path(__file__).parent / "unseen" / f"{name}.parquet")
    rows, back = curve.rows(0), curve.rows(branch)
    depth, load = curve.overlap / curve.radius, curve.force / (curve.material.yield_stress * curve.radius**2)
    loading = CubicSpline(np.log(depth[rows][1:]), np.log(load[rows][1:]))
    up = np.linspace(depth[rows][1], depth[back][0], 40)
    down = np.linspace(depth[back][0], depth[back][-1], 24)[1:]
    force = np.concatenate((np.exp(loading(np.log(up))), PchipInterpolator(depth[back][::-1], load[back][::-1])(down)))
    scatter = noise * force.max() * np.random.default_rng(seed).standard_normal(force.size)
    return Measured(
        np.concatenate((up, down)) * RADIUS, (force + scatter) * 400e6 * RADIUS**2, np.repeat([0, 1], [up.size, down.size]), RADIUS
    )


@ONCE
@pytest.mark.parametrize(
    ("name", "branch", "seed"), [("E70_nu0.2", 6, 1), ("E70_nu0.2", 10, 2), ("E300_nu0.4", 4, 3), ("E1.5_nu0.4", 14, 4)]
)
def test_round_trip_on_finite_elements_with_noise(name, branch, seed):
    """Within the interval, or so near its end that one more sigma covers it: four draws, each misses once in twenty times."""
    ratio, nu = (float(part) for part in name.removeprefix("E").split("_nu"))
    found = identify(finite_elements(name, branch, 0.01, seed), poissons_ratio=nu)
    for unknown, truth in (("youngs_modulus", ratio * 400e6), ("yield_stress", 400e6)):
        low, high = np.log(found.intervals[unknown])
        assert low - 0.25 * (high - low) < np.log(truth) < high + 0.25 * (high - low)
    assert 0.005 < found.noise / found.measured.force.max() < 0.02
    assert found.misfit < 1.5


@ONCE
def test_an_elastic_curve_bounds_the_yield_stress_from_below_only():
    soft = Setting(1e9, 400e6, 0.3, 0.0, 0.0)
    found = identify(measured_by(soft, grid(deepest=0.1, recovered=0.95), 0.01), poissons_ratio=0.3)
    assert found.estimates["yield_stress"] is None
    low, high = found.intervals["yield_stress"]
    assert high is None
    assert 50e6 < low < 400e6
    assert found.estimates["youngs_modulus"] == pytest.approx(1e9, rel=0.05)
    assert found.material.yield_stress is None
    assert any("bounded from below only" in text for text in found.statements)
    assert any("elastic as far as it goes" in text for text in found.statements)


@ONCE
def test_a_plastic_loading_alone_hardly_shows_the_modulus():
    """E/Y = 900 pressed from d = .1 R on: the force is that of a rigid-plastic body within the noise."""
    places = grid(deepest=0.4, unloading=False)
    deep = places.overlap > 0.1 * RADIUS
    places = Measured(places.overlap[deep], places.force[deep], places.branch[deep], RADIUS)
    found = identify(measured_by(Setting(360e9, 400e6, 0.3, 0.0, 0.0), places, 0.01), poissons_ratio=0.3)
    assert found.estimates["youngs_modulus"] is None
    assert found.intervals["youngs_modulus"][1] is None
    assert 90e9 < found.intervals["youngs_modulus"][0] < 360e9
    assert found.intervals["yield_stress"][1] == pytest.approx(400e6, rel=0.05)
    assert any("Young's modulus is bounded from below only" in text for text in found.statements)
    assert any("there is no unloading" in text for text in found.statements)


def write(path, lines, radius="# radius: 1e-3"):
    path.write_text("\n".join([radius, "overlap,force", *lines]) + "\n")
    return path


GOOD = [f"{d},{1e8 * d**1.5}" for d in np.linspace(0.0, 5e-5, 12)]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([*GOOD[:5], "2e-5,nan", *GOOD[6:]], "line 8: force = 'nan': must be a finite number"),
        ([*GOOD[:-1], GOOD[-1].split(",")[0]], "must have 2 values"),
        ([*GOOD, "4e-5,-20.0"], "must not fall below zero"),
        ([line.replace(",", ",-") for line in GOOD[1:]], "is never positive"),
        (GOOD[:3], "needs at least 5"),
        (["1e-5,2"] * 8, "never changes"),
        ([*GOOD, "2.0,3"], "check the units"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_with_the_reason(tmp_path, lines, message):
    with pytest.raises(InputError) as caught:
        read_measured(write(tmp_path / "measured.csv", lines))
    assert message in str(caught.value)


def test_the_radius_must_be_known_once(tmp_path):
    with pytest.raises(InputError, match="does not say how large"):
        read_measured(write(tmp_path / "measured.csv", GOOD, "# nothing"))
    with pytest.raises(InputError, match="contradicts"):
        read_measured(write(tmp_path / "measured.csv", GOOD), radius=2e-3)
    assert read_measured(write(tmp_path / "measured.csv", GOOD, "# nothing"), radius=2e-3).radius == 2e-3


def test_the_turning_point_is_the_largest_overlap(tmp_path):
    found = read_measured(write(tmp_path / "measured.csv", [*GOOD, "4.9e-5,10", "4.8e-5,0"]))
    assert found.branch.tolist() == [0] * 12 + [1, 1]


def test_what_leaves_the_atlas_or_has_too_few_rows_is_refused():
    deep = Measured(np.linspace(0.0, 0.7, 20) * RADIUS, np.linspace(0.0, 1.0, 20), np.zeros(20, np.int64), RADIUS)
    with pytest.raises(InputError, match="leaves the atlas"):
        identify(deep, poissons_ratio=0.3)
    few = Measured(np.linspace(0.0, 0.1, 5) * RADIUS, np.linspace(0.0, 1.0, 5), np.zeros(5, np.int64), RADIUS)
    with pytest.raises(InputError, match="too few for 5 unknowns"):
        identify(few, poissons_ratio=0.3, zero_unknown=True, compliance_unknown=True)
    with pytest.raises(InputError) as caught:
        identify(few, poissons_ratio=(0.4, 0.7), noise=-1.0)
    assert [problem.name for problem in caught.value.problems] == ["poissons_ratio", "noise"]
