"""Rigid bodies and links as lines for ParaView."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista


def mechanism(moment: Any) -> Any:
    """Rigid bodies and links of a configuration in the plane or in space as lines, or None."""
    lines = [*moment.rods(), *map(moment.ends, moment.links()), *moment.wheels()]
    return pyvista.PolyData().append_polydata(*(pyvista.lines_from_points(lifted(ends)) for ends in lines)) if lines else None


def lifted(points: np.ndarray) -> np.ndarray:
    """Points (n, 2) of the plane in space, (n, 3); points of space stay."""
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))]).astype(float)
