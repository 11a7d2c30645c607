"""Every statement of the paper that can be judged, in its order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from cases.edmans_sinka_2020 import statements_cylinder, statements_exponent, statements_loading, statements_models, statements_stiffness
from cases.edmans_sinka_2020.facts import Facts, Finding, Statement

GROUPS = (
    ("Loading, first yield, energy", statements_loading.STATEMENTS),
    ("Unloading stiffness", statements_stiffness.STATEMENTS),
    ("Unloading exponent", statements_exponent.STATEMENTS),
    ("Models of others", statements_models.STATEMENTS),
    ("The model of concentric cylinders", statements_cylinder.STATEMENTS),
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
