"""A scene whose points and models are looked up once, while its numbers are evaluated, and that tells what was asked of it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

import numpy as np

from toolkit.description.point import Point
from toolkit.foundation.itself import Itself
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.scene import Scene, position_in, size_of

T = TypeVar("T")


class Remembered:
    """A scene as bodies, joints and loads ask it (`bodies.body.Placed`), with every answer kept.

    Many ask for the same point or model.

    Parameters
    ----------
    scene
        The scene, at real or complex numbers.
    beside
        The same scene at other numbers, which has asked for the same models.
    """

    def __init__(self, scene: Scene, beside: Remembered | None = None) -> None:
        self._scene = scene
        self._models: dict[Any, ReducedModel] = {} if beside is None else beside._models
        self._kept: dict[Any, Any] = {}
        self._asked: set[Any] | None = None

    def __getattr__(self, name: str) -> Any:
        if self._asked is not None:
            self._asked.add(("attribute", name))
        return getattr(self._scene, name)

    def watched(self, make: Callable[[Remembered], T]) -> tuple[T, frozenset[Any]]:
        """Result of `make` for this scene, and all questions that were asked for it."""
        self._asked = set()
        try:
            return make(self), frozenset(self._asked)
        finally:
            self._asked = None

    def answers_as(self, other: Remembered, question: Any) -> bool:
        """Whether another scene, which differs in numbers alone, has the answer to a question that this one was asked.

        Of things without a value of their own it has that only if it holds the very same. A position is the same if no complex number
        has met it: so that what one step in a scene's numbers leaves alone it leaves alone at all of them.
        """
        kind, *about = question
        if kind in ("attribute", "interface"):
            mine, its = (
                getattr(each, about[0]) if kind == "attribute" else each.points.get(about[0])
                for each in (self._scene, other._scene)
            )
            return mine is its
        if kind == "position" and self._written_alike(other, about[0]):
            return True
        mine = self._kept[question]
        if kind == "arc lengths":
            return bool(other.arc_lengths(about[0].item) == mine)
        its = other.size if kind == "size" else getattr(other, kind)(*about)
        return mine is its or (kind == "position" and not np.iscomplexobj(its)) or (kind == "size" and bool(mine == its))

    def _written_alike(self, other: Remembered, point: str) -> bool:
        """Whether another scene has the very same point, which depends on nothing else."""
        written = self._scene.points.get(point)
        return isinstance(written, Point) and other.points.get(point) is written

    def interface(self, point: str) -> Any:
        """Description of a point as it was written."""
        return self.once(("interface", point), lambda: self._scene.interface(point))

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, (d,)."""
        return self.once(("position", point), lambda: position_in(self, point))

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model in a file."""
        return self.once(("model", path, *parts), lambda: self._read(path, *parts))

    def _read(self, path: str, *parts: str) -> ReducedModel:
        if (path, parts) not in self._models:
            self._models[path, parts] = self._scene.model(path, *parts)
        return self._models[path, parts]

    def arc_lengths(self, body: Any) -> dict[str, Any]:
        """Interface points of a body that the scene puts elsewhere along it."""
        return self.once(("arc lengths", Itself(body)), lambda: self._scene.arc_lengths(body))

    def of_body(self, body: Any, what: Hashable, make: Callable[[], T]) -> T:
        """Result of a computation for one body, made once.

        Its questions count each time, as if it were made each time.
        """
        key, outer = (what, id(body)), self._asked
        if key not in self._kept:
            self._asked = set()
            try:
                self._kept[key] = make(), self._asked, body  # which nothing else has the number of as long as it is kept
            finally:
                self._asked = outer
        found, asked, _ = self._kept[key]
        if outer is not None:
            outer |= asked
        made: T = found
        return made

    @property
    def size(self) -> float:
        """Length that displacements are compared with, see `Scene.size`."""
        return self.once(("size",), lambda: size_of(self))

    def once(self, key: Hashable, make: Callable[[], T]) -> T:
        """Result of `make`, made when it is first asked for under this key."""
        outer, self._asked = self._asked, None  # what answers a question asks others, which the answer speaks for
        if outer is not None:
            outer.add(key)
        if key not in self._kept:
            self._kept[key] = make()
        self._asked = outer
        found: T = self._kept[key]
        return found
