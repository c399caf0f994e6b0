"""What a part of a deck holds: nodes and elements by their numbers, node sets, element sets and surfaces by their names."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import Block, label_of, name_of
from preprocessing.foreign_files.abaqus.lookup import rises
from preprocessing.foreign_files.abaqus.numbers import WHOLE, label, whole
from preprocessing.foreign_files.abaqus.vocabulary import ElementType
from toolkit.foundation.errors import InputError


class Range(NamedTuple):
    """Numbers from the first to the last one, in steps; numbers that nothing has count for nothing."""

    first: int
    last: int
    step: int

    def of(self, numbers: np.ndarray) -> np.ndarray:
        """Numbers among the given ones that lie in the range."""
        inside = (numbers >= self.first) & (numbers <= self.last) & ((numbers - self.first) % self.step == 0)
        return numbers[inside]


class NodesOf(NamedTuple):
    """Nodes of the elements of a set."""

    elements: str  # label of the set
    known: tuple[Members, ...] | None  # its members by then; None if it is not defined by then
    place: str


class Named(NamedTuple):
    """Set of a name in an instance."""

    kind: str
    label: str
    place: str


class Members(NamedTuple):
    """Members of a set: numbers, a range of them, the nodes of elements, or all of another set."""

    instance: str  # label of the instance whose numbers they are; empty: those of the part itself
    what: np.ndarray | Range | NodesOf | Named


@dataclass
class Set:
    """A node set or an element set, to which every block of its name adds."""

    name: str  # as the deck spells it first
    members: list[Members] = field(default_factory=list)
    sorted: bool = True


class Elements(NamedTuple):
    """Elements of one block."""

    type: ElementType
    labels: np.ndarray  # (n_e,)
    nodes: np.ndarray  # (n_e, n_nodes) numbers of nodes
    block: Block


class Face(NamedTuple):
    """Line of a surface: a face of an element or of those of a set, or a node or node set."""

    target: str
    of: str  # NSET or ELSET: what a name in it means
    side: str  # "S1" and so on; empty of nodes, and where the line names none
    place: str


@dataclass
class Part:
    """Part, instance, assembly, or deck without any of them."""

    name: str = ""  # as the deck spells it
    nodes: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)  # labels (n,) and places (n, 3) of every block
    elements: list[Elements] = field(default_factory=list)
    node_sets: dict[str, Set] = field(default_factory=dict)  # label -> set
    element_sets: dict[str, Set] = field(default_factory=dict)
    surfaces: dict[str, tuple[str, list[Face]]] = field(default_factory=dict)  # label -> name as spelled, faces
    made_of: Part | None = None  # the part that an instance is a copy of
    generated: bool = False  # whether nodes were generated, which gives their ends once more

    def add_nodes(self, labels: np.ndarray, places: np.ndarray, block: Block) -> None:
        """Add nodes, also to the set that the keyword line names."""
        self.nodes.append((labels, places))
        self.add_to_set("NSET", labels, block)

    def add_elements(self, elements: Elements) -> None:
        """Add elements, also to the set that the keyword line names."""
        self.elements.append(elements)
        self.add_to_set("ELSET", elements.labels, elements.block)

    def add_to_set(self, kind: str, labels: np.ndarray, block: Block, key: str = "") -> None:
        """Add numbers to the set that a parameter of the keyword line names, if it has one."""
        if name := block.parameters.get(key or kind):
            self.set_of(kind, name).members.append(Members("", labels))

    def set_of(self, kind: str, name: str) -> Set:
        """Set NSET or ELSET of a name, made where there is none."""
        sets = self.node_sets if kind == "NSET" else self.element_sets
        return sets.setdefault(label_of(name), Set(name_of(name)))

    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (n,) and places (n, 3) of all nodes in the order of the deck; of one that is given twice the last place counts."""
        if not self.nodes:
            return np.zeros(0, np.int64), np.zeros((0, 3))
        labels, places = (each[0] if len(each) == 1 else np.concatenate(each) for each in zip(*self.nodes, strict=True))
        if rises(labels):
            return labels, places
        unique, first = np.unique(labels, return_index=True)
        if len(unique) == len(labels):
            return labels, places
        _, last = np.unique(labels[::-1], return_index=True)
        order = np.argsort(first, kind="stable")
        return unique[order], places[::-1][last][order]


def read_set(part: Part, block: Block) -> None:
    """Add the members that a block *NSET or *ELSET names.

    Raises
    ------
    InputError
        The block has no name, a member is no number and no set that is known by then, or a range does not rise.
    """
    kind = block.keyword
    if kind not in block.parameters:
        raise block.refuse(f"*{kind} needs the parameter {kind}=name. Add it.")
    target, instance = part.set_of(kind, block.parameters[kind]), label_of(block.parameters.get("INSTANCE", ""))
    if "UNSORTED" in block.parameters:
        target.sorted = False
    if kind == "NSET" and "ELSET" in block.parameters:
        own = None if instance else part.element_sets.get(label_of(block.parameters["ELSET"]))
        known = None if own is None else tuple(own.members)
        target.members.append(Members(instance, NodesOf(label_of(block.parameters["ELSET"]), known, block.place)))
    if "GENERATE" in block.parameters:
        target.members += [Members(instance, each) for each in _ranges(block)]
    else:
        target.members += list(_listed(part, kind, instance, block))


def _ranges(block: Block) -> list[Range]:
    found = []
    for place, fields in block.rows():
        if not 1 <= len(fields) <= 3:
            raise InputError(f"{place} has {len(fields)} fields; with GENERATE a line is: first, last, step.")
        first = label(fields[0], place)
        last = label(fields[1], place) if fields[1:] else first
        step = whole(fields[2], place) if fields[2:] and fields[2] else 1
        if step < 1 or last < first:
            raise InputError(f"{place}: numbers go from {first} to {last} in steps of {step}; they have to rise.")
        found.append(Range(first, last, step))
    return found


def _listed(part: Part, kind: str, instance: str, block: Block) -> list[Members]:
    """Numbers, names of sets, and both with the name of an instance before a point."""
    found, numbers, sets = list[Members](), list[int](), part.node_sets if kind == "NSET" else part.element_sets
    for place, fields in block.rows():
        for text in fields:
            if WHOLE.fullmatch(text):
                numbers.append(label(text, place))
                continue
            owner, _, own = text.rpartition(".")
            if owner and WHOLE.fullmatch(own):
                found.append(Members(label_of(owner), np.array([label(own, place)])))
            elif label_of(text) in sets:
                found += sets[label_of(text)].members
            elif instance or owner:
                found.append(Members(label_of(owner) or instance, Named(kind, label_of(own), place)))
            elif not text:
                raise InputError(f"{place} has an empty field between its commas. Take it out.")
            else:
                raise InputError(f"{place} names a set that the deck has not defined by then. Define it first, or give numbers.")
    return [*found, Members(instance, np.array(numbers, np.int64))] if numbers else found
