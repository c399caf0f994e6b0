"""Gradients of steady states, of their frequencies, and of frequencies at the end of a motion: all methods, and the complex step."""

from __future__ import annotations

import numpy as np
import pytest

from tests.spinning.scenes import governor, planar_blade, table, table_in_space, top
from toolkit.description.run_options import RunOptions
from toolkit.responses.energy import KineticEnergy
from toolkit.responses.forces.joint_force import JointForce
from toolkit.responses.kinematics.point_distance import PointDistance
from toolkit.responses.vibrations.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene
from toolkit.sensitivity.methods import gradients_by
from toolkit.sensitivity.preparation import prepare, solve

EXACT = 1e-10


def same(scene, kind: str, names: list[str], method: str, close: float = EXACT) -> None:
    found, judge = (gradients_by(each, scene, names, kind) for each in (method, "complex-step"))
    for response, slopes in judge.gradients.items():
        sizes = {name: abs(slope * scene.value_of(name)) for name, slope in slopes.items()}
        largest = max([*sizes.values(), abs(judge.values[response])])
        for name, slope in slopes.items():
            number = max(abs(scene.value_of(name)), 1e-3)
            ours = found.gradients[response][name]
            assert abs(ours - slope) * number <= close * largest, (response, name, ours, slope)
    assert all(any(abs(each) > 0 for each in slopes.values()) for slopes in judge.gradients.values())


@pytest.mark.parametrize("method", ["direct", "adjoint"])
@pytest.mark.parametrize("make", [table, table_in_space], ids=["plane", "space"])
def test_by_every_number_of_a_table_that_spins(make, method):
    scene = make(3.0, 50.0, 2.0, 1.0)
    asked = {
        **scene.responses,
        "reach": PointDistance(bodies=("ground", "block"), points=("O", "Q")),
        "pull": JointForce(joint="hinge", component="magnitude"),
        "kinetic": KineticEnergy(),
    }
    names = [name for name in scene.available_paths() if ".inertia." not in name or "block" in name]
    same(scene.model_copy(update={"responses": asked}), "static", names, method)


@pytest.mark.parametrize("method", ["direct", "adjoint"])
def test_by_the_numbers_of_a_governor_and_of_a_gyroscope(method):
    names = ["joints.motor.curve.coefficients.y", "points.B.x", "points.B.z", "bodies.ball.mass", "loads.weight.acceleration.z"]
    undamped = governor(6.0).model_copy(update={"responses": {"f": Frequency()}})
    same(undamped, "static", [*names, "bodies.ball.inertia.x"], method)
    wheel = ["joints.motor.curve.coefficients.y", "bodies.disc.inertia.z", "bodies.disc.inertia.x", "loads.about_x.stiffness"]
    same(top(5.0), "static", wheel, method)


def test_by_the_numbers_of_flexible_bodies(tmp_path):
    asked = {
        "f": Frequency(),
        "zeta": DampingRatio(number=2),
        "reach": PointDistance(bodies=("ground", "part2"), points=("part0_root", "part2_tip")),
    }
    scene = planar_blade(tmp_path, 3, 30.0, damping=1e-4).model_copy(update={"responses": asked})
    same(scene, "static", [f"bodies.part1.{name}" for name in ("youngs_modulus", "density", "thickness")], "direct")
    same(scene, "static", ["joints.motor.curve.coefficients.y", "bodies.part0.thickness"], "adjoint")


def settling(damping: float) -> Scene:
    """A block that a damper brings to its place on the table within the motion."""
    end = {"f": Frequency(when="end"), "zeta": DampingRatio(when="end")}
    options = RunOptions(end_time=6.0, step=0.02, tolerance=1e-13)
    return table(3.0, 50.0, 2.0, damping, responses=end, solver=options)


@pytest.mark.parametrize("method", ["direct", "adjoint"])
def test_at_the_end_of_a_motion(method):
    """The spin that a motion ends in has the frequency of the steady state, and exact gradients through all its steps."""
    scene = settling(12.0)
    names = ["loads.spring.stiffness", "bodies.block.mass", "joints.motor.curve.coefficients.y", "loads.spring.damping"]
    same(scene, "transient", names, method, 1e-9)  # what Newton leaves in 300 steps
    motion = gradients_by("direct", scene, names, "transient")
    state = table(3.0, 50.0, 2.0, 12.0)
    found = gradients_by("direct", state, names, "static")
    for name in ("f", "zeta"):
        assert motion.values[name] == pytest.approx(found.values[name], rel=1e-6)  # exp(-18) of the start is left
        for x in names:
            assert motion.gradients[name][x] == pytest.approx(found.gradients[name][x], rel=1e-5, abs=1e-6)


def test_at_the_end_of_a_motion_whose_states_exceed_the_memory():
    """The adjoint between checkpoints looks at the last window alone."""
    scene = settling(12.0)
    names = ["loads.spring.stiffness", "joints.motor.curve.coefficients.y"]
    whole = gradients_by("adjoint", scene, names, "transient")
    little = scene.model_copy(update={"solver": scene.solver.model_copy(update={"memory": 2e-5})})
    parts = gradients_by("adjoint", little, names, "transient")
    assert len(parts.solution.times) < len(whole.solution.times)  # those of the checkpoints
    for name in ("f", "zeta"):
        assert parts.values[name] == pytest.approx(whole.values[name], rel=1e-12)
        assert parts.gradients[name] == pytest.approx(whole.gradients[name], rel=1e-9)


def test_a_vibration_of_two_equal_frequencies_has_no_derivative():
    """A disc with springs that does not spin fast enough to be told: at rest both whirls are one."""
    scene = top(1e-9)
    found = gradients_by("direct", scene, ["loads.about_x.stiffness"], "static")
    assert np.isnan(found.gradients["first"]["loads.about_x.stiffness"])
    assert found.values["first"] == pytest.approx(np.sqrt(40.0 / 0.3) / (2 * np.pi), rel=1e-7)
    assert solve(prepare(scene), "static").spins


@pytest.mark.parametrize("method", ["direct", "adjoint"])
@pytest.mark.parametrize("make", [table, table_in_space], ids=["plane", "space"])
def test_a_motion_that_starts_in_its_steady_spin_stays_there(make, method):
    """No vibration begins: length and frequency are those of statics, and so are their gradients, through start and steps."""
    state = make(3.0, 50.0, 2.0, 0.0)
    end = {"f": Frequency(when="end"), "reach": PointDistance(bodies=("ground", "block"), points=("O", "Q"))}
    options = RunOptions(end_time=0.2, step=0.005, tolerance=1e-13, equilibrium="spinning", start="equilibrium")
    scene = state.model_copy(update={"responses": end, "solver": options})
    names = ["loads.spring.stiffness", "bodies.block.mass", "joints.motor.curve.coefficients.y"]
    same(scene, "transient", names, method)
    moved, still = (gradients_by(method, scene, names, kind) for kind in ("transient", "static"))
    for name in end:
        assert moved.values[name] == pytest.approx(still.values[name], rel=1e-4)  # (h Omega)^2 / 2 of the steps
        for x in names:
            assert moved.gradients[name][x] == pytest.approx(still.gradients[name][x], rel=5e-3, abs=1e-6), (name, x)
