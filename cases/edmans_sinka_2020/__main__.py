"""`python -m cases.edmans_sinka_2020 FOLDER [--unseen FOLDER] [--out DIR]`: tables, figures and the page from a folder of curves."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from calibration.unloadings import table_rows
from cases.batch.store import problems_with_folder
from cases.edmans_sinka_2020 import (
    figures_cylinder,
    figures_exponent,
    figures_inside,
    figures_loading,
    figures_models,
    figures_stiffness,
    inside,
    page,
    tables,
)
from cases.edmans_sinka_2020.data import Study, load
from cases.edmans_sinka_2020.drawing import Drawn, Picture
from cases.edmans_sinka_2020.facts import NU, Facts
from cases.edmans_sinka_2020.inside import Inside
from cases.edmans_sinka_2020.refit import Refit, refits
from cases.edmans_sinka_2020.statements import judge
from cases.report import judgement, plots
from cases.tradeoff.page import write_csv
from contactlaws.errors import InputError, require
from contactlaws.files import write_text
from contactlaws.unloading_table import write_table


def make(
    study: Study, unseen: Study | None, out: Path, within: dict[float, Inside], found: Sequence[Refit], shown: Sequence[Picture]
) -> Path:
    """Everything, into `out`; the page is written last."""
    out.mkdir(parents=True, exist_ok=True)
    points = study.points
    sets = {"all": points, "plastic": points.where(points.plastic)}
    if unseen is not None:
        sets |= {"not in the fit": unseen.points, "not in the fit, plastic": unseen.points.where(unseen.points.plastic)}
    errors = tables.errors_of_equation_3(sets, found)
    judgements = judge(Facts(study, within, list(found)))
    rows = list(table_rows(study.curves[key] for key in study.keys))
    for suffix in ("csv", "parquet"):
        write_table(rows, out / f"unloadings.{suffix}")
    for name, table in {
        "materials": tables.materials(study),
        "errors_of_equation_3": errors,
        "constants_of_equation_3": tables.constants(found),
        "statements": judgement.rows(judgements),
    }.items():
        write_csv(table, out / f"{name}.csv")
    drawn = [Drawn(item, plots.svg(item.figure)) for item in shown]
    (out / "figures").mkdir(exist_ok=True)
    for item in drawn:
        write_text(out / "figures" / f"{item.picture.name}.svg", item.svg)
    print(
        f"{len(rows)} unloadings, {len(drawn)} figures; statements: {', '.join(f'{n} {v}' for v, n in judgement.tally(judgements).items())}"
    )
    return page.write(out / "edmans_sinka_2020.html", study, judgements, drawn, found, errors)


def pictures(study: Study, within: dict[float, Inside]) -> list[Picture]:
    """All figures, in the paper's order, then ours."""
    drawn = [
        *figures_loading.pictures(study),
        *figures_stiffness.pictures(study),
        *figures_exponent.pictures(study),
        *figures_models.pictures(study, within),
        *figures_cylinder.pictures(study),
    ]
    return sorted(drawn, key=lambda item: int(item.number or 0)) + figures_inside.pictures(within)


def main(arguments: list[str] | None = None) -> int:
    """Exit code 0, or 2 for folders that cannot be used."""
    parser = argparse.ArgumentParser(prog="python -m cases.edmans_sinka_2020", description=__doc__)
    parser.add_argument("folder", type=Path, help="results of fe2dem run cases/edmans_sinka_2020/study.toml, or a folder of curves")
    parser.add_argument("--unseen", type=Path, help="curves of other materials, on which fitted constants are tried")
    parser.add_argument("--out", type=Path, help="where to write; FOLDER/edmans_sinka_2020 unless given")
    given = parser.parse_args(arguments)
    out = given.out or given.folder / "edmans_sinka_2020"
    try:
        study = load(given.folder)
        require(problems_with_folder("--out", out))
        unseen = load(given.unseen) if given.unseen else None
        within = inside.compute_all(study.moduli(NU), NU, out / "inside", lambda text: print(text, flush=True))
        print(make(study, unseen, out, within, refits(study.points), pictures(study, within)))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
