"""The finite-size factors of an elastic sphere as functions of Poisson's ratio: `contactlaws.elastic.FINITE_SIZE`, fitted anew.

    python -m calibration.finite_size_fit

About half a minute. Presses elastic spheres of Poisson's ratios from 0 to 0.4999 to 0.32 R, and to 0.01 R on a finer scale, fits the
factors of force and area in least squares over overlaps to 0.3 R (relative errors, those up to 0.1 R counting twice), and prints the
constants and what they leave, beside those in place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contactlaws.elastic import FINITE_SIZE, finite_size_factors
from contactlaws.material import Material
from fem.press import press

FloatArray = np.ndarray

RATIOS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.4314, 0.45, 0.47, 0.49, 0.499, 0.4999)
#: powers of the root of the overlap over the radius, and the degree in Poisson's ratio
FORCE, FORCE_DEGREE = (1, 2, 6), 3
AREA, AREA_DEGREE = (1, 4), 2
DEEPEST, SHALLOW = 0.3, 0.1


class Sample(NamedTuple):
    """One sphere: rows of overlap over the radius, force over Hertz's, contact area over pi R d."""

    ratio: float
    overlap: FloatArray
    force: FloatArray
    area: FloatArray


def sample(ratio: float) -> Sample:
    """Both presses of one Poisson's ratio; of the deep one the rows beyond the other."""
    material = Material(1000.0, ratio)
    rows = []
    for depth in (0.01, 0.32):
        curve = press(material, max_overlap=depth, tolerance=0.0025)
        assert curve.contact_radius is not None
        overlap, force, radius = (column[curve.rows(0)][1:] for column in (curve.overlap, curve.force, curve.contact_radius))
        keep = (overlap <= DEEPEST) & ((overlap > 0.012) if depth > 0.01 else True)
        hertz = 4.0 / 3.0 * material.reduced_modulus * overlap**1.5
        rows.append(np.stack([overlap, force / hertz, radius**2 / overlap])[:, keep])
    return Sample(ratio, *np.concatenate(rows, axis=1))


def fitted(samples: list[Sample], name: str, powers: tuple[int, ...], degree: int) -> FloatArray:
    """Constants (powers, degree + 1) of one factor."""
    columns, targets = [], []
    for one in samples:
        root, value = np.sqrt(one.overlap), getattr(one, name)
        weight = np.where(one.overlap <= SHALLOW, 2.0, 1.0) / value
        terms = [weight * root**p * one.ratio**j for p in powers for j in range(degree + 1)]
        columns.append(np.stack(terms, axis=1))
        targets.append(weight * (value - 1.0))
    found = np.linalg.lstsq(np.concatenate(columns), np.concatenate(targets), rcond=None)[0]
    return np.asarray(found.reshape(len(powers), degree + 1))


def errors(samples: list[Sample]) -> list[str]:
    """For each Poisson's ratio the worst error of the factors in place, to 0.1 R and to 0.3 R."""
    lines = []
    for one in samples:
        c1, c2, c3, b1, b2 = finite_size_factors(one.ratio)
        d, root = one.overlap, np.sqrt(one.overlap)
        force = abs((1.0 + c1 * root + c2 * d + c3 * d**3) / one.force - 1.0)
        radius = abs(np.sqrt((1.0 + b1 * root + b2 * d * d) / one.area) - 1.0)
        cells = [f"{100.0 * values[d <= deep].max():.2f} %" for values in (force, radius) for deep in (SHALLOW, DEEPEST)]
        lines.append(f"nu {one.ratio:<7g} force {cells[0]} {cells[1]}, contact radius {cells[2]} {cells[3]}")
    return lines


def main() -> None:
    """Compute, fit, print."""
    samples = [sample(ratio) for ratio in RATIOS]
    print("FINITE_SIZE = (")
    for rows in (fitted(samples, "force", FORCE, FORCE_DEGREE), fitted(samples, "area", AREA, AREA_DEGREE)):
        for row in rows:
            print(f"    ({', '.join(f'{value:.6g}' for value in row)}),")
    print(f")\nin place: {FINITE_SIZE}\nworst errors of those in place, up to {SHALLOW:g} R and up to {DEEPEST:g} R:")
    print("\n".join(errors(samples)))


if __name__ == "__main__":
    main()
