"""What a person sees in the terminal: progress, tables, and one line for each thing that was written."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Table

from cases.batch.store import Record
from cases.doctor import Finding

out = Console(highlight=False, soft_wrap=True)
log = Console(stderr=True, highlight=False, soft_wrap=True)
MARKS = {"ok": "[green]ok[/]", "missing": "[red]missing[/]", "optional": "[yellow]optional[/]"}
#: correlation coefficient, in magnitude, beyond which two parameters are named as hardly told apart
CORRELATED = 0.9
COLOURS = {"done": "green", "stopped": "yellow", "failed": "red"}


def bars() -> Bars:
    columns = (TextColumn("{task.description}"), BarColumn(24), TextColumn("{task.fields[text]}"), TimeElapsedColumn())
    return Bars(*columns, console=log, transient=True, disable=not log.is_terminal)


@contextlib.contextmanager
def bar(name: str) -> Iterator[Callable[[float, str], None]]:
    """A progress bar on stderr, where that is a terminal; yields the callback that moves it."""
    with bars() as shown:
        task = shown.add_task(name, total=1.0, text="")
        yield lambda fraction, text: shown.update(task, completed=fraction, text=text)


def one_line(record: Record) -> str:
    return escape(" | ".join((record.reason or "").splitlines()))


def sheet(*columns: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for index, column in enumerate(columns):
        table.add_column(column, justify="left" if index == 0 else "right", overflow="fold")
    return table


def number(value: object, digits: int = 4) -> str:
    """A number with so many digits; a dash for one that isn't there."""
    return "–" if value is None else f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def percent(value: float | None) -> str:
    """A relative error."""
    if value is None:
        return "–"
    return "< 0.01 %" if value < 1e-4 else f"{100 * value:.2g} %"


def show_curve(curve: Any, path: Path) -> None:
    """Where a curve was written, what it reaches, how wrong it may be, what it cost."""
    rows = curve.rows(0)
    out.print(f"{path}: {curve.overlap.size} states, {len(curve.unloadings)} unloadings, curve {curve.content_hash}")
    out.print(f"largest overlap {curve.overlap[rows][-1]:.6g} m, force {curve.force[rows][-1]:.6g} N")
    if curve.yield_overlap is not None:
        out.print(f"first yield at overlap {curve.yield_overlap:.6g} m")
    # the exponent's error is absolute
    errors = [f"{name} {number(value, 2) if name == 'unloading_exponent' else percent(value)}" for name, value in curve.errors.items()]
    out.print("estimated errors: " + (", ".join(errors) or "none stated"))
    cost = curve.provenance.get("cpu_seconds")
    if cost is not None:
        out.print(f"cost: {number(cost)} CPU s")


def show_fit(fit: Any, path: Path | None) -> None:
    """Parameters with errors, residual measures, warnings."""
    table = sheet("parameter", "value", "standard error")
    for name, value in _parameters(fit):
        table.add_row(
            escape(name), number(float(value), 7), number(fit.standard_errors.get(name), 2) if name in fit.standard_errors else "given"
        )
    out.print(f"{fit.fitted.name}: {fit.fitted.source}")
    out.print(table)
    out.print(
        "differences from the curves: "
        + ", ".join(f"{k.replace('_', ' ')} {percent(v)}" for k, v in fit.residuals._asdict().items() if v is not None)
    )
    out.print(f"good up to overlap {fit.fitted.max_overlap:.4g} m; condition number {number(fit.condition_number, 3)}")
    out.print(correlations(fit.free, fit.correlation))
    for warning in fit.warnings:
        log.print(f"[yellow]warning[/] {escape(warning)}")
    if path is not None:
        out.print(f"saved: {path}")


def _parameters(fit: Any) -> Iterator[tuple[str, float]]:
    """Those that are numbers, and the numbers of rows that were fitted; tables that a law is made of are left out."""
    for name, value in zip(fit.law._fields, fit.law, strict=True):
        if not hasattr(value, "shape"):
            yield name, value
        elif value.ndim == 1 and f"{name}[1]" in fit.standard_errors:
            yield from ((f"{name}[{place}]", number) for place, number in enumerate(value.tolist(), 1))


def show_trials(trials: Iterable[Any], quantity: str, tolerance: float) -> None:
    """The laws that were tried for a tolerance, the last being the one that keeps it."""
    table = sheet("law, from the cheapest on", "ns per contact", f"differs in {quantity.replace('_', ' ')} by", "")
    for trial in trials:
        kept = trial.error is not None and trial.error <= tolerance
        remark = escape((trial.reason or "").splitlines()[0][:80]) if trial.reason else "taken" if kept else ""
        table.add_row(trial.law, f"{trial.nanoseconds:.0f}", percent(trial.error), remark)
    table.columns[3].justify = "left"
    out.print(table)


def correlations(names: Sequence[str], matrix: Any) -> str:
    """The pairs of fitted parameters that the curves can hardly tell apart; NaN, of those they say nothing about, is no correlation.

    >>> correlations(("a", "b", "c"), [[1.0, -0.95, 0.3], [-0.95, 1.0, float("nan")], [0.3, float("nan"), 1.0]])
    'correlations beyond 0.9: a/b -0.950'
    """
    pairs = [(names[i], names[j], matrix[i][j]) for j in range(len(names)) for i in range(j)]
    high = [f"{first}/{second} {value:+.3f}" for first, second, value in pairs if abs(value) > CORRELATED]
    return f"correlations beyond {CORRELATED:g}: {', '.join(high) or 'none'}"


def show_findings(findings: Iterable[Finding]) -> None:
    """One row per finding of the doctor."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_header=False)
    for finding in findings:
        table.add_row(finding.name, MARKS[finding.state], escape(finding.text))
    out.print(table)


def show_laws(laws: Mapping[str, Any]) -> None:
    """One row per law."""
    table = Table("law", "a contact remembers", "source", box=box.SIMPLE_HEAD, pad_edge=False)
    for law in laws.values():
        table.add_row(law.name, ", ".join(name.replace("_", " ") for name in law.memory) or "nothing", law.source)
    out.print(table)


def show_impact(table: Any, law: str, warnings: Iterable[str]) -> None:
    """One row per speed, and a warning where the law is extrapolated."""
    shown = sheet("speed (m/s)", "restitution", "contact time (s)", "largest overlap of the pair (m)")
    for speed, e, duration, overlap in zip(*(column.tolist() for column in table), strict=True):
        shown.add_row(number(speed, 5), f"{e:.6f}", number(duration, 5), number(overlap, 5))
    out.print(f"two equal spheres on {law}")
    out.print(shown)
    for warning in warnings:
        log.print(f"[yellow]warning[/] {escape(warning)}")
