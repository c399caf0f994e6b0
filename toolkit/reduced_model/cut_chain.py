"""The elements of a body as chains, where its points lie along them, and Craig-Bampton shapes of a part of a chain.

With the elastic coordinates of the part sorted into kept ones b and inner ones i,

    [b]   [      1         0  ] [b]
    [i] = [-K_ii^-1 K_ib   Phi] [p]

so that forces at kept coordinates, and what inner ones hand on to these at rest, are exact with any number of modes (R. R. Craig,
M. C. C. Bampton, AIAA J. 6 (1968) 1313). Phi are the lowest modes with b held, and then what these leave out of K_ii^-1 times the inertia
under uniform accelerations along and across the chord, by which weight bends and stretches the part as it does with all coordinates
(modal truncation augmentation: J. M. Dickens, J. M. Nakagawa, M. J. Wittbrodt, Comput. Struct. 62 (1997) 985).

The constraint modes follow the design, complex steps too. Phi is that of the nominal design of the reduced model, whatever the design:
shapes, of which the derivative is none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import clusters, told_apart
from toolkit.reduced_model.parts import Elements, SpatialElements

NODE_DISTANCE = 1e-9
"""A point closer to a node than this part of its element is on the node."""


class ChainPlace(NamedTuple):
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


def place_at(connectivity: np.ndarray, node: int) -> ChainPlace:
    """Place of a node as the first or, if it is none, the second end of an element."""
    for end in (0, 1):
        elements = np.flatnonzero(connectivity[:, end] == node)
        if len(elements):
            return ChainPlace(int(elements[0]), float(end))
    raise ValueError(f"no element has node {node}")


def place_of(elements: Elements | SpatialElements, position: np.ndarray, what: str) -> ChainPlace:
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
    near = np.flatnonzero(distance <= distance.min() + NODE_DISTANCE)
    nodes = elements.connectivity[near, np.round(inside[near]).astype(int)]
    at_node = np.abs(inside[near] - np.round(inside[near])) <= NODE_DISTANCE
    if len(near) > 1 and not (np.all(at_node) and np.all(nodes == nodes[0])):
        raise InputError(
            f"{what} lies on elements {near[0]} and {near[-1]} of the body at once, so that nobody knows which of its parts holds the "
            "point. Leave `frames` out, or move the point."
        )
    element = int(near[0])
    end = round(float(inside[element]))
    if abs(inside[element] - end) > NODE_DISTANCE:
        return ChainPlace(element, ratio[element])
    moved = max(np.abs(np.imag(position)).max(), np.abs(np.imag(ends[element])).max()) / np.sqrt(np.real(square[element]))
    if abs(np.imag(ratio[element])) > NODE_DISTANCE * moved:
        raise InputError(
            f"{what} lies at a node of the body, between elements: with several floating frames its place along the body has no derivative "
            "there. Move the point off the node, or leave `frames` out."
        )
    return ChainPlace(element, float(end))


UNMOVED_PART = 1e-9
"""Part of the strongest motion of a mode below which that of a coordinate is round-off: beams that bend do not stretch."""


@dataclass(frozen=True, eq=False)
class PartShapes:
    """Craig-Bampton shapes of a part: the elastic coordinates that are kept, and fixed-interface modes on the others."""

    kept: np.ndarray  # (n_b,) numbers of elastic coordinates, in their order
    modes: np.ndarray  # Phi (n_i, n_p), real
    weights: int = 0  # how many of its last columns are shapes under uniform acceleration

    @property
    def count(self) -> int:
        """Number of coordinates of the reduced part."""
        return len(self.kept) + self.modes.shape[1]

    @property
    def names(self) -> list[str]:
        """Names of the mode coordinates, the columns of Phi."""
        modes = [f"fixed-interface mode {k + 1}" for k in range(self.modes.shape[1] - self.weights)]
        return [*modes, *(f"shape {k + 1} under uniform acceleration" for k in range(self.weights))]

    def columns(self, stiffness: np.ndarray) -> np.ndarray:
        """Elastic coordinates per kept and mode coordinate, (n_f, n_b + n_p), at the stiffness (n_f, n_f) of a design."""
        inner = np.delete(np.arange(len(stiffness)), self.kept)
        found = np.zeros((len(stiffness), self.count), stiffness.dtype)
        found[self.kept, np.arange(len(self.kept))] = 1
        if inner.size:
            found[inner, : len(self.kept)] = -_solved(stiffness[np.ix_(inner, inner)], stiffness[np.ix_(inner, self.kept)])
            found[inner, len(self.kept) :] = self.modes
        return found


def part_shapes(stiffness: np.ndarray, inertia: np.ndarray, weights: np.ndarray, kept: np.ndarray, count: int) -> PartShapes:
    """Craig-Bampton shapes with the lowest fixed-interface modes; all coordinates if these are no more than the shapes.

    Modes of equal frequency are taken together, so that there may be some more than `count`.

    Parameters
    ----------
    stiffness, inertia : (n_f, n_f)
        Of the part at the nominal design; the inertia in parts of its mass, so that a mode coordinate is the RMS displacement of the part.
    weights : (n_f, d)
        Forces of inertia under uniform accelerations.
    kept : (n_b,)
        Numbers of the coordinates that are kept.
    """
    inner = np.delete(np.arange(len(stiffness)), kept)
    if len(inner) <= count + weights.shape[1]:
        return PartShapes(np.arange(len(stiffness)), np.zeros((0, 0)))
    own = np.ix_(inner, inner)
    return PartShapes(kept, *_inner_shapes(stiffness[own], inertia[own], weights[inner], count))


def _inner_shapes(stiffness: np.ndarray, mass: np.ndarray, weights: np.ndarray, count: int) -> tuple[np.ndarray, int]:
    """Shapes Phi (n_i, n_p) at unit inertia, and how many of its last columns are shapes under uniform acceleration.

    Such shapes are left out where the modes contain them but for round-off.
    """
    shapes, sizes = _modes(stiffness, mass, count), np.sqrt(np.diag(mass))
    n_modes = shapes.shape[1]
    for bent in _solved(stiffness, weights).T:
        known = UNMOVED_PART**2 * (bent @ mass @ bent)
        for _ in range(2):  # once leaves round-off of the part that is taken out
            bent = bent - shapes @ (shapes.T @ (mass @ bent))
        if (square := bent @ mass @ bent) > known:
            shapes = np.column_stack([shapes, bent / np.sqrt(square)])
    moves = sizes[:, None] * np.abs(shapes)
    return np.where(moves > UNMOVED_PART * moves.max(axis=0, initial=0.0), shapes, 0.0), shapes.shape[1] - n_modes


def _modes(stiffness: np.ndarray, mass: np.ndarray, count: int) -> np.ndarray:
    """Lowest normal modes (n_i, m), as eigenvectors of the flexibility, so that they have the most digits."""
    if not count:
        return np.zeros((len(mass), 0))
    factor = np.linalg.cholesky(mass)
    moved = _solved(stiffness, factor)
    flexibility = factor.T @ moved
    values, turned = np.linalg.eigh(-(flexibility + flexibility.T) / 2)
    squares = -1 / values
    behind = next(behind for _, behind in clusters(squares) if behind >= count)
    return told_apart(squares[:behind], moved @ turned[:, :behind] * squares[:behind], np.sqrt(np.diag(mass)))


def _solved(matrix: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Solution of a linear system with a narrow band, matrix^-1 sides, both real or complex."""
    return scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix)).solve(sides.astype(matrix.dtype))
