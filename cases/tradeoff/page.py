"""What the measurements of a trade have in common: a table as CSV and Parquet, and a page without any link."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2

from cases.report.page import TEMPLATE
from contactlaws.files import write_atomically, write_text
from contactlaws.version import code_version


def write_page(
    path: Path, title: str, lead: str, sections: Iterable[Mapping[str, Any]], failures: Sequence[Mapping[str, str]] = ()
) -> Path:
    """Write a page in the report's style; sections are {"title", "blocks"} with the blocks of `cases.report.parts`.

    failures: {"task", "reason"} of what could not be measured; they stand on top.
    """
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    shown = [section for section in sections if section["blocks"]]
    return write_text(path, template.render(title=title, lead=lead, failures=list(failures), sections=shown))


def write_table(rows: Sequence[Mapping[str, Any]], stem: Path) -> tuple[Path, Path]:
    """Write rows with the same keys to `stem`.csv and `stem`.parquet; None is an empty cell."""
    return write_csv(rows, stem.with_suffix(".csv")), write_atomically(stem.with_suffix(".parquet"), lambda file: _parquet(rows, file))


def write_csv(rows: Sequence[Mapping[str, Any]], path: Path) -> Path:
    """Write rows with the same keys as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows(["" if value is None else value for value in row.values()] for row in rows)
    return write_text(path, text.getvalue())


def _parquet(rows: Sequence[Mapping[str, Any]], file: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({name: [row[name] for row in rows] for name in rows[0]})
    pq.write_table(table.replace_schema_metadata({"code": code_version()}), file)
