"""How a scene in space is looked at."""

from __future__ import annotations

from dataclasses import dataclass

from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene


@dataclass(frozen=True)
class View:
    """Choices of pictures of space.

    Attributes
    ----------
    perspective
        Whether what is nearer is larger; else the projection is parallel and has a scale.
    triads
        Whether the axes of the bodies' frames are drawn.
    """

    perspective: bool = False
    triads: bool = False

    def check(self, scene: Scene) -> None:
        """Refuse choices that pictures of a planar scene do not have.

        Raises
        ------
        InputError
            The scene is planar, and something is not as by default.
        """
        if scene.dimension == 2 and self != View():
            raise InputError("perspective and triads belong to pictures of space, and this scene is planar: leave them out.")
