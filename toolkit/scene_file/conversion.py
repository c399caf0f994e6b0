"""A whole scene in other units, with its reduced models."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.units import factor
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.file import load, save
from toolkit.responses.response import Response
from toolkit.scene.scene import Scene
from toolkit.scene_file.dimensions import dimensions, number_dimension, response_dimension


def converted(scene: Scene, units: str, directory: Path) -> Scene:
    """Scene with all numbers in another unit system; its results are the same to round-off, in the new units.

    Parameters
    ----------
    scene : Scene
    units : "m-kg-s" or "mm-t-s"
    directory : folder that the converted reduced models are written to

    Raises
    ------
    InputError
        The unit system is unknown, or a kind of component whose numbers nobody has given a dimension.
    """
    found = scene
    for path, dimension in dimensions(scene).items():
        by = factor(dimension, scene.units, units)
        if by != 1:
            found = found.with_number(path, np.multiply(by, scene.number(path)).item())
    bodies = {name: _with_model(scene, body, units, directory) for name, body in found.bodies.items()}
    return found.model_copy(update={"units": units, "bodies": bodies, "directory": directory})


def _with_model(scene: Scene, body, units: str, directory: Path):
    if not isinstance(body, ModelBody):
        return body
    models = sorted({each.model for each in scene.bodies.values() if isinstance(each, ModelBody)})
    name = f"{Path(body.model).stem}_{models.index(body.model)}_{units}.h5"
    save(converted_model(load(scene.directory / body.model), units), directory / name)
    return body.model_copy(update={"model": name})


def response_factor(scene: Scene, response: str, units: str) -> float:
    """Factor that turns the value of a response into other units."""
    found = scene.responses[response]
    return factor(response_dimension(found), scene.units, units) if isinstance(found, Response) else 1.0


def number_factor(scene: Scene, path: str, units: str) -> float:
    """Factor that turns the number at a path into other units."""
    return factor(number_dimension(scene, path), scene.units, units)
