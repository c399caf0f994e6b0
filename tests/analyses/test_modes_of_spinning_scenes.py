"""Frequencies about a state at rest say so where the scene spins: at the start, or by a driver; in plane and in space."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.spatial.test_frames import AREA, RHO, SECOND, E, Z, beam, elastic_frequencies
from toolkit.analyses.modes import Modes, solve_modes, undeformed
from toolkit.analyses.statics import solve_statics
from toolkit.command_line.cli import app
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.curves.rise import SmoothStep
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.springs import RotationalSpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.start_cautions import cautions_of_start

BEAM = Path(__file__).parents[2] / "models" / "rotating_beam" / "scene.toml"


def modes_of_the_beam(speed: float) -> Modes:
    return solve_modes(undeformed(compile_scene(read_scene(BEAM, {"bodies.beam.angular_velocity": repr(speed)}))), 4)


def test_frequencies_of_a_beam_that_spins_are_in_doubt():
    """50 rad/s beside 334 rad/s, the lowest of a beam that is free but for its hinge: 15.4182 sqrt(E I / rho A) / L^2."""
    found = modes_of_the_beam(50.0)
    (caution,) = (each for each in found.verdict.warnings if each.code == "spins")
    assert (caution.code, found.verdict.trusted) == ("spins", False)
    lowest = 2 * np.pi * found.frequencies[1]
    assert f"'beam' with 50 rad/s at the start, {50 / lowest:.2g} of the lowest circular frequency" in caution.text


def test_a_slow_spin_is_a_remark_and_none_is_none():
    slow = modes_of_the_beam(1e-3)
    assert [caution.doubt for caution in slow.verdict.warnings if caution.code == "spins"] == [False]
    assert "spins" not in modes_of_the_beam(0.0).verdict.codes


def test_the_line_between_both_is_where_the_frequencies_change_by_as_much(tmp_path):
    """A round shaft that turns about itself: |omega - spin| and omega + spin in the frame that turns with it."""
    body = SpatialFlexible(model="beam.h5", frame="turning", axis=Z, angular_velocity=(0.0, 0.0, 7.0))
    system = compile_scene(Scene(units="m-kg-s", dimension=3, directory=beam(tmp_path, 4), bodies={"beam": body}))
    found = solve_modes(undeformed(system))
    (caution,) = (each for each in found.verdict.warnings if each.code == "spins")
    assert "'beam' with 7 rad/s at the start" in caution.text
    lowest = 2 * np.pi * found.frequencies[1]
    assert lowest == pytest.approx(1.8751**2 * np.sqrt(E * SECOND / (RHO * AREA)), rel=1e-3)
    change = np.abs(elastic_frequencies(system, 7.0)[0] / lowest - 1)
    assert change == pytest.approx(7.0 / lowest, rel=1e-2)
    assert found.verdict.trusted == (change <= 1e-2)


def door(duration: float) -> Scene:
    """A driven door with a leaf on a spring."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0)},
        bodies={name: Rigid(mass=1.0, inertia=1.0, center="O") for name in ("door", "leaf")},
        joints={
            "hinge": Revolute(bodies=("door", "ground"), point="O"),
            "drive": AngleDriver(bodies=("door", "ground"), point="O", curve=SmoothStep(height=1.0, duration=duration)),
            "pin": Revolute(bodies=("leaf", "door"), point="O"),
        },
        loads={"coil": RotationalSpringDamper(bodies=("leaf", "door"), point="O", stiffness=4.0)},
        solver=RunOptions(end_time=1.0),
    )


def test_a_driver_that_is_at_work_is_told_and_one_that_has_done_its_work_is_not():
    """The rate of 10 s^3 - 15 s^4 + 6 s^5 in the middle is 30/16."""
    moving = solve_modes(solve_statics(compile_scene(door(2.0))))
    (caution,) = moving.verdict.warnings
    assert not moving.verdict.trusted
    assert "with 0.9375 rad/s at t = 1, by its driver, 0.47 of the lowest circular frequency" in caution.text
    assert solve_modes(solve_statics(compile_scene(door(1.0)))).verdict.warnings == ()


def test_an_equilibrium_of_a_scene_that_spins_is_said_to_be_one_at_rest():
    (caution,) = cautions_of_start(solve_statics(compile_scene(door(2.0))))
    assert (caution.code, caution.doubt) == ("at-rest", False)
    assert "with 0.9375 rad/s at t = 1, by its driver" in caution.text
    assert list(cautions_of_start(solve_statics(compile_scene(door(1.0))))) == []


def test_velocities_that_contradict_the_joints_are_no_matter_of_modes():
    scene = door(1.0)
    bodies = {**scene.bodies, "door": scene.bodies["door"].model_copy(update={"angular_velocity": 3.0})}
    (caution,) = solve_modes(solve_statics(compile_scene(scene.model_copy(update={"bodies": bodies})))).verdict.warnings
    assert "'door' with 3 rad/s at the start" in caution.text


def test_the_command_says_it_in_words_and_in_json():
    command = ["modes", str(BEAM), "--undeformed", "--count", "3"]
    words = CliRunner().invoke(app, command)
    assert words.exit_code == 0
    assert "NOT TO BE TRUSTED" in words.stdout
    assert "the scene spins: 'beam' with 50 rad/s" in words.stdout
    record = json.loads(CliRunner().invoke(app, [*command, "--json"]).stdout)
    assert record["verdict"]["trusted"] is False
    assert [each["code"] for each in record["warnings"]] == ["spins", "damped", "at-rest"]
