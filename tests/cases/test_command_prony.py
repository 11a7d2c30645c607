"""`fe2dem prony`: what it prints and writes, and that what cannot be used is said at once with exit code 2."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cases.command import BAD_INPUT, execute
from contactlaws.errors import InputError
from contactlaws.prony import uniaxial
from contactlaws.prony_files import read_series
from tests.calibration.prony_samples import PVDF, exact, places


def written(file, kind, modulus=PVDF, noise=0.01, first=0.01, last=30.0, remark=""):
    """A table on disk, as an instrument would leave it."""
    place = places(kind, 80, first, last)
    values = exact(modulus, kind, place)
    values = (values * (1.0 + noise * np.random.default_rng(1).standard_normal(values.size))).reshape(-1, 80)
    header = {"relaxation": "time,modulus", "creep": "time,compliance", "dynamic": "angular_frequency,storage,loss"}[kind]
    rows = [",".join(map(repr, row)) for row in np.vstack((place, values)).T.tolist()]
    file.write_text("\n".join((remark, header, *rows)) + "\n")
    return str(file)


def facts_of(path):
    pairs = (line[2:].split(": ", 1) for line in path.read_text().splitlines() if line.startswith("# "))
    return dict(pairs)


@pytest.mark.parametrize("kind", ["relaxation", "creep", "dynamic"])
def test_a_table_becomes_a_series_that_is_the_materials(tmp_path, capsys, kind):
    table, out = written(tmp_path / "table.csv", kind), tmp_path / "series.csv"
    assert execute(["prony", table, "--poissons-ratio", "0.4314", "--bulk", "constant", "--out", str(out)]) == 0
    found, truth = read_series(out), uniaxial(PVDF, 0.4314, constant_bulk=True)
    errors = json.loads(facts_of(out)["standard_errors"])
    # four standard errors: one table in 10 000 is further off in either
    assert abs(found.shear_fractions[0] - truth.shear_fractions[0]) < 4.0 * errors["shear_fraction"][0]
    assert abs(found.relaxation_times[0] - truth.relaxation_times[0]) < 4.0 * errors["relaxation_time"][0]
    assert found.bulk_fractions == (0.0,)
    assert found.poissons_ratio == 0.4314
    said = capsys.readouterr()
    for words in ("AICc", "BIC", "smallest BIC, taken", "fractions[1]", "standard error", "the table sees relaxation times", "saved:"):
        assert words in said.out
    assert "warning" not in said.err


def test_the_file_says_where_it_comes_from(tmp_path):
    table, out = tmp_path / "table.csv", tmp_path / "series.csv"
    assert execute(["prony", written(table, "relaxation"), "--poissons-ratio", "0.3", "--out", str(out)]) == 0
    facts = facts_of(out)
    assert facts["format"] == "fe2dem prony series"
    assert facts["code"].startswith("fe2dem ")
    source, fit, candidates = (json.loads(facts[name]) for name in ("table", "fit", "candidates"))
    assert (source["name"], source["kind"], source["modulus"], len(source["sha256"])) == ("table.csv", "relaxation", "uniaxial", 64)
    assert candidates[1]["bic"] == min(one["bic"] for one in candidates)
    assert fit["noise"] == pytest.approx(0.01, rel=0.3)
    assert fit["values"]["instantaneous"] == read_series(out).youngs_modulus


def test_without_poissons_ratio_the_reader_gives_it(tmp_path):
    table, out = written(tmp_path / "table.csv", "relaxation", noise=0.0), tmp_path / "series.csv"
    assert execute(["prony", table, "--out", str(out)]) == 0
    with pytest.raises(InputError, match="poissons_ratio"):
        read_series(out)
    assert read_series(out, poissons_ratio=0.3).shear_fractions == pytest.approx(PVDF.fractions, rel=1e-6)


def test_a_shear_modulus_needs_poissons_ratio(tmp_path, capsys):
    table, out = written(tmp_path / "table.csv", "relaxation", noise=0.0, remark="# modulus: shear"), tmp_path / "series.csv"
    assert execute(["prony", table, "--out", str(out)]) == BAD_INPUT
    assert "--poissons-ratio missing: is needed to know Young's modulus from that of shear" in capsys.readouterr().err
    assert execute(["prony", table, "--poissons-ratio", "0.25", "--out", str(out)]) == 0
    assert read_series(out).youngs_modulus == pytest.approx(2.5 * PVDF.instantaneous, rel=1e-6)


def test_warnings_stand_beside_the_result(tmp_path, capsys):
    table, out = written(tmp_path / "table.csv", "relaxation", noise=0.0, last=1.0), tmp_path / "series.csv"
    assert execute(["prony", table, "--noise", "1 %", "--terms", "1", "--poissons-ratio", "0.3", "--out", str(out)]) == 0
    said = capsys.readouterr().err
    assert "times[1] = 1.8 s lies outside the 0.01 to 1 s that the table can see" in said
    assert "not seen to level off" in said
    assert len(json.loads(facts_of(out)["warnings"])) == said.count("warning")


def test_a_material_that_does_not_relax_is_a_series_without_terms(tmp_path):
    table, out = written(tmp_path / "table.csv", "relaxation", PVDF._replace(fractions=(), times=())), tmp_path / "series.csv"
    assert execute(["prony", table, "--poissons-ratio", "0.3", "--bulk", "constant", "--out", str(out)]) == 0
    assert read_series(out).relaxation_times == ()


def test_every_bad_option_is_named_at_once(tmp_path, capsys):
    broken = tmp_path / "table.csv"
    broken.write_text("time,modulus\n1,2\n")
    options = ["--poissons-ratio", "0.5", "--bulk", "never", "--terms", "-1", "--noise", "3 m", "--out", str(tmp_path / "series.json")]
    assert execute(["prony", str(broken), *options]) == BAD_INPUT
    said = capsys.readouterr().err
    for name in ("--poissons-ratio", "--bulk", "--terms", "--noise", "--out", "1 rows"):
        assert name in said
    assert execute(["prony"]) == BAD_INPUT
    said = capsys.readouterr().err
    assert "TABLE.csv missing" in said
    assert "--out missing" in said


def test_more_terms_than_the_table_can_tell(tmp_path, capsys):
    table = written(tmp_path / "table.csv", "relaxation")
    assert execute(["prony", table, "--terms", "40", "--out", str(tmp_path / "series.csv")]) == BAD_INPUT
    assert "--terms = 40: must lie between 0 and 20 for 80 numbers" in capsys.readouterr().err
    assert not (tmp_path / "series.csv").exists()
