"""Limit points of statics, the path past them, and what is said there: a shallow truss in closed form, and a wing that snaps through."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

from toolkit.analyses.modes import solve_modes
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.command_line.cli import app
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import RotationalSpringDamper, SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import BifurcationError, ConvergenceError, CriticalPointError, CriticalStateError, LimitPointError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

WING = Path(__file__).parents[2] / "models" / "snap_through" / "scene.toml"
PAST = RunOptions(continuation="arc-length")

HALF_SPAN, HEIGHT, BAR = 1.0, 0.3, 1000.0
REST = np.hypot(HALF_SPAN, HEIGHT)


def bars(y: float) -> float:
    """Force down on the apex at height y: F = 2 k (l_0 / l - 1) y, l^2 = b^2 + y^2 (von Mises truss of two sprung bars)."""
    return 2 * BAR * (REST / np.hypot(HALF_SPAN, y) - 1) * y


def slope(y: float) -> float:
    """dF/dy = 2 k (l_0 b^2 / l^3 - 1)."""
    return 2 * BAR * (REST * HALF_SPAN**2 / np.hypot(HALF_SPAN, y) ** 3 - 1)


TURN = np.sqrt(np.cbrt(REST * HALF_SPAN**2) ** 2 - HALF_SPAN**2)  # dF/dy = 0
LIMIT = bars(TURN)


def truss(force: float) -> Scene:
    points = {"P": Point(x=0.0, y=HEIGHT), "L": Point(x=-HALF_SPAN, y=0.0), "R": Point(x=HALF_SPAN, y=0.0)}
    springs = {side: SpringDamper(bodies=("apex", "ground"), points=("P", side), stiffness=BAR) for side in ("L", "R")}
    return Scene(
        units="m-kg-s",
        points=points,
        bodies={"apex": Rigid(mass=1.0, inertia=1.0, center="P")},
        joints={"guide": Slider(bodies=("apex", "ground"), point="P", axis=(0.0, 1.0), lock_rotation=True)},
        loads={**springs, "push": PointForce(body="apex", point="P", force=(0.0, -force))},
    )


FORCE = "loads.push.force.y"


@pytest.mark.parametrize("part", [1 + 1e-9, 1.001, 1.3, 50.0])
def test_the_limit_load_is_that_of_the_closed_form(part):
    with pytest.raises(
        LimitPointError, match=r"at a limit point \(snap-through\).*y of body 'apex' runs away.*--past-limit"
    ) as error:
        solve_statics(compile_scene(truss(part * LIMIT)))
    # the load is flat at the limit point: exact to the square of the Newton tolerance, so to round-off
    assert error.value.load_factor * part == pytest.approx(1, rel=1e-11)
    assert error.value.coordinate == "y of body 'apex'"


def test_a_load_that_misses_the_limit_by_a_millionth_is_still_carried():
    """Load stepping gives up a ten-thousandth before; the rest goes by arc length."""
    force = (1 - 1e-6) * LIMIT
    found = solve_statics(compile_scene(truss(force))).q[0, 1]
    exact = brentq(lambda y: bars(y) - force, TURN, HEIGHT, xtol=1e-15)
    assert found == pytest.approx(
        exact, abs=1e-10
    )  # round-off of the force over the stiffness, which is a thousandth of the start's


def test_the_path_past_the_snap_is_that_of_the_closed_form_to_the_stable_branch():
    force = 1.3 * LIMIT
    run = solve_statics(compile_scene(truss(force)), PAST)
    y, path = run.q[0, 1], run.path
    assert y == pytest.approx(brentq(lambda y: bars(y) - force, -2.0, -TURN, xtol=1e-15), rel=1e-12)
    np.testing.assert_allclose(path.load_factors * force, bars(path.q[:, 1]), rtol=0, atol=1e-8 * LIMIT)
    assert np.all(np.diff(path.q[:, 1]) < 0)  # it never turns back on itself
    assert [limit.load_factor * force for limit in path.limit_points] == pytest.approx([LIMIT, -LIMIT], rel=1e-11)
    # the place of a flat maximum is known to the root of what its height is known to
    assert [path.q[limit.place, 1] for limit in path.limit_points] == pytest.approx([TURN, -TURN], rel=1e-8)
    stable = np.sqrt(-slope(y)) / (2 * np.pi)  # 1 kg on the stiffness against moving down
    assert solve_modes(run, 1).frequencies == pytest.approx([stable], rel=1e-9)


def test_gradients_beyond_the_snap_are_those_of_the_branch_reached():
    """dy/dF_y = 1 / (dF/dy), by direct differentiation and by the complex step, whose path is real."""
    force = 1.3 * LIMIT
    run = solve_statics(compile_scene(truss(force), [FORCE]), PAST)
    exact = 1 / slope(run.q[0, 1])
    assert -run.dq[0, 1, 0] == pytest.approx(exact, rel=1e-10)
    stepped = solve_statics(compile_scene(truss(force).with_number(FORCE, -force + 1e-30j)), PAST)
    assert -stepped.q[0, 1].imag / 1e-30 == pytest.approx(exact, rel=1e-10)


def test_before_the_limit_point_arc_length_and_load_stepping_agree():
    force = 0.95 * LIMIT
    by_length, by_load = (solve_statics(compile_scene(truss(force)), options) for options in (PAST, RunOptions()))
    np.testing.assert_allclose(by_length.q, by_load.q, rtol=0, atol=1e-12)
    assert not by_length.path.passed_limit
    for path in (by_length.path, by_load.path):
        np.testing.assert_allclose(path.load_factors * force, bars(path.q[:, 1]), rtol=0, atol=1e-8 * LIMIT)


@pytest.mark.parametrize("distance", [1e-7, 1e-9])
def test_gradients_at_a_limit_point_are_refused_but_not_the_state(distance):
    given = truss((1 - distance) * LIMIT)
    assert solve_statics(compile_scene(given)).q[0, 1] == pytest.approx(TURN, abs=2 * np.sqrt(distance))
    with pytest.raises(CriticalStateError, match=r"no gradient at a limit point.*y of body 'apex'.*ask for the values alone"):
        solve_statics(compile_scene(given, [FORCE]))
    with pytest.raises(CriticalStateError):
        solve_statics(compile_scene(given.with_number(FORCE, given.number(FORCE) + 1e-30j)))


@pytest.mark.parametrize("distance", [1e-14, 1e-15, 0.0, -1e-15, -1e-14])
def test_a_load_that_is_the_limit_load_to_round_off_is_refused_as_such(distance):
    with pytest.raises(CriticalPointError, match="limit point") as error:
        solve_statics(compile_scene(truss((1 - distance) * LIMIT)))
    assert error.value.load_factor == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("distance", [1e-5, 1e-3])
def test_gradients_near_a_limit_point_are_large_and_right(distance):
    run = solve_statics(compile_scene(truss((1 - distance) * LIMIT), [FORCE]))
    # the state is known to round-off over the stiffness, which goes as the root of the distance, and enters once more
    assert -run.dq[0, 1, 0] == pytest.approx(1 / slope(run.q[0, 1]), rel=1e-9)


def column(force: float) -> Scene:
    """An upright rigid link of 1 m with a spring of 20 N m at its foot, under a force down: it buckles at 20 N."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "A": Point(x=0.0, y=1.0)},
        bodies={"rod": Rod(between=("O", "A"), area=1.0, density=3.0)},
        joints={"O": Revolute(bodies=("rod", "ground"), point="O")},
        loads={
            "spring": RotationalSpringDamper(bodies=("rod", "ground"), point="O", stiffness=20.0),
            "push": PointForce(body="rod", point="A", force=(0.0, -force)),
        },
    )


@pytest.mark.parametrize("continuation", ["load", "arc-length"])
@pytest.mark.parametrize("force", [21.0, 31.0, 40.0])
def test_a_bifurcation_is_told_from_a_limit_point_and_found(force, continuation):
    options = RunOptions(continuation=continuation)
    with pytest.raises(BifurcationError, match=r"unstable beyond a bifurcation \(buckling\) at .* % of the load") as error:
        solve_statics(compile_scene(column(force)), options)
    assert error.value.load_factor == pytest.approx(20.0 / force, abs=1e-6)  # a step of up to a fifth, halved twenty times
    assert error.value.coordinate in ("x of body 'rod'", "rotation of body 'rod'")


def test_gradients_at_a_bifurcation_are_refused():
    with pytest.raises(CriticalStateError, match="body 'rod'"):
        solve_statics(compile_scene(column(20.0 * (1 - 1e-7)), [FORCE]))
    assert solve_statics(compile_scene(column(19.9), [FORCE])).dq[0, 2, 0] == 0


def test_a_path_without_end_is_given_up():
    with pytest.raises(ConvergenceError, match=r"no stable one under the full load in 5 steps.*solver.path_steps"):
        solve_statics(compile_scene(truss(1.3 * LIMIT)), PAST.model_copy(update={"path_steps": 5}))


# --- the wing ---------------------------------------------------------------------------------------------------------------------


def wing(**changes: str) -> Scene:
    return read_scene(WING, {key.replace("__", "."): value for key, value in changes.items()})


@pytest.fixture(scope="module")
def limit() -> LimitPointError:
    with pytest.raises(LimitPointError) as error:
        solve_statics(compile_scene(wing()))
    return error.value


def test_the_wing_bears_a_millionth_less_than_its_limit_load_and_not_a_millionth_more(limit):
    assert limit.load_factor == pytest.approx(0.92, abs=5e-3)  # about 92 % is stated with the reference scene
    torque = 4200.0 * limit.load_factor
    below = solve_statics(compile_scene(wing().with_number("loads.drive.torque", torque * (1 - 1e-6))))
    assert solve_modes(below, 1).frequencies[0] > 0
    with pytest.raises(LimitPointError):
        solve_statics(compile_scene(wing().with_number("loads.drive.torque", torque * (1 + 1e-6))))


@pytest.mark.parametrize("method", ["direct", "adjoint"])
def test_gradients_of_the_wing_at_its_limit_load_are_refused(limit, method):
    at_limit = wing().with_number("loads.drive.torque", 4200.0 * limit.load_factor * (1 - 1e-8))
    with pytest.raises(CriticalStateError, match=r"body 'body[24]'"):
        gradients_by(method, at_limit, ["t_w", "M_t"], "static")


def test_the_equilibrium_beyond_the_snap_is_where_a_damped_motion_comes_to_rest():
    found = solve_statics(compile_scene(wing()), PAST)
    assert len(found.path.limit_points) == 2
    damped = wing(bodies__skin__damping_mass="30.0")  # 1/s: half of it is the rate at which all ringing decays
    settled = simulate(compile_scene(damped), RunOptions(end_time=2.0, step=2e-3))
    # 1.2 s after the jump by 0.2 rad: exp(-15 x 1.2) of it, and mm of the skin in proportion
    np.testing.assert_allclose(settled.q[-1], found.q[0], rtol=0, atol=1e-5)


def test_the_wings_path_before_its_limit_point_is_that_of_load_stepping():
    path = solve_statics(compile_scene(wing()), PAST).path
    for place in (2, 5, 7):
        torque = 4200.0 * path.load_factors[place]
        stepped = solve_statics(compile_scene(wing().with_number("loads.drive.torque", torque)))
        # Newton's tolerance of 1e-10 of the model size of some 200 mm, met quadratically
        np.testing.assert_allclose(path.q[place], stepped.q[0], rtol=0, atol=1e-8)


def test_gradients_of_the_wing_beyond_the_snap_are_those_of_central_differences():
    scene = wing(solver__continuation="arc-length")
    names = ["t_w", "M_t", "y_A"]
    ours, judge = (gradients_by(method, scene, names, "static").gradients for method in ("direct", "central-difference"))
    for response in ("max_stress_true", "drive_angle"):
        for name in names:
            assert ours[response][name] == pytest.approx(judge[response][name], rel=1e-5), (response, name)  # steps of 1e-5


def test_the_command_says_that_a_state_lies_beyond_a_snap_through():
    refused = CliRunner().invoke(app, ["statics", str(WING)])
    assert refused.exit_code == 1
    assert "limit point (snap-through)" in refused.stderr
    found = CliRunner().invoke(app, ["statics", str(WING), "--past-limit", "--json"])
    run = json.loads(found.stdout)["run"]
    assert "BEYOND A SNAP-THROUGH" in found.stderr
    assert run["beyond_snap_through"] is True
    assert [round(each["load_factor"], 2) for each in run["limit_points"]] == [0.92, 0.86]
    spoken = CliRunner().invoke(app, ["statics", str(WING), "--past-limit", "--quiet"])
    assert "BEYOND A SNAP-THROUGH" in spoken.stdout
