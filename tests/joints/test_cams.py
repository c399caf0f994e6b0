"""Cams against closed forms: the follower's acceleration f''(angle) w^2 over several turns, in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from ffrf import plane, space
from tests.joints.test_gears import AXIS, TURN, at, gradients
from tests.models.cases import LIFT, PROFILE
from toolkit.analyses.transient import simulate
from toolkit.components.curves.curve import Curve
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.kernels.profile import PIECE
from toolkit.components.joints.profile import profile_form
from toolkit.description.run_options import RunOptions
from toolkit.files.gradient_units import variable_unit
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.system.system import compile_scene

RISE = plane.Cycloid(height=0.03, start=0.4, duration=1.1)
DWELLS = plane.Sequence(
    curves=(RISE, plane.Constant(value=0.0), plane.Cycloid(height=-0.03, start=0.2, duration=1.3)), times=(2.0, 3.5)
)
"""Up, a dwell, down."""
CURVES = {"harmonics": PROFILE, "table": LIFT, "dwells": DWELLS}
SPEED = 5.0


@pytest.mark.parametrize("name", CURVES)
def test_a_profile_is_its_curve(name):
    """Polynomials of its pieces against the curve itself, with two derivatives."""
    curve = CURVES[name]
    pieces = np.array([value for _, value in profile_form(curve).linear]).reshape(-1, PIECE)
    angles = np.linspace(1e-3, TURN - 1e-3, 997)
    exact = curve.evaluate(angles) - [curve.evaluate(np.zeros(1))[0, 0], 0, 0]
    which = np.searchsorted(pieces[:, 0], angles, "right") - 1
    for angle, piece, values in zip(angles, pieces[which], exact, strict=True):
        own = np.polynomial.Polynomial(piece[2:])
        found = [each(angle - piece[1]) for each in (own, own.deriv(), own.deriv(2))]
        # to 1e-13 of the largest value; pieces are 0.05 wide and more, and a derivative of degree 9 takes up to 81 times 2 / width of that
        np.testing.assert_allclose(found[0], values[0], atol=1e-12 * np.abs(exact[:, 0]).max())
        np.testing.assert_allclose(found[1], values[1], atol=1e-9 * np.abs(exact[:, 1]).max())
        np.testing.assert_allclose(found[2], values[2], atol=1e-6 * np.abs(exact[:, 2]).max())


def driven(curve: Curve, **changes) -> ffrf.Scene:
    """A cam that turns at a constant speed and pushes a follower of 2 kg up a slope; after three turns and more."""
    axis = (0.6, 0.8)
    return ffrf.Scene(
        units="m-kg-s",
        points=at(O=(0.1, 0.2), P=(0.1 + 0.06, 0.2 + 0.08)),
        bodies={
            "cam": plane.Rigid(mass=1.0, inertia=0.02, center="O", angular_velocity=SPEED),
            "follower": plane.Rigid(mass=2.0, inertia=0.1, center="P"),
        },
        joints={
            "O": plane.Revolute(bodies=("cam", "ground"), point="O"),
            "drive": plane.AngleDriver(bodies=("cam", "ground"), point="O", curve=plane.Polynomial(coefficients=(0.0, SPEED))),
            "guide": plane.Slider(bodies=("follower", "ground"), point="P", axis=axis, lock_rotation=True),
            "cam": plane.Cam(bodies=("follower", "cam"), points=("P", "O"), axis=axis, curve=curve),
        },
        responses={
            "lift": plane.Displacement(body="follower", point="P", component="y"),
            "push": plane.JointForce(joint="cam", component="y"),
        },
        **changes,
    )


@pytest.mark.parametrize("name", CURVES)
def test_a_follower_has_the_lift_and_the_acceleration_of_its_curve(name):
    """s = f(w t) - f(0), s'' = f''(w t) w^2, force m s''; joints that are kept in place, and joints by their accelerations."""
    curve = CURVES[name]
    kept, found = (
        simulate(compile_scene(driven(curve)), RunOptions(end_time=4.1, step=1e-3, formulation=kind))
        for kind in ("index-3", "index-1")
    )
    angle = (SPEED * found.times) % TURN
    assert found.times[-1] * SPEED > 3 * TURN
    exact = curve.evaluate(angle)
    s = (kept.q[:, 3] - kept.q[0, 3]) * 0.6 + (kept.q[:, 4] - kept.q[0, 4]) * 0.8
    np.testing.assert_allclose(s, exact[:, 0] - exact[0, 0], atol=1e-8 * np.ptp(exact[:, 0]))  # Newton's tolerance
    # where f'' jumps a step misses a part of it, which is made good within thirty
    corners = [float(np.real(c)) for c in (*curve.corners(), 0.0, TURN)]
    away = np.min([(angle - c) % TURN for c in corners], axis=0) > 30 * 1e-3 * SPEED
    assert away.mean() > 0.7
    rates, expected = found.a[:, 3] * 0.6 + found.a[:, 4] * 0.8, exact[:, 2] * SPEED**2
    np.testing.assert_allclose(rates[away], expected[away], atol=2e-3 * np.abs(expected).max())
    np.testing.assert_allclose(np.abs(found.multipliers[:, -1]), 2.0 * np.abs(rates), atol=1e-6 * np.abs(rates).max())


@pytest.mark.parametrize("name", CURVES)
def test_gradients_by_all_numbers_of_a_profile_are_those_of_the_complex_step(name):
    scene = driven(CURVES[name])
    paths = [f"joints.cam.curve.{path}" for path, _ in CURVES[name].numbers()]
    paths = [path for path in paths if not path.endswith("frequency")]
    for response in ("lift", "push"):
        found = gradients(scene, [*paths, "points.P.x", "bodies.follower.mass"], response, 4e-3, 0.17)
        assert any(found[:-2])


def test_the_gradient_by_a_lift_is_that_of_the_curve():
    """df/d amplitude = cos(w t + phase) - cos(phase) for three waves a turn, at t = 0.3, whatever the step."""
    (slope,) = gradients(driven(PROFILE), ["joints.cam.curve.terms.0.amplitude"], "lift", 1e-3, 0.3)
    assert slope == pytest.approx(0.8 * (np.cos(3 * SPEED * 0.3 + 0.3) - np.cos(0.3)), rel=1e-3)  # second order in the step


def test_numbers_of_a_profile_are_over_an_angle():
    scene = driven(LIFT)
    assert variable_unit(scene, "joints.cam.curve.times.0") == "rad"
    assert variable_unit(scene, "joints.cam.curve.values.0") == "m"
    assert variable_unit(driven(PROFILE), "joints.cam.curve.terms.0.frequency") == "1/rad"
    assert variable_unit(driven(PROFILE), "joints.drive.curve.coefficients.1") == "rad/s"


def swinging(dimension: int, carrier: bool) -> ffrf.Scene:
    """A cam that turns freely and a lever that swings, on the ground or on a carrier that turns at a speed of its own."""
    e_1, e_2, e_3 = axes_along(AXIS).T
    places = {"O": (0.1, 0.2), "P": (0.4, 0.3), "C": (0.0, 0.0)}
    if dimension == 3:
        places = {name: tuple(x * e_1 + y * e_2 + 0.1 * e_3) for name, (x, y) in places.items()}
    kinds, about = (plane, {}) if dimension == 2 else (space, {"axis": AXIS})
    rigid = (
        (lambda mass, J, c: plane.Rigid(mass=mass, inertia=J, center=c))
        if dimension == 2
        else (lambda mass, J, c: space.Rigid(mass=mass, inertia=(J, J, J), center=c))
    )
    base = "carrier" if carrier else "ground"
    joints: dict = {
        "O": kinds.Revolute(bodies=("cam", base), point="O", **about),
        "P": kinds.Revolute(bodies=("lever", base), point="P", **about),
        "swing": kinds.SwingCam(bodies=("lever", "cam"), points=("P", "O"), curve=PROFILE, **about),
    }
    bodies = {"cam": rigid(1.0, 0.02, "O"), "lever": rigid(0.5, 0.01, "P")}
    if carrier:
        bodies["carrier"] = rigid(1.0, 0.3, "C")
        joints["C"] = kinds.Revolute(bodies=("carrier", "ground"), point="C", **about)
    torque = 0.3 if dimension == 2 else tuple(0.3 * x for x in AXIS)
    own = {"carrier": 0.2 if dimension == 2 else tuple(0.2 * x for x in AXIS)} if carrier else {}
    loads = {
        "motor": kinds.Torque(body="cam", point="O", torque=torque, reaction=base),
        **{name: kinds.Torque(body=name, point="C", torque=value) for name, value in own.items()},
    }
    angles = {name: kinds.RelativeAngle(bodies=(name, base), point=p, **about) for name, p in (("cam", "O"), ("lever", "P"))}
    return ffrf.Scene(
        units="m-kg-s", dimension=dimension, points=at(**places), bodies=bodies, joints=joints, loads=loads, responses=angles,
        solver=RunOptions(end_time=1.5, step=1e-3, formulation="index-3"),
    )  # fmt: skip


@pytest.mark.parametrize("carrier", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_lever_swings_as_its_curve_says_whatever_carries_it(dimension, carrier):
    values = ffrf.compile(swinging(dimension, carrier)).simulate().values
    assert values["cam"] > TURN
    lift = PROFILE.evaluate(np.array([values["cam"] % TURN, 0.0]))[:, 0]
    assert values["lever"] == pytest.approx(lift[0] - lift[1], abs=1e-8)  # Newton's tolerance


def test_a_cam_keeps_the_energy_of_its_motor():
    """Torque times angle, over a turn and more: the constraint takes nothing; half the step, a quarter of the error."""
    errors = []
    for step in (2e-3, 1e-3):
        scene = swinging(2, False)
        found = simulate(compile_scene(scene), RunOptions(end_time=1.5, step=step))
        energy = (0.02 * found.v[:, 2] ** 2 + 0.01 * found.v[:, 5] ** 2) / 2
        errors.append(np.abs(energy - 0.3 * found.q[:, 2]).max() / energy[-1])
    assert errors[1] < 2e-3
    assert 3.3 < errors[0] / errors[1] < 4.7


def test_a_follower_in_space_has_the_lift_of_its_curve_along_the_axis_of_its_cam():
    """A drum, driven at a constant speed about an oblique axis."""
    e_1, _, e_3 = axes_along(AXIS).T
    scene = ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points=at(O=(0.1, 0.2, 0.3), P=tuple(np.array([0.1, 0.2, 0.3]) + 0.2 * e_1 + 0.3 * e_3)),
        bodies={
            "cam": space.Rigid(mass=1.0, inertia=(0.02,) * 3, center="O", angular_velocity=tuple(SPEED * e_3)),
            "follower": space.Rigid(mass=2.0, inertia=(0.1,) * 3, center="P"),
        },
        joints={
            "O": space.Revolute(bodies=("cam", "ground"), point="O", axis=AXIS),
            "drive": space.AngleDriver(
                bodies=("cam", "ground"), point="O", axis=AXIS, curve=plane.Polynomial(coefficients=(0.0, SPEED))
            ),
            "guide": space.Prismatic(bodies=("follower", "ground"), point="P", axis=AXIS),
            "cam": space.Cam(bodies=("follower", "cam"), points=("P", "O"), axis=AXIS, along=AXIS, curve=PROFILE),
        },
    )
    found = simulate(compile_scene(scene), RunOptions(end_time=2.0, step=1e-3))
    lift = PROFILE.evaluate((SPEED * found.times) % TURN)
    moved = (found.q[:, 7:10] - found.q[0, 7:10]) @ e_3
    np.testing.assert_allclose(moved, lift[:, 0] - lift[0, 0], atol=1e-4)  # second order: (15 rad/s x 1 ms)^2 / 2
    np.testing.assert_allclose(found.a[:, 7:10] @ e_3, lift[:, 2] * SPEED**2, atol=1e-3 * np.abs(lift[:, 2]).max() * SPEED**2)


def cam(curve: Curve) -> Joint:
    return plane.Cam(bodies=("follower", "cam"), points=("P", "O"), curve=curve)


def test_a_curve_that_does_not_come_back_after_a_turn_is_refused():
    for curve, what in (
        (RISE, "value 0 at the angle 0 and 0.03 after a turn"),
        (plane.Sine(amplitude=0.1, frequency=1.0), "value 0 at"),
        (plane.Sine(amplitude=0.1, frequency=0.5 / TURN), "slope 0.05 at the angle 0 and -0.05 after a turn"),
    ):
        with pytest.raises(InputError, match=rf"the cam between points 'P' and 'O' has the {what}"):
            compile_scene(driven(curve))


def test_a_curve_with_corners_is_refused():
    with pytest.raises(ValueError, match="a driver needs a curve with a second derivative"):
        cam(plane.Table(times=(0.0, 3.0, 6.0), values=(0.0, 0.1, 0.0), interpolation="linear"))


def test_a_curve_that_swings_too_often_is_refused():
    with pytest.raises(InputError, match="changes too often within one turn"):
        compile_scene(driven(plane.Sine(amplitude=0.1, frequency=1000 / TURN)))


def test_a_lever_on_the_axis_of_its_cam_is_refused():
    scene = swinging(2, False)
    with pytest.raises(InputError, match="has the pivot of its follower on the axis of the cam"):
        compile_scene(scene.model_copy(update={"points": at(O=(0.1, 0.2), P=(0.1, 0.2), C=(0.0, 0.0))}))


def test_other_numbers_of_a_profile_need_no_new_model():
    """A rise that begins later takes other pieces: the same as a model of its own."""
    scene = driven(DWELLS).model_copy(update={"solver": RunOptions(end_time=0.2, step=1e-3)})
    model = ffrf.compile(scene, variables=["joints.cam.curve.curves.0.start", "joints.cam.curve.curves.0.duration"])
    for change in ({"joints.cam.curve.curves.0.start": 0.7}, {"joints.cam.curve.curves.0.duration": 0.4}):
        found = model.simulate(change).values
        fresh = ffrf.compile(scene.with_number(*next(iter(change.items())))).simulate().values
        assert found == pytest.approx(fresh, rel=1e-9)
        assert found["lift"] != pytest.approx(model.simulate().values["lift"], rel=1e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_variable_that_opens_a_profile_is_doubted_where_the_cam_passes_its_end(dimension):
    """A frequency moves the end away from the beginning, an amplitude does not; nor does a frequency before the end is reached."""
    scene = swinging(dimension, False)
    scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"step": 5e-3})})  # any step passes the end
    amplitude, frequency = ("joints.swing.curve.terms.0.amplitude", "joints.swing.curve.terms.0.frequency")
    whole, part = scene.solver, scene.solver.model_copy(update={"end_time": 0.3})
    for path, solver, doubted in ((frequency, whole, True), (amplitude, whole, False), (frequency, part, False)):
        found = ffrf.compile(scene.model_copy(update={"solver": solver}), variables=[path]).simulate(gradients=True)
        said = [each.text for each in found.verdict.warnings if each.code == "cam-opened"]
        assert len(said) == doubted
        assert all(f"{path} would open the curve of joints.swing" in text for text in said)


def test_a_cam_starts_in_its_first_piece_whatever_round_off_makes_of_the_angle_zero():
    """An angle a little below zero, as round-off has it, is not one at the end of the turn, where f'' is another one."""
    bumpy = plane.Table(times=(0.0, 2.0, 4.0, 5.0), values=(0.1, 0.2, 0.15, 0.1))
    rates = []
    for turn in (0.0, 1e-12, -1e-12):
        scene = driven(bumpy)
        drive = plane.AngleDriver(bodies=("cam", "ground"), point="O", curve=plane.Polynomial(coefficients=(turn, SPEED)))
        joints = {**scene.joints, "drive": drive}
        found = simulate(
            compile_scene(scene.model_copy(update={"joints": joints})), RunOptions(end_time=0.01, step=1e-3, assemble=True)
        )
        rates.append(found.a[0, 3:5] @ [0.6, 0.8])
    exact = bumpy.evaluate(np.array([1e-9]))[0, 2] * SPEED**2
    assert abs(exact) > 0.5
    assert rates == pytest.approx([exact] * 3, rel=1e-6)
