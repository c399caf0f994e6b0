"""Groups: the elements of every property, and the nodes and elements of the cards SET1 and SET3."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np

from preprocessing.foreign_files.contents import Elements, LeftOut
from preprocessing.foreign_files.nastran.cards import Card, Cards
from preprocessing.foreign_files.nastran.elements import Block
from preprocessing.foreign_files.nastran.grid import Grid

NUMBER = re.compile(r"\d{1,18}")
MOST = 1000
"""Properties from which on they are no groups: every element has its own."""
UNREAD = "its words are no list of numbers, so that it is no group"
Group = tuple[str, Elements]


def property_groups(body: Sequence[Block], naming: Sequence[Block]) -> list[Group]:
    """Elements by property, as `pid 3`; faces and edges are `pid 3 CQUAD4` where elements of the body have the same property."""
    found: dict[str, Elements] = {}
    own = properties_of(body)
    if len(own) > MOST:
        return []
    for block in [*body, *naming]:
        numbers, which = np.unique(block.properties, return_inverse=True)
        for k, number in enumerate(numbers.tolist()[:MOST]):
            card = f" {block.card}" if any(block is each for each in naming) and number in own else ""
            found.setdefault(f"pid {number}{card}", []).append((block.kind, block.nodes[which == k]))
    return list(found.items())


def properties_of(blocks: Sequence[Block]) -> set[int]:
    """Numbers of the properties of elements."""
    return {int(number) for block in blocks for number in np.unique(block.properties)}


def set_groups(cards: Cards, grid: Grid, blocks: Sequence[Block]) -> tuple[list[Group], list[LeftOut]]:
    """Groups under names such as `SET1 5`, and remarks on sets that are none."""
    groups: dict[str, Elements] = {}
    left: dict[tuple[str, str], int] = {}
    for name in ("SET1", "SET3"):
        for card in cards.by_name.get(name, []):
            why = _one(name, card, grid, blocks, groups)
            if why:
                left[name, why] = left.get((name, why), 0) + 1
    return list(groups.items()), [LeftOut(name, number, why) for (name, why), number in left.items()]


def _one(name: str, card: Card, grid: Grid, blocks: Sequence[Block], groups: dict[str, Elements]) -> str:
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


def _elements(block: Block, spans: Sequence[tuple[int, int]]) -> Elements:
    wide = [(a, b) for a, b in spans if a != b]
    single = np.isin(block.labels, [a for a, b in spans if a == b])
    which = single | np.any([(block.labels >= a) & (block.labels <= b) for a, b in wide], axis=0) if wide else single
    return [(block.kind, block.nodes[which])] if which.any() else []
