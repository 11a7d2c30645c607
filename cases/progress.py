"""What a person sees of a run while it goes on: a line for each result of a small one, the pace and the failures of a large one."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType

from rich.markup import escape
from rich.progress import TaskID

from cases.batch import pace
from cases.batch.store import Record
from cases.batch.task import Task
from cases.console import COLOURS, bars, log, one_line, out

#: a run of more tasks is shown as a whole
FEW = 40
#: of a large run, so many failures are shown as they happen, and so many reasons at its end
FAILURES, REASONS = 10, 8
#: s between two lines on the pace where there is no terminal; each comes later than the one before, so that a log of days stays short
FIRST_LINE, SLOWER = 10.0, 1.5


class Progress:
    """Watches a run, and leaves word in its folder for `fe2dem status`."""

    def __init__(self, tasks: Sequence[Task], jobs: int = 1, folder: Path | None = None) -> None:
        self._bars = bars()
        self._shown: dict[str, TaskID] = {}
        self._pace = pace.Pace(tasks, jobs)
        self._few = len(tasks) <= FEW
        self._whole: TaskID | None = None
        self._folder = folder
        self._reused: set[str] = set()
        self._said: set[str] = set()  # notes, which many scenes have in common
        self._warned: Counter[str] = Counter()
        self._next_note = self._next_line = 0.0
        self._interval = FIRST_LINE

    def __enter__(self) -> Progress:
        self._bars.start()
        if not self._few:
            self._whole = self._bars.add_task("all", total=float(self._pace.total), text="")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bars.stop()
        if self._folder is not None:
            pace.remove_note(self._folder)

    def reused(self, task: Task, record: Record) -> None:
        """A result that is there already."""
        self._reused.add(task.id)
        self._pace.reused(task)
        if self._few:
            cost = f"  ({record.cpu_seconds:.1f} CPU s when it was made)"
            log.print(f"[cyan]reused[/]   {task.id}" + (f": {one_line(record)}" if record.reason else cost))
        self._say_how_good(record)

    def started(self, task: Task) -> None:
        """A task has been handed to a process."""
        if self._few:  # beside long names, a narrow terminal has no room for how the whole run goes
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
        self._pace.finished(task, record)
        if task.id in self._shown:
            self._bars.remove_task(self._shown.pop(task.id))
        if self._few or (record.state != "done" and self._pace.failed <= FAILURES):
            told = one_line(record) if record.reason else f"{record.cpu_seconds:.1f} CPU s"
            log.print(f"[{COLOURS[record.state]}]{record.state:8}[/] {task.id}: {told}")
            if not self._few and self._pace.failed == FAILURES:
                log.print("         further failures are counted only")
        for text in record.summary.get("notes", ()):  # a short scene may be over before its messages arrive
            self._note(task, text)
        self._say_how_good(record)

    def waiting(self) -> None:
        """Nothing to do but to wait: time to say how it goes."""
        now = time.monotonic()
        if self._whole is not None:
            self._bars.update(self._whole, completed=float(self._pace.done), text=self._pace.sentence())
            if not log.is_terminal and now >= self._next_line and (self._next_line == 0.0 or self._pace.computed):
                log.print(self._pace.sentence())
                self._next_line, self._interval = now + self._interval, self._interval * SLOWER
        if self._folder is not None and now >= self._next_note:
            pace.write_note(self._folder, self._pace)
            self._next_note = now + pace.NOTE_EVERY

    def _note(self, task: Task, text: str) -> None:
        """A line on what is computed and what is left out, or what is wrong with that; once even if several scenes say it."""
        if text not in self._said:
            self._said.add(text)
            kind = "[yellow]warning[/] " if text.startswith("warning: ") else "[dim]note[/]    "
            log.print(f"{kind} {task.id}: {escape(text.removeprefix('warning: '))}")

    def _say_how_good(self, record: Record) -> None:
        """The measures that a scene is judged by, and whatever a result warns of."""
        statistics = record.summary.get("statistics")
        if statistics and self._few:
            deepest = statistics["time_step_over_critical_at_largest_overlap"]
            how = f"{statistics['steps']:,} iterations to states of rest"
            if statistics["dt_over_critical"]:
                fraction = max(statistics["dt_over_critical"])
                how = (
                    f"energy balance closes to {statistics['energy_balance']:.2g}; time step up to {fraction:.3g} of the critical one "
                    f"({deepest:.3g} at the largest overlap that was reached)"
                )
            log.print(f"         {record.task}: {how}")
        if self._few and "worst_overlap" in record.summary:
            fraction, overlap = record.summary["packing_fraction"], record.summary["worst_overlap"]
            log.print(f"         {record.task}: packing fraction {fraction:.4f}, worst overlap {max(overlap, 0.0):.2g} of a radius")
        warnings = [text for text in dict.fromkeys(record.summary.get("warnings", ())) if text != record.reason]  # stages may repeat one
        if self._few:
            for warning in warnings:
                log.print(f"[yellow]warning[/]  {record.task}: {escape(warning)}")
        self._warned[record.kind] += bool(warnings)

    def summarise(self, records: Iterable[Record]) -> None:
        """One line for the whole run; of a large one also what it warned of and why what failed."""
        records = list(records)
        bad = [record for record in records if record.state != "done"]
        new = sum(record.cpu_seconds for record in records if record.task not in self._reused)
        computed = self._pace.total - len(self._reused)
        text = f"{self._pace.total} results: {len(self._reused)} reused, {computed} computed"
        cost = f"; this run took {new:.1f} CPU s in {pace.duration(self._pace.elapsed)}" if computed else ""
        out.print(f"{text}, [red]{len(bad)} failed or stopped early[/]" + cost if bad else text + cost)
        if not self._few:
            for line in (*reasons(bad), *self._warnings()):
                log.print(line)

    def _warnings(self) -> Iterable[str]:
        for kind, count in self._warned.items():
            if count:
                yield f"[yellow]warning[/]  {count} of the {kind} carry a warning; the tables say which"


def reasons(records: Iterable[Record]) -> list[str]:
    """One line for each reason why results are not done, the most frequent first."""
    groups: dict[tuple[str, str], list[str]] = {}
    for record in records:
        groups.setdefault((record.state, one_line(record)), []).append(record.task)
    lines = []
    for (state, reason), names in sorted(groups.items(), key=lambda group: -len(group[1])):
        others = f" and {len(names) - 1} more" if len(names) > 1 else ""
        lines.append(f"[{COLOURS[state]}]{state:8}[/] {names[0]}{others}: {reason}")
    return lines if len(lines) <= REASONS else [*lines[:REASONS], f"         and {len(lines) - REASONS} more reasons: see curves.csv"]
