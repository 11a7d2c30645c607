"""What is there after a study whose processes were killed, held against what should be."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from cases.batch import results
from cases.batch.store import Record, load, record_path
from cases.batch.worker import DEATHS
from cases.verification.solver_runs import Line, lines, name_of
from contactlaws.material import Material

#: columns of tables that measure time, or name the sources' release
MEASURED = ("cpu_seconds", "solver_cpu_seconds")
TABLES = ("curves.csv", "unloadings.csv", "table.csv")
DONE, FAILED = 0, 3  # exit codes of `fe2dem run`


class Expected(NamedTuple):
    """How a row is to end."""

    lethal: str | None = None  # bodies of this Poisson's ratio kill their process, and fail


class Verdict(NamedTuple):
    """One row of the table."""

    row: str
    done: str
    expected: str
    counted: str
    sound: bool

    def sentence(self) -> str:
        """As shown."""
        start = "" if self.sound else "NOT AS EXPECTED: "
        return f"{start}{self.row}: {self.done} Expected: {self.expected}. Counted: {self.counted}."


class Count(NamedTuple):
    """What the lines of the solver's runs say, and the records."""

    bodies: int
    whole: int  # results that are there, their files as they were written
    failed: int  # that say why
    begun: int
    again: int  # begun when the result was there
    together: int  # begun when another process was at it, which came to its end


def judged(row: str, done: str, folder: Path, code: int, killed: Sequence[int], expected: Expected, reference: Path) -> Verdict:
    """Count what is there in `folder`, and hold it against what is expected, and the tables against those of `reference`."""
    found = counted(folder)
    wrong = list(_wrong(found, code, killed, expected))
    wrong += [] if expected.lethal or folder == reference else list(different_tables(folder / "results", reference / "results"))
    lethal = found.failed if expected.lethal else 0
    wanted = f"{found.bodies - lethal} done, {found.bodies + lethal * (DEATHS - 1)} begun, at most {len(killed)} more"
    if lethal:
        wanted += f"; {lethal} failed"
    text = f"{found.whole} done, {found.begun} begun"
    if found.failed:
        text += f", {found.failed} failed"
    text += f", {len(killed)} killed at work; {found.again} twice, {found.together} at once"
    if not expected.lethal and folder != reference:
        text += "; tables differ" if any("differs" in word or "is missing" in word for word in wrong) else "; same tables"
    return Verdict(row, done, wanted, text + "".join(f"; WRONG: {word}" for word in wrong), not wrong)


def _wrong(found: Count, code: int, killed: Sequence[int], expected: Expected) -> Iterator[str]:
    if code != (FAILED if expected.lethal else DONE):
        yield f"exit code {code}"
    if found.whole + found.failed != found.bodies or bool(found.failed) != bool(expected.lethal):
        yield f"{found.whole} whole and {found.failed} failed of {found.bodies}"
    if found.again:
        yield "done twice"
    if found.together:
        yield "two at once"
    least = found.bodies + found.failed * (DEATHS - 1)
    if not least <= found.begun <= least + len(killed):
        yield f"{found.begun} begun"


def counted(folder: Path) -> Count:
    """Of the curves of a run whose solver counted."""
    case = json.loads((folder / "results" / "case.json").read_text(encoding="utf-8"))
    wanted = [item for item in case["tasks"] if item["task"].startswith("curves.")]
    logs = lines(folder / "runs")
    whole = failed = again = 0
    for item in wanted:
        record = load(folder / "results", item["task"], item["key"], verify=True)
        whole += record is not None and record.state == "done"
        failed += _died(record)
        again += _again(folder / "results", item, record, logs)
    begun = sum(line.what == "begin" for log in logs.values() for line in log)
    return Count(len(wanted), whole, failed, begun, again, sum(map(together, logs.values())))


def _died(record: Record | None) -> bool:
    return record is not None and record.state == "failed" and f"killed {DEATHS} times" in str(record.reason)


def _again(folder: Path, item: Mapping[str, Any], record: Record | None, logs: Mapping[str, Sequence[Line]]) -> int:
    """How often a body was begun after its record had been written."""
    if record is None:
        return 0
    written = record_path(folder, item["task"], item["key"]).stat().st_mtime
    log = logs.get(name_of(Material(**item["values"]["material"])), ())
    return sum(line.what == "begin" and line.time > written for line in log)


def together(log: Sequence[Line]) -> int:
    """How often a body was begun by a second process when the first was at it, and came to its end.

    >>> log = [Line("begin", 1, 0.0), Line("begin", 2, 1.0), Line("end", 1, 2.0), Line("end", 2, 3.0)]
    >>> together(log), together(log[:2] + log[3:])
    (1, 0)
    """
    found, ends = 0, {(line.process, place) for place, line in enumerate(log) if line.what == "end"}
    for place, line in enumerate(log):
        if line.what == "begin" and place and log[place - 1].what == "begin":
            found += any(process == log[place - 1].process and when > place for process, when in ends)
    return found


def different_tables(folder: Path, reference: Path) -> Iterator[str]:
    """Tables that are not the same to the bit, but for the time that was measured."""
    for name in TABLES:
        if not (folder / name).exists():
            yield f"{name} is missing"
        elif without_times(folder / name) != without_times(reference / name):
            yield f"{name} differs"
    case, other = results.load_case(folder)[1], results.load_case(reference)[1]
    if [_hash(record) for record in case] != [_hash(record) for record in other]:
        yield "a curve differs"


def _hash(record: Record | None) -> Any:
    return None if record is None else (record.task, record.key, record.summary.get("hash"))


def without_times(path: Path) -> list[list[str]]:
    """The texts of a table, without the columns of CPU time."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    kept = [place for place, name in enumerate(rows[0]) if name not in MEASURED]
    return [[row[place] for place in kept] for row in rows]
