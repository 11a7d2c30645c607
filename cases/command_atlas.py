"""The commands that need no finite elements: `fe2dem predict` from the atlas, `fe2dem identify` a material by it, `fe2dem ellipsoid`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from cases.arguments import option

Text = str | None
FAILED = 3


def predict(
    youngs_modulus: Annotated[Text, option("Young's modulus, such as '142 GPa'.")] = None,
    poissons_ratio: Annotated[Text, option("Poisson's ratio, in [0, 0.5).")] = None,
    yield_stress: Annotated[Text, option("Yield stress, such as '7.9 GPa'; see --elastic.")] = None,
    elastic: Annotated[bool, typer.Option("--elastic", help="A body that never yields.")] = False,
    radius: Annotated[str, option("Radius of the sphere, such as '5 um'; 1 m without it.")] = "1",
    unload_from: Annotated[list[str] | None, option("D1 D2 ...: overlaps over radius to unload from; default: the atlas's own.")] = None,
    max_overlap: Annotated[Text, option("Largest overlap over radius; default: the largest of --unload-from, else of the atlas.")] = None,
    law: Annotated[Text, option("Law to make of it; 'tabulated', exact on the curve, without it.")] = None,
    tolerance: Annotated[Text, option("In place of --law: takes the cheapest law whose measured error is no larger.")] = None,
    quantity: Annotated[str, option("What --tolerance is about: force, contact_radius, recovered_energy ...; force without it.")] = "force",
    compute: Annotated[bool, typer.Option("--compute", help="Run finite elements for what lies outside the atlas.")] = False,
    out: Annotated[Path | None, option("LAW.json, CURVE.csv or CURVE.parquet.")] = None,
) -> None:
    """Curve or law of any material in the range of the atlas, with its error, in milliseconds."""
    from cases import prediction

    values = {"youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio, "yield_stress": yield_stress, "radius": radius}
    values_given: dict[str, Any] = {name: value for name, value in {**values, "max_overlap": max_overlap}.items() if value is not None}
    choice = prediction.LawOption(law, tolerance, quantity)
    stopped = prediction.predict({**values_given, "unload_from": unload_from or []}, elastic, choice, compute, out)
    if stopped:
        print(f"fe2dem: stopped early: {stopped}; what is in {out} goes up to there", file=sys.stderr)
        raise typer.Exit(FAILED)


def ellipsoid(
    youngs_modulus: Annotated[Text, option("Young's modulus, such as '142 GPa'.")] = None,
    poissons_ratio: Annotated[Text, option("Poisson's ratio, in [0, 0.5).")] = None,
    yield_stress: Annotated[Text, option("Yield stress, such as '7.9 GPa'; see --elastic.")] = None,
    elastic: Annotated[bool, typer.Option("--elastic", help="A body that never yields.")] = False,
    axes: Annotated[list[str] | None, option("A B C: its semi-axes, that of the load first, such as '5 um' '6 um' '7 um'.")] = None,
    other_axes: Annotated[list[str] | None, option("A B C of a second body of this material; a rigid flat without it.")] = None,
    unload_from: Annotated[list[str] | None, option("D1 D2 ...: overlaps over the mean radius (abc)^(1/3), of a pair over both.")] = None,
    out: Annotated[Path | None, option("CURVE.csv: overlap, force and semi-axes of the contact.")] = None,
) -> None:
    """Force and contact ellipse of an ellipsoid on a flat, or of two, along loading and unloadings, by the law of ellipsoids."""
    from cases import ellipsoid_curve

    values: dict[str, Any] = {"youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio, "yield_stress": yield_stress}
    values |= {"axes": axes, "other_axes": other_axes, "unload_from": unload_from}
    ellipsoid_curve.ellipsoid({name: value for name, value in values.items() if value is not None}, elastic, out)


def identify(
    measured: Annotated[Path | None, typer.Argument(metavar="MEASURED.csv", help="Columns overlap,force: m, N", show_default=False)] = None,
    radius: Annotated[Text, option("Radius of the particle, where the file does not say it.")] = None,
    poissons_ratio: Annotated[Text, option("Poisson's ratio, such as 0.3, or an interval such as 0.2..0.35.")] = None,
    zero_unknown: Annotated[bool, typer.Option("--zero-unknown", help="The overlap at first touch is unknown too.")] = False,
    compliance_unknown: Annotated[bool, typer.Option("--compliance-unknown", help="So is how far the machine gives way.")] = False,
    noise: Annotated[Text, option("Standard deviation of a force, such as '2 mN' or '1 %' of the largest; default: found.")] = None,
    out: Annotated[Path | None, option("Folder for identified.json, profiles.csv and identified.png.")] = None,
) -> None:
    """Young's modulus and yield stress from a measured force-overlap curve of one particle, with intervals."""
    from cases import identification

    options = {} if radius is None else {"radius": radius}
    unknown = {"zero_unknown": zero_unknown, "compliance_unknown": compliance_unknown}
    identification.identify(measured, options, poissons_ratio, noise, unknown, out)
