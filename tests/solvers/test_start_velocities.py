"""Velocities at the start: what is written holds or is refused with both numbers, what is not written is found by the joints."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.starts import derivatives_agree, started
from toolkit.analyses.modes import undeformed
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.oscillation import Sine
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import scene_from_table
from toolkit.foundation.errors import InputError
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.start_cautions import cautions_of_start, moved_bodies, start_lines, start_record, start_state

EXACT = 1e-12
"""Round-off of a solve, of velocities of order one; for derivatives, judged by a complex step, 1e-10."""
PLACES = {"O": (0.0, 0.0), "A": (0.1, 0.3), "B": (0.87, 0.71), "C": (1.0, 0.0)}


def four_bar(solver: dict[str, Any] | None = None, **motion: dict[str, Any]) -> Scene:
    """Crank OA, coupler AB, rocker CB; `motion` is what is written of each bar's velocity."""
    bars = {"crank": ("O", "A"), "coupler": ("A", "B"), "rocker": ("C", "B")}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in PLACES.items()},
        bodies={name: Rod(between=ends, area=1e-4, density=7800.0, **motion.get(name, {})) for name, ends in bars.items()},
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "A": Revolute(bodies=("crank", "coupler"), point="A"),
            "B": Revolute(bodies=("coupler", "rocker"), point="B"),
            "C": Revolute(bodies=("rocker", "ground"), point="C"),
        },
        solver=RunOptions(**({"end_time": 0.01, "step": 0.001} | (solver or {}))),
    )


def kinematics(omega: float) -> np.ndarray:
    """Velocities of the three bars for a rate of the crank, by v_B = v_A + w x r, from the plane geometry of the linkage alone."""
    A, B, C = (np.array(PLACES[name]) for name in "ABC")  # from O, the origin

    def across(vector: np.ndarray) -> np.ndarray:
        return np.array([-vector[1], vector[0]])

    of_coupler, of_rocker = np.linalg.solve(np.column_stack([across(B - A), -across(B - C)]), -omega * across(A))
    v_A, v_B = omega * across(A), of_rocker * across(B - C)
    return np.concatenate([[*v_A / 2, omega], [*(v_A + v_B) / 2, of_coupler], [*v_B / 2, of_rocker]])


def velocities(scene: Scene) -> np.ndarray:
    system, state = started(scene)
    return state.v[: system.n_q]


# --- what is written holds ------------------------------------------------------------------------------------------------------


def test_a_crank_that_is_given_six_radians_per_second_starts_with_them_and_the_joints_find_the_rest():
    np.testing.assert_allclose(velocities(four_bar(crank={"angular_velocity": 6.0})), kinematics(6.0), atol=EXACT)


def test_written_velocities_of_several_bodies_that_fit_hold():
    right = kinematics(6.0)
    motion = {
        name: {"velocity": tuple(map(float, right[k : k + 3]))} for name, k in (("crank", 0), ("coupler", 3), ("rocker", 6))
    }
    np.testing.assert_allclose(velocities(four_bar(**motion)), right, atol=EXACT)
    del motion["coupler"]
    np.testing.assert_allclose(velocities(four_bar(**motion)), right, atol=EXACT)


def test_the_order_of_the_bodies_does_not_decide():
    scene = four_bar(
        rocker={"angular_velocity": 2.0}, coupler={"angular_velocity": float(kinematics(1.0)[5] * 2 / kinematics(1.0)[8])}
    )
    for order in permutations(scene.bodies):
        system, state = started(scene.model_copy(update={"bodies": {name: scene.bodies[name] for name in order}}))
        rates = {name: state.v[system.numbering.first[name] + 2] for name in order}
        expected = kinematics(2.0 / kinematics(1.0)[8])
        assert rates == pytest.approx({"crank": expected[2], "coupler": expected[5], "rocker": 2.0}, abs=EXACT)


def test_nothing_moves_where_nothing_is_written():
    assert not np.any(velocities(four_bar()))


def test_least_motion_decides_what_neither_words_nor_joints_do():
    """A rod that is pushed at one end with v, free otherwise, turns about the centre of percussion: 2 L / 3 from that end."""
    scene = Scene(
        units="m-kg-s",
        points={"P": Point(x=0.0, y=0.0), "Q": Point(x=3.0, y=0.0), "R": Point(x=-1.0, y=0.0)},
        bodies={
            "rod": Rod(between=("P", "Q"), area=1.0, density=1.0),
            "block": Rigid(mass=1e-3, inertia=1.0, center="R", velocity=(0.0, 1.0, 0.0)),
        },
        joints={"pin": Revolute(bodies=("block", "rod"), point="P")},
    )
    _, state = started(scene)
    np.testing.assert_allclose(state.v[:6], [0, 0.25, -0.5, 0, 1, 0], atol=EXACT)


# --- or is refused with both numbers --------------------------------------------------------------------------------------------


def test_a_zero_that_is_written_counts():
    """The crank's middle cannot stay where it is while the crank turns."""
    x = kinematics(6.0)[0]
    with pytest.raises(
        InputError, match=rf"bodies\.crank\.velocity\.0 is written as 0 m/s at the start, but .* allow {x:.9g} m/s.*found"
    ):
        velocities(four_bar(crank={"velocity": (0.0, 0.0, 6.0)}))


def test_two_rates_that_contradict_are_refused_with_the_one_that_fits():
    allowed = kinematics(6.0)[8]
    with pytest.raises(
        InputError, match=rf"bodies\.rocker\.angular_velocity is written as 1 rad/s .* allow {allowed:.8g}\d* rad/s"
    ):
        velocities(four_bar(crank={"angular_velocity": 6.0}, rocker={"angular_velocity": 1.0}))


def test_a_rate_that_contradicts_a_driver_is_refused():
    scene = four_bar(crank={"angular_velocity": 6.0})
    curve = Sine(amplitude=0.5, frequency=1.0)
    scene = scene.model_copy(
        update={"joints": {**scene.joints, "drive": AngleDriver(bodies=("crank", "ground"), point="O", curve=curve)}}
    )
    with pytest.raises(InputError, match=r"bodies\.crank\.angular_velocity is written as 6 rad/s .* allow 3\.14159265 rad/s"):
        velocities(scene)


@pytest.mark.parametrize(("digits", "fits"), [(8, True), (4, False)])
def test_written_digits_are_enough_or_refused(digits, fits):
    motion = {"coupler": {"velocity": tuple(float(f"{x:.{digits}g}") for x in kinematics(6.0)[3:6])}}
    if fits:
        np.testing.assert_allclose(velocities(four_bar(**motion)), kinematics(6.0), atol=10 ** (1 - digits))
    else:
        with pytest.raises(InputError, match=r"bodies\.coupler\.velocity\.\d is written as"):
            velocities(four_bar(**motion))


def test_velocities_given_as_a_start_of_their_own_fit_or_are_refused():
    system = compile_scene(four_bar())
    np.testing.assert_allclose(simulate(system, v=kinematics(6.0)).v[0], kinematics(6.0), atol=EXACT)
    with pytest.raises(
        InputError, match=r"given as a start contradict the joints: that of .* is .*, and .* in the nearest motion"
    ):
        simulate(system, v=kinematics(6.0) * (np.arange(9) != 8))


def test_one_rotation_is_written_once():
    with pytest.raises(ValueError, match="third number of `velocity` is the angular velocity already"):
        Rod(between=("O", "A"), area=1.0, density=1.0, velocity=(0.0, 0.0, 1.0), angular_velocity=1.0)


def test_velocities_that_are_not_written_are_no_numbers_of_the_scene():
    scene = four_bar(crank={"angular_velocity": 6.0})
    assert [path for path in scene.available_paths() if "velocity" in path] == ["bodies.crank.angular_velocity"]
    with pytest.raises(InputError, match=r"no number 'bodies\.rocker\.velocity\.2'"):
        scene.number("bodies.rocker.velocity.2")


# --- derivatives ----------------------------------------------------------------------------------------------------------------

GEOMETRY = ["points.A.x", "points.B.y", "points.C.x", "bodies.rocker.density"]


def test_the_start_of_a_linkage_is_differentiated():
    derivatives_agree(four_bar(crank={"angular_velocity": 6.0}), [*GEOMETRY, "bodies.crank.angular_velocity"])


@pytest.mark.parametrize("path", ["points.A.x", "bodies.crank.velocity.2"])
def test_a_variable_that_would_make_written_velocities_contradict_is_refused(path):
    motion = {"crank": {"velocity": tuple(map(float, kinematics(6.0)[:3]))}}
    with pytest.raises(
        InputError, match=rf"'{path}' would make bodies\.crank\.velocity.* contradict the joints.*`angular_velocity` alone"
    ):
        started(four_bar(**motion), [path])


def test_a_complex_step_refuses_such_a_variable_too():
    """Its step is far too small for the velocities themselves to miss."""
    scene = four_bar(crank={"velocity": tuple(map(float, kinematics(6.0)[:3]))})
    scene = scene.model_copy(update={"responses": {"turn": Rotation(body="rocker", point="C")}})
    for method in ("direct", "complex-step"):
        with pytest.raises(InputError, match=r"would make bodies\.crank\.velocity.* contradict the joints"):
            gradients_by(method, scene, ["points.A.x"], "transient")


def test_a_variable_that_leaves_written_velocities_alone_has_a_derivative():
    motion = {"crank": {"velocity": tuple(map(float, kinematics(6.0)[:3]))}}
    derivatives_agree(four_bar(**motion), ["bodies.rocker.density", "bodies.crank.area", "points.C.x"])


def test_bodies_that_assembly_moves_start_with_what_is_written_and_derivatives():
    scene = four_bar({"assemble": True}, crank={"angular_velocity": 6.0})
    bar = Distance(bodies=("crank", "rocker"), points=("A", "B"), length=0.93)
    joints = {name: joint for name, joint in scene.joints.items() if name in "OC"} | {"bar": bar}
    bodies = {name: body for name, body in scene.bodies.items() if name != "coupler"}
    opened = scene.model_copy(update={"joints": joints, "bodies": bodies})
    _, state = started(opened)
    assert state.v[2] == pytest.approx(6.0, abs=EXACT)
    derivatives_agree(opened, ["joints.bar.length", "points.A.x", "bodies.crank.angular_velocity"])


# --- flexible bodies ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("models")
    section = Section(youngs_modulus=2e11, density=7800.0, thickness=0.01, width=0.02, damping_stiffness=1e-4)
    save_beam(directory / "beam.h5", np.column_stack([np.linspace(0, 1, 5), np.zeros(5)]), section, {"root": 0.0, "tip": 1.0})
    return directory


def arm(folder, pinned: bool = False, **motion) -> Scene:
    """A crank that a beam is welded to; or a beam on a hinge, whose tip is pinned to the ground too."""
    crank = {} if pinned else {"crank": Rigid(mass=0.1, inertia=1e-3, center="O", angular_velocity=6.0)}
    joints: dict[str, Any] = (
        {"root": Revolute(bodies=("beam", "ground"), point="R"), "tip": Revolute(bodies=("beam", "ground"), point="T")}
        if pinned
        else {"hinge": Revolute(bodies=("crank", "ground"), point="O"), "weld": RigidJoint(bodies=("beam", "crank"), point="R")}
    )
    return Scene(
        units="m-kg-s",
        directory=folder,
        points={
            "O": Point(x=0.0, y=0.0),
            "R": BodyPoint(body="beam", interface="root"),
            "T": BodyPoint(body="beam", interface="tip"),
        },
        bodies={**crank, "beam": Flexible(model="beam.h5", **motion)},
        joints=joints,
        solver=RunOptions(end_time=1e-3, step=1e-4),
    )


def test_a_flexible_body_starts_without_deforming_where_it_can(folder):
    """An impact would leave the beam's tip behind with 6 m/s."""
    system, state = started(arm(folder))
    at = slice(system.numbering.first["beam"], system.n_q)
    assert state.v[at][2] == pytest.approx(6.0, abs=EXACT)
    # the inertia of the beam beside its stiffness: 1 / (1 s)^2 over the square of its lowest frequency of 52 rad/s, times four
    assert np.abs(state.v[at][3:]).max() < 6.0 / 52**2 * 4
    assert not list(cautions_of_start(simulate(system)))


def test_the_start_of_flexible_bodies_is_differentiated(folder):
    derivatives_agree(arm(folder), ["bodies.crank.angular_velocity", "bodies.beam.thickness", "bodies.beam.youngs_modulus"])
    derivatives_agree(arm(folder, pinned=True, angular_velocity=0.3), ["bodies.beam.angular_velocity", "bodies.beam.thickness"])


def test_a_body_that_can_only_start_by_deforming_is_told(folder):
    run = simulate(compile_scene(arm(folder, pinned=True, angular_velocity=0.3)))
    assert run.v[0, 2] == pytest.approx(0.3, abs=EXACT)
    (caution,) = cautions_of_start(run)
    assert (caution.code, caution.doubt) == ("starts-deforming", False)
    assert "'beam' starts deforming with" in caution.text


def test_statics_and_modes_about_the_given_positions_do_not_ask_for_velocities(folder):
    contradictory = four_bar(crank={"velocity": (0.0, 0.0, 6.0)})
    assert not np.any(undeformed(compile_scene(contradictory)).v)


# --- what is told ---------------------------------------------------------------------------------------------------------------


def test_the_start_in_use_is_told_body_by_body():
    run = simulate(compile_scene(four_bar(crank={"angular_velocity": 6.0})))
    right = kinematics(6.0)
    crank, coupler, _ = start_state(run)
    assert (crank.written_angular_velocity, crank.written_velocity, coupler.written_angular_velocity) == ((6.0,), None, None)
    assert crank.velocity == pytest.approx(right[:2])
    record = start_record(run)
    assert record["rocker"]["angular_velocity"] == {"used": [pytest.approx(right[8])], "written": None, "unit": "rad/s"}
    assert record["crank"]["angular_velocity"]["written"] == [6.0]
    assert start_lines(run)[0].endswith("angular velocity 6 rad/s (written 6).")
    assert not list(cautions_of_start(run))


def test_no_start_is_told_of_a_run_that_has_none():
    assert start_lines(simulate(compile_scene(four_bar()))) == []


def test_by_how_much_assembly_moves_bodies_is_told():
    """A rod on a hinge, whose end a bar holds at a height that is given with an error."""
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0), "Q": Point(x=1.0, y=1.0)},
        bodies={"rod": Rod(between=("O", "P"), area=1.0, density=1.0)},
        joints={
            "hinge": Revolute(bodies=("rod", "ground"), point="O"),
            "bar": Distance(bodies=("rod", "ground"), points=("P", "Q"), length=0.98),
        },
        solver=RunOptions(end_time=0.01, step=0.001, assemble=True),
    )
    run = simulate(compile_scene(scene))
    # law of cosines in the triangle O, P, Q with sides 1, sqrt 2 and 0.98
    angle = np.pi / 4 - np.arccos((3 - 0.98**2) / (2 * np.sqrt(2)))
    shift, turn = moved_bodies(run)["rod"]
    assert (shift, turn) == pytest.approx((np.sin(angle / 2), angle), rel=1e-9)  # of the middle, half a metre out
    (caution,) = cautions_of_start(run)
    assert (caution.code, caution.doubt) == ("assembled", False)
    assert f"'rod' by {shift:.3g} m and {turn:.3g} rad" in caution.text


def test_joints_that_statics_closes_are_told():
    scene = four_bar()
    joints = {"O": scene.joints["O"], "bar": Distance(bodies=("crank", "ground"), points=("A", "C"), length=0.9)}
    still = scene.model_copy(update={"joints": joints, "bodies": {"crank": scene.bodies["crank"]}})
    (caution,) = cautions_of_start(solve_statics(compile_scene(still)))
    gap = abs(np.hypot(0.9, 0.3) - 0.9)
    assert caution.code == "assembled"
    assert "distance of joint 'bar'" in caution.text
    told, unit = caution.text.split(" by ")[1].split(",")[0].split()
    assert (float(told), unit) == (pytest.approx(gap, rel=1e-2), "m")  # three digits are told


def test_velocities_of_a_run_without_inertia_are_told_to_have_no_effect():
    scene = four_bar({"quasi_static": True}, crank={"angular_velocity": 6.0})
    drive = AngleDriver(bodies=("crank", "ground"), point="O", curve=Sine(amplitude=0.1, frequency=0.2))
    run = simulate(compile_scene(scene.model_copy(update={"joints": {**scene.joints, "drive": drive}})))
    assert [caution.code for caution in cautions_of_start(run)] == ["velocity-without-inertia"]
    assert start_state(run) == []


def test_a_scene_file_tells_a_written_zero_from_none(tmp_path):
    table = {
        "units": "m-kg-s",
        "points": {"O": [0.0, 0.0], "P": [1.0, 0.0]},
        "bodies": {
            "still": {"type": "rod", "between": ["O", "P"], "area": 1.0, "density": 1.0, "velocity": [0.0, 0.0, 0.0]},
            "free": {"type": "rod", "between": ["O", "P"], "area": 1.0, "density": 1.0},
        },
    }
    bodies = scene_from_table(table, tmp_path / "scene.toml").bodies
    assert (len(bodies["still"].written_velocities()), len(bodies["free"].written_velocities())) == (3, 0)
