"""Nodes of elements as a mesh file lists them: collapsed and repeated elements, and nodes between corners.

Collapsed elements: hexahedra and wedges with repeated nodes become the wedges and tetrahedra that they are, quadrilaterals triangles.

A face may be collapsed to an edge or a point, in any orientation. What is left of the faces tells what the element is: two triangles and
three quadrilaterals bound a wedge, four triangles a tetrahedron. The node in the middle of a collapsed edge must be the one that the edge
is collapsed to, and edges that fall together must have one node in their middle.

Programs list them in different orders, and an element with nodes of another order is folded or, worse, only bent a little. With the
middles c of the straight edges and faces between the corners, and the nodes x that stand for them, every two of these lie alike:

    (x_i - x_j) . (c_i - c_j) > 0

also on curved and thin elements, whose edges bend together. Nodes that have changed places turn the sign, and one of the two is far
nearer to the middle of the other's edge than to that of its own; where it is not, the element is bent so far that it is folded over.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import KNOWN, PLANE, SOLID, Elements, MeshContents
from preprocessing.mesh.faces import HEXAHEDRON, HEXAHEDRON_EDGES, TETRA, TETRA_EDGES, WEDGE, WEDGE_EDGES
from toolkit.foundation.errors import InputError


class CollapsedForm(NamedTuple):
    """Faces of an element and its edges by their corners, the edges in the order of the nodes in their middles."""

    faces: tuple[tuple[int, ...], ...]  # anticlockwise seen from outside; in the plane the element itself
    edges: tuple[tuple[int, ...], ...]


FORMS = {
    "triangle": CollapsedForm(((0, 1, 2),), ((0, 1), (1, 2), (2, 0))),
    "quad": CollapsedForm(((0, 1, 2, 3),), ((0, 1), (1, 2), (2, 3), (3, 0))),
    "tetra": CollapsedForm(TETRA, TETRA_EDGES),
    "wedge": CollapsedForm(WEDGE, WEDGE_EDGES),
    "hexahedron": CollapsedForm(HEXAHEDRON, HEXAHEDRON_EDGES),
}
"""Forms of elements by their kind without the number of its nodes."""
MADE = {(3,): "triangle", (3, 3, 3, 3): "tetra", (3, 3, 4, 4, 4): "wedge", (3, 3, 3, 3, 4): "pyramid"}
"""Kind of an element by the numbers of corners of its faces."""
QUADRATIC = {"triangle": "triangle6", "tetra": "tetra10", "wedge": "wedge15", "pyramid": "pyramid"}
"""The same with nodes in the middle of its edges."""
REPEATS_AT_ONCE = 20_000
"""Elements at once that are looked through for repeated nodes."""

Meaning = tuple[str, list[int]]
"""The kind that a collapsed element is, and where its nodes are among those of the element; "" is the kind of one that is none."""


def uncollapsed(path: Path, raw: MeshContents) -> MeshContents:
    """Contents of a mesh file, its groups too, with every collapsed element as what it is.

    Raises
    ------
    InputError
        An element repeats nodes in another way; says where it is and what would be right.
    """
    kept = PLANE if any(kind.startswith(SOLID) for kind, _ in raw.cells) else {}  # in space these serve to name faces only
    cells, remarks = [], list(raw.remarks)
    for kind, elements in raw.cells:
        for other, found in _split(kind, elements):
            if other != kind and kind not in kept:
                if other in ("", "pyramid"):
                    _refuse(path, raw.points, kind, found, other)
                remarks.append(_told(kind, other, len(found)))
            cells.append((other or kind, found))
    groups = [(name, [(o or kind, found) for kind, each in all_ for o, found in _split(kind, each)]) for name, all_ in raw.groups]
    return raw._replace(cells=cells, groups=groups, remarks=remarks)


def _told(kind: str, made: str, number: int) -> str:
    """Remarks on collapsed elements that the user should know."""
    stiffer = (
        " Programs that integrate them as they stand, as CalculiX does, make them stiffer." if made in QUADRATIC.values() else ""
    )
    return f"{number} elements of kind {kind} repeat nodes, and are taken as what they are: {made}.{stiffer}"


def _split(kind: str, elements: np.ndarray) -> Elements:
    """Elements of one kind by the kinds that they really are, each in the order of the file."""
    repeated = _repeat(elements) if kind.rstrip("0123456789") in FORMS and kind in KNOWN else np.zeros(len(elements), bool)
    if not repeated.any():
        return [(kind, elements)]
    wrong = elements[repeated]
    patterns, number = np.unique(_first_places(wrong), axis=0, return_inverse=True)
    meanings = [_meaning(kind, pattern) for pattern in patterns.tolist()]
    found = [] if repeated.all() else [(kind, elements[~repeated])]
    for other in dict.fromkeys(meaning for meaning, _ in meanings):
        own = [k for k, (each, _) in enumerate(meanings) if each == other]
        places = np.array([meanings[k][1] for k in own])
        which = np.searchsorted(own, number.ravel())
        here = np.isin(number.ravel(), own)
        found.append((other, np.take_along_axis(wrong[here], places[which[here]], axis=1)))
    return found


def _repeat(elements: np.ndarray) -> np.ndarray:
    """Which elements (n_e, n_local) have a node twice, (n_e,)."""
    found = np.zeros(len(elements), bool)
    for first in range(0, len(elements), REPEATS_AT_ONCE):
        members = np.ascontiguousarray(elements[first : first + REPEATS_AT_ONCE].T)
        for one, other in combinations(members, 2):
            found[first : first + REPEATS_AT_ONCE] |= one == other
    return found


def _first_places(elements: np.ndarray) -> np.ndarray:
    """Place at which each element first has every one of its nodes, for elements (n_e, n_local)."""
    return np.column_stack([(elements == column[:, None]).argmax(axis=1) for column in elements.T]).astype(np.uint8)


def _meaning(kind: str, pattern: list[int]) -> Meaning:
    """Kind that an element with repeated nodes really is, and its nodes; the pattern gives each node's first place."""
    none, form = ("", [*range(len(pattern))]), FORMS[kind.rstrip("0123456789")]
    n = 1 + max(corner for face in form.faces for corner in face)
    faces = [ring for face in form.faces if len(ring := _ring([pattern[corner] for corner in face])) > 2]
    made = MADE.get(tuple(sorted(map(len, faces))), "")
    if not made or not _closed(faces) or (made == "triangle") != (len(form.faces) == 1):
        return none
    if made == "pyramid":
        return made, none[1]
    corners = _corners(made, faces)
    if len(pattern) == n:
        return made, corners
    middles = _middles(form, n, pattern) if len(pattern) == n + len(form.edges) else {}
    if not middles:
        return none
    return QUADRATIC[made], [*corners, *(middles[frozenset(corners[k] for k in edge)] for edge in FORMS[made].edges)]


def _ring(corners: list[int]) -> list[int]:
    """Corners of a face without those that repeat the one before."""
    return [corner for k, corner in enumerate(corners) if corner != corners[k - 1]]


def _closed(faces: Sequence[list[int]]) -> bool:
    """Whether no face has a corner twice, and every edge is one of two faces in opposite directions; in the plane there is one face."""
    edges = Counter((a, b) for face in faces for a, b in zip(face, face[1:] + face[:1], strict=True))
    simple = all(len(set(face)) == len(face) for face in faces)
    return simple and max(edges.values()) == 1 and (len(faces) == 1 or all((b, a) in edges for a, b in edges))


def _corners(made: str, faces: Sequence[list[int]]) -> list[int]:
    """The corners of an element in the order of its kind."""
    first = min(faces, key=len)
    if made == "triangle":
        return first
    below = [first[0], *first[:0:-1]]  # the first face of a tetrahedron and of a wedge is seen from outside, from below
    edges = {(a, b) for face in faces for a, b in zip(face, face[1:] + face[:1], strict=True)}
    above = [next(b for a, b in sorted(edges) if a == corner and b not in below) for corner in below]
    return [*below, *(above if made == "wedge" else above[:1])]


def _middles(form: CollapsedForm, n: int, pattern: list[int]) -> dict[frozenset[int], int]:
    """Node in the middle of every edge that is left, by both corners; empty where nodes are not as they should be."""
    found: dict[frozenset[int], int] = {}
    for (a, b), middle in zip(form.edges, pattern[n:], strict=True):
        ends = frozenset((pattern[a], pattern[b]))
        if (len(ends) == 1) != (middle < n) or (middle < n and middle not in ends) or found.setdefault(ends, middle) != middle:
            return {}
    left = [middle for middle in found.values() if middle >= n]
    return found if len(set(left)) == len(left) else {}


def _refuse(path: Path, points: np.ndarray, kind: str, elements: np.ndarray, made: str) -> None:
    """Refuse elements that repeat nodes and are pyramids or nothing that is known."""
    place = ", ".join(f"{x:g}" for x in points[np.unique(elements[0])].mean(axis=0))
    what = "as pyramids do, which are no elements here" if made else "in a way that leaves no element"
    raise InputError(
        f"the mesh {str(path)!r} has {len(elements)} elements of kind {kind} that repeat nodes {what}, the first round ({place}). A "
        "hexahedron or wedge may have a face collapsed so that a wedge or a tetrahedron is left, a quadrilateral a side so that a triangle "
        "is; the node in the middle of a collapsed edge is then that of its end, and edges that fall together have the same one. Mesh that "
        "place again with wedges or tetrahedra."
    )


GAMMA, FIRST, SECOND = (np.uint64(each) for each in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB))
"""Constants of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014)."""
DENSE_NUMBERS = 16
"""Part of all numbers, one in so many, from which on a table of all of them is faster than sorting."""


def distinct(arrays: Sequence[np.ndarray], n: int) -> np.ndarray:
    """Numbers from 0 to n - 1 that occur in arrays, in rising order."""
    if DENSE_NUMBERS * sum(each.size for each in arrays) < n:
        return np.unique(np.concatenate([np.zeros(0, np.int64), *(each.ravel() for each in arrays)]))
    there = np.zeros(n, bool)
    for each in arrays:
        there[each] = True
    return np.flatnonzero(there)


def joined(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """Rows of all arrays, without a copy if there is a single one."""
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


class Renumbering(NamedTuple):
    """New numbers of nodes of which some were left out."""

    table: np.ndarray  # (n,) new number, or -1
    whole: bool  # whether none was left out

    def of(self, nodes: np.ndarray) -> np.ndarray:
        """New numbers of given nodes; where none was left out the array itself."""
        return nodes if self.whole else self.table[nodes]

    @classmethod
    def keeping(cls, used: np.ndarray, n: int) -> Renumbering:
        """Renumbering that keeps those of n nodes that are used, in their order."""
        table = np.full(n, -1)
        table[used] = np.arange(len(used))
        return cls(table, len(used) == n)


def first_of_copies(elements: np.ndarray) -> np.ndarray:
    """Which elements (n_e, n_local) have other nodes than all before them, in any order, (n_e,).

    Equal elements have equal sums of the scrambled numbers of their nodes. Of the few others that have these too, nodes are compared.
    """
    keys = _scrambled_sums(elements)
    rising = np.sort(keys)
    if not (rising[1:] == rising[:-1]).any():
        return np.ones(len(elements), bool)
    order = np.argsort(keys, kind="stable")
    begins = np.concatenate([[True], rising[1:] != rising[:-1]])
    start = np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))  # of the elements with one sum
    later = np.flatnonzero(~begins)
    alike = _in_order(elements, order[later]) == _in_order(elements, order[start[later]])
    found = np.ones(len(elements), bool)
    if not alike.all():
        return _compared(elements)
    found[order[later]] = False
    return found


def _scrambled_sums(elements: np.ndarray) -> np.ndarray:
    """Hash of 64 bits of the nodes of each element, whatever their order."""
    total = np.zeros(len(elements), np.uint64)
    for column in elements.T:
        total += _scrambled(column.astype(np.uint64))
    return total


def _scrambled(numbers: np.ndarray) -> np.ndarray:
    """Hash of every number by SplitMix64."""
    z = (numbers + np.uint64(1)) * GAMMA
    z = (z ^ (z >> np.uint64(30))) * FIRST
    z = (z ^ (z >> np.uint64(27))) * SECOND
    return z ^ (z >> np.uint64(31))


def _in_order(elements: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Nodes of some elements in rising order."""
    return np.sort(elements[which], axis=1)


def _compared(elements: np.ndarray) -> np.ndarray:
    """First elements among copies, as `first_of_copies`, where different elements have one sum."""
    found = np.zeros(len(elements), bool)
    found[np.unique(np.sort(elements, axis=1), axis=0, return_index=True)[1]] = True
    return found


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
STRAIGHT_EDGE = 1e-6
"""Largest distance of a node from the middle of its edge, in parts of the element's extent, that no exchange can have."""
LEAST_PRODUCT = 0.05
"""Part of |c_i - c_j|^2 that the product has at least: nodes in the quarters of their edges leave 0.5, a turn by a right angle 0."""
NEARER_EDGE = 0.3
"""Distance of a node from the middle of another edge, in parts of that from its own, below which it is taken to belong there."""
ELEMENTS_AT_ONCE = 50_000
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
        parts = range(0, len(elements), ELEMENTS_AT_ONCE)
        wrong = np.concatenate([_exchanged(kind, nodes[elements[first : first + ELEMENTS_AT_ONCE]]) for first in parts])
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
    bent = np.flatnonzero(off > STRAIGHT_EDGE * np.ptp(places[:, :corners], axis=1).max(axis=1))
    middles, further = middles[bent], further[bent]
    for i, j in combinations(range(len(between)), 2):
        apart = middles[:, i] - middles[:, j]
        unlike = ((further[:, i] - further[:, j]) * apart).sum(axis=1) < LEAST_PRODUCT * (apart**2).sum(axis=1)
        exchanged = [
            _length(further[:, a] - middles[:, b]) < NEARER_EDGE * _length(further[:, a] - middles[:, a])
            for a, b in ((i, j), (j, i))
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
