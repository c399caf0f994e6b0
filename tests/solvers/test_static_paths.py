"""Statics follows the path of equilibria: no limit point, no bifurcation hides between its steps, and none is seen where none is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import lapack
from scipy.optimize import brentq

from tests.benchmarks.static_paths import judged
from tests.models.fine_path import FinePath
from tests.models.random_statics import KINDS, SNAPPING, WING, random_scene
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import PositionDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import BifurcationError, ConvergenceError, CriticalPointError, LimitPointError
from toolkit.scene.scene import Scene
from toolkit.solvers.static.static_matrix import Saddle, Softness, softest
from toolkit.system.system import System, compile_scene

PAST = RunOptions(continuation="arc-length")
LOAD_STEPS = (5, 10, 11, 12, 20, 50, 200)


# --- the wing whose path turns back twice within one load step -------------------------------------------------------------------


@pytest.fixture(scope="module")
def snapping() -> Scene:
    return read_scene(WING, {name: str(list(value) if isinstance(value, tuple) else value) for name, value in SNAPPING.items()})


@pytest.fixture(scope="module")
def judge(snapping) -> float:
    """Torque at its first limit point, by some hundred small steps."""
    found = FinePath(compile_scene(snapping), 1.0, 0.004).follow()
    assert found.what == "limit"
    return found.factor * SNAPPING["loads.drive.torque"]


@pytest.mark.parametrize("load_steps", LOAD_STEPS)
def test_a_snap_within_one_load_step_is_not_passed(snapping, judge, load_steps):
    with pytest.raises(LimitPointError, match=r"rotation of body 'body2' runs away") as error:
        solve_statics(compile_scene(snapping), RunOptions(load_steps=load_steps))
    # flat at the limit point: the load is exact to the square of the place, which is round-off in both
    assert error.value.load_factor * SNAPPING["loads.drive.torque"] == pytest.approx(judge, rel=1e-10)


def test_the_torque_that_snaps_is_the_same_whatever_the_full_torque(snapping, judge):
    """Load steps lie differently against the two limit points. (21 torques: `tests.benchmarks.static_paths`.)"""
    for part in np.linspace(0.95, 1.05, 5):
        torque = part * SNAPPING["loads.drive.torque"]
        with pytest.raises(LimitPointError) as error:
            solve_statics(compile_scene(snapping.with_number("loads.drive.torque", torque)))
        assert error.value.load_factor * torque == pytest.approx(judge, rel=1e-10)


def test_limit_points_do_not_depend_on_the_steps_along_the_path(snapping):
    paths = [solve_statics(compile_scene(snapping), PAST.model_copy(update={"load_steps": n})).path for n in (5, 10, 40, 160)]
    for path in paths[1:]:
        np.testing.assert_allclose(
            [limit.load_factor for limit in path.limit_points], [limit.load_factor for limit in paths[0].limit_points], rtol=1e-10
        )
        np.testing.assert_allclose(path.q[-1], paths[0].q[-1], rtol=0, atol=1e-9)  # mm and rad, of a scene of 200 mm


# --- a truss whose snap is as narrow as one likes --------------------------------------------------------------------------------

HALF_SPAN, HEIGHT, BAR = 1.0, 0.3, 1000.0
REST = np.hypot(HALF_SPAN, HEIGHT)
STEEPEST = 2 * BAR * (REST / HALF_SPAN - 1)
"""What the two bars push with per way at the dead point: a spring against the apex that is stiffer ends the snap."""
CENTRE = 0.55
"""Part of the load at the dead point."""


def bars(y: float) -> float:
    """Force down on the apex at height y, F = 2 k (l_0 / l - 1) y."""
    return 2 * BAR * (REST / np.hypot(HALF_SPAN, y) - 1) * y


def stayed_truss(narrow: float) -> Scene:
    """Two sprung bars, and a spring below their apex with a stiffness of (1 - narrow) STEEPEST."""
    stay = (1 - narrow) * STEEPEST
    places = {"P": (0.0, HEIGHT), "L": (-HALF_SPAN, 0.0), "R": (HALF_SPAN, 0.0), "F": (0.0, -5.0)}
    springs = {side: SpringDamper(bodies=("apex", "ground"), points=("P", side), stiffness=BAR) for side in ("L", "R")}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in places.items()},
        bodies={"apex": Rigid(mass=1.0, inertia=1.0, center="P")},
        joints={"guide": Slider(bodies=("apex", "ground"), point="P", axis=(0.0, 1.0), lock_rotation=True)},
        loads={
            **springs,
            "stay": SpringDamper(bodies=("apex", "ground"), points=("P", "F"), stiffness=stay),
            "push": PointForce(body="apex", point="P", force=(0.0, -stay * HEIGHT / CENTRE)),
        },
    )


def stayed_limits(narrow: float) -> list[float]:
    """Load factors where dF/dy = 0: l^3 = l_0 b^2 / (1 + k_s / 2 k), F = bars(y) + k_s (h - y)."""
    stay = (1 - narrow) * STEEPEST
    y = np.sqrt(np.cbrt(REST * HALF_SPAN**2 / (1 + stay / (2 * BAR))) ** 2 - HALF_SPAN**2)
    return [(bars(side * y) + stay * (HEIGHT - side * y)) / (stay * HEIGHT / CENTRE) for side in (1, -1)]


@pytest.mark.parametrize("load_steps", [1, 3, 10, 11, 30])
@pytest.mark.parametrize("narrow", [0.5, 0.2, 0.05, 0.01, 3e-3])
def test_a_snap_is_found_however_narrow_it_is(narrow, load_steps):
    """The narrowest lets the load fall by 2e-5 of itself, on 3 % of the way."""
    run = solve_statics(compile_scene(stayed_truss(narrow)), PAST.model_copy(update={"load_steps": load_steps}))
    assert [limit.load_factor for limit in run.path.limit_points] == pytest.approx(stayed_limits(narrow), rel=1e-9)
    with pytest.raises(LimitPointError) as error:
        solve_statics(compile_scene(stayed_truss(narrow)), RunOptions(load_steps=load_steps))
    assert error.value.load_factor == pytest.approx(stayed_limits(narrow)[0], rel=1e-9)


@pytest.mark.parametrize("load_steps", [1, 3, 10, 11, 30])
@pytest.mark.parametrize("narrow", [-1e-3, -0.01, -0.1])
def test_a_path_that_nearly_turns_back_goes_on(narrow, load_steps):
    run = solve_statics(compile_scene(stayed_truss(narrow)), RunOptions(load_steps=load_steps))
    stay = (1 - narrow) * STEEPEST
    exact = brentq(lambda y: bars(y) + stay * (HEIGHT - y) - stay * HEIGHT / CENTRE, -2 * HEIGHT, HEIGHT, xtol=1e-15)
    assert run.q[0, 1] == pytest.approx(exact, abs=1e-12)
    assert not run.path.passed_limit


# --- stability that is lost and comes back within a step -------------------------------------------------------------------------

LENGTH, WAY, WEIGHT = 1.0, 1.0, 10.0
"""A weight that a driver lets slide down an upright rod as the load grows: m g s (L - s d), s = load factor, tilts it."""


def sliding_weight(lost: float) -> Scene:
    """The spring at the foot of the rod holds it upright up to a part `lost` of the load, and again from 1 - lost on."""
    stiffness = WEIGHT * lost * (LENGTH - lost * WAY)
    places = {"O": (0.0, 0.0), "A": (0.0, LENGTH)}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in places.items()},
        bodies={
            "rod": Rod(between=("O", "A"), area=1.0, density=1e-9),
            "weight": Rigid(mass=1.0, inertia=1.0, center="A"),
        },
        joints={
            "foot": Revolute(bodies=("rod", "ground"), point="O"),
            "guide": Slider(bodies=("weight", "rod"), point="A", axis=(0.0, 1.0), lock_rotation=True),
            "slide": PositionDriver(bodies=("weight", "rod"), point="A", axis=(0.0, 1.0), curve=SmoothStep(height=-WAY)),
        },
        loads={
            "spring": RotationalSpringDamper(bodies=("rod", "ground"), point="O", stiffness=stiffness),
            "push": PointForce(body="weight", point="A", force=(0.0, -WEIGHT)),
        },
    )


@pytest.mark.parametrize("load_steps", [5, 7, 9, 11])
@pytest.mark.parametrize("lost", [0.41, 0.46, 0.49, 0.499])
def test_stability_that_comes_back_within_a_step_was_lost(lost, load_steps):
    with pytest.raises(BifurcationError, match=r"bifurcation .*rotation of body 'rod'|bifurcation .*body 'weight'") as error:
        solve_statics(compile_scene(sliding_weight(lost)), RunOptions(load_steps=load_steps))
    assert error.value.load_factor == pytest.approx(lost, abs=1e-6)  # the shortest step


# --- drivers that move to where the joints let nothing move, and past it ---------------------------------------------------------

CRANK, ROD, START = 0.5, 1.2, 0.6
DEAD_POINT = CRANK + ROD
SLIDER = CRANK * np.cos(START) + np.sqrt(ROD**2 - (CRANK * np.sin(START)) ** 2)


def pulled(reach: float) -> Scene:
    """A slider-crank whose slider is driven to a distance from the crank's foot."""
    places = {"O": (0.0, 0.0), "T": (CRANK * np.cos(START), CRANK * np.sin(START)), "X": (SLIDER, 0.0)}
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in places.items()},
        bodies={
            "crank": Rod(between=("O", "T"), area=1.0, density=1.0),
            "rod": Rod(between=("T", "X"), area=1.0, density=1.0),
        },
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "T": Revolute(bodies=("crank", "rod"), point="T"),
            "X": Slider(bodies=("rod", "ground"), point="X", axis=(1.0, 0.0)),
            "pull": PositionDriver(bodies=("rod", "ground"), point="X", axis=(1.0, 0.0), curve=SmoothStep(height=reach - SLIDER)),
        },
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
    )


@pytest.mark.parametrize("load_steps", [1, 10, 50])
@pytest.mark.parametrize("reach", [1.65, 1.699, 1.69999])
def test_a_driver_is_followed_up_to_the_dead_point(reach, load_steps):
    run = solve_statics(compile_scene(pulled(reach)), RunOptions(load_steps=load_steps))
    angle = np.arccos((reach**2 + CRANK**2 - ROD**2) / (2 * reach * CRANK))
    # of the crank; next to the dead point the angle is the root of the length, which is known to round-off
    assert run.q[0, 2] == pytest.approx(angle - START, abs=1e-15 / angle + 1e-12)


@pytest.mark.parametrize("load_steps", [1, 10, 50])
@pytest.mark.parametrize("reach", [1.700001, 1.71, 1.8, 2.5])
def test_a_driver_past_the_dead_point_is_refused_there(reach, load_steps):
    with pytest.raises(LimitPointError) as error:
        solve_statics(compile_scene(pulled(reach)), RunOptions(load_steps=load_steps))
    assert error.value.load_factor == pytest.approx((DEAD_POINT - SLIDER) / (reach - SLIDER), rel=1e-12)


@pytest.mark.parametrize("load_steps", [1, 2, 3, 10, 15, 50])
def test_a_driver_to_the_dead_point_is_refused_whatever_the_round_off(load_steps):
    with pytest.raises(CriticalPointError):
        solve_statics(compile_scene(pulled(DEAD_POINT)), RunOptions(load_steps=load_steps))


# --- motions without inertia -----------------------------------------------------------------------------------------------------


def in_time(scene: Scene) -> System:
    """The same with a load that grows from zero within a second."""
    push = scene.loads["push"].model_copy(update={"curve": SmoothStep(height=1.0, duration=1.0)})
    return compile_scene(scene.model_copy(update={"loads": {**scene.loads, "push": push}}))


def time_of(load: float) -> float:
    """When t^3 (10 - 15 t + 6 t^2) is a load factor."""
    return brentq(lambda t: t**3 * (10 - 15 * t + 6 * t**2) - load, 0, 1, xtol=1e-15)


def without_inertia(step: float) -> RunOptions:
    return RunOptions(end_time=1.0, step=step, quasi_static=True)


@pytest.mark.parametrize("step", [0.3, 0.1, 0.07, 0.02, 0.01, 0.003])
@pytest.mark.parametrize("narrow", [0.05, 3e-3])
def test_a_motion_without_inertia_does_not_pass_a_snap_between_two_times(narrow, step):
    """The next equilibrium is so near that a step finds it."""
    with pytest.raises(ConvergenceError, match=r"quasi-static motion jumps at t = .*snap-through") as error:
        simulate(in_time(stayed_truss(narrow)), without_inertia(step))
    named = float(str(error.value).split("t = ")[1].split(":")[0])
    assert named == pytest.approx(time_of(stayed_limits(narrow)[0]), abs=1e-6)  # six digits are printed


@pytest.mark.parametrize("step", [0.3, 0.1, 0.07, 0.02, 0.01, 0.003])
@pytest.mark.parametrize("narrow", [-1e-3, -0.01])
def test_a_motion_without_inertia_that_nearly_turns_back_goes_on(narrow, step):
    run = simulate(in_time(stayed_truss(narrow)), without_inertia(step))
    assert run.q[-1, 1] == pytest.approx(solve_statics(compile_scene(stayed_truss(narrow))).q[0, 1], abs=1e-9)


@pytest.mark.parametrize("step", [0.1, 0.01])
def test_a_motion_without_inertia_does_not_stay_on_a_column_that_has_buckled(step):
    with pytest.raises(ConvergenceError, match=r"unstable from t = .*buckling") as error:
        simulate(in_time(sliding_weight(0.3)), without_inertia(step))
    named = float(str(error.value).split("t = ")[1].split()[0].rstrip(":"))
    assert time_of(0.3) - 1e-6 <= named <= time_of(0.3) + step


# --- random scenes ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "wing"])
def test_random_scenes_end_where_a_path_of_small_steps_ends(kind, seed):
    """A few of those of `python -m tests.benchmarks.static_paths`."""
    _, wrong, _ = judged(random_scene(kind, 1000 + seed), length=0.02, load_steps=(1, 10))
    assert not wrong


@pytest.mark.parametrize("told", [0, 1, 2])
def test_soft_motions_are_found_from_a_point_near_by_that_tells_fewer_of_them(told):
    """Diagonal stiffness, no joints: the softest two of 1, 2, 5, 9 from a point at which round-off had swallowed some."""
    saddle = Saddle(np.ones(4), *lapack.dsytrf(np.diag([9.0, 1.0, 5.0, 2.0]), lower=1)[:2], True, 0)
    known = Softness(np.array([1.1, 2.1])[:told], np.eye(4)[:, [1, 3]][:, :told])
    np.testing.assert_allclose(np.sort(softest(saddle, 4, 4, known).values), [1, 2], rtol=1e-3)  # six iterations: (2 / 5)^12
