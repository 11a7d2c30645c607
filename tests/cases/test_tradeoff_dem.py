"""The trade of packings: what is compared is comparable, what is equal in physics comes out equal, and errors are what they are called."""

from __future__ import annotations

import math

import numpy as np
import pytest

import dem
from cases.tradeoff import dem_errors, dem_runs
from cases.tradeoff.dem_errors import SEEDS, SIZE
from cases.tradeoff.dem_page import choices_table, picture, verdicts_table
from cases.tradeoff.dem_runs import OUTPUTS, QUANTITIES
from cases.tradeoff.dem_settings import USUAL, Axis, Choice, Plan, Setting, plan
from dem.packing import random_close_packing

#: as few spheres as still pack to the fraction that all have
ROUGH = USUAL._replace(spheres=60, inertial_number=0.03, law="hertz")


@pytest.fixture(scope="module")
def packing():
    return random_close_packing(ROUGH.spheres, dem_runs.PACKING_FRACTION, dem_runs.RADIUS, 1)


@pytest.mark.parametrize("quick", [True, False])
def test_every_axis_changes_one_thing_and_no_run_is_planned_twice(quick):
    wanted = plan(quick)
    for axis in wanted.axes:
        for choice in axis.choices:
            assert choice.setting != axis.finest.setting
            changed = [name for name in Setting._fields if getattr(choice.setting, name) != getattr(axis.finest.setting, name)]
            # states of rest replace motion at a rate, so there the rate has no meaning
            assert len(set(changed) - ({"inertial_number"} if choice.setting.strain_step else set())) == 1
        assert len({choice.name for choice in (*axis.choices, axis.finest)}) == len(axis.choices) + 1
    assert len(wanted.runs) == len(set(wanted.runs))
    assert {seed for setting, seed in wanted.runs if setting == USUAL} >= set(wanted.seeds)
    assert max(wanted.means) <= dict(wanted.sizes)[USUAL.spheres]


def test_density_scaling_at_one_strain_rate_is_a_larger_inertial_number(packing):
    """Lengths, forces and contacts know no mass: the equations are the same in time over its square root.

    1e-9: the two runs round times and masses differently, and some hundred steps of a few collisions let that grow.
    """
    scaled = dem.run(dem_runs.scene_of(ROUGH._replace(density_scaling=4.0), packing))
    faster = dem.run(dem_runs.scene_of(ROUGH._replace(inertial_number=0.06), packing))
    assert scaled.statistics["steps"] == faster.statistics["steps"]
    assert scaled.stress == pytest.approx(faster.stress, rel=1e-9, abs=1e-9 * float(scaled.stress.max()))


def test_means_of_stress_are_work_over_strain(packing):
    """The work that the run itself counts, per initial volume, the section staying what it is. 1 %: trapezoids between 30 outputs."""
    done = dem.run(dem_runs.scene_of(ROUGH, packing))
    found, work, volume = dem_runs.stresses(done), done.energies.boundary_work, packing.box.volume
    assert found["peak"] == pytest.approx(done.stress[OUTPUTS, 2, 2], rel=1e-15)
    assert found["loading"] == pytest.approx(work[OUTPUTS] / volume / dem_runs.STRAIN, rel=0.01)
    back = (work[OUTPUTS] - work[-1]) / volume / dem_runs.STRAIN
    assert found["release"] == pytest.approx(back, rel=0.01)
    assert found["release"] < found["loading"] < found["peak"]


def _stand_in(values: dict[tuple[Setting, int], float]) -> dem_runs.Results:
    """Results whose three stresses are all the same number."""
    facts = {"stopped": None, "steps": 100, "packing_cpu_seconds": 0.1}
    return {
        run: facts | dict.fromkeys(QUANTITIES, value) | {"cpu_seconds": 1.0 + 0.1 * run[1] + 0.001 * run[0].spheres}
        for run, value in values.items()
    }


COARSE, LARGE = USUAL._replace(law="hertz"), Setting(spheres=1000)
PLAN = Plan((Axis("law", (Choice("coarse", COARSE),), Choice("fine", USUAL)),), 2, ((USUAL.spheres, 4), (1000, 2)), (1, 4))
#: usual packings 80 to 120 about 100, whose standard deviation is 10 sqrt(8/3); the coarse law 10 % and 14 % too stiff on the first two
VALUES = {
    **{(USUAL, seed): value for seed, value in enumerate((80.0, 100.0, 100.0, 120.0), 1)},
    (COARSE, 1): 88.0,
    (COARSE, 2): 114.0,
    (LARGE, 1): 108.0,
    (LARGE, 2): 112.0,
}


def test_errors_are_measured_on_the_same_packings_and_scatter_on_all():
    rows = {(row.axis, row.choice): row for row in dem_errors.rows(PLAN, _stand_in(VALUES)) if row.quantity == "peak"}
    law = rows["law", "coarse"]
    # round-off of a few operations
    assert law.bias == pytest.approx(0.12, rel=1e-12)
    assert law.error == pytest.approx(math.sqrt((0.1**2 + 0.14**2) / 2), rel=1e-12)
    assert law.bias_error == pytest.approx(0.02, rel=1e-12)
    assert law.scatter == pytest.approx(math.sqrt(800.0 / 3.0) / 100.0, rel=1e-12)
    assert law.cpu_seconds == pytest.approx(1.35, rel=1e-12)
    size = rows[SIZE, f"{USUAL.spheres} spheres"]
    assert size.bias == pytest.approx(100.0 / 110.0 - 1.0, rel=1e-12)
    assert size.error == pytest.approx(np.sqrt(np.mean((np.array([80.0, 100.0, 100.0, 120.0]) / 110.0 - 1.0) ** 2)), rel=1e-12)
    assert size.own == pytest.approx(abs(size.bias), rel=1e-15)
    four = rows[SEEDS, "mean of 4"]
    assert four.error == pytest.approx(law.scatter / 2.0, rel=1e-12)
    assert four.cpu_seconds == pytest.approx(4.0 * 1.35, rel=1e-12)


def test_the_verdict_names_what_is_small_beside_the_scatter():
    results = _stand_in(VALUES)
    law, size = (next(v for v in dem_errors.verdicts(dem_errors.rows(PLAN, results)) if v.axis == axis) for axis in ("law", SIZE))
    assert law.usual is None
    assert law.worst.choice == "coarse"
    assert law.cheapest is None
    # a bias of 1/11 is more than a third of 0.163
    assert size.cheapest is None
    assert dem_errors.packings_for(size.usual) == math.ceil((math.sqrt(800.0 / 3.0) / 100.0 * 11.0) ** 2)
    closer = _stand_in(VALUES | {(COARSE, 1): 80.8, (COARSE, 2): 101.0})
    law = next(v for v in dem_errors.verdicts(dem_errors.rows(PLAN, closer)) if v.axis == "law")
    assert law.cheapest.choice == "coarse"


def test_a_run_that_stopped_is_reported_and_its_choice_left_out():
    results = _stand_in(VALUES)
    results[COARSE, 2] = {name: value for name, value in results[COARSE, 2].items() if name not in QUANTITIES} | {"stopped": "it diverged"}
    rows = dem_errors.rows(PLAN, results)
    assert not [row for row in rows if row.axis == "law"]
    assert [row for row in rows if row.axis == SIZE]
    assert [problem["reason"] for problem in dem_errors.failures(results)] == ["it diverged"]


def test_tables_and_picture_show_every_choice_and_the_scatter():
    results = _stand_in(VALUES)
    rows = dem_errors.rows(PLAN, results)
    header, lines = choices_table(PLAN, results, rows)
    assert all(len(line) == len(header) for line in lines)
    assert [line[0].split(":")[0] for line in lines if not line[0].startswith("…")] == ["law", SIZE, SEEDS, SEEDS]
    header, lines = verdicts_table(dem_errors.verdicts(rows))
    assert all(len(line) == len(header) for line in lines)
    drawn = picture(rows, "peak")
    dashed = [line.get_ydata()[0] for axis in drawn.axes for line in axis.lines if line.get_linestyle() == "--"]
    assert dashed == pytest.approx([dem_errors.scatter(PLAN, results)["peak"]] * 3, rel=1e-15)


@pytest.mark.compiled_only("compiles nothing, but packs and runs 60 spheres")
def test_an_interrupted_measurement_goes_on_where_it_was(tmp_path, monkeypatch):
    runs = [(ROUGH, 1), (ROUGH._replace(time_step_fraction=0.8), 1), (ROUGH, 2)]
    first = dem_runs.measure(runs[:2], tmp_path)
    monkeypatch.setattr(dem_runs, "run", lambda setting, packing: {"stopped": "only what is missing is run"})
    again = dem_runs.measure(runs, tmp_path)
    assert {run: again[run] for run in runs[:2]} == first
    assert again[runs[2]]["stopped"] == "only what is missing is run"
