"""Every statement of the paper that can be judged, in its order."""

from __future__ import annotations

from collections.abc import Sequence

from cases.becker_kamlah_2021 import statements_elastic, statements_loading, statements_unloading
from cases.becker_kamlah_2021.facts import Facts
from cases.report import judgement
from cases.report.judgement import Judgement

GROUPS = (
    ("Elastic contact and first yield", statements_elastic.STATEMENTS),
    ("Loading beyond yield", statements_loading.STATEMENTS),
    ("Unloading and validation", statements_unloading.STATEMENTS),
)


def judge(facts: Facts) -> list[Judgement]:
    """All of them."""
    return judgement.judge(GROUPS, facts, "Not among the curves: {}.")


def in_words(judgements: Sequence[Judgement]) -> str:
    """The same as a phrase."""
    plural = {"holds": "hold", "holds partly": "hold in part", "does not hold": "do not"}
    counts = judgement.tally(judgements)
    return ", ".join(f"{counts[verdict]} {words}" for verdict, words in plural.items() if verdict in counts)
