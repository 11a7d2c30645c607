"""The page: numbers, where the 5.4 % come from, accuracy, trade, extremes, figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from cases.edmans_sinka_2020.wording import Block, prose, subscripts, table, text
from cases.report import parts, plots
from cases.tradeoff.page import write_page
from cases.verification import viscoelastic_extremes
from cases.wahn_gan_kamlah_2022 import accuracy, gap
from cases.wahn_gan_kamlah_2022.accuracy import Compared
from cases.wahn_gan_kamlah_2022.figures import Picture
from cases.wahn_gan_kamlah_2022.gap import Gap
from cases.wahn_gan_kamlah_2022.numbers import Number
from cases.wahn_gan_kamlah_2022.trade import Choice
from contactlaws.version import code_version

TITLE = "Two viscoelastic spheres of Wahn, Gan & Kamlah (2022), done again"


#: laws as the page calls them
NAMES = {
    accuracy.OURS: "Maxwell-Zener with Ting's retreat and finite size (ours)",
    "maxwell_zener": "the same without Ting's retreat",
    accuracy.TING: "the same, of a half-space",
    accuracy.PLAIN: "Maxwell-Zener of a half-space",
    accuracy.RIVAL: "the paper's increments",
    "kuwabara_kono": "Kuwabara & Kono",
}


def write(
    path: Path,
    found: Sequence[Number],
    gaps: Sequence[Gap],
    compared: Sequence[Compared],
    choices: Sequence[Choice],
    tried: Sequence[viscoelastic_extremes.Row],
    pictures: Sequence[Picture],
    cost: str,
) -> Path:
    """Write the page; one file without any link."""
    shown = {picture.name: _figure(picture) for picture in pictures}
    sections = [
        {"title": "Numbers", "blocks": [*_numbers(found), shown["figure_09"], shown["figure_10"]]},
        {"title": "Where the 5.4 % come from", "blocks": [*_gap(gaps), shown["gap"], shown["figure_12"]]},
        {"title": "Laws against finite elements", "blocks": [*_accuracy(compared), shown["retreat"]]},
        {"title": "What terms and memory cost", "blocks": [*_trade(choices), shown["trade"]]},
        {"title": "At the extremes", "blocks": extremes(tried)},
        {"title": "Where this is from", "blocks": [parts.text(f"{code_version()}. {cost}")]},
    ]
    lead = "PVDF spheres of 5 µm radius, 2 % strain: every number of the two-sphere sections, old and new laws against finite elements."
    return write_page(path, TITLE, lead, sections)


def _figure(picture: Picture) -> Block:
    return {"kind": "figures", "figures": [{"svg": plots.svg(picture.figure), "caption": subscripts(picture.caption)}]}


def _numbers(found: Sequence[Number]) -> Iterator[Block]:
    held = sum(number.ok for number in found)
    yield text(f"{held} of {len(found)} numbers are met within their tolerance. Forces are those of the pair kernel, step after step.")
    rows = [
        (n.name, f"{n.value:.5g} {n.unit}", f"{n.expected:.5g} {n.unit}", f"{n.tolerance:.1g}", "✓" if n.ok else "✗", n.source)
        for n in found
    ]
    yield prose(("quantity", "found", "expected", "tolerance", "", "where the expected value is from"), rows)


def _gap(gaps: Sequence[Gap]) -> Iterator[Block]:
    yield text(
        "The paper finds its finite elements 5.4 % stiffer than its law and blames incompressibility. The law, a half-space contact, knows "
        "Poisson's ratio; what it does not know is that the sphere ends. Causes at the slowest ramp, one after the other:"
    )
    yield table(("cause", "share"), [(name, f"{100.0 * value:+.2f} %") for name, value in gap.parts(list(gaps))])
    yield text("Force of finite elements above the half-space law at 2 % strain:")
    yield table(
        ("ramp (s)", "nu constant", "K constant", "as published", "as published, over the elements' force"),
        [(f"{g.ramp:g}", *(f"{100.0 * v:.2f} %" for v in g[1:])) for g in gaps],
    )


def _accuracy(compared: Sequence[Compared]) -> Iterator[Block]:
    yield text(
        "Largest difference of the force over the largest force, over five histories: ramp and release, with a hold, slowly up and fast "
        "back, released and met again before recovery, and three cycles. A smallest force below zero pulls."
    )
    names = list(dict.fromkeys(row.law for row in compared))
    rows = []
    for material in accuracy.MATERIALS:
        for depth in accuracy.DEPTHS:
            for name in names:
                own = [row for row in compared if (row.law, row.material, row.depth) == (name, material, depth)]
                if not own:
                    continue
                parts = [[v for row in own if (v := getattr(row, kind)) is not None] for kind in accuracy.KINDS]
                cells = [f"{100.0 * max(values):.2f} %" if values else "–" for values in parts]
                rows.append((f"{material}, {depth:g} R: {NAMES[name]}", *cells, f"{min(row.lowest for row in own):+.3f}"))
    yield table(("", "growing", "resting", "shrinking", "met again", "smallest force"), rows)


def extremes(rows: Sequence[viscoelastic_extremes.Row]) -> list[Block]:
    """What laws were asked for that no simulation should ask, and what came of it."""
    header = viscoelastic_extremes.HEADER
    shown = [[cell.replace("_", "-") for cell in viscoelastic_extremes.cells(row)] for row in rows]
    return [text(viscoelastic_extremes.summary(list(rows)).replace("_", " ")), table(header, shown)]


def _trade(choices: Sequence[Choice]) -> Iterator[Block]:
    yield text(
        "A material that relaxes evenly over six decades in twelve terms, its law with fewer. Errors over the largest force against the "
        "continuum; ns per contact in the simulation's pair kernel, and how many times Hertz's, taken in turns."
    )
    rows = [
        (
            f"{c.terms} term{'s' * (c.terms > 1)}" + (f", Ting with {c.springs} springs" if c.springs else ", without Ting"),
            f"{100.0 * c.growing:.2f} %",
            f"{100.0 * c.retreating:.2f} %",
            f"{c.nanoseconds:.1f}",
            f"{c.loading:.2f}",
            f"{c.unloading:.2f}",
            f"{c.bytes}",
        )
        for c in choices
    ]
    yield table(("law", "growing", "after turning", "ns", "times Hertz, growing", "shrinking", "bytes"), rows)
