"""Bases without shapes that stretch a body: what forces along it do is found beside them, and of weight the verdict says that it is not."""

from __future__ import annotations

import re

import numpy as np
import pytest

import ffrf
from preprocessing import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from toolkit.reduced_model.file import save
from toolkit.scene.resolution import loaded
from toolkit.validity.bodies.known_chain import chain
from toolkit.validity.bodies.unseen_forces import axial_forces

SECTION = Section(youngs_modulus=210e9, density=7800.0, thickness=0.02, width=0.05)
EULER = np.pi**2 * 210e9 * 0.05 * 0.02**3 / 12 / 4
SCENE = """
units = "m-kg-s"
[points]
tip = {{ body = "strut", interface = "tip" }}
[bodies]
strut = {{ type = "flexible", model = "strut.h5", frame = "grounded" }}
[loads]
push = {{ type = "point-force", body = "strut", point = "tip", force = [{force}, 10.0] }}
[responses]
y = {{ type = "displacement", body = "strut", point = "tip", component = "y" }}
"""


def strut(folder, angle=0.0, **basis):
    """A clamped strut under nine tenths of Euler's load, its far half turned by an angle."""
    x = np.linspace(0, 1, 11)
    bent = np.maximum(x - 0.5, 0.0)
    nodes = np.column_stack([x - bent * (1 - np.cos(angle)), bent * np.sin(angle)])
    save(polygon_beam(nodes, SECTION, {"tip": 1.0}, basis=BasisChoice(**basis)), folder / "strut.h5")
    (folder / "scene.toml").write_text(SCENE.format(force=-0.9 * EULER))
    return ffrf.read_scene(folder / "scene.toml")


@pytest.mark.parametrize(
    "basis",
    [{"kind": "full"}, {"kind": "craig-bampton", "count": 1}, {"kind": "eigenmodes", "count": 3}],
    ids=lambda basis: basis["kind"],
)
def test_compression_is_judged_by_any_basis(basis, tmp_path):
    """The deflection misses nine tenths of what buckling makes of it."""
    warnings = ffrf.compile(strut(tmp_path, **basis)).statics().verdict.warnings
    assert {"critical-load", "unseen-tension"} & {each.code for each in warnings} == {"critical-load"}


@pytest.mark.parametrize("part", [-4.0, -0.3, 0.01, 0.3, 0.8])
def test_deflections_are_off_by_as_much_as_the_force_along_the_body_makes_them(part, tmp_path):
    """Of a column under a force P along it and one across its end: 3 (tan u / u - 1) / u^2 of the linear deflection, u^2 = P L^2 / EI."""
    strut(tmp_path, kind="eigenmodes", count=3)
    (tmp_path / "scene.toml").write_text(SCENE.format(force=-part * EULER))
    warnings = [
        each.text for each in ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics().verdict.warnings if each.doubt
    ]
    u = np.emath.sqrt(part) * np.pi / 2
    times = float(np.real(3 * (np.tan(u) / u - 1) / u**2))
    if part == 0.01:
        assert warnings == []
        return
    pattern = r"lack ([\d.]+) times themselves" if part > 0 else r"deflections are ([\d.]+) times as large"
    found = [float(match[1]) for each in warnings if (match := re.search(pattern, each))]
    assert found == [pytest.approx(times - 1 if part > 0 else 1 / times, rel=0.02)]  # its three modes


@pytest.mark.parametrize("angle", [0.0, 0.8])
def test_the_missed_part_is_all_of_it_without_stretch_and_nothing_with_it(angle, tmp_path):
    parts = []
    for basis in ({"kind": "eigenmodes", "count": 1}, {"kind": "craig-bampton", "count": 0}):
        scene = loaded(strut(tmp_path, angle, **basis))
        behind = chain(scene, "strut")
        tip = np.zeros((2, len(behind.shapes)))
        tip[[0, 1], [-3, -2]] = 1.0
        true, shown = axial_forces(scene, "strut", behind, tip)
        parts.append(np.linalg.norm(shown - true) / np.linalg.norm(true))
    assert parts[0] == pytest.approx(1.0, abs=0.01 if angle == 0 else 0.3)  # bending of a kinked strut goes with some stretch
    assert parts[1] == pytest.approx(0.0, abs=1e-6)


def hung_or_standing(weight: float, elements: int = 40, end: float = 0.0, spin: float = 0.0) -> float:
    """Tip of a column under a force across its end in parts of the same without weight, by cubic elements with the axial force N of its
    weight, rho A g L^3 / EI = `weight`, positive where it hangs; with a force `end` in E I / L^2 and a spin in sqrt(E I / rho A) / L^2."""
    h, n = 1 / elements, 2 * (elements + 1)
    bending = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    )
    pulled = np.array(
        [
            [36, 3 * h, -36, 3 * h],
            [3 * h, 4 * h**2, -3 * h, -(h**2)],
            [-36, -3 * h, 36, -3 * h],
            [3 * h, -(h**2), -3 * h, 4 * h**2],
        ]
    )
    stiffness = np.zeros((n, n))
    for k in range(elements):
        at, x = slice(2 * k, 2 * k + 4), (k + 0.5) * h
        force = weight * (1 - x) + end + spin**2 * (1 - x * x) / 2
        stiffness[at, at] += bending / h**3 + force * pulled / (30 * h)
    tip = np.zeros(n)
    tip[-2] = 1.0
    return 3 * float(np.linalg.solve(stiffness[2:, 2:], tip[2:])[-2])


@pytest.mark.parametrize("weight", [9.81, -4.0, 0.05])
def test_weight_pulls_and_presses_too(weight, tmp_path):
    """Of a column that hangs, or stands, or hardly weighs; its modes know nothing of the forces along it."""
    strut(tmp_path, kind="eigenmodes", count=3)
    gravity = weight * 210e9 * 0.02**2 / 12 / 7800.0
    text = SCENE.format(force=0.0) + f'[loads.weight]\ntype = "gravity"\nacceleration = [{gravity}, 0.0]\n'
    (tmp_path / "scene.toml").write_text(text)
    warnings = [
        each.text for each in ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics().verdict.warnings if each.doubt
    ]
    true = hung_or_standing(weight)
    if weight == 0.05:
        assert warnings == []
        return
    pattern = r"deflections are ([\d.]+) times as large" if weight > 0 else r"lack ([\d.]+) times themselves"
    found = [float(match[1]) for each in warnings if (match := re.search(pattern, each))]
    assert found == [pytest.approx(1 / true if weight > 0 else true - 1, rel=0.03)]  # ten elements, three modes


BAR = """units = "m-kg-s"
dimension = 3
clamp = ["root"]
nodes = { root = [0.0, 0.0, 0.0], tip = [1.0, 0.0, 0.0] }
beams = [ { from = "root", to = "tip", section = "s", elements = 12 } ]
interface_points = { root = { node = "root" }, tip = { node = "tip" } }
sections.s = { kind = "rectangle", thickness = 0.01, width = 1.0, material = "m" }
materials.m = { youngs_modulus = 12e6, density = 100.0, poisson_ratio = 0.3 }
basis = { kind = "eigenmodes", count = COUNT }
"""
IN_SPACE = """units = "m-kg-s"
dimension = 3
points.root = { body = "bar", interface = "root" }
points.tip = { body = "bar", interface = "tip" }
bodies.bar = { type = "flexible", model = "bar.h5", frame = "FRAME" }
loads.weight = { type = "gravity", acceleration = [WEIGHT, 0.0, 0.0] }
loads.push.type = "point-force"
loads.push.body = "bar"
loads.push.point = "tip"
loads.push.force = [END, 0.01, 0.0]
responses.y = { type = "displacement", body = "bar", point = "tip", component = "y" }
"""
SPINNING = """joints.hub = { type = "revolute", bodies = ["bar", "ground"], point = "root", axis = [0.0, 1.0, 0.0] }
joints.motor = { type = "angle-driver", bodies = ["bar", "ground"], point = "root", axis = [0.0, 1.0, 0.0], curve = STEADY }
loads.push.curve = { type = "smooth-step", duration = 3.0 }
solver = { end_time = 3.0, step = 0.02 }
"""


def told_in_space(folder, text: str, how: str, count: int = 6) -> list[float]:
    """How many times too large deflections of a bar with E I = rho A = L = 1 are, by modes that do not stretch it."""
    (folder / "bar.toml").write_text(BAR.replace("COUNT", str(count)))
    save(build(folder / "bar.toml"), folder / "bar.h5")
    (folder / "scene.toml").write_text(text)
    verdict = getattr(ffrf.compile(ffrf.read_scene(folder / "scene.toml")), how)().verdict
    texts = [each.text for each in verdict.warnings if each.doubt and "its basis does not show" in each.text]
    pairs = ((re.search(r"deflections are ([\d.]+) times", each), re.search(r"lack ([\d.]+) times", each)) for each in texts)
    return [float(large[1]) if large else 1 / (1 + float(lack[1])) for large, lack in pairs]


@pytest.mark.parametrize(("weight", "end"), [(5.0, 0.0), (-4.0, 0.0), (0.0, 5.0), (2.0, 3.0), (0.05, 0.0)])
def test_modes_of_a_beam_in_space_are_told_what_pulls_at_them(tmp_path, weight, end):
    text = IN_SPACE.replace("FRAME", "grounded").replace("END", repr(end)).replace("WEIGHT", repr(weight))
    found = told_in_space(tmp_path, text, "statics")
    assert found == ([] if weight == 0.05 else [pytest.approx(1 / hung_or_standing(weight, end=end), rel=0.04)])


@pytest.mark.parametrize("spin", [6.0, 0.5])
def test_a_beam_in_space_that_spins_is_told_too(tmp_path, spin):
    """By the static deflection across the plane of the spin."""
    steady = f'{{ type = "polynomial", coefficients = [0.0, {spin}] }}'
    text = IN_SPACE.replace("FRAME", "moving").replace("END", "0.0").replace("WEIGHT", "0.0") + SPINNING.replace("STEADY", steady)
    times = 1 / hung_or_standing(0.0, spin=spin)
    assert (times > 1.05) == (spin == 6.0)
    assert told_in_space(tmp_path, text, "simulate") == ([pytest.approx(times, rel=0.08)] if spin == 6.0 else [])
