"""Derivatives of a largest stress that occurs at two places: doubted where it jumps, with both numbers, against a closed form.

A beam clamped at both ends that carries F in its middle has the moment F L / 8 at both of them, so the stress s = 3 F L / (4 b t^2). The
thickness of one half moves the stress of one end more than that of the other; those of both together move each by -2 s / t.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

import ffrf
from preprocessing import build, save

FRAME = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = { A = [0.0, 0.0], M = [0.5, 0.0], B = [1.0, 0.0] }
beams = [ { from = "A", to = "M", section = "one", elements = 2 }, { from = "M", to = "B", section = "other", elements = 2 } ]
interface_points = { M = { node = "M" }, B = { node = "B" } }
sections.one = { kind = "rectangle", thickness = 0.02, width = 0.03, material = "m" }
sections.other = { kind = "rectangle", thickness = 0.02, width = 0.03, material = "m" }
materials.m = { youngs_modulus = 2e9, density = 1200.0 }
"""
SCENE = """units = "m-kg-s"
points.M = { body = "beam", interface = "M" }
points.B = { body = "beam", interface = "B" }
bodies.beam = { type = "flexible", model = "beam.h5", frame = "grounded", thickness_other = THICKNESS }
joints.end = { type = "rigid", bodies = ["beam", "ground"], point = "B" }
loads.push = { type = "point-force", body = "beam", point = "M", force = [0.0, 2.0] }
design = { one = "bodies.beam.thickness_one", other = "bodies.beam.thickness_other", force = "loads.push.force.y" }
responses.stress = { type = "max-stress", body = "beam", measure = "absolute" }
solver = { end_time = 0.1, step = 0.01, quasi_static = true }
"""
STRESS = 3 * 2.0 * 1.0 / (4 * 0.03 * 0.02**2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the beam."""
    found = tmp_path_factory.mktemp("tied")
    (found / "beam.toml").write_text(FRAME)
    save(build(found / "beam.toml"), found / "beam.h5")
    return found


def run(folder, thickness: float, analysis: str) -> ffrf.Run:
    """With gradients, for a thickness of the other half."""
    (folder / "scene.toml").write_text(SCENE.replace("THICKNESS", str(thickness)))
    model = ffrf.compile(ffrf.read_scene(folder / "scene.toml"), variables=["one", "other", "force"])
    return model.statics(gradients=True) if analysis == "statics" else model.simulate(gradients=True)


@pytest.mark.parametrize("analysis", ["statics", "motion"])
def test_a_stress_that_is_the_same_at_two_ends_is_doubted_with_both_derivatives(folder, analysis):
    found = run(folder, 0.02, analysis)
    told = [each.text for each in found.verdict.warnings if each.code == "tied-extreme"]
    assert found.values["stress"] == pytest.approx(STRESS, rel=1e-9)
    assert len(told) == 2  # not by the force, which moves both alike
    by = np.array([re.findall(r"(-?\d[\d.e+]*) by the", each) for each in told], float)  # (thickness, place)
    assert by.sum(axis=0) == pytest.approx([-2 * STRESS / 0.02] * 2, rel=1e-3)
    assert np.ptp(by[0]) > STRESS / 0.02


@pytest.mark.parametrize("thickness", [0.0199, 0.0201])
def test_a_stress_that_is_larger_at_one_end_is_no_doubt(folder, thickness):
    assert all(each.code != "tied-extreme" or not each.doubt for each in run(folder, thickness, "statics").verdict.warnings)


@pytest.mark.parametrize(("thickness", "remarks"), [(0.02004, True), (0.0204, False)])
def test_a_stress_that_is_hardly_larger_at_one_end_is_a_remark(folder, thickness, remarks):
    """The moments at the ends are to each other as the compliances of the halves, about: 2 % of thickness are more than 1 % of stress."""
    found = run(folder, thickness, "statics")
    told = [each for each in found.verdict.warnings if each.code == "tied-extreme"]
    assert bool(told) is remarks
    assert not any(each.doubt for each in told)
