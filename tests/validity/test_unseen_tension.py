"""Bases without shapes that stretch a body: what forces along it do is found beside them, and of weight the verdict says that it is not."""

from __future__ import annotations

import re

import numpy as np
import pytest

import ffrf
from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.elements.section import Section
from preprocessing.recipes.frame.polygon_beam import polygon_beam
from toolkit.reduced_model.file import save
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.compressed.unseen_tension import axial_forces

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
        scene = strut(tmp_path, angle, **basis)
        behind = chain(scene, "strut")
        tip = np.zeros((2, len(behind.shapes)))
        tip[[0, 1], [-3, -2]] = 1.0
        true, shown = axial_forces(scene, "strut", behind, tip)
        parts.append(np.linalg.norm(shown - true) / np.linalg.norm(true))
    assert parts[0] == pytest.approx(1.0, abs=0.01 if angle == 0 else 0.3)  # bending of a kinked strut goes with some stretch
    assert parts[1] == pytest.approx(0.0, abs=1e-6)


def hung_or_standing(weight: float, elements: int = 40) -> float:
    """Tip of a column under a force across its end in parts of the same without weight, by cubic elements with the axial force N of its
    weight, rho A g L^3 / EI = `weight`, positive where it hangs."""
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
        at = slice(2 * k, 2 * k + 4)
        stiffness[at, at] += bending / h**3 + weight * (1 - (k + 0.5) * h) * pulled / (30 * h)
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
