"""The elements of a body as a chain, and where its points lie along it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.elements import Elements, SpatialElements

ON_NODE = 1e-9
"""A point closer to a node than this part of its element is on the node."""


class Place(NamedTuple):
    """A point of a chain: the element, and the part of its length from its first node; at a node the ratio is 0 or 1."""

    element: int
    ratio: Any

    @property
    def station(self) -> float:
        """Elements before the point."""
        return self.element + float(np.real(self.ratio))


def chain_nodes(connectivity: np.ndarray) -> np.ndarray | None:
    """Nodes in the order of the chain, (n_elements + 1,); None if the elements are no chain."""
    follows = np.array_equal(connectivity[1:, 0], connectivity[:-1, 1])
    nodes = np.append(connectivity[:, 0], connectivity[-1:, 1])
    return nodes if follows and len(set(nodes.tolist())) == len(nodes) else None


def place_of(elements: Elements | SpatialElements, position: np.ndarray, what: str) -> Place:
    """Where a point (d,) lies on the chain; complex steps of the nodes and of the point move its ratio.

    Raises
    ------
    InputError
        It is on two elements that do not follow each other.
    """
    ends = elements.nodes[elements.connectivity]
    side = ends[:, 1] - ends[:, 0]
    square = np.sum(side * side, axis=1)
    ratio = np.sum((position - ends[:, 0]) * side, axis=1) / square
    inside = np.clip(np.real(ratio), 0.0, 1.0)
    away = np.real(position - ends[:, 0]) - inside[:, None] * np.real(side)
    distance = np.sum(away * away, axis=1) / np.real(square)
    near = np.flatnonzero(distance <= distance.min() + ON_NODE)
    if near[-1] - near[0] > 1:
        raise InputError(
            f"{what} lies on elements {near[0]} and {near[-1]} of the body at once, so that nobody knows which of its parts holds the "
            "point. Leave `frames` out, or move the point."
        )
    element = int(near[0])
    end = round(float(inside[element]))
    return Place(element, float(end) if abs(inside[element] - end) <= ON_NODE else ratio[element])
