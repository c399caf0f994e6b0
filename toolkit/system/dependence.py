"""Dependence on a number of a scene: it can change only the items that name its owner, directly or through others, and of these only
those whose numbers were made with an answer of the scene that it changes.

A joint finds its bodies, a rod its points, a point its body by name; gravity alone acts on all without being named, and a body alone
depends on points that name it. So a step in one number needs to evaluate those items only, which keeps the compilation of hundreds of
variables short.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from toolkit.components.bodies.body import Body
from toolkit.components.loads.gravity import UniformGravity
from toolkit.description.description import Description, Scalar
from toolkit.description.design import BodyPoint, Point
from toolkit.foundation.itself import Itself
from toolkit.reduced_model.model import ReducedModel
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene

T = TypeVar("T")
Item = tuple[str, str]
"""Group and name, for example ("points", "A")."""
GROUPS = ("points", "bodies", "joints", "loads")


class Affected(NamedTuple):
    """Items of a scene, and markers by their numbers, that some numbers may change."""

    items: frozenset[Item]
    markers: frozenset[int]

    def __and__(self, other: Affected) -> Affected:  # type: ignore[override]
        """Items and markers that the numbers of both may change; mixed derivatives of all else are zero."""
        return Affected(self.items & other.items, self.markers & other.markers)


def affected_by(
    scene: ResolvedScene, markers: Sequence[tuple[str, ...]], paths: list[str], users: dict[str, list[Item]]
) -> Affected:
    """Items and markers that the numbers at some paths may change.

    `users` are those of `users_by_name`, `markers` those of the numbering.
    """
    found = [affected_items(scene, path, users) for path in paths]
    everything = {(group, name) for group in ("bodies", "joints", "loads") for name in _names(scene, group)}
    items = frozenset().union(*(everything if each is None else each for each in found))
    if None in found:
        return Affected(items, frozenset(range(len(markers))))
    return Affected(items, frozenset(m for m, grip in enumerate(markers) if not items.isdisjoint(_behind(grip))))


def _names(scene: ResolvedScene, group: str) -> list[str]:
    return list(scene.all_bodies() if group == "bodies" else getattr(scene, group))


def _behind(grip: tuple[str, ...]) -> list[Item]:
    """Items that a marker's numbers follow from: its body, its point, and the component whose axes it has."""
    body, point, *component = grip
    return [("bodies", body), ("points", point), *((owner.partition(".")[0], owner.partition(".")[2]) for owner in component)]


def users_by_name(scene: ResolvedScene) -> dict[str, list[Item]]:
    """Name -> items that name it, whatever they mean by it."""
    found: dict[str, list[Item]] = {}
    for group in GROUPS:
        items = scene.all_bodies() if group == "bodies" else getattr(scene, group)
        for name, item in items.items():
            for word in _words(item):
                found.setdefault(word, []).append((group, name))
    return found


def affected_items(scene: Scene, path: str, users: dict[str, list[Item]]) -> set[Item] | None:
    """Items that the number at a path may change; None if it may change all."""
    group, name = path.split(".")[:2]
    if isinstance(getattr(scene, group)[name], UniformGravity):
        return None
    found: set[Item] = set()
    waiting: list[Item] = [(group, name)]
    while waiting:
        item = waiting.pop()
        if item not in found:
            found.add(item)
            waiting += users.get(item[1], [])
            point = scene.points.get(item[1]) if item[0] == "points" else None
            if isinstance(point, BodyPoint):
                waiting.append(("bodies", point.body))  # whose shapes may follow the place of the point
    return found


def items_of(scene: Scene, paths: Iterable[str], users: dict[str, list[Item]]) -> set[Item]:
    """Items that any of the numbers at paths may change, without what the direction of gravity does to all."""
    return {item for path in paths for item in affected_items(scene, path, users) or ()}


def _words(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Description):
        for _, below in value:
            yield from _words(below)
    elif isinstance(value, (tuple, list)):
        for below in value:
            yield from _words(below)


Question: TypeAlias = tuple[Hashable, ...]
"""What was asked of a scene: "attribute", "interface", "position" and so on, and of what."""


class AskedScene:
    """A scene as bodies, joints and loads ask it (`bodies.body.Placed`), which notes what is asked.

    Parameters
    ----------
    scene
        The scene, which has the answers.
    """

    def __init__(self, scene: ResolvedScene) -> None:
        self._scene = scene
        self._asked: set[Question] = set()
        self._made: dict[Any, tuple[Any, set[Any]]] = {}

    def __getattr__(self, name: str) -> Any:
        self._asked.add(("attribute", name))
        return getattr(self._scene, name)

    def watched(self, make: Callable[[AskedScene], T]) -> tuple[T, frozenset[Question]]:
        """Result of `make` for this scene, and all questions that were asked for it."""
        self._asked = set()
        return make(self), frozenset(self._asked)

    def interface(self, point: str) -> Point | BodyPoint:
        """Description of a point as it was written."""
        self._asked.add(("interface", point))
        return self._scene.interface(point)

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, (d,)."""
        self._asked.add(("position", point))
        return self._scene.position(point)

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model in a file."""
        self._asked.add(("model", path, *parts))
        return self._scene.model(path, *parts)

    def arc_lengths(self, body: Body) -> dict[str, Scalar]:
        """Interface points of a body that the scene puts elsewhere along it."""
        self._asked.add(("arc lengths", Itself(body)))
        return self._scene.arc_lengths(body)

    @property
    def size(self) -> float:
        """Model size."""
        self._asked.add(("size",))
        return self._scene.size

    def of_body(self, body: Body, what: Hashable, make: Callable[[], T]) -> T:
        """Result of a computation for one body, made once; its questions count each time, as if it were made each time."""
        key, outer = (what, Itself(body)), self._asked
        if key not in self._made:
            self._asked = set()
            try:
                self._made[key] = make(), self._asked
            finally:
                self._asked = outer
        found, asked = self._made[key]
        outer |= asked
        made: T = found
        return made


def answers_alike(scene: ResolvedScene, other: ResolvedScene, question: Question) -> bool:
    """Whether another scene, which differs in numbers alone, has the answer to a question that `AskedScene` has noted of this one.

    Of things without a value of their own it has that only if it holds the very same. A position is the same if no complex number
    has met it: so that what one step in a scene's numbers leaves alone it leaves alone at all of them.
    """
    kind, about = question[0], list[Any](question[1:])
    if kind == "attribute":
        return getattr(scene, about[0]) is getattr(other, about[0])
    if kind == "interface":
        return scene.points.get(about[0]) is other.points.get(about[0])
    if kind == "position":
        written = scene.points.get(about[0])
        alike = isinstance(written, Point) and other.points.get(about[0]) is written  # and a point depends on nothing else
        return alike or not np.iscomplexobj(other.position(about[0]))
    if kind == "arc lengths":
        return bool(other.arc_lengths(about[0].item) == scene.arc_lengths(about[0].item))
    return scene.size == other.size if kind == "size" else scene.model(*about) is other.model(*about)
