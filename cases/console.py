"""What a person sees in the terminal: progress, tables, and one line for each thing that was written."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Table

from cases.batch.plan import Task
from cases.batch.store import Record
from cases.doctor import Finding

out = Console(highlight=False, soft_wrap=True)
log = Console(stderr=True, highlight=False, soft_wrap=True)
MARKS = {"ok": "[green]ok[/]", "missing": "[red]missing[/]", "optional": "[yellow]optional[/]"}
#: correlation coefficient, in magnitude, beyond which two parameters are named as hardly told apart
CORRELATED = 0.9
COLOURS = {"done": "green", "stopped": "yellow", "failed": "red"}


def _bars() -> Bars:
    columns = (TextColumn("{task.description}"), BarColumn(24), TextColumn("{task.fields[text]}"), TimeElapsedColumn())
    return Bars(*columns, console=log, transient=True, disable=not log.is_terminal)


@contextlib.contextmanager
def bar(name: str) -> Iterator[Callable[[float, str], None]]:
    """A progress bar on stderr, where that is a terminal; yields the callback that moves it."""
    with _bars() as bars:
        task = bars.add_task(name, total=1.0, text="")
        yield lambda fraction, text: bars.update(task, completed=fraction, text=text)


class Progress:
    """Watches a run: a bar for each task in work, and a line when one is finished."""

    def __init__(self, tasks: Sequence[Task]) -> None:
        self._bars = _bars()
        self._shown: dict[str, TaskID] = {}
        self._total = len(tasks)
        self._reused: set[str] = set()
        self._said: set[str] = set()  # notes, which many scenes have in common

    def __enter__(self) -> Progress:
        self._bars.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bars.stop()

    def reused(self, task: Task, record: Record) -> None:
        """A result that is there already."""
        self._reused.add(task.id)
        log.print(
            f"[cyan]reused[/]   {task.id}"
            + (f": {_one_line(record)}" if record.reason else f"  ({record.cpu_seconds:.1f} CPU s when it was made)")
        )
        _say_how_good(record)

    def started(self, task: Task) -> None:
        """A task has been handed to a process."""
        self._shown[task.id] = self._bars.add_task(task.id, total=1.0, text="")
        if not log.is_terminal:
            log.print(f"started  {task.id}")

    def advanced(self, task: Task, fraction: float, text: str) -> None:
        """A task says how far it is; what a scene says before its first step stays on the screen."""
        if fraction == 0.0 and task.kind == "scenes":
            self._note(task, text)
        if task.id in self._shown:
            self._bars.update(self._shown[task.id], completed=fraction, text=text)

    def finished(self, task: Task, record: Record) -> None:
        """A task has its record."""
        if task.id in self._shown:
            self._bars.remove_task(self._shown.pop(task.id))
        colour = COLOURS[record.state]
        log.print(
            f"[{colour}]{record.state:8}[/] {task.id}: " + (_one_line(record) if record.reason else f"{record.cpu_seconds:.1f} CPU s")
        )
        for text in record.summary.get("notes", ()):  # a short scene may be over before its messages arrive
            self._note(task, text)
        _say_how_good(record)

    def _note(self, task: Task, text: str) -> None:
        """A line on what is computed and what is left out, or what is wrong with that; once even if several scenes say it."""
        if text not in self._said:
            self._said.add(text)
            kind = "[yellow]warning[/] " if text.startswith("warning: ") else "[dim]note[/]    "
            log.print(f"{kind} {task.id}: {escape(text.removeprefix('warning: '))}")

    def summarise(self, records: Iterable[Record]) -> None:
        """One line for the whole run."""
        records = list(records)
        bad = sum(record.state != "done" for record in records)
        new = sum(record.cpu_seconds for record in records if record.task not in self._reused)
        text = f"{self._total} results: {len(self._reused)} reused, {self._total - len(self._reused)} computed"
        cost = f"; this run took {new:.1f} CPU s" if len(self._reused) < self._total else ""
        out.print(f"{text}, [red]{bad} failed or stopped early[/]" + cost if bad else text + cost)


def _say_how_good(record: Record) -> None:
    """The measures that a scene is judged by, and whatever a result warns of."""
    statistics = record.summary.get("statistics")
    if statistics:
        deepest = statistics["time_step_over_critical_at_largest_overlap"]
        log.print(
            f"         {record.task}: energy balance closes to {statistics['energy_balance']:.2g}; time step up to "
            f"{max(statistics['dt_over_critical']):.3g} of the critical one ({deepest:.3g} at the largest overlap that was reached)"
        )
    for warning in dict.fromkeys(record.summary.get("warnings", ())):  # several stages may warn of the same
        if warning != record.reason:
            log.print(f"[yellow]warning[/]  {record.task}: {escape(warning)}")


def _one_line(record: Record) -> str:
    return escape(" | ".join((record.reason or "").splitlines()))


def _table(*columns: str) -> Table:
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
    table = _table("parameter", "value", "standard error")
    for name, value in zip(fit.law._fields, fit.law, strict=True):
        if not hasattr(value, "shape"):
            table.add_row(
                name, number(float(value), 7), number(fit.standard_errors.get(name), 2) if name in fit.standard_errors else "given"
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


def correlations(names: Sequence[str], matrix: Any) -> str:
    """The pairs of fitted parameters that the curves can hardly tell apart; NaN, of those they say nothing about, is no correlation.

    >>> correlations(("a", "b", "c"), [[1.0, -0.95, 0.3], [-0.95, 1.0, float("nan")], [0.3, float("nan"), 1.0]])
    'correlations beyond 0.9: a/b -0.950'
    """
    pairs = [(names[i], names[j], matrix[i][j]) for j in range(len(names)) for i in range(j)]
    high = [f"{first}/{second} {value:+.3f}" for first, second, value in pairs if abs(value) > CORRELATED]
    return f"correlations beyond {CORRELATED:g}: {', '.join(high) or 'none'}"


def show_status(case: Mapping[str, Any], records: Sequence[Record | None]) -> None:
    """One row per task of the last run."""
    table = _table("task", "state", "CPU s", "key", "reason")
    for item, record in zip(case["tasks"], records, strict=True):
        state = "not there yet" if record is None else record.state
        cost = None if record is None else round(record.cpu_seconds, 1)
        table.add_row(item["task"], state, number(cost), item["key"], "" if record is None else _one_line(record))
    out.print(case["title"])
    out.print(table)


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
    shown = _table("speed (m/s)", "restitution", "contact time (s)", "largest overlap of the pair (m)")
    for speed, e, duration, overlap in zip(*(column.tolist() for column in table), strict=True):
        shown.add_row(number(speed, 5), f"{e:.6f}", number(duration, 5), number(overlap, 5))
    out.print(f"two equal spheres on {law}")
    out.print(shown)
    for warning in warnings:
        log.print(f"[yellow]warning[/] {escape(warning)}")
