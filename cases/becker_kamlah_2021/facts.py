"""What statements are judged by, and what a statement is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cases.becker_kamlah_2021.apart import Loaded, Unloaded, loaded, unloaded
from cases.becker_kamlah_2021.bodies import Named
from cases.becker_kamlah_2021.data import Key, Study, nmc_key
from cases.becker_kamlah_2021.joint_fit import Joint, fit_all
from cases.becker_kamlah_2021.shape_fit import Read, Shape, Together, fit, fit_together, points, readings
from cases.edmans_sinka_2020.facts import span
from cases.report.judgement import FAILS, HOLDS, PARTLY, UNTESTED, Finding, Lacking, Statement, verdict

__all__ = ["FAILS", "HOLDS", "PARTLY", "UNTESTED", "Facts", "Finding", "Lacking", "Statement", "gather", "span", "verdict"]

QUANTITIES = ("pressure_ratio", "radius_ratio")
READINGS = ("force", "plateau")


@dataclass(frozen=True)
class Facts:
    """Everything computed."""

    study: Study
    named: Named
    read_of: Mapping[Key, Sequence[Read]]
    loading: Sequence[Loaded]  # of the authors' material, as `unloading`
    unloading: Sequence[Unloaded]
    shapes: Mapping[tuple[Key, str, str], Shape]  # by material, reading and quantity
    together: Mapping[tuple[str, str], Together]  # by reading and quantity
    joint: Mapping[Key, Joint]  # all seven constants, by material

    @property
    def nmc(self) -> Sequence[Read]:
        """Readings of the authors' material, by shape."""
        return self.readings(nmc_key())

    def readings(self, key: Key) -> Sequence[Read]:
        """Of one material; raises `Lacking`."""
        if key not in self.read_of:
            raise Lacking(f"E/Y = {key[0]:g}, ν = {key[1]:g}")
        return self.read_of[key]

    def of_shape(self, key: Key, aspect: float) -> Read:
        """One body; raises `Lacking`."""
        for row in self.readings(key):
            if abs(row.body.aspect - aspect) < 1e-6:
                return row
        raise Lacking(f"the body 1:{aspect:g} of E/Y = {key[0]:g}, ν = {key[1]:g}")

    def shape(self, reading: str, quantity: str, key: Key | None = None) -> Shape:
        """A fit of Eq. 52; raises `Lacking`."""
        found = self.shapes.get((key or nmc_key(), reading, quantity))
        if found is None:
            raise Lacking("enough shapes to fit Eq. 52")
        return found


def gather(study: Study, named: Named) -> Facts:
    """All readings, fits and comparisons of a study."""
    read_of = readings(study)
    own = {row.body.name: row.force for row in read_of.get(nmc_key(), ())}
    bodies = [body for body in study.nmc if body.name in own]
    laws = [body.law._replace(pressure_ratio=own[body.name].pressure_ratio, radius_ratio=own[body.name].radius_ratio) for body in bodies]
    shapes = {
        (key, reading, quantity): found
        for key, rows in read_of.items()
        for reading in READINGS
        for quantity in QUANTITIES
        if (found := fit(*points(rows, quantity, reading), quantity)) is not None
    }
    together = {
        (reading, quantity): whole
        for reading in READINGS
        for quantity in QUANTITIES
        if (whole := fit_together(read_of, quantity, reading)) is not None
    }
    return Facts(
        study=study,
        named=named,
        read_of=read_of,
        loading=[loaded(body, law) for body, law in zip(bodies, laws, strict=True)],
        unloading=[row for body in bodies for row in unloaded(body)],
        shapes=shapes,
        together=together,
        joint={key: joint for key, rows in read_of.items() if (joint := fit_all(rows)) is not None},
    )
