"""Sets and surfaces of a deck as groups, by the names that body.toml can give."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from preprocessing.foreign_files.abaqus.assembled import Assembled, Numbered, PlacedElements
from preprocessing.foreign_files.abaqus.blocks import label_of
from preprocessing.foreign_files.abaqus.faces import side_of
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.lookup import Lookup, rises
from preprocessing.foreign_files.abaqus.numbers import WHOLE
from preprocessing.foreign_files.abaqus.parts import Face, Members, Set
from preprocessing.foreign_files.contents import Elements
from toolkit.foundation.errors import InputError

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
