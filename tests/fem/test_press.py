"""The reference curve against Hertz, the theory of first yield, symmetry of scales, and what a curve promises of itself."""

from __future__ import annotations

import math
from itertools import islice
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

from contactlaws.curve import Curve, FloatArray
from contactlaws.errors import InputError
from contactlaws.material import Material
from fem.assembly import discretise
from fem.fields import contact_pressure
from fem.first_yield import small_run
from fem.march import Steps, landings, unload
from fem.mesh import spheroid
from fem.newton import RESIDUAL, Equilibrium, NoEquilibrium
from fem.press import RESOLUTIONS, moduli_of, press, resolution_for
from fem.readout import exponent
from fem.walk import walk

compiled_only = pytest.mark.compiled_only("a run is some hundred assemblies of the mesh; interpreted, minutes")

#: largest pressure over yield stress at first yield in the Hertz field, von Mises, by Poisson's ratio
PRESSURE_AT_YIELD = {0.0: 1.2993, 0.15: 1.4453, 0.3: 1.6128, 0.45: 1.8061, 0.49: 1.8627}


def over_hertz(curve: Curve) -> float:
    """Last loading force over that of a parabolic body with the curvature of the pole, 1/(R aspect^2)."""
    assert curve.material is not None
    last = curve.rows(0).stop - 1
    hertz = 4.0 / 3.0 * curve.material.reduced_modulus * curve.aspect * math.sqrt(curve.radius) * curve.overlap[last] ** 1.5
    return float(curve.force[last] / hertz)


def first_yield_of_a_paraboloid(material: Material, aspect: float = 1.0) -> float:
    """Overlap over the half height at first yield: (pi p0/(2 E*))^2 R."""
    assert material.yield_stress is not None
    p0 = PRESSURE_AT_YIELD[material.poissons_ratio] * material.yield_stress
    return (math.pi * p0 / (2.0 * material.reduced_modulus)) ** 2 * aspect**2


# Hertz


@compiled_only
@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_hertz_at_small_overlap(nu: float):
    """Within 0.3 %. At nu = 0 finite size takes 0.25 % off at this overlap already: the verification goes to 1e-7 there."""
    overlap = 1e-5
    curve = press(Material(1000.0, nu), max_overlap=overlap)
    assert over_hertz(curve) == pytest.approx(1.0, abs=0.003)
    assert curve.contact_radius is not None
    assert curve.contact_radius[-1] == pytest.approx(math.sqrt(overlap), rel=0.01)


@compiled_only
@pytest.mark.parametrize(("overlap", "excess"), [(1e-3, 0.0124), (1e-2, 0.047)])
def test_finite_sphere_is_stiffer_than_hertz(overlap: float, excess: float):
    """What CalculiX gives for nu = 0.3, itself good to 0.5 %; about a/2R."""
    curve = press(Material(1000.0, 0.3), max_overlap=overlap)
    assert over_hertz(curve) - 1.0 == pytest.approx(excess, abs=0.005)


@compiled_only
@pytest.mark.parametrize("aspect", [0.5, 2.0])
def test_spheroid_touches_like_a_sphere_of_its_pole_curvature(aspect: float):
    """R = aspect^2 times the half height; the default tolerance."""
    curve = press(Material(1000.0, 0.3), aspect=aspect, max_overlap=1e-5)
    assert over_hertz(curve) == pytest.approx(1.0, abs=0.01)
    assert curve.contact_radius is not None
    assert curve.contact_radius[-1] == pytest.approx(aspect * math.sqrt(1e-5), rel=0.02)


# first yield


@compiled_only
@pytest.mark.parametrize("nu", list(PRESSURE_AT_YIELD))
def test_first_yield_of_a_stiff_sphere(nu: float):
    """3 % of overlap is 1.5 % of pressure, what the stress at the Gauss points next to the peak and the pressure's own error add up to."""
    material = Material(1000.0, nu, 1.0)
    found = small_run(material, 1.0, moduli_of(material))
    assert found is not None
    assert found.overlap == pytest.approx(first_yield_of_a_paraboloid(material), rel=0.03)
    if nu == 0.3:
        depth, contact_radius = 1.0 - found.place[1], math.sqrt(found.overlap)
        # on the axis 0.48 a below the surface, to a Gauss point of an element of a/8 in a field that is flat at its maximum
        assert found.place[0] < 0.1 * contact_radius
        assert depth / contact_radius == pytest.approx(0.48, abs=0.08)


@compiled_only
def test_first_yield_within_a_run_that_resolves_it():
    """The same from the main run, of a spheroid too."""
    for aspect in (1.0, 2.0):
        material = Material(1000.0, 0.3, 1.0)
        curve = press(material, aspect=aspect, max_overlap=10.0 * first_yield_of_a_paraboloid(material, aspect))
        assert curve.yield_overlap == pytest.approx(first_yield_of_a_paraboloid(material, aspect), rel=0.03)


# one curve, looked at from all sides


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fields")


@pytest.fixture(scope="module")
def plastic(folder: Path) -> Curve:
    return press(Material(100.0, 0.3, 1.0), unload_from=(0.1, 0.02), fields=folder)


@pytest.fixture(scope="module")
def elastic(folder: Path) -> Curve:
    return press(Material(100.0, 0.3), unload_from=(0.05,), fields=folder)


@compiled_only
def test_branches_leave_the_loading_and_end_apart(plastic: Curve, elastic: Curve):
    for curve, overlaps in ((plastic, (0.02, 0.1)), (elastic, (0.05,))):
        assert curve.stopped is None
        assert list(curve.unloadings) == list(range(1, len(overlaps) + 1))
        loading = curve.rows(0)
        columns = (curve.force, curve.contact_radius, curve.stored_energy, curve.dissipated_energy)
        for k, overlap in zip(curve.unloadings, overlaps, strict=True):
            rows = curve.rows(k)
            assert curve.overlap[rows][0] == pytest.approx(overlap, rel=1e-12)
            origin = np.flatnonzero(curve.overlap[loading] == curve.overlap[rows][0])
            assert origin.size == 1
            for column in columns:
                assert column is not None
                assert column[rows][0] == pytest.approx(column[loading][origin[0]], rel=1e-14)  # round-off
            assert curve.force[rows][-1] == 0.0
            assert curve.contact_radius is not None
            assert curve.contact_radius[rows][-1] == 0.0
            assert (np.diff(curve.overlap[rows]) < 0.0).all()
            assert (np.diff(curve.force[rows]) < 0.0).all()
            assert (np.diff(curve.contact_radius[rows]) <= 0.0).all()
        assert curve.overlap[loading][-1] == pytest.approx(overlaps[-1], rel=1e-12)
        assert (np.diff(curve.force[loading]) > 0.0).all()
        assert (np.diff(curve.time) > 0.0).all() or (np.diff(curve.time)[np.diff(curve.branch) == 0] > 0.0).all()


@compiled_only
def test_energies_along_the_curve(plastic: Curve, elastic: Curve):
    for curve in (plastic, elastic):
        assert curve.stored_energy is not None
        assert curve.dissipated_energy is not None
        loading = curve.rows(0)
        total = curve.stored_energy + curve.dissipated_energy
        work = np.concatenate(
            [[0.0], np.cumsum(0.5 * np.diff(curve.overlap[loading]) * (curve.force[loading][1:] + curve.force[loading][:-1]))]
        )
        # trapezia between rows a tenth apart in overlap
        assert work[-1] == pytest.approx(total[loading][-1], rel=0.01)
        assert (np.diff(curve.dissipated_energy[loading]) >= 0.0).all()
        for k in curve.unloadings:
            rows = curve.rows(k)
            assert (np.diff(curve.dissipated_energy[rows]) >= -1e-12 * total.max()).all()
            assert 0.0 < total[rows][-1] / total[rows][0] < 1.0 or curve is elastic
            recovered = -np.trapezoid(curve.force[rows], curve.overlap[rows])
            assert total[rows][0] - total[rows][-1] == pytest.approx(recovered, rel=0.01)  # the same
        assert abs(curve.provenance["balance"]) < 0.005


@compiled_only
def test_elastic_curve_dissipates_nothing_and_returns(elastic: Curve):
    assert elastic.dissipated_energy is not None
    assert elastic.stored_energy is not None
    assert elastic.yield_overlap is None
    np.testing.assert_array_equal(elastic.dissipated_energy, 0.0)
    rows = elastic.rows(1)
    assert elastic.overlap[rows][-1] == pytest.approx(0.0, abs=RESIDUAL * elastic.overlap.max())
    # the way back is the way in; where the contact is resolved the rows between are interpolated, to less than 1e-3 of the largest force
    loaded = elastic.rows(0)
    resolved = elastic.overlap[rows] >= elastic.overlap[loaded][1]
    into = CubicSpline(elastic.overlap[loaded], elastic.force[loaded])(elastic.overlap[rows][resolved])
    np.testing.assert_allclose(elastic.force[rows][resolved], into, rtol=0, atol=1e-3 * elastic.force.max())
    # and what was stored comes back: work by Simpson's rule over rows of 1/25 of the way, to 1e-4 where the force goes as d^3/2
    assert elastic.stored_energy[rows][-1] == 0.0
    back = -simpson(elastic.force[rows], x=elastic.overlap[rows])
    assert back == pytest.approx(elastic.stored_energy[rows][0], rel=2e-3)


@compiled_only
def test_unloading_changes_smoothly_over_first_yield():
    """Before it a body gives all back; just beyond, points that have hardly yielded cost hardly anything."""
    material = Material(5.0, 0.3, 1.0)
    first = press(material, max_overlap=0.15).yield_overlap
    assert first is not None
    curve = press(material, unload_from=(0.8 * first, 0.95 * first, 1.05 * first, 1.2 * first))
    assert curve.dissipated_energy is not None
    assert curve.stored_energy is not None
    rows = [curve.rows(k) for k in curve.unloadings]
    recovered = np.array([1.0 - curve.overlap[r][-1] / curve.overlap[r][0] for r in rows])
    exponents = np.array([exponent(curve.overlap[r], curve.force[r]) for r in rows])
    lost = np.array([curve.dissipated_energy[r][-1] / curve.stored_energy[r][0] for r in rows])
    np.testing.assert_array_equal(recovered[:2], 1.0)
    np.testing.assert_array_equal(lost[:2], 0.0)
    # plastic work grows at least as the square of the distance from first yield: (1.2 - 1)^2 and more of what is stored
    assert np.all(lost[2:] >= 0.0)
    assert lost[2] < 0.05**2
    assert lost[3] < 0.2**2
    # what the default tolerance leaves of an exponent is .5 %, of what is recovered the same
    assert abs(recovered[2] - 1.0) < 0.005
    assert abs(exponents[2] / exponents[1] - 1.0) < 0.01


@compiled_only
def test_raw_force_is_the_smooth_one_with_ripples(plastic: Curve):
    """Landing nodes make the raw force a sawtooth of a few per cent, biased by the mesh's own error."""
    assert plastic.raw_force is not None
    rows = plastic.rows(0)
    ratio = plastic.raw_force[rows][3:] / plastic.force[rows][3:]
    assert abs(ratio.mean() - 1.0) < 0.03
    assert 0.0 < ratio.std() < 0.05


@compiled_only
def test_error_estimates_are_named_and_positive(plastic: Curve, elastic: Curve):
    for curve in (plastic, elastic):
        assert set(curve.errors) == {"force", "contact_radius", "unloading_stiffness", "unloading_exponent", "recovered_energy"}
        assert all(0.0 < value < 0.2 for value in curve.errors.values())
    assert set(press(Material(100.0, 0.3), max_overlap=0.01).errors) == {"force", "contact_radius"}


@compiled_only
def test_provenance_says_how_it_was_made(plastic: Curve):
    assert {"code", "mesh", "elements", "resolution", "statistics", "balance", "cpu_seconds"} <= set(plastic.provenance)
    assert plastic.provenance["statistics"]["fine"]["steps"] > 50


@compiled_only
def test_units_do_not_matter():
    """A 5 um NMC sphere in SI and the dimensionless problem of the same E/Y and nu: one curve, to the solver's round-off."""
    real = press(Material(142e9, 0.25, 7.9e9), radius=5e-6, unload_from=(0.03,))
    plain = press(Material(142.0 / 7.9, 0.25, 1.0), unload_from=(0.03,))
    length, stress = 5e-6, 7.9e9
    for name, unit in (
        ("overlap", length),
        ("contact_radius", length),
        ("force", stress * length**2),
        ("raw_force", stress * length**2),
        ("stored_energy", stress * length**3),
        ("dissipated_energy", stress * length**3),
    ):
        one, two = getattr(real, name) / unit, getattr(plain, name)
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-10 * np.abs(two).max(), err_msg=name)
    assert real.yield_overlap == pytest.approx(plain.yield_overlap * length, rel=1e-10)


# fields


def carried(radius: FloatArray, pressure: FloatArray) -> float:
    """Force of a pressure that is linear between surface nodes: 2 pi r p dr over each piece, exactly."""
    r, p = radius, pressure
    return float((2.0 * np.pi * np.diff(r) * (r[:-1] * (p[:-1] / 3.0 + p[1:] / 6.0) + r[1:] * (p[:-1] / 6.0 + p[1:] / 3.0))).sum())


@compiled_only
def test_contact_pressure_carries_the_force_of_its_state():
    body = discretise(spheroid(4, 0.1))
    solver = Equilibrium(body, moduli_of(Material(50.0, 0.3, 1.0)))
    path = islice(landings(solver, Steps()), 12)
    state = [states[-1] for _, states in path][-1]
    surface = body.section.surface
    radius = body.section.mesh.p[0, surface] + state.displacement[surface, 0]
    # the residual, summed over the nodes
    assert carried(radius, contact_pressure(body, state)) == pytest.approx(state.force, rel=RESIDUAL * np.sqrt(radius.size))


@compiled_only
def test_fields_open_and_carry_the_force(plastic: Curve, elastic: Curve, folder: Path):
    assert plastic.raw_force is not None
    for k, overlap in ((1, 0.02), (2, 0.1)):
        mesh = meshio.read(folder / f"loading_D{overlap:.4f}.vtu")
        assert mesh.cells[0].type == "quad"
        pressure, radius = mesh.point_data["contact_pressure"], mesh.points[:, 0]
        r0, z0 = mesh.point_data["undeformed"][:, :2].T
        surface = np.flatnonzero(np.abs(np.hypot(r0, z0) - 1.0) < 1e-12)
        surface = surface[np.argsort(r0[surface])]
        np.testing.assert_array_equal(pressure[np.setdiff1d(np.arange(pressure.size), surface)], 0.0)
        # the very state at this overlap: its force carries the ripple of landing nodes, 2 to 3 % on this mesh, which the curve does not
        p = pressure[surface]
        assert carried(radius[surface], p) == pytest.approx(plastic.force[plastic.rows(k)][0], rel=0.04)
        # in contact the body ends at the flat
        assert np.ptp(mesh.points[surface[p > 0.0], 1]) < 1e-9
        # mean of points within yield is within yield
        assert mesh.cell_data["von_mises"][0].max() <= 1.0 + 1e-9
        strain = mesh.cell_data["equivalent_plastic_strain"][0]
        assert strain.min() >= 0.0
        assert strain.max() > 0.01
        apart = meshio.read(folder / f"unloaded_D{overlap:.4f}.vtu")
        np.testing.assert_array_equal(apart.point_data["contact_pressure"], 0.0)
        assert apart.cell_data["equivalent_plastic_strain"][0].max() >= strain.max()
    pressed = meshio.read(folder / "loading_D0.0500.vtu")
    np.testing.assert_array_equal(pressed.cell_data["equivalent_plastic_strain"][0], 0.0)
    free = meshio.read(folder / "unloaded_D0.0500.vtu")
    assert (
        np.abs(free.cell_data["stress"][0]).max() < 1e-6 * np.abs(pressed.cell_data["stress"][0]).max()
    )  # the residual over a small element


# bad input


@pytest.mark.parametrize(
    ("changes", "messages"),
    [
        ({"material": Material(-1.0, 0.5, 0.0)}, ["youngs_modulus", "poissons_ratio", "yield_stress"]),
        ({"radius": 0.0, "aspect": math.nan}, ["radius = 0.0: must be a positive length", "aspect = nan"]),
        ({"unload_from": (0.1, 1.2, math.nan)}, ["unload_from = 1.2: overlap over radius must lie in", "unload_from = nan"]),
        ({"max_overlap": -0.1, "aspect": 20.0}, ["max_overlap = -0.1", "aspect = 20.0: must lie between 0.1 and 10"]),
        ({"max_overlap": None}, ["nothing to do without an overlap"]),
        ({"tolerance": 1e-6}, ["tolerance = 1e-06: the finest on offer is"]),
        ({"tolerance": math.nan}, ["tolerance = nan"]),
    ],
)
def test_bad_input_is_named_with_bound_and_remedy(changes: dict[str, object], messages: list[str]):
    arguments: dict[str, object] = {"material": Material(100.0, 0.3, 1.0), "max_overlap": 0.1, **changes}
    material = arguments.pop("material")
    with pytest.raises(InputError) as caught:
        press(material, **arguments)  # type: ignore[arg-type]
    for message in messages:
        assert message in str(caught.value)


def test_resolutions_get_finer_with_the_tolerance():
    tolerances = [tolerance for tolerance, _ in RESOLUTIONS]
    assert tolerances == sorted(tolerances, reverse=True)
    divisions = [resolution_for(tolerance).divisions for tolerance in (0.05, *tolerances)]
    assert divisions == sorted(divisions)
    assert all(n % 2 == 0 for n in divisions)


# what stands in the way of a run


@compiled_only
def test_a_nearly_incompressible_body_is_pressed():
    """Its round-off is that of the bulk modulus, 1700 times Young's; Hertz within .6 % (finite size at this overlap: .3 %)."""
    curve = press(Material(1000.0, 0.4999), max_overlap=1e-4)
    assert curve.stopped is None
    assert over_hertz(curve) == pytest.approx(1.0, abs=0.006)


@compiled_only
def test_an_unloading_that_fails_does_not_end_the_loading(monkeypatch: pytest.MonkeyPatch):
    """The solver gives up wherever an unloading starts beyond .01 R: the rest of the curve is as if nobody had asked for it."""
    plain = press(Material(50.0, 0.3, 1.0), unload_from=(0.005,), max_overlap=0.02)

    def stubborn(solver, start, steps, smallest=0.004):  # type: ignore[no-untyped-def]
        if start.overlap > 0.01:
            raise NoEquilibrium("for a test")
        return unload(solver, start, steps, smallest)

    monkeypatch.setattr("fem.branch.unload", stubborn)
    curve = press(Material(50.0, 0.3, 1.0), unload_from=(0.005, 0.015), max_overlap=0.02)
    assert len(curve.unloadings) == 1
    assert curve.stopped is not None
    assert "0.015" in curve.stopped
    assert curve.overlap[curve.rows(0)][-1] == 0.02
    assert curve.force[curve.rows(0)][-1] == pytest.approx(plain.force[plain.rows(0)][-1], rel=1e-9)  # another row changes round-off only


@compiled_only
def test_the_curve_ends_where_the_mesh_does():
    """With one element of free surface left, the next node lands close to an overlap of 1 only, with a work beyond all bounds."""
    body, moduli = discretise(spheroid(6, 0.142, along=1.5)), moduli_of(Material(100.0, 0.3, 1.0))
    run = walk(body, moduli, 0.95)
    work = run.landing_stored + run.landing_dissipated
    assert run.stopped is not None
    assert "mesh ends" in run.stopped or "no equilibrium" in run.stopped
    assert run.landing_overlap[-1] < 0.95
    rise = np.diff(np.log(work)) / np.diff(np.log(run.landing_overlap))
    assert rise.max() < 6.0  # F d/W: 2 in full plasticity, growing towards the end; that landing would make it 35


@compiled_only
def test_the_contact_never_grows_while_it_is_let_go():
    """Also of unloadings that are carried from those that were computed, at many overlaps."""
    curve = press(Material(100.0, 0.3, 1.0), unload_from=(0.01, 0.05, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5))
    assert curve.contact_radius is not None
    for branch in curve.unloadings:
        radius = curve.contact_radius[curve.rows(branch)]
        assert (np.diff(radius) <= 1e-12).all()
        assert radius[-1] == 0.0
