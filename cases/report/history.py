"""What a scene did over time, as a table: Parquet with units in its schema, one row per output."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from contactlaws.files import write_atomically
from contactlaws.version import code_version

#: unit of every column; compression is positive in strain and stress
UNITS = {
    "time": "s",
    "stage": "1",
    "strain_x": "1",
    "strain_y": "1",
    "strain_z": "1",
    **{f"shear_{plane}": "1" for plane in ("xy", "xz", "yz")},
    **{f"stress_{a}{b}": "Pa" for a in "xyz" for b in "xyz"},
    **{f"fabric_{a}{b}": "1" for a in "xyz" for b in "xyz"},
    "coordination_number": "1",
    "coordination_number_held": "1",
    "rattlers": "1",
    "packing_fraction": "1",
    "contacts_beyond": "1",
    "kinetic": "J",
    "stored": "J",
    "sheared": "J",
    "dissipated": "J",
    "rubbed": "J",
    "dashed": "J",
    "damped": "J",
    "boundary_work": "J",
    "balance": "1",
}


def columns(trajectory: Any) -> dict[str, npt.NDArray[Any]]:
    """The table's columns from a trajectory of `dem.run`."""
    found = {name: getattr(trajectory, name) for name in UNITS if hasattr(trajectory, name)}
    found |= {f"strain_{axis}": trajectory.strain[:, i] for i, axis in enumerate("xyz")}
    found |= {name: getattr(trajectory.energies, name) for name, unit in UNITS.items() if unit == "J" or name == "balance"}
    found |= {f"shear_{plane}": trajectory.shear[:, i] for i, plane in enumerate(("xy", "xz", "yz"))}
    found |= {f"stress_{a}{b}": trajectory.stress[:, i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
    found |= {f"fabric_{a}{b}": trajectory.fabric[:, i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
    return {name: np.asarray(found[name]) for name in UNITS}


def write(values: Mapping[str, npt.NDArray[Any]], path: Path) -> Path:
    """Write the columns to a .parquet file, whole or not at all."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table(dict(values))
    fields = [field.with_metadata({"unit": UNITS[field.name]}) for field in table.schema]
    return write_atomically(path, lambda file: pq.write_table(table.cast(pa.schema(fields, {"code": code_version()})), file))


def read(path: Path) -> dict[str, npt.NDArray[Any]]:
    """The columns that `write` wrote."""
    import pyarrow.parquet as pq

    table = pq.ParquetFile(path).read()
    return {name: table[name].to_numpy() for name in table.column_names}
