"""The verification of the viscoelastic solver: each part's machinery runs, and its cheapest claims hold; the whole is run by hand."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from cases.verification import viscoelastic
from cases.verification.continuum import Check, at_most
from contactlaws.curve import Curve
from contactlaws.prony import Relaxation
from fem.programme import ramp_hold_release

pytestmark = pytest.mark.compiled_only("presses bodies")


def fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    """One depth and one material, to a coarse tolerance."""
    monkeypatch.setattr(viscoelastic, "DEPTHS", (0.02,))
    monkeypatch.setattr(viscoelastic, "MATERIALS", {"nu constant": viscoelastic.TOGETHER})


@pytest.mark.parametrize(("part", "checks"), [("limits", 2), ("order", 1)])
def test_a_part_as_it_is(monkeypatch: pytest.MonkeyPatch, part: str, checks: int):
    fewer(monkeypatch)
    found = list(viscoelastic.PARTS[part]())
    assert len(found) == checks
    assert all(check.ok for check in found), found


@pytest.mark.parametrize("part", ["lee_radok", "ting", "meshes"])
def test_the_first_claim_of_a_part(monkeypatch: pytest.MonkeyPatch, part: str):
    fewer(monkeypatch)
    first = next(viscoelastic.PARTS[part]())
    assert first.ok, first


def test_turning_in_the_limit_of_a_small_overlap():
    """Where nothing turns, first and second Piola-Kirchhoff stresses remember the same."""
    ours, with_body = viscoelastic.turned_force(viscoelastic.PVDF, viscoelastic.NU, 1e-4, steps=6, divisions=6)
    assert with_body == pytest.approx(ours, rel=1e-3)  # strains are of the order of the root of the overlap; the part that lags is small


def test_the_integral_of_a_power_law():
    """Lee & Radok of Hertz's force under a ramp that is held: by quadrature of rows, and by a fine sum of it."""
    overlap = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 30)])
    hertz = Curve(overlap, 0.1 * overlap, overlap**1.5, np.zeros(31, np.int64), radius=1.0)
    modulus = Relaxation(7.0, (0.2, 0.3), (0.1, 5.0))
    s = (np.arange(200000) + 0.5) / 200000
    for time in (0.5, 1.0, 3.0):
        share = s * min(time, 1.0)
        psi = modulus.at(time - share) / modulus.instantaneous
        expected = float((psi * 1.5 * np.sqrt(share)).mean()) * min(time, 1.0)
        assert viscoelastic.hereditary(hertz, modulus, time, 0.1) == pytest.approx(expected, rel=1e-5)  # of the quadrature


def test_mesh_and_springs_are_given_in_the_same_rows():
    programme = ramp_hold_release(0.02, 1.0, 1.0)
    run, springs = viscoelastic.on_mesh(viscoelastic.TOGETHER, 0.02, programme, 8, 4)
    assert springs.shape == run.force.shape == (17,)
    np.testing.assert_allclose(run.force, springs, rtol=0, atol=1e-4 * springs.max())  # residuals, while the contact grows


def checks_of(*measured: float) -> Iterator[Check]:
    yield from (at_most("a claim", value, 1.0) for value in measured)


@pytest.mark.parametrize(("measured", "code", "word"), [((0.5,), 0, "ok"), ((0.5, 2.0), 1, "BROKEN")])
def test_the_exit_code_says_whether_a_claim_is_broken(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], measured: tuple[float, ...], code: int, word: str
):
    monkeypatch.setitem(viscoelastic.PARTS, "limits", lambda: checks_of(*measured))
    assert viscoelastic.main(["limits"]) == code
    assert word in capsys.readouterr().out


def test_a_part_that_is_not_there(capsys: pytest.CaptureFixture[str]):
    assert viscoelastic.main(["limit"]) == 2
    assert "no part limit; there are limits, lee_radok" in capsys.readouterr().err
