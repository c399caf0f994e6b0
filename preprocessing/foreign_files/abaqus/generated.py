"""Nodes and elements that a deck generates from others: *NGEN, *NFILL, *NCOPY, *ELGEN, *ELCOPY.

What each line means is that of the keywords manual of Abaqus; forms that curve, grade, mirror or map the nodes are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import LARGEST_LABEL, KeywordBlock, label_of, whole
from preprocessing.foreign_files.abaqus.parts import (
    DeckPart,
    Lookup,
    Members,
    Named,
    NodesOf,
    PartElements,
    Range,
    last_of,
    placement,
)
from toolkit.foundation.errors import InputError

MOST_GENERATED = 20_000_000
"""Nodes or elements that one block may generate."""


def generate(part: DeckPart, block: KeywordBlock) -> None:
    """Add the nodes, elements or sets that a block generates to a part.

    Raises
    ------
    InputError
        A form of the keyword is not read, or a line names nodes, elements or sets that there are not.
    """
    for name in REFUSED.get(block.keyword, ()):
        if name in block.parameters:
            raise block.refuse(f"*{block.keyword} with {name} is not read. Export the deck with the nodes written out.")
    HOW[block.keyword](part, block)


def _ngen(part: DeckPart, block: KeywordBlock) -> None:
    """Generate nodes on straight lines between two existing ones: first, last, step of the numbers."""
    made = []
    for place, fields in block.rows():
        first, last, step = (*_wholes(fields, place, 2), *_wholes(fields[2:], place, 0, [1]))
        if step == 0 or (last - first) % step or (last - first) // step < 1:
            raise InputError(f"{place}: the step {step} does not lead from node {first} to node {last}.")
        count = _bounded(block, (last - first) // step)
        ends = places_of(part, np.array([first, last]), place)
        ratio = np.arange(count + 1)[:, None] / count
        made.append((first + step * np.arange(count + 1), (1 - ratio) * ends[0] + ratio * ends[1]))
    _add_nodes(part, block, made)


def _nfill(part: DeckPart, block: KeywordBlock) -> None:
    """Generate nodes on straight lines between those of two sets: set, set, number of intervals, step of the numbers."""
    made = []
    for place, fields in block.rows():
        if len(fields) < 3:
            raise InputError(f"{place}: *NFILL needs two node sets and a number of intervals.")
        from_set, to_set = (_members(part, "NSET", name, place) for name in fields[:2])
        count, step = whole(fields[2], place), *_wholes(fields[3:], place, 0, [1])
        if len(from_set) != len(to_set) or count < 1:
            raise InputError(
                f"{place}: the sets have {len(from_set)} and {len(to_set)} nodes: both need as many, and 1 interval or more."
            )
        _bounded(block, count * len(from_set))
        ends = [places_of(part, each, place) for each in (from_set, to_set)]
        for k in range(1, count):
            made.append((from_set + k * step, (1 - k / count) * ends[0] + k / count * ends[1]))
        made += [(from_set, ends[0]), (to_set, ends[1])]
    _add_nodes(part, block, made)


def _ncopy(part: DeckPart, block: KeywordBlock) -> None:
    """Generate copies of a set of nodes, each moved by the same translation and rotation as the one before it."""
    if "SHIFT" not in block.parameters or "OLD SET" not in block.parameters or "CHANGE NUMBER" not in block.parameters:
        raise block.refuse("*NCOPY is read with SHIFT, OLD SET and CHANGE NUMBER. Export the deck with the nodes written out.")
    step, times = (whole(block.parameters.get(name) or "1", block.place) for name in ("CHANGE NUMBER", "MULTIPLE"))
    old = _members(part, "NSET", block.parameters["OLD SET"], block.place)
    moved, made = placement(block), []
    places = places_of(part, old, block.place)
    for k in range(1, 1 + _bounded(block, times)):
        places = moved.applied(places)
        made.append((old + k * step, places))
    _add_nodes(part, block, made, "NEW SET")


def _elgen(part: DeckPart, block: KeywordBlock) -> None:
    """Generate rows, layers and blocks of elements like a master: its number, then per direction count, node and element step."""
    everything = []
    for place, fields in block.rows():
        numbers = _wholes(fields, place, 2, [1, 1, 1, 1, 1, 1, 1, 1])
        master, directions = numbers[0], [numbers[1:4], numbers[4:7], numbers[7:10]]
        owner, nodes = _element(part, master, place)
        labels, nodes = np.array([master]), nodes[None]
        for count, of_nodes, of_elements in directions:
            if count < 1:
                raise InputError(f"{place}: {count} elements in a direction; at least 1 are needed.")
            k = np.arange(_bounded(block, count * len(labels)) // len(labels))
            labels = (labels[None] + of_elements * k[:, None]).ravel()
            nodes = (nodes[None] + of_nodes * k[:, None, None]).reshape(-1, nodes.shape[1])
        _refuse_labels(block, labels)
        part.elements.append(PartElements(owner.type, labels[1:], nodes[1:], block))
        everything.append(labels)
    part.add_to_set("ELSET", np.concatenate([np.zeros(0, np.int64), *everything]), block)


def _elcopy(part: DeckPart, block: KeywordBlock) -> None:
    """Generate a copy of a set of elements, with other numbers of elements and nodes."""
    needed = ("OLD SET", "ELEMENT SHIFT", "SHIFT NODES")
    if lacking := [name for name in needed if not block.parameters.get(name)]:
        raise block.refuse(f"*ELCOPY needs {', '.join(lacking)}. Add it.")
    shift, of_nodes = (whole(block.parameters[name], block.place) for name in needed[1:])
    copied = _members(part, "ELSET", block.parameters["OLD SET"], block.place)
    for each in list(part.elements):
        here = np.isin(each.labels, copied)
        if here.any():
            labels = each.labels[here] + shift
            _refuse_labels(block, labels)
            part.elements.append(PartElements(each.type, labels, each.nodes[here] + of_nodes, block))
    part.add_to_set("ELSET", copied + shift, block, "NEW SET")


HOW: dict[str, Callable[[DeckPart, KeywordBlock], None]] = {
    "NGEN": _ngen, "NFILL": _nfill, "NCOPY": _ncopy, "ELGEN": _elgen, "ELCOPY": _elcopy,
}  # fmt: skip
REFUSED = {
    "NGEN": ("LINE",),
    "NFILL": ("BIAS", "SINGULAR", "TWO STEP"),
    "NCOPY": ("REFLECT", "POLE"),
    "ELGEN": ("ALL NODES",),
    "ELCOPY": ("REFLECT",),
}
"""Keyword -> parameters that make other things than straight, evenly spaced nodes."""


def _wholes(fields: list[str], place: str, needed: int, defaults: list[int] | None = None) -> list[int]:
    """Whole numbers of a line, missing or empty ones by default."""
    if len(fields) < needed:
        raise InputError(f"{place}: the line needs {needed} numbers at least. Fix it.")
    found = [whole(text, place) for text in fields[:needed]]
    rest = fields[needed : needed + len(defaults or [])]
    return found + [whole(rest[k], place) if k < len(rest) and rest[k] else default for k, default in enumerate(defaults or [])]


def _bounded(block: KeywordBlock, count: int) -> int:
    if not 1 <= count <= MOST_GENERATED:
        raise block.refuse(f"it generates {count} nodes or elements, and from 1 to {MOST_GENERATED} are read. Fix the numbers.")
    return count


def _refuse_labels(block: KeywordBlock, labels: np.ndarray) -> None:
    if labels.min() < 1 or labels.max() > LARGEST_LABEL:
        raise block.refuse(f"it generates numbers from {labels.min()} to {labels.max()}; these go from 1 to {LARGEST_LABEL}.")


def _add_nodes(part: DeckPart, block: KeywordBlock, made: list[tuple[np.ndarray, np.ndarray]], into: str = "NSET") -> None:
    if not made:
        return
    labels, places = (np.concatenate(each) for each in zip(*made, strict=True))
    _refuse_labels(block, labels)
    part.nodes.append((labels, places))
    part.generated = True
    part.add_to_set("NSET", labels, block, into)


def places_of(part: DeckPart, wanted: np.ndarray, place: str) -> np.ndarray:
    """Places (n, 3) of existing nodes.

    Raises
    ------
    InputError
        There is no such node.
    """
    labels, places = part.places()
    at = Lookup(labels).places(wanted)
    if np.any(at < 0):
        raise InputError(f"{place} names a node that the deck has not defined by then. Define it first.")
    return places[at]


def _element(part: DeckPart, wanted: int, place: str) -> tuple[PartElements, np.ndarray]:
    """Element of a number, the last one of it, and its nodes."""
    for each in reversed(part.elements):
        if len(here := np.flatnonzero(each.labels == wanted)):
            return each, each.nodes[here[-1]]
    raise InputError(f"{place} names element {wanted}, which the deck has not defined by then. Define it first.")


def _members(part: DeckPart, kind: str, name: str, place: str) -> np.ndarray:
    """Numbers of the nodes or elements of a set of the part, rising unless the set keeps its order."""
    sets = part.node_sets if kind == "NSET" else part.element_sets
    if label_of(name) not in sets:
        raise InputError(f"{place} names a set that the deck has not defined by then. Define it first.")
    found = sets[label_of(name)]
    numbers = numbers_of(part, kind, found.members)
    return np.unique(numbers) if found.sorted else numbers[np.sort(np.unique(numbers, return_index=True)[1])]


def _nodes_of(part: DeckPart, wanted: np.ndarray) -> Iterator[np.ndarray]:
    """Numbers of the nodes of elements, by block; of an element that is given twice the last one counts."""
    kept, start = last_of(np.concatenate([np.zeros(0, np.int64), *(each.labels for each in part.elements)])), 0
    for each in part.elements:
        yield each.nodes[np.isin(each.labels, wanted) & kept[start : start + len(each.labels)]]
        start += len(each.labels)


def numbers_of(part: DeckPart, kind: str, members: list[Members]) -> np.ndarray:
    """Numbers of the members of a set that are those of the part itself."""
    labels = np.zeros(0, np.int64)
    if any(isinstance(member.what, Range) for member in members):
        labels = part.places()[0] if kind == "NSET" else np.concatenate([labels, *(each.labels for each in part.elements)])
    found = [np.zeros(0, np.int64)]
    for member in members:
        what = member.what
        if member.instance:
            raise InputError("a set of an instance cannot be used to generate nodes or elements. Export them written out.")
        if isinstance(what, Range):
            found.append(what.of(labels))
        elif isinstance(what, NodesOf):
            own = part.element_sets.get(what.elements)
            if what.known is None and own is None:
                raise InputError(f"{what.place} names an element set that the deck does not have. Define it first.")
            wanted = numbers_of(part, "ELSET", own.members if own and what.known is None else [*(what.known or ())])
            found += [nodes.ravel() for nodes in _nodes_of(part, wanted)]
        elif isinstance(what, Named):
            sets = part.node_sets if what.kind == "NSET" else part.element_sets
            if what.label not in sets:
                raise InputError(f"{what.place} names a set that the instance does not have. Define it first.")
            found.append(numbers_of(part, kind, sets[what.label].members))
        else:
            found.append(what)
    return np.concatenate(found)
