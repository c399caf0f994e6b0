"""A deck of Abaqus or CalculiX put together: instances in their places, elements on the nodes, sets as groups."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.assembled import Assembled, Groups, Numbered, PlacedElements, assembled
from preprocessing.foreign_files.abaqus.blocks import KeywordBlock, label_of, number
from preprocessing.foreign_files.abaqus.blocks import whole as whole_number
from preprocessing.foreign_files.abaqus.deck import Deck, Property, read_blocks, refusal_of
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.parts import DeckPart
from preprocessing.foreign_files.abaqus.vocabulary import lie_on_solids
from preprocessing.foreign_files.contents import Elements, LeftOutContent, MeshContents, PointMass
from preprocessing.foreign_files.contents import Elements as Cells

HOW = ("KINEMATIC", "DISTRIBUTING")
"""Keywords that say how the coupling before them ties its nodes."""


def point_masses(deck: Deck, whole: Assembled, cells: Elements, groups: Groups) -> list[PointMass]:
    """Masses and inertias of all elements MASS and ROTARYI.

    Raises
    ------
    InputError
        Such an element has no *MASS or *ROTARY INERTIA, or one that cannot be taken.
    """
    blocks = [each for each in whole.elements if each.of.type.role == "mass"]
    if not blocks:
        return []
    used = np.unique(np.concatenate([nodes.ravel() for _, nodes in cells] or [np.zeros(0, np.int64)]))
    carriers = list(_carriers(deck, whole, groups))
    given = {id(each): _properties(deck, each) for each in whole.instances}
    return [mass for each in blocks for mass in _masses(whole, each, given[id(each.instance)], used, carriers)]


class MassCarriers(NamedTuple):
    """Nodes that a reference node moves with."""

    reference: int  # place among the points
    nodes: np.ndarray
    rigid: bool
    block: KeywordBlock
    plain: bool  # whether all translations are tied, and the reference node stays where it is


def _masses(
    whole: Assembled,
    each: PlacedElements,
    given: dict[tuple[str, int], KeywordBlock],
    used: np.ndarray,
    carriers: list[MassCarriers],
) -> Iterator[PointMass]:
    keyword = "MASS" if each.of.type.name == "MASS" else "ROTARY INERTIA"
    for label, (node,) in zip(each.labels.tolist(), each.nodes.tolist(), strict=True):
        block = _property(given, each, keyword, label)
        values = [number(text, place) for place, row in block.rows() for text in row]
        source = f"{keyword}, line {block.line}"
        ties = [] if node in used else [tie for tie in carriers if tie.reference == node]
        nodes, rigid = _together(ties) if ties else (np.array([node]), True)
        place = tuple(whole.points[node].tolist())
        if keyword == "MASS":
            yield PointMass(place, _isotropic(block, values), nodes, rigid=rigid, source=source)
        else:
            yield PointMass(place, 0.0, nodes, _turned(each.instance, [*values, *6 * [0.0]][:6]), rigid, source)


def _properties(deck: Deck, instance: Numbered) -> dict[tuple[str, int], KeywordBlock]:
    """Block that gives the mass of each element, by keyword and number; the last one that names the element."""
    given: dict[tuple[str, int], KeywordBlock] = {}
    for found in deck.masses:
        own = found.part.element_sets.get(label_of(found.block.parameters.get("ELSET", "")))
        if found.part in (instance.part, instance.part.made_of) and own:
            given.update(
                ((found.block.keyword, label), found.block) for label in numbers_of(found.part, "ELSET", own.members).tolist()
            )
    return given


def _property(given: dict[tuple[str, int], KeywordBlock], each: PlacedElements, keyword: str, label: int) -> KeywordBlock:
    """Block that gives the mass of an element."""
    block = given.get((keyword, label))
    if block is None:
        raise each.of.block.refuse(
            f"element {label} of type {each.of.type.name} has no *{keyword} that says how heavy it is. Add it, or leave the element out: "
            f'leave_out = ["{each.of.type.name}"].'
        )
    for name in ("ORIENTATION", "INPUT"):
        if name in block.parameters:
            raise block.refuse(f"*{keyword} with {name} is not read. Give it in the axes of the deck, in its own lines.")
    return block


def _isotropic(block: KeywordBlock, values: list[float]) -> float:
    if not values or len(set(values)) != 1 or values[0] < 0:
        raise block.refuse(
            "a concentrated mass is one number that is not negative, the same along all axes. Fix it, or leave it out."
        )
    return values[0]


def _turned(numbered: Numbered, values: list[float]) -> tuple[float, ...]:
    """Inertia tensor J of an instance in the axes of the assembly.

    Abaqus gives J_12 itself, minus the integral of x_1 x_2.
    """
    xx, yy, zz, xy, xz, yz = values
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if numbered.instance.placement is not None:
        rotation = numbered.instance.placement.rotation
        tensor = rotation @ tensor @ rotation.T
    return tuple(float(tensor[a, b]) for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def _together(ties: list[MassCarriers]) -> tuple[np.ndarray, bool]:
    """Nodes that carry a mass on the reference node of these ties, and whether they are rigid.

    Raises
    ------
    InputError
        A tie leaves the mass free in some direction or moves its node, or several tie it of which one follows a mean.
    """
    for tie in ties:
        if not tie.plain or (len(ties) > 1 and not tie.rigid):
            raise tie.block.refuse(
                f"a concentrated mass is on the reference node of *{tie.block.keyword}, which leaves translations free or moves that node, "
                "or is one of several of which one follows a mean. Tie the mass by one coupling of all translations, or leave it out: "
                'leave_out = ["MASS"] in [mesh].'
            )
    return np.unique(np.concatenate([tie.nodes for tie in ties])), ties[0].rigid


def _carriers(deck: Deck, whole: Assembled, groups: Groups) -> Iterator[MassCarriers]:
    """Reference nodes of rigid bodies and couplings, and the nodes that they move with."""
    for k, tie in enumerate(deck.ties):
        how = deck.ties[k + 1].block if deck.ties[k + 1 :] and deck.ties[k + 1].block.keyword in HOW else tie.block
        for each in whole.instances:
            if tie.part in (each.part, each.part.made_of):
                reference = groups.nodes(each, "NSET", tie.block.parameters.get("REF NODE", ""))
                nodes = np.concatenate([np.zeros(0, np.int64), *(groups.nodes(each, *what) for what in _tied(tie.block))])
                if len(reference) == 1 and len(nodes):
                    plain = _holds(how) and not tie.block.parameters.get("POSITION", "").upper().startswith("CENTER")
                    rigid = how.keyword != "DISTRIBUTING"
                    yield MassCarriers(int(reference[0]), np.setdiff1d(nodes, reference), rigid, tie.block, plain)


def _holds(block: KeywordBlock) -> bool:
    """Whether the lines of a kinematic coupling, which may give first and last degrees of freedom, tie all translations."""
    first = {"KINEMATIC": 0, "KINEMATIC COUPLING": 1}.get(block.keyword)
    if first is None:
        return True
    spans = [[whole_number(text, place) for text in row[first:] if text] for place, row in block.rows()]
    tied = {k for span in spans for k in range(span[0], span[-1] + 1)} if all(spans) else {1, 2, 3}
    return not spans or tied >= {1, 2, 3}


def _tied(block: KeywordBlock) -> Iterator[tuple[str, str]]:
    """Kind and name of the set or surface that a block ties to its reference node."""
    for name, kind in (("NSET", "NSET"), ("TIE NSET", "NSET"), ("PIN NSET", "NSET"), ("SURFACE", "SURFACE"), ("ELSET", "ELSET")):
        if text := block.parameters.get(name):
            yield kind, text
    if block.keyword == "KINEMATIC COUPLING":
        yield from (("NSET", row[0]) for _, row in block.rows() if row)


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
    left_out = [LeftOutContent(name, number, "as leave_out says") for name, number in deck.dropped.items()]
    left_out += [LeftOutContent(name, number, ONLY_NAMES) for name, number in named.items()]
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


def _sections(deck: Deck, part: DeckPart) -> Iterator[Property]:
    return (each for each in deck.sections if each.part in (part, part.made_of))


def _ties(deck: Deck) -> list[LeftOutContent]:
    """Ties of the analysis, by keyword."""
    names = [each.block.keyword for each in deck.ties]
    return [LeftOutContent(name, names.count(name), ANALYSIS) for name in dict.fromkeys(names)]


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
