"""`python -m cases.becker_kamlah_2021 [--curves FOLDER] [--out DIR] [--nmc] [--jobs N]`: tables, figures and the page.

Computes what is missing among the curves: 369 in all, some 50 CPU minutes; with --nmc the 9 of the authors' material and the elastic ones
that are there.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from cases.batch.store import problems_with_folder
from cases.becker_kamlah_2021 import bodies, data, figures_apart, figures_loading, figures_paths, figures_shape, page, tables
from cases.becker_kamlah_2021.bodies import Named
from cases.becker_kamlah_2021.data import Study
from cases.becker_kamlah_2021.facts import Facts, gather
from cases.becker_kamlah_2021.statements import in_words, judge
from cases.edmans_sinka_2020.drawing import Drawn, Picture
from cases.report import judgement, plots
from cases.tradeoff.page import write_csv
from contactlaws.errors import InputError, require
from contactlaws.files import write_text

OUT = Path("results/becker_kamlah_2021")


def make(study: Study, named: Named, out: Path) -> Path:
    """Everything, into `out`; the page is written last."""
    facts = gather(study, named)
    judgements = judge(facts)
    write_tables(facts, out)
    write_csv(judgement.rows(judgements), out / "statements.csv")
    drawn = [Drawn(item, plots.svg(item.figure)) for item in pictures(facts)]
    (out / "figures").mkdir(parents=True, exist_ok=True)
    for item in drawn:
        write_text(out / "figures" / f"{item.picture.name}.svg", item.svg)
    print(f"{len(drawn)} figures; statements: {in_words(judgements)}")
    return page.write(out / "becker_kamlah_2021.html", facts, judgements, drawn)


def write_tables(facts: Facts, out: Path) -> None:
    """All numbers as CSV."""
    out.mkdir(parents=True, exist_ok=True)
    rows = {
        "bodies": tables.bodies(facts),
        "constants": tables.constants(facts),
        "joint": tables.joint(facts),
        "together": tables.together(facts),
        "loading": [row._asdict() for row in facts.loading],
        "unloading": [row._asdict() for row in facts.unloading],
    }
    for name, table in rows.items():
        if table:
            write_csv(table, out / f"{name}.csv")


def pictures(facts: Facts) -> list[Picture]:
    """All figures, the paper's first and in its order."""
    drawn = [
        *figures_loading.pictures(facts.study, facts.named),
        *figures_shape.pictures(facts.read_of),
        *figures_paths.pictures(facts.study, facts.named),
        *figures_apart.pictures(facts.study, facts.loading, facts.unloading),
    ]
    return sorted(drawn, key=lambda item: int(item.number or 99))


def _say(words: str) -> None:
    print(words, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for folders that cannot be used."""
    parser = argparse.ArgumentParser(prog="python -m cases.becker_kamlah_2021", description=__doc__)
    parser.add_argument("--curves", type=Path, help=f"folder of the curves, completed if need be; {OUT}/curves unless given")
    parser.add_argument("--out", type=Path, default=OUT, help="where to write")
    parser.add_argument("--nmc", action="store_true", help="compute curves of the authors' material alone")
    parser.add_argument("--jobs", type=int, default=1, help="processes that compute curves")
    given = parser.parse_args(arguments)
    try:
        require(problems_with_folder("--out", given.out))
        folder = given.curves or given.out / "curves"
        data.compute_missing(folder, data.wanted(given.nmc), given.jobs, _say)
        named = bodies.compute(given.out / "named", _say)
        print(make(data.load(folder), named, given.out))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
