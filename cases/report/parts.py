"""The sections of the report: each takes the records that are there and says nothing about what isn't."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from calibration import table as fit_tables
from cases.batch.store import Record
from cases.console import number, percent
from cases.report import history, overview, plots
from contactlaws import fitted
from contactlaws.curve import Curve
from contactlaws.curve_files import read_curve
from contactlaws.dispatch import law_of
from contactlaws.elastoplastic import Thornton
from contactlaws.fitted import FittedLaw
from contactlaws.version import sources_alone

Block = dict[str, Any]
There = Mapping[str, Record]


def sections(folder: Path, case: Mapping[str, Any], there: There) -> Iterator[dict[str, Any]]:
    """Title and blocks of each section, in the order of the pipeline."""
    listed = {item["task"]: item for item in case["tasks"] if item["task"] in there}
    large = {kind for kind in overview.FEW if overview.is_large(kind, there)}
    curves: dict[str, Curve] = {}
    if "curves" not in large:
        curves = {task: read_curve(folder / record.files["curve"]) for task, record in there.items() if record.kind == "curves"}
    laws: dict[str, FittedLaw] = {}
    if "fits" not in large:
        laws = {task: fitted.load(folder / record.files["law"]) for task, record in there.items() if record.kind == "fits"}
    own = _curves(listed, there, curves, laws) if "curves" not in large else overview.curves(case, there)
    yield {"title": "Reference curves and laws", "blocks": list(own)}
    yield {"title": "Inside the body", "blocks": list(_fields(folder, there, curves))}
    own = _laws(folder, there, laws) if "fits" not in large else overview.laws(folder, there)
    yield {"title": "Fitted laws and their errors", "blocks": list(own)}
    own = _impacts(listed, there, laws) if "impacts" not in large else overview.many("impacts", there)
    yield {"title": "Impact", "blocks": list(own)}
    own = _scenes(folder, listed, there, laws) if "scenes" not in large else overview.many("scenes", there)
    yield {"title": "Packings under compression", "blocks": list(own)}
    own = _costs(case, there) if not large else overview.costs(there)
    yield {"title": "Where each number is from, and what it cost", "blocks": list(own)}


def text(words: str, note: bool = False) -> Block:
    """A paragraph."""
    return {"kind": "text", "text": words, "note": note}


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Block:
    """A table whose first column is text."""
    return {"kind": "table", "columns": columns, "rows": rows}


def figures(*pairs: tuple[Figure, str]) -> Block:
    """Figures side by side, each with its caption."""
    return {"kind": "figures", "figures": [{"svg": plots.svg(figure), "caption": caption} for figure, caption in pairs]}


def _curves(listed: Mapping[str, Any], there: There, curves: Mapping[str, Curve], laws: Mapping[str, FittedLaw]) -> Iterator[Block]:
    if not curves:
        return
    yield text(
        "One body pressed by its mid-plane against a rigid frictionless flat, by finite elements at finite strain; overlap δ is the "
        "approach of this one body. The last five columns are estimated errors of mesh and steps, by the solver's own error model."
    )
    names = ("force", "contact_radius", "unloading_stiffness", "unloading_exponent", "recovered_energy")
    header = ("curve", "material", "R (µm)", "unloadings", "first yield δ/R", *(name.replace("_", " ") for name in names))
    rows = []
    for task, curve in curves.items():
        errors = [number(curve.errors.get(name), 2) if name == "unloading_exponent" else percent(curve.errors.get(name)) for name in names]
        onset = None if curve.yield_overlap is None else curve.yield_overlap / curve.radius
        rows.append((there[task].name, _material(curve), f"{curve.radius * 1e6:g}", str(len(curve.unloadings)), number(onset, 3), *errors))
    yield table(header, rows)
    colours = _colours(there[fit].name for fit in laws)
    for task, curve in curves.items():
        users = {there[fit].name: law.law for fit, law in laws.items() if task in listed[fit]["needs"] and _meant_for(law.law, curve)}
        made_by = sources_alone(there[task].code)
        caption = (
            f"Curve “{there[task].name}” ({curve.content_hash}, {made_by}) against the laws fitted to it; unloadings run to separation. "
            "Grey band: the curve's own estimated error."
        )
        yield figures((plots.curve_against_laws(curve, users, colours), caption))


def _meant_for(law: Any, curve: Curve) -> bool:
    """An elastic curve tells a plastic law only how it begins."""
    elastic = curve.material is not None and curve.material.yield_stress is None
    return not (elastic and law_of(law).memory)


def _colours(names: Iterable[str]) -> dict[str, str]:
    """One colour for each name, the same in all pictures of its kind."""
    return dict(zip(names, itertools.cycle(plots.COLOURS), strict=False))


def _material(curve: Curve) -> str:
    if curve.material is None:
        return "not stated"
    material = curve.material
    plastic = "elastic" if material.yield_stress is None else f"Y {material.yield_stress / 1e9:g} GPa"
    return f"E {material.youngs_modulus / 1e9:g} GPa, ν {material.poissons_ratio:g}, {plastic}"


def _fields(folder: Path, there: There, curves: Mapping[str, Curve]) -> Iterator[Block]:
    for task, curve in curves.items():
        place = there[task].files.get("fields")
        states = plots.fields_in(folder / place, "loading") if place is not None else ()
        if not states:
            continue
        stress, symbol = plots.stress_scale(curve)
        source = f"Curve “{there[task].name}” ({curve.content_hash})."
        pair = [(plots.pressure_profiles(states, stress, symbol), f"Contact pressure over the contact at the stored states. {source}")]
        if curve.material is not None and curve.material.yield_stress is not None:
            deepest = states[-1]
            caption = (
                f"Upper half of the meridian section at δ/R = {deepest.depth:g}, deformed to scale: von Mises stress on the left, "
                f"equivalent plastic strain on the right. {source}"
            )
            pair.insert(0, (plots.section(deepest, curve.radius, curve.material.yield_stress), caption))
        yield figures(*pair)


def _laws(folder: Path, there: There, laws: Mapping[str, FittedLaw]) -> Iterator[Block]:
    rows = [row for task in laws for row in fit_tables.read(folder / there[task].files["row"]).rows]
    overview.write_tables(folder, rows)
    if not laws:
        return
    measures = list(rows[0].residuals._fields)
    header = ("fit", "law", "curves", *(name.replace("_", " ") for name in measures), "condition number", "good up to δ/R")
    body = []
    for (task, law), row in zip(laws.items(), rows, strict=True):
        sizes = [percent(getattr(row.residuals, name)) for name in measures]
        hashes = " ".join(item[:8] for item in law.curve_hashes)
        body.append(
            (there[task].name, law.name, hashes, *sizes, number(row.condition_number, 3), number(law.max_overlap / law.law.radius, 3))
        )
    yield text(
        "Differences between law and curve, each quantity apart: force and contact radius along the loading, then unloading stiffness "
        "1/(δ_max − δ_0), residual overlap, force along the unloadings, and energy given back. table.csv and table.parquet hold the same."
    )
    yield table(header, body)
    yield table(("fit", "fitted parameter (SI)", "value", "standard error"), list(_parameters(there, laws)))
    for task in laws:
        if there[task].summary["warnings"]:
            yield text(f"{there[task].name}: {'; '.join(there[task].summary['warnings'])}.", note=True)


def _parameters(there: There, laws: Mapping[str, FittedLaw]) -> Iterator[tuple[str, ...]]:
    for task, law in laws.items():
        for name, value in zip(law.law._fields, law.law, strict=True):
            if name in law.standard_errors:
                yield there[task].name, name.replace("_", " "), number(float(value), 6), number(law.standard_errors[name], 2)


def _impacts(listed: Mapping[str, Any], there: There, laws: Mapping[str, FittedLaw]) -> Iterator[Block]:
    impacts = {task: record for task, record in there.items() if record.kind == "impacts"}
    if not impacts:
        return
    first = listed[next(iter(impacts))]["values"]
    thornton = next((law.law for law in laws.values() if isinstance(law.law, Thornton)), None)
    tables = {record.name: record.summary for record in impacts.values()}
    caption = "Two equal spheres meeting head-on, by the kernel that also runs the packings."
    if thornton is not None:
        caption += " Grey: Thornton's closed form for the fitted yield pressure; his law must lie on it."
    rows = []
    for name, values in tables.items():
        for speed, e, duration, overlap in zip(
            *(values[key] for key in ("speed", "restitution", "contact_time", "largest_overlap")), strict=True
        ):
            rows.append((name, number(speed, 4), f"{e:.5f}", number(duration * 1e9, 4), number(overlap / first["radius"] / 2, 3)))
    yield figures((plots.restitution(tables, thornton, first["density"], first["radius"], _colours(tables)), caption))
    yield table(("impact", "speed (m/s)", "restitution", "contact time (ns)", "largest δ/R of one body"), rows)
    for record in impacts.values():
        for warning in record.summary.get("warnings", ()):
            yield text(f"{record.name}: {warning}", note=True)


def _scenes(folder: Path, listed: Mapping[str, Any], there: There, laws: Mapping[str, FittedLaw]) -> Iterator[Block]:
    scenes = {record.name: record for record in there.values() if record.kind == "scenes"}
    if not scenes:
        return
    histories = {name: history.read(folder / record.files["history"]) for name, record in scenes.items()}
    made_with = {name: [*listed[record.task]["given"], *listed[record.task]["needs"]] for name, record in scenes.items()}
    caption = "; ".join(f"“{name}” on {_law_among(made_with[name])}" for name in scenes)
    yield figures(
        (plots.stress_strain(histories, _colours(histories)), f"Axial stress against axial strain, compression and release: {caption}.")
    )
    yield figures(
        *(
            (plots.energies(values), f"Energy balance of “{name}”; {sources_alone(scenes[name].code)}.")
            for name, values in histories.items()
        )
    )
    rows = []
    for name, values in histories.items():
        peak = int(values["strain_z"].argmax())
        statistics = scenes[name].summary["statistics"]
        cells = (
            f"{values['stress_zz'][peak] / 1e6:.4g}",
            f"{values['coordination_number'][peak]:.3f}",
            f"{values['packing_fraction'][peak]:.4f}",
        )
        rows.append(
            (
                name,
                *cells,
                number(abs(values["balance"]).max(), 2),
                number(max(statistics["dt_over_critical"]), 3) if statistics["dt_over_critical"] else "quasi-static",
                str(statistics["steps"]),
            )
        )
    peak_columns = ("axial stress (MPa)", "coordination number", "packing fraction")
    yield table(("scene", *peak_columns, "worst energy balance", "step over critical step", "steps"), rows)
    for name, record in scenes.items():
        for line in (*record.summary["warnings"], *record.summary["notes"]):
            yield text(f"{name}: {line}", note=True)


def _law_among(sources: list[str]) -> str:
    """The law that a scene is made with; of ellipsoids there is no source but their packing."""
    return next((name.removeprefix("fits.") for name in sources if not name.startswith("packings.")), "the law of its ellipsoids' material")


def _costs(case: Mapping[str, Any], there: There) -> Iterator[Block]:
    rows = []
    for item in case["tasks"]:
        record = there.get(item["task"])
        if record is not None:
            made_from = ", ".join((*item["needs"], *(Path(path).name for path in item["given"]))) or "input alone"
            apart = number(record.summary.get("cost", record.summary.get("statistics", {}).get("cpu_seconds")), 3)
            code = sources_alone(record.code).removeprefix("fe2dem ")
            rows.append((record.task, record.key, made_from, code, f"{record.cpu_seconds:.1f}", apart))
    yield text(
        "CPU seconds of each result when it was made, compilation of kernels included; apart: what the solver took, where it says so. "
        "The key is a hash of the checked input, of what it was made from, and of the sources."
    )
    yield table(("result", "key", "made from", "code", "CPU s", "solver apart"), rows)
    for code in sorted({record.code for record in there.values()}):
        yield text(f"{code}.", note=True)
