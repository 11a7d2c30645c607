"""Effective moduli of a lattice against its stress, differentiated by hand; contacts in files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from dem.measure import force_distribution
from dem.output import write_network
from dem.packing import Packing, face_centred_cubic
from dem.probes import moduli

RADIUS, DENSITY = 5e-6, 4750.0


@pytest.mark.compiled_only(reason="thirteen searches for rest, each of hundreds of iterations")
def test_moduli_of_a_face_centred_lattice(hertz: Hertz) -> None:
    """Springs k = 2 E* sqrt(R d) of the pair along 110: C11 = 2 C12 = 2 C44 = sqrt(2) k/(2 R) but for the prestress, of relative size e."""
    strain = 1e-4
    lattice = face_centred_cubic((2, 2, 2), RADIUS)
    bodies = dem.spheres(lattice.position * (1.0 - strain), RADIUS, DENSITY)
    scene = dem.Scene(bodies, lattice.box.stretched((1.0 - strain,) * 3), dem.Contact(hertz), (dem.isotropic_compression(1e-3),))
    found = moduli(scene)
    spring = hertz.reduced_modulus * np.sqrt(0.5 * RADIUS * 2.0 * RADIUS * strain)  # 2 (E*/2) sqrt(R/2 d)
    expected = np.sqrt(2.0) * spring / (2.0 * RADIUS)
    cubic = np.array([[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]])
    np.testing.assert_allclose(found[:3, :3], 0.5 * expected * cubic, rtol=0.0, atol=3e-3 * expected)
    np.testing.assert_allclose(np.diag(found)[3:], 0.5 * expected, rtol=3e-3)


def test_contacts_of_all_frames_go_to_a_file(hertz: Hertz, shaken_crystal: Packing, tmp_path: Path) -> None:
    scene = dem.packed_scene(shaken_crystal, DENSITY, dem.Contact(hertz), dem.uniaxial_compression(0.02), inertial_number=2e-2, outputs=4)
    trajectory = dem.run(scene)
    rows = np.genfromtxt(write_network(trajectory, tmp_path / "contacts.csv"), delimiter=",", names=True)
    assert len(rows) == sum(len(frame.network.first) for frame in trajectory.frames)
    frame = max(trajectory.frames, key=lambda frame: len(frame.network.first))
    mine = rows[rows["output"] == frame.output]
    counted = np.bincount(np.concatenate([mine["id_1"], mine["id_2"]]).astype(int), minlength=33)[1:]
    np.testing.assert_array_equal(counted, frame.contacts)
    stress = np.einsum("ia,ib->ab", frame.network.branch, frame.network.force) / frame.box.volume
    kinetic = 2.0 / 3.0 * trajectory.energies.kinetic[frame.output] / frame.box.volume
    assert np.trace(stress) / 3.0 == pytest.approx(trajectory.pressure[frame.output] - kinetic, rel=1e-9)
    edges = np.linspace(0.0, 20.0, 50)
    assert float(np.sum(force_distribution(frame.network, edges) * np.diff(edges))) == pytest.approx(1.0)
