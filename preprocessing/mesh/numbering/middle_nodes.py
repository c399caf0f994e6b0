"""Nodes between the corners of quadratic elements, in the order in which a mesh file is to list them.

Programs list them in different orders, and an element with nodes of another order is folded or, worse, only bent a little. With the
middles c of the straight edges and faces between the corners, and the nodes x that stand for them, every two of these lie alike:

    (x_i - x_j) . (c_i - c_j) > 0

also on curved and thin elements, whose edges bend together. Nodes that have changed places turn the sign, and one of the two is far
nearer to the middle of the other's edge than to that of its own; where it is not, the element is bent so far that it is folded over.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from pathlib import Path

import numpy as np

from preprocessing.mesh.faces import HEXAHEDRON
from preprocessing.mesh.numbering.collapsed import FORMS
from toolkit.foundation.errors import InputError

Places = tuple[tuple[int, ...], ...]

BETWEEN: dict[str, tuple[int, Places]] = {
    "triangle6": (3, FORMS["triangle"].edges),
    "quad8": (4, FORMS["quad"].edges),
    "quad9": (4, (*FORMS["quad"].edges, (0, 1, 2, 3))),
    "tetra10": (4, FORMS["tetra"].edges),
    "wedge15": (6, FORMS["wedge"].edges),
    "hexahedron20": (8, FORMS["hexahedron"].edges),
    "hexahedron27": (8, (*FORMS["hexahedron"].edges, *HEXAHEDRON, tuple(range(8)))),
}
"""Number of corners of a kind, and the corners round every further node in the order of mesh files."""
STRAIGHT = 1e-6
"""Largest distance of a node from the middle of its edge, in parts of the element's extent, that no exchange can have."""
ALIKE = 0.05
"""Part of |c_i - c_j|^2 that the product has at least: nodes in the quarters of their edges leave 0.5, a turn by a right angle 0."""
NEARER = 0.3
"""Distance of a node from the middle of another edge, in parts of that from its own, below which it is taken to belong there."""
AT_ONCE = 50_000
"""Elements at once."""


def refuse_exchanged(path: Path, nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> None:
    """Refuse elements whose nodes between the corners stand in another order.

    Parameters
    ----------
    nodes : (n_nodes, d)
    blocks : kind of element -> (n_e, nodes of one element)

    Raises
    ------
    InputError
        It says how many there are, where the first one is, and which order is right.
    """
    for kind, elements in blocks.items():
        if kind not in BETWEEN:
            continue
        parts = range(0, len(elements), AT_ONCE)
        wrong = np.concatenate([_exchanged(kind, nodes[elements[first : first + AT_ONCE]]) for first in parts])
        if wrong.any():
            place = ", ".join(f"{x:g}" for x in nodes[elements[np.argmax(wrong)]].mean(axis=0))
            order = ", ".join("-".join(str(corner + 1) for corner in edge) for edge in BETWEEN[kind][1] if len(edge) == 2)
            raise InputError(
                f"{wrong.sum()} of the {len(elements)} elements of kind {kind} of the mesh {str(path)!r} have nodes in the middle of other "
                f"edges than of those that they stand for, the first round ({place}). After the corners these nodes belong between the "
                f"corners {order}, in this order, which is that of Abaqus, CalculiX and VTK; gmsh and Nastran have others in their own "
                "formats. Export the mesh by the program's own writer of this format; or, where few of many elements are wrong, mesh that "
                "place finer, as edges bend there by more than the elements are thick."
            )


def _exchanged(kind: str, places: np.ndarray) -> np.ndarray:
    """Which elements have nodes between their corners in another order, by the nodes' places (n_e, n_local, d)."""
    corners, between = BETWEEN[kind]
    middles = np.stack([places[:, list(each)].mean(axis=1) for each in between], axis=1)
    found, further = np.zeros(len(places), bool), places[:, corners:]
    off = np.abs(further - middles).max(axis=(1, 2), initial=0.0)
    bent = np.flatnonzero(off > STRAIGHT * np.ptp(places[:, :corners], axis=1).max(axis=1))
    middles, further = middles[bent], further[bent]
    for i, j in combinations(range(len(between)), 2):
        apart = middles[:, i] - middles[:, j]
        unlike = ((further[:, i] - further[:, j]) * apart).sum(axis=1) < ALIKE * (apart**2).sum(axis=1)
        exchanged = [
            _length(further[:, a] - middles[:, b]) < NEARER * _length(further[:, a] - middles[:, a]) for a, b in ((i, j), (j, i))
        ]
        found[bent] |= unlike & (exchanged[0] | exchanged[1])
    return found


def _length(arms: np.ndarray) -> np.ndarray:
    """Lengths (n,) of vectors (n, d)."""
    return np.sqrt(np.einsum("nd,nd->n", arms, arms))


def refuse_unlike(path: Path, nodes: np.ndarray, blocks: Mapping[str, np.ndarray]) -> None:
    """Refuse edges that have a node in their middle in some of their elements only, or another one, or that of another edge.

    Raises
    ------
    InputError
        It says how many there are, and where the first one is.
    """
    if not any(kind in BETWEEN for kind in blocks):
        return
    edges = [_edges(kind, elements, len(nodes)) for kind, elements in blocks.items()]
    key, middle = (np.concatenate(each) for each in zip(*edges, strict=True))
    wrong = _unlike(key, middle, len(nodes))
    if len(wrong):
        ends = " and ".join("(" + ", ".join(f"{x:g}" for x in nodes[k]) + ")" for k in divmod(int(wrong.min()), len(nodes)))
        raise InputError(
            f"{_count(wrong)} edges of elements of the mesh {str(path)!r} have a node in their middle in some of their elements only, or "
            f"different nodes there; one is between {ends}. Mesh the whole body with elements of one order, and merge coincident nodes."
        )


def _unlike(key: np.ndarray, middle: np.ndarray, n_nodes: int) -> np.ndarray:
    """Numbers of edges as `_edges` gives them whose node in the middle is not the same everywhere, or is that of another edge too."""
    owner = np.full(n_nodes + 1, -1)  # the last one stands for no node
    owner[middle] = key
    wrong = key[(middle >= 0) & (owner[middle] != key)]
    if len(wrong) or _count(key) == _count(key[middle < 0]) + _count(middle[middle >= 0]):
        return wrong
    order = np.lexsort((middle, key))
    return key[order][1:][(np.diff(key[order]) == 0) & (np.diff(middle[order]) != 0)]


def _edges(kind: str, elements: np.ndarray, n_nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Number of every edge of every element, made of its corners, and the node in its middle or -1."""
    edges = np.array(FORMS[kind.rstrip("0123456789")].edges)
    ends = elements[:, edges]
    key = (ends.min(axis=2) * n_nodes + ends.max(axis=2)).ravel()
    if kind not in BETWEEN:
        return key, np.full(len(key), -1)
    first = BETWEEN[kind][0]
    return key, elements[:, first : first + len(edges)].ravel()


def _count(numbers: np.ndarray) -> int:
    """Number of different values."""
    if not len(numbers):
        return 0
    rising = np.sort(numbers)
    return 1 + int(np.count_nonzero(rising[1:] != rising[:-1]))
