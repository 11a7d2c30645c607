"""The command line of a table whose rows can be asked for by name."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence


def parser_of(module: str, doc: str | None, rows: Iterable[str]) -> argparse.ArgumentParser:
    """Of `python -m cases.verification.MODULE [ROW ...]`, described by the first line of its `doc`; it has no other options yet."""
    parser = argparse.ArgumentParser(prog=f"python -m cases.verification.{module}", description=(doc or "").splitlines()[0])
    parser.add_argument("row", nargs="*", metavar="ROW", help=f"of {', '.join(rows)}; all if none is named")
    return parser


def asked(parser: argparse.ArgumentParser, rows: Mapping[str, object], arguments: Sequence[str] | None) -> argparse.Namespace:
    """What was asked for, `row` being all rows if none is named; a name that no row has ends the program with code 2."""
    given = parser.parse_args(arguments)
    unknown = [name for name in given.row if name not in rows]
    if unknown:
        parser.error(f"no row is named {', '.join(unknown)}: choose from {', '.join(rows)}")
    given.row = given.row or list(rows)
    return given
