"""`fe2dem ellipsoid` as a user types it."""

import numpy as np
import pytest

from cases.command import execute
from contactlaws.ellipsoid_contact import on_flat
from contactlaws.material import Material

NMC = ["--youngs-modulus", "142 GPa", "--poissons-ratio", "0.25", "--yield-stress", "7.9 GPa"]


def test_it_writes_the_curve_of_the_law_in_si_units(tmp_path, capsys):
    out = tmp_path / "curve.csv"
    assert execute(["ellipsoid", *NMC, "--axes", "5 um", "6 um", "4 um", "--unload-from", "0.05", "0.1", "--out", str(out)]) == 0
    assert "residual overlap" in " ".join(capsys.readouterr().out.split())
    branch, overlap, force, long, short = np.loadtxt(out, delimiter=",", comments=("#", "b")).T
    assert set(branch) == {0.0, 1.0, 2.0}
    contact = on_flat(Material(142e9, 0.25, 7.9e9), (5e-6, 6e-6, 4e-6))
    assert overlap.max() == pytest.approx(0.1 * contact.mean_radius, rel=1e-8)
    loading = branch == 0.0
    assert force[loading] == pytest.approx(contact.along(overlap[loading]).force, rel=1e-6, abs=1e-12)  # nine digits are written
    assert (long >= short).all()
    for number in (1.0, 2.0):
        assert force[branch == number][-1] == 0.0
        assert overlap[branch == number][-1] > 0.0


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (["--axes", "5 um", "6 um"], "axes[2]"),
        (["--axes", "5 um", "6 um", "-1 um"], "axes[2]"),
        (["--axes", "5 um", "6 um", "4 um", "--unload-from", "0.4"], "0.2"),
        (["--axes", "5 um", "6 um", "4 GPa"], "GPa"),
        (["--axes", "5 um", "51 um", "5 um"], "--axes"),
        (["--axes", "5 um", "6 um", "4 um", "--other-axes", "20 um", "1 um", "1 um"], "--other-axes"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_written(wrong, said, tmp_path, capsys):
    out = tmp_path / "curve.csv"
    assert execute(["ellipsoid", *NMC, *wrong, "--out", str(out)]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()


def test_a_body_blunter_than_the_law_was_fitted_to_is_told(tmp_path, capsys):
    """Hertz's law, of a body that does not yield, is for any."""
    flat = ["--axes", "2 um", "5 um", "5 um", "--out", str(tmp_path / "curve.csv")]
    for options, told in ((NMC, True), ([*NMC[:4], "--elastic"], False)):
        assert execute(["ellipsoid", *options, *flat]) == 0
        assert ("spheroid 1 : 2.5; the law is fitted from 1 : 0.5 to 1 : 2" in " ".join(capsys.readouterr().out.split())) == told
