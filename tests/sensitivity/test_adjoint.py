"""The discrete adjoint: the same gradients as direct differentiation, by a formulation that shares no line of the recursion."""

from __future__ import annotations

import pytest

from tests.models.scenes import HANGING_DESIGN, WING, hanging_skin
from toolkit.analyses.sensitivity.adjoint import adjoint_gradients
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import TimeIntegral

ROUND_OFF = 1e-9
"""Both methods are exact for the discrete equations; what differs is round-off, times the condition of the skin's equations."""

VALUES = 1e-11
"""Two runs of the same equations, of which one carries gradients: forces of joints have round-off of positions by 1 / h^2. Runs that never
stop before round-off differ by 3e-12 in a moment."""


def agree(scene, design, kind, small=1e-12):
    ours, exact = gradients_by("adjoint", scene, design, kind), direct(scene, design, kind)
    assert ours.values == pytest.approx(exact.values, rel=VALUES)
    for name, slopes in exact.gradients.items():
        largest = max(abs(slope) for slope in slopes.values())
        # a derivative far below a response's others is made of their round-off
        assert ours.gradients[name] == pytest.approx(slopes, rel=ROUND_OFF, abs=small * largest), name


@pytest.mark.parametrize("kind", ["static", "transient"])
def test_gradients_of_the_wing(kind):
    scene = read_scene(WING)
    agree(scene, list(scene.design), kind)


@pytest.mark.parametrize(("scheme", "rho_inf"), [("arnold-bruels", 0.3), ("paper", 0.0), ("paper", 0.8), ("arnold-bruels", 1.0)])
def test_gradients_of_every_kind_of_response_and_variable(scheme, rho_inf):
    """Moving frame, all joints, loads, curves and start values; `paper` carries terms from step to step."""
    scene = hanging_skin()
    solver = scene.solver.model_copy(update={"scheme": scheme, "rho_inf": rho_inf})
    agree(scene.model_copy(update={"solver": solver}), HANGING_DESIGN, "transient", 1e-10)


def test_gradients_by_start_velocities():
    """They enter through the start alone, where the joints find all other velocities."""
    responses = {"turn": Rotation(body="arm", point="O"), "force": JointForce(joint="C", component="x", time=0.0)}
    scene = hanging_skin(responses=responses)
    bodies = {
        name: body.model_copy(update={"angular_velocity": 3.0} if name != "skin" else {}) for name, body in scene.bodies.items()
    }
    design = ["bodies.arm.angular_velocity", "bodies.block.angular_velocity"]
    agree(scene.model_copy(update={"bodies": bodies}), design, "transient")


def test_a_length_that_starts_at_zero_is_referred_to_the_direct_method():
    scene = hanging_skin(responses={"way": TimeIntegral(of=Displacement(body="arm", point="C", component="magnitude"))})
    with pytest.raises(InputError, match=r"no derivatives of q.*Use the direct method"):
        gradients_by("adjoint", scene, ["points.O.x"], "transient")


def test_an_unknown_method_lists_the_known_ones():
    with pytest.raises(InputError, match=r"unknown method 'magic'; available: auto, direct, adjoint, complex-step"):
        gradients_by("magic", read_scene(WING), ["t_w"], "static")


def test_a_run_with_options_of_its_own_is_differentiated_as_it_was_run():
    scene, names = hanging_skin(), ["points.O.x", "loads.drive.torque"]
    options = RunOptions(end_time=0.01, step=0.0005, scheme="paper", rho_inf=0.3)
    system = prepare(scene, names)
    exact = simulate(system, options)
    found, gradient = adjoint_gradients(system, simulate(prepare(scene), options))
    for r, name in enumerate(found):
        # round-off, as above
        assert gradient[:, r] == pytest.approx(scene.responses[name].gradient(exact), rel=ROUND_OFF), name


def test_a_run_with_a_start_of_its_own_is_referred_to_the_direct_method():
    system = prepare(hanging_skin(), ["points.O.x"])
    with pytest.raises(InputError, match=r"start of its own.*Use the direct method"):
        adjoint_gradients(system, simulate(system, v=0 * system.start()[1][: system.n_q]))


def test_without_responses_there_is_nothing_to_do():
    scene = read_scene(WING).model_copy(update={"responses": {}})
    assert gradients_by("adjoint", scene, ["t_w"], "static").gradients == {}


def test_with_the_direct_solution_at_hand_a_length_that_starts_at_zero_is_no_obstacle():
    """As `certify` does it: the direct derivatives tell that the length is zero whatever the design."""
    scene = hanging_skin(responses={"way": TimeIntegral(of=Displacement(body="arm", point="C", component="magnitude"))})
    solution = simulate(prepare(scene, ["loads.drive.torque"]))
    _, gradient = adjoint_gradients(solution.system, solution)
    assert gradient[:, 0] == pytest.approx(scene.responses["way"].gradient(solution), rel=ROUND_OFF)
