"""What the figures share: axes, one colour for each E/Y and each overlap, legends beside the axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cases.report.plots import GREY, styled

__all__ = ["GREY", "Picture", "beside", "colour_of_depth", "colour_of_modulus", "new_figure", "styled"]

D_MAX = r"overlap before unloading $\bar\delta_{max} = \delta_{max}/R_0$"
E_BAR = r"stiffness ratio $\bar E = E/\sigma_y$"
RHO = r"unloading stiffness $\rho = 1/(\bar\delta_{max}-\bar\delta_0)$"
ALPHA = r"unloading exponent $\alpha$"


class Picture(NamedTuple):
    """A figure with its number in the paper (None: ours), title and caption."""

    number: str | None
    title: str
    figure: Figure
    caption: str

    @property
    def name(self) -> str:
        """The stem of its file."""
        return f"figure_{self.number.zfill(2)}" if self.number else "beyond_" + "_".join(self.title.lower().split()[:3])


class Drawn(NamedTuple):
    """A picture as SVG, drawn once for the page and for its file."""

    picture: Picture
    svg: str


def new_figure(width: float, height: float, *shape: int, **settings: Any) -> tuple[Figure, Any]:
    """A figure and its axes."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(*shape, **settings)


def colour_of_modulus(modulus: float) -> Any:
    """From dark (E/Y = 1) to light (1000)."""
    return matplotlib.colormaps["plasma"](np.clip(np.log10(max(modulus, 1e-9)) / 3.0, 0.0, 1.0) * 0.88)


def colour_of_depth(depth: float) -> Any:
    """From dark (.01) to light (.5)."""
    return matplotlib.colormaps["viridis"](np.clip((np.sqrt(depth) - 0.1) / (np.sqrt(0.5) - 0.1), 0.0, 1.0) * 0.92)


def beside(figure: Figure, axis: Axes, title: str | None = None) -> None:
    """All that is labelled in `axis`, in a legend to the right of the figure."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", title=title, alignment="left", handlelength=1.8, labelspacing=0.35)


def panel_titles(axes: Iterable[Axes], titles: Iterable[str]) -> None:
    """(a), (b), ... before each title."""
    for letter, (axis, title) in zip("abcdefgh", zip(axes, titles, strict=True), strict=False):
        axis.set_title(f"({letter}) {title}")
