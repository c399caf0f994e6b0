"""Controllers against closed forms of the linear systems that they make, in the plane and in space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.linalg import expm

import ffrf
from ffrf import plane, space
from tests.models.directions import along, derivative_along, felt_direction
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError
from toolkit.system.system import compile_scene

INERTIA, MASS, TORQUE, FORCE = 0.5, 2.0, 3.0, 5.0
GAINS = {"proportional_gain": 20.0, "derivative_gain": 2.0}
INTEGRAL = 15.0
SET = 0.7
Z = (0.0, 0.0, 1.0)


def rotor(dimension: int, curve: Any = None, torque: float = TORQUE, options: dict | None = None, **gains: Any) -> ffrf.Scene:
    """A rotor on its axle with a motor, under a torque."""
    curve = curve or plane.Constant(value=SET)
    place = {"bodies": ("rotor", "ground"), "point": "O"}
    options = {"end_time": 2.0, "step": 0.02, "assemble": False, **(options or {})}
    if dimension == 2:
        return ffrf.Scene(
            units="m-kg-s",
            points={"O": plane.Point(x=0.3, y=-0.2)},
            bodies={"rotor": plane.Rigid(mass=1.0, inertia=INERTIA, center="O")},
            joints={"axle": plane.Revolute(**place)},
            loads={
                "motor": plane.AngleController(**place, **GAINS, **gains, curve=curve),
                "push": plane.Torque(body="rotor", point="O", torque=torque),
            },
            responses={"angle": plane.Rotation(body="rotor", point="O")},
            solver=options,
        )
    return ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        points={"O": space.Point(x=0.3, y=-0.2, z=0.1)},
        bodies={"rotor": space.Rigid(mass=1.0, inertia=(0.3, 0.4, INERTIA), center="O")},
        joints={"axle": space.Revolute(**place, axis=Z)},
        loads={
            "motor": space.AngleController(**place, axis=Z, **GAINS, **gains, curve=curve),
            "push": space.Torque(body="rotor", point="O", torque=(0.0, 0.0, torque)),
        },
        responses={"angle": space.Rotation(body="rotor", point="O", axis=Z)},
        solver=options,
    )


def block(dimension: int, options: dict | None = None, curve: Any = None, **gains: Any) -> ffrf.Scene:
    """A block on a skew guide with a linear motor, under a force along the guide."""
    way, curve = np.array([0.8, -0.6, 0.0][:dimension]), curve or plane.Constant(value=SET)
    place = {"bodies": ("block", "ground"), "point": "O"}
    kinds: Any = plane if dimension == 2 else space
    point = {"x": 0.3, "y": -0.2} | ({} if dimension == 2 else {"z": 0.1})
    inertia = 0.1 if dimension == 2 else (0.1, 0.1, 0.1)
    guide = plane.Slider(**place, axis=way, lock_rotation=True) if dimension == 2 else space.Prismatic(**place, axis=way)
    return ffrf.Scene(
        units="m-kg-s",
        dimension=dimension,
        points={"O": kinds.Point(**point)},
        bodies={"block": kinds.Rigid(mass=MASS, inertia=inertia, center="O")},
        joints={"guide": guide},
        loads={
            "motor": kinds.PositionController(**place, axis=way, **GAINS, **gains, curve=curve),
            "push": kinds.PointForce(body="block", point="O", force=FORCE * way),
        },
        responses={"way": kinds.Displacement(body="block", point="O", component="x")},
        solver={"end_time": 2.0, "step": 0.02, **(options or {})},
    )


def closed_form(mass: float, push: float, time: float, integral: float) -> float:
    """m g'' = k_p (s - g) + k_i x - k_d g' + push, x' = s - g from rest; a linear system of three states and a constant."""
    k_p, k_d = GAINS["proportional_gain"], GAINS["derivative_gain"]
    A = [[0, 1, 0, 0], [-k_p / mass, -k_d / mass, integral / mass, (k_p * SET + push) / mass], [-1, 0, 0, SET], [0] * 4]
    return float((expm(np.array(A) * time) @ [0, 0, 0, 1])[0])


SETTINGS = [
    {},
    {"rho_inf": 0.0},
    {"scheme": "paper", "rho_inf": 1.0},
    {"formulation": "index-3"},
    {"formulation": "ggl"},
]


@pytest.mark.parametrize("gains", [{}, {"integral_gain": INTEGRAL}], ids=["PD", "PID"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("options", SETTINGS, ids=lambda options: " ".join(map(str, options.values())) or "default")
def test_a_controlled_rotor_moves_as_the_linear_system_says(dimension, options, gains):
    time = 0.5  # while it still swings
    exact = closed_form(INERTIA, TORQUE, time, gains.get("integral_gain", 0.0))
    scenes = [rotor(dimension, options={**options, "end_time": time, "step": step}, **gains) for step in (0.005, 0.0025)]
    runs = [ffrf.compile(scene).simulate() for scene in scenes]
    errors = np.abs([run.values["angle"] - exact for run in runs])
    assert errors[-1] < 3e-4  # (step / time scale)^2 = (0.0025 / 0.15)^2
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)  # second order: the integral takes nothing from it
    assert runs[-1].verdict.trusted


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_controlled_block_is_a_double_integrator_with_its_closed_form(dimension):
    exact = 0.8 * closed_form(MASS, FORCE, 2.0, INTEGRAL)
    errors = [
        abs(ffrf.compile(block(dimension, {"step": step}, integral_gain=INTEGRAL)).simulate().values["way"] - exact)
        for step in (0.02, 0.01)
    ]
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("dimension", [2, 3])
def test_an_integral_brings_the_steady_error_to_zero_and_nothing_else_does(dimension):
    long = {"end_time": 40.0, "step": 0.02}
    without = ffrf.compile(rotor(dimension, options=long)).simulate()
    led = ffrf.compile(rotor(dimension, options=long, integral_gain=INTEGRAL)).simulate()
    assert without.values["angle"] - SET == pytest.approx(TORQUE / GAINS["proportional_gain"], rel=1e-10)
    assert abs(led.values["angle"] - SET) < 1e-9  # the slowest root decays like exp(-0.8 t) for 40 s; no step's error stays


def test_without_an_integral_a_moving_set_value_is_followed_with_the_lag_that_is_told():
    ramp = plane.Polynomial(coefficients=(0.0, 0.3))
    found = ffrf.compile(rotor(2, curve=ramp, torque=0.0, options={"end_time": 10.0})).simulate()
    lag = GAINS["derivative_gain"] * 0.3 / GAINS["proportional_gain"]
    assert 3.0 - found.values["angle"] == pytest.approx(lag, abs=1e-8)  # exp(-2 * 10)


@pytest.mark.parametrize("dimension", [2, 3])
def test_an_equilibrium_with_an_integral_has_no_error_and_its_integral_carries_the_load(dimension):
    solution = solve_statics(compile_scene(rotor(dimension, integral_gain=INTEGRAL)))
    assert solution.q[0, -1] * INTEGRAL == pytest.approx(-TORQUE, rel=1e-12)
    assert solution.verdict.trusted
    found = ffrf.compile(rotor(dimension, integral_gain=INTEGRAL)).statics()
    assert found.values["angle"] == pytest.approx(SET, abs=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_an_equilibrium_without_an_integral_has_the_error_of_a_spring(dimension):
    found = ffrf.compile(rotor(dimension)).statics()
    assert found.values["angle"] == pytest.approx(SET + TORQUE / GAINS["proportional_gain"], rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_start_in_equilibrium_keeps_the_integral(dimension):
    scene = rotor(dimension, integral_gain=INTEGRAL, options={"start": "equilibrium"})
    run = simulate(compile_scene(scene), scene.solver)
    assert np.abs(run.v).max() < 1e-9
    assert np.abs(run.q[:, -1] * INTEGRAL + TORQUE).max() < 1e-9


def test_a_start_from_a_results_file_goes_on_with_its_integral(tmp_path):
    """Of the whole run's motion and gradients, but for the second rate of the integral, which starts at zero again: of second order."""
    paths, half = ["loads.motor.integral_gain", "loads.push.torque"], {"end_time": 1.0, "tolerance": 1e-13}
    found = {}
    for step in (0.02, 0.01):
        first, whole = (
            ffrf.compile(rotor(2, integral_gain=INTEGRAL, options={**half, "step": step, "end_time": end}), variables=paths)
            for end in (1.0, 2.0)
        )
        first.simulate(gradients=True).save(str(tmp_path / "first.h5"))
        scene = rotor(2, integral_gain=INTEGRAL, options={**half, "step": step, "start": str(tmp_path / "first.h5")})
        runs = [each.simulate(gradients=True) for each in (ffrf.compile(scene, variables=paths), whole)]
        found[step] = [np.array([run.values["angle"], *run.gradients["angle"].values()]) for run in runs]
    off = {step: np.abs(ours - exact) / np.abs(exact) for step, (ours, exact) in found.items()}
    assert off[0.01].max() < 3e-5  # without the integral, or its derivatives, it would be off by a tenth
    assert np.all(off[0.01] < off[0.02] / 3)


def test_a_motion_without_inertia_follows_the_first_order_system_that_is_left():
    """k_d g' = k_p (s - g) + k_i x + M, x' = s - g, from equilibrium, after the set value has begun to move: of first order in the step."""
    k_p, k_d, rate, time = GAINS["proportional_gain"], GAINS["derivative_gain"], 0.3, 2.0
    A = np.array([[-k_p / k_d, INTEGRAL / k_d, k_p / k_d * rate, 0], [-1, 0, rate, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
    exact = (expm(A * time) @ [0, 0, 0, 1])[0]  # of the deviation from the start, with the time as a third state
    ramp, errors = plane.Polynomial(coefficients=(0.0, rate)), []
    for step in (0.01, 0.005):
        options = {"end_time": time, "step": step, "quasi_static": True}
        found = ffrf.compile(rotor(2, curve=ramp, integral_gain=INTEGRAL, options=options)).simulate()
        errors.append(abs(found.values["angle"] - exact))
    assert errors[1] < 2e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("dimension", [2, 3])
def test_small_vibrations_have_the_roots_of_the_closed_loop(dimension):
    """I s^3 + k_d s^2 + k_p s + k_i = 0."""
    scene = rotor(dimension, integral_gain=INTEGRAL)
    kinds: Any = plane if dimension == 2 else space
    responses = {"damping": kinds.DampingRatio(number=1)}
    paths = ["loads.motor.integral_gain"]
    found = ffrf.compile(scene.model_copy(update={"responses": responses}), variables=paths).statics(gradients=True)

    def damping(integral: float) -> float:
        roots = np.roots([INERTIA, GAINS["derivative_gain"], GAINS["proportional_gain"], integral])
        root = roots[np.argmax(roots.imag)]
        return float(-root.real / abs(root))

    assert found.values["damping"] == pytest.approx(damping(INTEGRAL), rel=1e-10)
    slope = (damping(INTEGRAL + 1e-3) - damping(INTEGRAL - 1e-3)) / 2e-3
    assert found.gradients["damping"][paths[0]] == pytest.approx(slope, rel=1e-7)  # of the difference: round-off over its step


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_cylinder_holds_its_length_against_a_weight(dimension):
    """A mass on a vertical guide, held by a slanting cylinder from the side: its length is that of the set value."""
    kinds: Any = plane if dimension == 2 else space
    more = {} if dimension == 2 else {"z": 0.0}
    points = {"P": kinds.Point(x=0.0, y=1.0, **more), "Q": kinds.Point(x=1.0, y=0.0, **more)}
    up = (0.0, 1.0, 0.0)[:dimension]
    place = {"bodies": ("lift", "ground"), "point": "P", "axis": up}
    scene = ffrf.Scene(
        units="m-kg-s",
        dimension=dimension,
        points=points,
        bodies={"lift": kinds.Rigid(mass=2.0, inertia=0.1 if dimension == 2 else (0.1, 0.1, 0.1), center="P")},
        joints={"guide": plane.Slider(**place, lock_rotation=True) if dimension == 2 else space.Prismatic(**place)},
        loads={
            "weight": kinds.Gravity(acceleration=(0.0, -9.81, 0.0)[:dimension]),
            "cylinder": kinds.DistanceController(
                bodies=("lift", "ground"),
                points=("P", "Q"),
                proportional_gain=500.0,
                integral_gain=9.0,
                curve=plane.Constant(value=1.5),
            ),
        },
        responses={"rise": kinds.Displacement(body="lift", point="P", component="y")},
    )
    found = ffrf.compile(scene).statics()
    assert 1.0 + found.values["rise"] == pytest.approx(np.sqrt(1.5**2 - 1), rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_a_motor_puts_in_is_what_moves(dimension):
    scene = rotor(dimension, torque=0.0, integral_gain=INTEGRAL, options={"step": 0.002})
    kinds: Any = plane if dimension == 2 else space
    responses = {"work": kinds.Work(load="motor"), "energy": kinds.KineticEnergy()}
    gaps = []
    for step in (0.004, 0.002):
        solver = scene.solver.model_copy(update={"step": step, "end_time": 0.3})
        values = ffrf.compile(scene.model_copy(update={"responses": responses, "solver": solver})).simulate().values
        gaps.append(abs(values["work"] - values["energy"]))
    assert gaps[1] < 1e-3  # of about 1 J, by the trapezoidal rule
    assert np.log2(gaps[0] / gaps[1]) == pytest.approx(2.0, abs=0.1)


def test_gradients_by_gains_are_those_of_the_closed_form():
    """Against a complex step of the closed form's own formula, and direct = adjoint = complex step of the run."""
    paths = [
        "loads.motor.integral_gain",
        "loads.motor.proportional_gain",
        "loads.motor.derivative_gain",
        "loads.motor.curve.value",
    ]
    scene = rotor(2, integral_gain=INTEGRAL, options={"step": 0.004, "tolerance": 1e-13})
    run = gradients_by("direct", scene, paths, "transient")
    by = {"direct": run.gradients["angle"], "adjoint": gradients_by("adjoint", scene, paths, "transient").gradients["angle"]}
    assert by["adjoint"] == pytest.approx(by["direct"], rel=1e-10)
    factors = felt_direction({"angle": by["direct"]}, 0.0)
    judge = derivative_along(scene, factors, "transient", run.solution)["angle"]
    assert along(by["direct"], factors) == pytest.approx(judge, rel=0, abs=1e-10 * max(map(abs, by["direct"].values())))
    step = 1e-4
    slope = (closed_form(INERTIA, TORQUE, 2.0, INTEGRAL + step) - closed_form(INERTIA, TORQUE, 2.0, INTEGRAL - step)) / (2 * step)
    assert by["direct"]["loads.motor.integral_gain"] == pytest.approx(slope, rel=1e-2)  # the run's own error of second order


def test_a_cylinder_that_passes_length_zero_is_told():
    scene = ffrf.Scene(
        units="m-kg-s",
        points={"P": plane.Point(x=-1.0, y=0.0), "Q": plane.Point(x=0.0, y=0.0)},
        bodies={"sled": plane.Rigid(mass=1.0, inertia=0.1, center="P", velocity=(3.0, 0.0, 0.0))},
        joints={"rail": plane.Slider(bodies=("sled", "ground"), point="P", lock_rotation=True)},
        loads={
            "cylinder": plane.DistanceController(
                bodies=("sled", "ground"), points=("P", "Q"), proportional_gain=1.0, curve=plane.Constant(value=1.0)
            )
        },
        responses={"way": plane.Displacement(body="sled", point="P", component="x")},
        solver={"end_time": 0.5, "step": 0.003},
    )
    assert "spring-through-zero" in ffrf.compile(scene).simulate().verdict.codes


def test_wrong_controllers_are_refused():
    place = {"bodies": ("rotor", "ground"), "point": "O", "curve": plane.Constant(value=1.0)}
    with pytest.raises(ValidationError, match="greater than 0"):
        plane.AngleController(**place, integral_gain=0.0)
    with pytest.raises(ValidationError, match=r"controller has no effect without proportional_gain, derivative_gain or integral"):
        plane.AngleController(**place)
    with pytest.raises(ValidationError, match="an angle-controller acts between two different bodies, not on 'rotor' alone"):
        plane.AngleController(**{**place, "bodies": ("rotor", "rotor")}, proportional_gain=1.0)
    with pytest.raises(ValidationError, match="a distance-controller needs two different points"):
        plane.DistanceController(
            bodies=("rotor", "ground"), points=("O", "O"), curve=plane.Constant(value=1.0), proportional_gain=1.0
        )
    with pytest.raises(ValidationError, match="curve"):
        space.AngleController(bodies=("rotor", "ground"), point="O", axis=Z, proportional_gain=1.0)


def test_undamped_modes_of_an_integral_are_refused_with_what_to_ask_for():
    with pytest.raises(SingularSystemError, match=r"state of load 'motor' is an integral over time.*response damping-ratio"):
        ffrf.compile(rotor(2, integral_gain=INTEGRAL)).modes()


def test_an_undamped_frequency_of_an_integral_is_refused_too():
    scene = rotor(2, integral_gain=INTEGRAL).model_copy(update={"responses": {"f": plane.Frequency(number=1)}})
    with pytest.raises(InputError, match=r"state of load 'motor' is an integral over time.*response damping-ratio"):
        ffrf.compile(scene).statics()


def test_a_motor_in_space_that_stays_behind_by_half_a_turn_is_refused():
    with pytest.raises(ConvergenceError, match="the angle-controller 'motor' stays half a turn behind at t ="):
        ffrf.compile(rotor(3, torque=90.0)).simulate()


def test_a_motor_in_the_plane_counts_turns():
    found = ffrf.compile(
        rotor(2, curve=plane.SmoothStep(height=20.0, duration=2.0), torque=0.0, options={"end_time": 8.0})
    ).simulate()
    assert found.values["angle"] == pytest.approx(20.0, abs=1e-4)  # exp(-2 * 6) of 20 rad


@pytest.mark.parametrize(("integral", "radius"), [(None, 0.5 + (100 * 0.1 + 2 * 3**2 * 0.5) / (100 - 2 * 3**2)), (40.0, 0.6)])
def test_a_controlled_bead_on_a_spinning_arm_stands_where_its_spring_or_its_integral_says(integral, radius):
    """m w^2 r = k_p (r - 0.5 - s) without an integral; with one r = 0.5 + s."""
    scene = ffrf.Scene(
        units="m-kg-s",
        points={"O": plane.Point(x=0.0, y=0.0), "A": plane.Point(x=0.5, y=0.0)},
        bodies={
            "arm": plane.Rod(between=("O", "A"), area=1e-4, density=7800.0),
            "bead": plane.Rigid(mass=2.0, inertia=0.01, center="A"),
        },
        joints={
            "axle": plane.Revolute(bodies=("arm", "ground"), point="O"),
            "drive": plane.AngleDriver(bodies=("arm", "ground"), point="O", curve=plane.Polynomial(coefficients=(0.0, 3.0))),
            "guide": plane.Slider(bodies=("bead", "arm"), point="A", lock_rotation=True),
        },
        loads={
            "hold": plane.PositionController(
                bodies=("bead", "arm"),
                point="A",
                proportional_gain=100.0,
                derivative_gain=2.0,
                integral_gain=integral,
                curve=plane.Constant(value=0.1),
            )
        },
        responses={"radius": plane.PointDistance(bodies=("bead", "ground"), points=("A", "O"))},
        solver={"end_time": 1.0, "equilibrium": "spinning"},
    )
    assert ffrf.compile(scene).statics().values["radius"] == pytest.approx(radius, rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("part", "grows"), [(0.95, False), (1.05, True)])
def test_an_equilibrium_that_a_controller_makes_flutter_is_doubted(dimension, part, grows):
    """m s^3 + k_d s^2 + k_p s + k_i = 0 has roots to the right from k_i = k_p k_d / m on (Hurwitz)."""
    k_p, k_d = GAINS["proportional_gain"], GAINS["derivative_gain"]
    integral = part * k_p * k_d / MASS
    rate = max(np.roots([MASS, k_d, k_p, integral]).real)
    found = ffrf.compile(block(dimension, integral_gain=integral)).statics().verdict
    assert found.trusted == (not grows) == (rate < 0)
    assert all(f"grows like exp({rate:.4g} t)" in each for each in found.reasons)
