"""What the scenes of a propagation have done, put together: stress against strain of every law on every packing."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cases.batch.store import Record
from cases.report import history
from contactlaws.errors import InputError, Problem

FloatArray = npt.NDArray[np.float64]

#: strain and stress of each loading: columns of a history; several are averaged
COLUMNS = {
    "uniaxial": (("strain_z",), ("stress_zz",)),
    "isotropic": (("strain_x", "strain_y", "strain_z"), ("stress_xx", "stress_yy", "stress_zz")),
    "shear": (("shear_xz",), ("stress_xz",)),
}
#: outputs are at the same strains, but for the last step's round-off
SAME = 1e-9


class Runs(NamedTuple):
    """Every law on every packing, at the same outputs."""

    stage: npt.NDArray[np.int64]
    strain: FloatArray
    stress: FloatArray  # Pa, shape (laws, packings, outputs)
    laws: tuple[str, ...]  # names of the draws that are in it
    packings: tuple[str, ...]
    left_out: tuple[str, ...]  # draws that did not run on all packings, and why

    @property
    def peak(self) -> int:
        """The output of the largest strain."""
        return int(np.argmax(np.abs(self.strain)))


def put_together(records: Mapping[str, Record], folder: Path, loading: str) -> Runs:
    """All scenes of a run; a law that failed on a packing is left out. Raises `InputError` if fewer than two are left."""
    scenes = {record.name: record for record in records.values() if record.kind == "scenes"}
    packings = tuple(dict.fromkeys(name.split("-")[1] for name in scenes))
    laws, left_out = [], []
    for law in dict.fromkeys(name.split("-")[0] for name in scenes):
        bad = [scenes[f"{law}-{packing}"] for packing in packings if scenes[f"{law}-{packing}"].state != "done"]
        if bad:
            left_out.append(f"law {law} is left out: {bad[0].task} {bad[0].state}: {bad[0].reason}")
        else:
            laws.append(law)
    if len(laws) < 2:
        remedy = "fe2dem status says why each failed; give more draws, or a law that the curves determine better"
        raise InputError(Problem("--draws", len(laws), "laws have run on all packings, and two are needed", remedy))
    tables = {name: history.read(folder / record.files["history"]) for name, record in scenes.items() if name.split("-")[0] in laws}
    strains, stresses = COLUMNS[loading]
    first = tables[f"{laws[0]}-{packings[0]}"]
    strain = np.mean([first[column] for column in strains], axis=0)
    for name, table in tables.items():
        found = np.mean([table[column] for column in strains], axis=0)
        if found.shape != strain.shape or abs(found - strain).max() > SAME:
            raise InputError(Problem(f"scenes.{name}", len(found), "has other outputs than the first", "run again in an empty folder"))
    stress = np.array(
        [[np.mean([tables[f"{law}-{packing}"][column] for column in stresses], axis=0) for packing in packings] for law in laws]
    )
    return Runs(first["stage"].astype(np.int64), strain, stress, tuple(laws), packings, tuple(left_out))
