"""A frame of beams with several floating frames that snaps through, past two limit points, against published ones."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing import build, save
from tests.frames.test_cut_bodies import agree

FRAME = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = { A = [0.0, 0.0], B = [0.0, 120.0], P = [24.0, 120.0], C = [120.0, 120.0] }
interface_points = { A = { node = "A" }, P = { node = "P" }, C = { node = "C" } }
beams = [
    { from = "A", to = "B", section = "s", elements = 10 },
    { from = "B", to = "P", section = "s", elements = 2 },
    { from = "P", to = "C", section = "s", elements = 8 },
]
sections.s = { kind = "rectangle", thickness = 2.0, width = 3.0, material = "m" }
materials.m = { youngs_modulus = 720.0, density = 1.0 }
"""
SCENE = """units = "m-kg-s"
[points]
A = { body = "lee", interface = "A" }
P = { body = "lee", interface = "P" }
C = { body = "lee", interface = "C" }
[bodies]
lee = { type = "flexible", model = "lee.h5", frames = FRAMES }
[joints]
A = { type = "revolute", bodies = ["lee", "ground"], point = "A" }
C = { type = "revolute", bodies = ["lee", "ground"], point = "C" }
[loads]
down = { type = "point-force", body = "lee", point = "P", force = [0.0, -20.0] }
[design]
F = "loads.down.force.y"
t = "bodies.lee.thickness_s"
[responses]
x = { type = "displacement", body = "lee", point = "P", component = "x" }
y = { type = "displacement", body = "lee", point = "P", component = "y" }
[solver]
continuation = "arc-length"
"""
UNIT = 720.0 * 2.0 / 120.0**2
"""E I / L^2."""
LEE, RETURN = 18.552, -9.47
"""Loads at which the path turns back, in this unit: Lee, Manuel and Rossow, ASCE J. Engineering Mechanics 94 (1968); the second one is read
from the curve of Simo and Vu-Quoc, Computer Methods in Applied Mechanics and Engineering 58 (1986), to half a percent."""


def test_a_frame_of_beams_snaps_through_as_published(tmp_path):
    """Lee's frame. Limit loads of 10 and 20 parts converge with the square of the number, and gradients beyond are complex steps."""
    (tmp_path / "frame.toml").write_text(FRAME)
    save(build(tmp_path / "frame.toml"), tmp_path / "lee.h5")
    found, models = [], []
    for frames in (10, 20):
        (tmp_path / "scene.toml").write_text(SCENE.replace("FRAMES", str(frames)))
        models.append(ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml"), variables=["F", "t"]))
        path = models[-1].statics().solution.path
        found.append(np.array([20 / UNIT * each.load_factor for each in path.limit_points]))
    coarse, fine = found
    limit = fine + (fine - coarse) / 3
    assert limit[0] == pytest.approx(LEE, rel=2e-3)  # theirs does not stretch
    assert limit[1] == pytest.approx(RETURN, rel=1e-2)
    assert abs(fine[0] - LEE) < 1e-2 * LEE
    agree(models[0], "statics")
