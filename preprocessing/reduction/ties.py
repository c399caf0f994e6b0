"""Clamped nodes, and nodes that are tied to a point with position and rotation: what they leave of a solid's coordinates.

Clamped nodes, and nodes that are tied to a point with position and rotation: what they leave free, and how the point moves.

Rigid motions about a place turn the node k, at a_k = x_k - c from it, by R(a_k) theta: theta e_z x a_k in the plane, theta x a_k in space.
For nodes with means sum_kl W_kl f_k g_l, of sum 1, and w_k = sum_l W_kl, about c = sum_k w_k x_k, the point P moves by

    theta = (sum_kl W_kl R(a_k)^T R(a_l))^-1 sum_kl W_kl R(a_l)^T u_k,      u_P = sum_k w_k u_k + R(x_P - c) theta

Averaged nodes (RBE3) stay as they are; rigid ones (RBE2) follow u_k = u_P + R(x_k - x_P) theta, which gives back u_P and theta above.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from preprocessing.mesh.solid_mesh import SolidMesh, rotations, translations
from preprocessing.reduction.boundary import along, left, refuse_short, refuse_unknown
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import Chord

ONE_POINT_RADIUS = 1e-9
"""Radius of gyration of tied nodes, in parts of the body's extent, below which they are one point without a rotation."""
THIN_MOMENT = 1e-12
"""Least moment of tied nodes about an axis, in parts of the largest, below which they are on one line."""


WeightedNodes = tuple[np.ndarray, sparse.sparray]
"""Numbers (k,) of nodes, and the weights W (k, k) of their mean, of sum 1."""


@dataclass(frozen=True, eq=False)
class NodeTie:
    """Interface point tied to nodes; m = 3 motions in the plane, 6 in space."""

    nodes: np.ndarray  # numbers of the nodes that carry it
    point: np.ndarray  # (d,) its undeformed place
    rows: sparse.csr_array  # (m, n): displacements and rotations from the nodal coordinates
    rigid: bool

    def motion(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions Z_P (d, 1 + n_f), and T_P (1 + n_f,) or (3, 1 + n_f), for Z = [xi, Psi].

        The first column is the undeformed place.
        """
        moved, d = self.rows @ z, len(self.point)
        moved[:, 0] = [*self.point, *np.zeros(len(moved) - d)]
        return moved[:d], moved[2] if d == 2 else moved[d:]


@dataclass(frozen=True, eq=False)
class Freedom:
    """Independent coordinates u^ of nodal ones T u^: first those of free nodes, then the motions of each rigid tie."""

    map: sparse.csr_array  # T (n, n_free + m n_rigid)
    rigid: tuple[str, ...]  # names of the rigid ties that can move, in the order of their coordinates
    motions: int = 3  # m, of a point

    @property
    def n_free(self) -> int:
        """Number of coordinates of nodes that nothing ties."""
        return self.map.shape[1] - self.motions * len(self.rigid)

    @property
    def free(self) -> np.ndarray:
        """Numbers of the nodal coordinates that nothing ties, (n_free,)."""
        every = self.map.tocoo()
        return np.unique(every.row[every.col < self.n_free])

    @property
    def floats(self) -> bool:
        """Whether neither a clamp nor a rigid tie takes a coordinate, so that averaged points alone can hold the body."""
        return not self.rigid and self.map.shape[0] == self.map.shape[1]

    @property
    def stiff(self) -> bool:
        """Whether all nodes move with one point, so that the body is rigid."""
        return self.map.shape[1] == self.motions and len(self.rigid) == 1 and bool((np.diff(self.map.indptr) > 0).all())

    def coordinates_of(self, motions: np.ndarray, ties: Mapping[str, NodeTie]) -> np.ndarray:
        """Independent coordinates (n^, k) of nodal motions (n, k) that leave tied nodes rigid."""
        return np.vstack([motions[self.free], *(ties[name].rows @ motions for name in self.rigid)])

    def places(self, nodes: np.ndarray, ties: Mapping[str, NodeTie]) -> np.ndarray:
        """Positions of all independent coordinates, (n^, d)."""
        each = np.repeat(nodes, nodes.shape[1], axis=0)[self.free]
        return np.vstack([each, *(np.tile(ties[name].point, (self.motions, 1)) for name in self.rigid)])


def tie(mesh: SolidMesh, nodes: np.ndarray, spread: sparse.sparray, at: list[float] | None, rigid: bool) -> NodeTie:
    """Interface point carried by nodes; those of the mesh are real, or complex for a complex step.

    Parameters
    ----------
    nodes : (k,)
    spread : W (k, k) sparse, of sum 1
    at : the point, by default the mean of the nodes

    Raises
    ------
    InputError
        A rotation cannot be had from these nodes, or the point has not as many coordinates as they.
    """
    if at is not None and len(at) != mesh.dimension:
        raise InputError(f"at = {at} has {len(at)} coordinates, but the body has {mesh.dimension} axes. Give one for each.")
    if len(nodes) == 1:
        return _at_one_node(mesh, int(nodes[0]), at, rigid)
    centre = spread.sum(axis=1) @ mesh.nodes[nodes]
    point = centre if at is None else np.array(at)
    return NodeTie(nodes, point, _rows(mesh, (nodes, spread), (nodes, spread), point), rigid)


def _at_one_node(mesh: SolidMesh, node: int, at: list[float] | None, rigid: bool) -> NodeTie:
    """Rows of a point at one node: the node's displacement, and the rotation of the nodes around it."""
    place = mesh.nodes[node]
    if rigid or (at is not None and not np.allclose(at, place, rtol=0, atol=ONE_POINT_RADIUS * mesh.size)):
        raise InputError(
            f"node {node} alone ties no rotation and no other place; name a group of nodes, or leave tie and at out."
        )
    return NodeTie(np.array([node]), place, rows_of_place(mesh, np.array([node]), place), False)


def rows_of_place(mesh: SolidMesh, nodes: np.ndarray, place: np.ndarray) -> sparse.csr_array:
    """Rows, sparse (m, n), of displacement and rotation at a place that nodes carry, all alike; one node turns with those around it.

    Raises
    ------
    InputError
        A rotation cannot be had from these nodes.
    """
    turned = nodes if len(nodes) > 1 else mesh.around(int(nodes[0]))
    if not len(turned):
        raise InputError(f"node {nodes[0]} alone has no rotation without elements around it; name several nodes.")
    return _rows(mesh, (nodes, _alike(nodes)), (turned, _alike(turned)), place)


def _alike(nodes: np.ndarray) -> sparse.dia_array:
    return sparse.diags_array(np.full(len(nodes), 1 / len(nodes)))


def _rows(mesh: SolidMesh, carried: WeightedNodes, turned: WeightedNodes, point: np.ndarray) -> sparse.csr_array:
    """Rows of displacements and rotations from nodes with means, those that carry the point and those that tell its rotation."""
    (nodes, spread), (others, spread_of_turns), d = carried, turned, mesh.dimension
    weights = spread.sum(axis=1)
    turns = rotations(mesh.nodes[others] - spread_of_turns.sum(axis=1) @ mesh.nodes[others])  # R(a_k)^T, (n_rotations, k, d)
    flat = turns.reshape(len(turns), -1)
    shares = sparse.kron(spread_of_turns, np.eye(d), format="csr") @ flat.T
    moments = flat @ shares
    sizes = np.linalg.eigvalsh(moments.real)
    if not sizes[0] > max((ONE_POINT_RADIUS * mesh.size) ** 2, THIN_MOMENT * sizes[-1]):
        where = "at one place" if d == 2 else "at one place or on one line"
        raise InputError(f"the {len(others)} nodes are {where}, so that they do not tell a rotation; name nodes that are apart.")
    rotation = _placed(mesh, others, np.linalg.solve(moments, shares.T))
    offset = rotations(point - weights @ mesh.nodes[nodes]).T  # R(x_P - c), (d, n_rotations)
    moved = _placed(mesh, nodes, np.kron(weights, np.eye(d)))
    return sparse.vstack([moved + sparse.csr_array(offset) @ rotation, rotation], format="csr")


def _placed(mesh: SolidMesh, nodes: np.ndarray, values: np.ndarray) -> sparse.csr_array:
    """Values (n_rows, k d) at the coordinates of k nodes."""
    d = mesh.dimension
    column = np.tile((d * nodes[:, None] + np.arange(d)).ravel(), len(values))
    row = np.repeat(np.arange(len(values)), values.shape[1])
    return sparse.coo_array((values.ravel(), (row, column)), shape=(len(values), mesh.n)).tocsr()


def freedom(mesh: SolidMesh, clamped: np.ndarray, ties: Mapping[str, NodeTie]) -> Freedom:
    """Independent coordinates that clamp and rigid ties leave; a rigid tie whose nodes are all clamped stands still.

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
    return Freedom(sparse.hstack([unit, *carried], format="csr"), tuple(moving), mesh.motions)


def _carried(mesh: SolidMesh, each: NodeTie) -> sparse.sparray:
    """Nodal coordinates of the nodes that move with the point, sparse (n, m)."""
    turns = rotations(mesh.nodes[each.nodes] - each.point)
    moved = np.hstack([translations(len(each.nodes), mesh.dimension), turns.reshape(len(turns), -1).T])
    return _placed(mesh, each.nodes, moved.T).T


def chord_turn(chord: Chord, names: Sequence[str], ties: Mapping[str, NodeTie]) -> np.ndarray:
    """Matrix T (m n_points, m n_points - m) from motions that the chord leaves to those of all points; real or complex.

    Parameters
    ----------
    names : of the points, in the order of their motions

    Raises
    ------
    InputError
        One of the two points does not exist, or both are at one place.
    """
    refuse_unknown(chord, names)
    refuse_short(chord, *(np.real(ties[name].point) for name in chord))
    rows = left(along(*(ties[name].point for name in chord)))
    m, one, other = len(rows), *(names.index(name) for name in chord)
    unit = np.eye(m * len(names))
    ends = np.concatenate([m * one + np.arange(m), m * other + np.arange(m)])
    others = np.delete(unit, ends, axis=1)
    turned: np.ndarray = np.column_stack([unit[:, ends] @ rows.T, others])
    return turned


def supported(stiffness: sparse.csr_array, rows: Sequence[sparse.csr_array]) -> sparse.csr_array:
    """Stiffness K + s B^T B of a free body, supported at the point with the fewest nodes.

    B are the rows of that point, among the `rows` that are held besides.

    Where B u is given, that changes nothing but the forces on B.
    """
    held = min(rows, key=lambda each: each.nnz)
    size = stiffness.diagonal().max()
    weight = sparse.diags_array(size / held.multiply(held).sum(axis=1))
    return (stiffness + held.T @ weight @ held).tocsr()
