"""Flexible bodies whose reduced models can be built afresh, from the skin file beside the model, and the scene with such a model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from toolkit.bodies.model_body import ModelBody
from toolkit.description.point import BodyPoint
from toolkit.foundation.errors import InputError
from toolkit.foundation.processes.preprocessing_process import run
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene

PROGRAM = "preprocessing.commands.designs_command"


def source(scene: Scene, body: str) -> Path:
    """The skin file that a body's model would be built from; it may not exist."""
    flexible: Any = scene.bodies[body]
    return (scene.directory / flexible.model).with_suffix(".toml")


def rebuildable(scene: Scene) -> dict[str, Path]:
    """Flexible body -> its skin file, where there is one."""
    found = {name: source(scene, name) for name, body in scene.bodies.items() if isinstance(body, ModelBody)}
    return {name: path for name, path in found.items() if path.is_file() and is_built_from(scene, name, path)}


def is_built_from(scene: Scene, body: str, skin: Path) -> bool:
    """Whether a body's model was built from a file of that name, and not one of another purpose lies beside it."""
    flexible: Any = scene.bodies[body]
    return skin.name in {Path(name).name for name in scene.model(flexible.model).inputs}


def given_values(scene: Scene, body: str) -> dict[str, Any]:
    """Parameters to which the scene gives values of its own, by their names for the preprocessing."""
    flexible: Any = scene.bodies[body]
    places = {f"interface_points.{name}.arc_length": s for name, s in loaded(scene).arc_lengths(flexible).items()}
    return {**flexible.model_values(), **places}


def with_model(scene: Scene, body: str, file: Path) -> Scene:
    """The scene with another reduced model of a body, and nothing given that is in the model already."""
    flexible: Any = scene.bodies[body]
    plain = type(flexible)(**{key: value for key, value in flexible if key in type(flexible).model_fields} | {"model": str(file)})
    points = {
        name: point.model_copy(update={"arc_length": None}) if isinstance(point, BodyPoint) and point.body == body else point
        for name, point in scene.points.items()
    }
    return scene.model_copy(update={"bodies": {**scene.bodies, body: plain}, "points": points})


def build_all(skin: Path, wanted: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Reduced models of one skin file in one process of the preprocessing.

    Parameters
    ----------
    wanted : tables {"file": where it goes, "values": {parameter: value}, "keys": {key of skin.toml: value}}, the last two optional

    Returns
    -------
    built : list
        Tables {"file": ..., "tables": the tables of skin.toml that other keys changed}.

    Raises
    ------
    InputError
        The preprocessing is not installed, or refuses one of them.
    """
    done = run(PROGRAM, [str(skin)], "\n".join(map(json.dumps, wanted)))
    if done.returncode:
        raise InputError(f"preprocessing afresh failed: {done.stderr.strip()}")
    return [json.loads(line) for line in done.stdout.splitlines()]
