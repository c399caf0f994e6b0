"""What forces at points, weight and inertia do in shapes that a reduced basis leaves out is told as large as it is."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import ffrf
from preprocessing import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from toolkit.foundation.errors import ModelFileError
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.file import load, save
from toolkit.responses.least_squares_forces import JointWrenches
from toolkit.validity.bodies.geometric_stiffness import wrenches_at_points

E, RHO, T, B, L = 2e9, 1200.0, 0.02, 0.03, 1.0
AREA, INERTIA = T * B, B * T**3 / 12
SCENE = """
units = "m-kg-s"
{space}
[points]
root = {{ body = "beam", interface = "root" }}
tip = {{ body = "beam", interface = "tip" }}
{points}
[bodies]
beam = {{ type = "flexible", model = "beam.h5", frame = {frame} }}
{more}
[responses]
energy = {{ type = "strain-energy" }}
y = {{ type = "displacement", body = "beam", point = "tip", component = "y" }}
turn = {{ type = "rotation", body = "{turning}", point = "tip"{axis} }}
stress = {{ type = "max-stress", body = "beam", measure = "absolute" }}
"""
PUSH = '[loads]\npush = { type = "point-force", body = "beam", point = "tip", force = FORCE }'
WEIGHT = '[loads]\nweight = {{ type = "gravity", acceleration = [{}, {}] }}'
FRAME = """units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0.0, 0.0, 0.0], B = [0.6, 0.0, 0.8] }
beams = [{ from = "A", to = "B", section = "bar", elements = 8 }]
interface_points = { root = { node = "A" }, tip = { node = "B" } }
basis = { kind = "eigenmodes", count = 4 }
[sections]
bar = { kind = "tube", diameter = 0.03, wall = 0.004, material = "plastic" }
[materials]
plastic = { youngs_modulus = 2e9, poisson_ratio = 0.35, density = 1200.0 }
"""


def beam(folder, more="", turning="beam", frame='"grounded"', points="", **basis):
    """A bar along x of ten elements."""
    nodes = np.column_stack([np.linspace(0, L, 11), np.zeros(11)])
    section = Section(youngs_modulus=E, density=RHO, thickness=T, width=B)
    save(polygon_beam(nodes, section, {"root": 0.0, "tip": L}, basis=BasisChoice(**basis)), folder / "beam.h5")
    (folder / "scene.toml").write_text(SCENE.format(space="", points=points, axis="", more=more, frame=frame, turning=turning))
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"))


def told(run):
    """Response -> by which part a doubt about shapes that are left out says that it is off."""
    texts = [each.text for each in run.verdict.warnings if each.code == "left-out-shapes" and each.doubt]
    return {name: float(part) / 100 for text in texts for name, part in re.findall(r"(\w+) is off by about (\d+)%", text)}


def parts(run, **exact):
    """The same from exact values, of parts that count."""
    off = {name: abs(1 - run.values[name] / value) for name, value in exact.items()}
    return {name: pytest.approx(part, abs=0.006) for name, part in off.items() if part > 0.05}


@pytest.mark.parametrize(
    ("along", "basis"),
    [
        (0.0, {"kind": "eigenmodes", "count": 1}),
        (300.0, {"kind": "eigenmodes", "count": 4}),
        (300.0, {"kind": "craig-bampton", "count": 0}),
        (0.0, {"kind": "full"}),
    ],
    ids=["one mode", "pulled", "craig-bampton", "full"],
)
def test_forces_at_points_in_shapes_that_are_left_out(along, basis, tmp_path):
    """A cantilever: F^2 L^3 / (6 E I) + N^2 L / (2 E A), F L / (I / (t / 2)) + N / A at its clamp, F L^3 / (3 E I), F L^2 / (2 E I)."""
    run = beam(tmp_path, PUSH.replace("FORCE", f"[{along}, 1.0]"), **basis).statics()
    energy = L**3 / (6 * E * INERTIA) + along**2 * L / (2 * E * AREA)
    moves = {"y": L**3 / (3 * E * INERTIA), "turn": L**2 / (2 * E * INERTIA)}
    assert told(run) == parts(run, energy=energy, stress=L * T / 2 / INERTIA + along / AREA, **moves)


@pytest.mark.parametrize("thickness", [0.03])
def test_other_numbers_than_those_of_the_file(thickness, tmp_path):
    body = f'"grounded", thickness = {thickness}'
    one = {"kind": "eigenmodes", "count": 1, "derivative": "frozen"}
    run = beam(tmp_path, PUSH.replace("FORCE", "[0.0, 0.1]"), frame=body, **one).statics()
    inertia = B * thickness**3 / 12
    exact = {"stress": 0.1 * L * thickness / 2 / inertia, "turn": 0.1 * L**2 / (2 * E * inertia)}
    assert told(run) == parts(run, **exact)


def test_a_mass_turns_as_the_tip_that_it_is_fixed_to(tmp_path):
    mass = '[bodies.mass]\ntype = "rigid"\nmass = 0.1\ncenter = "tip"\ninertia = 1e-4\n'
    glue = '[joints]\nglue = { type = "rigid", bodies = ["mass", "beam"], point = "tip" }\n'
    run = beam(tmp_path, mass + glue + PUSH.replace("FORCE", "[0.0, 1.0]"), "mass", kind="eigenmodes", count=1).statics()
    assert told(run)["turn"] == parts(run, turn=L**2 / (2 * E * INERTIA))["turn"]


def test_points_that_joints_hold_move_no_further(tmp_path):
    pin = '[joints]\npin = { type = "revolute", bodies = ["beam", "ground"], point = "tip" }\n'
    run = beam(tmp_path, pin + WEIGHT.format(0.0, -9.81), kind="eigenmodes", count=4).statics()
    assert not {"y", "turn"} & {*told(run)}


@pytest.mark.parametrize("angle", [0.02, 1.5], ids=["nearly along", "across"])
def test_weight_in_shapes_that_are_left_out(angle, tmp_path):
    """Of p per length, across p^2 L^5 / (40 E I) and along p^2 L^3 / (6 E A)."""
    p = RHO * AREA * 9.81 * np.array([np.cos(angle), np.sin(angle)])
    run = beam(tmp_path, WEIGHT.format(*(p / RHO / AREA)), kind="eigenmodes", count=3).statics()
    exact = p[1] ** 2 * L**5 / (40 * E * INERTIA) + p[0] ** 2 * L**3 / (6 * E * AREA)
    assert told(run).get("energy", 0.0) == parts(run, energy=exact).get("energy", 0.0)


def test_inertia_in_shapes_that_are_left_out(tmp_path):
    """A bar that spins about its end is stretched by rho^2 A omega^4 L^5 / (15 E)."""
    turn = """[joints]
hinge = { type = "revolute", bodies = ["beam", "ground"], point = "root" }
drive = { type = "angle-driver", bodies = ["beam", "ground"], point = "root", curve = { type = "polynomial", coefficients = [0.0, 6.0] } }
[solver]
end_time = 0.1
step = 0.01
"""
    run = beam(tmp_path, turn, frame='"moving", angular_velocity = 6.0', kind="eigenmodes", count=3).simulate()
    assert told(run)["energy"] == pytest.approx(1 - run.values["energy"] / (RHO**2 * AREA * 6.0**4 * L**5 / (15 * E)), abs=0.05)


def test_free_fall_leaves_nothing_but_round_off(tmp_path):
    solver = "[solver]\nend_time = 0.1\nstep = 0.01\n"
    run = beam(tmp_path, WEIGHT.format(0.0, -9.81) + "\n" + solver, frame='"moving"', kind="eigenmodes", count=3).simulate()
    assert told(run) == {}


def test_joints_push_both_of_their_bodies(tmp_path):
    """A rod that the tip of a beam carries: the joint bears its weight m g and the moment m g l / 2 of that, and puts both on the beam."""
    rod = '[bodies.rod]\ntype = "rod"\nbetween = ["tip", "end"]\narea = 1e-4\ndensity = 1000.0\n'
    glue = '[joints]\nglue = { type = "rigid", bodies = ["rod", "beam"], point = "tip" }\n'
    text = rod + glue + WEIGHT.format(0.0, -9.81)
    run = beam(tmp_path, text, kind="eigenmodes", count=3, points="end = [1.5, 0.0]").statics()
    ((on_rod, on_beam),) = JointWrenches(run.solution).at(0)
    weight = 1e-4 * 0.5 * 1000.0 * 9.81
    np.testing.assert_allclose(on_rod, [0.0, weight, weight * 0.25], rtol=1e-2, atol=1e-9)
    np.testing.assert_allclose(on_beam, -on_rod, atol=1e-12)
    np.testing.assert_allclose(wrenches_at_points(run.solution, "beam", np.array([0]))["tip"][0], on_beam, atol=1e-12)


def test_a_torque_in_space_twists_what_its_modes_do_not(tmp_path):
    """Of a tube, T^2 L / (2 G J); the four slowest modes bend it."""
    (tmp_path / "frame.toml").write_text(FRAME)
    save(build(tmp_path / "frame.toml"), tmp_path / "beam.h5")
    torque = '[loads]\ntwist = { type = "torque", body = "beam", point = "tip", torque = [0.6, 0.0, 0.8] }'
    scene = SCENE.format(
        space="dimension = 3", points="", axis=", axis = [0.0, 1.0, 0.0]", turning="beam", more=torque, frame='"grounded"'
    )
    (tmp_path / "scene.toml").write_text(scene)
    run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
    assert run.values["energy"] < 1e-12
    assert told(run)["energy"] == 1.0
    polar, found = np.pi / 32 * (0.03**4 - 0.022**4), load(tmp_path / "beam.h5").left_out_shapes.compliance
    twist = np.zeros(len(found))
    twist[[9, 11]] = 0.6, 0.8  # moments at the tip, behind six loads at the root
    assert twist @ found @ twist == pytest.approx(L / (2e9 / 2.7 * polar), rel=1e-9)


def test_other_units_are_the_same_body(tmp_path):
    beam(tmp_path, "", kind="eigenmodes", count=2)
    here = load(tmp_path / "beam.h5")
    there = converted_model(here, "mm-t-s").left_out_shapes
    c, s = here.left_out_shapes.compliance, here.left_out_shapes.stress_operator
    for k, unit in {3: 1.0, 5: 1e3, 6: 1e3, 8: 1.0}.items():  # forces in N, moments in N mm, pulls in mm / s^2 and 1 / s^2
        np.testing.assert_allclose(there.compliance[k, k], 1e3 * c[k, k] / unit**2, rtol=1e-12)
        np.testing.assert_allclose(there.stress_operator[:, k], 1e-6 * s[:, k] / unit, rtol=1e-12, atol=1e-20)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"compliance": lambda c: c[1:, 1:], "stress_operator": lambda s: s[:, 1:]}, "has 13 loads instead of 14"),
        ({"compliance": lambda c: c + np.eye(14, k=1)}, "is not symmetric"),
        ({"stress_operator": lambda s: s[1:]}, "has another number of rows"),
    ],
)
def test_parts_that_cannot_be_are_refused(changed, message, tmp_path):
    beam(tmp_path, "", kind="eigenmodes", count=2)
    model = load(tmp_path / "beam.h5")
    wrong = {name: change(getattr(model.left_out_shapes, name)) for name, change in changed.items()}
    with pytest.raises(ModelFileError, match=message):
        save(replace(model, left_out_shapes=replace(model.left_out_shapes, **wrong)), tmp_path / "wrong.h5")
