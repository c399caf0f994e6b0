"""Doubts about what linear bodies do not know in their frames, weighed by a run with more of them: where answers feel nothing they are
remarks, where answers feel it, or where it would not show, they stay."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import ffrf
from preprocessing import build, save

FRAME = """units = "m-kg-s"
dimension = 2
clamp = ["A"]
nodes = { A = [0.0, 0.0], B = [1.0, 0.0] }
beams = [ { from = "A", to = "B", section = "s", elements = 4 } ]
interface_points = { A = { node = "A" }, B = { node = "B" } }
sections.s = { kind = "rectangle", thickness = 0.02, width = 0.03, material = "m" }
materials.m = { youngs_modulus = 2e9, density = 1200.0 }
"""
BENDING = 2e9 * 0.03 * 0.02**3 / 12
SCENE = """units = "m-kg-s"
points.A = {{ body = "beam", interface = "A" }}
points.B = {{ body = "beam", interface = "B" }}
bodies.beam = {{ type = "flexible", model = "beam.h5", frame = "moving" }}
joints.root = {{ type = "rigid", bodies = ["beam", "ground"], point = "A" }}
loads.F.type = "point-force"
loads.F.body = "beam"
loads.F.point = "B"
loads.F.force = [{along}, {across}]
loads.F.curve = {{ type = "smooth-step", duration = 0.5 }}
design = {{ t = "bodies.beam.thickness_s" }}
responses.held = {{ type = "joint-force", joint = "root", component = "{component}" }}
solver = {{ end_time = 0.5, step = 0.01 }}
"""
TIP = 'responses.tip = { type = "displacement", body = "beam", point = "B", component = "y" }\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the beam."""
    found = tmp_path_factory.mktemp("weighed")
    (found / "beam.toml").write_text(FRAME)
    save(build(found / "beam.toml"), found / "beam.h5")
    return found


def model(folder, more: str = "", along: float = 0.0, across: float = 0.0, component: str = "y") -> ffrf.Model:
    """Pulled or pressed along, and bent, by forces in parts of E I / L^2."""
    text = SCENE.format(along=along * BENDING, across=across * BENDING, component=component)
    (folder / "scene.toml").write_text(text + more)
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"), variables=["t"])


def test_a_force_that_equilibrium_tells_is_right_however_far_the_beam_bends(folder):
    """A tip that goes aside by a third of the length: the clamp holds what pulls, whatever is in between."""
    run = model(folder, across=1.0).statics(gradients=True)
    assert abs(run.values["held"]) == pytest.approx(BENDING, rel=1e-9)
    assert run.verdict.trusted
    assert "the responses hardly feel it" in " ".join(each.text for each in run.verdict.warnings).lower()


def test_a_displacement_that_feels_it_is_doubted(folder):
    """By how much, the run that is made for the gradients tells: F L^2 = E I moves the tip by 0.3017 L (Bisshopp and Drucker, 1945), not by
    a third."""
    run = model(folder, TIP, across=1.0).statics(gradients=True)
    texts = [each.text for each in run.verdict.warnings if each.doubt and each.code == "large-deformation"]
    (told,) = [re.search(r"tip by about ([\d.]+)%", text)[1] for text in texts if "tip by about" in text]
    assert run.values["tip"] == pytest.approx(1 / 3, rel=1e-6)
    assert float(told) / 100 == pytest.approx(1 - 3 * 0.3017, rel=0.25)


def elastica(load: float) -> float:
    """How far F = load E I / L^2 moves the tip across, in parts of the length (Bisshopp and Drucker, 1945).

    sqrt(load) = K(k) - F(p, k),   1 - 2 (E(k) - E(p, k)) / sqrt(load),   sin p = 1 / (sqrt(2) k)
    """
    root = np.sqrt(load)
    k = brentq(lambda k: ellipk(k * k) - ellipkinc(np.arcsin(1 / (np.sqrt(2) * k)), k * k) - root, np.sqrt(0.5) + 1e-12, 0.999)
    return 1 - 2 * (ellipe(k * k) - ellipeinc(np.arcsin(1 / (np.sqrt(2) * k)), k * k)) / root


@pytest.mark.parametrize(("across", "right"), [(0.3, True), (0.35, True), (0.5, False)])
def test_values_and_gradients_within_their_own_limits_are_not_doubted(across, right, folder):
    """A gradient by the thickness is off by three times as much as the tip, which ends up shorter by more than the meter's limit."""
    run = model(folder, TIP, across=across).statics(gradients=True)
    slope = -3 * across * (elastica(across * 1.001) - elastica(across * 0.999)) / (0.002 * across * 0.02)  # load ~ t^-3
    value_off, slope_off = run.values["tip"] / elastica(across) - 1, run.gradients["tip"]["t"] / slope - 1
    assert 0.01 < value_off < 0.03
    assert (0.03 < slope_off < 0.05) == right
    assert run.verdict.trusted == right
    remarks = [each.text for each in run.verdict.warnings if each.code == "large-deformation" and not each.doubt]
    (told,) = re.findall(r"change by ([\d.e-]+) at most, and gradients by ([\d.e-]+),", "".join(remarks)) or [(0, 0)]
    assert [float(each) for each in told] == (
        [pytest.approx(value_off, rel=0.3), pytest.approx(slope_off, rel=0.3)] if right else [0, 0]
    )


@pytest.mark.parametrize("analysis", ["statics", "simulate"])
def test_a_column_beyond_its_critical_load_that_nothing_turns_aside_is_doubted(folder, analysis):
    """Pressed straight with twice pi^2 E I / 4 L^2, it stays straight with any number of frames."""
    run = getattr(model(folder, along=-4.93, component="x"), analysis)(gradients=True)
    assert "critical-load" in [each.code for each in run.verdict.warnings if each.doubt]
