"""Points: the skeleton of a scene, in the undeformed global configuration."""

from __future__ import annotations

from toolkit.description import Description, Number


class Point(Description):
    """A point given by its coordinates."""

    x: Number
    y: Number


class BodyPoint(Description):
    """An interface point of a flexible body; `arc_length` moves it along the body, within the element it was made for."""

    body: str
    interface: str
    arc_length: Number | None = None
