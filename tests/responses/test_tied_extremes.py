"""Derivatives of largest values that occur twice: doubted where they jump, silent where one peak is higher or both have one derivative."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from toolkit.responses.over_time.tied_extremes import tied_peaks

SCENE = """units = "m-kg-s"
points.C = [0.0, 0.0]
points.S = [-1.0, 0.0]
bodies.mass = { type = "rigid", mass = 1.0, inertia = 1.0, center = "C" }
joints.guide = { type = "slider", bodies = ["mass", "ground"], point = "C", axis = [1.0, 0.0], lock_rotation = true }
joints.lead = { type = "position-driver", bodies = ["mass", "ground"], point = "C", axis = [1.0, 0.0], curve = CURVE }
design.first = "joints.lead.curve.values.1"
responses.most = { type = "time-max", of = { type = "displacement", body = "mass", point = "C", component = "x" } }
solver = { end_time = 4.0, step = 0.02 }
"""


def codes(folder, second: float) -> tuple[str, ...]:
    """Of a block that is led to 1 at t = 1 and to `second` at t = 3."""
    curve = f'{{ type = "table", times = [0.0, 1.0, 2.0, 3.0, 4.0], values = [0.0, 1.0, 0.0, {second}, 0.0], interpolation = "monotone" }}'
    path = folder / "scene.toml"
    path.write_text(SCENE.replace("CURVE", curve))
    scene = ffrf.read_scene(path)
    return ffrf.compile(scene, variables=["first"]).simulate(gradients=True).verdict.codes


@pytest.mark.parametrize(("second", "tied"), [(1.0, True), (0.99, False), (1.01, False)])
def test_the_derivative_of_two_peaks_of_one_height_is_doubted(tmp_path, second, tied):
    """By the first value of the table it is 1 by the first peak, and 0 by the second."""
    assert ("tied-extreme" in codes(tmp_path, second)) is tied


def test_peaks_are_counted_once_each():
    assert tied_peaks(np.array([0.0, 1.0, 1.0, 0.5, 1.0, 0.2])).tolist() == [1, 4]
    assert tied_peaks(np.array([0.0, 1.0, 0.5])).tolist() == [1]
    assert tied_peaks(np.ones(4)).tolist() == [0]
