"""A deck of Abaqus or CalculiX put together: instances in their places, elements on the nodes, sets as groups."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.abaqus.assembled import Assembled, PlacedElements, assembled
from preprocessing.foreign_files.abaqus.blocks import label_of
from preprocessing.foreign_files.abaqus.concentrated import point_masses
from preprocessing.foreign_files.abaqus.deck import Deck, Property, read_blocks, refusal_of
from preprocessing.foreign_files.abaqus.faces import lie_on_solids
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.groups import Groups
from preprocessing.foreign_files.abaqus.parts import Part
from preprocessing.foreign_files.contents import Elements as Cells
from preprocessing.foreign_files.contents import LeftOut, MeshContents

ANALYSIS = "it belongs to the analysis; the body is clamped and tied as [clamp] and [interface_points] say"
ONLY_NAMES = "they have no section and lie on solids: they name groups and are not part of the body"


def read_deck(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """The contents of an input deck.

    Parameters
    ----------
    path : the deck; what it includes is sought from its folder, or from that of the file which includes it
    leave_out : element types and keywords that are not to be part of the body, in capitals

    Raises
    ------
    InputError
        The deck cannot be read, or holds something that carries mass or stiffness and cannot be taken; says in which line.
    """
    deck = read_blocks(path, leave_out)
    whole = assembled(deck)
    cells, named = _roles(deck, whole)
    left_out = [LeftOut(name, number, "as leave_out says") for name, number in deck.dropped.items()]
    left_out += [LeftOut(name, number, ONLY_NAMES) for name, number in named.items()]
    groups = Groups(whole)
    every = groups.every()
    masses = point_masses(deck, whole, cells, groups)
    return MeshContents(whole.points, cells, every, whole.labels, masses, [*left_out, *_ties(deck)], [*_remarks(deck, whole)])


def _roles(deck: Deck, whole: Assembled) -> tuple[Cells, dict[str, int]]:
    """Elements of the body by kind, and number of elements of each type that only name faces and edges.

    Raises
    ------
    InputError
        Shells, membranes or bars carry mass and stiffness beside the body.
    """
    solids = [(each.of.type.kind, each.nodes) for each in whole.elements if each.of.type.role == "solid"]
    cells, named = Cells(), dict[str, int]()
    for each in whole.elements:
        found = each.of.type
        if found.role == "mass":
            continue
        if found.role == "shape" and deck.sections:
            raise refusal_of(each.of.block, found, len(each.nodes))
        lower = found.role != "solid" if solids else found.kind.startswith("line")
        if lower:
            _refuse_carriers(deck, each, solids)
            named[found.name] = named.get(found.name, 0) + len(each.nodes)
        cells.append((found.kind, each.nodes))
    return cells, named


def _refuse_carriers(deck: Deck, each: PlacedElements, solids: Cells) -> None:
    """Refuse elements of lower dimension that have a section, or lie elsewhere than on solids."""
    with_section = np.zeros(len(each.labels), bool)
    for section in _sections(deck, each.part):
        own = section.part.element_sets.get(label_of(section.block.parameters.get("ELSET", "")))
        if own:
            with_section |= np.isin(each.labels, numbers_of(section.part, "ELSET", own.members))
    apart = ~lie_on_solids(each.of.type.kind, each.nodes, solids) if solids else np.zeros(len(each.labels), bool)
    if np.any(carrying := with_section | apart):
        raise refusal_of(each.of.block, each.of.type, int(carrying.sum()))


def _sections(deck: Deck, part: Part) -> Iterator[Property]:
    return (each for each in deck.sections if each.part in (part, part.made_of))


def _ties(deck: Deck) -> list[LeftOut]:
    """Ties of the analysis, by keyword."""
    names = [each.block.keyword for each in deck.ties]
    return [LeftOut(name, names.count(name), ANALYSIS) for name in dict.fromkeys(names)]


def _remarks(deck: Deck, whole: Assembled) -> Iterator[str]:
    """Remarks on the reading that the user should know."""
    yield from whole.remarks
    solid = [each for each in deck.sections if each.block.keyword == "SOLID SECTION"]
    materials = {label_of(each.block.parameters.get("MATERIAL", "")) for each in solid} - {""}
    if len(materials) > 1:
        yield f"the deck gives its solids {len(materials)} materials; the body has that of [material] everywhere."
    types = {each.of.type.name for each in whole.elements}
    if any(name.startswith("CPE") for name in types) and not any(name.startswith("C3D") for name in types):
        yield "the elements of the deck are of plane strain (CPE): the body is of plane stress unless state in [material] says otherwise."
    if any(each.of.type.role == "skin" for each in whole.elements) and not any(name.startswith("C3D") for name in types):
        yield "the shells or membranes of the deck are taken as a plate that moves in its plane only."
