"""Every statement of the paper that can be judged, in its order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from cases.becker_kamlah_2021 import statements_elastic, statements_loading, statements_unloading
from cases.becker_kamlah_2021.facts import Facts, Finding, Statement

GROUPS = (
    ("Elastic contact and first yield", statements_elastic.STATEMENTS),
    ("Loading beyond yield", statements_loading.STATEMENTS),
    ("Unloading and validation", statements_unloading.STATEMENTS),
)


class Judgement(NamedTuple):
    """A statement and what was found."""

    group: str
    statement: Statement
    finding: Finding


def judge(facts: Facts) -> list[Judgement]:
    """All of them."""
    return [Judgement(group, statement, statement.judged(facts)) for group, statements in GROUPS for statement in statements]


def tally(judgements: Sequence[Judgement]) -> dict[str, int]:
    """How many have which verdict."""
    return dict(Counter(judgement.finding.verdict for judgement in judgements))


def in_words(judgements: Sequence[Judgement]) -> str:
    """The same as a phrase."""
    plural = {"holds": "hold", "holds partly": "hold in part", "does not hold": "do not"}
    counts = tally(judgements)
    return ", ".join(f"{counts[verdict]} {words}" for verdict, words in plural.items() if verdict in counts)
