"""Motions that begin in the equilibrium of their scene: they stay where nothing changes, vibrate as theory says, and know their design."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ffrf
from tests.models.cases import write_models
from tests.models.directions import along, derivative_along, direction
from tests.models.every_number import SCENES
from tests.models.spatial_cases import write_models as write_spatial_models
from tests.models.spatial_every_number import SCENES as SPATIAL
from toolkit.analyses.run_start import start_at_rest
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.components.curves.oscillation import Harmonic
from toolkit.components.curves.polynomial import Constant
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError
from toolkit.report.cost_summary import cost_summary
from toolkit.scene.scene import Scene

MASS, STIFFNESS, FORCE, FREQUENCY, END = 1.3, 40.0, 6.0, 0.35, 1.1


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    write_spatial_models(directory)
    return directory


def oscillator(dimension: int, curve: Any, velocity: float = 0.0, **options) -> Scene:
    """A mass on a rail, a spring to the ground, and a force."""
    kinds: Any = ffrf.plane if dimension == 2 else ffrf.space
    pad = (0.0,) * (dimension - 1)
    body: dict[str, Any] = {"mass": MASS, "inertia": 1.0 if dimension == 2 else (1.0, 1.0, 1.0, 0.0, 0.0, 0.0), "center": "P"}
    if velocity:
        body["velocity"] = (velocity, 0.0, 0.0)
    guide = (
        kinds.Slider(bodies=("block", "ground"), point="P", axis=(1.0, *pad), lock_rotation=True)
        if dimension == 2
        else kinds.Prismatic(bodies=("block", "ground"), point="P", axis=(1.0, *pad))
    )
    return Scene(
        units="m-kg-s",
        dimension=dimension,
        points={
            name: kinds.Point(**dict(zip("xyz"[:dimension], (x, *pad), strict=True))) for name, x in (("O", 0.0), ("P", 1.0))
        },
        bodies={"block": kinds.Rigid(**body)},
        joints={"guide": guide},
        loads={
            "spring": kinds.SpringDamper(bodies=("block", "ground"), points=("P", "O"), stiffness=STIFFNESS, damping=0.0),
            "push": kinds.PointForce(body="block", point="P", force=(FORCE, *pad), curve=curve),
        },
        responses={"way": kinds.Displacement(body="block", point="P", component="x")},
        solver=RunOptions(end_time=END, step=END / 800, rho_inf=1.0, start="equilibrium", **options),
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_force_that_swings_from_its_equilibrium_on_moves_a_mass_as_theory_says(dimension):
    """x = A cos(W t) + (F / k - A) cos(w t) + v / w sin(w t), A = F / (k - m W^2); and its derivatives by F, m and k."""
    speed = 0.2

    def way(force: complex, mass: complex, stiffness: complex) -> complex:
        own, driven = np.sqrt(stiffness / mass), 2 * np.pi * FREQUENCY
        amplitude = force / (stiffness - mass * driven**2)
        swing = (force / stiffness - amplitude) * np.cos(own * END)
        return amplitude * np.cos(driven * END) + swing + speed / own * np.sin(own * END)

    scene = oscillator(dimension, Harmonic(frequency=FREQUENCY), velocity=speed)
    force = f"loads.push.force.{'x' if dimension == 2 else '0'}"
    given = {force: FORCE, "bodies.block.mass": MASS, "loads.spring.stiffness": STIFFNESS}
    for method in ("direct", "adjoint"):
        found = gradients_by(method, scene, list(given), "transient")
        # second order: (w h)^2 / 12 = 5e-6 of the phase, 6 rad
        assert found.values["way"] == pytest.approx(float(np.real(way(*given.values()))), rel=2e-4)
        for path in given:
            moved = [value + 1e-30j * (path == name) for name, value in given.items()]
            assert found.gradients["way"][path] == pytest.approx(np.imag(way(*moved)) / 1e-30, rel=1e-3), (method, path)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_begins_in_equilibrium_stays_there_if_nothing_changes(dimension):
    scene = oscillator(dimension, Constant())
    run = ffrf.compile(scene, ["loads.spring.stiffness"]).simulate(gradients=True)
    assert run.values["way"] == pytest.approx(FORCE / STIFFNESS, rel=1e-9)
    assert run.gradients["way"]["loads.spring.stiffness"] == pytest.approx(-FORCE / STIFFNESS**2, rel=1e-8)
    assert np.abs(run.solution.v).max() < 1e-9  # Newton leaves 1e-10 of the length, at 6 rad / s
    assert run.verdict.trusted, run.verdict.reasons


ALL = {"plane, rods": ("swing", 2), "plane, flexible": ("beams", 2), "space, flexible": ("frames", 3)}


@pytest.mark.parametrize("name", ALL)
def test_gradients_know_how_the_equilibrium_depends_on_every_number(folder, name):
    which, dimension = ALL[name]
    scene = (SCENES if dimension == 2 else SPATIAL)[which](folder)
    scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"start": "equilibrium"})})
    paths = [
        path for path in scene.available_paths() if dimension == 2 or path.endswith((".x", ".0", "thickness_bar", "stiffness"))
    ]
    by = {method: gradients_by(method, scene, paths, "transient").gradients for method in ("direct", "adjoint")}
    factors = direction(paths)
    judge = derivative_along(scene, factors, "transient", start_at_rest(prepare(scene), scene.solver))
    for response, slopes in by["adjoint"].items():
        largest = max(map(abs, slopes.values()))
        assert along(slopes, factors) == pytest.approx(judge[response], rel=1e-9, abs=1e-11 * largest), response
        # direct: blocks whose vectors refine by less than 1e-11 are not refined, which joint forces of stiff bodies magnify
        assert by["direct"][response] == pytest.approx(slopes, rel=5e-9, abs=1e-10 * largest), response
    given = scene.model_copy(update={"solver": scene.solver.model_copy(update={"start": "given"})})
    elsewhere = direct(given, paths, "transient").gradients
    assert any(abs(elsewhere[f][x] - by["direct"][f][x]) > 1e-3 * abs(by["direct"][f][x]) for f in elsewhere for x in paths)


def test_what_is_free_to_move_has_no_equilibrium_to_start_in():
    scene = oscillator(2, Constant())
    free = scene.model_copy(update={"loads": {"push": scene.loads["push"]}})
    with pytest.raises(ConvergenceError, match="the equilibrium is unstable or out of reach"):
        ffrf.compile(free).simulate()


def test_a_scene_that_rests_is_trusted_and_can_be_gone_on_with(tmp_path):
    """A pendulum in a leaning field: it hangs along the field, and what is left of its energy is round-off."""
    (tmp_path / "scene.toml").write_text("""
units = "m-kg-s"
points = { O = [0.0, 0.0], C = [0.1, 0.0] }
bodies = { b = { type = "rigid", mass = 1.0, center = "C", inertia = 0.1 } }
joints = { r = { type = "revolute", bodies = ["b", "ground"], point = "O" } }
loads = { g = { type = "gravity", acceleration = [3.0, -9.81] } }
responses = { a = { type = "rotation", body = "b", point = "O" }, c = { type = "centre-of-mass", component = "x" } }
solver = { start = "equilibrium" }
""")
    scene = ffrf.read_scene(tmp_path / "scene.toml")
    model = ffrf.compile(scene)
    run = model.simulate()
    assert run.verdict.trusted, run.verdict
    assert run.values["a"] == pytest.approx(np.arctan2(-9.81, 3.0), abs=1e-9)
    further = ffrf.compile(scene, ["loads.g.acceleration.x"]).simulate(start=run, gradients=True)
    assert further.values["a"] == pytest.approx(run.values["a"], abs=1e-9)
    assert further.verdict.trusted, further.verdict
    assert "markers" in cost_summary(scene, [], False, measured=False)  # a centre of mass is no point of the scene
