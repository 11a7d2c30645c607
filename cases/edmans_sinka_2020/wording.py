"""Texts for the page: subscripts, and tables of texts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from markupsafe import Markup, escape

from cases.report import parts

Block = dict[str, Any]


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


def percents(values: Sequence[float]) -> str:
    """Percentiles in per cent.

    >>> percents((0.0184, 0.3633))
    '1.84 / 36.33'
    """
    return " / ".join(f"{100 * value:.2f}" for value in values)
