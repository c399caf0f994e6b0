"""Elements as blocks of one card and kind, and the groups of elements and nodes."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import Elements, LeftOutContent
from preprocessing.foreign_files.nastran.cards import Card, Cards, CardTable
from preprocessing.foreign_files.nastran.grid import Grid, refuse_missing
from preprocessing.foreign_files.nastran.lines import SOLIDS

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


class CardBlock(NamedTuple):
    """Elements of one card and one kind."""

    card: str
    kind: str
    nodes: np.ndarray  # (n, n_local) places among the points
    labels: np.ndarray  # (n,) numbers of the elements
    properties: np.ndarray  # (n,) numbers of their properties
    rows: np.ndarray  # (n,) of the table
    table: CardTable

    def part(self, which: np.ndarray) -> CardBlock:
        """Block with some of the elements."""
        return self._replace(**{name: getattr(self, name)[which] for name in ("nodes", "labels", "properties", "rows")})

    def place(self, k: int = 0) -> str:
        """Position of one of the elements in the file, in words."""
        return self.table.place(int(self.rows[k]))


def blocks_of(cards: Cards, grid: Grid, kinds: Mapping[str, Mapping[int, str]], leave_out: Collection[str]) -> list[CardBlock]:
    """All elements of these cards but those that are to be left out.

    Raises
    ------
    InputError
        A node is missing, or some but not all of the middles of edges are given.
    """
    names = [name for name in kinds if name in cards.by_name and name not in leave_out]
    return [block for name in names for block in _blocks(name, cards, grid, kinds[name])]


def _blocks(name: str, cards: Cards, grid: Grid, kinds: Mapping[int, str]) -> Iterator[CardBlock]:
    most = max(kinds)
    table = CardTable(name, cards.by_name[name], 2 + most, cards.lines, rest=name not in SOLIDS)
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
            yield CardBlock(
                name, kind, here[:, ORDER[kind]] if kind in ORDER else here, labels[rows], properties[rows], rows, table
            )
    if not taken.all():
        counts = " or ".join(map(str, kinds))
        raise table.error(
            int(np.argmin(taken)),
            f"{name} is read with {counts} nodes, and this one has others: a corner is missing, or some of the middles of edges. "
            "Give it all middles, or none.",
        )


def refuse_twice(blocks: Sequence[CardBlock]) -> None:
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


def only_name(block: CardBlock, body: Sequence[CardBlock], grid: Grid, properties: Collection[int]) -> np.ndarray:
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


def _faces(body: Sequence[CardBlock], corners: np.ndarray, n_nodes: int) -> set[frozenset[int]]:
    """Faces of the body that have no other corners than some nodes."""
    near = np.zeros(n_nodes, bool)
    near[corners] = True
    found: set[frozenset[int]] = set()
    for block in body:
        for face in FACES.get(block.kind.rstrip("0123456789"), ()):
            nodes = block.nodes[:, list(face)]
            found.update(map(frozenset, nodes[near[nodes].all(axis=1)].tolist()))
    return found


NUMBER = re.compile(r"\d{1,18}")
MOST_PROPERTIES = 1000
"""Properties from which on they are no groups: every element has its own."""
UNREAD = "its words are no list of numbers, so that it is no group"
Group = tuple[str, Elements]


def property_groups(body: Sequence[CardBlock], naming: Sequence[CardBlock]) -> list[Group]:
    """Elements by property, as `pid 3`; faces and edges are `pid 3 CQUAD4` where elements of the body have the same property."""
    found: dict[str, Elements] = {}
    own = properties_of(body)
    if len(own) > MOST_PROPERTIES:
        return []
    for block in [*body, *naming]:
        numbers, which = np.unique(block.properties, return_inverse=True)
        for k, number in enumerate(numbers.tolist()[:MOST_PROPERTIES]):
            card = f" {block.card}" if any(block is each for each in naming) and number in own else ""
            found.setdefault(f"pid {number}{card}", []).append((block.kind, block.nodes[which == k]))
    return list(found.items())


def properties_of(blocks: Sequence[CardBlock]) -> set[int]:
    """Numbers of the properties of elements."""
    return {int(number) for block in blocks for number in np.unique(block.properties)}


def set_groups(cards: Cards, grid: Grid, blocks: Sequence[CardBlock]) -> tuple[list[Group], list[LeftOutContent]]:
    """Groups under names such as `SET1 5`, and remarks on sets that are none."""
    groups: dict[str, Elements] = {}
    left: dict[tuple[str, str], int] = {}
    for name in ("SET1", "SET3"):
        for card in cards.by_name.get(name, []):
            why = _one(name, card, grid, blocks, groups)
            if why:
                left[name, why] = left.get((name, why), 0) + 1
    return list(groups.items()), [LeftOutContent(name, number, why) for (name, why), number in left.items()]


def _one(name: str, card: Card, grid: Grid, blocks: Sequence[CardBlock], groups: dict[str, Elements]) -> str:
    """Add the group that one card names, or the reason why it is none."""
    words = [each for each in card.words() if each]
    of = words.pop(1) if name == "SET3" and len(words) > 1 else "GRID"
    if of not in ("GRID", "ELEM"):
        return "it names neither nodes (GRID) nor elements (ELEM)"
    spans = None if card.excess or not words or not NUMBER.fullmatch(words[0]) else list(_spans(words[1:]))
    if not spans or None in spans:
        return UNREAD
    elements = _nodes(grid, spans) if of == "GRID" else [each for block in blocks for each in _elements(block, spans)]  # type: ignore[arg-type]
    if not elements:
        return "it names what is no node or element of the body"
    groups.setdefault(f"{name} {int(words[0])}", []).extend(elements)
    return ""


def _spans(words: Sequence[str]) -> Iterator[tuple[int, int] | None]:
    """First and last number of every span, `a THRU b`, or of a single number; None for what is none."""
    k = 0
    while k < len(words):
        span = words[k : k + 3 : 2] if words[k + 1 : k + 2] == ["THRU"] else words[k : k + 1]
        k += 3 if words[k + 1 : k + 2] == ["THRU"] else 1
        if not all(NUMBER.fullmatch(each) for each in span) or (k > 2 and len(span) == 0):
            yield None
            return
        yield int(span[0]), int(span[-1])


def _within(labels: np.ndarray, order: np.ndarray, spans: Sequence[tuple[int, int]]) -> np.ndarray:
    """Places of the labels that lie in one of the spans; none if a single number is no label."""
    rising = labels[order]
    first, after = np.searchsorted(rising, [a for a, _ in spans]), np.searchsorted(rising, [b for _, b in spans], side="right")
    if any(a == b and start == end for (a, b), start, end in zip(spans, first, after, strict=True)):
        return np.zeros(0, np.int64)
    picked = np.zeros(len(labels) + 1, np.int64)
    np.add.at(picked, first, 1)
    np.add.at(picked, np.maximum(after, first), -1)
    return np.sort(order[np.cumsum(picked)[:-1] > 0])


def _nodes(grid: Grid, spans: Sequence[tuple[int, int]]) -> Elements:
    nodes = _within(grid.labels, grid.order, spans)
    return [("vertex", nodes[:, None])] if len(nodes) else []


def _elements(block: CardBlock, spans: Sequence[tuple[int, int]]) -> Elements:
    wide = [(a, b) for a, b in spans if a != b]
    single = np.isin(block.labels, [a for a, b in spans if a == b])
    which = single | np.any([(block.labels >= a) & (block.labels <= b) for a, b in wide], axis=0) if wide else single
    return [(block.kind, block.nodes[which])] if which.any() else []
