"""The elements of a body as a chain or as several ones that meet, and where its points lie along them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.parts import Elements, SpatialElements

ON_NODE = 1e-9
"""A point closer to a node than this part of its element is on the node."""


class Place(NamedTuple):
    """Point of a chain by its element and its distance from the first node in element lengths; at a node 0 or 1."""

    element: int
    ratio: Any

    @property
    def station(self) -> float:
        """Position along the chain, counted in elements from its beginning."""
        return self.element + float(np.real(self.ratio))

    @property
    def at_node(self) -> bool:
        """Whether the point is an end of its element."""
        return self.ratio in (0.0, 1.0)


def chain_nodes(connectivity: np.ndarray) -> np.ndarray | None:
    """Nodes in the order of the chain, (n_elements + 1,); None if the elements are no chain."""
    follows = np.array_equal(connectivity[1:, 0], connectivity[:-1, 1])
    nodes = np.append(connectivity[:, 0], connectivity[-1:, 1])
    return nodes if follows and len(set(nodes.tolist())) == len(nodes) else None


def nodes_of_part(connectivity: np.ndarray, first: int, last: int) -> np.ndarray:
    """Numbers of the nodes of a chain's elements from `first` up to, but without, `last`, (n_nodes,)."""
    return np.append(connectivity[first:last, 0], connectivity[last - 1, 1])


def breaks(connectivity: np.ndarray) -> list[int]:
    """Numbers of elements before which a chain ends, as they begin elsewhere or where other elements meet."""
    nodes, count = np.unique(connectivity, return_counts=True)
    two = np.isin(connectivity[1:, 0], nodes[count == 2]) & (connectivity[1:, 0] == connectivity[:-1, 1])
    return [int(k) + 1 for k in np.flatnonzero(~two)]


def node_labels(connectivity: np.ndarray) -> dict[int, int]:
    """Node -> its number for people: along a chain from its beginning, else its own."""
    order = chain_nodes(connectivity)
    nodes = [int(node) for node in (np.unique(connectivity) if order is None else order)]
    return dict(zip(nodes, nodes if order is None else range(len(nodes)), strict=True))


def place_at(connectivity: np.ndarray, node: int) -> Place:
    """Place of a node as the first or, if it is none, the second end of an element."""
    for end in (0, 1):
        elements = np.flatnonzero(connectivity[:, end] == node)
        if len(elements):
            return Place(int(elements[0]), float(end))
    raise ValueError(f"no element has node {node}")


def place_of(elements: Elements | SpatialElements, position: np.ndarray, what: str) -> Place:
    """Place of a point (d,) on the chain; complex steps of the nodes and of the point change its ratio.

    Raises
    ------
    InputError
        It is on two elements that do not follow each other, or at a node that a complex step moves it away from.
    """
    ends = elements.nodes[elements.connectivity]
    side = ends[:, 1] - ends[:, 0]
    square = np.sum(side * side, axis=1)
    ratio = np.sum((position - ends[:, 0]) * side, axis=1) / square
    inside = np.clip(np.real(ratio), 0.0, 1.0)
    away = np.real(position - ends[:, 0]) - inside[:, None] * np.real(side)
    distance = np.sum(away * away, axis=1) / np.real(square)
    near = np.flatnonzero(distance <= distance.min() + ON_NODE)
    nodes = elements.connectivity[near, np.round(inside[near]).astype(int)]
    at_node = np.abs(inside[near] - np.round(inside[near])) <= ON_NODE
    if len(near) > 1 and not (np.all(at_node) and np.all(nodes == nodes[0])):
        raise InputError(
            f"{what} lies on elements {near[0]} and {near[-1]} of the body at once, so that nobody knows which of its parts holds the "
            "point. Leave `frames` out, or move the point."
        )
    element = int(near[0])
    end = round(float(inside[element]))
    if abs(inside[element] - end) > ON_NODE:
        return Place(element, ratio[element])
    moved = max(np.abs(np.imag(position)).max(), np.abs(np.imag(ends[element])).max()) / np.sqrt(np.real(square[element]))
    if abs(np.imag(ratio[element])) > ON_NODE * moved:
        raise InputError(
            f"{what} lies at a node of the body, between elements: with several floating frames its place along the body has no derivative "
            "there. Move the point off the node, or leave `frames` out."
        )
    return Place(element, float(end))
