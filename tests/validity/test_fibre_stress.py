"""The shear of twisted beams in space, and bending between the fibres of round ones, are said where they count: by closed forms of bars."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing import build
from toolkit.reduced_model.file import save
from toolkit.validity.bodies.deformation import LIMIT

FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0.0, 0.0, 0.0], B = [0.0, 1.2, 0.0] }
beams = [{ from = "A", to = "B", section = "bar", elements = 4 }]
interface_points = { tip = { node = "B" } }
sections.bar = { SECTION, material = "steel" }
materials.steel = { youngs_modulus = 2e11, poisson_ratio = 0.3, density = 7850.0 }
"""
SCENE = """units = "m-kg-s"
dimension = 3
points = { T = { body = "bar", interface = "tip" } }
bodies = { bar = { type = "flexible", model = "bar.h5", frame = "grounded", frames = FRAMES } }
loads.push = { type = "point-force", body = "bar", point = "T", force = FORCE }
loads.turn = { type = "torque", body = "bar", point = "T", torque = TORQUE }
responses.stress = { type = "max-stress", body = "bar", measure = "absolute" }
"""
TUBE = 'kind = "tube", diameter = 0.05, wall = 0.004'
SECOND = np.pi / 64 * (0.05**4 - 0.042**4)
RECTANGLE = 'kind = "rectangle", thickness = 0.02, width = 0.04'
STRIP = 'kind = "rectangle", thickness = 0.002, width = 0.2'
MIDDLE = 0.02 * 0.04**2 * 0.02 / 0.04  # a b^2
PULL, BENT = 3e2 / (np.pi / 4 * (0.05**2 - 0.042**2)), 4.0 * 0.025 / SECOND
DIAGONAL = np.pi / 8
"""Between two of eight fibres."""
CASES = {
    "tube, twisted": (TUBE, (0, 0, 0), (0, 9, 0), np.sqrt(3) * 9 * 0.025 / (2 * SECOND), 0.0),
    "tube, twisted, bent and pulled": (
        TUBE, (0, 3e2, 0), (4, 9, 0), np.hypot(PULL + BENT, np.sqrt(3) * 9 * 0.025 / (2 * SECOND)), PULL + BENT,
    ),
    "tube, bent between its fibres": (
        TUBE, (0, 0, 0), (4 * np.cos(DIAGONAL), 0, 4 * np.sin(DIAGONAL)), BENT, BENT * np.cos(DIAGONAL),
    ),
    "circle, twisted": ('kind = "circle", diameter = 0.03', (0, 0, 0), (0, 9, 0), np.sqrt(3) * 16 * 9 / np.pi / 0.03**3, 0.0),
    "rectangle, twisted": (RECTANGLE, (0, 0, 0), (0, 9, 0), np.sqrt(3) * 9 / (0.246 * MIDDLE), 0.0),
    "strip, twisted": (
        STRIP, (0, 0, 0), (0, 9, 0), np.sqrt(3) * 9 * 3 / (0.2 * 0.002**2) / (1 - 0.0063), 0.0,
    ),
    "square, twisted": ('kind = "rectangle", thickness = 0.02, width = 0.02', (0, 0, 0), (0, 9, 0), np.sqrt(3) * 9 / (0.208 * 8e-6), 0.0),
}  # fmt: skip
"""Section, force, torque, von Mises' stress and that of the fibres; of rectangles by Timoshenko and Goodier's table (three digits), and by
the limit of thin ones, J = a b^3 / 3 (1 - 0.63 b / a)."""


GENERAL = 'kind = "general", area = 1e-3, I_y = 1e-7, I_z = 1e-7, J = 1e-7, I_p = 2e-7'


def run(folder, section, force, torque, frames=1, **changes):
    text = FRAME.replace("SECTION", section) + changes.get("basis", "")
    (folder / "bar.toml").write_text(text)
    save(build(folder / "bar.toml"), folder / "bar.h5")
    numbers = {"FORCE": list(map(float, force)), "TORQUE": list(map(float, torque)), "FRAMES": frames}
    scene = SCENE
    for name, value in numbers.items():
        scene = scene.replace(name, str(value))
    (folder / "scene.toml").write_text(scene)
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml")).statics()


def said(found):
    return [each for each in found.verdict.warnings if each.code == "fibre-stress"]


@pytest.mark.parametrize("name", CASES)
def test_what_fibres_lack_is_said_as_large_as_it_is(name, tmp_path):
    section, force, torque, whole, fibres = CASES[name]
    found = run(tmp_path, section, force, torque)
    assert found.values["stress"] == pytest.approx(fibres, rel=1e-6, abs=1e-6 * whole)
    (caution,) = said(found)
    told = float(caution.text.partition("von Mises' is ")[2].split()[0])
    assert told == pytest.approx(whole, rel=5e-3 if "rectangle" in section else 1e-3)  # digits of the table, and of the words
    assert caution.doubt
    assert not found.verdict.trusted


def test_a_cut_bar_says_the_same_and_little_twist_says_nothing(tmp_path):
    section, force, torque, _, fibres = CASES["tube, twisted, bent and pulled"]
    assert [each.text for each in said(run(tmp_path, section, force, torque, frames=2))] == [
        each.text for each in said(run(tmp_path, section, force, torque))
    ]
    twist = 0.9 * fibres * np.sqrt(1 / (1 - LIMIT) ** 2 - 1) * 2 * SECOND / 0.025 / np.sqrt(3)  # nine tenths of what counts
    assert not said(run(tmp_path, section, force, (torque[0], twist, 0)))


@pytest.mark.parametrize(
    ("section", "basis"),
    [
        (TUBE, 'basis = { kind = "craig-bampton", count = 2 }\n'),
        (f"{GENERAL}, fibres = [[0.0, 0.02], [0.01, 0.0]]", ""),
    ],
    ids=["reduced", "general section"],
)
def test_where_sections_are_not_known_that_is_said(section, basis, tmp_path):
    (caution,) = said(run(tmp_path, section, (0, 0, 1), (0, 9, 0), basis=basis))
    assert "not known" in caution.text
    assert not caution.doubt


def test_a_section_that_names_no_fibres_has_no_stress_by_bending_and_that_is_said(tmp_path):
    found = run(tmp_path, GENERAL, (0, 0, 1), (0, 0, 0))
    assert found.values["stress"] == pytest.approx(0.0, abs=1e-3)
    (caution,) = said(found)
    assert "which bending does not reach" in caution.text
    assert not found.verdict.trusted
