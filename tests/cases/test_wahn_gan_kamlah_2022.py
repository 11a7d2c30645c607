"""The two spheres of Wahn, Gan & Kamlah: every number, and the laws against the continuum within what the page says."""

from __future__ import annotations

import pytest

from cases.wahn_gan_kamlah_2022 import accuracy, gap
from cases.wahn_gan_kamlah_2022.accuracy import OURS, PLAIN, RIVAL, Compared
from cases.wahn_gan_kamlah_2022.material import PUBLISHED
from cases.wahn_gan_kamlah_2022.numbers import Number, numbers

slow_interpreted = pytest.mark.compiled_only(reason="finite elements, and laws in thousands of steps")


@slow_interpreted
@pytest.mark.parametrize("number", list(numbers()), ids=lambda number: number.name)
def test_number(number: Number):
    assert number.ok, f"{number.value} in place of {number.expected}"


#: history, and what the largest error of our law over the largest force may be at .02 R and at .1 R; the curves' own is .1 %
BOUNDS = {0.02: 0.005, 0.1: 0.01}


@slow_interpreted
@pytest.mark.parametrize("depth", sorted(BOUNDS))
@pytest.mark.parametrize("material", sorted(accuracy.MATERIALS))
@pytest.mark.parametrize("history", ["ramp, hold, release", "release and meet again"])
def test_our_law_follows_the_continuum_where_the_old_one_does_not(material: str, depth: float, history: str):
    curve = accuracy.reference(accuracy.MATERIALS[material], depth, history, 0.01)
    laws = accuracy.laws(accuracy.MATERIALS[material])

    def compared(name: str) -> Compared:
        return accuracy.compare(name, laws[name], curve, material, depth, history)

    assert compared(OURS).worst <= BOUNDS[depth]
    assert compared(OURS).lowest >= 0.0
    assert compared(PLAIN).worst >= 0.05  # no finite size: 7 % at .02 R, 17 % at .1 R
    if RIVAL in laws:
        assert compared(RIVAL).lowest < -0.03  # the paper's increments pull


@slow_interpreted
def test_the_papers_gap_is_finite_size_less_a_modulus_too_small():
    """With the paper's own constants the slowest ramp of Fig. 12 is 5.5 % of the elements' force apart; the paper says 5.4 %."""
    law, slow = gap.law_force(1000.0), gap.end_force(PUBLISHED, 1000.0, tolerance=0.01)
    assert 1.0 - law / (slow * gap.ITS_SHEAR) == pytest.approx(gap.STATED, abs=0.003)
