"""Linkages that pass a dead point, jump over one that their lengths have opened, or have none."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import ffrf
from ffrf import plane
from toolkit.foundation.verdict import Verdict

ROD = {"area": 1e-4, "density": 7800.0}
TURN, BEGIN = 3.2, 0.5


def linkage(points: dict[str, tuple[float, float]], joints: dict, rods: dict[str, tuple[str, str]], **start: float) -> ffrf.Scene:
    """Rods between points, the first on a pin at A and either led by a motor or, with a start, free."""
    led = plane.AngleDriver(bodies=("crank", "ground"), point="A", curve=plane.SmoothStep(height=TURN, duration=1.0))
    bodies = {name: plane.Rod(between=ends, **ROD, **(start if name == "crank" else {})) for name, ends in rods.items()}
    return ffrf.Scene(
        units="m-kg-s",
        points={name: plane.Point(x=x, y=y) for name, (x, y) in points.items()},
        bodies=bodies,
        joints={"A": plane.Revolute(bodies=("crank", "ground"), point="A"), **joints, **({} if start else {"motor": led})},
        responses={"end": plane.Rotation(body=[*rods][-1], point=[*rods.values()][-1][0])},
        solver=ffrf.RunOptions(end_time=1.0, step=0.005),
    )


def four_bar(ground: float, crank: float = 1.0, **start: float) -> ffrf.Scene:
    """Crank, coupler of 2 m and rocker of 1 m; with a ground of 2 m and a crank of 1 m a parallelogram."""
    tip = np.array([np.cos(BEGIN), np.sin(BEGIN)])
    points = {"A": (0.0, 0.0), "B": tuple(crank * tip), "C": (2 + tip[0], tip[1]), "D": (ground, 0.0)}
    rods = {"crank": ("A", "B"), "coupler": ("B", "C"), "rocker": ("C", "D")}
    joints = {
        "B": plane.Revolute(bodies=("crank", "coupler"), point="B"),
        "C": plane.Revolute(bodies=("coupler", "rocker"), point="C"),
        "D": plane.Revolute(bodies=("rocker", "ground"), point="D"),
    }
    return linkage(points, joints, rods, **start)


def slider_crank(more: float = 0.0) -> ffrf.Scene:
    """Crank and rod of equal length where `more` is zero: the rod folds over, or goes on, where it stands on the slide at pi / 2."""
    points = {"A": (0.0, 0.0), "B": (np.cos(BEGIN), np.sin(BEGIN)), "C": (2 * np.cos(BEGIN) + more, 0.0)}
    joints = {
        "B": plane.Revolute(bodies=("crank", "rod"), point="B"),
        "C": plane.Slider(bodies=("rod", "ground"), point="C", axis=(1.0, 0.0)),
    }
    return linkage(points, joints, {"crank": ("A", "B"), "rod": ("B", "C")})


def verdict(scene: ffrf.Scene, *variables: str) -> Verdict:
    return ffrf.compile(scene, variables=list(variables)).simulate(gradients=bool(variables)).verdict


def said(found: Verdict, code: str) -> str:
    (text,) = [each.text for each in found.warnings if each.code == code]
    return text


def told_time(found: Verdict) -> float:
    (time,) = re.findall(r"^at t = ([0-9.]+) the motion passes", said(found, "dead-point"))
    return float(time)


def reached(angle: float) -> float:
    """When the crank is at an angle: BEGIN + TURN u^3 (10 - 15 u + 6 u^2)."""
    return float(brentq(lambda u: BEGIN + TURN * u**3 * (10 - 15 * u + 6 * u**2) - angle, 0, 1))


@pytest.mark.parametrize(
    ("scene", "angle", "opens"), [(four_bar(2.0), np.pi, "points.D.x"), (slider_crank(), np.pi / 2, "points.C.x")]
)
def test_a_dead_point_is_told_and_derivatives_by_what_opens_it_are_doubted(scene, angle, opens):
    plain = verdict(scene)
    assert plain.trusted
    assert told_time(plain) == pytest.approx(reached(angle), abs=1e-3)  # a fifth of a step
    assert verdict(scene, "joints.motor.curve.height", "bodies.crank.density").trusted
    doubted = verdict(scene, opens, "joints.motor.curve.height")
    assert said(doubted, "gradient-dead-point").startswith(f"derivatives by {opens} do not exist")


@pytest.mark.parametrize("scene", [four_bar(2 - 1e-6), four_bar(2 - 1e-5), slider_crank(1e-6)])
def test_a_step_that_jumps_over_an_opened_dead_point_is_doubted(scene):
    """The branches are closer to each other than the step is long: bodies would turn over, and smaller steps do it too late to be seen."""
    found = ffrf.compile(scene).simulate()
    assert "a step has jumped" in said(found.verdict, "jumped")


def test_a_linkage_that_turns_over_is_trusted():
    """Of a ground that is shorter by 0.1 mm the rocker turns over: triangles of school geometry, C always on the same side of B D."""
    found = ffrf.compile(four_bar(2 - 1e-4)).simulate()
    crank = BEGIN + TURN
    way = np.array([2 - 1e-4, 0.0]) - [np.cos(crank), np.sin(crank)]
    pin = np.array([2 + np.cos(BEGIN) - (2 - 1e-4), np.sin(BEGIN)])
    length, diagonal = np.hypot(*pin), np.hypot(*way)
    corner = np.arccos((diagonal**2 + length**2 - 4) / (2 * diagonal * length))
    direction = np.arctan2(*-way[::-1]) - corner
    turned = (direction - np.arctan2(*pin[::-1])) % (2 * np.pi)
    assert found.values["end"] % (2 * np.pi) == pytest.approx(turned, abs=1e-3)
    assert not {"jumped", "dead-point"} & set(found.verdict.codes)


@pytest.mark.parametrize("spin", [0.5, 7.0])
def test_a_free_linkage_is_looked_at_too(spin):
    """The parallelogram keeps its speed as it has no weight: it stretches after pi - BEGIN and 2 pi - BEGIN."""
    found = verdict(four_bar(2.0, angular_velocity=spin))
    assert ("dead-point" in found.codes) == (spin * 1.0 > np.pi - BEGIN)
    if spin > 1:
        assert told_time(found) == pytest.approx((np.pi - BEGIN) / spin, abs=1e-3)


def test_a_crank_that_turns_all_round_has_none():
    """Shortest and longest bar are shorter than the others together (Grashof), driven and free, for several turns."""
    scene = four_bar(1.9, crank=0.4)
    for each in (scene, four_bar(1.9, crank=0.4, angular_velocity=20.0)):
        assert not {"jumped", "dead-point"} & set(verdict(each).codes)
