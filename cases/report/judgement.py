"""Statements of a paper, judged by what was computed: what a statement is, how many hold, and their rows in a table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

HOLDS, PARTLY, FAILS, UNTESTED = "holds", "holds partly", "does not hold", "not tested"

Facts = TypeVar("Facts")


class Lacking(LookupError):
    """What is asked for has not been computed: a material, a body, an overlap or a field."""


class Finding(NamedTuple):
    """What was found about a statement."""

    ours: str
    verdict: str
    reason: str


class Statement(NamedTuple, Generic[Facts]):
    """A statement of the paper in our words, the number that it gives, and how it is judged."""

    place: str  # section, equation or figure
    claim: str
    paper: str
    check: Callable[[Facts], Finding]  # may raise `Lacking`


class Judgement(NamedTuple):
    """A statement and what was found."""

    group: str
    statement: Statement[Any]
    finding: Finding


def verdict(whole: bool, part: bool = True) -> str:
    """The verdict where a statement holds as a whole, in part, or not."""
    return HOLDS if whole else PARTLY if part else FAILS


def judge(groups: Iterable[tuple[str, Sequence[Statement[Facts]]]], facts: Facts, untested: str) -> list[Judgement]:
    """All statements of all groups; `untested` says, with {} for what is lacking, why one could not be tested."""
    return [Judgement(group, statement, _finding(statement, facts, untested)) for group, statements in groups for statement in statements]


def _finding(statement: Statement[Facts], facts: Facts, untested: str) -> Finding:
    try:
        return statement.check(facts)
    except Lacking as lacking:
        return Finding("—", UNTESTED, untested.format(lacking))


def tally(judgements: Sequence[Judgement]) -> dict[str, int]:
    """How many have which verdict."""
    return dict(Counter(judgement.finding.verdict for judgement in judgements))


def rows(judgements: Sequence[Judgement]) -> list[dict[str, Any]]:
    """One row of a table for each statement."""
    return [
        {
            "group": item.group,
            "place": item.statement.place,
            "statement": item.statement.claim,
            "paper": item.statement.paper,
            "ours": item.finding.ours,
            "verdict": item.finding.verdict,
            "reason": item.finding.reason,
        }
        for item in judgements
    ]
