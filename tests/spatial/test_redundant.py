"""Joints that repeat each other: named where they are refused; on request left out of the motion, with joint forces of least squares."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import null_space

from tests.models.directions import along, derivative_along, direction
from tests.spatial.scenes import at
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import SpatialRigid, SpatialRod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import SpatialAngleDriver
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.spherical import Spherical
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.torque import SpatialTorque
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.responses.joint_force import JointForce, SpatialJointForce
from toolkit.responses.least_squares_forces import JointWrenches
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.scene.space import SPACE
from toolkit.system.redundant_joints import joint_terms
from toolkit.system.redundant_rows import independent_rows
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance

Z = (0.0, 0.0, 1.0)
MASS, WIDTH, HEIGHT, GRAVITY, TORQUE = 15.0, 1.0, 2.0, 9.81, 5.0
CUBE = {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, -1, 0), "D": (1, -1, 1), "E": (0, -1, 1), "F": (0, 0, 1)}
AXES = {"A": (0.0, 1.0, 0.0), "B": Z, "C": (1.0, 0.0, 0.0), "D": (0.0, 1.0, 0.0), "E": Z, "F": (1.0, 0.0, 0.0)}


def door(redundant: str, upper: type = SpatialRevolute, **joints) -> Scene:
    """A door on two hinges, pushed by a torque about them."""
    hinges = {"lower": SpatialRevolute(bodies=("door", "ground"), point="A", axis=Z)}
    axis = {"axis": Z} if upper is SpatialRevolute else {}
    hinges["upper"] = upper(bodies=("door", "ground"), point="B", **axis)
    forces = {
        f"{joint}-{c}": JointForce(joint=joint, component=c) for joint in hinges for c in ("x", "y", "z", "torque-x", "torque-y")
    }
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(A=(0, 0, 0), B=(0, 0, HEIGHT), C=(WIDTH / 2, 0, HEIGHT / 2)),
        bodies={"door": SpatialRigid(mass=MASS, inertia=(5.0, 6.25, 1.25), center="C")},
        joints={**hinges, **joints},
        loads={
            "weight": SpatialGravity(acceleration=(0.0, 0.0, -GRAVITY)),
            "push": SpatialTorque(body="door", point="C", torque=(0.0, 0.0, TORQUE)),
        },
        responses={**forces, "angle": Rotation(body="door", point="C", axis=Z)},
        solver=RunOptions(end_time=0.2, step=0.01, redundant=redundant),  # type: ignore[arg-type]
    )


def bricard(redundant: str, step: float) -> Scene:
    """Five rods and the ground along the edges of a cube, six hinges: one motion, though the count of constraints leaves none."""
    rods = [("A", "B"), ("B", "C"), ("C", "D"), ("D", "E"), ("E", "F")]
    bodies = {f"rod-{a}{b}": SpatialRod(between=(a, b), area=1e-3, density=1e4) for a, b in rods}
    order = ["ground", *bodies, "ground"]
    joints = {
        f"hinge-{point}": SpatialRevolute(bodies=(first, second), point=point, axis=AXES[point])
        for point, (first, second) in zip(CUBE, pairwise(order), strict=True)
    }
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=at(**CUBE),
        bodies=bodies,
        joints=joints,
        loads={"weight": SpatialGravity(acceleration=(0.0, -9.81, 0.0))},
        solver=RunOptions(end_time=1.0, step=step, rho_inf=0.9, redundant=redundant),  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module")
def opened() -> Solution:
    return simulate(compile_scene(door("least-squares")))


def response(solution: Solution, name: str) -> float:
    return float(solution.system.scene.responses[name].partials(solution).value)


def test_a_door_on_two_hinges_is_refused_and_both_hinges_are_named():
    with pytest.raises(SingularSystemError, match=r"lower.*upper.*least-squares"):
        simulate(compile_scene(door("refuse")))


def test_the_door_turns_as_it_does_on_one_hinge_and_a_ball(opened):
    """Theta phi'' = M with the moment of inertia about the hinges: a closed form that the scheme meets to the last digits."""
    inertia = 1.25 + MASS * (WIDTH / 2) ** 2
    assert response(opened, "angle") == pytest.approx(TORQUE / inertia * 0.2**2 / 2, rel=1e-4)  # second order in the step
    assert opened.drift < 1e-7  # rows that were dropped stay closed too: as index 1 leaves the others


def test_two_hinges_share_the_load_as_least_squares_says(opened):
    """The least sum of squares splits the weight in two halves; its moment is carried by forces and torques in the ratio of their arms."""
    assert response(opened, "lower-z") + response(opened, "upper-z") == pytest.approx(MASS * GRAVITY, rel=1e-9)
    assert response(opened, "lower-z") == pytest.approx(response(opened, "upper-z"), rel=0.01)  # the door has moved a little
    assert response(opened, "lower-torque-x") == pytest.approx(response(opened, "upper-torque-x"), abs=1e-9)
    arm = (response(opened, "upper-x") - response(opened, "lower-x")) * HEIGHT / 2
    moment = arm + response(opened, "lower-torque-y") + response(opened, "upper-torque-y")
    assert moment == pytest.approx(-MASS * GRAVITY * WIDTH / 2, rel=0.01)  # likewise


def wrenches(solution: Solution, multipliers: np.ndarray | None = None) -> np.ndarray:
    """Forces, times the distance of the hinges, and torques of both hinges at the end."""
    system, lam = solution.system, solution.multipliers[-1] if multipliers is None else multipliers
    scale = np.repeat([HEIGHT, 1.0], 3)
    return np.concatenate([scale * SpatialJointForce(system, j)(solution.q[-1], lam)[0] for j in range(2)])


def test_no_other_forces_that_balance_the_door_have_a_smaller_sum_of_squares(opened):
    """Against the least squares of numpy over all multipliers that put the same forces on the door."""
    system, scene = opened.system, opened.system.scene
    acc = np.concatenate([np.zeros(system.n_q), opened.multipliers[-1]])
    q = np.concatenate([opened.q[-1], 0 * opened.multipliers[-1]])
    phi_q = system.matrix(joint_terms(system, q, acc).I_acc).toarray()[system.n_q :, : system.n_q]
    free = null_space(phi_q.T, rcond=1e-9)
    G = np.column_stack([wrenches(opened, column) for column in free.T])
    least = wrenches(opened) - G @ np.linalg.lstsq(G, wrenches(opened), rcond=None)[0]
    scale = np.repeat([HEIGHT, 1.0], 3)
    ours = [JointForce(joint=j, component=c) for j in scene.joints for c in SPACE.wrench]
    found = np.array([force.partials(opened).value for force in ours]) * np.tile(scale, 2)
    np.testing.assert_allclose(found, least, atol=1e-7 * np.abs(least).max())  # the constraints hold to 1e-8


@pytest.mark.parametrize("more", ["a rod far away", "a point far away"])
def test_joint_forces_do_not_depend_on_what_touches_nothing(opened, more):
    scene = door("least-squares")
    update = {"points": {**scene.points, **at(P=(20, 0, 0), Q=(21, 0, 0))}}
    if more == "a rod far away":
        update["bodies"] = {**scene.bodies, "rod": SpatialRod(between=("P", "Q"), area=1e-3, density=1e4)}
    solution = simulate(compile_scene(scene.model_copy(update=update)))
    for joint in ("lower", "upper"):
        for c in SPACE.wrench:
            force = JointForce(joint=joint, component=c)
            assert force.partials(solution).value == pytest.approx(force.partials(opened).value, abs=1e-6)  # of 150 N
    of_checks = [JointWrenches(each).at(each.steps)[:, 0] for each in (solution, opened)]
    np.testing.assert_allclose(*of_checks, rtol=0, atol=1e-6)
    ours = [
        [JointForce(joint=joint, component=c).partials(opened).value for c in SPACE.wrench]
        for joint in opened.system.scene.joints
    ]
    np.testing.assert_allclose(of_checks[1], ours, rtol=0, atol=1e-6)


@pytest.mark.parametrize("change", ["tilted", "swapped"])
def test_joint_forces_do_not_depend_on_how_the_hinges_are_written(opened, change):
    """A tilt by round-off turns the normals of the axis anywhere; a hinge written the other way round has the opposite force."""
    scene = door("least-squares")
    update = {"axis": (1e-14, 0.0, 1.0)} if change == "tilted" else {"bodies": ("ground", "door")}
    lower = scene.joints["lower"].model_copy(update=update)
    solution = simulate(compile_scene(scene.model_copy(update={"joints": {**scene.joints, "lower": lower}})))
    sign = 1 if change == "tilted" else -1
    for c in SPACE.wrench:
        for joint, by in (("lower", sign), ("upper", 1)):
            force = JointForce(joint=joint, component=c)
            assert force.partials(solution).value == pytest.approx(by * force.partials(opened).value, abs=1e-6)  # of 150 N


def test_a_variable_that_would_jam_the_door_is_refused():
    with pytest.raises(InputError, match=r"joints\.lower\.axis\.0.*jam"):
        compile_scene(door("least-squares"), ["points.C.x", "joints.lower.axis.0"])


def test_hinges_that_nearly_fit_are_refused():
    scene = door("least-squares")
    lower = scene.joints["lower"].model_copy(update={"axis": (1e-6, 0.0, 1.0)})
    with pytest.raises(InputError, match="not exactly"):
        compile_scene(scene.model_copy(update={"joints": {**scene.joints, "lower": lower}}))


def test_gradients_of_redundant_joints_agree_by_all_methods():
    """To 1e-8: round-off of the accelerations, amplified by Baumgarte's 1/step."""
    scene, variables = door("least-squares"), ["points.B.z", "points.C.x", "bodies.door.mass", "loads.push.torque.2"]
    found = [gradients_by(method, scene, variables, "transient") for method in ("direct", "adjoint")]
    results = [each.gradients for each in found]
    factors = direction(variables)
    judge = derivative_along(scene, factors, "transient", found[0].solution)
    for name in ("lower-x", "upper-z", "lower-torque-y", "angle"):
        direct, adjoint = (result[name] for result in results)
        largest = max(map(abs, direct.values()))
        assert adjoint == pytest.approx(direct, rel=1e-8, abs=1e-8 * largest)
        assert along(direct, factors) == pytest.approx(judge[name], rel=0, abs=1e-8 * largest)


def test_a_driver_of_what_other_joints_hold_is_refused():
    drive = SpatialAngleDriver(
        bodies=("door", "ground"), point="A", axis=(1.0, 0.0, 0.0), curve=SmoothStep(height=1.0, duration=0.1)
    )
    with pytest.raises(InputError, match="drives what other joints already determine"):
        compile_scene(door("least-squares", drive=drive))


def test_bricards_linkage_moves_and_keeps_its_energy():
    """Second order: half the step, a quarter of the energy's error."""
    defects = []
    for step in (0.01, 0.005):
        solution = simulate(compile_scene(bricard("least-squares", step)))
        assert len(solution.system.plan.dropped) == 1  # Maxwell's count: thirty rows, one motion, so one too many
        assert np.ptp(solution.q[:, :3]) > 0.1
        defects.append(energy_balance(solution).relative_defect)
    assert defects[1] < 0.35 * defects[0]


def test_bricards_linkage_is_refused_unless_asked_for():
    with pytest.raises(SingularSystemError, match="repeat or contradict"):
        simulate(compile_scene(bricard("refuse", 0.01)))


def test_only_what_repeats_is_dropped():
    """A hinge holds all points of its axis, so that a ball there repeats three directions; a lone hinge repeats nothing."""
    both = door("least-squares", Spherical)
    assert len(compile_scene(both).plan.dropped) == 3
    lone = both.model_copy(update={"joints": {"lower": both.joints["lower"]}, "responses": {}})
    assert len(compile_scene(lone).plan.dropped) == 0


def test_rows_that_come_first_are_never_dropped():
    rows = np.array([[1.0, 0, 0], [0, 2, 0], [3, 4, 0]])
    assert independent_rows(rows, np.ones(3), np.array([2])).repeating.tolist() in ([0], [1])
