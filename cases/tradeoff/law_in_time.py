"""`fe2dem tradeoff law --in-time`: what terms and Ting's retreat are worth, measured now."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cases import console
from cases.report import plots
from cases.wahn_gan_kamlah_2022 import figures, trade
from cases.wahn_gan_kamlah_2022.trade import Choice


def tradeoff_in_time(out: Path | None) -> None:
    """Measure, print, and draw into `out` (.png) if given; see `cases.wahn_gan_kamlah_2022.trade`."""
    console.out.print("continuum with twelve terms over six decades, three histories; then each law beside it, and its cost beside Hertz's")
    choices = trade.choices(trade.references())
    show(choices)
    if out is not None:
        plots.png(figures.figure_trade(choices).figure, out)
        console.out.print(f"picture: {out}")


def show(choices: Sequence[Choice]) -> None:
    """The table, errors in per cent of the largest force."""
    names = ("law", "terms", "springs", "growing (%)", "after turning (%)", "ns", "times Hertz", "shrinking, times Hertz", "bytes")
    sheet = console.sheet(*names)
    for one in choices:
        numbers = (100.0 * one.growing, 100.0 * one.retreating, one.nanoseconds, one.loading, one.unloading)
        springs = str(one.springs) if one.springs else "without"
        sheet.add_row(one.law, str(one.terms), springs, *(f"{value:.3g}" for value in numbers), str(one.bytes))
    console.out.print(sheet)
