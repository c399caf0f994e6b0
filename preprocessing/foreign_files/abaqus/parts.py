"""What a part of a deck holds: nodes and elements by their numbers, node sets, element sets and surfaces by their names."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import WHOLE, KeywordBlock, label, label_of, name_of, number, whole
from preprocessing.foreign_files.abaqus.vocabulary import ElementType
from toolkit.foundation.errors import InputError

SPARSE_NUMBERS = 8
"""Times as many as there are numbers, up to which the largest of them may be for a table of all numbers below it."""


class Lookup:
    """Lookup of numbers in a list without repetitions, by a table where they are dense, else by bisection."""

    def __init__(self, numbers: np.ndarray) -> None:
        self.numbers = numbers
        self._rises = rises(numbers)
        largest = int(numbers.max(initial=0))
        self._table: np.ndarray | None = None
        if largest < SPARSE_NUMBERS * len(numbers) + 1000:
            self._table = np.full(largest + 2, -1)
            self._table[numbers] = np.arange(len(numbers))
        self._order = np.arange(0) if self._table is not None or self._rises else np.argsort(numbers, kind="stable")

    def places(self, wanted: np.ndarray) -> np.ndarray:
        """Places of some numbers, which are positive; -1 where there is none."""
        if self._table is not None:
            found: np.ndarray = self._table.take(wanted, mode="clip")
            return found
        at = np.searchsorted(self.numbers, wanted, sorter=None if self._rises else self._order).clip(max=len(self.numbers) - 1)
        at = at if self._rises else self._order[at]
        return np.where(self.numbers[at] == wanted, at, -1)


def rises(numbers: np.ndarray) -> bool:
    """Whether numbers grow from one to the next."""
    return bool(np.all(numbers[1:] > numbers[:-1]))


def last_of(numbers: np.ndarray) -> np.ndarray:
    """Whether each of the numbers is the last one of its value."""
    kept = np.ones(len(numbers), bool)
    if not rises(numbers):
        kept[:] = False
        kept[len(numbers) - 1 - np.unique(numbers[::-1], return_index=True)[1]] = True
    return kept


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


class PartElements(NamedTuple):
    """Elements of one block."""

    type: ElementType
    labels: np.ndarray  # (n_e,)
    nodes: np.ndarray  # (n_e, n_nodes) numbers of nodes
    block: KeywordBlock


class Face(NamedTuple):
    """Line of a surface: a face of an element or of those of a set, or a node or node set."""

    target: str
    of: str  # NSET or ELSET: what a name in it means
    side: str  # "S1" and so on; empty of nodes, and where the line names none
    place: str


@dataclass
class DeckPart:
    """Part, instance, assembly, or deck without any of them."""

    name: str = ""  # as the deck spells it
    nodes: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)  # labels (n,) and places (n, 3) of every block
    elements: list[PartElements] = field(default_factory=list)
    node_sets: dict[str, Set] = field(default_factory=dict)  # label -> set
    element_sets: dict[str, Set] = field(default_factory=dict)
    surfaces: dict[str, tuple[str, list[Face]]] = field(default_factory=dict)  # label -> name as spelled, faces
    made_of: DeckPart | None = None  # the part that an instance is a copy of
    generated: bool = False  # whether nodes were generated, which gives their ends once more

    def add_nodes(self, labels: np.ndarray, places: np.ndarray, block: KeywordBlock) -> None:
        """Add nodes, also to the set that the keyword line names."""
        self.nodes.append((labels, places))
        self.add_to_set("NSET", labels, block)

    def add_elements(self, elements: PartElements) -> None:
        """Add elements, also to the set that the keyword line names."""
        self.elements.append(elements)
        self.add_to_set("ELSET", elements.labels, elements.block)

    def add_to_set(self, kind: str, labels: np.ndarray, block: KeywordBlock, key: str = "") -> None:
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


def read_set(part: DeckPart, block: KeywordBlock) -> None:
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


def _ranges(block: KeywordBlock) -> list[Range]:
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


def _listed(part: DeckPart, kind: str, instance: str, block: KeywordBlock) -> list[Members]:
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


SHORTEST_AXIS = 1e-12
"""Length of an axis, in parts of the coordinates that make it, below which it has no direction."""


class Placement(NamedTuple):
    """Affine map x -> A x + b."""

    rotation: np.ndarray  # A (3, 3)
    shift: np.ndarray  # b (3,)

    def applied(self, places: np.ndarray) -> np.ndarray:
        """Places (n, 3) moved by the map."""
        return places @ self.rotation.T + self.shift


def from_cylindrical(places: np.ndarray) -> np.ndarray:
    """Coordinates x, y, z from cylindrical ones: r, angle in degrees, z."""
    angle = np.deg2rad(places[:, 1])
    return np.column_stack([places[:, 0] * np.cos(angle), places[:, 0] * np.sin(angle), places[:, 2]])


def local_system(block: KeywordBlock) -> Placement | None:
    """Map from the coordinates of *SYSTEM to those of the deck; None without data lines, which end the local system.

    Its origin is a, its first axis runs through b, and c is in the plane of the first two axes.

    Without c the third axis is that of the deck, and the first one is projected on the plane of x and y. Without data lines there is no
    local system any more.
    """
    rows = [[number(text, place) for text in fields] for place, fields in block.rows()]
    if not rows:
        return None
    if len(rows) > 2 or len(rows[0]) > 6 or (rows[1:] and len(rows[1]) > 3):
        raise block.refuse("*SYSTEM has at most two lines, of 6 and 3 numbers. Fix them.")
    a, b = np.array([*rows[0], *6 * [0.0]][:6]).reshape(2, 3)
    if len(rows[0]) <= 3:
        return Placement(np.eye(3), a)
    first = b - a
    if rows[1:]:
        third = np.cross(first, np.array([*rows[1], 0.0, 0.0][:3]) - a)
    else:
        first, third = first * [1, 1, 0], np.array([0.0, 0.0, 1.0])
    return Placement(_axes(block, first, third), a)


def _axes(block: KeywordBlock, first: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Columns of unit axes, of which the first and the third have these directions."""
    scale = max(np.abs(first).max(), np.finfo(float).tiny)
    if np.linalg.norm(first) == 0 or np.linalg.norm(third) <= SHORTEST_AXIS * scale * max(1.0, scale):
        raise block.refuse("the points of the local system are at one place or on one line. Give three that are apart.")
    x, z = first / np.linalg.norm(first), third / np.linalg.norm(third)
    return np.column_stack([x, np.cross(z, x), z])


def placement(block: KeywordBlock) -> Placement:
    """Map of a translation, then a rotation by degrees about the axis from a to b: lines of *INSTANCE and *NCOPY, SHIFT."""
    rows = [[number(text, place) for text in fields] for place, fields in block.rows()]
    if len(rows) > 2 or (rows and len(rows[0]) > 3) or (rows[1:] and len(rows[1]) != 7):
        raise block.refuse(
            "a placement is a line with a translation, and one with points a and b of an axis and an angle. Fix it."
        )
    shift = np.array([*(rows[0] if rows else []), 0.0, 0.0, 0.0][:3])
    if not rows[1:]:
        return Placement(np.eye(3), shift)
    a, axis, angle = np.array(rows[1][:3]), np.array(rows[1][3:6]) - rows[1][:3], np.deg2rad(rows[1][6])
    if not np.linalg.norm(axis):
        raise block.refuse("the points a and b of its axis of rotation are the same. Give two.")
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return Placement(turn, turn @ (shift - a) + a)
