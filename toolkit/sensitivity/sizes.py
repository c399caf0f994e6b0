"""Sizes of design variables and of responses: what a relative step, or an error of a derivative, refers to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from toolkit.description.design import DesignVariable
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene

EPS = float(np.finfo(float).eps)


class Differentiated(Protocol):
    """What knows values and gradients of responses."""

    @property
    def values(self) -> dict[str, Any]:
        """Response -> value."""

    @property
    def gradients(self) -> dict[str, dict[str, float]]:
        """Response -> variable -> derivative."""


def typical_size(scene: Scene, variable: DesignVariable) -> float:
    """What a relative step refers to: the value, or for a zero the model size (points) or one."""
    if variable.value != 0:
        return abs(variable.value)
    return loaded(scene).size if variable.path.startswith("points.") else 1.0


def variable_sizes(scene: Scene, exact: Differentiated) -> dict[str, float]:
    """What a relative step of each variable refers to.

    It is the value; for a zero of a point the model size; for another zero the change that moves no response further than the others
    can, or than its value (one in the scene's units could be anything, as 1 mm/s, or 1 s of damping), and no body further than the
    model size or by more than 1 rad.
    """
    variables = list(scene.design_variables(list(next(iter(exact.gradients.values()), {}))))
    known = {v.name: typical_size(scene, v) for v in variables if v.value != 0 or v.path.startswith("points.")}
    scales = response_scales(exact, known)
    sizes = {}
    for variable in variables:
        slopes = {f: abs(slopes[variable.name]) for f, slopes in exact.gradients.items()}
        allowed = [scales[f] / slope for f, slope in slopes.items() if slope > EPS * scales[f]]
        sizes[variable.name] = known.get(variable.name, min([*allowed, _reach(scene, variable.path)]))
    return sizes


def _reach(scene: Scene, path: str) -> float:
    """Largest sensible change of a place, angle, velocity or time; 1 in the scene's units for what is none of these."""
    group, owner, *name = path.split(".")
    time = scene.solver.end_time
    if name[:1] in (["velocity"], ["angular_velocity"]):
        said = getattr(scene, group)[owner].quantity_of(name[0])
        place = int(name[1]) if name[1:] else 0
        return (1.0 if said is not None and said.measure(place).angle else loaded(scene).size) / time
    if name[:1] in (["position"], ["deflection"]):
        return loaded(scene).size
    if name[:1] == ["elastic_velocity"]:
        return loaded(scene).size / time
    return time if name[-1] in ("start", "duration") else 1.0


def response_scales(exact: Differentiated, sizes: Mapping[str, float]) -> dict[str, float]:
    """Response -> the largest of its value and of its changes by the variables that have a size."""
    return {
        f: max([abs(exact.values[f]), *(abs(slopes[x]) * size for x, size in sizes.items())], default=0.0)
        for f, slopes in exact.gradients.items()
    }
