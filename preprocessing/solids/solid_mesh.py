"""A mesh of solid elements as plain arrays: nodes, elements by kind, and groups of nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from toolkit.errors import InputError


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """Nodes and elements in space of dimension d; nodal coordinates are u_1 ... u_d of node 0, then of node 1, and so on.

    Finished matrices may come without elements; then there are no blocks.
    """

    nodes: np.ndarray  # (n_nodes, d)
    blocks: Mapping[str, np.ndarray] = field(default_factory=dict)  # kind in the words of meshio -> (n_e, nodes of one element)
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)  # name -> numbers of nodes
    in_file: np.ndarray | None = None  # (n_nodes,) number of each node in its file, rising, if some of the file were left out

    @property
    def dimension(self) -> int:
        """d of space."""
        return self.nodes.shape[1]

    @property
    def n(self) -> int:
        """Number of nodal coordinates."""
        return self.nodes.size

    @property
    def size(self) -> float:
        """Largest extent of the body along an axis."""
        return float(np.ptp(self.nodes, axis=0).max())

    def around(self, node: int) -> np.ndarray:
        """Numbers of the other nodes of all elements that have a node."""
        with_it = [block[(block == node).any(axis=1)].ravel() for block in self.blocks.values()]
        found = np.unique(np.concatenate([np.zeros(0, int), *with_it]))
        return found[found != node]


def rigid_motions(nodes: np.ndarray) -> np.ndarray:
    """Nodal coordinates of unit translations, and of unit rotations in the planes of two axes about the origin, (n, d (d + 1) / 2)."""
    d = nodes.shape[1]
    columns = [np.tile(axis, len(nodes)) for axis in np.eye(d)]
    for a in range(d):
        for b in range(a + 1, d):
            turned = np.zeros_like(nodes)
            turned[:, a], turned[:, b] = -nodes[:, b], nodes[:, a]
            columns.append(turned.ravel())
    return np.column_stack(columns)


def refuse_parts(mesh: SolidMesh) -> None:
    """Refuse elements that do not hang together.

    Raises
    ------
    InputError
        It says how many parts there are, and where the second one is.
    """
    pairs = [np.column_stack([np.repeat(b[:, 0], b.shape[1]), b.ravel()]) for b in mesh.blocks.values()]
    row, column = np.concatenate(pairs).T
    graph = sparse.coo_array((np.ones(len(row)), (row, column)), shape=(len(mesh.nodes),) * 2)
    parts, label = connected_components(graph, directed=False)
    if parts > 1:
        place = ", ".join(f"{x:g}" for x in mesh.nodes[np.argmax(label != label[0])])
        raise InputError(
            f"the mesh consists of {parts} parts that share no nodes; one of them is at ({place}). Merge coincident nodes in the program "
            "that made the mesh (gmsh: Coherence), or give every part a body of its own."
        )
