"""Elements: solids, shells and rods as blocks of one card and kind, in the order of nodes that meshio has."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.nastran.cards import Cards, Table
from preprocessing.foreign_files.nastran.grid import Grid, refuse_missing
from preprocessing.foreign_files.nastran.vocabulary import SOLIDS

ORDER = {
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
}
"""Kind -> nodes of a card in the order of meshio: Nastran has the middles of the upright edges ahead of those at the top."""
FACES = {
    "tetra": ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)),
    "hexahedron": ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
}
"""Kind, less the number of nodes at its end -> corners of its faces."""
CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "line": 2}


class Block(NamedTuple):
    """Elements of one card and one kind."""

    card: str
    kind: str
    nodes: np.ndarray  # (n, n_local) places among the points
    labels: np.ndarray  # (n,) numbers of the elements
    properties: np.ndarray  # (n,) numbers of their properties
    rows: np.ndarray  # (n,) of the table
    table: Table

    def part(self, which: np.ndarray) -> Block:
        """Block with some of the elements."""
        return self._replace(**{name: getattr(self, name)[which] for name in ("nodes", "labels", "properties", "rows")})

    def place(self, k: int = 0) -> str:
        """Position of one of the elements in the file, in words."""
        return self.table.place(int(self.rows[k]))


def blocks_of(cards: Cards, grid: Grid, kinds: Mapping[str, Mapping[int, str]], leave_out: Collection[str]) -> list[Block]:
    """All elements of these cards but those that are to be left out.

    Raises
    ------
    InputError
        A node is missing, or some but not all of the middles of edges are given.
    """
    names = [name for name in kinds if name in cards.by_name and name not in leave_out]
    return [block for name in names for block in _blocks(name, cards, grid, kinds[name])]


def _blocks(name: str, cards: Cards, grid: Grid, kinds: Mapping[int, str]) -> Iterator[Block]:
    most = max(kinds)
    table = Table(name, cards.by_name[name], 2 + most, cards.lines, rest=name not in SOLIDS)
    labels, nodes = table.whole(0), table.whole(2, 2 + most, blank=0)
    properties = np.where(table.blank(1), labels, table.whole(1, blank=0))
    given = nodes != 0
    places = np.where(given, grid.places(nodes), 0)
    refuse_missing(table, nodes, places)
    taken = np.zeros(len(labels), bool)
    for n, kind in kinds.items():
        rows = np.flatnonzero(given[:, :n].all(axis=1) & ~given[:, n:].any(axis=1))
        taken[rows] = True
        if len(rows):
            here = places[rows, :n]
            yield Block(name, kind, here[:, ORDER[kind]] if kind in ORDER else here, labels[rows], properties[rows], rows, table)
    if not taken.all():
        counts = " or ".join(map(str, kinds))
        raise table.error(
            int(np.argmin(taken)),
            f"{name} is read with {counts} nodes, and this one has others: a corner is missing, or some of the middles of edges. "
            "Give it all middles, or none.",
        )


def refuse_twice(blocks: Sequence[Block]) -> None:
    """Refuse two elements of one number."""
    labels = np.concatenate([np.zeros(0, np.int64), *(block.labels for block in blocks)])
    _, first = np.unique(labels, return_index=True)
    if len(first) == len(labels):
        return
    second = int(np.setdiff1d(np.arange(len(labels)), first)[0])
    at = [(block, k) for block in blocks for k in range(len(block.labels)) if block.labels[k] == labels[second]]
    (block, k), (other, j) = at[:2]
    raise other.table.error(
        int(other.rows[j]),
        f"element {labels[second]} is there twice, first in {block.place(k)}. Take one out, or give it another number.",
    )


def only_name(block: Block, body: Sequence[Block], grid: Grid, properties: Collection[int]) -> np.ndarray:
    """Whether each of the elements names a place of the body only: it has no property in the file, and is a face or edge there, (n,)."""
    free = ~np.isin(block.properties, list(properties))
    if block.kind == "line":
        used = np.zeros(len(grid.labels), bool)
        for each in body:
            used[each.nodes] = True
        return free & used[block.nodes].all(axis=1)
    corners = block.nodes[:, : CORNERS[block.kind]]
    faces = _faces(body, corners, len(grid.labels))
    return free & np.array([frozenset(row) in faces for row in corners.tolist()], bool)


def _faces(body: Sequence[Block], corners: np.ndarray, n_nodes: int) -> set[frozenset[int]]:
    """Faces of the body that have no other corners than some nodes."""
    near = np.zeros(n_nodes, bool)
    near[corners] = True
    found: set[frozenset[int]] = set()
    for block in body:
        for face in FACES.get(block.kind.rstrip("0123456789"), ()):
            nodes = block.nodes[:, list(face)]
            found.update(map(frozenset, nodes[near[nodes].all(axis=1)].tolist()))
    return found
