"""What the reduced model of a solid in pieces tells of its surface: each piece is one of the model's elements, with a node at both ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pieces:
    """Every point of the surface by the piece that it is told by: its place is `position @ [1; u]`, u of the nodes of the element."""

    element: np.ndarray  # (n_points,)
    position: np.ndarray  # (n_points, 3, 13)
