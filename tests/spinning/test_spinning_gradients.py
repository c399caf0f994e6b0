"""Gradients of steady states, of their frequencies, and of frequencies at the end of a motion: all methods, and the complex step."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.directions import along, derivative_along, direction
from tests.spinning.scenes import governor, planar_blade, table, table_in_space, top
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import Kind, prepare, solve
from toolkit.analyses.sensitivity.run import Run
from toolkit.description.run_options import RunOptions
from toolkit.responses.energy import KineticEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.point_motion import PointDistance
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene

EXACT = 1e-10


def same(scene: Scene, kind: Kind, names: list[str], close: float = EXACT) -> dict[str, Run]:
    """Gradients by direct differentiation and by the adjoint, after a complex step of all numbers has judged both."""
    found = {method: gradients_by(method, scene, names, kind) for method in ("direct", "adjoint")}
    factors = {name: part * max(abs(scene.value_of(name)), 1e-3) for name, part in direction(names).items()}
    for response, judge in derivative_along(scene, factors, kind, found["direct"].solution).items():
        for method, by in found.items():
            slopes = by.gradients[response]
            largest = max([*(abs(slope * factors[name]) for name, slope in slopes.items()), abs(by.values[response])])
            assert along(slopes, factors) == pytest.approx(judge, rel=0, abs=close * largest), (method, response)
            assert any(slopes.values()), response
    for response, slopes in found["direct"].gradients.items():
        other = found["adjoint"].gradients[response]
        largest = max([*(abs(slope * factors[name]) for name, slope in slopes.items()), abs(found["direct"].values[response])])
        for name, slope in slopes.items():
            assert abs(other[name] - slope) * abs(factors[name]) <= close * largest, (response, name, other[name], slope)
    return found


@pytest.mark.parametrize("make", [table, table_in_space], ids=["plane", "space"])
def test_by_every_number_of_a_table_that_spins(make):
    scene = make(3.0, 50.0, 2.0, 1.0)
    asked = {
        **scene.responses,
        "reach": PointDistance(bodies=("ground", "block"), points=("O", "Q")),
        "pull": JointForce(joint="hinge", component="magnitude"),
        "kinetic": KineticEnergy(),
    }
    names = [name for name in scene.available_paths() if ".inertia." not in name or "block" in name]
    same(scene.model_copy(update={"responses": asked}), "static", names)


def test_by_the_numbers_of_a_governor_and_of_a_gyroscope():
    names = ["joints.motor.curve.coefficients.y", "points.B.x", "points.B.z", "bodies.ball.mass", "loads.weight.acceleration.z"]
    undamped = governor(6.0).model_copy(update={"responses": {"f": Frequency()}})
    same(undamped, "static", [*names, "bodies.ball.inertia.x"])
    wheel = ["joints.motor.curve.coefficients.y", "bodies.disc.inertia.z", "bodies.disc.inertia.x", "loads.about_x.stiffness"]
    same(top(5.0), "static", wheel)


def test_by_the_numbers_of_flexible_bodies(tmp_path):
    asked = {
        "f": Frequency(),
        "zeta": DampingRatio(number=2),
        "reach": PointDistance(bodies=("ground", "part2"), points=("part0_root", "part2_tip")),
    }
    scene = planar_blade(tmp_path, 3, 30.0, damping=1e-4).model_copy(update={"responses": asked})
    names = [f"bodies.part1.{name}" for name in ("youngs_modulus", "density", "thickness")]
    same(scene, "static", [*names, "joints.motor.curve.coefficients.y", "bodies.part0.thickness"])


def settling(damping: float) -> Scene:
    """A block that a damper brings to its place on the table within the motion."""
    end = {"f": Frequency(when="end"), "zeta": DampingRatio(when="end")}
    options = RunOptions(end_time=6.0, step=0.02, tolerance=1e-13)
    return table(3.0, 50.0, 2.0, damping, responses=end, solver=options)


def test_at_the_end_of_a_motion():
    """The spin that a motion ends in has the frequency of the steady state, and exact gradients through all its steps."""
    scene = settling(12.0)
    names = ["loads.spring.stiffness", "bodies.block.mass", "joints.motor.curve.coefficients.y", "loads.spring.damping"]
    motion = same(scene, "transient", names, 1e-9)["direct"]  # what Newton leaves in 300 steps
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


@pytest.mark.parametrize("make", [table, table_in_space], ids=["plane", "space"])
def test_a_motion_that_starts_in_its_steady_spin_stays_there(make):
    """No vibration begins: length and frequency are those of statics, and so are their gradients, through start and steps."""
    state = make(3.0, 50.0, 2.0, 0.0)
    end = {"f": Frequency(when="end"), "reach": PointDistance(bodies=("ground", "block"), points=("O", "Q"))}
    options = RunOptions(end_time=0.2, step=0.005, tolerance=1e-13, equilibrium="spinning", start="equilibrium")
    scene = state.model_copy(update={"responses": end, "solver": options})
    names = ["loads.spring.stiffness", "bodies.block.mass", "joints.motor.curve.coefficients.y"]
    for method, moved in same(scene, "transient", names).items():
        still = gradients_by(method, scene, names, "static")
        for name in end:
            assert moved.values[name] == pytest.approx(still.values[name], rel=1e-4)  # (h Omega)^2 / 2 of the steps
            for x in names:
                assert moved.gradients[name][x] == pytest.approx(still.gradients[name][x], rel=5e-3, abs=1e-6), (method, name, x)
