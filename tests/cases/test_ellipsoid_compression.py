"""The case of compressed beds, small: books, laws, and that ellipsoids begin to bear later than spheres of the same fraction."""

from __future__ import annotations

import pytest

from cases.becker_kamlah_2021.compression import LAWS, compressed


@pytest.mark.compiled_only(reason="thousands of steps of interpreted kernels")
@pytest.mark.parametrize("law", sorted(LAWS))
def test_beds_keep_their_books(law: str) -> None:
    """Energy to 1e-4 (the step is .4 of the critical one); stored, dissipated and dragged energy of the ellipsoids never negative."""
    found = compressed(law, strain=0.04, seed=1, count=40)
    for bed in found.values():
        assert bed.balance < 1e-4
        energy, scale = bed.stages.energies, bed.stages.energies.boundary_work.max()
        for term in (energy.stored, energy.dissipated, energy.damped):
            assert term.min() >= -1e-6 * scale
        assert 0.0 <= bed.returned <= 1.0
    spheres, loose, dense = found.values()
    assert loose.stress < spheres.stress
    assert dense.contacts > spheres.contacts
