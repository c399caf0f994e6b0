"""Angles beyond half a turn: drivers follow them, in motion and statics; springs count turns or refuse them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.spatial.scenes import at
from toolkit.analyses.modes import solve_modes
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import SpatialRigid
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import SpatialAngleDriver
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.loads.springs import SpatialRotationalSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError
from toolkit.foundation.kinematics.orientation import matrix_of
from toolkit.responses.motion import Rotation
from toolkit.responses.over_time import TimeMean
from toolkit.responses.relative_angle import RelativeAngle
from toolkit.responses.vibration import Frequency
from toolkit.scene.scene import Scene
from toolkit.solvers.half_turns import half_turn
from toolkit.system.system import compile_scene

Z = (0.0, 0.0, 1.0)


def arm(**more) -> Scene:
    """A body on a hinge about z."""
    hinge = SpatialRevolute(bodies=("arm", "ground"), point="O", axis=Z)
    body = SpatialRigid(mass=2.0, inertia=(0.1, 0.2, 0.2), center="C", **more.pop("body", {}))
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(O=(0, 0, 0), C=(0.5, 0, 0)),
        bodies={"arm": body},
        joints={"hinge": hinge, **more.pop("joints", {})},
        solver=RunOptions(end_time=1.0, step=0.005),
        **more,
    )


def driven(angle: float) -> Scene:
    curve = SmoothStep(height=angle, duration=1.0)
    return arm(joints={"drive": SpatialAngleDriver(bodies=("arm", "ground"), point="O", axis=Z, curve=curve)})


@pytest.mark.parametrize("angle", [3.5, 7.0, -9.0])
@pytest.mark.parametrize("solve", [solve_statics, simulate])
def test_a_driver_turns_as_often_as_its_curve_says(solve, angle):
    """To 1e-4 in motion: joints are stabilised by their accelerations; of the last turn alone, as the attitude tells no more."""
    solution = solve(compile_scene(driven(angle)))
    A = matrix_of(solution.q[-1, 3:])
    np.testing.assert_allclose([A[0, 0], A[1, 0]], [np.cos(angle), np.sin(angle)], atol=1e-4)
    ahead = solution.q[:, 3]  # cos of half the angle: it changes sign once a turn
    if solve is simulate:
        assert np.count_nonzero(np.diff(np.sign(ahead))) == round(abs(angle) / (2 * np.pi))


@pytest.mark.parametrize(("angle", "folded"), [(3.0, False), (3.5, True), (-9.0, True)])
def test_a_rotation_that_is_folded_is_told(angle, folded):
    turn = Rotation(body="arm", point="O", axis=Z)
    responses = {"turn": turn, "mean": TimeMean(of=turn)}
    found = direct(driven(angle).model_copy(update={"responses": responses}), [], "transient")
    told = [(each.doubt, each.text.partition(" passed")[0]) for each in found.verdict.warnings if each.code == "rotation-folded"]
    assert told == [(True, "the rotation that mean is made of"), (False, "turn")] * folded
    assert found.values["turn"] == pytest.approx((angle + np.pi) % (2 * np.pi) - np.pi, abs=1e-4)


def test_a_spring_that_turns_beyond_half_a_turn_is_refused_with_the_time():
    spring = SpatialRotationalSpringDamper(bodies=("arm", "ground"), point="O", axis=Z, stiffness=0.1)
    body = {"angular_velocity": (0.0, 0.0, 6.0), "velocity": (0.0, 3.0, 0.0)}
    with pytest.raises(ConvergenceError, match=r"'coil' turns beyond half a turn at t = 0\.5.*counts_turns = true"):
        simulate(compile_scene(arm(body=body, loads={"coil": spring})))


STIFFNESS, TURNING = 3.0, 0.2 + 2 * 0.5**2
"""Of a spring in N m/rad, and of the arm about its hinge in kg m^2."""


def counting(loads=(), **more) -> Scene:
    """The arm on a spring that counts turns."""
    spring = SpatialRotationalSpringDamper(bodies=("arm", "ground"), point="O", axis=Z, stiffness=STIFFNESS, counts_turns=True)
    return arm(loads={"coil": spring, **dict(loads)}, **more)


@pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])
def test_a_spring_that_counts_turns_swings_by_its_closed_form(formulation):
    """10 rad there and back: 10 sin(w t), and its derivative by k of w; half the step leaves a quarter of the errors, or less."""
    rate = np.sqrt(STIFFNESS / TURNING)
    slope = 10 * (np.cos(rate) - np.sin(rate) / rate) * rate / (2 * STIFFNESS)  # at the same velocity
    scene, errors = counting(body={"angular_velocity": (0.0, 0.0, 10 * rate)}), []
    for step in (0.004, 0.002):
        responses = {"turn": RelativeAngle(bodies=("arm", "ground"), point="O", axis=Z)}
        options = RunOptions(end_time=1.0, step=step, formulation=formulation)
        found = direct(
            scene.model_copy(update={"responses": responses, "solver": options}), ["loads.coil.stiffness"], "transient"
        )
        assert found.verdict.trusted
        gradient = found.gradients["turn"]["loads.coil.stiffness"]
        errors.append([found.values["turn"] - 10 * np.sin(rate), gradient - slope])
    coarse, fine = np.abs(errors)
    assert np.all(fine < 5e-3)  # of some 10 rad, and rad per N m/rad
    assert np.all(coarse / fine > 3.5)


@pytest.mark.parametrize("turned", [-9.0, 9.0, 20.0])
def test_an_equilibrium_and_its_vibration_count_turns_too(turned):
    """k angle = T, to round-off; the frequency is that of the arm on the spring, whatever the turns."""
    torque = SpatialTorque(body="arm", point="O", torque=(0.0, 0.0, STIFFNESS * turned))
    responses = {"turn": Rotation(body="arm", point="O", axis=Z), "slowest": Frequency(number=1)}
    scene = counting({"wind": torque}).model_copy(update={"responses": responses})
    found = direct(scene, ["loads.coil.stiffness", "loads.wind.torque.2"], "static")
    folded = (turned + np.pi) % (2 * np.pi) - np.pi
    assert found.values["turn"] == pytest.approx(folded, abs=1e-12)
    assert list(found.gradients["turn"].values()) == pytest.approx([-turned / STIFFNESS, 1 / STIFFNESS], rel=1e-11)
    frequency = np.sqrt(STIFFNESS / TURNING) / (2 * np.pi)
    assert found.values["slowest"] == pytest.approx(frequency, rel=1e-12)
    assert solve_modes(found.solution).frequencies == pytest.approx([frequency], rel=1e-12)


def test_turns_that_a_step_hides_are_refused():
    solution = simulate(compile_scene(counting(body={"angular_velocity": (0.0, 0.0, 20.0)})))
    q = np.pad(solution.q, ((0, 0), (0, solution.system.n - solution.system.n_q)))
    none = np.zeros((len(q), 0, 3))
    assert half_turn(solution.system, q, lambda: none) is None
    what, why, step = half_turn(solution.system, q[::50], lambda: none)
    assert "more than half a turn between two states" in what
    assert step == 1
    assert "Use smaller steps" in why
