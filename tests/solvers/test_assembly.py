"""Closing the joints at the start: a four-bar linkage whose coupler has a length of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import values_of
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rod
from toolkit.components.curves.combined import Sum
from toolkit.components.curves.oscillation import Sine
from toolkit.components.curves.polynomial import Constant
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError, InputError
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

FREE = Sum(terms=(Constant(value=0.0), Sine(amplitude=0.3, frequency=0.8)))


def linkage(length: float | None = None, drive: bool = False, **solver: Any) -> Scene:
    """Two hanging rods OA and QB, tied by a massless bar from A to B; the first is driven on request."""
    places = {"O": (0.0, 0.0), "A": (0.2, -1.0), "Q": (1.1, 0.1), "B": (1.4, -0.8)}
    joints: dict[str, Any] = {
        "O": Revolute(bodies=("first", "ground"), point="O"),
        "Q": Revolute(bodies=("second", "ground"), point="Q"),
        "bar": Distance(bodies=("first", "second"), points=("A", "B"), length=length),
    }
    if drive:
        joints["drive"] = AngleDriver(bodies=("first", "ground"), point="O", curve=FREE)
    return Scene(
        units="m-kg-s",
        points={name: Point(x=x, y=y) for name, (x, y) in places.items()},
        bodies={
            "first": Rod(between=("O", "A"), area=1.0, density=1.0),
            "second": Rod(between=("Q", "B"), area=0.7, density=1.0, angular_velocity=None if drive else 0.2),
        },
        joints=joints,
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        responses={
            "first": Rotation(body="first", point="O"),
            "second": Rotation(body="second", point="Q"),
            "at_start": Rotation(body="second", point="Q", time=0.0),
        },
        solver=RunOptions(end_time=0.2, step=0.02, **solver),
    )


FITS = float(np.hypot(1.2, 0.2))


def test_a_bar_that_is_too_long_is_refused_unless_the_joints_may_be_closed():
    with pytest.raises(InputError, match=r"distance of joint 'bar' is violated.*solver\.assemble = true"):
        simulate(compile_scene(linkage(1.25)))


@pytest.mark.parametrize("length", [1.1, 1.25, 1.3])
def test_bodies_move_until_the_bar_fits(length):
    scene = linkage(length, assemble=True)
    system = compile_scene(scene)
    run = simulate(system)
    A, B = (run.q[0][rows][:2] + _arm(run.q[0][rows][2], half) for rows, half in ((slice(0, 3), "OA"), (slice(3, 6), "QB")))
    assert np.hypot(*(A - B)) == pytest.approx(length, rel=1e-13)  # round-off


def _arm(angle, which):
    half = {"OA": np.array([0.1, -0.5]), "QB": np.array([0.15, -0.45])}[which]
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]]) @ half


def test_bodies_that_fit_stay_where_they_are():
    run = simulate(compile_scene(linkage(FITS, assemble=True)))
    np.testing.assert_allclose(run.q[0], simulate(compile_scene(linkage(FITS))).q[0], atol=1e-15)  # round-off


@pytest.mark.parametrize("length", [FITS, 1.3])
def test_gradients_by_lengths_and_points_include_the_closing(length):
    scene = linkage(length, assemble=True)
    design = ["joints.bar.length", "points.A.x", "points.Q.y", "bodies.second.density"]
    by = {method: gradients_by(method, scene, design, "transient").gradients for method in ("direct", "adjoint", "complex-step")}
    for name, slopes in by["direct"].items():
        for method in ("adjoint", "complex-step"):
            # round-off; a start that fits does not depend on the mass, so that a zero stands among numbers of order one
            assert by[method][name] == pytest.approx(slopes, rel=1e-10, abs=1e-13), (name, method)
    assert abs(by["direct"]["at_start"]["joints.bar.length"]) > 0.1


def test_the_gradient_by_a_length_is_that_of_longer_and_shorter_bars():
    slope = direct(linkage(FITS, assemble=True), ["joints.bar.length"], "transient").gradients["second"]["joints.bar.length"]
    up, down = (values_of(linkage(FITS + h, assemble=True), "transient")["second"] for h in (1e-4, -1e-4))
    assert slope == pytest.approx((up - down) / 2e-4, rel=1e-5)  # truncation: square of the step times order 100


def test_the_start_value_of_a_driver_can_be_a_design_variable():
    scene = linkage(drive=True, assemble=True)
    design = ["joints.drive.curve.terms.0.value", "joints.drive.curve.terms.1.phase"]
    exact = gradients_by("complex-step", scene, design, "transient").gradients
    found = direct(scene, design, "transient").gradients
    assert found["first"]["joints.drive.curve.terms.0.value"] == pytest.approx(1.0, rel=1e-9)  # drift of the joints
    for name, slopes in exact.items():
        assert found[name] == pytest.approx(slopes, rel=1e-10), name  # round-off


def test_joints_that_only_close_far_away_are_refused():
    with pytest.raises(ConvergenceError, match=r"do not close near the given positions: .* would move by"):
        simulate(compile_scene(linkage(0.1, assemble=True)))
