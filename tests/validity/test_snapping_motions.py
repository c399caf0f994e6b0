"""A motion that snaps through says so, when, and what moves; motions that do not, or that have nothing to snap from, say nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.solvers.test_snap_through import LIMIT, TURN, truss
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.curves.rise import SmoothStep
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of, quaternion_rate
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene
from toolkit.validity.snap_through import snap_through, stiffness_of_turns

MODELS = Path(__file__).parents[2] / "models"


def pushed(part: float, **body: object) -> Scene:
    """The shallow truss under a part of its limit load that grows within a second: slowly, for an apex of 1 kg on 1e3 N/m."""
    scene = truss(part * LIMIT)
    push = scene.loads["push"].model_copy(update={"curve": SmoothStep(duration=1.0)})
    bodies = {"apex": Rigid(mass=1.0, inertia=1.0, center="P", **body)}
    return scene.model_copy(update={"loads": {**scene.loads, "push": push}, "bodies": bodies})


def motion(scene: Scene, step: float = 2e-3, **options: object) -> Solution:
    return simulate(compile_scene(scene), RunOptions(end_time=1.2, step=step, **options))


@pytest.mark.parametrize("formulation", ["index-1", "index-3"])
def test_a_truss_that_snaps_through_says_when_its_stiffness_has_gone(formulation):
    """At the height where bars push most."""
    run = motion(pushed(1.3), formulation=formulation)
    (found,) = snap_through(run)
    assert found.code == "snaps"
    assert not found.doubt
    assert "motion of y of body 'apex'" in found.text
    n = int(np.argmax(run.q[:, 1] < TURN))
    passed = np.interp(-TURN, -run.q[n - 1 : n + 1, 1], run.times[n - 1 : n + 1])
    assert float(found.text.split("t = ")[1].split()[0]) == pytest.approx(
        passed, abs=0.1 * 2e-3 + 5e-5
    )  # a tenth of a step, 4 digits


def test_a_step_over_the_snap_is_looked_into():
    """Every state but the first three lies on one of the stable sides."""
    run = motion(pushed(1.3), step=0.02, formulation="index-3", rho_inf=0.0)
    y = run.q[:, 1]
    kept = np.abs(y) > TURN
    assert y.min() < -TURN
    stable = Solution(
        run.system,
        *(getattr(run, name)[kept] for name in ("times", "q", "v", "a", "multipliers", "dq", "dv", "da", "dmultipliers")),
    )
    assert [*snap_through(stable)]


def test_a_truss_that_holds_says_nothing():
    assert not [*snap_through(motion(pushed(0.9)))]


@pytest.mark.parametrize("change", ["moving", "far from rest"])
def test_a_motion_that_does_not_begin_at_rest_is_no_snap_through(change):
    """The apex swings from side to side."""
    if change == "moving":
        run = motion(pushed(1e-6, velocity=(0.0, -10.0, 0.0)))
    else:
        run = simulate(compile_scene(truss(50 * LIMIT)), RunOptions(end_time=0.05, step=1e-4))
    assert run.q[:, 1].min() < -TURN
    assert not [*snap_through(run)]


@pytest.mark.parametrize("name", ["pendulum", "four_bar_chain", "slider_crank", "rotating_beam", "morphing_wing", "bracket"])
def test_the_models_that_do_not_snap_say_nothing(name):
    scene = read_scene(MODELS / name / "scene.toml")
    end = min(scene.solver.end_time, 2.0)
    assert not [*snap_through(simulate(compile_scene(scene), scene.solver.model_copy(update={"end_time": end})))]


def test_the_wing_that_snaps_says_that_its_driven_rod_runs_away():
    (found,) = snap_through(simulate(compile_scene(read_scene(MODELS / "snap_through" / "scene.toml"))))
    assert "motion of rotation of body 'body2'" in found.text
    assert 0.77 < float(found.text.split("t = ")[1].split()[0]) < 0.79  # the load is that of the limit point at 0.7699


def test_a_force_that_keeps_its_direction_resists_turns_as_a_weight_does_those_of_a_pendulum():
    """In whatever direction and with whatever quaternion: the second derivative of -g . A c along a turn about n is g . A (c - n n . c)."""
    rng = np.random.default_rng(5)
    for _ in range(5):
        force, centre, axis = rng.normal(size=(3, 3))
        quaternion, axis = quaternion_of(rng.normal(size=3)), axis / np.linalg.norm(axis)
        A, rate = matrix_of(quaternion), quaternion_rate(quaternion, axis)
        found = rate @ stiffness_of_turns(force, centre, A, 4) @ rate
        assert found == pytest.approx(force @ A @ (centre - axis * (axis @ centre)), abs=1e-12)
