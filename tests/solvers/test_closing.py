"""Joints that cannot be closed, and drivers that lead to a limit position: how they are told, against closed forms of triangles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy

from tests.spatial.scenes import at
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rod, SpatialRod
from toolkit.components.curves.polynomial import Constant
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.distance import Distance, SpatialDistance
from toolkit.components.joints.driver import AngleDriver, SpatialAngleDriver
from toolkit.components.joints.revolute import Revolute, SpatialRevolute
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, InputError, LimitPointError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

CRANK, COUPLER, ROCKER, GROUND = 1.0, 1.6, 1.2, 2.0
CORNER = np.arccos((CRANK**2 + GROUND**2 - (COUPLER + ROCKER) ** 2) / (2 * CRANK * GROUND))
"""Angle of the crank at which coupler and rocker are stretched, by the law of cosines: more than half a turn is closed to it."""
WRITTEN = 1.2
"""Angle of the crank as it is written."""


def tied(length: float, **solver: Any) -> Scene:
    """A crank of 1 m from O to A, whose end a bar of some length ties to a point that is 3 m from O, all on one line."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=1.0, y=0.0), "G": Point(x=3.0, y=0.0)},
        bodies={"crank": Rod(between=("O", "A"), area=1e-3, density=1e3)},
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "bar": Distance(bodies=("crank", "ground"), points=("A", "G"), length=length),
        },
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        solver=RunOptions(end_time=0.1, step=0.01, **solver),
    )


def four_bar(curve: Any, **solver: Any) -> Scene:
    """Crank OA, coupler AB and rocker BC of rigid rods, whose crank follows a curve from where it is written."""
    A = CRANK * np.array([np.cos(WRITTEN), np.sin(WRITTEN)])
    C = np.array([GROUND, 0.0])
    far = float(np.hypot(*(C - A)))
    along = (COUPLER**2 - ROCKER**2 + far**2) / (2 * far)
    e = (C - A) / far
    B = A + along * e + np.sqrt(COUPLER**2 - along**2) * np.array([-e[1], e[0]])
    places = {"O": (0.0, 0.0), "A": A, "B": B, "C": C}
    rods = {"crank": ("O", "A"), "coupler": ("A", "B"), "rocker": ("B", "C")}
    joints: dict[str, Any] = {
        "O": Revolute(bodies=("crank", "ground"), point="O"),
        "A": Revolute(bodies=("crank", "coupler"), point="A"),
        "B": Revolute(bodies=("coupler", "rocker"), point="B"),
        "C": Revolute(bodies=("rocker", "ground"), point="C"),
        "motor": AngleDriver(bodies=("crank", "ground"), point="O", curve=curve),
    }
    return Scene(
        units="m-kg-s",
        points={name: Point(x=float(x), y=float(y)) for name, (x, y) in places.items()},
        bodies={name: Rod(between=ends, area=1e-3, density=1e3) for name, ends in rods.items()},
        joints=joints,
        solver=RunOptions(end_time=1.0, step=solver.pop("step", 0.01), **solver),
    )


def refusal(solve: Callable[..., Any], scene: Scene, kind: type[Exception] = ConvergenceError) -> str:
    """What a run that is refused says."""
    with pytest.raises(kind) as error:
        solve(compile_scene(scene))
    return str(error.value)


@pytest.mark.parametrize("solve", [simulate, solve_statics])
@pytest.mark.parametrize(("length", "gap"), [(1.75, "0.25 m"), (1.98, "0.02 m"), (4.5, "0.5 m")])
def test_a_bar_that_no_triangle_has_is_told_by_its_gap(solve, length, gap):
    # |3 - 1| <= length <= 3 + 1 by the inequality of triangles
    assert (
        f"joints cannot be closed: in the nearest positions that were found, distance of joint 'bar' is open by {gap.rjust(3)}"
        in (refusal(solve, tied(length, assemble=True)).replace("open by -", "open by "))
    )


def test_a_dead_point_that_a_longer_bar_begins_in_is_no_contradiction_of_joints():
    turn = np.arccos((1 + 9 - 2.5**2) / 6)  # law of cosines
    assert f"rotation of body 'crank' would move by {turn:.2g}" in refusal(simulate, tied(2.5, assemble=True))
    assert "rotation of body 'crank' moved by" in refusal(simulate, tied(2.05, assemble=True))


def test_statics_refuses_a_joint_that_was_left_out_and_is_open():
    said = refusal(solve_statics, tied(1.75, redundant="least-squares"))
    assert f"other joints imply it at the start; it is open by {np.sqrt(10) - 1.75:.3g} m" in said  # of the crank that hangs


def test_gaps_of_a_bar_are_lengths():
    assert "distance of joint 'bar' is violated by 0.25 m" in refusal(simulate, tied(1.75), InputError)


@pytest.mark.parametrize("solver", [{}, {"step": 0.05}, {"formulation": "ggl"}, {"local_error": 1e-5}, {"quasi_static": True}])
def test_a_run_whose_driver_goes_on_behind_a_limit_position_says_where_that_is(solver):
    said = refusal(simulate, four_bar(SmoothStep(height=2.5, duration=1.0), **solver))
    assert f"limit position at t = {_time_of(CORNER - WRITTEN, 2.5):.4g}" in said
    assert f"joint 'motor' comes to {CORNER - WRITTEN:.3g} rad and no further, where its curve goes on to 2.5 rad" in said


def _time_of(turn: float, height: float) -> float:
    times = np.linspace(0, 1, 200001)
    return float(np.interp(turn / height, times**3 * (10 - 15 * times + 6 * times**2), times))


@pytest.mark.parametrize("solver", [{}, {"continuation": "arc-length", "path_steps": 20}])
def test_statics_calls_a_limit_position_no_snap_through(solver):
    said = refusal(solve_statics, four_bar(SmoothStep(height=2.5, duration=1.0), **solver))
    assert f"joint 'motor' comes to {CORNER - WRITTEN:.3g} rad and no further" in said
    assert f"at {100 * (CORNER - WRITTEN) / 2.5:.4g} % of the way of its drivers" in said
    assert "snap" not in said


def test_the_limit_point_of_a_mechanism_keeps_its_numbers():
    with pytest.raises(LimitPointError) as error:
        solve_statics(compile_scene(four_bar(SmoothStep(height=2.5, duration=1.0))))
    assert error.value.load_factor == pytest.approx((CORNER - WRITTEN) / 2.5, rel=1e-5)


def test_a_driver_that_begins_behind_the_limit_position_is_told_how_far_it_comes():
    said = refusal(simulate, four_bar(Constant(value=1.5), assemble=True))
    assert f"it comes to {CORNER - WRITTEN:.4g} rad, where its curve asks for 1.5 rad" in said


@pytest.mark.parametrize("turn", [-0.58, 0.5])
def test_a_driver_may_begin_as_far_away_in_the_plane_as_in_space(turn):
    run = simulate(compile_scene(four_bar(Constant(value=turn), assemble=True)))
    assert run.q[0][2] == pytest.approx(turn, rel=1e-12)  # round-off
    assert run.drift <= 1e-12


def in_space(driven: str, height: float, **bar: float) -> Scene:
    """A crank of 0.3 m about x and a rocker of 0.5 m about z, 1 m and 0.4 m away, which a bar ties to each other."""
    turns: dict[str, dict[str, Any]] = {
        "crank": {"bodies": ("crank", "ground"), "point": "O", "axis": (1.0, 0.0, 0.0)},
        "rocker": {"bodies": ("rocker", "ground"), "point": "C", "axis": (0.0, 0.0, 1.0)},
    }
    places = {"O": (0.0, 0.0, 0.0), "A": (0.0, 0.3, 0.0), "B": (1.0, 0.5, 0.4), "C": (1.0, 0.0, 0.4)}
    joints: dict[str, Any] = {name: SpatialRevolute(**each) for name, each in turns.items()}
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={**at(**places)},
        bodies={
            name: SpatialRod(between=ends, area=1e-3, density=1e3)
            for name, ends in (("crank", ("O", "A")), ("rocker", ("C", "B")))
        },
        joints={
            **joints,
            "bar": SpatialDistance(bodies=("crank", "rocker"), points=("A", "B"), **bar),
            "motor": SpatialAngleDriver(**turns[driven], curve=SmoothStep(height=height, duration=1.0)),
        },
        solver=RunOptions(end_time=1.0, step=0.01, assemble=True),
    )


def test_a_bar_in_space_that_is_too_short_is_told_by_its_gap():
    # its ends are (1 - s / 2)^2 + (c / 2 - 0.3)^2 + 0.4^2 apart, squared, with sine s and cosine c of the rocker
    nearest = np.sqrt(1.5 - np.hypot(1, 0.3))
    assert f"distance of joint 'bar' is open by {nearest - 0.4:.4g} m" in refusal(simulate, in_space("crank", 1.0, length=0.4))


def test_the_limit_position_of_a_driver_in_space():
    # of the crank's angle the square above lacks 0.6 (c / 2 cos + 0.4 sin): it is 1.2, that of the bar, up to this angle of the rocker
    turn = scipy.optimize.brentq(lambda angle: np.sin(angle) - 0.3 - 0.6 * np.hypot(np.cos(angle) / 2, 0.4), 0, 1)
    assert f"joint 'motor' comes to {turn:.3g} rad and no further" in refusal(simulate, in_space("rocker", 1.5))
