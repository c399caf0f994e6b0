"""Collapsed elements: hexahedra and wedges with repeated nodes become the wedges and tetrahedra that they are, quadrilaterals triangles.

A face may be collapsed to an edge or a point, in any orientation. What is left of the faces tells what the element is: two triangles and
three quadrilaterals bound a wedge, four triangles a tetrahedron. The node in the middle of a collapsed edge must be the one that the edge
is collapsed to, and edges that fall together must have one node in their middle.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import Elements, MeshContents
from preprocessing.foreign_files.element_kinds import KNOWN, PLANE, SOLID
from preprocessing.mesh.faces import HEXAHEDRON, HEXAHEDRON_EDGES, TETRA, TETRA_EDGES, WEDGE, WEDGE_EDGES
from toolkit.foundation.errors import InputError


class Form(NamedTuple):
    """Faces of an element and its edges by their corners, the edges in the order of the nodes in their middles."""

    faces: tuple[tuple[int, ...], ...]  # anticlockwise seen from outside; in the plane the element itself
    edges: tuple[tuple[int, ...], ...]


FORMS = {
    "triangle": Form(((0, 1, 2),), ((0, 1), (1, 2), (2, 0))),
    "quad": Form(((0, 1, 2, 3),), ((0, 1), (1, 2), (2, 3), (3, 0))),
    "tetra": Form(TETRA, TETRA_EDGES),
    "wedge": Form(WEDGE, WEDGE_EDGES),
    "hexahedron": Form(HEXAHEDRON, HEXAHEDRON_EDGES),
}
"""Forms of elements by their kind without the number of its nodes."""
MADE = {(3,): "triangle", (3, 3, 3, 3): "tetra", (3, 3, 4, 4, 4): "wedge", (3, 3, 3, 3, 4): "pyramid"}
"""Kind of an element by the numbers of corners of its faces."""
QUADRATIC = {"triangle": "triangle6", "tetra": "tetra10", "wedge": "wedge15", "pyramid": "pyramid"}
"""The same with nodes in the middle of its edges."""
AT_ONCE = 20_000
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
    for first in range(0, len(elements), AT_ONCE):
        members = np.ascontiguousarray(elements[first : first + AT_ONCE].T)
        for one, other in combinations(members, 2):
            found[first : first + AT_ONCE] |= one == other
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


def _middles(form: Form, n: int, pattern: list[int]) -> dict[frozenset[int], int]:
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
