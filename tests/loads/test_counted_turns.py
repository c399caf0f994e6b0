"""Rotational springs and motors in space beyond half a turn: an axis does not say how often a body has turned."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ffrf
from ffrf import plane, space
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.transient import simulate
from toolkit.api.check import check_load
from toolkit.foundation.errors import ConvergenceError
from toolkit.system.system import compile_scene

INERTIA, STIFFNESS, DAMPING = 0.5, 20.0, 0.3
Z = (0.0, 0.0, 1.0)
PLACE: dict[str, Any] = {"bodies": ("rotor", "ground"), "point": "O"}
HUB = {"units": "m-kg-s", "dimension": 3, "points": {"O": space.Point(x=0.3, y=-0.2, z=0.1)}}
COUNTING = space.RotationalSpringDamper(**PLACE, axis=Z, stiffness=STIFFNESS, rest_angle=20.0, counts_turns=True)


def wheel(options: dict[str, Any], **loads: Any) -> ffrf.Scene:
    """A rotor on its axle."""
    return ffrf.Scene(
        **HUB,
        bodies={"rotor": space.Rigid(mass=1.0, inertia=(0.3, 0.4, INERTIA), center="O")},
        joints={"axle": space.Revolute(**PLACE, axis=Z)},
        loads=loads,
        responses={"angle": space.RelativeAngle(**PLACE, axis=Z)},
        solver=options,
    )


def angle_of(scene: ffrf.Scene) -> float:
    return float(ffrf.compile(scene).simulate().values["angle"])


def test_a_wound_spring_swings_over_turns_as_its_closed_form():
    """20 (1 - cos w t) at a quarter of the swing, where it is fastest; errors fall with the square of the step."""
    end = np.pi / np.sqrt(STIFFNESS / INERTIA) / 2
    errors = [abs(angle_of(wheel({"end_time": end, "step": end / steps}, spring=COUNTING)) - 20.0) for steps in (250, 500)]
    assert errors[1] < 0.01  # 20 rad in 500 steps, of up to 0.06 rad
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


def test_the_state_stays_by_the_angle_whose_turns_it_counts():
    """Within the error of the steps, (0.25 rad)^2 / 12, over sixty turns."""
    blow = space.Torque(**{"body": "rotor", "point": "O"}, torque=(0.0, 0.0, 10.0))
    slack = COUNTING.model_copy(update={"stiffness": 0.0, "rest_angle": 0.0})
    scene = wheel({"end_time": 6.0, "step": 0.002}, spring=slack, blow=blow)
    solution = simulate(compile_scene(scene))
    look = scene.responses["angle"].instants(solution)
    angles = np.array([look(step).value for step in range(len(solution.times))])
    assert angles[-1] == pytest.approx(360.0, rel=1e-2)  # M t^2 / (2 I), with the error of the steps
    assert np.abs(solution.q[:, -1] - angles).max() < 0.01


def test_gradients_are_those_of_a_complex_step():
    options = {"end_time": 0.1, "step": 0.005, "tolerance": 1e-13}  # to 4 rad
    scene = wheel(options, spring=COUNTING.model_copy(update={"damping": DAMPING}))
    paths = [f"loads.spring.{name}" for name in ("stiffness", "damping", "rest_angle")]
    by = {how: gradients_by(how, scene, paths, "transient").gradients["angle"] for how in ("direct", "adjoint", "complex-step")}
    assert by["adjoint"] == pytest.approx(by["direct"], rel=1e-10)
    assert by["complex-step"] == pytest.approx(by["direct"], rel=1e-10)


def test_its_formula_holds_at_any_state():
    check_load(COUNTING, wheel({}))


def test_what_the_spring_gives_is_what_moves():
    scene = wheel({"end_time": 0.4, "step": 0.0005}, spring=COUNTING)
    responses = {"work": space.Work(load="spring"), "energy": space.KineticEnergy()}
    run = ffrf.compile(scene.model_copy(update={"responses": responses})).simulate()
    assert run.values["work"] == pytest.approx(run.values["energy"], rel=1e-3)  # (0.0005 / 0.16)^2 of the trapezoidal rule
    assert run.verdict.trusted


@pytest.mark.parametrize("torque", [30.0, 400.0, -600.0])
def test_an_equilibrium_is_wound_by_its_torque_over_its_stiffness(torque):
    wound = wheel(
        {},
        spring=COUNTING.model_copy(update={"rest_angle": 0.0}),
        drive=space.Torque(body="rotor", point="O", torque=(0, 0, torque)),
    )
    run = ffrf.compile(wound).statics()
    assert run.solution.q[0, -1] == pytest.approx(torque / STIFFNESS, rel=1e-12)
    assert run.verdict.trusted
    folded = [each.text for each in run.verdict.warnings if each.code == "rotation-folded"]
    assert len(folded) == (abs(torque / STIFFNESS) > np.pi)  # the response tells no turns, the remark does
    assert all(f"it is {torque / STIFFNESS:.5g} rad" in text for text in folded)


def test_counted_turns_take_nothing_from_the_modes():
    frequency = np.sqrt(STIFFNESS / INERTIA) / (2 * np.pi)
    relaxed = wheel({}, spring=COUNTING.model_copy(update={"rest_angle": 0.0}))
    assert ffrf.compile(relaxed).modes().frequencies == pytest.approx([frequency], rel=1e-12)
    asked = relaxed.model_copy(update={"responses": {"f": space.Frequency(number=1)}})
    assert ffrf.compile(asked).statics().values["f"] == pytest.approx(frequency, rel=1e-12)


def test_a_motor_leads_over_turns_and_is_refused_where_it_stays_behind():
    def led(height: float, torque: float) -> ffrf.Scene:
        motor = space.AngleController(
            **PLACE, axis=Z, proportional_gain=20.0, derivative_gain=2.0, curve=plane.SmoothStep(height=height, duration=2.0)
        )
        drag = space.Torque(body="rotor", point="O", torque=(0.0, 0.0, torque))
        return wheel({"end_time": 8.0, "step": 0.01}, motor=motor, drag=drag)

    assert angle_of(led(20.0, 0.0)) == pytest.approx(20.0, abs=1e-4)  # exp(-2 * 6) of 20 rad
    with pytest.raises(ConvergenceError, match=r"angle-controller 'motor' stays half a turn behind at t = .* more closely"):
        angle_of(led(20.0, -90.0))


def test_a_spring_without_a_count_is_refused_with_what_to_write_and_a_damper_needs_none():
    plain = COUNTING.model_copy(update={"counts_turns": False})
    with pytest.raises(ConvergenceError, match=r"spring-damper 'spring' turns beyond half a turn .*counts_turns = true"):
        angle_of(wheel({"end_time": 0.5, "step": 0.002}, spring=plain))
    drive = space.Torque(body="rotor", point="O", torque=(0.0, 0.0, 3.0))
    damper = space.RotationalSpringDamper(**PLACE, axis=Z, damping=DAMPING)
    angle = angle_of(wheel({"end_time": 10.0, "step": 0.01}, damper=damper, drive=drive))
    lag = INERTIA / DAMPING
    assert angle == pytest.approx(10.0 * (10.0 - lag * (1 - np.exp(-10.0 / lag))), rel=1e-3)  # steps of 0.1 rad


def test_a_spring_that_turns_half_round_within_a_step_is_not_trusted():
    """Nothing tells there how often it has turned; halves of such steps end elsewhere, and the verdict says so."""
    with pytest.raises(ConvergenceError, match=r"turn|step"):
        ffrf.compile(wheel({"end_time": 1.0, "step": 0.05, "halvings": 0}, spring=COUNTING)).simulate()
    assert {"steps", "halved-steps"} <= {
        *ffrf.compile(wheel({"end_time": 1.0, "step": 0.05}, spring=COUNTING)).simulate().verdict.codes
    }
