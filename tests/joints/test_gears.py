"""Gears, racks, screws and rolling discs against closed forms, over many turns, in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from ffrf import plane, space
from tests.models.directions import along, derivative_along, felt_direction
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.transient import simulate
from toolkit.components.joints.joint import Joint
from toolkit.components.joints.rows import Row
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

AXIS = (0.48, -0.6, 0.64)
"""Of a length of one, along no axis of the coordinates."""
TURN = 2 * np.pi


def at(**places: tuple[float, ...]) -> dict:
    return {name: plane.Point(**dict(zip("xyz", place, strict=False))) for name, place in places.items()}


def run(scene: ffrf.Scene, step: float = 1e-2, end_time: float = 4.0) -> Solution:
    return simulate(compile_scene(scene), RunOptions(end_time=end_time, step=step))


def gradients(scene: ffrf.Scene, paths: list[str], response: str, step: float = 1e-2, end_time: float = 1.0) -> list[float]:
    """By each path, judged by a complex step of all of them through the whole run."""
    scene = scene.model_copy(update={"solver": RunOptions(end_time=end_time, step=step)})
    run = gradients_by("direct", scene, paths, "transient")
    found = run.gradients[response]
    largest = max(abs(slope) for slope in found.values())
    factors = felt_direction({response: found}, 0.1, 0.1)
    # both solve to the Newton tolerance of 1e-10; a small derivative is as exact as one that is ten times smaller than the largest
    assert along(found, factors) == pytest.approx(
        derivative_along(scene, factors, "transient", run.solution)[response], rel=0, abs=1e-8 * largest
    )
    return [found[path] for path in paths]


# --- wheels on axles that are fixed to the ground -----------------------------------------------------------------------------------


def geared_wheels(gear: Joint, torque: float = 0.5) -> ffrf.Scene:
    """Two wheels in the plane, whose centres are 0.4 apart, and a motor on the first."""
    wheels = {"small": plane.Rigid(mass=1.0, inertia=0.02, center="A"), "large": plane.Rigid(mass=9.0, inertia=1.5, center="B")}
    axles = {point: plane.Revolute(bodies=(body, "ground"), point=point) for body, point in (("small", "A"), ("large", "B"))}
    return ffrf.Scene(
        units="m-kg-s",
        points=at(A=(0.3, 0.1), B=(0.54, 0.42)),
        bodies=wheels,
        joints={**axles, "gear": gear},
        loads={"motor": plane.Torque(body="small", point="A", torque=torque)},
        responses={"turned": plane.Rotation(body="large", point="B")},
    )


GIVEN = [({"ratio": 3.0}, 3.0), ({"radii": (0.1, 0.3)}, 3.0), ({"teeth": (17, 51)}, 3.0), ({"radii": (0.2, -0.6)}, -3.0)]


@pytest.mark.parametrize(("numbers", "ratio"), [*GIVEN, ({"ratio": -1.0}, -1.0)])
def test_geared_wheels_turn_with_their_reduced_inertia(numbers, ratio):
    """(J_a + J_b / n^2) angle_a'' = torque, angle_b = - angle_a / n."""
    found = run(geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), **numbers)))
    exact = 0.5 * 0.5 * found.times**2 / (0.02 + 1.5 / ratio**2)
    assert abs(exact[-1]) > 0.3 * TURN
    np.testing.assert_allclose(found.q[:, 2], exact, atol=1e-8)  # constant acceleration: exact but for round-off
    np.testing.assert_allclose(found.q[:, 5], -exact / ratio, atol=1e-8)


def test_gradients_by_ratio_and_radii_are_those_of_the_reduced_inertia():
    """angle_b = - t^2 / 2 torque / (n J_a + J_b / n) after t = 1."""
    slope = 0.25 * (0.02 - 1.5 / 9) / (3 * 0.02 + 0.5) ** 2
    scene = geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), ratio=3.0))
    assert gradients(scene, ["joints.gear.ratio", "points.A.x"], "turned") == pytest.approx([slope, 0.0], rel=1e-8, abs=1e-12)
    scene = geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), radii=(0.1, 0.3)))
    by_radii = gradients(scene, ["joints.gear.radii.x", "joints.gear.radii.y"], "turned")
    assert by_radii == pytest.approx([-slope * 0.3 / 0.1**2, slope / 0.1], rel=1e-8)


def spatial_wheels(teeth: tuple[int, int]) -> ffrf.Scene:
    """The same wheels in space, about an oblique axis, their centres 0.4 apart across it and 0.2 along it."""
    e_1, _, e_3 = axes_along(AXIS).T
    places = {"A": (0.3, 0.1, -0.2), "B": tuple(np.array([0.3, 0.1, -0.2]) + 0.4 * e_1 + 0.2 * e_3)}
    bodies = {"small": ("A", 1.0, 0.02), "large": ("B", 9.0, 1.5)}
    return ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points=at(**places),
        bodies={name: space.Rigid(mass=mass, inertia=(J, J, J), center=point) for name, (point, mass, J) in bodies.items()},
        joints={
            **{point: space.Revolute(bodies=(name, "ground"), point=point, axis=AXIS) for name, (point, *_) in bodies.items()},
            "gear": space.Gear(bodies=("small", "large"), points=("A", "B"), axis=AXIS, teeth=teeth),
        },
        loads={"motor": space.Torque(body="small", point="A", torque=tuple(0.5 * x for x in AXIS))},
        responses={
            "turned": space.RelativeAngle(bodies=("large", "ground"), point="B", axis=AXIS),
            "speed": space.KineticEnergy(),
        },
    )


@pytest.mark.parametrize("teeth", [(17, 51), (20, -47)])
def test_geared_wheels_in_space_turn_with_their_reduced_inertia(teeth):
    """Kinetic energy torque^2 t^2 / 2 / J over several turns: no wheel slips a tooth, which would stop both."""
    ratio, errors = teeth[1] / teeth[0], []
    inertia = 0.02 + 1.5 / ratio**2
    assert 0.5 * 0.5 * 3**2 / inertia > TURN
    for step in (4e-3, 2e-3):
        scene = spatial_wheels(teeth).model_copy(update={"solver": RunOptions(end_time=3.0, step=step)})
        values = ffrf.compile(scene).simulate().values
        turned = -0.5 * 0.5 * 3**2 / inertia / ratio
        errors.append([abs(values["speed"] / (0.5 * 3) ** 2 * 2 * inertia - 1), abs(values["turned"] / turned - 1)])
    assert max(errors[1]) < 1e-3  # second order: (15 rad/s x 2 ms)^2 / 12
    np.testing.assert_allclose(np.divide(*errors), 4, rtol=0.1)


@pytest.mark.parametrize("angle", [0.3, 2.5])
@pytest.mark.parametrize("teeth", [(17, 51), (97, 101), (20, -47)])
def test_geared_wheels_rest_where_a_spring_holds_them(teeth, angle):
    """torque = k angle_a / n^2, in the plane and in space: no equilibrium is in mesh with the next tooth."""
    ratio, k = teeth[1] / teeth[0], 2.0
    torque = k * angle / ratio**2
    flat = geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), teeth=teeth))
    flat_loads = {
        "motor": plane.Torque(body="small", point="A", torque=torque),
        "coil": plane.RotationalSpringDamper(bodies=("large", "ground"), point="B", stiffness=k),
    }
    loads = {
        "motor": space.Torque(body="small", point="A", torque=tuple(torque * x for x in AXIS)),
        "coil": space.RotationalSpringDamper(bodies=("large", "ground"), point="B", axis=AXIS, stiffness=k),
    }
    for scene, found in ((flat, flat_loads), (spatial_wheels(teeth), loads)):
        values = ffrf.compile(scene.model_copy(update={"loads": found})).statics().values
        assert values["turned"] == pytest.approx(-angle / ratio, abs=1e-9)  # Newton's tolerance


# --- a carrier that turns ------------------------------------------------------------------------------------------------------------

ARM, PLANET = (0.7, 0.05), (2.0, 0.01)
"""Mass and moment of inertia of what carries the planet, and of the planet."""


def planetary(sun: float, planet: float, ring: bool) -> ffrf.Scene:
    """A planet, carried by an arm round a wheel, or within a ring, of the ground; a motor on the arm."""
    fixed = -(sun + 2 * planet) if ring else sun
    distance = abs(fixed + planet)
    return ffrf.Scene(
        units="m-kg-s",
        points=at(O=(0.2, -0.1), P=(0.2 - 0.6 * distance, -0.1 + 0.8 * distance)),
        bodies={
            "arm": plane.Rigid(mass=ARM[0], inertia=ARM[1], center="O"),
            "planet": plane.Rigid(mass=PLANET[0], inertia=PLANET[1], center="P"),
        },
        joints={
            "O": plane.Revolute(bodies=("arm", "ground"), point="O"),
            "P": plane.Revolute(bodies=("planet", "arm"), point="P"),
            "gear": plane.Gear(bodies=("planet", "ground"), points=("P", "O"), radii=(planet, fixed)),
        },
        loads={"motor": plane.Torque(body="arm", point="O", torque=0.6)},
    )


@pytest.mark.parametrize(("ring", "share"), [(False, 1 + 0.3 / 0.1), (True, 1 - 0.5 / 0.1)])
def test_a_planet_turns_with_its_carrier(ring, share):
    """angle_planet = (1 + R_fixed / R_planet) phi, so that (J_arm + m d^2 + J_planet share^2) phi'' = torque."""
    d = 0.4
    inertia = ARM[1] + PLANET[0] * d**2 + PLANET[1] * share**2
    errors = []
    for step in (2e-3, 1e-3):
        found = run(planetary(0.3, 0.1, ring), step)
        phi = 0.6 * found.times**2 / 2 / inertia
        errors.append([np.abs(found.q[:, 2] - phi).max() / phi[-1], np.abs(found.q[:, 5] - share * phi).max() / phi[-1]])
    assert phi[-1] > TURN
    assert max(errors[1]) < 1e-4  # second order: (5 rad/s x 1 ms)^2 / 12, over 4 s
    np.testing.assert_allclose(np.divide(*errors), 4, rtol=0.1)


def test_a_planet_in_space_is_that_in_the_plane():
    """The same planet about an oblique axis: the relation of its angle to its carrier's is kept to what the joints keep."""
    e_1, e_2, e_3 = axes_along(AXIS).T
    centre = np.array([0.2, -0.1, 0.4])
    scene = ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points=at(O=tuple(centre), P=tuple(centre + 0.4 * (0.6 * e_1 + 0.8 * e_2))),
        bodies={
            "arm": space.Rigid(mass=ARM[0], inertia=(ARM[1],) * 3, center="O"),
            "planet": space.Rigid(mass=PLANET[0], inertia=(PLANET[1],) * 3, center="P"),
        },
        joints={
            "O": space.Revolute(bodies=("arm", "ground"), point="O", axis=AXIS),
            "P": space.Revolute(bodies=("planet", "arm"), point="P", axis=AXIS),
            "gear": space.Gear(bodies=("planet", "ground"), points=("P", "O"), axis=AXIS, teeth=(11, 33)),
        },
        loads={"motor": space.Torque(body="arm", point="O", torque=tuple(0.6 * x for x in e_3))},
        responses={
            "arm": space.RelativeAngle(bodies=("arm", "ground"), point="O", axis=AXIS),
            "planet": space.RelativeAngle(bodies=("planet", "ground"), point="P", axis=AXIS),
        },
        solver=RunOptions(end_time=4.0, step=1e-3),
    )
    model = ffrf.compile(scene, variables=["points.P.x", "joints.gear.axis.0"])
    found = model.simulate().values
    phi = 0.6 * 4.0**2 / 2 / (ARM[1] + PLANET[0] * 0.4**2 + PLANET[1] * 16)
    assert found["arm"] == pytest.approx(phi, rel=1e-3)  # second order: (6 rad/s x 1 ms)^2 / 12, over 4 s
    assert found["planet"] == pytest.approx(4 * found["arm"], abs=1e-6)  # the drift of the joints
    gradients(scene, ["points.P.x", "points.O.y", "bodies.planet.mass"], "planet", 5e-3, 0.1)


# --- racks and discs -----------------------------------------------------------------------------------------------------------------


def pinion_and_rack(side: float = 1.0, **numbers) -> ffrf.Scene:
    """A pinion on the ground, turned by a motor, and a rack on a guide."""
    return ffrf.Scene(
        units="m-kg-s",
        points=at(P=(0.5, side * 0.25), Q=(0.0, 0.0)),
        bodies={
            "pinion": plane.Rigid(mass=1.0, inertia=0.02, center="P"),
            "rack": plane.Rigid(mass=3.0, inertia=0.1, center="Q"),
        },
        joints={
            "axle": plane.Revolute(bodies=("pinion", "ground"), point="P"),
            "guide": plane.Slider(bodies=("rack", "ground"), point="Q", lock_rotation=True),
            "rack": plane.Rack(bodies=("pinion", "rack"), points=("P", "Q"), **numbers),
        },
        loads={"motor": plane.Torque(body="pinion", point="P", torque=0.4)},
        responses={"moved": plane.Displacement(body="rack", point="Q", component="x")},
    )


@pytest.mark.parametrize(("side", "numbers"), [(1.0, {}), (-1.0, {}), (-1.0, {"radius": 0.2})])
def test_a_pinion_pushes_its_rack(side, numbers):
    """(J + m R^2) angle'' = torque, and the rack moves by R angle, the other way if it is above the pinion."""
    radius = numbers.get("radius", 0.25)
    found = run(pinion_and_rack(side, **numbers))
    angle = 0.4 * found.times**2 / 2 / (0.02 + 3.0 * radius**2)
    assert angle[-1] > 2 * TURN
    np.testing.assert_allclose(found.q[:, 2], angle, atol=1e-8)  # constant acceleration: exact but for round-off
    np.testing.assert_allclose(found.q[:, 3], side * radius * angle, atol=1e-8)


def test_the_radius_of_a_rack_follows_its_points():
    """x = R torque / 2 / (J + m R^2), R = y_P - y_Q."""
    slope = 0.2 * (0.02 - 3 * 0.25**2) / (0.02 + 3 * 0.25**2) ** 2
    assert gradients(pinion_and_rack(), ["points.P.y", "points.P.x"], "moved") == pytest.approx([slope, 0.0], rel=1e-7, abs=1e-9)
    assert gradients(pinion_and_rack(radius=0.25), ["joints.rack.radius"], "moved") == pytest.approx([slope], rel=1e-7)


def disc(kind: type, slope: float, **numbers) -> ffrf.Scene:
    """A disc of 2 kg and R = 0.3 on a line that falls by an angle."""
    along, normal = np.array([np.cos(slope), -np.sin(slope)]), np.array([np.sin(slope), np.cos(slope)])
    centre = np.array([0.1, 0.7])
    return ffrf.Scene(
        units="m-kg-s",
        points=at(P=tuple(centre), Q=tuple(centre - 0.3 * normal + 0.2 * along)),
        bodies={"disc": plane.Rigid(mass=2.0, inertia=2.0 * 0.3**2 / 2, center="P")},
        joints={"disc": kind(bodies=("disc", "ground"), points=("P", "Q"), axis=tuple(along), **numbers)},
        loads={"weight": plane.Gravity(acceleration=(0.0, -9.81))},
        responses={"x": plane.Displacement(body="disc", point="P", component="x")},
    )


def test_a_disc_rolls_down_a_slope_with_two_thirds_of_what_slides():
    found = run(disc(plane.RollingDisc, 0.3))
    s = 9.81 * np.sin(0.3) * 2 / 3 * found.times**2 / 2
    np.testing.assert_allclose(found.q[:, 0], 0.1 + s * np.cos(0.3), atol=1e-8)  # constant acceleration
    np.testing.assert_allclose(found.q[:, 1], 0.7 - s * np.sin(0.3), atol=1e-8)
    np.testing.assert_allclose(found.q[:, 2], -s / 0.3, atol=1e-7)
    assert s[-1] / 0.3 > 2 * TURN


def test_a_disc_on_a_board_that_is_pulled_stays_behind():
    """A board of M, pulled by F: the disc follows with a third of its acceleration, so that (M + m / 3) A = F."""
    scene = ffrf.Scene(
        units="m-kg-s",
        points=at(P=(0.0, 0.3), Q=(0.0, 0.0)),
        bodies={
            "board": plane.Rigid(mass=5.0, inertia=1.0, center="Q"),
            "disc": plane.Rigid(mass=2.0, inertia=2.0 * 0.3**2 / 2, center="P"),
        },
        joints={
            "guide": plane.Slider(bodies=("board", "ground"), point="Q", lock_rotation=True),
            "disc": plane.RollingDisc(bodies=("disc", "board"), points=("P", "Q")),
        },
        loads={"pull": plane.PointForce(body="board", point="Q", force=(7.0, 0.0))},
    )
    found = run(scene, end_time=2.0)
    moved = 7.0 / (5 + 2 / 3) * found.times**2 / 2
    np.testing.assert_allclose(found.q[:, 0], moved, atol=1e-8)
    np.testing.assert_allclose(found.q[:, 3], moved / 3, atol=1e-8)


def test_a_disc_keeps_its_energy_on_a_board_that_swings():
    """The constraint forces of a line that turns do no work: half the step, a quarter of what is missing."""
    scene = ffrf.Scene(
        units="m-kg-s",
        points=at(O=(0.0, 1.0), P=(0.0, 0.3), Q=(0.0, 0.0)),
        bodies={
            "board": plane.Rigid(mass=5.0, inertia=1.0, center="Q"),
            "disc": plane.Rigid(mass=2.0, inertia=2.0 * 0.3**2 / 2, center="P", velocity=(1.0, 0.0, -1.0 / 0.3)),
        },
        joints={
            "hinge": plane.Revolute(bodies=("board", "ground"), point="O"),
            "disc": plane.RollingDisc(bodies=("disc", "board"), points=("P", "Q")),
        },
        loads={"weight": plane.Gravity(acceleration=(0.0, -9.81))},
    )
    defects = []
    for step in (1e-2, 5e-3):
        found = simulate(compile_scene(scene), RunOptions(end_time=1.0, step=step, rho_inf=1.0))
        mass, inertia = np.array([5.0, 2.0]), np.array([1.0, 0.09])
        q, v = found.q.reshape(-1, 2, 3), found.v.reshape(-1, 2, 3)
        energy = (v[:, :, :2] ** 2).sum(axis=2) @ mass / 2 + v[:, :, 2] ** 2 @ inertia / 2 + 9.81 * q[:, :, 1] @ mass
        defects.append(np.ptp(energy))
        assert np.ptp(q[:, 0, 2]) > 0.1
    assert defects[1] < 0.01 * 9.81 * 2
    assert 3.5 < defects[0] / defects[1] < 4.5


def spatial_rack(axis: np.ndarray, along: np.ndarray) -> ffrf.Scene:
    aside, centre = np.cross(axis, along), np.array([0.1, 0.2, -0.3])
    return ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points=at(P=tuple(centre), Q=tuple(centre - 0.25 * aside + 0.1 * axis)),
        bodies={
            "pinion": space.Rigid(mass=1.0, inertia=(0.02,) * 3, center="P"),
            "rack": space.Rigid(mass=3.0, inertia=(0.1,) * 3, center="Q"),
        },
        joints={
            "axle": space.Revolute(bodies=("pinion", "ground"), point="P", axis=tuple(axis)),
            "guide": space.Prismatic(bodies=("rack", "ground"), point="Q", axis=tuple(along)),
            "rack": space.Rack(bodies=("pinion", "rack"), points=("P", "Q"), axis=tuple(axis), along=tuple(along)),
        },
        loads={"motor": space.Torque(body="pinion", point="P", torque=tuple(0.4 * axis))},
        responses={"moved": space.Displacement(body="rack", point="Q", component="x")},
    )


def test_a_pinion_pushes_its_rack_in_space():
    along, _, axis = axes_along(AXIS).T
    errors = []
    for step in (2e-3, 1e-3):
        found = run(spatial_rack(axis, along), step, 2.0)
        moved = 0.25 * 0.4 * found.times**2 / 2 / (0.02 + 3.0 * 0.25**2)
        errors.append(np.abs((found.q[:, 7:10] - found.q[0, 7:10]) - np.outer(moved, along)).max() / moved[-1])
    assert moved[-1] / 0.25 > 0.5 * TURN
    assert errors[1] < 1e-4  # second order: (4 rad/s x 1 ms)^2
    assert 3.5 < errors[0] / errors[1] < 4.5
    gradients(spatial_rack(axis, along), ["points.P.y", "points.Q.z", "bodies.rack.mass"], "moved", 5e-3, 0.1)


# --- screws --------------------------------------------------------------------------------------------------------------------------


def falling_nut(pitch: float) -> ffrf.Scene:
    return ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points=at(P=(0.3, -0.2, 0.1)),
        bodies={"nut": space.Rigid(mass=2.0, inertia=(0.03, 0.03, 0.03), center="P")},
        joints={"screw": space.Screw(bodies=("nut", "ground"), point="P", axis=(0.0, 0.0, 1.0), pitch=pitch)},
        loads={"weight": space.Gravity(acceleration=(0.0, 0.0, -9.81))},
        responses={"z": space.Displacement(body="nut", point="P", component="z")},
    )


@pytest.mark.parametrize("pitch", [0.2, -0.2])
def test_a_nut_falls_on_its_thread(pitch):
    """z'' = - g / (1 + J (2 pi / pitch)^2 / m), over many turns, to the right or to the left."""
    errors = []
    for step in (1e-3, 5e-4):
        found = run(falling_nut(pitch), step, 2.0)
        fallen = 9.81 / (1 + 0.03 * (TURN / pitch) ** 2 / 2.0) * found.times**2 / 2
        errors.append(np.abs(found.q[:, 2] - 0.1 + fallen).max() / fallen[-1])
        spin = 2 * (found.q[:, 3] * found.v[:, 6] - found.q[:, 6] * found.v[:, 3])  # about z: 2 (p_0 p_3' - p_3 p_0')
        np.testing.assert_allclose(spin, found.v[:, 2] * TURN / pitch, atol=1e-3 * np.abs(spin).max())  # the rates drift a little
    assert fallen[-1] > 5 * abs(pitch)
    assert errors[1] < 1e-2  # second order: 40 rad/s at the end, (40 x 5e-4)^2
    assert 3.3 < errors[0] / errors[1] < 4.7


def test_the_gradient_by_the_pitch_is_that_of_the_closed_form():
    """By p: z = - g t^2 / 2 / (1 + J (2 pi / p)^2 / m)."""
    ratio = 0.03 * (TURN / 0.2) ** 2 / 2.0
    slope = -9.81 * 0.1**2 / 2 / (1 + ratio) ** 2 * 2 * ratio / 0.2
    (found,) = gradients(falling_nut(0.2), ["joints.screw.pitch"], "z", 2e-3, 0.1)
    assert found == pytest.approx(slope, rel=1e-3)  # second order, as the motion


# --- what nobody can mean ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "numbers", "message"),
    [
        (plane.Gear, {}, "one of `ratio`, `radii` and `teeth`, not none of them"),
        (plane.Gear, {"ratio": 2.0, "teeth": (10, 20)}, "not ratio and teeth"),
        (plane.Gear, {"ratio": 0.0}, "is zero"),
        (plane.Gear, {"teeth": (-10, -20)}, "of two wheels one at most is a ring"),
        (space.Gear, {"axis": AXIS, "teeth": (10, 0)}, "at least one tooth"),
        (space.Gear, {"axis": AXIS, "ratio": 2.0}, "Extra inputs"),
        (space.Rack, {"axis": AXIS, "along": AXIS}, "perpendicular to the axis of its pinion"),
        (plane.Rack, {"radius": -0.1}, "greater than 0"),
    ],
)
def test_numbers_that_no_gear_has_are_refused(kind, numbers, message):
    with pytest.raises(ValueError, match=message):
        kind(bodies=("a", "b"), points=("A", "B"), **numbers)


def test_a_screw_without_pitch_is_refused():
    with pytest.raises(ValueError, match="a screw without pitch is a revolute joint"):
        space.Screw(bodies=("a", "b"), point="A", axis=AXIS, pitch=0.0)


def test_radii_that_miss_the_distance_of_the_centres_are_refused():
    scene = geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), radii=(0.1, 0.25)))
    with pytest.raises(InputError, match=r"points 'A' and 'B' add up to 0\.35, but the centres are 0\.4 apart"):
        compile_scene(scene)


def test_wheels_with_one_centre_are_refused():
    scene = geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), ratio=2.0))
    with pytest.raises(InputError, match="both centres at one place"):
        compile_scene(scene.model_copy(update={"points": at(A=(0.3, 0.1), B=(0.3, 0.1))}))


def test_a_pinion_on_the_line_of_its_rack_is_refused():
    scene = pinion_and_rack()
    with pytest.raises(InputError, match="point 'P', the centre of a wheel, is on the line through 'Q'"):
        compile_scene(scene.model_copy(update={"points": at(P=(0.5, 0.0), Q=(0.0, 0.0))}))


def test_a_disc_that_does_not_touch_its_line_is_refused():
    with pytest.raises(InputError, match=r"contact of joint 'disc' is violated by -0\.05"):
        simulate(compile_scene(disc(plane.RollingDisc, 0.3, radius=0.35)))


class Coupled(plane.Gear):
    """A joint of one's own with a point on each body."""

    kind = "test-coupled"

    def constraint(self, scene: object) -> tuple[Row, ...]:
        """Both turn alike."""
        a, b = self.poses
        return (Row("rotation", "angle", a.angle - b.angle),)


def test_points_of_a_joint_that_needs_no_direction_may_lie_at_one_place():
    """Two wheels that one shaft couples."""
    scene = geared_wheels(Coupled(bodies=("small", "large"), points=("A", "B"), ratio=1.0))
    found = run(scene.model_copy(update={"points": at(A=(0.3, 0.1), B=(0.3, 0.1))}))
    np.testing.assert_allclose(found.q[:, 5], 0.25 * found.times**2 / (0.02 + 1.5), atol=1e-8)


def test_a_rod_of_no_length_is_still_refused():
    scene = geared_wheels(plane.Distance(bodies=("small", "large"), points=("A", "B")))
    with pytest.raises(InputError, match=r"joints\.gear leads from point 'A' to point 'B', which are at the same place"):
        compile_scene(scene.model_copy(update={"points": at(A=(0.3, 0.1), B=(0.3, 0.1))}))
