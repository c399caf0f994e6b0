"""What pictures are asked for: their format, and how a scene in space is looked at."""

from __future__ import annotations

from dataclasses import dataclass

from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene

FORMATS = ("png", "svg", "pdf")


@dataclass(frozen=True)
class View:
    """Choices of pictures that a user can make.

    Attributes
    ----------
    perspective
        Whether what is nearer is larger; else the projection is parallel and has a scale.
    triads
        Whether the axes of the bodies' frames are drawn.
    format
        Of the files: of planar scenes also svg or pdf, which stay sharp at every size.
    """

    perspective: bool = False
    triads: bool = False
    format: str = "png"

    def check(self, scene: Scene) -> None:
        """Refuse choices that pictures of a scene do not have.

        Raises
        ------
        InputError
            There is no such format, pictures of space are to be vectors, or a planar scene is to be seen as space is.
        """
        if self.format not in FORMATS:
            raise InputError(f"there are no pictures of format {self.format!r}. Take one of {', '.join(FORMATS)}.")
        if not scene.space.camera and (self.perspective or self.triads):
            raise InputError("perspective and triads belong to pictures of space, and this scene is planar: leave them out.")
        if scene.space.camera and self.format != "png":
            raise InputError(f"pictures of space consist of pixels and cannot be written as {self.format}: leave the format out.")
