"""The comparison with another code's curves finds the differences that were put in, and its exit code says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cases.verification import reference_curves
from contactlaws.curve import Curve
from contactlaws.errors import InputError
from contactlaws.material import Material

OVERLAP, SEPARATION, EXPONENT = 0.05, 0.04, 1.4


def loading_force(overlap):
    return 3.0 * overlap**1.2


def unloading_force(overlap, zero=SEPARATION, exponent=EXPONENT):
    return loading_force(OVERLAP) * ((overlap - zero) / (OVERLAP - zero)) ** exponent


def own_curve(force_factor=1.0, zero=SEPARATION, exponent=EXPONENT) -> Curve:
    load, unload = np.linspace(0.0, OVERLAP, 80), np.linspace(OVERLAP, zero, 60)
    force = force_factor * np.pi * np.concatenate([loading_force(load), unloading_force(unload, zero, exponent)])
    overlap = np.concatenate([load, unload])
    return Curve(
        time=np.arange(overlap.size),
        overlap=overlap,
        force=force,
        branch=np.repeat([0, 1], [80, 60]),
        radius=1.0,
        contact_radius=np.sqrt(2.0 * overlap),
        material=Material(100.0, 0.3, 1.0),
        provenance={"cpu_seconds": 0.0},
    )


@pytest.fixture
def folder(tmp_path):
    load, unload = np.linspace(OVERLAP / 30, OVERLAP, 30), np.linspace(OVERLAP, SEPARATION, 21)[1:]
    lines = ["delta,F,a,stage,a_lo,a_hi"]
    lines += [f"{x!r},{loading_force(x)!r},0,load,{0.99 * (2 * x) ** 0.5!r},{1.01 * (2 * x) ** 0.5!r}" for x in load.tolist()]
    lines += [f"{x!r},{unloading_force(x)!r},0,unload,{0.99 * (2 * x) ** 0.5!r},{1.01 * (2 * x) ** 0.5!r}" for x in unload.tolist()]
    (tmp_path / "E100_nu0.3_d0.05.csv").write_text("\n".join(lines))
    return tmp_path


@pytest.mark.parametrize(("factor", "zero", "exponent"), [(1.0, SEPARATION, EXPONENT), (1.01, 0.0405, EXPONENT), (0.98, SEPARATION, 1.45)])
def test_differences_put_in_are_found(folder, factor, zero, exponent):
    found = reference_curves.compare(own_curve(factor, zero, exponent), reference_curves.read(folder / "E100_nu0.3_d0.05.csv"))
    # interpolation between 80 rows: 1e-4
    assert found.force_by_work == pytest.approx(factor - 1.0, abs=1e-4)
    assert found.force_pointwise == pytest.approx(factor - 1.0, abs=1e-4)
    assert found.stiffness == pytest.approx((OVERLAP - SEPARATION) / (OVERLAP - zero) - 1.0, abs=1e-3)
    assert found.exponent == pytest.approx(exponent - EXPONENT, abs=1e-3)
    assert found.inside == 1.0
    assert bool(found.broken()) == (factor != 1.0)


@pytest.mark.parametrize(("factor", "outside"), [(1.005, 0.0), (1.03, 0.02), (0.96, 0.03)])
def test_a_radius_out_of_its_bracket_breaks_the_bound(folder, factor, outside):
    """The bracket is 1 % to both sides; the curve's own estimate of its radius error, 1.5 %, is let pass."""
    own = own_curve()
    moved = replace(own, contact_radius=factor * own.contact_radius, errors={"contact_radius": 0.015})
    found = reference_curves.compare(moved, reference_curves.read(folder / "E100_nu0.3_d0.05.csv"))
    assert found.outside_by == pytest.approx(outside / factor, abs=1e-3)
    # over the largest radius, from .05 to .042 R: 5 % less in the mean
    assert found.unloading_outside == pytest.approx(0.95 * outside / factor, abs=2e-3)
    broken = ["contact radius outside its bracket", "contact radius outside its bracket on unloading"]
    assert [line.rsplit(maxsplit=3)[0] for line in found.broken()] == (broken if outside > 0.015 else [])


def test_the_exit_code_tells_of_a_broken_bound(folder, monkeypatch, capsys):
    monkeypatch.setattr(reference_curves, "compute", lambda reference, tolerance: own_curve(1.02))
    monkeypatch.setattr(reference_curves.fem, "press", lambda *arguments, **options: None)
    assert reference_curves.main([str(folder)]) == 1
    assert "BROKEN: force +0.0200" in capsys.readouterr().out
    monkeypatch.setattr(reference_curves, "compute", lambda reference, tolerance: own_curve())
    assert reference_curves.main([str(folder)]) == 0


def test_nothing_to_compare_with_is_said(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("FE2DEM_REFERENCE", raising=False)
    assert reference_curves.main([]) == 2
    assert reference_curves.main([str(tmp_path)]) == 2
    assert "FE2DEM_REFERENCE not set" in capsys.readouterr().err
    with pytest.raises(InputError, match="must be named"):
        reference_curves.read(tmp_path / "curve.csv")
