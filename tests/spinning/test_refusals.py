"""What spins cannot be: said in words, with what to do."""

from __future__ import annotations

import pytest

from tests.spinning.scenes import governor, motor, table
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.api.model import compile_model
from toolkit.components.curves.polynomial import Constant, Polynomial
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.springs import SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError, SingularSystemError
from toolkit.responses.least_frequency import LoadMargin
from toolkit.responses.vibration import Frequency
from toolkit.scene.scene import Scene


def with_parts(scene: Scene, **groups: dict) -> Scene:
    return scene.model_copy(update={group: {**getattr(scene, group), **parts} for group, parts in groups.items()})


def refused(scene: Scene, words: str, error: type[Exception] = InputError) -> None:
    with pytest.raises(error, match=words):
        solve(prepare(scene), "static")


def test_a_scene_that_nothing_spins():
    still = AngleDriver(bodies=("table", "ground"), point="O", curve=Constant(value=0.0))
    refused(
        with_parts(table(), joints={"motor": still}),
        r"nothing says how fast the scene spins: no angle-driver between a body and the",
    )


def test_two_speeds():
    other = AngleDriver(bodies=("block", "ground"), point="O", curve=motor(2.0))
    refused(
        with_parts(table(), joints={"other": other}),
        r"'motor' and 'other' drive the scene; a steady spin has one speed and one axis",
    )
    between = AngleDriver(bodies=("block", "table"), point="O", curve=motor(2.0))
    scene = table()
    joints = {name: each for name, each in scene.joints.items() if name not in ("motor", "rail")} | {"between": between}
    refused(
        scene.model_copy(update={"joints": joints}),
        r"joint 'between' turns 'block' against 'table': then the scene does not spin with",
    )


def test_a_joint_that_holds_a_body_off_the_axis():
    guide = Slider(bodies=("block", "ground"), point="Q", axis=(1.0, 0.0))
    refused(
        with_parts(table(), joints={"guide": guide}),
        r"the scene cannot spin as a whole about the axis of its driver: .* of joint 'guide'",
    )


def test_a_frame_that_turns_about_another_axis():
    scene = governor(6.0)
    oblique = scene.bodies["spindle"].model_copy(update={"frame": "turning", "axis": (0.0, 1.0, 1.0)})
    refused(with_parts(scene, bodies={"spindle": oblique}), r"the frame of body 'spindle' turns about an axis of its own")


@pytest.mark.parametrize(
    ("group", "part"),
    [
        ("weight", Gravity(acceleration=(0.0, -9.81))),
        ("tie", SpringDamper(bodies=("block", "ground"), points=("Q", "F"), stiffness=3.0)),
    ],
)
def test_weight_across_the_axis_and_springs_to_the_ground_off_it(group, part):
    scene = with_parts(table(), loads={group: part}, points={"F": Point(x=4.0, y=1.0)})
    refused(scene, r"the scene is not the same at every angle of its spin: 1 rad further the forces on .* 'block' are other ones")


def test_a_spring_on_the_axis_is_no_matter_and_works_as_it_should():
    """A spring to the axis adds to that of the table: (k + k_2) (r - 2) = m Omega^2 r."""
    tie = SpringDamper(bodies=("block", "ground"), points=("Q", "O"), stiffness=30.0)
    state = solve(prepare(with_parts(table(), loads={"tie": tie})), "static")
    x, y = state.q[0, state.coordinates("block")][:2] - [0.5, 0.2]
    assert (x**2 + y**2) ** 0.5 == pytest.approx(2 * 80.0 / (80.0 - 18.0), rel=1e-11)


def test_a_driver_that_does_not_keep_its_rate():
    """Bodies lag behind it by forces that no steady state shows; at a rate of 20 rad/s it would be a frequency with exit code 0."""
    (name, motor), *_ = [(name, each) for name, each in table().joints.items() if each.kind == "angle-driver"]
    hurried = motor.model_copy(update={"curve": Polynomial(coefficients=(0.0, 2.0, 3.0))})
    refused(
        with_parts(table(), joints={name: hurried}),
        r"turns with .* but does not keep that rate: it changes by 6 per unit of time",
    )


def test_what_is_free_in_the_frame_that_spins():
    loose = {name: each for name, each in table().joints.items() if name != "rail"}
    with pytest.raises(
        SingularSystemError, match=r"nothing determines .* of body 'block' in the frame that spins|no steady spin"
    ):
        solve(prepare(table(speed=1e-9).model_copy(update={"joints": loose, "loads": {}})), "static")


def test_options_that_contradict_it():
    with pytest.raises(ValueError, match="is not followed by arc length"):
        RunOptions(equilibrium="spinning", continuation="arc-length")
    with pytest.raises(ValueError, match="held by inertia, which a quasi-static run leaves out"):
        RunOptions(equilibrium="spinning", quasi_static=True)


def test_a_load_margin_of_a_spin():
    with pytest.raises(InputError, match="a load margin is that of an equilibrium at rest"):
        gradients_by("direct", table(responses={"margin": LoadMargin()}), [], "static")


def test_a_motion_that_does_not_come_to_rest():
    scene = table(damping=0.0, responses={"f": Frequency(when="end")}, solver=RunOptions(end_time=1.0, step=0.02))
    with pytest.raises(
        InputError, match=r"the motion does not end in an equilibrium, nor in a steady spin: .* of body 'block' is still"
    ):
        gradients_by("direct", scene, [], "transient")


def test_a_motion_says_which_responses_it_has_not():
    scene = table(responses={"f": Frequency(), "margin": LoadMargin()}, solver=RunOptions(end_time=0.1, step=0.02))
    found = gradients_by("direct", scene, [], "transient")
    assert found.values == {}
    (caution,) = [each for each in found.solution.warnings if each.code == "left-out"]
    assert caution.text.startswith("'f' and 'margin' are responses of an equilibrium, and left out of this motion")


@pytest.mark.parametrize("speeds", [[], [-1.0], [float("nan")], [[1.0]]])
def test_speeds_that_are_none(speeds):
    with pytest.raises(InputError, match="speeds are a list of 1 to 10000 numbers"):
        compile_model(table()).campbell(speeds)


def test_a_driven_part_of_a_scene_that_rests():
    """A second body on a bearing of its own does not turn with the table."""
    scene = table()
    bodies = {**scene.bodies, "wheel": scene.bodies["table"].model_copy(update={"center": "W"})}
    joints = {**scene.joints, "bearing": Revolute(bodies=("wheel", "ground"), point="W")}
    refused(
        scene.model_copy(update={"bodies": bodies, "joints": joints, "points": {**scene.points, "W": Point(x=3.0, y=3.0)}}),
        r"the scene cannot spin as a whole about the axis of its driver: x of joint 'bearing' does not let it",
    )


def test_a_written_velocity_beside_a_start_in_a_steady_spin():
    scene = table(solver=RunOptions(end_time=0.1, step=0.02, equilibrium="spinning", start="equilibrium"))
    block = scene.bodies["block"].model_copy(update={"angular_velocity": 3.0})
    with pytest.raises(
        InputError, match=r"bodies\.block\.angular_velocity is written, but a motion that starts in a steady spin has"
    ):
        solve(prepare(with_parts(scene, bodies={"block": block})), "transient")
