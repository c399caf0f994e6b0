"""Statics follows the path of equilibria: no limit point, no bifurcation hides between its steps, and none is seen where none is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.fine_path import FinePath
from tests.random_statics import SNAPPING, WING
from toolkit.bodies.rigid import Rigid, Rod
from toolkit.errors import BifurcationError, LimitPointError
from toolkit.joints.driver import PositionDriver
from toolkit.joints.revolute import Revolute
from toolkit.joints.slider import Slider
from toolkit.loads.point_force import PointForce
from toolkit.loads.spring_damper import RotationalSpringDamper, SpringDamper
from toolkit.point import Point
from toolkit.profile import SmoothStep
from toolkit.run_options import RunOptions
from toolkit.scene import Scene
from toolkit.scene_file import read_scene
from toolkit.solvers.statics import solve_statics
from toolkit.system import compile_scene

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
    """21 torques within 5 %: load steps lie differently against the two limit points."""
    for part in np.linspace(0.95, 1.05, 21):
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
