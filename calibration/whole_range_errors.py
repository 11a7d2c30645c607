"""How far the whole-range law is from a folder of curves: percentiles of the relative errors, and where the worst stand.

python -m calibration.whole_range_errors FOLDER
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from calibration.unloadings import power_law
from calibration.whole_range_data import Targets, evaluate, read_folder, targets
from contactlaws import whole_range_constants
from contactlaws.whole_range_record import Constants

FloatArray = npt.NDArray[np.float64]

PERCENTILES = (50, 75, 90, 100)
_FINE = np.linspace(1.0, 0.0, 201)


def errors(constants: dict[str, float], wanted: Targets) -> dict[str, FloatArray]:
    """Relative errors (law over curve less 1) of each quantity, one per unloading.

    `shape`: largest difference of the force over F_max; `retreat`: mean difference of the contact area over its largest, at the same steps.
    """
    record = Constants(**constants)
    found = evaluate(record, wanted.modulus, wanted.poissons_ratio, wanted.depth, wanted.s)
    fine = evaluate(
        record, wanted.modulus, wanted.poissons_ratio, wanted.depth, np.broadcast_to(_FINE, (wanted.depth.size, _FINE.size)).copy()
    )
    exponent = np.array([power_law(_FINE, np.append(row[:-1], 0.0)).exponent for row in fine.shape])
    return {
        "force": found.load / wanted.load - 1.0,
        "contact radius": found.contact_radius / wanted.contact_radius - 1.0,
        "rho": wanted.recovered / found.recovered - 1.0,
        "alpha": exponent / wanted.exponent - 1.0,
        "energy": found.energy / wanted.energy - 1.0,
        "shape": abs(found.shape - wanted.shape).max(axis=1),
        "retreat": abs(found.area - wanted.area).mean(axis=1),
        "yield": np.where(np.isfinite(wanted.yield_depth), found.yield_depth / wanted.yield_depth - 1.0, 0.0),
    }


def report(constants: dict[str, float], wanted: Targets, unseen: Targets | None = None) -> str:
    """The table of percentiles as text."""
    groups = [("all", wanted, np.ones(wanted.depth.size, dtype=bool)), ("plastic", wanted, wanted.plastic)]
    if unseen is not None:
        groups += [("unseen", unseen, np.ones(unseen.depth.size, dtype=bool)), ("unseen plastic", unseen, unseen.plastic)]
    return "\n".join(line for name, rows, keep in groups for line in _lines(name, constants, rows, keep))


def _lines(name: str, constants: dict[str, float], wanted: Targets, keep: npt.NDArray[np.bool_]) -> Iterator[str]:
    shares = "/".join(map(str, PERCENTILES))
    yield f"{name}: {np.count_nonzero(keep)} unloadings, absolute relative error in % at the {shares}th percentile"
    for quantity, error in errors(constants, wanted).items():
        values = 100.0 * abs(error[keep])
        text = "/".join(f"{value:.2f}" for value in np.percentile(values, PERCENTILES))
        worst = int(np.flatnonzero(keep)[values.argmax()])
        place = f"E/Y {wanted.modulus[worst]:g}, nu {wanted.poissons_ratio[worst]:g}, overlap {wanted.depth[worst]:.3g} R"
        yield f"  {quantity:15s}{text:>24s}   worst {100.0 * error[worst]:+.2f} at {place}"


def main() -> None:
    """Print the table for the constants in place."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--compact", action="store_true", help="of the law with 20 constants")
    options = parser.parse_args()
    constants = whole_range_constants.COMPACT if options.compact else whole_range_constants.WHOLE
    print(report(constants, targets(read_folder(options.folder))))


if __name__ == "__main__":
    main()
