"""The content of a deck as it is written: parts, instances, sections, masses and ties, before any of it is put together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import KeywordBlock, blocks_of, element_rows, label_of, name_of, node_rows
from preprocessing.foreign_files.abaqus.generated import HOW as GENERATED
from preprocessing.foreign_files.abaqus.generated import generate
from preprocessing.foreign_files.abaqus.parts import (
    DeckPart,
    Face,
    PartElements,
    Placement,
    Set,
    from_cylindrical,
    local_system,
    placement,
    read_set,
)
from preprocessing.foreign_files.abaqus.vocabulary import (
    CARRIES,
    TIES,
    ElementType,
    element_type,
    says_nothing,
    unknown_parameters,
)
from toolkit.foundation.errors import InputError


class Instance(NamedTuple):
    """Copy of a part in its own place."""

    label: str  # empty of a deck without instances
    part: DeckPart
    placement: Placement | None


class Property(NamedTuple):
    """Block that gives something to the elements of a set, or to nodes of a part."""

    block: KeywordBlock
    part: DeckPart


@dataclass
class Deck:
    """Contents of a deck that are used."""

    path: Path
    leave_out: frozenset[str]
    root: DeckPart = field(default_factory=DeckPart)  # what stands outside of parts; with instances the assembly
    parts: dict[str, DeckPart] = field(default_factory=dict)
    instances: list[Instance] = field(default_factory=list)
    sections: list[Property] = field(default_factory=list)
    masses: list[Property] = field(default_factory=list)
    ties: list[Property] = field(default_factory=list)
    dropped: dict[str, int] = field(default_factory=dict)  # what was left out on purpose -> how many
    remarks: list[str] = field(default_factory=list)

    def drop(self, name: str, number: int) -> None:
        """Note that something was left out on purpose."""
        self.dropped[name] = self.dropped.get(name, 0) + number


def read_blocks(path: Path, leave_out: frozenset[str]) -> Deck:
    """Read a deck block by block.

    Raises
    ------
    InputError
        A block cannot be read, or adds something to the body that cannot be taken; says which line.
    """
    reading = _Reading(Deck(path, leave_out))
    for block in (blocks := blocks_of(path)):
        reading.take(block)
    reading.end()
    for text in {id(block.text): block.text for block in blocks}.values():
        text.release()
    return reading.deck


class _Reading:
    """State of reading a deck: the current part or instance, and the local system in effect."""

    def __init__(self, deck: Deck) -> None:
        self.deck = deck
        self.part, self.inside = deck.root, list[KeywordBlock]()  # blocks *PART, *ASSEMBLY, *INSTANCE that have not ended
        self.system: Placement | None = None
        self.of_instance: tuple[str, DeckPart, KeywordBlock] | None = None

    def take(self, block: KeywordBlock) -> None:
        """Read one block."""
        keyword = block.keyword
        self._parameters(block)
        if not keyword:
            self.deck.remarks.append(
                f"lines of the deck ahead of its first keyword, from line {block.line} on, belong to nothing."
            )
        elif keyword in self.deck.leave_out and keyword not in NEEDED:
            self.deck.drop(keyword, 0 if element_type(keyword) else 1)
        elif keyword in TAKEN:
            TAKEN[keyword](self, block)
        elif keyword in GENERATED:
            if self.system is not None:
                raise block.refuse(
                    "nodes that are generated under *SYSTEM are not read. Export the deck with the nodes written out."
                )
            generate(self.part, block)
        elif keyword in CARRIES:
            raise block.refuse(
                f"*{keyword} stands for {CARRIES[keyword]}, which the body cannot take. Export the deck without it, or leave it out on "
                f'purpose: leave_out = ["{keyword}"] in [mesh].'
            )
        elif keyword in TIES:
            self.deck.ties.append(Property(block, self.part))
        elif not says_nothing(keyword):
            raise block.refuse(
                "the keyword is none of those that are known, and may stand for a part of the body. Fix its spelling, or leave it out on "
                "purpose: leave_out in [mesh] takes its name."
            )

    def _parameters(self, block: KeywordBlock) -> None:
        """Report parameters that are not known, as CalculiX does; refuse those without a value, which may be data."""
        unknown = unknown_parameters(block.keyword, block.parameters)
        if not all(block.parameters[name] for name in unknown):
            raise block.refuse(
                f"*{block.keyword} has a parameter that is not known. Take it out, or fix its spelling; and end the line without a comma "
                "where data follow."
            )
        if unknown and block.keyword != "SURFACE":  # those of surfaces say nothing of their faces
            self.deck.remarks.append(
                f"{block.place}: *{block.keyword} has a parameter that is not known, and is read without it."
            )

    def end(self) -> None:
        """Refuse a deck that ends within a part."""
        if self.inside:
            raise self.inside[-1].refuse(f"*{self.inside[-1].keyword} has no end. Export the deck again.")
        if unused := sorted(self.deck.leave_out - set(self.deck.dropped)):
            raise InputError(
                f"leave_out names {', '.join(map(repr, unused))}, and the deck {str(self.deck.path)!r} has neither an element type nor a "
                "keyword of this name. Take it out of leave_out, or fix its spelling."
            )

    def nodes(self, block: KeywordBlock) -> None:
        """Read a block *NODE."""
        labels, places = node_rows(block)
        system = block.parameters.get("SYSTEM", "R").strip().upper()
        if system not in ("R", "C"):
            raise block.refuse(
                "coordinates are spherical or of a system that is not known, and only SYSTEM=R and SYSTEM=C are read. Export the nodes in "
                "rectangular coordinates."
            )
        places = from_cylindrical(places) if system == "C" else places
        self.part.add_nodes(labels, places if self.system is None else self.system.applied(places), block)

    def local_system(self, block: KeywordBlock) -> None:
        """Read a block *SYSTEM."""
        self.system = local_system(block)

    def elements(self, block: KeywordBlock) -> None:
        """Read a block *ELEMENT."""
        name = block.parameters.get("TYPE", "").strip().upper()
        if not name:
            raise block.refuse("*ELEMENT needs the parameter TYPE. Add it.")
        found = element_type(name)
        if name in self.deck.leave_out:
            readable = found is not None and found.n_nodes
            self.deck.drop(name, len(element_rows(block, found.n_nodes)) if found and readable else sum(1 for _ in block.lines()))
            self.part.add_to_set("ELSET", np.zeros(0, np.int64), block)
            return
        if found is None:
            raise block.refuse(
                "the element type is none of those that are known. Fix its spelling, or leave it out: leave_out in [mesh]."
            )
        if not found.n_nodes:
            raise refusal_of(block, found, sum(1 for _ in block.lines()))
        if "OFFSET" in block.parameters or "FILE" in block.parameters:
            raise block.refuse("*ELEMENT with OFFSET or FILE is not read. Export the deck with the elements written out.")
        rows = _rows(block, found)
        self.part.add_elements(PartElements(found, rows[:, 0], rows[:, 1:], block))

    def set(self, block: KeywordBlock) -> None:
        """Read a block *NSET or *ELSET."""
        read_set(self.part, block)

    def surface(self, block: KeywordBlock) -> None:
        """Read a block *SURFACE, of which faces of elements and nodes are used."""
        if not block.parameters.get("NAME") or {"COMBINE", "CROP"} & set(block.parameters):
            return
        name = block.parameters["NAME"]
        faces = self.part.surfaces.setdefault(label_of(name), (name_of(name), []))[1]
        of = block.parameters.get("TYPE", "ELEMENT").strip().upper()
        if of == "ELEMENT":
            faces += [Face(row[0], "ELSET", row[1].upper() if row[1:] else "", place) for place, row in block.rows() if row]
        elif of == "NODE":  # an area may follow the nodes
            faces += [Face(row[0], "NSET", "", place) for place, row in block.rows() if row]

    def section(self, block: KeywordBlock) -> None:
        """Read a section of elements."""
        self.deck.sections.append(Property(block, self.part))

    def mass(self, block: KeywordBlock) -> None:
        """Read a block *MASS or *ROTARY INERTIA."""
        self.deck.masses.append(Property(block, self.part))

    def begin_part(self, block: KeywordBlock) -> None:
        """Read *PART."""
        self._begin(block, "PART", within=())
        name = block.parameters["NAME"]
        if label_of(name) in self.deck.parts:
            raise block.refuse("there are two parts of this name. Rename one of them.")
        self.part = self.deck.parts.setdefault(label_of(name), DeckPart(name_of(name)))

    def begin_assembly(self, block: KeywordBlock) -> None:
        """Read *ASSEMBLY."""
        self._begin(block, "ASSEMBLY", within=())
        self.part = self.deck.root

    def begin_instance(self, block: KeywordBlock) -> None:
        """Read *INSTANCE: a copy of its part, to which it may add nodes, elements and sets of its own."""
        self._begin(block, "INSTANCE", within=("ASSEMBLY",))
        if "INSTANCE" in block.parameters:
            raise block.refuse("an instance of another analysis cannot be read. Export the whole model in one deck.")
        of = self.deck.parts.get(label_of(block.parameters.get("PART", "")))
        if of is None:
            raise block.refuse("*INSTANCE names no part that the deck has defined by then. Fix the parameter PART.")
        label = label_of(block.parameters["NAME"])
        if any(each.label == label for each in self.deck.instances):
            raise block.refuse("there are two instances of this name. Rename one of them.")
        self.part = copy_of(of, name_of(block.parameters["NAME"]))
        self.deck.instances.append(Instance(label, self.part, placement(block)))

    def end_of(self, block: KeywordBlock) -> None:
        """Read *END PART, *END ASSEMBLY or *END INSTANCE."""
        what = block.keyword.removeprefix("END ")
        if not self.inside or self.inside[-1].keyword != what:
            raise block.refuse(f"*{block.keyword} stands where no *{what} has begun. Export the deck again.")
        self.inside.pop()
        self.part, self.system = self.deck.root, None

    def _begin(self, block: KeywordBlock, what: str, within: tuple[str, ...]) -> None:
        if tuple(each.keyword for each in self.inside) != within:
            raise block.refuse(f"*{what} stands within another one, or outside of *ASSEMBLY. Export the deck again.")
        if not block.parameters.get("NAME"):
            raise block.refuse(f"*{what} needs the parameter NAME. Add it.")
        self.inside.append(block)
        self.system = None


def copy_of(part: DeckPart, name: str) -> DeckPart:
    """Copy of a part with lists of its own, so that more can be added to it."""
    nodes, elements = (
        {key: Set(each.name, [*each.members], each.sorted) for key, each in of.items()}
        for of in (part.node_sets, part.element_sets)
    )
    surfaces = {key: (spelled, [*faces]) for key, (spelled, faces) in part.surfaces.items()}
    return DeckPart(name, [*part.nodes], [*part.elements], nodes, elements, surfaces, part, part.generated)


def _rows(block: KeywordBlock, found: ElementType) -> np.ndarray:
    """Labels and nodes of elements, without the three nodes of incompatible modes that decks of CalculiX may give C3D8I."""
    try:
        return element_rows(block, found.n_nodes)
    except InputError:
        if found.name != "C3D8I":
            raise
        return element_rows(block, found.n_nodes + 3)[:, : 1 + found.n_nodes]


def refusal_of(block: KeywordBlock, found: ElementType, count: int) -> InputError:
    """Error saying that elements carry what a body of solids cannot take."""
    return block.refuse(
        f"the deck has {count} element{'s' * (count > 1)} of type {found.name} here ({found.words}), which carry mass or stiffness that a "
        f"body of solids or of the plane cannot take. Model them with solids, or leave them out on purpose: leave_out = "
        f'["{found.name}"] in [mesh].'
    )


NEEDED = ("NODE", "ELEMENT", "NSET", "ELSET", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "INSTANCE", "END INSTANCE")
"""Keywords that cannot be left out."""
Handler = Callable[[_Reading, KeywordBlock], None]
TAKEN: dict[str, Handler] = {
    "NODE": _Reading.nodes,
    "ELEMENT": _Reading.elements,
    "NSET": _Reading.set,
    "ELSET": _Reading.set,
    "SURFACE": _Reading.surface,
    "SYSTEM": _Reading.local_system,
    "PART": _Reading.begin_part,
    "END PART": _Reading.end_of,
    "ASSEMBLY": _Reading.begin_assembly,
    "END ASSEMBLY": _Reading.end_of,
    "INSTANCE": _Reading.begin_instance,
    "END INSTANCE": _Reading.end_of,
    "MASS": _Reading.mass,
    "ROTARY INERTIA": _Reading.mass,
    **dict.fromkeys(
        (
            "SOLID SECTION",
            "SHELL SECTION",
            "SHELL GENERAL SECTION",
            "MEMBRANE SECTION",
            "SURFACE SECTION",
            "BEAM SECTION",
            "BEAM GENERAL SECTION",
        ),
        _Reading.section,
    ),
}
"""Keyword -> how it is read."""
