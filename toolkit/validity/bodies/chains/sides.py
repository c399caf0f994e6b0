"""Elements of a chain as lines between two nodes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.validity.bodies.chains.chain import Chain


class Sides(NamedTuple):
    """Elements of a chain as straight lines: their nodes, lengths and directions."""

    ends: np.ndarray  # (n_e, 2)
    lengths: np.ndarray  # (n_e,)
    along: np.ndarray  # (n_e, d)


def sides_of(behind: Chain) -> Sides:
    """Straight lines of the undeformed elements of a chain."""
    numbers = behind.forms.dofs // behind.per_node
    ends = numbers[:, [0, -1]]
    sides = behind.nodes[ends[:, 1]] - behind.nodes[ends[:, 0]]
    lengths = np.linalg.norm(sides, axis=1)
    return Sides(ends, lengths, sides / lengths[:, None])
