"""A scene as nested tables, the inverse of reading a scene file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from toolkit.description.description import Description
from toolkit.description.point import Point
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene


def table_of(scene: Scene) -> dict[str, Any]:
    """Tables that `toolkit.scene_file.reader.scene_from_table` makes the same scene from, with every number as it is now.

    Raises
    ------
    InputError
        A number is complex: the scene belongs to a complex step.
    """
    table = _plain(scene)
    del table["directory"]
    return table


def _plain(value: Any) -> Any:
    if isinstance(value, Point):
        return [_plain(number) for number in (value.x, value.y, value.z) if number is not None]
    if isinstance(value, Description):
        kind = getattr(value, "kind", None)
        return ({"type": kind} if kind else {}) | {name: _plain(item) for name, item in value if item is not None}
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        raise InputError("a scene with a complex number cannot be kept in a file. Solve it with real numbers.")
    return value
