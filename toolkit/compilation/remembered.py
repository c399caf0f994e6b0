"""A scene whose points and models are looked up once, while its numbers are evaluated."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

import numpy as np

from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.scene import Scene, position_in, size_of

T = TypeVar("T")


class Remembered:
    """What bodies, joints and loads ask of a scene (`bodies.body.Placed`), with every answer kept: many ask for the same point or model.

    Parameters
    ----------
    scene
        The scene, at real or complex numbers.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._kept: dict[Any, Any] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scene, name)

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, (d,)."""
        return self._once(("position", point), lambda: position_in(self, point))

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model of that file."""
        return self._once(("model", path, parts), lambda: self._scene.model(path, *parts))

    def arc_lengths(self, body: Any) -> dict[str, Any]:
        """Interface points of a body that the scene puts elsewhere along it."""
        return self._once(("arc lengths", id(body)), lambda: self._scene.arc_lengths(body))

    @property
    def size(self) -> float:
        """The length that displacements are compared with, see `Scene.size`."""
        return self._once("size", lambda: size_of(self))

    def _once(self, key: Hashable, make: Callable[[], T]) -> T:
        if key not in self._kept:
            self._kept[key] = make()
        found: T = self._kept[key]
        return found
