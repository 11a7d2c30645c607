"""Every statement of the paper that can be judged, in its order."""

from __future__ import annotations

from cases.edmans_sinka_2020 import statements_cylinder, statements_exponent, statements_loading, statements_models, statements_stiffness
from cases.edmans_sinka_2020.facts import Facts
from cases.report import judgement
from cases.report.judgement import Judgement

GROUPS = (
    ("Loading, first yield, energy", statements_loading.STATEMENTS),
    ("Unloading stiffness", statements_stiffness.STATEMENTS),
    ("Unloading exponent", statements_exponent.STATEMENTS),
    ("Models of others", statements_models.STATEMENTS),
    ("The model of concentric cylinders", statements_cylinder.STATEMENTS),
)


def judge(facts: Facts) -> list[Judgement]:
    """All of them."""
    return judgement.judge(GROUPS, facts, "needs {}, which is not among the curves.")
