"""Dependence on a number of a scene: it can change only the items that name its owner, directly or through others.

A joint finds its bodies, a rod its points, a point its body by name; gravity alone acts on all without being named, and a body alone
depends on points that name it. So a step in one number needs to evaluate those items only, which keeps the compilation of hundreds of
variables short.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from toolkit.description.description import Description
from toolkit.description.point import BodyPoint
from toolkit.loads.gravity import UniformGravity
from toolkit.scene.scene import Scene

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


def affected_by(scene: Scene, markers: Sequence[tuple[str, ...]], paths: list[str], users: dict[str, list[Item]]) -> Affected:
    """Items and markers that the numbers at some paths may change.

    `users` are those of `users_by_name`, `markers` those of the numbering.
    """
    found = [affected_items(scene, path, users) for path in paths]
    everything = {(group, name) for group in ("bodies", "joints", "loads") for name in _names(scene, group)}
    items = frozenset().union(*(everything if each is None else each for each in found))
    if None in found:
        return Affected(items, frozenset(range(len(markers))))
    return Affected(items, frozenset(m for m, grip in enumerate(markers) if not items.isdisjoint(_behind(grip))))


def _names(scene: Scene, group: str) -> list[str]:
    return list(scene.all_bodies() if group == "bodies" else getattr(scene, group))


def _behind(grip: tuple[str, ...]) -> list[Item]:
    """Items that a marker's numbers follow from: its body, its point, and the component whose axes it has."""
    body, point, *component = grip
    return [("bodies", body), ("points", point), *((owner.partition(".")[0], owner.partition(".")[2]) for owner in component)]


def users_by_name(scene: Scene) -> dict[str, list[Item]]:
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


def _words(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Description):
        for _, below in value:
            yield from _words(below)
    elif isinstance(value, (tuple, list)):
        for below in value:
            yield from _words(below)
