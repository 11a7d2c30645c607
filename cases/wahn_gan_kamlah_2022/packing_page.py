"""The packings: runs, statements, figures, tables, page."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from cases.edmans_sinka_2020.wording import Block, prose, subscripts, table, text
from cases.report import parts, plots
from cases.tradeoff.page import write_csv, write_page
from cases.wahn_gan_kamlah_2022.figures import Picture
from cases.wahn_gan_kamlah_2022.jamming import Exponents, exponents
from cases.wahn_gan_kamlah_2022.packing_facts import (
    PAPER_CONTACTS,
    PAPER_ONSET,
    PAPER_STRESS,
    Judged,
    from_loose,
    inline,
    long_term,
    onsets,
    power,
)
from cases.wahn_gan_kamlah_2022.packing_figures import all_figures
from cases.wahn_gan_kamlah_2022.packing_runs import FRICTIONS, FULL, QUICK, SLOW, SWEEP, Effort, Say, everything, threshold, unjam
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
    jammed = [own for seed in effort.seeds if (own := unjam(contracted(seed, effort.spheres), seed))]
    found = [exponents(own, effort.spheres) for own in jammed]
    say("jamming")
    judged, pictures = judge(runs, found), all_figures(runs, jammed, found)
    for picture in pictures:
        write_text(out / f"{picture.name}.svg", plots.svg(picture.figure))
    write_csv(list(summaries(runs)), out / "packing_runs.csv")
    write_csv(list(rows(runs)), out / "packing_curves.csv")
    write_csv([own._asdict() | {"ours": inline(own.ours)} for own in judged], out / "packing_statements.csv")
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
        {"title": "What holds", "blocks": [words_used(), *statements(judged)]},
        {"title": "A loose bed, and friction", "blocks": [shown["figure_13"], *coefficients(runs)]},
        {"title": "Routines and ways of loading", "blocks": [shown["figure_14"]]},
        {"title": "Rates and densities", "blocks": [shown["figure_15"], shown["shares"], *densities(runs, effort), shown["density"]]},
        {"title": "Relaxation", "blocks": [shown["figure_16"]]},
        {"title": "Jamming", "blocks": [*jamming(found), shown["jamming"]]},
        {"title": "How it was done", "blocks": [*routines(runs), parts.text(f"{code_version()}. {cost}")]},
    ]
    lead = (
        f"{effort.spheres} and {effort.bed} spheres, {len(effort.seeds)} packings of each kind, with friction ({max(FRICTIONS):g}) and "
        "without: every statement of section 5, judged. The paper gives no friction coefficient and shows one packing."
    )
    return write_page(path, TITLE, lead, sections)


def statements(judged: Sequence[Judged]) -> list[Block]:
    """The table of statements."""
    counted = Counter(own.verdict for own in judged)
    words = ", ".join(f"{MARKS[verdict]} {verdict}: {counted[verdict]}" for verdict in MARKS if counted[verdict])
    header = ("", "where", "statement", "paper", "ours: mean (least to most; packings)", "why")
    cells = [(MARKS[j.verdict], j.place, j.claim, j.paper, Markup("<br>").join(j.ours.split("\n")), j.reason) for j in judged]
    return [
        text(f"{words}. Statements in our words; brackets hold the range over packings, and their number."),
        prose(header, cells),
    ]


def words_used() -> Block:
    """What the page's short words mean."""
    return text(
        "HSD: elastic Hertz contacts; MZ: viscoelastic Maxwell-Zener contacts, equations and units corrected. PVDF: long-term modulus "
        "E_soft 1366 MPa, instantaneous E_stiff 1770 MPa; NMC: 142 and 184 GPa. BCT: spheres are carried along with the box; BC: only "
        "the box moves. μ: friction coefficient; φ: packing fraction; z: contacts per sphere. At rest: the quasi-static routine, one "
        "state of rest after the other; in motion: the dynamic routine, masses scaled to an inertial number (strain rate times diameter "
        f"times the root of density over pressure, this of an effective medium) of {SLOW:g} where nothing else is said. First stress: a "
        f"pressure of {threshold('PVDF'):.0f} Pa, a millionth of the modulus E/(1 − ν²). Differences in per cent are between runs of the "
        "same packing.",
        note=True,
    )


def coefficients(runs: Runs) -> list[Block]:
    """What the paper's numbers say of the coefficient that it does not give."""
    rows = []
    for friction in SWEEP:
        strain, fraction, contacts = onsets(from_loose(runs, friction))
        stress = long_term(runs, friction).text(".4f", "", 1e-6)
        rows.append((f"{friction:g}", strain.text(".1f", "", 100.0), fraction.text(".3f"), contacts.text(".2f"), stress))
    paper = ("paper", f"{100.0 * PAPER_ONSET:g}", ".62", f"{PAPER_CONTACTS:g}", f"{1e-6 * PAPER_STRESS:.4f}")
    header = ("μ", "first stress from .58 at (%)", "φ there", "z there", "long-term stress at 0.3 % (MPa)")
    return [text("The paper has Coulomb's limit but no coefficient. Mean (least to most; packings):"), table(header, [*rows, paper])]


def densities(runs: Runs, effort: Effort) -> list[Block]:
    """What scaled masses cost and carry."""
    own = [r for r in runs.all if r.figure == "density" and r.name != "at rest"]
    cells = [
        (f"{r.friction:g}", f"{float(r.name):.0e}", power(r.density_scaling), f"{r.inertial_number:.1e}", f"{r.kinetic:.1e}", f"{r.steps}",
         f"{1e-6 * r.at(0.005):.4f}")
        for r in own
    ]  # fmt: skip
    scaling = itasca_scaling(1800.0, contact("PVDF", "E_soft", 0.0, RADIUS), contracted(effort.seeds[0], effort.spheres), 0.003, 1e-5)
    words = (
        f"Table 1's densities are kg/m³, though printed as g/mm³. The paper's time step of 1e-5 s needs masses {power(scaling)} times the "
        "true ones by its own rule (Eq. 2.8). Below, one packing by 0.5 % in 1 s, MZ, with ever less mass; the inertial number at the "
        "end is that of the true pressure there, kinetic energy is over the stored one at its peak."
    )
    header = ("μ", "inertial number asked for", "masses times", "at the end", "kinetic over stored", "steps", "MPa at 0.5 %")
    return [text(words), table(header, cells)]


def jamming(found: Sequence[Exponents]) -> list[Block]:
    """Each packing."""
    header = (
        "seed",
        "φ_J",
        "z_J (by a line)",
        "z of the last state with pressure",
        "6 − 4/N",
        "power of z",
        "power of p",
        "p over effective medium",
    )
    cells = [
        (f"{e.seed}", f"{e.fraction:.4f}", f"{e.coordination:.3f}", f"{e.last:.3f}", f"{e.isostatic:.3f}", f"{e.contacts_exponent:.2f}",
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
        f"{len(runs.all)} runs; {len(lost)} found no rest and are left out. At rest laws are followed through the physical time of a stage "
        "in implicit steps. In motion a drag acts on velocities relative to the box, except where said. Kinetic over stored energy at the "
        f"peak: with friction up to {rubbing.most:.1g}, without up to {smooth.most:.1g}; energy balance to {balance:.1g}. Tangential "
        "springs are elastic, those of Maxwell-Zener contacts with the long-term modulus."
    )
    return [text(words)]
