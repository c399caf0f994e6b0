"""The eye that looks at a scene in space: an isometric view that frames given points, parallel or in perspective."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.render.panel import Window

ANGLE = np.deg2rad(25.0)
"""From the lower to the upper edge of a picture in perspective."""
ISOMETRIC = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 2.0], [1.0, -1.0, 1.0]]) / np.sqrt([[2.0], [6.0], [3.0]])
"""Directions to the right, up and towards the eye: x comes to the front on the right, y goes to the back on the right, z is up."""


@dataclass(frozen=True)
class Camera:
    """An isometric view of a box of points.

    Attributes
    ----------
    focus
        What it looks at, (3,).
    size
        Width and height of what it sees at the focus, (2,), in the scene's unit of length.
    distance
        From the eye to the focus.
    reach
        How far things are from the focus at most, along the line of sight.
    perspective
        Whether what is nearer is larger.
    """

    focus: np.ndarray
    size: np.ndarray
    distance: float
    reach: float
    perspective: bool

    @classmethod
    def framing(cls, points: np.ndarray, aspect: float, margin: float, perspective: bool) -> Camera:
        """The nearest view of an aspect (width over height) that shows all points (n, 3), with a margin relative to their extent."""
        seen = points @ ISOMETRIC.T
        reach = max(0.6 * float(np.linalg.norm(np.ptp(seen, axis=0))), 1e-12)
        middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
        window = Window.around(seen[:, :2], aspect, margin)
        if not perspective:
            return cls(middle @ ISOMETRIC, window.size, 4 * reach, reach, False)
        beside, height = np.abs(seen - middle), np.tan(ANGLE / 2)
        need = np.maximum(beside[:, 0] / aspect, beside[:, 1]) * (1 + 2 * margin) / height
        distance = max(float(np.max(seen[:, 2] - middle[2] + need)), 1.2 * reach)
        return cls(middle @ ISOMETRIC, 2 * distance * height * np.array([aspect, 1.0]), distance, reach, True)

    @property
    def eye(self) -> np.ndarray:
        """Where it is, (3,)."""
        return self.focus + self.distance * ISOMETRIC[2]

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) on the plane through the focus, from the lower left corner of what it shows, (..., 2)."""
        local = (points - self.focus) @ ISOMETRIC.T
        nearness = self.distance / (self.distance - local[..., 2:]) if self.perspective else 1.0
        return local[..., :2] * nearness + self.size / 2

    def nearer(self, points: np.ndarray, shift: float) -> np.ndarray:
        """Points (n, 3) moved towards the eye by about a length, or away by a negative one, without a change of where they are seen."""
        if self.perspective:
            return points + (self.eye - points) * self.ratio(shift)
        return points + shift * ISOMETRIC[2]

    def ratio(self, shift: float) -> float:
        """Part of the way to the eye that a shift is in perspective."""
        return float(np.clip(shift / self.distance, -0.9, 0.9))
