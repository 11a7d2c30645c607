"""What the report's figures show."""

from __future__ import annotations

import numpy as np
import pytest

from cases.report import plots


def test_layers_of_energy_add_up_to_the_work() -> None:
    """Every term has its layer, so that the top of the stack is the dashed line; what is nothing has none, nor a place in the legend."""
    time = np.linspace(0.0, 1.0, 11)
    terms = {"dissipated": 1e-9 * time, "rubbed": 3e-9 * time**2, "stored": 5e-9 * time, "kinetic": 0.0 * time, "sheared": 1e-9 * time}
    values = {name: terms.get(name, np.zeros(11)) for name in plots.LAYERS} | {"time": time, "boundary_work": sum(terms.values())}
    figure = plots.energies(values)
    axis = figure.axes[0]
    tops = [max(path[:, 1].max() for path in (layer.get_paths()[0].vertices,)) for layer in axis.collections]
    (line,) = axis.lines
    assert len(tops) == 4
    assert max(tops) == pytest.approx(line.get_ydata()[-1], rel=1e-12)
    said = [text.get_text() for text in axis.get_legend().get_texts()]
    assert "rubbed off by friction" in said
    assert "kinetic" not in said
