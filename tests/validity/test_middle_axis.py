"""A free spin about the middle axis: told that round-off decides, where it does, with the growth of Euler's equations."""

from __future__ import annotations

import re

import numpy as np
import pytest

import ffrf
from ffrf import space
from toolkit.description.design import Point
from toolkit.responses.energy import KineticEnergy


def verdict(spin, end: float = 10.0):
    """Of a body with the principal moments 1, 2 and 3."""
    scene = ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points={"C": Point(x=0.0, y=0.0, z=0.0)},
        bodies={"block": space.Rigid(mass=1.0, inertia=(1.0, 2.0, 3.0), center="C", angular_velocity=spin)},
        responses={"energy": KineticEnergy()},
        solver=ffrf.RunOptions(end_time=end, step=0.02),
    )
    return ffrf.compile(scene).simulate().verdict


def test_a_spin_that_round_off_turns_over_is_doubted_with_its_growth():
    (text,) = [each.text for each in verdict((0.0, 3.0, 1e-12)).warnings if each.code == "middle-axis"]
    grown = float(re.search(r"grows ([\d.e+]+) times", text)[1])
    assert np.log(grown) == pytest.approx(3.0 * 10.0 / np.sqrt(3), rel=0.02)  # (I2 - I1) (I3 - I2) / (I1 I3) = 1/3


@pytest.mark.parametrize("spin", [(0.0, 3.0, 0.01), (0.0, 0.0, 3.0), (3.0, 1e-12, 0.0), (0.0, 0.1, 0.0)])
def test_spins_that_are_meant_or_stable_or_slow_are_silent(spin):
    assert "middle-axis" not in verdict(spin).codes
