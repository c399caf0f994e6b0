"""Rigid bodies and links as lines for ParaView."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import pyvista


def mechanism(moment: Any, but: Collection[str] = ()) -> Any:
    """Rigid bodies and links of a configuration in the plane or in space as lines, or None; without bodies that are shown already."""
    lines = [*moment.rods(but), *map(moment.ends, moment.links()), *moment.wheels()]
    return pyvista.PolyData().append_polydata(*(pyvista.lines_from_points(lifted(ends)) for ends in lines)) if lines else None


def lifted(points: np.ndarray) -> np.ndarray:
    """Points (n, 2) of the plane in space, (n, 3); points of space stay."""
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))]).astype(float)
