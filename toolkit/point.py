"""Points: the skeleton of a scene, in the undeformed global configuration."""

from __future__ import annotations

from toolkit.description import Description, Number


class Point(Description):
    """A point given by its coordinates.

    Attributes
    ----------
    x
        Coordinate in the undeformed global configuration, in units of length.
    y
        Likewise.
    """

    x: Number
    y: Number


class BodyPoint(Description):
    """An interface point of a flexible body; `arc_length` moves it along the body, within the element it was made for.

    Attributes
    ----------
    body
        Name of the flexible body.
    interface
        Name of the interface point in the body's reduced model; "(frame)" is the origin of the body's frame, which does not deform.
    arc_length
        Place along the body, in units of length from its start; by default where preprocessing put the point.
    """

    body: str
    interface: str
    arc_length: Number | None = None
