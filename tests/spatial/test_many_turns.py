"""Angles beyond half a turn: drivers follow them, in motion and statics; springs refuse them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.spatial.scenes import at
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.bodies.spatial.rigid import SpatialRigid
from toolkit.curves.kinds.smooth_step import SmoothStep
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError
from toolkit.joints.both.driver import SpatialAngleDriver
from toolkit.joints.spatial.revolute import SpatialRevolute
from toolkit.kinematics.spatial import matrix_of
from toolkit.loads.spatial.rotational_spring_damper import SpatialRotationalSpringDamper
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.sensitivity.direct import direct
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
    found = direct(driven(angle).model_copy(update={"responses": {"turn": turn}}), [], "transient")
    assert ("rotation-folded" in found.verdict.codes) == folded
    assert found.values["turn"] == pytest.approx((angle + np.pi) % (2 * np.pi) - np.pi, abs=1e-4)


def test_a_spring_that_turns_beyond_half_a_turn_is_refused_with_the_time():
    spring = SpatialRotationalSpringDamper(bodies=("arm", "ground"), point="O", axis=Z, stiffness=0.1)
    body = {"angular_velocity": (0.0, 0.0, 6.0), "velocity": (0.0, 3.0, 0.0)}
    with pytest.raises(ConvergenceError, match=r"'coil' turns beyond half a turn at t = 0\.5"):
        simulate(compile_scene(arm(body=body, loads={"coil": spring})))
