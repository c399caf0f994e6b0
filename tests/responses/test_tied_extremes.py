"""Derivatives of largest values that occur twice: doubted where they jump, silent where one peak is higher or both have one derivative."""

from __future__ import annotations

import re

import numpy as np
import pytest

import ffrf
from preprocessing import build, save
from toolkit.responses.extremes import tied_peaks

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


BAR = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = { A = [0.0, 0.0], B = [1.0, 0.0] }
beams = [ { from = "A", to = "B", section = "s", elements = 4 } ]
interface_points = { B = { node = "B" } }
sections.s = { kind = "rectangle", thickness = 0.01, width = 0.05, material = "m" }
materials.m = { youngs_modulus = 7e10, density = 2700.0 }
"""
PULLED = """units = "m-kg-s"
points.B = { body = "bar", interface = "B" }
bodies.bar = { type = "flexible", model = "bar.h5", frame = "grounded" }
loads.F = { type = "point-force", body = "bar", point = "B", force = [ALONG, ACROSS] }
design.along = "loads.F.force.x"
design.across = "loads.F.force.y"
responses.most = { type = "max-stress", body = "bar", measure = "MEASURE" }
"""
SECTION, MODULUS = 0.01 * 0.05, 0.05 * 0.01**2 / 6


@pytest.mark.parametrize(
    ("along", "across", "measure", "told"),
    [
        (0.0, 5.0, "absolute", {}),  # a newton changes it by less than a thousandth
        (0.0, 0.005, "absolute", {"along": True}),
        (0.0, 5.0, "signed", {}),
        (1.0, 5.0, "absolute", {}),
        (50.0, 0.0, "signed", {"across": True}),
    ],
)
def test_a_largest_stress_on_both_sides_of_a_bar_has_no_derivative_by_what_raises_one_of_them(
    tmp_path, along, across, measure, told
):
    """|F| L / W +- N / A: a doubt where a newton counts; on both sides the derivative by what bends is one."""
    (tmp_path / "bar.toml").write_text(BAR)
    save(build(tmp_path / "bar.toml"), tmp_path / "bar.h5")
    text = PULLED.replace("ALONG", repr(along)).replace("ACROSS", repr(across)).replace("MEASURE", measure)
    (tmp_path / "scene.toml").write_text(text)
    run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml"), variables=["along", "across"]).statics(gradients=True)
    assert run.values["most"] == pytest.approx(across / MODULUS + along / SECTION, rel=1e-6)
    found = [each for each in run.verdict.warnings if each.code == "tied-extreme"]
    assert {each.text.split(" by ")[1].split()[0]: each.doubt for each in found} == told
    for each in found:
        slope = 1 / SECTION if "along" in told else 1 / MODULUS
        low, high = sorted(map(float, re.findall(r"(-?[\d.e+]+) by the", each.text)))
        assert (low, high) == pytest.approx((-slope, slope), rel=1e-3)
