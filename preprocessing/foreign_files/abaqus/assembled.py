"""Instances put together in one list of points, and the sets and surfaces of a deck as groups of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import WHOLE, label_of
from preprocessing.foreign_files.abaqus.deck import Deck, Instance
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.parts import DeckPart, Face, Lookup, Members, PartElements, Set, last_of, rises
from preprocessing.foreign_files.abaqus.vocabulary import side_of
from preprocessing.foreign_files.contents import Elements
from toolkit.foundation.errors import InputError


class PlacedElements(NamedTuple):
    """Elements of one block in one instance."""

    of: PartElements
    instance: Numbered
    labels: np.ndarray  # (n_e,)
    nodes: np.ndarray  # (n_e, n_nodes) places among the points

    @property
    def part(self) -> DeckPart:
        """Part that the elements belong to."""
        return self.instance.part


@dataclass(eq=False)
class Numbered:
    """Instance with the places of its nodes among the points."""

    label: str
    part: DeckPart
    instance: Instance
    nodes: Lookup  # its nodes by their numbers
    first: int  # place of its first node among the points

    def places_of(self, wanted: np.ndarray) -> np.ndarray:
        """Places among the points of nodes by their numbers; -1 where there is none."""
        found = self.nodes.places(wanted)
        return found if not self.first else np.where(found >= 0, self.first + found, -1)


@dataclass
class Assembled:
    """Nodes and elements of all instances of a deck."""

    deck: Deck
    instances: list[Numbered]  # that of the assembly, or of the deck itself, is the first
    points: np.ndarray  # (n, 3)
    labels: np.ndarray  # (n,) numbers in the deck; empty where two nodes have the same
    elements: list[PlacedElements] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def instance(self, label: str) -> Numbered | None:
        """Instance with the given label."""
        return next((each for each in self.instances if each.label == label), None)


def assembled(deck: Deck) -> Assembled:
    """Put the instances of a deck in their places.

    Raises
    ------
    InputError
        Several parts stand there without an assembly, or an element names a node that there is not.
    """
    instances, points, first, remarks = list[Numbered](), [np.zeros((0, 3))], 0, [*deck.remarks]
    root, *others = _instances(deck)
    for each in (*others, root):  # what an assembly has itself stands behind its instances in the deck
        labels, places = each.part.places()
        given = sum(len(own) for own, _ in each.part.nodes)
        if given > len(labels) and not each.part.generated:
            remarks.append(f"{given - len(labels)} nodes of the deck are given more than once: the last place of each counts.")
        instances.append(Numbered(each.label, each.part, each, Lookup(labels), first))
        points.append(places if each.placement is None else each.placement.applied(places))
        first += len(labels)
    labels = np.concatenate([each.nodes.numbers for each in instances])
    instances = [instances[-1], *instances[:-1]]
    unique = rises(labels) or len(np.unique(labels)) == len(labels)
    found = Assembled(deck, instances, np.concatenate(points), labels if unique else labels[:0], remarks=remarks)
    for numbered in instances:
        found.elements += _placed(numbered, found.remarks)
    return found


def _instances(deck: Deck) -> list[Instance]:
    root = Instance("", deck.root, None)
    if deck.instances or not deck.parts:
        return [root, *deck.instances]
    if len(deck.parts) > 1 or deck.root.nodes:
        raise InputError(
            f"the deck {str(deck.path)!r} has {len(deck.parts)} parts and no *ASSEMBLY that says where they are. Export the body as one "
            "part, or with its assembly."
        )
    return [Instance("", part, None) for part in deck.parts.values()]


def _placed(numbered: Numbered, remarks: list[str]) -> list[PlacedElements]:
    """Elements of an instance; of those with one number the last one counts, as in the manual."""
    blocks, found, start = numbered.part.elements, [], 0
    kept = last_of(np.concatenate([np.zeros(0, np.int64), *(each.labels for each in blocks)]))
    if np.any(~kept):
        remarks.append(
            f"{np.count_nonzero(~kept)} elements of the deck are given more than once: the last one of each number counts."
        )
    for each in blocks:
        here = kept[start : start + len(each.labels)]
        labels, nodes = (each.labels, each.nodes) if here.all() else (each.labels[here], each.nodes[here])
        start += len(each.labels)
        if len(labels):
            found.append(PlacedElements(each, numbered, labels, _on_points(numbered, each, labels, nodes)))
    return found


def _on_points(numbered: Numbered, each: PartElements, labels: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Nodes of elements as places among the points."""
    found = numbered.places_of(nodes)
    if found.min() < 0:
        row = int(np.flatnonzero((found < 0).any(axis=1))[0])
        wrong = nodes[row][found[row] < 0][0]
        raise each.block.refuse(f"element {labels[row]} names node {wrong}, which the deck does not have. Export it again.")
    return found


Group = tuple[str, Elements]
"""Name, and nodes or elements."""


KINDS = {"NSET": "node_sets", "SURFACE": "surfaces", "ELSET": "element_sets"}
"""Attribute of a part that holds its groups, by the keyword that names these."""


class Groups:
    """Node sets, surfaces and element sets of all instances."""

    def __init__(self, whole: Assembled) -> None:
        self.whole = whole
        self.index = {id(each): _Index(whole, each) for each in whole.instances}
        self._missing: dict[str, set[int]] = {"NSET": set(), "ELSET": set()}

    def every(self) -> list[Group]:
        """All node sets, surfaces and element sets, in this order: where several have one name, the nodes of the first count.

        A set of an instance has its own name where nothing else has it, and that of the instance and a point before it where something
        else has its own, or there are several instances. Surfaces that are not read as a whole are none of these, which is told.
        """
        found = list[Group]()
        for kind, place in KINDS.items():
            names = [label for each in self.whole.instances for label in getattr(each.part, place)]
            for each in self.whole.instances:
                for label, own in getattr(each.part, place).items():
                    elements = self._told(each, own[1]) if kind == "SURFACE" else self._of_set(each, kind, own.members)
                    if elements is not None:
                        found += [(name, elements) for name in _names(self.whole, each, label, own, names)]
        self._tell_missing()
        return found

    def _tell_missing(self) -> None:
        """Report members that the deck does not have, except elements that are left out on purpose."""
        for kind, words in (("NSET", "nodes"), ("ELSET", "elements")):
            missing = self._missing[kind]
            if missing and (kind == "NSET" or not self.whole.deck.dropped):
                self.whole.remarks.append(
                    f"sets and surfaces of the deck name {len(missing)} {words} that it does not have, the first of them {min(missing)}."
                )

    def _placed(self, owner: Numbered, numbers: np.ndarray) -> np.ndarray:
        """Places of those nodes that exist."""
        places = owner.places_of(numbers)
        self._missing["NSET"].update(numbers[places < 0].tolist())
        return places[places >= 0]

    def _rows_of(self, owner: Numbered, numbers: np.ndarray) -> Iterator[tuple[PlacedElements, np.ndarray]]:
        """Blocks with the rows of those elements that exist."""
        index = self.index[id(owner)]
        self._missing["ELSET"].update(index.missing(numbers).tolist())
        yield from index.rows_of(numbers)

    def nodes(self, each: Numbered, kind: str, text: str) -> np.ndarray:
        """Places of the nodes of a set or surface that a part names, or of a node by its number; none where there is no such name."""
        owner, text = _owner(self.whole, each, text.strip())
        own = getattr(owner.part, KINDS[kind]).get(label_of(text))
        if kind == "NSET" and WHOLE.fullmatch(text):
            places = owner.places_of(np.array([int(text)]))
            return places[places >= 0]
        elements = (
            []
            if own is None
            else self._of_surface(owner, own[1])
            if kind == "SURFACE"
            else self._of_set(owner, kind, own.members)
        )
        return np.unique(np.concatenate([np.zeros(0, np.int64), *(nodes.ravel() for _, nodes in elements)]))

    def _of_set(self, each: Numbered, kind: str, members: list[Members]) -> Elements:
        """Nodes, or elements by kind, of a set."""
        found = Elements()
        for owner, numbers in _numbers(self.whole, each, kind, members):
            if kind == "NSET":
                found.append(("vertex", self._placed(owner, numbers)[:, None]))
            else:
                found += [(block.of.type.kind, _rows(block.nodes, rows)) for block, rows in self._rows_of(owner, numbers)]
        return found

    def _told(self, each: Numbered, faces: list[Face]) -> Elements | None:
        """Sides and nodes of a surface; None, with a remark, of one that is not read."""
        try:
            return self._of_surface(each, faces)
        except _NotReadError as error:
            self.whole.remarks.append(
                f"the surface of {error} of the deck is no group: it names sides of elements that are not read (S1 to S6, and SPOS and "
                "SNEG of shells are)."
            )
            return None

    def _of_surface(self, each: Numbered, faces: list[Face]) -> Elements:
        """Sides of elements by kind, and nodes, of a surface."""
        found = Elements()
        for face in faces:
            owner, text = _owner(self.whole, each, face.target)
            for holder, numbers in _targets(self.whole, owner, face, text):
                if face.of == "NSET":
                    found.append(("vertex", self._placed(holder, numbers)[:, None]))
                    continue
                for block, rows in self._rows_of(holder, numbers):
                    side = side_of(block.of.type.kind, face.side)
                    if side is None:
                        raise _NotReadError(face.place)
                    found.append((side[0], block.nodes[rows][:, side[1]]))
        return found


class _NotReadError(Exception):
    """Error of a surface that names sides of elements that are not read."""


def _names(whole: Assembled, each: Numbered, label: str, own: Set | tuple[str, list[Face]], every: list[str]) -> Iterator[str]:
    spelled, alone = own.name if isinstance(own, Set) else own[0], every.count(label) == 1
    if not each.label or alone:
        yield spelled
    if each.label and (len(whole.instances) > 2 or not alone):
        yield f"{each.part.name}.{spelled}"


def _owner(whole: Assembled, each: Numbered, text: str) -> tuple[Numbered, str]:
    """Instance that a name belongs to, which may stand before it and a point, and the name itself."""
    owner = whole.instance(label_of(text.rpartition(".")[0])) if "." in text else None
    return (each, text) if owner is None else (owner, text.rpartition(".")[2])


class _Index:
    """Index of an instance's elements by their numbers."""

    def __init__(self, whole: Assembled, instance: Numbered) -> None:
        self.blocks = [each for each in whole.elements if each.instance is instance]
        self.elements = Lookup(np.concatenate([np.zeros(0, np.int64), *(each.labels for each in self.blocks)]))
        self.starts = np.cumsum([0, *(len(each.labels) for each in self.blocks)])

    def missing(self, wanted: np.ndarray) -> np.ndarray:
        """Numbers among the wanted ones that no element has."""
        return wanted[self.elements.places(wanted) < 0] if len(self.elements.numbers) else wanted

    def rows_of(self, wanted: np.ndarray) -> Iterator[tuple[PlacedElements, np.ndarray]]:
        """Blocks with the rows of the elements of these numbers; numbers without an element count for nothing."""
        if not len(self.elements.numbers):
            return
        rows = self.elements.places(wanted)
        rows = rows if rises(rows) else np.unique(rows)
        cuts = np.searchsorted(rows, self.starts)
        for k in np.flatnonzero(cuts[1:] > cuts[:-1]).tolist():
            yield self.blocks[k], rows[cuts[k] : cuts[k + 1]] - self.starts[k]


def _rows(nodes: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows of an array; where these are all, the array itself, which then is stored once."""
    return nodes if len(rows) == len(nodes) else nodes[rows]


def _numbers(whole: Assembled, each: Numbered, kind: str, members: list[Members]) -> Iterator[tuple[Numbered, np.ndarray]]:
    """Instances, and the numbers of those members that are theirs."""
    for label in dict.fromkeys(member.instance for member in members):
        owner = whole.instance(label) if label else each
        if owner is None:
            raise InputError(
                f"a set of the deck {str(whole.deck.path)!r} names an instance that the deck does not have. Export it again."
            )
        mine = [member._replace(instance="") for member in members if member.instance == label]
        yield owner, numbers_of(owner.part, kind, mine)


def _targets(whole: Assembled, owner: Numbered, face: Face, text: str) -> Iterator[tuple[Numbered, np.ndarray]]:
    """Instances with the numbers of elements, or of nodes, that a line of a surface means."""
    if WHOLE.fullmatch(text):
        yield owner, np.array([int(text)])
        return
    sets = owner.part.element_sets if face.of == "ELSET" else owner.part.node_sets
    if label_of(text) not in sets:
        raise InputError(f"{face.place} names a set that the deck does not have. Define it, or take the line out.")
    yield from _numbers(whole, owner, face.of, sets[label_of(text)].members)
