"""Wheels that are seen at a few of their angles only, and peaks between the steps: steps of other lengths agree with them by chance."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from ffrf import plane
from toolkit.responses.extremes import MISSED_PEAK, TimeKS, TimeMax, missed_part


def wheel(per_turn: float, point: str = "P", **loads):
    """A wheel that spins freely about its centre for 20 steps."""
    steps, rate = 20, 2 * np.pi / per_turn / 0.01
    farthest = TimeMax(of={"type": "displacement", "body": "wheel", "point": point, "component": "x"}, measure="absolute")
    return ffrf.Scene(
        units="m-kg-s",
        points={"O": plane.Point(x=0.0, y=0.0), "P": plane.Point(x=1.0, y=0.0)},
        bodies={"wheel": plane.Rigid(center="O", mass=1.0, inertia=1.0, angular_velocity=rate)},
        joints={"pin": plane.Revolute(bodies=("wheel", "ground"), point="O")},
        loads=loads,
        responses={"farthest": farthest},
        solver=ffrf.RunOptions(end_time=steps * 0.01, step=0.01),
    )


def codes(scene) -> tuple[str, ...]:
    return ffrf.compile(scene).simulate().verdict.codes


@pytest.mark.parametrize(
    ("per_turn", "code"), [(1, "turns-in-a-step"), (2.5, "turns-in-a-step"), (3, "missed-peak"), (5, "missed-peak")]
)
def test_a_point_of_a_wheel_that_is_seen_at_few_angles_is_doubted(per_turn, code):
    """The point comes 2 m far, of which steps see 0, 1.81, 1.5 and 1.81 m; twice as long ones see the same."""
    run = ffrf.compile(wheel(per_turn)).simulate()
    assert run.values["farthest"] < 1.82
    assert code in run.verdict.codes
    assert not run.verdict.trusted


def test_a_smooth_largest_value_misses_the_peak_too():
    whole = wheel(5)
    smooth = TimeKS(of=whole.responses["farthest"].of, measure="absolute", aggregation=100.0)
    run = ffrf.compile(whole.model_copy(update={"responses": {"farthest": smooth}})).simulate()
    assert run.values["farthest"] < 1.82 + np.log(42) / 100  # of twice 21 values, where it comes 2 m far
    assert "missed-peak" in run.verdict.codes


def test_a_wheel_whose_angle_nothing_depends_on_may_turn_as_far_as_it_likes():
    torque = plane.Torque(body="wheel", point="O", torque=1.0)
    assert "turns-in-a-step" not in codes(wheel(1, "O", motor=torque))
    pull = plane.PointForce(body="wheel", point="O", force=(1.0, 0.0), frame="body")
    assert "turns-in-a-step" in codes(wheel(1, "O", pull=pull))


def test_four_steps_in_a_turn_that_meet_the_peak_are_no_doubt():
    assert codes(wheel(4)) == ()


def sampled(per_turn: float, shift: float = 0.0) -> np.ndarray:
    return np.cos(2 * np.pi * (np.arange(40) + shift) / per_turn)[None]


@pytest.mark.parametrize("per_turn", [3, 5, 7, 16])
def test_a_peak_between_two_equal_values_is_estimated_from_below(per_turn):
    """Two values beside a peak of cos lack 1 - cos(pi / n) of it; a parabola finds no more, and of five steps in a turn 73 % of that."""
    values = sampled(per_turn, 0.5)
    lacks = (1 - values.max()) / np.abs(values).max()
    found = missed_part(np.arange(40.0), values)
    assert (0.7 if per_turn > 3 else 0.3) * lacks < found <= lacks


def test_unequal_steps_are_where_they_are():
    times = np.array([0.0, 1.0, 1.5, 3.0, 3.2, 5.0])
    assert missed_part(times, -((times - 2.2) ** 2)[None]) == pytest.approx(
        0.7**2 / 2.8**2
    )  # a parabola itself, of -0.49 at the most


@pytest.mark.parametrize(
    "values",
    [[0, 0, 0, 1, 1, 1, 1], [1, 0, 1, 0, 1, 0, 1], [0, 0, 1, 0.99, 0.97, 0.9, 0.8], [0, 1, 2, 3, 2, 1, 0], [3, 3, 3, 3, 3, 3, 3]],
)
def test_jumps_corners_noise_and_constants_are_no_missed_peaks(values):
    assert missed_part(np.arange(7.0), np.array([values], float)) < MISSED_PEAK
