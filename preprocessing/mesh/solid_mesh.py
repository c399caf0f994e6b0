"""A mesh of solid elements as plain arrays: nodes, elements by kind, and groups of nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from preprocessing.foreign_files.contents import LeftOutContent, PointMass
from toolkit.foundation.errors import InputError

NODES_AT_ONCE = 1_000_000
"""Nodes of elements that are put together at once: a graph of all would take more memory than the mesh."""


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """Nodes and elements in space of dimension d; nodal coordinates are u_1 ... u_d of node 0, then of node 1, and so on.

    Finished matrices may come without elements; then there are no blocks.
    """

    nodes: np.ndarray  # (n_nodes, d)
    blocks: Mapping[str, np.ndarray] = field(default_factory=dict)  # kind in the words of meshio -> (n_e, nodes of one element)
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)  # name -> numbers of nodes
    in_file: np.ndarray | None = None  # (n_nodes,) number of each node in its file, rising, if some of the file were left out
    faces: Mapping[str, frozenset] = field(default_factory=dict)  # name of a group -> corners of its faces, if it has any
    n_file: int = 0  # nodes in the file
    volumes: Mapping[str, Mapping[str, np.ndarray]] = field(
        default_factory=dict
    )  # name of a group -> its elements by kind, as `blocks`, if it has any
    labels: np.ndarray | None = None  # (n_nodes,) number that the file gives each node, if it numbers them
    masses: Sequence[PointMass] = ()  # in the numbers of the nodes here; lengths in those of `nodes`
    left_out: Sequence[LeftOutContent] = ()  # what stands in the file and is not part of the body
    remarks: Sequence[str] = ()  # what the user should know of the reading

    @property
    def motions(self) -> int:
        """Number of rigid motions, and of motions of a point with rotations."""
        return self.dimension * (self.dimension + 1) // 2

    @property
    def dimension(self) -> int:
        """Dimension d of space."""
        return self.nodes.shape[1]

    @property
    def n(self) -> int:
        """Number of nodal coordinates."""
        return self.nodes.size

    @property
    def size(self) -> float:
        """Largest extent of the body along an axis."""
        return float(np.ptp(self.nodes.real, axis=0).max())

    def moved(self, motion: np.ndarray) -> SolidMesh:
        """Mesh whose nodes are moved by (n_nodes, d), real or complex.

        Concentrated masses keep their offset from the mean of their nodes.
        """
        masses = [each._replace(place=tuple(each.place + motion[each.carriers].mean(axis=0))) for each in self.masses]
        return replace(self, nodes=self.nodes + motion, masses=masses)

    def around(self, node: int) -> np.ndarray:
        """Numbers of the other nodes of all elements that have a node."""
        with_it = [block[(block == node).any(axis=1)].ravel() for block in self.blocks.values()]
        found = np.unique(np.concatenate([np.zeros(0, int), *with_it]))
        return found[found != node]


def rigid_motions(nodes: np.ndarray) -> np.ndarray:
    """Nodal coordinates of unit translations, and of unit rotations about the origin, (n, d (d + 1) / 2); nodes real or complex."""
    return np.hstack([translations(*nodes.shape), *(turned.reshape(-1, 1) for turned in rotations(nodes))])


def translations(n_nodes: int, dimension: int) -> np.ndarray:
    """Nodal coordinates of the unit translations, (n, d)."""
    return np.tile(np.eye(dimension), (n_nodes, 1))


PLANES = {2: ((0, 1),), 3: ((1, 2), (2, 0), (0, 1))}
"""Axes from which and to which every unit rotation turns; in space the rotations are those about x, y and z."""


def rotations(arms: np.ndarray) -> np.ndarray:
    """Displacements under unit rotations at places `arms` (..., d) from the axes, (n_rotations, ..., d): -y, x in the plane."""
    planes = PLANES[arms.shape[-1]]
    found = np.zeros((len(planes), *arms.shape), arms.dtype)
    for turned, (a, b) in zip(found, planes, strict=True):
        turned[..., a], turned[..., b] = -arms[..., b], arms[..., a]
    return found


def refuse_parts(mesh: SolidMesh) -> None:
    """Refuse a mesh of several parts that do not hang together.

    Raises
    ------
    InputError
        It says how many parts there are, and where the second one is.
    """
    label = lumps(len(mesh.nodes), [*mesh.blocks.values()])
    if label.max() > 0:
        place = ", ".join(f"{x:g}" for x in mesh.nodes[np.argmax(label != label[0])])
        raise InputError(
            f"the mesh consists of {label.max() + 1} parts that share no nodes; one of them is at ({place}). Merge coincident nodes in the "
            "program that made the mesh (gmsh: Coherence), or give every part a body of its own."
        )


def lumps(n_nodes: int, members: Sequence[np.ndarray]) -> np.ndarray:
    """Number of the lump that each node is in, (n_nodes,); elements or faces (n, n_local) hang together that share nodes."""
    label = np.arange(n_nodes, dtype=np.int32)
    for each in members:
        for some in np.array_split(each, 1 + each.size // NODES_AT_ONCE):
            label = _merged(label, label[some])[label]
    return label


def _merged(label: np.ndarray, lumps_of_elements: np.ndarray) -> np.ndarray:
    """The new number of every lump where elements hang together those at their nodes, (n_e, n_local)."""
    n, (n_elements, n_local) = int(label.max(initial=-1)) + 1, lumps_of_elements.shape
    ends = np.concatenate([np.zeros(n + 1, np.int32), n_local * np.arange(1, n_elements + 1, dtype=np.int32)])
    graph = sparse.csr_array((np.ones(lumps_of_elements.size), lumps_of_elements.ravel(), ends), shape=(n + n_elements,) * 2)
    found: np.ndarray = connected_components(graph, directed=False)[1][:n]
    return found
