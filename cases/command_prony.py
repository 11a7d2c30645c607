"""The command `fe2dem prony`: a measured table of relaxation, creep or DMA becomes a Prony series."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cases.arguments import option

Text = str | None


def prony(
    table: Annotated[
        Path | None,
        typer.Argument(
            metavar="TABLE.csv", help="Columns time,modulus; time,compliance; or frequency,storage,loss: s, Pa, Hz", show_default=False
        ),
    ] = None,
    poissons_ratio: Annotated[Text, option("The instantaneous one; without it, it is left to whoever reads the series.")] = None,
    bulk: Annotated[
        str, option("'with-shear': Poisson's ratio stays, as it does without this; 'constant': the bulk modulus.")
    ] = "with-shear",
    terms: Annotated[int | None, option("How many; without it the number with the smallest BIC.")] = None,
    noise: Annotated[Text, option("Standard deviation of each number over itself, such as 0.01 or '1 %'; default: found.")] = None,
    out: Annotated[Path | None, option("SERIES.csv: where to save the series.")] = None,
) -> None:
    """Fit a Prony series to a measured table; prints candidates, parameters with their errors, and what the table cannot tell."""
    from cases import prony_series

    values = {"poissons_ratio": poissons_ratio, "bulk": bulk, "terms": terms, "noise": noise}
    prony_series.fit(table, {name: value for name, value in values.items() if value is not None}, out)
