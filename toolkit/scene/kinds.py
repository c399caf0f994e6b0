"""All kinds of bodies, joints and loads that a scene file can name, for the plane and for space."""

from __future__ import annotations

from collections.abc import Mapping

from toolkit.description.description import Registered, import_room
from toolkit.scene.space import SPACES

DIMENSIONS = tuple(SPACES)
"""Dimensions that a scene can have."""

for _room in ("bodies", "joints", "loads"):
    import_room(f"toolkit.components.{_room}")


def kinds_of(dimension: int) -> dict[str, Mapping[str, type[Registered]]]:
    """Group of the scene -> `type` -> class, of the plane (2) or of space (3), with kinds of users' own."""
    return dict(SPACES[dimension].kinds)
