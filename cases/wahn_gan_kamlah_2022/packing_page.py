"""The packings: runs, statements, figures, tables, page."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from cases.edmans_sinka_2020.wording import Block, prose, subscripts, table, text
from cases.report import plots
from cases.tradeoff.page import write_csv, write_page
from cases.wahn_gan_kamlah_2022.figures import Picture
from cases.wahn_gan_kamlah_2022.jamming import Exponents, exponents
from cases.wahn_gan_kamlah_2022.packing_facts import Judged
from cases.wahn_gan_kamlah_2022.packing_figures import all_figures
from cases.wahn_gan_kamlah_2022.packing_runs import FRICTIONS, FULL, QUICK, Effort, Say, everything, unjam
from cases.wahn_gan_kamlah_2022.packing_statements import judge
from cases.wahn_gan_kamlah_2022.packings import RADIUS, Runs, band, contact, contracted, itasca_scaling
from contactlaws.files import write_text
from contactlaws.version import code_version

TITLE = "Packings of Wahn, Gan & Kamlah (2022), done again"
MARKS = {"holds": "✓", "holds partly": "~", "does not hold": "✗", "not tested": "–"}


def make(out: Path, quick: bool, say: Say) -> Path:
    """Run everything and write tables, figures and the page into `out`."""
    began, effort = time.process_time(), QUICK if quick else FULL
    out.mkdir(parents=True, exist_ok=True)
    runs = everything(effort, say)
    jammed = [unjam(contracted(seed, effort.spheres), seed) for seed in effort.seeds]
    found = [exponents(own, effort.spheres) for own in jammed]
    say("jamming")
    judged, pictures = judge(runs, found), all_figures(runs, jammed, found)
    for picture in pictures:
        write_text(out / f"{picture.name}.svg", plots.svg(picture.figure))
    write_csv(list(summaries(runs)), out / "packing_runs.csv")
    write_csv(list(rows(runs)), out / "packing_curves.csv")
    write_csv([own._asdict() for own in judged], out / "packing_statements.csv")
    write_csv([own._asdict() for own in found], out / "jamming.csv")
    cost = f"{time.process_time() - began:.0f} CPU seconds, packings of seeds {effort.seeds[0]} to {effort.seeds[-1]}."
    return write(out / "packings.html", runs, judged, found, pictures, effort, cost)


def summaries(runs: Runs) -> Iterator[dict[str, Any]]:
    """One row for each run."""
    for run in runs.all:
        single = {name: value for name, value in run._asdict().items() if not hasattr(value, "shape")}
        yield single | {"stress at the end": float(run.stress[-1]), "strain at the end": float(run.strain[-1])}


def rows(runs: Runs) -> Iterator[dict[str, Any]]:
    """One row for each output of each run."""
    for run in runs.all:
        for k in range(len(run.strain)):
            values = (run.time[k], run.strain[k], run.stress[k], run.pressure[k], run.fraction[k], run.coordination[k])
            names = ("time", "strain", "stress", "pressure", "fraction", "coordination")
            head = {"figure": run.figure, "name": run.name, "seed": run.seed, "friction": run.friction}
            yield head | {name: float(value) for name, value in zip(names, values, strict=True)}


def write(
    path: Path, runs: Runs, judged: Sequence[Judged], found: Sequence[Exponents], pictures: Sequence[Picture], effort: Effort, cost: str
) -> Path:
    """Write the page; one file without any link."""
    shown: dict[str, Block] = {
        p.name: {"kind": "figures", "figures": [{"svg": plots.svg(p.figure), "caption": subscripts(p.caption)}]} for p in pictures
    }
    sections = [
        {"title": "What holds", "blocks": statements(judged)},
        {"title": "A loose bed", "blocks": [shown["figure_13"]]},
        {"title": "Routines and ways of loading", "blocks": [shown["figure_14"]]},
        {"title": "Rates and densities", "blocks": [*densities(runs, effort), shown["figure_15"], shown["density"]]},
        {"title": "Relaxation", "blocks": [shown["figure_16"]]},
        {"title": "Jamming", "blocks": [*jamming(found), shown["jamming"]]},
        {"title": "How it was done", "blocks": [*routines(runs), text(f"{code_version()}. {cost}")]},
    ]
    lead = (
        f"{effort.spheres} and {effort.bed} spheres, {len(effort.seeds)} packings of each kind, with friction ({max(FRICTIONS):g}) and "
        "without: every statement of section 5, judged. The paper gives no friction coefficient and shows one packing."
    )
    return write_page(path, TITLE, lead, sections)


def statements(judged: Sequence[Judged]) -> list[Block]:
    """The table of statements."""
    counted = Counter(own.verdict for own in judged)
    words = ", ".join(f"{number} {name}" for name, number in counted.items())
    header = ("", "where", "statement", "paper", "ours: mean (least to most; packings)", "why")
    cells = [(MARKS[j.verdict], j.place, j.claim, j.paper, j.ours, j.reason) for j in judged]
    return [text(f"{words}. In brackets: range over packings, and their number."), prose(header, cells)]


def densities(runs: Runs, effort: Effort) -> list[Block]:
    """What scaled masses cost and carry."""
    own = [r for r in runs.all if r.figure == "density" and r.name != "at rest"]
    cells = [
        (f"{r.friction:g}", f"{r.density_scaling:.1e}", f"{r.inertial_number:.1e}", f"{r.kinetic:.1e}", f"{r.steps}",
         f"{1e-6 * r.at(0.005):.4f}")
        for r in own
    ]  # fmt: skip
    scaling = itasca_scaling(1800.0, contact("PVDF", "E_soft", 0.0, RADIUS), contracted(effort.seeds[0], effort.spheres), 0.003, 1e-5)
    words = (
        f"Table 1's densities are kg/m³. For the step of 1e-5 s that the paper names Itasca's factor asks for masses {scaling:.1e} times "
        "the true ones. Inertial numbers are those at the top, with the pressure there; kinetic energy is over the stored one."
    )
    return [text(words), table(("friction", "masses times", "inertial number", "kinetic", "steps", "MPa at 0.5 %"), cells)]


def jamming(found: Sequence[Exponents]) -> list[Block]:
    """Each packing."""
    header = ("seed", "φ_J", "z_J", "6 − 4/N", "power of z − z_J", "power of p", "p over effective medium")
    cells = [
        (f"{e.seed}", f"{e.fraction:.4f}", f"{e.coordination:.3f}", f"{e.isostatic:.3f}", f"{e.contacts_exponent:.2f}",
         f"{e.pressure_exponent:.2f}", f"{e.over_medium:.2f}")
        for e in found
    ]  # fmt: skip
    return [table(header, cells)]


def routines(runs: Runs) -> list[Block]:
    """Guards of the runs."""
    lost = [r for r in runs.all if r.stopped]
    moving = [r for r in runs.all if r.inertial_number > 0.0 and r.figure != "density"]
    balance = max((r.balance for r in moving), default=0.0)
    rubbing, smooth = (band(r.kinetic for r in moving if (r.friction > 0.0) == some) for some in (True, False))
    words = (
        f"{len(runs.all)} runs, {len(lost)} without rest, which are left out. At rest: the quasi-static routine, which integrates laws "
        "in time implicitly, stage durations being physical. In motion: masses scaled to the inertial number wanted, a drag on "
        "velocities relative "
        f"to the box. Kinetic over stored energy at the peak: with friction up to {rubbing.most:.1g}, without up to {smooth.most:.1g}; "
        f"energy balance to {balance:.1g}. Tangential springs are elastic, those of Maxwell-Zener contacts with the long-term modulus."
    )
    return [text(words)]
