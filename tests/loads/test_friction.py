"""Friction regularised by velocity: stopping distances, creep and work against closed forms, and what the verdict says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

import ffrf
from ffrf import plane, space

MASS, MU, G, SPEED = 2.0, 0.3, 9.81, 3.0
LEVEL = MU * MASS * G
DISTANCE = SPEED**2 / (2 * MU * G)
Z = (0.0, 0.0, 1.0)


def block(dimension: int, width: float, push: float = 0.0, speed: float = SPEED, **options: Any) -> ffrf.Scene:
    """A block that slides on a rail along x."""
    kinds: Any = plane if dimension == 2 else space
    place = {"bodies": ("block", "ground"), "point": "O", "axis": (1.0, 0.0, 0.0)[:dimension]}
    return ffrf.Scene(
        units="m-kg-s",
        dimension=dimension,
        points={"O": kinds.Point(**dict.fromkeys("xyz"[:dimension], 0.2))},
        bodies={
            "block": kinds.Rigid(
                mass=MASS,
                inertia=0.1 if dimension == 2 else (0.1, 0.1, 0.1),
                center="O",
                velocity=(speed, 0.0, 0.0),
            )
        },
        joints={"rail": plane.Slider(**place, lock_rotation=True) if dimension == 2 else space.Prismatic(**place)},
        loads={
            "friction": kinds.SlidingFriction(**place, level=LEVEL, width=width),
            "push": kinds.PointForce(body="block", point="O", force=(push, 0.0, 0.0)[:dimension]),
        },
        responses={
            "way": kinds.Displacement(body="block", point="O", component="x"),
            "work": kinds.Work(load="friction"),
            "energy": kinds.KineticEnergy(),
        },
        solver={"end_time": 1.6, "step": 5e-4, "tolerance": 1e-12} | options,
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_stops_after_v2_over_2_mu_g_and_what_the_width_adds_to_it(dimension):
    """Integral of v dv / (mu g tanh(v / d)) = v0^2 / (2 mu g) + pi^2 d^2 / (12 mu g): of second order in the width d."""
    widths = np.array([0.4, 0.2, 0.1])
    runs = [ffrf.compile(block(dimension, width)).simulate() for width in widths]
    beyond = np.array([run.values["way"] for run in runs]) - DISTANCE
    added = np.pi**2 * widths**2 / (12 * MU * G)
    assert beyond[1:] == pytest.approx(
        added[1:], rel=2e-3
    )  # exp(-mu g (1.6 - 1.02) / d) of the creep is still to come: 2e-4 of d = 0.2
    assert np.log2(beyond[1] / beyond[2]) == pytest.approx(2.0, abs=0.01)
    assert runs[2].values["energy"] < 1e-10
    assert runs[2].values["work"] == pytest.approx(
        -MASS * SPEED**2 / 2, rel=1e-6
    )  # friction takes all that moved: (step / time)^2
    assert runs[2].verdict.trusted


@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_by_level_width_and_speed_are_those_of_the_closed_form(dimension):
    width = 0.1
    paths = ["loads.friction.width", "loads.friction.level"]
    run = ffrf.compile(block(dimension, width), variables=paths).simulate(gradients=True)
    own = run.gradients["way"]
    assert own["loads.friction.width"] == pytest.approx(np.pi**2 * width / (6 * MU * G), rel=2e-3)
    whole = DISTANCE + np.pi**2 * width**2 / (12 * MU * G)
    assert own["loads.friction.level"] == pytest.approx(-whole / LEVEL, rel=1e-4)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_pushed_block_creeps_with_the_speed_that_is_told(dimension):
    """F tanh(v / d) = L: v = d artanh(L / F), after the time scale m d / F."""
    width, part = 0.02, 0.5
    run = ffrf.compile(block(dimension, width, push=part * LEVEL, speed=0.0, end_time=4.0, step=1e-3)).simulate()
    speed = width * np.arctanh(part)
    assert run.values["energy"] == pytest.approx(MASS * speed**2 / 2, rel=1e-6)
    said = next(each for each in run.warnings if each.code == "friction-width")
    assert not said.doubt
    assert "loads.friction is friction regularised by velocity, with a width of 0.02 m/s" in said.text
    assert f"100% of the time, it lets creep: by {run.values['way']:.3g} m." in said.text
    assert run.verdict.trusted


def test_friction_that_is_never_slow_says_its_width_alone():
    run = ffrf.compile(block(2, 0.1, end_time=0.5)).simulate()
    said = next(each for each in run.warnings if each.code == "friction-width")
    assert said.text.endswith("with a width of 0.1 m/s. Nothing was slower than that at any time.")


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rotor_runs_down_at_a_constant_rate(dimension):
    inertia, torque, spin, width = 0.5, 0.8, 4.0, 0.05
    kinds: Any = plane if dimension == 2 else space
    place = {"bodies": ("rotor", "ground"), "point": "O"} | ({} if dimension == 2 else {"axis": Z})
    body: Any = {"inertia": inertia, "angular_velocity": spin}
    if dimension == 3:
        body = {"inertia": (0.3, 0.4, inertia), "angular_velocity": (0.0, 0.0, spin)}
    scene = ffrf.Scene(
        units="m-kg-s",
        dimension=dimension,
        points={"O": kinds.Point(**dict.fromkeys("xyz"[:dimension], 0.0))},
        bodies={"rotor": kinds.Rigid(mass=1.0, center="O", **body)},
        joints={"axle": kinds.Revolute(**place)},
        loads={"friction": kinds.TurningFriction(**place, level=torque, width=width)},
        responses={
            "angle": kinds.RelativeAngle(bodies=("rotor", "ground"), point="O", **({} if dimension == 2 else {"axis": Z})),
            "energy": kinds.KineticEnergy(),
        },
        solver={"end_time": 2.0, "step": 1e-3},
    )
    values = ffrf.compile(scene).simulate().values  # 4.8 rad: friction knows no half turns
    assert values["angle"] == pytest.approx(spin * 2 - torque / inertia * 2, rel=5e-6)  # (step spin)^2 / 3
    assert values["energy"] == pytest.approx(inertia * (spin - torque / inertia * 2) ** 2 / 2, rel=5e-5)


def test_an_equilibrium_says_that_friction_holds_nothing_there():
    scene = block(2, 0.1, push=1.0)
    spring = plane.SpringDamper(bodies=("block", "ground"), points=("O", "W"), stiffness=50.0)
    scene = scene.model_copy(
        update={"points": {**scene.points, "W": plane.Point(x=-1.0, y=0.2)}, "loads": {**scene.loads, "spring": spring}}
    )
    found = ffrf.compile(ffrf.Scene(**{**dict(scene), "responses": {"way": scene.responses["way"]}})).statics()
    assert found.values["way"] == pytest.approx(1.0 / 50.0, rel=1e-12)
    assert "friction-at-rest" in found.verdict.codes


def test_a_block_at_rest_creeps_by_nothing_and_no_round_off_is_told():
    run = ffrf.compile(block(2, 0.1, speed=0.0, end_time=0.5)).simulate()
    said = next(each for each in run.warnings if each.code == "friction-width")
    assert "100% of the time, it lets creep: by 0 m." in said.text


def test_friction_without_a_width_is_refused():
    place = {"bodies": ("block", "ground"), "point": "O"}
    with pytest.raises(ValidationError, match="greater than 0"):
        plane.SlidingFriction(**place, level=1.0, width=0.0)
    with pytest.raises(ValidationError, match="a turning-friction acts between two different bodies, not on 'block' alone"):
        plane.TurningFriction(**{**place, "bodies": ("block", "block")}, level=1.0, width=0.1)
