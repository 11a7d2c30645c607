"""The atlas: what finite elements found for a tensor of materials, small enough to ship, and the file that holds it."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from calibration.atlas_columns import LOADING_COLUMNS, UNLOADING_COLUMNS
from contactlaws.curve import QUANTITIES
from contactlaws.errors import InputError, Problem
from contactlaws.files import write_atomically
from contactlaws.json_input import parsed

FloatArray = npt.NDArray[np.float64]

FORMAT = "fe2dem atlas 1"
SHIPPED = Path(__file__).parent / "data" / "atlas.parquet"


@dataclass(frozen=True)
class Atlas:
    """Columns (see `calibration.atlas_columns`) of all pairs of the moduli and Poisson's ratios below; radius and yield stress are 1."""

    modulus_ratios: FloatArray  # E/Y, ascending; n
    poissons_ratios: FloatArray  # ascending; m
    depths: FloatArray  # overlap over radius on the loading, ascending
    starts: FloatArray  # overlap over radius that an unloading starts from, ascending
    yield_depth: FloatArray  # (n, m); NaN: this material does not yield up to the largest depth
    loading: FloatArray  # (n, m, depths, LOADING_COLUMNS)
    unloading: FloatArray  # (n, m, starts, UNLOADING_COLUMNS)
    elastic_loading: FloatArray  # (m, depths, LOADING_COLUMNS)
    elastic_unloading: FloatArray  # (m, starts, UNLOADING_COLUMNS - 1)
    errors: FloatArray  # (n, m, len(QUANTITIES)); the finite elements' own estimates
    leave_out: FloatArray  # (2, n, m, starts, len(QUANTITIES)); see `calibration.atlas_errors.leave_out`
    hashes: tuple[str, ...]  # content hashes of all curves: n x m plastic ones, then m elastic ones
    provenance: Mapping[str, Any] = field(default_factory=dict)  # code versions of the curves and of the reduction, leave-out errors

    @property
    def content_hash(self) -> str:
        """Sixteen hexadecimal digits of the numbers, and of the hashes of the curves that they are from."""
        digest = hashlib.sha256(json.dumps(self.hashes).encode())
        for name in ARRAYS:
            digest.update(name.encode() + np.ascontiguousarray(getattr(self, name)).tobytes())
        return digest.hexdigest()[:16]

    def without(self, modulus_ratio: float | None = None, poissons_ratio: float | None = None) -> Atlas:
        """The atlas that would be there without one of its moduli or Poisson's ratios; for leave-out tests."""
        keep = self.modulus_ratios != modulus_ratio
        own = self.poissons_ratios != poissons_ratio
        tensor = {name: getattr(self, name)[np.ix_(keep, own)] for name in ("yield_depth", "loading", "unloading", "errors")}
        left = self.leave_out[:, keep][:, :, own]
        return Atlas(
            self.modulus_ratios[keep],
            self.poissons_ratios[own],
            self.depths,
            self.starts,
            elastic_loading=self.elastic_loading[own],
            elastic_unloading=self.elastic_unloading[own],
            leave_out=left,
            hashes=self.hashes,
            **tensor,
        )


ARRAYS: tuple[str, ...] = ("modulus_ratios", "poissons_ratios", "depths", "starts", "yield_depth", "loading", "unloading")
ARRAYS += ("elastic_loading", "elastic_unloading", "errors", "leave_out")


def write(atlas: Atlas, path: str | Path) -> Path:
    """One row per material, the elastic ones (without yield stress) last; raises `InputError` if the file cannot be written."""
    n, m = atlas.modulus_ratios.size, atlas.poissons_ratios.size
    plastic = [
        {
            "modulus_ratio": float(ratio),
            "poissons_ratio": float(nu),
            "yield_depth": None if np.isnan(atlas.yield_depth[i, j]) else float(atlas.yield_depth[i, j]),
            "loading": atlas.loading[i, j].ravel().tolist(),
            "unloading": atlas.unloading[i, j].ravel().tolist(),
            "errors": atlas.errors[i, j].tolist(),
            "leave_out": atlas.leave_out[:, i, j].ravel().tolist(),
            "curve": atlas.hashes[i * m + j],
        }
        for i, ratio in enumerate(atlas.modulus_ratios)
        for j, nu in enumerate(atlas.poissons_ratios)
    ]
    elastic = [
        {
            "modulus_ratio": None,
            "poissons_ratio": float(nu),
            "yield_depth": None,
            "loading": atlas.elastic_loading[j].ravel().tolist(),
            "unloading": atlas.elastic_unloading[j].ravel().tolist(),
            "errors": None,
            "leave_out": None,
            "curve": atlas.hashes[n * m + j],
        }
        for j, nu in enumerate(atlas.poissons_ratios)
    ]
    facts = {"depths": atlas.depths.tolist(), "starts": atlas.starts.tolist(), "hash": atlas.content_hash, **atlas.provenance}
    schema = pa.schema(_FIELDS, {"format": FORMAT, "facts": json.dumps(facts, allow_nan=False)})
    table = pa.Table.from_pylist([*plastic, *elastic], schema)
    return write_atomically(path, lambda file: pq.write_table(table, file, compression="zstd"))


_NUMBERS = pa.list_(pa.float64())
_FIELDS = [
    pa.field("modulus_ratio", pa.float64(), metadata={"unit": "1", "meaning": "Young's modulus over yield stress; null: elastic"}),
    pa.field("poissons_ratio", pa.float64(), False, {"unit": "1"}),
    pa.field("yield_depth", pa.float64(), metadata={"unit": "1", "meaning": "overlap over radius at first yield; null: none"}),
    pa.field("loading", _NUMBERS, False, {"shape": f"depths, {LOADING_COLUMNS}", "meaning": "ln F/F_el, ln A/A_el; elastic: to Hertz"}),
    pa.field("unloading", _NUMBERS, False, {"shape": f"starts, {UNLOADING_COLUMNS}", "meaning": "ln w/d, exponents of force and area"}),
    pa.field("errors", _NUMBERS, metadata={"shape": f"{len(QUANTITIES)}", "meaning": ", ".join(QUANTITIES)}),
    pa.field("leave_out", _NUMBERS, metadata={"shape": f"2, starts, {len(QUANTITIES)}", "meaning": "change without modulus, without nu"}),
    pa.field("curve", pa.string(), False, {"meaning": "content hash of the curve"}),
]


@functools.cache
def shipped() -> Atlas:
    """The atlas that comes with this package."""
    return read(SHIPPED)


def read(path: str | Path) -> Atlas:
    """Read what `write` wrote; raises `InputError` for a file that is not there, is damaged, or is something else."""
    try:
        table = pq.ParquetFile(path).read()
        metadata = {key.decode(): value for key, value in (table.schema.metadata or {}).items()}
        if metadata.get("format") != FORMAT.encode():
            _broken(path, table.column_names[:8], f"is Parquet, but no {FORMAT!r}")
        facts = parsed(metadata["facts"])
        atlas = _from_rows(table.to_pylist(), facts)
    except OSError as error:
        raise InputError(Problem(str(path), error.strerror or str(error), "cannot be read", "check the name and the permission")) from error
    except pa.ArrowException as error:
        _broken(path, str(error).splitlines()[0], "is no whole Parquet file")
    except (KeyError, TypeError, ValueError, IndexError) as error:
        if isinstance(error, InputError):
            raise
        _broken(path, str(error), "does not hold what an atlas must")
    if atlas.content_hash != facts["hash"]:
        _broken(path, atlas.content_hash, f"its numbers are not those it was written with ({facts['hash']})")
    return atlas


def _from_rows(rows: list[dict[str, Any]], facts: Mapping[str, Any]) -> Atlas:
    plastic = [row for row in rows if row["modulus_ratio"] is not None]
    elastic = [row for row in rows if row["modulus_ratio"] is None]
    ratios = np.unique([row["modulus_ratio"] for row in plastic])
    nus = np.unique([row["poissons_ratio"] for row in elastic])
    shape, depths, starts = (ratios.size, nus.size), np.array(facts["depths"]), np.array(facts["starts"])

    def stacked(name: str, source: list[dict[str, Any]], *to: int) -> FloatArray:
        return np.array([np.nan if row[name] is None else row[name] for row in source], dtype=np.float64).reshape(to)

    return Atlas(
        ratios,
        nus,
        depths,
        starts,
        stacked("yield_depth", plastic, *shape),
        stacked("loading", plastic, *shape, depths.size, LOADING_COLUMNS),
        stacked("unloading", plastic, *shape, starts.size, UNLOADING_COLUMNS),
        stacked("loading", elastic, nus.size, depths.size, LOADING_COLUMNS),
        stacked("unloading", elastic, nus.size, starts.size, UNLOADING_COLUMNS - 1),
        stacked("errors", plastic, *shape, len(QUANTITIES)),
        np.moveaxis(stacked("leave_out", plastic, *shape, 2, starts.size, len(QUANTITIES)), 2, 0),
        tuple(row["curve"] for row in rows),
        {name: value for name, value in facts.items() if name not in ("depths", "starts", "hash")},
    )


def _broken(path: str | Path, value: object, bound: str) -> NoReturn:
    raise InputError(Problem(str(path), value, bound, "install the package anew, or run `python -m calibration.atlas_build`"))
