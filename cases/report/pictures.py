"""The README's picture, from the results of the quickstart: `python -m cases.report.pictures results/quickstart docs/pictures`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibration.residuals import follow
from cases.batch.results import load_case
from cases.batch.store import Record
from cases.report import history, plots
from contactlaws import fitted
from contactlaws.curve_files import read_curve


def main(results: Path, folder: Path) -> Path:
    """Write pipeline.png into `folder` from the curve, law and scenes of the quickstart in `results`."""
    _, records = load_case(results)
    there = {record.task: record for record in records if record is not None and record.usable}
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "pipeline.png"
    plots.png(pipeline(results, there), path)
    return path


@plots.styled
def pipeline(results: Path, there: dict[str, Record]) -> Figure:
    """The body, its curve with the fitted law, and the packing on that law, side by side."""
    figure = Figure(figsize=(11.0, 3.1), layout="constrained")
    body, curve_axis, packing = figure.subplots(1, 3, width_ratios=(1.45, 1.0, 1.0))
    plastic = there["curves.plastic"]
    curve = read_curve(results / plastic.files["curve"])
    stress, _ = plots.stress_scale(curve)
    plots.draw_section(figure, body, plots.fields_in(results / plastic.files["fields"], "loading")[-1], curve.radius, stress)
    body.set_anchor("N")  # so that the three titles stand on one line
    law = fitted.load(results / there["fits.edmans-sinka"].files["law"])
    _draw_curve(curve_axis, curve, law.law)
    _draw_scenes(packing, {name: history.read(results / there[f"scenes.{name}"].files["history"]) for name in ("plastic", "elastic")})
    for axis, title in (
        (body, "1  a body of NMC, pressed"),
        (curve_axis, "2  its curve, and a law fitted to it"),
        (packing, "3  250 spheres on that law"),
    ):
        axis.set_title(title, fontweight="bold", pad=9)
    return figure


def _draw_curve(axis: Axes, curve: Any, law: Any) -> None:
    stress, _ = plots.stress_scale(curve)
    area = math.pi * curve.radius**2 * stress
    for branch in (0, *curve.unloadings):
        rows = curve.rows(branch)
        x = curve.overlap[rows] / curve.radius
        axis.plot(
            x, curve.force[rows] / area, color="#c2c2c2", lw=3.6, solid_capstyle="butt", label="finite elements" if branch == 0 else None
        )
        axis.plot(x, follow(law, curve, branch).force / area, color=plots.COLOURS[1], lw=1.0, label="fitted law" if branch == 0 else None)
    axis.set(xlabel="overlap $\\delta/R$", ylabel=r"force $F/(\pi R^2 Y)$", xlim=(0, None), ylim=(0, None))
    axis.legend(loc="upper left")


def _draw_scenes(axis: Axes, histories: dict[str, dict[str, Any]]) -> None:
    for (name, values), colour in zip(histories.items(), plots.COLOURS[1::-1], strict=True):
        axis.plot(100 * values["strain_z"], np.asarray(values["stress_zz"]) / 1e6, color=colour, lw=1.2, label=f"{name} law")
    axis.set(xlabel="axial strain (%)", ylabel="axial stress (MPa)", xlim=(0, None), ylim=(0, None))
    axis.legend(loc="upper left")


if __name__ == "__main__":
    print(main(Path(sys.argv[1]), Path(sys.argv[2])))
