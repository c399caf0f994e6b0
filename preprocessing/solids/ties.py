"""Clamped nodes, and nodes that are tied to a point with position and rotation: what they leave free, and how the point moves.

For nodes at x_k with weights w_k of sum 1 about their mean c, the point P moves by

    theta = sum_k w_k (x_k - c) x u_k / sum_k w_k |x_k - c|^2,      u_P = sum_k w_k u_k + theta e_z x (x_P - c)

Averaged nodes (RBE3) stay as they are; rigid ones (RBE2) follow u_k = u_P + theta e_z x (x_k - x_P), which gives back u_P and theta above.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.solids.solid_mesh import SolidMesh
from toolkit.errors import InputError

NARROW = 1e-9
"""Radius of gyration of tied nodes, in parts of the body's extent, below which they are one point without a rotation."""


@dataclass(frozen=True, eq=False)
class Tie:
    """One interface point."""

    nodes: np.ndarray  # numbers of the nodes that carry it
    point: np.ndarray  # (2,) its undeformed place
    rows: Any  # sparse (3, n): displacement x, y and rotation from the nodal coordinates
    rigid: bool

    def motion(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Z_P (2, 1 + n_f) and T_P (1 + n_f,) for Z = [xi, Psi]; the first column is the undeformed place."""
        moved = self.rows @ z
        moved[:, 0] = [*self.point, 0.0]
        return moved[:2], moved[2]


@dataclass(frozen=True, eq=False)
class Freedom:
    """Independent coordinates: nodal coordinates are T u^, first those of free nodes, then three of each rigid tie."""

    map: Any  # T, sparse (n, n_free + 3 n_rigid)
    rigid: tuple[str, ...]  # names of the rigid ties that can move, in the order of their coordinates

    @property
    def n_free(self) -> int:
        """Number of coordinates of nodes that nothing ties."""
        return self.map.shape[1] - 3 * len(self.rigid)

    def coordinates_of(self, motions: np.ndarray, ties: Mapping[str, Tie]) -> np.ndarray:
        """Independent coordinates (n^, k) of nodal motions (n, k) that leave tied nodes rigid."""
        free = np.unique(self.map.tocoo().row[self.map.tocoo().col < self.n_free])
        return np.vstack([motions[free], *(ties[name].rows @ motions for name in self.rigid)])


def tie(mesh: SolidMesh, nodes: np.ndarray, weights: np.ndarray, at: list[float] | None, rigid: bool) -> Tie:
    """A point carried by nodes.

    Parameters
    ----------
    nodes, weights : (k,), the weights of sum 1
    at : the point, by default the mean of the nodes

    Raises
    ------
    InputError
        A rotation cannot be had from these nodes.
    """
    if len(nodes) == 1:
        return _at_one_node(mesh, int(nodes[0]), at, rigid)
    centre = weights @ mesh.nodes[nodes]
    point = centre if at is None else np.array(at)
    return Tie(nodes, point, _rows(mesh, (nodes, weights), (nodes, weights), point), rigid)


def _at_one_node(mesh: SolidMesh, node: int, at: list[float] | None, rigid: bool) -> Tie:
    """The displacement of the node, and the rotation of those around it."""
    place = mesh.nodes[node]
    if rigid or (at is not None and not np.allclose(at, place, rtol=0, atol=NARROW * mesh.size)):
        raise InputError(
            f"node {node} alone ties no rotation and no other place; name a group of nodes, or leave tie and at out."
        )
    others = mesh.around(node)
    if not len(others):
        raise InputError(f"node {node} alone has no rotation without elements around it; name several nodes.")
    weights = np.full(len(others), 1 / len(others))
    return Tie(np.array([node]), place, _rows(mesh, (np.array([node]), np.ones(1)), (others, weights), place), False)


def _rows(mesh: SolidMesh, carried: tuple, turned: tuple, point: np.ndarray) -> Any:
    """Rows of x, y and rotation from nodes with weights, those that carry the point and those that tell its rotation."""
    (nodes, weights), (others, shares) = carried, turned
    arms = mesh.nodes[others] - shares @ mesh.nodes[others]
    squared = shares @ (arms**2).sum(axis=1)
    if not squared > (NARROW * mesh.size) ** 2:
        raise InputError(f"the {len(others)} nodes are at one place, so that they have no rotation; name nodes that are apart.")
    rows = sparse.lil_array((3, mesh.n))
    rows[2, 2 * others], rows[2, 2 * others + 1] = -shares * arms[:, 1] / squared, shares * arms[:, 0] / squared
    offset = point - weights @ mesh.nodes[nodes]
    rows = rows.tocsr()
    rotation = rows[[2]]
    moved = sparse.coo_array(
        (np.tile(weights, 2), (np.repeat([0, 1], len(nodes)), np.concatenate([2 * nodes, 2 * nodes + 1]))), shape=(2, mesh.n)
    )
    return sparse.vstack([moved + sparse.vstack([-offset[1] * rotation, offset[0] * rotation]), rotation], format="csr")


def freedom(mesh: SolidMesh, clamped: np.ndarray, ties: Mapping[str, Tie]) -> Freedom:
    """What clamp and rigid ties leave free; a rigid tie whose nodes are all clamped stands still.

    Raises
    ------
    InputError
        Rigid ties share nodes with each other, or partly with the clamp.
    """
    owner = np.full(len(mesh.nodes), "", object)
    owner[clamped] = "the clamp"
    moving = []
    for name, each in ties.items():
        if not each.rigid or np.isin(each.nodes, clamped).all():
            continue
        if shared := sorted(set(owner[each.nodes]) - {""}):
            raise InputError(
                f"the rigid tie of interface point {name!r} shares nodes with {', '.join(shared)}. Let every node belong to one of them."
            )
        owner[each.nodes] = f"that of {name!r}"
        moving.append(name)
    free = np.flatnonzero(np.repeat(owner == "", mesh.dimension))
    unit = sparse.coo_array((np.ones(len(free)), (free, np.arange(len(free)))), shape=(mesh.n, len(free)))
    carried = [_carried(mesh, ties[name]) for name in moving]
    return Freedom(sparse.hstack([unit, *carried], format="csr"), tuple(moving))


def _carried(mesh: SolidMesh, each: Tie) -> Any:
    """Nodal coordinates of the nodes that move with the point, sparse (n, 3)."""
    arms = mesh.nodes[each.nodes] - each.point
    x, ones = 2 * each.nodes, np.ones(len(each.nodes))
    row, column = np.concatenate([x, x + 1, x, x + 1]), np.repeat([0, 1, 2, 2], len(ones))
    return sparse.coo_array((np.concatenate([ones, ones, -arms[:, 1], arms[:, 0]]), (row, column)), shape=(mesh.n, 3))
