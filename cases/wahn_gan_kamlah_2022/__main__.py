"""`python -m cases.wahn_gan_kamlah_2022 [--out DIR] [--packings [--quick]]`: numbers, tables, figures and the page.

Two spheres, about four CPU minutes; with --packings section 5 instead, about twelve, or two with --quick.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from cases.batch.store import problems_with_folder
from cases.report import plots
from cases.tradeoff.page import write_csv
from cases.verification import viscoelastic_extremes
from cases.wahn_gan_kamlah_2022 import accuracy, figures, gap, numbers, packing_page, page, trade
from cases.wahn_gan_kamlah_2022.material import HISTORIES, OVERLAP, PUBLISHED, RADIUS, TOGETHER
from contactlaws.curve_files import write_curve
from contactlaws.errors import InputError, require
from contactlaws.files import write_text
from fem.press_in_time import press_in_time
from fem.programme import ramp_hold_release

RATES = (0.01, 0.1, 1.0, 10.0, 100.0)  # loading times of Fig. 9, s
SHOWN = ("ramp, hold, release", "release and meet again")


def make(out: Path, tolerance: float) -> Path:
    """Everything, into `out`; the page is written last."""
    began = time.process_time()
    (out / "curves").mkdir(parents=True, exist_ok=True)
    found = list(numbers.numbers())
    _say(f"{sum(n.ok for n in found)} of {len(found)} numbers met")
    curves = {}
    for material in accuracy.MATERIALS:
        for depth in accuracy.DEPTHS:
            for history in HISTORIES:
                curve = accuracy.reference(accuracy.MATERIALS[material], depth, history, tolerance)
                curves[material, depth, history] = curve
                write_curve(curve, out / "curves" / f"{material} {depth:g} {history}.parquet".replace(" ", "_").replace(",", ""))
            _say(f"finite elements: {material}, {depth:g} R")
    compared = accuracy.table(curves)
    fast = {t: press_in_time(TOGETHER, ramp_hold_release(OVERLAP, t), radius=RADIUS, tolerance=tolerance) for t in RATES}
    published = {t: press_in_time(PUBLISHED, ramp_hold_release(OVERLAP, t), radius=RADIUS, tolerance=tolerance) for t in gap.RAMPS}
    relaxed = press_in_time(TOGETHER, ramp_hold_release(OVERLAP, 1.0, 19.0), radius=RADIUS, tolerance=tolerance)
    gaps = gap.gaps()
    _say("the gap's parts")
    choices = trade.choices(trade.references(tolerance))
    _say("terms against cost")
    pictures = [
        figures.figure_9(fast),
        figures.figure_10(relaxed),
        figures.figure_12(published),
        figures.figure_gap(gap.elastic(), gaps),
        figures.figure_retreat({history: curves["nu constant", accuracy.DEPTHS[0], history] for history in SHOWN}),
        figures.figure_trade(choices),
    ]
    for picture in pictures:
        write_text(out / f"{picture.name}.svg", plots.svg(picture.figure))
    for name, rows in (("numbers", found), ("accuracy", compared), ("trade", choices), ("gap", gaps)):
        write_csv([row._asdict() for row in rows], out / f"{name}.csv")
    cost = f"{time.process_time() - began:.0f} CPU seconds."
    return page.write(out / "wahn_gan_kamlah_2022.html", found, gaps, compared, choices, viscoelastic_extremes.rows(), pictures, cost)


def _say(words: str) -> None:
    print(words, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code 0; 1 if a number is missed; 2 for a folder that cannot be used."""
    parser = argparse.ArgumentParser(prog="python -m cases.wahn_gan_kamlah_2022", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("results/wahn_gan_kamlah_2022"), help="where to write")
    parser.add_argument("--tolerance", type=float, default=0.005, help="of the finite elements")
    parser.add_argument("--packings", action="store_true", help="the packings of section 5, not the two spheres")
    parser.add_argument("--quick", action="store_true", help="few and small packings")
    given = parser.parse_args(arguments)
    try:
        require(problems_with_folder("--out", given.out))
        if given.packings:
            print(packing_page.make(given.out, given.quick, _say))
            return 0
        print(make(given.out, given.tolerance))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0 if all(number.ok for number in numbers.numbers()) else 1


if __name__ == "__main__":
    sys.exit(main())
