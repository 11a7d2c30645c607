"""Options as all commands declare them, and several values after one: `--speed 1 2 5`, where the parser knows only one value each time."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

import typer


def spread(arguments: Sequence[str], options: Collection[str]) -> list[str]:
    """Repeat each of `options` before each of its values; a value is what doesn't begin with a dash, or is a number.

    >>> spread(["law.json", "--speed", "1", "2 m/s", "-3", "--radius", "1"], {"--speed"})
    ['law.json', '--speed', '1', '--speed', '2 m/s', '--speed', '-3', '--radius', '1']
    """
    return list(_spread(arguments, options))


def _spread(arguments: Sequence[str], options: Collection[str]) -> Iterator[str]:
    current, count = None, 0
    for index, argument in enumerate(arguments):
        if argument == "--":
            yield from arguments[index:]
            return
        if _is_option(argument):
            current, count = (argument if argument in options else None), 0
        elif current is not None:
            count += 1
            if count > 1:
                yield current
        yield argument


def _is_option(argument: str) -> bool:
    return argument.startswith("-") and argument != "-" and not argument[1:2].isdigit() and argument[1:2] != "."


def option(help_text: str) -> Any:
    """An option whose help says itself what holds without it."""
    return typer.Option(help=help_text, show_default=False)
