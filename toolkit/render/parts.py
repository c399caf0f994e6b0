"""The parts of a picture as meshes in the plane: lines, dashes, tubes, dots."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista


def line(points: np.ndarray, height: float = 0.0) -> Any:
    """A polyline through points (n, 2) at a height above the plane; what is higher covers what is lower."""
    return pyvista.lines_from_points(lifted(points, height))


def dashes(points: np.ndarray, length: float, height: float = 0.0) -> Any:
    """A polyline broken into dashes of a length, with gaps two thirds as long; None if there is nothing to draw."""
    arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    starts = np.arange(0, arc[-1], length * 5 / 3)
    pieces = []
    for start, end in zip(starts, np.minimum(starts + length, arc[-1]), strict=True):
        inside = arc[(arc > start) & (arc < end)]
        places = np.concatenate([[start], inside, [end]])
        pieces.append(line(np.column_stack([np.interp(places, arc, column) for column in points.T]), height))
    return pyvista.merge(pieces) if pieces else None


def tube(points: np.ndarray, radius: float) -> Any:
    """A tube along a polyline (n, 2)."""
    return line(points).tube(radius=radius, n_sides=24)


def dot(point: np.ndarray, radius: float, height: float) -> Any:
    """A flat disc."""
    return pyvista.Disc(center=lifted(point[None], height)[0], inner=0.0, outer=radius, c_res=32)


def lines(every: list[np.ndarray], height: float) -> Any:
    """Several polylines, each (n, 2), as one mesh."""
    return pyvista.merge([line(points, height) for points in every])


def lifted(points: np.ndarray, height: float) -> np.ndarray:
    """Points (n, 2) of the plane at a height above it, (n, 3)."""
    return np.column_stack([points, np.full(len(points), height)]).astype(float)
