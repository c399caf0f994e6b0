"""A rod that is held at both ends: a slider-crank whose rod bends by its own inertia, against linear theory.

A crank of 0.15 m turns with constant speed, a rod of 0.3 m drives a block, as in the published runs of flexible slider-cranks (a steel rod
of 6 mm diameter). The rod's chord moves as that of a rigid rod, at an angle phi with L sin(phi) = -r sin(omega t), and across it

    w = sum_k q_k sin(k pi x / L),    q_k'' + (omega_k^2 - phi'^2) q_k = -(2 / L) int_0^L sin(k pi x / L) (n . a_A + x phi'') dx

with the acceleration a_A of the crank's pin and the rod's normal n. Of elongation, some 1e-5 of the length, the theory knows nothing.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from preprocessing import build
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from tests.models.beam_models import save_beam
from tests.models.directions import along, derivative_along, direction
from toolkit.analyses.sensitivity.certificate.fresh_models import disagreements, fresh_gradients
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.command_line.commands.inspection import describe_scene
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.point_force import PointForce
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import save
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.carried_force import lateral_compliance, turning_frames
from toolkit.validity.bodies.corotational_beams import compare_with_corotational
from toolkit.validity.bodies.deformation import deformation
from toolkit.validity.frame_choice import frame_choices

CRANK, ROD, DIAMETER, BLOCK = 0.15, 0.3, 0.006, 0.033
SPEED = 120.0
MODULUS, DENSITY = 2e11, 7870.0
THICKNESS = DIAMETER * np.sqrt(3) / 2
SECTION = Section(MODULUS, DENSITY, THICKNESS, np.pi * DIAMETER**2 / 4 / THICKNESS)
"""The rectangle with area and second moment of the circle."""
END = BasisChoice("eigenmodes", count=5)
CHORD = BasisChoice("eigenmodes", count=5, chord=("A", "B"))

SCENE = """units = "m-kg-s"
[points]
O = [0.0, 0.0]
A = { body = "rod", interface = "A" }
M = { body = "rod", interface = "M" }
B = { body = "rod", interface = "B" }
[bodies]
crank = { type = "rigid", mass = 1.0, inertia = 1e4, center = "O", angular_velocity = SPEED }  # it keeps its speed
rod = { type = "flexible", model = "rod.h5", frame = "moving", position = [0.15, 0.0] }
block = { type = "rigid", mass = 0.033, inertia = 1.0, center = "B" }
[joints]
O = { type = "revolute", bodies = ["crank", "ground"], point = "O" }
A = { type = "revolute", bodies = ["crank", "rod"], point = "A" }
B = { type = "revolute", bodies = ["rod", "block"], point = "B" }
guide = { type = "slider", bodies = ["block", "ground"], point = "B", axis = [1.0, 0.0], lock_rotation = true }
[design]
E = "bodies.rod.youngs_modulus"
[responses]
y = { type = "displacement", body = "rod", point = "M", component = "y" }
[solver]
end_time = END
step = STEP
rho_inf = 1.0
"""


FRAME = """units = "m-kg-s"
dimension = 2
nodes = { A = [0.02, 0.01], M = [0.17, 0.02] }
polar_nodes = { B = { from = "A", length = 0.3, angle = 0.1 } }
beams = [{ from = "A", to = "M", section = "s", elements = 3 }, { from = "M", to = "B", section = "s", elements = 3 }]
sections.s = { kind = "rectangle", thickness = 0.006, width = 0.01, material = "steel" }
materials.steel = { youngs_modulus = 2e11, density = 7870.0 }
damping = { stiffness = 1e-5 }
interface_points = { A = { node = "A" }, M = { node = "M" }, B = { node = "B" } }
basis = { kind = "craig-bampton", count = 2, chord = ["A", "B"] }
"""
SWING = """units = "m-kg-s"
[points]
A = { body = "rod", interface = "A" }
B = { body = "rod", interface = "B" }
M = { body = "rod", interface = "M" }
[bodies]
rod = { type = "flexible", model = "rod.h5", frame = "moving", extrapolation = "first-order" }
[joints]
A = { type = "revolute", bodies = ["rod", "ground"], point = "A" }
[loads]
weight = { type = "gravity", acceleration = [0.0, -9.81] }
push = { type = "point-force", body = "rod", point = "B", force = [-20.0, 3.0], curve = { type = "smooth-step", duration = 0.01 } }
[responses]
y = { type = "displacement", body = "rod", point = "M", component = "y" }
[solver]
end_time = 0.02
step = 0.0002
tolerance = 1e-12
"""


def theory(speed: float, times: np.ndarray, moduli: tuple[float, ...] = (MODULUS,), modes: int = 5) -> np.ndarray:
    """Deflections in the middle of rods of such moduli, and cos(phi) behind them, at the times: (n + 1, n_t)."""
    k = np.arange(1, modes + 1)
    own = (k * np.pi / ROD) ** 2 * np.sqrt(np.array(moduli)[:, None] * DIAMETER**2 / 16 / DENSITY)

    def chord(t: float) -> tuple[float, float, float, float]:
        """phi', phi'', n . a_A, cos(phi)."""
        along, up = math.cos(speed * t), math.sin(speed * t)
        sine, first, second = (-CRANK / ROD * each for each in (up, speed * along, -(speed**2) * up))
        cosine = math.sqrt(1 - sine**2)
        spin = first / cosine
        return spin, (second + sine * spin**2) / cosine, -(speed**2) * CRANK * (up * cosine - along * sine), cosine

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        spin, turn, across, _ = chord(t)
        q, v = y.reshape(2, *own.shape)
        return np.concatenate([v.ravel(), (-(own**2 - spin**2) * q - across * of_ends - turn * of_turn).ravel()])

    of_ends, of_turn = 2 / (k * np.pi) * (1 - (-1.0) ** k), -2 / (k * np.pi) * (-1.0) ** k * ROD
    found = solve_ivp(rates, (0, times[-1]), np.zeros(2 * own.size), t_eval=times, rtol=1e-10, atol=1e-14, method="DOP853")
    middle = np.sin(k * np.pi / 2) @ found.y[: own.size].reshape(*own.shape, -1)
    return np.vstack([middle, [chord(t)[3] for t in times]])


def scene(folder, choice: BasisChoice, steps: int = 8000) -> Scene:
    nodes = np.column_stack([np.linspace(0, ROD, 17), np.zeros(17)])
    save_beam(folder / "rod.h5", nodes, SECTION, {"A": 0.0, "M": ROD / 2, "B": ROD}, basis=choice)
    end = 2 * np.pi / SPEED
    text = SCENE.replace("SPEED", repr(SPEED)).replace("END", repr(end)).replace("STEP", repr(end / steps))
    (folder / "scene.toml").write_text(text)
    return read_scene(folder / "scene.toml")


def deflection(solution: Solution) -> np.ndarray:
    """Of the middle of the rod from the line through its ends."""
    model = solution.system.scene.model("rod.h5")
    q = np.real(solution.q[:, solution.coordinates("rod")])
    one, middle, other = (np.column_stack([np.ones(len(q)), q[:, 3:]]) @ model.interfaces[name].here[0].T for name in "AMB")
    chord = other - one
    e = chord / np.linalg.norm(chord, axis=1)[:, None]
    return np.einsum("td,td->t", middle - one, np.column_stack([-e[:, 1], e[:, 0]]))


def end_turn(solution: Solution) -> float:
    """Rotation of the first end against the line through both, of a rod along x."""
    model = solution.system.scene.model("rod.h5")
    q = np.real(solution.q[-1, solution.coordinates("rod")])
    elastic = np.append(1.0, q[3:])
    one, other = (model.interfaces[name].here[0] @ elastic for name in "AB")
    return float(model.interfaces["A"].here[1] @ elastic - np.arctan2(*(other - one)[::-1]))


def test_only_a_frame_on_the_chord_gives_the_deflection_of_a_rod_between_two_pins(tmp_path):
    """The end frame is off by a third and more: the force along the rod turns with the rod's end instead of its chord."""
    errors = {}
    for name, choice in (("end", END), ("chord", CHORD)):
        found = simulate(prepare(scene(tmp_path, choice)))
        expected, _ = theory(SPEED, found.times)
        errors[name] = np.abs(deflection(found) - expected).max() / np.abs(expected).max()
    assert errors["end"] > 0.3
    assert errors["chord"] < 1e-4  # phase of the vibration: omega_1 t (omega_1 h)^2 / 12 = 1.2e-4 at the very end


def test_gradients_are_those_of_linear_theory_with_a_chord_alone(tmp_path):
    """dy/dE of the middle at the end of a turn, cos(phi) dw/dE: the rod's chord moves as if it were rigid."""
    times, h = np.linspace(0, 2 * np.pi / SPEED, 5), 1e-4 * MODULUS
    up, down, cosine = theory(SPEED, times, (MODULUS + h, MODULUS - h))
    expected = (cosine * (up - down) / (2 * h))[-1]
    errors = {}
    for name, choice in (("end", END), ("chord", CHORD)):
        found = direct(scene(tmp_path, choice), ["bodies.rod.youngs_modulus"], "transient").gradients["y"][
            "bodies.rod.youngs_modulus"
        ]
        errors[name] = abs(found - expected) / abs(expected)
    assert errors["end"] > 1
    assert errors["chord"] < 1e-3  # that phase, of a derivative that grows with it: 5e-4


def test_gradients_of_the_motion_are_those_of_the_complex_step(tmp_path):
    """By what the beam is made of, where shapes on the chord follow it."""
    moving = scene(tmp_path, BasisChoice("craig-bampton", count=2, chord=("A", "B")), 200)
    design = [f"bodies.rod.{name}" for name in ("youngs_modulus", "density", "thickness")]
    found = direct(moving, design, "transient")
    ours, factors = found.gradients["y"], {x: part * abs(moving.number(x)) for x, part in direction(design).items()}
    judge = derivative_along(moving, factors, "transient", found.solution)["y"]
    largest = max(abs(ours[x] * factors[x]) for x in design)
    assert abs(along(ours, factors) - judge) <= 1e-9 * largest  # Newton's tolerance, 1e-10, over 200 steps


@pytest.mark.usefixtures("programs_here")
def test_gradients_by_length_and_section_are_those_of_models_built_afresh(tmp_path):
    """As `ffrf certify` compares them, of a frame in the plane on a chord that its length and angle turn."""
    (tmp_path / "rod.toml").write_text(FRAME)
    save(build(tmp_path / "rod.toml"), tmp_path / "rod.h5")
    (tmp_path / "scene.toml").write_text(SWING)
    swinging, design = (
        read_scene(tmp_path / "scene.toml"),
        [f"bodies.rod.{name}" for name in ("length_B", "angle_B", "thickness_s")],
    )
    fresh = fresh_gradients(swinging, design, "transient", lambda *_: None)
    assert set(fresh.slopes["y"]) == set(design)
    assert list(disagreements(fresh, direct(swinging, design, "transient"))) == []


# what is said of it


def test_a_run_and_inspect_say_which_frame_the_joints_ask_for(tmp_path):
    moving = scene(tmp_path, BasisChoice("craig-bampton", count=2), 400)
    told = {caution.code: caution.text for caution in simulate(prepare(moving)).warnings}
    for code in ("large-deformation", "critical-load", "reference-condition"):
        assert "held at 'A' and 'B' by joints that let it turn: a frame through these points" in told[code]
        assert 'basis.chord = ["A", "B"]' in told[code]
    words = describe_scene(moving)["reference_conditions"]["rod"]
    assert words.startswith("tangent frame")
    assert 'basis.chord = ["A", "B"]' in words
    moving = scene(tmp_path, CHORD, 200)
    assert describe_scene(moving)["reference_conditions"]["rod"].endswith("by joints that let it turn, as it should be")
    assert not any("basis.chord" in caution.text for caution in simulate(prepare(moving)).warnings)


def test_modes_without_elongation_hide_nothing(tmp_path):
    """Bending modes do not tell the force along the rod: the joints do. The estimate is that of a rod at rest under it."""
    run = simulate(prepare(scene(tmp_path, END, 400)))
    (doubt,) = [caution for caution in run.warnings if caution.code == "reference-condition"]
    assert doubt.doubt
    assert doubt.text in run.verdict.reasons
    (found,) = turning_frames(run)
    assert found.chord == ("A", "B")
    assert found.force > 0
    np.testing.assert_allclose(
        lateral_compliance(run, "rod", found.chord),
        ROD**2 / (3 * MODULUS * np.pi * DIAMETER**4 / 64),
        rtol=2e-3,  # of five modes
    )
    assert list(turning_frames(simulate(prepare(scene(tmp_path, CHORD, 400))))) == []


@pytest.mark.parametrize("tension", [60.0, -60.0])
def test_the_meter_of_turning_frames_is_right_for_a_beam_at_rest(tension, tmp_path):
    """A beam on a pin and a slider under a force along it and a small one across: how its end turns against its chord in both frames."""
    found, meters = {}, []
    for name, choice in (("end", BasisChoice("full")), ("chord", CHORD)):
        held = scene(tmp_path, choice, 200)
        joints = {
            "A": Revolute(bodies=("rod", "ground"), point="A"),
            "B": Slider(bodies=("rod", "ground"), point="B", axis=(1.0, 0.0)),
        }
        loads = {
            "pull": PointForce(body="rod", point="B", force=(tension, 0.0)),
            "push": PointForce(body="rod", point="M", force=(0.0, 0.1)),
        }
        held = held.model_copy(update={"bodies": {"rod": held.bodies["rod"]}, "joints": joints, "loads": loads})
        points = {name: point for name, point in held.points.items() if name != "O"}
        run = solve_statics(compile_scene(held.model_copy(update={"points": points})))
        found[name] = end_turn(run)
        meters += turning_frames(run)
    (meter,) = meters
    np.testing.assert_allclose(meter.force, tension, rtol=1e-3)  # small rotations
    off = found["end"] / found["chord"] - 1
    np.testing.assert_allclose(np.sign(tension) * meter.error, off, rtol=0.02)
    assert abs(off) > 0.1


def test_a_rod_on_a_chord_that_is_clamped_is_told_to_have_an_end_frame(tmp_path):
    held = scene(tmp_path, CHORD, 200)
    clamp = RigidJoint(bodies=("crank", "rod"), point="A")
    clamped = held.model_copy(update={"joints": {"O": held.joints["O"], "A": clamp}})
    (found,) = frame_choices(clamped).values()
    assert found.words.startswith("chord: ")
    assert "clamped at 'A' alone: a frame that is clamped there" in found.words
    assert frame_choices(held.model_copy(update={"joints": {"O": held.joints["O"], "A": held.joints["A"]}})) == {}


@pytest.mark.usefixtures("programs_here")
def test_the_meter_of_large_deformation_knows_the_chord(tmp_path):
    """Against corotational elements on the same chord, under the forces of the instant that deforms them most."""
    run = simulate(prepare(scene(tmp_path, BasisChoice("full", chord=("A", "B")), 400)))
    truth = compare_with_corotational(run, "rod")
    estimate = deformation(run, "rod")
    assert 1 / 1.5 < estimate.error / truth.error < 1.5  # as far as turns by less than 0.7 rad go, see test_deformation
    assert estimate.relative > 0.05
