"""A scene that is moved and turned as a whole, with gravity, forces and axes, moves in the same way, up to 1e4 m from the origin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.models.cases import write_models
from tests.models.every_number import SCENES
from tests.models.scenes import WING, hanging_skin
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.loads.bushing import Bushing
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.description.design import Point
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.kinematics.orientation import rotation
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.responses.response import Response
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution

NAMES = [*SCENES, "hanging skin", "wing"]
FAR = 1e4
"""Distance from the origin in m."""
MOVES = {
    "turned": (1.1, (0.0, 0.0)),
    "turned and moved": (-2.5, (0.7, 0.3)),
    "far": (0.0, (FAR, -FAR)),
    "turned and far": (0.7, (FAR, FAR)),
}
"""Angle, and displacement in m."""
FORMULATIONS = pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    return directory


def scene_of(name: str, folder: Path, formulation: str = "index-1") -> Scene:
    if name in SCENES:
        scene = alike_along_all_axes(SCENES[name](folder))
    else:
        scene = hanging_skin() if name == "hanging skin" else read_scene(WING, {"solver.scheme": "arnold-bruels"})
    return scene.model_copy(update={"solver": scene.solver.model_copy(update={"formulation": formulation})})


def alike_along_all_axes(scene: Scene) -> Scene:
    """The scene with bushings that are as stiff along x as along y: their axes do not turn with the scene."""
    loads = {
        name: load.model_copy(update={"stiffness": load.stiffness[:1] * 2, "damping": load.damping[:1] * 2})
        if isinstance(load, Bushing)
        else load
        for name, load in scene.loads.items()
    }
    return scene.model_copy(update={"loads": loads})


def metre(scene: Scene) -> float:
    return 1000.0 if scene.units == "mm-t-s" else 1.0


def moved(scene: Scene, angle: float, shift: np.ndarray) -> Scene:
    """Everything turned about the origin, then shifted."""

    def turned(vector: Any) -> tuple[float, float]:
        x, y = rotation(angle) @ np.array(vector)
        return float(x), float(y)

    def placed(vector: Any) -> tuple[float, float]:
        x, y = np.array(turned(vector)) + shift
        return float(x), float(y)

    def changed(item: Any) -> Any:
        if isinstance(item, Point):
            x, y = placed((item.x, item.y))
            return Point(x=x, y=y)
        update: dict[str, Any] = {}
        if getattr(item, "velocity", None) is not None:
            update["velocity"] = (*turned(item.velocity[:2]), item.velocity[2])
        if isinstance(item, Flexible):
            update |= {"position": placed(item.position), "angle": item.angle + angle}
        if hasattr(item, "axis"):
            update["axis"] = turned(item.axis)
        if isinstance(item, Gravity):
            update["acceleration"] = turned(item.acceleration)
        if isinstance(item, PointForce):
            update["force"] = turned(item.force)
        return item.model_copy(update=update)

    groups = {
        group: {name: changed(item) for name, item in getattr(scene, group).items()}
        for group in ("points", "bodies", "joints", "loads")
    }
    return scene.model_copy(update=groups)


def carried_along(solution: Solution, angle: float, shift: np.ndarray) -> np.ndarray:
    """Coordinates of the solution in the moved scene."""
    q = solution.q.copy()
    for name, body in solution.system.scene.bodies.items():
        first = solution.coordinates(name).start
        if isinstance(body, Flexible) and not body.has_frame:
            continue
        q[:, first : first + 2] = q[:, first : first + 2] @ rotation(angle).T + shift
        if isinstance(body, Flexible):
            q[:, first + 2] += angle
    return q


def independent(response: Response) -> bool:
    """Whether it does not name a direction in space."""
    return not (isinstance(response, (Displacement, JointForce)) and response.component in ("x", "y"))


def compare(scene: Scene, solve: Any, angle: float, shift: np.ndarray, error: float, of_forces: float) -> None:
    here, there = (solve(prepare(each)) for each in (scene, moved(scene, angle, shift)))
    np.testing.assert_allclose(there.q, carried_along(here, angle, shift), rtol=0, atol=error * loaded(scene).size)
    ours, theirs = (evaluate_responses(each) for each in (here, there))
    for name, response in scene.responses.items():
        if name in ours and independent(response):
            tolerance = of_forces if response.quantity == "force" or isinstance(response, JointForce) else 1e3 * error
            assert theirs[name] == pytest.approx(ours[name], rel=tolerance, abs=tolerance * loaded(scene).size), name


@FORMULATIONS
@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("name", NAMES)
def test_motion_goes_along(name, move, formulation, folder):
    scene = scene_of(name, folder, formulation)
    angle, shift = MOVES[move]
    distance = np.abs(shift).max() * metre(scene) / loaded(scene).size
    # round-off of positions, eps times the distance, through the stiffness of a skin, a hundredfold; forces have it over step^2
    error = 1e-13 + 1e-14 * distance
    forces = 1e-9 + 1e-16 * distance / scene.solver.step**2 * 100
    compare(scene, simulate, angle, np.array(shift) * metre(scene), error, forces)


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("name", ["swing", "wing"])
def test_equilibrium_goes_along(name, move, folder):
    scene = scene_of(name, folder)
    angle, shift = MOVES[move]
    distance = np.abs(shift).max() * metre(scene) / loaded(scene).size
    # as above; the soft mode of the wing multiplies round-off of tension by a thousand
    compare(scene, solve_statics, angle, np.array(shift) * metre(scene), 1e-10 + 1e-13 * distance, 1e-8 + 1e-10 * distance)
