"""The pictures of the report, each a figure made from records and files; nothing is drawn that was not computed."""

from __future__ import annotations

import functools
import io
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from calibration.residuals import follow
from cases.report.closed_forms import thornton_restitution, yield_speed
from contactlaws.curve import Curve
from contactlaws.elastoplastic import Thornton

P = ParamSpec("P")
R = TypeVar("R")

#: black for the continuum, then colours that stay apart for every kind of colour vision (Okabe & Ito)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
GREY = "#8a8a8a"
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "svg.hashsalt": "fe2dem",  # the same results give the same file
    "savefig.dpi": 180,
}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Everything that `draw` makes is in this project's style, whatever the caller's settings are."""

    @functools.wraps(draw)
    def drawn(*arguments: P.args, **options: P.kwargs) -> R:
        with matplotlib.rc_context(STYLE):
            return draw(*arguments, **options)

    return drawn


@styled
def svg(figure: Figure) -> str:
    """The figure as SVG text without XML head, to stand in an HTML page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


@styled
def png(figure: Figure, path: Path) -> None:
    """The figure as a PNG file."""
    figure.savefig(path, format="png", metadata={"Software": None})


def _figure(width: float, height: float, *shape: int, **settings: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(*shape, **settings)


def stress_scale(curve: Curve) -> tuple[float, str]:
    """What forces over pi R^2 are divided by, and how that's written."""
    material = curve.material
    if material is not None and material.yield_stress is not None:
        return material.yield_stress, "Y"
    return (material.youngs_modulus, "E") if material is not None else (1.0, r"1\,\mathrm{Pa}")


@styled
def curve_against_laws(curve: Curve, laws: Mapping[str, Any], colours: Mapping[str, str]) -> Figure:
    """Force and contact radius of one curve with the laws followed along it, and below each what is left between them."""
    figure, axes = _figure(9.2, 4.9, 2, 2, sharex=True, gridspec_kw={"height_ratios": [2.6, 1]})
    scale, symbol = stress_scale(curve)
    area = math.pi * curve.radius**2 * scale
    columns = [("force", area, rf"force $F/(\pi R^2 {symbol})$")]
    if curve.contact_radius is not None:
        columns.append(("contact_radius", curve.radius, "contact radius $a/R$"))
    else:
        axes[0, 1].set_visible(False)
        axes[1, 1].set_visible(False)
    for (name, unit, label), (top, bottom) in zip(columns, axes.T, strict=False):
        _compare(curve, laws, colours, name, unit, top, bottom)
        top.set_ylabel(label)
        top.set_ylim(bottom=0)
        bottom.set_ylabel("law − FE\n(% of largest)")
        bottom.set_xlabel("overlap $\\delta/R$")
        bottom.set_xlim(left=0)
    axes[0, 0].legend(loc="upper left")
    return figure


def _compare(curve: Curve, laws: Mapping[str, Any], colours: Mapping[str, str], name: str, unit: float, top: Axes, bottom: Axes) -> None:
    values = np.asarray(getattr(curve, name)) / unit
    largest = float(values.max())
    bottom.axhspan(-100 * curve.errors.get(name, 0.0), 100 * curve.errors.get(name, 0.0), color=GREY, alpha=0.25, lw=0)
    bottom.axhline(0, color="black", lw=0.7)
    for branch in (0, *curve.unloadings):
        rows = curve.rows(branch)
        x = curve.overlap[rows] / curve.radius
        top.plot(x, values[rows], color="#c2c2c2", lw=3.4, solid_capstyle="butt", label="finite elements" if branch == 0 else None)
        for law_name, law in laws.items():
            colour = colours[law_name]
            law_values = getattr(follow(law, curve, branch), name) / unit
            top.plot(x, law_values, color=colour, lw=1.0, label=law_name if branch == 0 else None)
            bottom.plot(x, 100 * (law_values - values[rows]) / largest, color=colour, lw=1.0)


class Field:
    """A deformed mesh with its values, read from a .vtu file."""

    def __init__(self, path: Path) -> None:
        import meshio

        mesh = meshio.read(path)
        quads = [(block.data, index) for index, block in enumerate(mesh.cells) if block.type == "quad"]
        self.points = mesh.points[:, :2]
        self.corners, block = quads[0]
        self.point_data = mesh.point_data
        self.cell_data = {name: values[block] for name, values in mesh.cell_data.items()}
        self.depth = float(path.stem.rpartition("_D")[2])

    @property
    def polygons(self) -> Any:
        """Corners of every cell, shape (cells, 4, 2)."""
        return self.points[self.corners]


def fields_in(folder: Path, prefix: str) -> list[Field]:
    """The states of one kind, from the smallest to the largest overlap."""
    return sorted((Field(path) for path in folder.glob(f"{prefix}_D*.vtu")), key=lambda field: field.depth)


@styled
def pressure_profiles(fields: Sequence[Field], stress: float, symbol: str) -> Figure:
    """Contact pressure over the distance from the axis, both over what the state itself gives: its radius, and Y or E."""
    figure, axis = _figure(4.4, 3.2)
    for field, shade in zip(fields, _shades(len(fields)), strict=True):
        touching = np.flatnonzero(field.point_data["contact_pressure"] > 0)
        order = touching[np.argsort(field.points[touching, 0])]
        radius, pressure = field.points[order, 0], field.point_data["contact_pressure"][order] / stress
        axis.plot(radius / radius.max(), pressure, color=shade, marker="o", ms=2.2, lw=1.0, label=rf"$\delta/R = {field.depth:g}$")
    axis.set(xlabel="distance from the axis over contact radius $r/a$", ylabel=f"contact pressure $p/{symbol}$", xlim=(0, 1.05))
    axis.set_ylim(bottom=0)
    axis.legend(loc="lower left")
    return figure


def _shades(count: int) -> list[Any]:
    return [matplotlib.colormaps["viridis"](value) for value in np.linspace(0.15, 0.8, max(count, 1))[:count]]


@styled
def section(field: Field, radius: float, yield_stress: float) -> Figure:
    """The deformed meridian section: von Mises stress on the left, plastic strain on the right of the axis; the flat lies on top."""
    figure, axis = _figure(5.6, 3.4)
    draw_section(figure, axis, field, radius, yield_stress)
    return figure


def draw_section(figure: Figure, axis: Axes, field: Field, radius: float, yield_stress: float) -> None:
    """Draw `section` into given axes."""
    stress = field.cell_data["von_mises"].ravel() / yield_stress
    strain = field.cell_data["equivalent_plastic_strain"].ravel()
    shape = field.polygons / radius
    halves = (
        (shape * [-1, 1], stress, "cividis", Normalize(0, 1), "von Mises stress $/Y$", "left"),
        (
            shape,
            np.ma.masked_less_equal(strain, 0.0),
            "YlOrRd",
            Normalize(0, _round_up(strain.max())),
            "plastic strain (grey: elastic)",
            "right",
        ),
    )
    for polygons, values, colours, norm, label, side in halves:
        axis.add_collection(PolyCollection(polygons, facecolors="#dcdcdc", edgecolors="face", linewidths=0.1, rasterized=True))
        cells = PolyCollection(polygons, array=values, cmap=colours, norm=norm, edgecolors="face", linewidths=0.1, rasterized=True)
        axis.add_collection(cells)
        figure.colorbar(cells, ax=axis, location=side, shrink=0.75, aspect=22, pad=0.02, label=label)
    top, wide = float(shape[..., 1].max()), float(shape[..., 0].max())
    axis.plot([-wide, wide], [top, top], color="black", lw=1.2)
    axis.plot([0, 0], [0, top], color="white", lw=0.6)
    axis.set(xlim=(-1.03 * wide, 1.03 * wide), ylim=(-0.01, 1.02 * top), aspect="equal", xticks=[], yticks=[])
    for spine in axis.spines.values():
        spine.set_visible(False)


def _round_up(value: float) -> float:
    """To one digit, for the end of a colour scale."""
    if value <= 0:
        return 1.0
    digit = 10.0 ** math.floor(math.log10(value))
    return math.ceil(value / digit) * digit


@styled
def restitution(
    tables: Mapping[str, Mapping[str, Any]], thornton: Thornton | None, density: float, radius: float, colours: Mapping[str, str]
) -> Figure:
    """Coefficient of restitution against speed, with Thornton's closed form for the yield speed of his law beside it."""
    figure, axis = _figure(5.2, 3.2)
    speeds = np.concatenate([np.asarray(table["speed"], dtype=float) for table in tables.values()])
    if thornton is not None:
        slowest = yield_speed(thornton, radius, density)
        line = np.geomspace(speeds.min(), speeds.max(), 200)
        closed = [thornton_restitution(speed / slowest) for speed in line]
        axis.plot(line, closed, color="#c2c2c2", lw=3.4, label="Thornton 1997, closed form")
        axis.axvline(slowest, color=GREY, lw=0.7, ls=":")
        axis.annotate("first yield", (slowest, 0.02), xycoords=("data", "axes fraction"), rotation=90, fontsize=7, color=GREY, ha="right")
    for name, table in tables.items():
        axis.plot(table["speed"], table["restitution"], "o-", color=colours[name], ms=3.5, lw=1.0, label=name)
    axis.set(xscale="log", xlabel="closing speed (m/s)", ylabel="coefficient of restitution $e$", ylim=(0, 1.03))
    axis.legend(loc="lower left")
    return figure


@styled
def stress_strain(histories: Mapping[str, Mapping[str, Any]], colours: Mapping[str, str]) -> Figure:
    """Axial stress and coordination number over axial strain; the way back is thinner."""
    figure, axes = _figure(9.2, 3.2, 1, 2)
    for name, values in histories.items():
        turn = int(np.argmax(values["strain_z"]))
        for part, width in ((slice(0, turn + 1), 1.6), (slice(turn, None), 0.8)):
            strain = 100 * values["strain_z"][part]
            label = name if part.start == 0 else None
            axes[0].plot(strain, values["stress_zz"][part] / 1e6, color=colours[name], lw=width, label=label)
            axes[1].plot(strain, values["coordination_number"][part], color=colours[name], lw=width)
    axes[0].set(xlabel="axial strain (%)", ylabel="axial stress (MPa)")
    axes[1].set(xlabel="axial strain (%)", ylabel="coordination number")
    for axis in axes:
        axis.set_xlim(left=0)
        axis.set_ylim(bottom=0)
    axes[0].legend(loc="upper left")
    return figure


#: terms of the energy balance in the order of their layers, with names for people and colours
LAYERS = {
    "dissipated": ("dissipated in contacts", "#d9a066"),
    "rubbed": ("rubbed off by friction", "#c98f8f"),
    "dashed": ("taken by dampers", "#b8a4c9"),
    "damped": ("taken by the drag", "#e6cfa8"),
    "sheared": ("stored by friction", "#7fa3a0"),
    "stored": ("stored", "#9db9d3"),
    "kinetic": ("kinetic", "#b9cfb0"),
}
#: share of the largest energy below which a term has no layer
VISIBLE = 1e-3


@styled
def energies(values: Mapping[str, Any]) -> Figure:
    """Where the work of the boundary went, layer upon layer; the line is the work itself."""
    figure, axis = _figure(4.4, 3.0)
    terms = {name: np.asarray(values[name], dtype=float) for name in LAYERS}
    work = np.asarray(values["boundary_work"]) + sum(float(term[0]) for term in terms.values())
    largest = float(max(np.max(np.abs(work)), *(np.max(term) for term in terms.values())))
    unit, word = _energy_unit(largest)
    time = np.asarray(values["time"]) / max(float(values["time"][-1]), 1e-300)
    shown = [name for name, term in terms.items() if np.max(term) > VISIBLE * largest] or ["stored"]
    labels, colours = zip(*(LAYERS[name] for name in shown), strict=True)
    axis.stackplot(time, [terms[name] / unit for name in shown], labels=labels, colors=colours, lw=0)
    axis.plot(time, work / unit, color="black", lw=1.0, ls="--", label="work of the boundary")
    axis.set(xlabel="time over duration", ylabel=f"energy ({word})", xlim=(0, 1))
    axis.set_ylim(bottom=0)
    axis.legend(loc="upper left")
    return figure


def _energy_unit(size: float) -> tuple[float, str]:
    for unit, word in ((1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ")):
        if size >= unit:
            return unit, word
    return 1e-12, "pJ"
