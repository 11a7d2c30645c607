"""Texts for the page: subscripts, and tables of texts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

from markupsafe import Markup, escape

from cases.report import parts
from cases.report.judgement import FAILS, HOLDS, PARTLY, UNTESTED, Judgement

Block = dict[str, Any]

SIGNS = {HOLDS: "✓", PARTLY: "◐", FAILS: "✗", UNTESTED: "–"}


def subscripts(words: str) -> Markup:
    """Plain text as HTML, with what follows an underscore as a subscript, and fractions kept on one line.

    >>> str(subscripts("δ_c/R < 5"))
    'δ<sub>c</sub>/\\u2060R &lt; 5'
    """
    return Markup(re.sub(r"_([A-Za-z0-9]+)", r"<sub>\1</sub>", str(escape(words))).replace("/", "/\u2060").replace("</\u2060", "</"))


def text(words: str, note: bool = False) -> Block:
    """A paragraph."""
    return parts.text(subscripts(words), note)


def prose(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Block:
    """A table of texts."""
    return {"kind": "prose", "columns": columns, "rows": [[subscripts(cell) for cell in row] for row in rows]}


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Block:
    """A table of numbers whose first column is text."""
    return parts.table([subscripts(name) for name in columns], [[subscripts(cell) for cell in row] for row in rows])


def statements(judgements: Sequence[Judgement]) -> Iterator[Block]:
    """A table of every statement and what was found, for each group of them."""
    for group in dict.fromkeys(item.group for item in judgements):
        yield text(group + ":")
        rows = [
            (
                item.statement.place,
                item.statement.claim,
                item.statement.paper,
                item.finding.ours,
                f"{SIGNS[item.finding.verdict]} {item.finding.verdict}",
                item.finding.reason,
            )
            for item in judgements
            if item.group == group
        ]
        yield prose(("place", "statement", "paper", "ours", "verdict", "remark"), rows)


def figure(number: str | None, svg: Any, caption: str) -> Block:
    """A figure with its number in the paper; None: ours."""
    head = f"Fig. {number}. " if number else "Beyond the paper. "
    return {"kind": "figures", "figures": [{"svg": svg, "caption": subscripts(head + caption)}]}


def percents(values: Sequence[float]) -> str:
    """Percentiles in per cent.

    >>> percents((0.0184, 0.3633))
    '1.84 / 36.33'
    """
    return " / ".join(f"{100 * value:.2f}" for value in values)
