"""One small case from a measured curve to the report, and once more: everything is reused, and the report is one file without links."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from cases.command import execute
from contactlaws.curve import Curve
from contactlaws.curve_files import write_curve
from contactlaws.elastic import Hertz
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


def test_from_a_measured_curve_to_the_report(tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    law = Hertz(1e-3, Material(70e9, 0.25).reduced_modulus)
    overlap = np.linspace(0.0, 2e-5, 30)
    write_curve(Curve(np.arange(30.0), overlap, scan(law, overlap).force, np.zeros(30, np.int64), radius=1e-3), "measured.csv")
    Path("case.toml").write_text(CASE)
    assert execute(["run", "case.toml", "--out", "results", "--jobs", "1"]) == 0
    assert "4 results: 0 reused" in capfd.readouterr().out
    assert execute(["run", "case.toml", "--out", "results", "--jobs", "1"]) == 0
    assert "4 results: 4 reused" in capfd.readouterr().out
    page = Path("results/report.html").read_text(encoding="utf-8")
    assert "A case &lt;of&gt; &amp; its own" in page
    # namespaces are names, not links; a link would be a src, href or url() that leaves the page
    assert not re.search(r"""(src|href)=["'](?!#|data:)|url\((?!#)""", page)
    assert execute(["status", "results"]) == 0
    assert "scenes.small" in capfd.readouterr().out
