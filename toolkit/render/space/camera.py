"""The eye that looks at a scene in space: an isometric view that frames given points, parallel or in perspective."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ANGLE = np.deg2rad(25.0)
"""Angle of view from the lower to the upper edge of a picture in perspective."""
ISOMETRIC = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 2.0], [1.0, -1.0, 1.0]]) / np.sqrt([[2.0], [6.0], [3.0]])
"""Directions to the right, up and towards the eye: x comes to the front on the right, y goes to the back on the right, z is up."""
_LEAST = 0.25
"""Half of what is seen at least, relative to the reach: of a rod along the line of sight."""
_CLEAR = 2.2
"""Distance by which things are moved before or behind all others, relative to the reach; these are at most two apart."""


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
        How far things are from the focus at most.
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
        """Nearest view of an aspect (width over height) that shows all points (n, 3), with a margin relative to their extent."""
        seen = points @ ISOMETRIC.T
        reach = 0.6 * float(np.linalg.norm(np.ptp(seen, axis=0))) or 0.5
        middle = (seen.min(axis=0) + seen.max(axis=0)) / 2
        seen = np.vstack([seen, middle + _LEAST * reach * np.vstack([np.eye(3), -np.eye(3)])])
        size = _framed(np.ptp(seen[:, :2], axis=0), aspect, margin)
        if not perspective:
            return cls(middle @ ISOMETRIC, size, 5 * reach, reach, False)
        beside, height = np.abs(seen - middle), np.tan(ANGLE / 2)
        need = np.maximum(beside[:, 0] / aspect, beside[:, 1]) * (1 + 2 * margin) / height
        distance = max(float(np.max(seen[:, 2] - middle[2] + need)), 1.5 * reach)
        return cls(middle @ ISOMETRIC, 2 * distance * height * np.array([aspect, 1.0]), distance, reach, True)

    @property
    def eye(self) -> np.ndarray:
        """Position of the camera, (3,)."""
        return self.focus + self.distance * ISOMETRIC[2]

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Places (..., 2) of points (..., 3) on the plane through the focus, from the lower left corner of the view."""
        local = (points - self.focus) @ ISOMETRIC.T
        nearness = self.distance / (self.distance - local[..., 2:]) if self.perspective else 1.0
        return local[..., :2] * nearness + self.size / 2

    def nearer(self, points: np.ndarray, shift: float) -> np.ndarray:
        """Points (n, 3) moved towards the eye by about a length, without a change of where they are seen."""
        return self._along_sight(points, shift, 1 - shift / self.distance)

    def before_all(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) moved before everything else, without a change of where they are seen."""
        return self._along_sight(points, _CLEAR * self.reach, self._nearest / self._farthest)

    def behind_all(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) moved behind everything else, without a change of where they are seen."""
        return self._along_sight(points, -_CLEAR * self.reach, self._farthest / self._nearest)

    @property
    def range(self) -> tuple[float, float]:
        """Distances from the eye that contain everything, also what was moved before and behind all else."""
        if self.perspective:
            return 0.9 * self._nearest**2 / self._farthest, 1.1 * self._farthest**2 / self._nearest
        return self._nearest - _CLEAR * self.reach, self._farthest + _CLEAR * self.reach

    @property
    def _nearest(self) -> float:
        return self.distance - self.reach

    @property
    def _farthest(self) -> float:
        return self.distance + self.reach

    def _along_sight(self, points: np.ndarray, shift: float, factor: float) -> np.ndarray:
        """Points moved by a length in parallel projection, in perspective to a multiple of their distance from the eye."""
        return self.eye + (points - self.eye) * factor if self.perspective else points + shift * ISOMETRIC[2]


def natural_aspect(points: np.ndarray, least: float, largest: float) -> float:
    """Width over height of the view of points (n, 3), within bounds, so that a panel is empty at no side."""
    width, height = np.ptp(points @ ISOMETRIC[:2].T, axis=0)
    return float(np.clip(width / height if height else largest, least, largest))


def _framed(extent: np.ndarray, aspect: float, margin: float) -> np.ndarray:
    """Width and height (2,) of the smallest rectangle of an aspect round an extent (2,), with a margin relative to that."""
    size = extent + 2 * margin * max(extent.max(), 1e-12)
    return np.maximum(size, [size[1] * aspect, size[0] / aspect])
