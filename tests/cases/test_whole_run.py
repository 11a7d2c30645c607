"""One small case from a measured curve to the report, and once more: everything is reused, and the report is one file without links."""

from __future__ import annotations

import re
from pathlib import Path

import meshio
import numpy as np
import pytest

from cases.command import execute
from cases.report import history
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve, write_curve
from contactlaws.elastic import Hertz
from contactlaws.fitted import load
from contactlaws.material import Material
from contactlaws.path import scan

pytestmark = pytest.mark.compiled_only(reason="a packing that is compressed takes minutes interpreted")

CASE = """
title = "A case <of> & its own"
[materials.glass]
youngs_modulus = "70 GPa"
poissons_ratio = 0.25
[fits.elastic]
law = "hertz"
curves = ["measured.csv"]
material = "glass"
radius = "1 mm"
[impacts.elastic]
fit = "elastic"
radius = "1 mm"
density = "2500 kg/m^3"
speed = [0.1, 1]
[scenes.small]
fit = "elastic"
radius = "1 mm"
density = "2500 kg/m^3"
count = 20
packing_fraction = 0.55
strain = 0.05
release = false
"""


PLASTIC = """
[materials.nmc]
youngs_modulus = "142 GPa"
poissons_ratio = 0.25
yield_stress = "7.9 GPa"
[curves.pressed]
material = "nmc"
radius = "5 um"
unload_from = [0.05]
fields = true
[fits.law]
law = "thornton"
curves = ["pressed"]
[scenes.small]
fit = "law"
radius = "5 um"
density = "4750 kg/m^3"
count = 30
packing_fraction = 0.62
strain = 0.12
strain_rate = "1e5 1/s"
"""


def test_from_constants_to_a_plastic_packing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole line. A body that yields gives back less than it took, and so do a fit to it and a packing of it; the energies add up."""
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(PLASTIC)
    assert execute(["run", "case.toml", "--out", "results", "--jobs", "1"]) == 0
    (curve_file,) = Path("results/curves").glob("*.parquet")
    curve = read_curve(curve_file)
    assert curve.yield_overlap is not None
    assert curve.dissipated_energy is not None
    assert curve.dissipated_energy[curve.rows(0)][-1] > 0.0
    fields = [meshio.read(file) for file in sorted(Path("results/fields").glob("*/*.vtu"))]
    assert len(fields) >= 2  # loaded and unloaded
    assert all({"von_mises", "equivalent_plastic_strain"} <= {*field.point_data, *field.cell_data} for field in fields)
    (law_file,) = Path("results/fits").glob("*.json")
    assert 1.0 < load(law_file).law.yield_pressure / 7.9e9 < 3.0  # first yield at 1.6, full plasticity at 3 yield stresses
    (scene_file,) = Path("results/scenes").glob("*.parquet")
    scene = history.read(scene_file)
    assert scene["dissipated"][-1] > scene["stored"][-1]
    assert np.abs(scene["balance"]).max() < 1e-3  # what a run must close to by its own warning
    assert "small" in Path("results/report.html").read_text(encoding="utf-8")
    with Path("results/table.csv").open() as file:
        assert "thornton" in file.read()


def test_from_a_measured_curve_to_the_report(tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    law = Hertz(1e-3, Material(70e9, 0.25).reduced_modulus)
    overlap = np.linspace(0.0, 2e-5, 30)
    write_curve(Curve(np.arange(30.0), overlap, scan(law, overlap).force, np.zeros(30, np.int64), radius=1e-3), "measured.csv")
    Path("case.toml").write_text(CASE)
    assert execute(["run", "case.toml", "--out", "results", "--jobs", "1"]) == 0
    shown = capfd.readouterr()
    assert "4 results: 0 reused" in shown.out
    for words in ("no rotations, no tangential history", "energy balance closes to", "of the critical one", "inertia shows in the stress"):
        assert words in shown.err
    assert execute(["run", "case.toml", "--out", "results", "--jobs", "1"]) == 0
    assert capfd.readouterr().out.startswith("4 results: 4 reused, 0 computed\n")  # no new cost
    page = Path("results/report.html").read_text(encoding="utf-8")
    assert "A case &lt;of&gt; &amp; its own" in page
    # namespaces are names, not links; a link would be a src, href or url() that leaves the page
    assert not re.search(r"""(src|href)=["'](?!#|data:)|url\((?!#)""", page)
    assert execute(["status", "results"]) == 0
    assert "scenes.small" in capfd.readouterr().out
