"""Shear that Euler-Bernoulli beams leave out is told as large as it is, of what bends in the plane asked for: by Timoshenko's beam."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import ffrf
from preprocessing.builders.build_model import build
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.timoshenko import cantilever_frequency
from toolkit.reduced_model.file import save
from toolkit.validity.bodies.sheared_beams import raised_by_stiff_shear, sheared_parts

E, RHO, WIDTH = 2e11, 7800.0, 0.05
SHEAR = 5 / 6 / 2.6
"""kappa G / E of a rectangle with Poisson's ratio 0.3."""
SCENE = """units = "m-kg-s"
[points]
T = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded" }
[design]
t = "bodies.beam.thickness"
[loads]
F = { type = "point-force", body = "beam", point = "T", force = DIRECTION }
[responses]
"""
FREQUENCIES = [81.16, 486.4, 1279.4]
STRIP = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0.0, 0.0, 0.0], B = [1.0, 0.0, 0.0] }
beams = [{ from = "A", to = "B", section = "s", elements = 1 }]
sections.s = { kind = "rectangle", thickness = 0.02, width = 0.4, material = "m" }
materials.m = { youngs_modulus = 2e11, density = 7800.0, poisson_ratio = 0.3 }
interface_points.tip = { node = "B" }
"""


def cantilever(folder, thickness, elements=4, responses="", direction="[0.0, 1.0]"):
    section = Section(youngs_modulus=E, density=RHO, thickness=thickness, width=WIDTH)
    nodes = np.column_stack([np.linspace(0, 1, elements + 1), np.zeros(elements + 1)])
    save_beam(folder / "beam.h5", nodes, section, {"root": 0.0, "tip": 1.0}, rotary_inertia=True)
    (folder / "scene.toml").write_text(SCENE.replace("DIRECTION", direction) + responses)
    return ffrf.read_scene(folder / "scene.toml")


def frequencies(numbers):
    return "".join(f'f{k} = {{ type = "frequency", number = {k} }}\n' for k in numbers)


def said(verdict):
    return [each.text for each in verdict.warnings if each.code == "shear"]


@pytest.mark.parametrize("thickness", [0.1, 0.4])
def test_the_deflection_that_shear_adds_is_told_as_large_as_it_is(thickness, tmp_path):
    """Timoshenko's cantilever: 3 E I / (kappa G A L^2)."""
    run = ffrf.compile(cantilever(tmp_path, thickness)).statics()
    part = thickness**2 / 4 / SHEAR
    assert sheared_parts(run.solution)["beam"] == pytest.approx(part, rel=1e-9)
    assert bool(said(run.verdict)) == (part > 0.05)
    assert not said(run.verdict) or f"add some {part:.0%}" in said(run.verdict)[0]


@pytest.mark.parametrize("thickness", [0.4])
def test_shear_of_what_is_pulled_is_none(thickness, tmp_path):
    run = ffrf.compile(cantilever(tmp_path, thickness, direction="[1.0, 0.0]")).statics()
    assert not said(run.verdict)


@pytest.mark.parametrize(("direction", "thickness"), [("[0.0, 1.0, 0.0]", 0.02), ("[0.0, 0.0, 1.0]", 0.4)])
def test_a_strip_is_judged_in_the_plane_in_which_it_bends(direction, thickness, tmp_path):
    """Over its thin side and over its deep one."""
    (tmp_path / "frame.toml").write_text(STRIP)
    save(build(tmp_path / "frame.toml"), tmp_path / "beam.h5")
    text = (
        SCENE.replace("DIRECTION", direction).replace("[points]", "dimension = 3\n[points]").replace("thickness", "thickness_s")
    )
    (tmp_path / "scene.toml").write_text(text)
    run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
    part = thickness**2 / 4 / SHEAR
    assert sheared_parts(run.solution)["beam"] == pytest.approx(part, rel=1e-9)
    assert bool(said(run.verdict)) == (part > 0.05)


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """L / h = 10, whose fourth bending vibration is 15 % too fast and its derivative 48 % too large; f3 is its stretch."""
    folder = tmp_path_factory.mktemp("short")
    model = ffrf.compile(cantilever(folder, 0.1, 16, frequencies([1, 2, 3, 4])), variables=["t"])
    return model, model.statics(gradients=True)


def test_frequencies_that_shear_lowers_are_told_within_a_factor_of_two(short):
    _, run = short
    at = {
        name: partial(cantilever_frequency, near, E, RHO, shear=SHEAR)
        for name, near in zip(("f1", "f2", "f4"), FREQUENCIES, strict=True)
    }
    told = raised_by_stiff_shear(run.solution, {name: run.values[name] for name in (*at, "f3")}, True)
    assert set(told) == {"f2", "f3", "f4"}  # the slowest one is right
    assert told["f3"].value == pytest.approx(0.0, abs=1e-9)
    for name in ("f2", "f4"):
        true, rate = at[name](0.1), (at[name](0.1001) - at[name](0.0999)) / 2e-4
        off, steeper = run.values[name] / true - 1, run.gradients[name]["t"] / rate - 1
        assert off / 2 < told[name].value < 2 * off
        assert steeper / 2 < told[name].derivative < 2 * steeper
    (text,) = said(run.verdict)
    assert f"f4 of {run.values['f4']:.5g} 1/s by some {told['f4'].value:.1%} (its derivative" in text
    assert "f1 of" not in text


def test_a_table_of_modes_names_those_that_shear_lowers(short):
    model, _ = short
    assert not said(model.modes(count=3).verdict)
    (text,) = said(model.modes(count=6).verdict)
    assert "mode 4" in text
    assert "mode 3" not in text


def test_slender_beams_cost_no_second_solution(tmp_path):
    run = ffrf.compile(cantilever(tmp_path, 0.01, 8, frequencies([1, 4]))).statics()
    assert raised_by_stiff_shear(run.solution, run.values, True) == {}
    assert not said(run.verdict)
