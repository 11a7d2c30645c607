"""What processes note of their results is believed only while it is true; whatever becomes of the notes, the results say it."""

from __future__ import annotations

import json
import shutil
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from cases.batch import index, results, shards, store
from cases.batch.store import Record, hash_of
from cases.batch.task import Task
from tests.cases import stand_in

TASKS = [Task("curves", f"t{n}", {}, key=hash_of(n), input=hash_of("i", n)) for n in range(5)]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of five results, which are many: from three on, notes are read, and made anew."""
    monkeypatch.setattr(index, "WORTH", 3)
    results.declare(tmp_path, "title", tmp_path / "case.toml", "code", TASKS)
    for task in TASKS:
        store.save(tmp_path, record(task))
    return tmp_path


def record(task: Task, state: str = "done", reason: str | None = None) -> Record:
    return Record(task.id, task.key, state, reason, cpu_seconds=0.1, input=task.input, summary={"errors": {"force": 1 / 3}})


def states(folder: Path) -> list[str | None]:
    return [None if record is None else record.state for record in results.listing(folder).records]


def opened(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[str | None]:
    """`states`, where no record may be opened."""
    with monkeypatch.context() as patch:
        patch.setattr(store, "record_in", stand_in.refuse)
        return states(folder)


def notes(folder: Path) -> list[Path]:
    return stand_in.notes(folder, store.NOTES)


def test_many_results_are_known_without_opening_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert opened(folder, monkeypatch) == ["done"] * 5
    assert index.all_records(folder) == {store.record_name(task.id, task.key): record(task) for task in TASKS}


def test_what_has_changed_since_is_read(folder: Path) -> None:
    store.save(folder, record(TASKS[1], "failed", "since then"))
    store.record_path(folder, TASKS[2].id, TASKS[2].key).unlink()
    path = store.record_path(folder, TASKS[3].id, TASKS[3].key)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"state": "stopped"}))  # by hand: there is no note of it
    expected = ["done", "failed", None, "stopped", "done"]
    assert states(folder) == expected
    shutil.rmtree(shards.place(folder))
    assert states(folder) == expected


def test_notes_that_are_gone_are_made_anew(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also those of a folder that was copied, whose files all have another time."""
    shutil.rmtree(shards.place(folder))
    assert states(folder) == ["done"] * 5
    assert opened(folder, monkeypatch) == ["done"] * 5
    copied = Path(shutil.copytree(folder, folder / "copy", copy_function=shutil.copyfile))
    assert states(copied) == ["done"] * 5
    assert opened(copied, monkeypatch) == ["done"] * 5
    assert len(notes(copied)) == 1  # in place of those of the other files


def names(folder: Path) -> list[str]:
    return [entry[0] for entry in shards.read(folder, store.NOTES).entries]


def test_a_note_cut_off_at_any_byte_takes_no_other_along(folder: Path) -> None:
    """The process was killed, and another of its number goes on in the same file."""
    (path,) = notes(folder)
    content, all_names = path.read_bytes(), names(folder)
    end = len(content) - 1  # what is cut off there lacks its line break only, which the next one brings
    for cut in range(content.rindex(b"\n", 0, end), len(content) + 1):
        path.write_bytes(content[:cut])
        assert names(folder) == all_names[: 5 if cut > end else 4]
        shards.add(folder, store.NOTES, '["next", 0, 0, {}]')
        assert names(folder) == [*all_names[: 5 if cut >= end else 4], "next"]
    path.write_bytes(content[:-99])
    assert states(folder) == ["done"] * 5


@pytest.mark.parametrize("torn", [b"", b"\0" * 700, b"x" * 700, b"\n" * 700, b'\n00000000 ["torn"]\n', bytes(range(256)) * 3])
def test_what_a_power_cut_leaves_in_notes_is_not_believed(folder: Path, torn: bytes) -> None:
    (path,) = notes(folder)
    content = path.read_bytes()
    path.write_bytes(content[:300] + torn + content[1000:])
    assert 1 <= len(names(folder)) <= 4
    assert states(folder) == ["done"] * 5
    for found in notes(folder):
        found.write_bytes(torn)
    assert names(folder) == []
    assert states(folder) == ["done"] * 5


def test_a_digit_that_turned_is_found(folder: Path) -> None:
    (path,) = notes(folder)
    path.write_bytes(path.read_bytes().replace(b'"cpu_seconds": 0.1', b'"cpu_seconds": 0.2', 1))
    assert [record.cpu_seconds for record in results.listing(folder).records if record is not None] == [0.1] * 5


@pytest.mark.parametrize("lie", ["another's content", "other files", "no record", "another release's", "no entry", "unheard of"])
def test_a_note_that_says_what_cannot_be_is_not_believed(folder: Path, lie: str) -> None:
    """Whole lines with the right stamp, which are later than the true ones."""
    path = store.record_path(folder, TASKS[0].id, TASKS[0].key)
    wrong = vars(record(TASKS[0], "failed", "a lie"))
    content: object = {
        "another's content": vars(record(TASKS[1], "failed", "a lie")),
        "other files": wrong | {"files": {"curve": "x"}},
        "no record": ["a lie"],
        "another release's": wrong | {"colour": "red"},
        "no entry": None,
        "unheard of": {},
    }[lie]
    entry = store.noted(path.name, store.stamp(path.stat()), json.dumps(content))
    shards.add(folder, store.NOTES, {"no entry": '"a lie"', "unheard of": '{"a": ["lie"]}'}.get(lie, entry))
    assert states(folder) == ["done"] * 5


def test_a_file_that_is_no_notes_is_left_alone(folder: Path) -> None:
    (path,) = notes(folder)
    path.write_bytes(b"%08x no JSON\n" % zlib.crc32(b"no JSON"))
    assert states(folder) == ["done"] * 5
    assert path in notes(folder)
    assert len(notes(folder)) == 2


def test_a_record_under_the_name_of_another_is_none(folder: Path) -> None:
    shutil.copyfile(store.record_path(folder, TASKS[0].id, TASKS[0].key), store.record_path(folder, TASKS[1].id, TASKS[1].key))
    assert states(folder) == ["done", None, "done", "done", "done"]


def test_a_folder_that_takes_no_notes_still_tells_its_results(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    shutil.rmtree(shards.place(folder))
    monkeypatch.setattr(Path, "mkdir", refuse)
    assert states(folder) == ["done"] * 5
    assert not shards.place(folder).exists()


def test_many_at_once_who_write_read_and_throw_away(folder: Path) -> None:
    """Notes come and go under everybody's hands; what is read is right all the same."""

    def work(number: int) -> list[list[str | None]]:
        seen = []
        for turn in range(20):
            store.save(folder, record(TASKS[number % 5]))
            if turn % 4 == number:
                shutil.rmtree(shards.place(folder), ignore_errors=True)
            seen.append(states(folder))
        return seen

    with ThreadPoolExecutor(4) as threads:
        assert all(seen == ["done"] * 5 for found in threads.map(work, range(4)) for seen in found)
