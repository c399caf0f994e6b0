"""The inside of a plane meshed body, which pictures colour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Interior:
    """The nodes of a plane meshed body and the stress there, for pictures: points are `position @ [1; q_f]`.

    The stress at a node is the mean of the elements that meet there, each at that node: E `stress` @ q_f, where E is the parameter that
    `modulus` counts.
    """

    position: np.ndarray  # (n_points, 2, 1 + n_f)
    triangles: np.ndarray  # (n_triangles, 3) points; elements with more nodes are several
    stress: np.ndarray  # (n_points, 4, n_f) xx, yy, zz, xy in the body's axes, in parts of the modulus
    modulus: np.ndarray  # () number of the parameter
