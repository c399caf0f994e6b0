"""Sets and surfaces of a deck as groups, by the names that body.toml can give."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from preprocessing.foreign_files.abaqus.assembled import Assembled, Numbered, PlacedElements
from preprocessing.foreign_files.abaqus.blocks import label_of
from preprocessing.foreign_files.abaqus.faces import face_of
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.lookup import Lookup, rises
from preprocessing.foreign_files.abaqus.numbers import WHOLE
from preprocessing.foreign_files.abaqus.parts import Face, Members, Set
from preprocessing.foreign_files.contents import Elements
from toolkit.foundation.errors import InputError

Group = tuple[str, Elements]
"""Name, and nodes or elements."""


def groups_of(whole: Assembled) -> list[Group]:
    """All node sets, surfaces and element sets, in this order: where several have one name, the nodes of the first count.

    A set of an instance has its own name where no other instance has it, and always that of the instance and a point before it where
    there are several instances.
    """
    index = {id(each): _Index(whole, each) for each in whole.instances}
    found = list[Group]()
    for kind in ("node_sets", "surfaces", "element_sets"):
        names = [label for each in whole.instances for label in getattr(each.part, kind)]
        for each in whole.instances:
            for label, own in getattr(each.part, kind).items():
                elements = (
                    _of_surface(whole, index, each, own[1]) if kind == "surfaces" else _of_set(whole, index, each, kind, own)
                )
                found += [(name, elements) for name in _names(whole, each, label, own, names)]
    return found


def _names(whole: Assembled, each: Numbered, label: str, own: Set | tuple[str, list[Face]], every: list[str]) -> Iterator[str]:
    spelled = own.name if isinstance(own, Set) else own[0]
    if not each.label or every.count(label) == 1:
        yield spelled
    if each.label and len(whole.instances) > 2:
        yield f"{each.part.name}.{spelled}"


class _Index:
    """The elements of an instance by their numbers."""

    def __init__(self, whole: Assembled, instance: Numbered) -> None:
        self.blocks = [each for each in whole.elements if each.instance is instance]
        self.elements = Lookup(np.concatenate([np.zeros(0, np.int64), *(each.labels for each in self.blocks)]))
        self.starts = np.cumsum([0, *(len(each.labels) for each in self.blocks)])

    def rows_of(self, wanted: np.ndarray) -> Iterator[tuple[PlacedElements, np.ndarray]]:
        """Blocks with the rows of the elements of these numbers; those that there are not count for nothing."""
        if not len(self.elements.numbers):
            return
        rows = self.elements.places(wanted)
        rows = rows if rises(rows) else np.unique(rows)
        for each, start, end in zip(self.blocks, self.starts[:-1], self.starts[1:], strict=True):
            first, last = np.searchsorted(rows, [start, end])
            if last > first:
                yield each, rows[first:last] - start


def _of_set(whole: Assembled, index: dict[int, _Index], each: Numbered, kind: str, own: Set) -> Elements:
    """The nodes, or the elements by kind, of a set."""
    what, found = "NSET" if kind == "node_sets" else "ELSET", Elements()
    for owner, numbers in _numbers(whole, each, what, own.members):
        if what == "NSET":
            places = owner.places_of(numbers)
            found.append(("vertex", places[places >= 0][:, None]))
        else:
            found += [(block.of.type.kind, _rows(block.nodes, rows)) for block, rows in index[id(owner)].rows_of(numbers)]
    return found


def _rows(nodes: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Some rows; where these are all, the array itself, which then is kept once."""
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


def _of_surface(whole: Assembled, index: dict[int, _Index], each: Numbered, faces: list[Face]) -> Elements:
    """Faces of elements by kind, and nodes, of a surface."""
    found = Elements()
    for face in faces:
        owner, text = each, face.target
        if "." in text and (other := whole.instance(label_of(text.rpartition(".")[0]))):
            owner, text = other, text.rpartition(".")[2]
        for holder, numbers in _targets(whole, owner, face, text):
            if not face.face:
                places = holder.places_of(numbers)
                found.append(("vertex", places[places >= 0][:, None]))
                continue
            for block, rows in index[id(holder)].rows_of(numbers):
                side = face_of(block.of.type.kind, int(face.face[1:]) - 1) if face.face[1:].isdigit() else None
                if side is not None and face.face[0] == "S":
                    found.append((side[0], block.nodes[rows][:, side[1]]))
    return found


def _targets(whole: Assembled, owner: Numbered, face: Face, text: str) -> Iterator[tuple[Numbered, np.ndarray]]:
    """Instances with the numbers of elements, or of nodes, that a line of a surface means."""
    if WHOLE.fullmatch(text):
        yield owner, np.array([int(text)])
        return
    kind, sets = ("ELSET", owner.part.element_sets) if face.face else ("NSET", owner.part.node_sets)
    if label_of(text) in sets:
        yield from _numbers(whole, owner, kind, sets[label_of(text)].members)
