"""What the reduced model of a solid in pieces tells of its surface and of pressures on it: each piece is one of the model's elements, with
a node at both ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pieces:
    """Surface points by the piece that each belongs to: places are `position @ [1; u]`, u of the nodes of the element."""

    element: np.ndarray  # (n_points,)
    position: np.ndarray  # (n_points, 3, 13)


@dataclass(frozen=True)
class PieceLoads:
    """A unit pressure on a named surface, piece by piece: f and L of `SurfaceLoad`, on [1; u] of the nodes of the element.

    Under such forces at its ends the piece moves these as the pressure would at rest; how it deforms between them is not in it.
    """

    force: np.ndarray  # (n_elements, 3)
    moment: np.ndarray  # (n_elements, 3, 3, 13)
