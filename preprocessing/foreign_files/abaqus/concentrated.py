"""Concentrated masses and rotary inertia of a deck, and the nodes that carry them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from preprocessing.foreign_files.abaqus.assembled import Assembled, Numbered, PlacedElements
from preprocessing.foreign_files.abaqus.blocks import Block, label_of
from preprocessing.foreign_files.abaqus.deck import Deck
from preprocessing.foreign_files.abaqus.generated import numbers_of
from preprocessing.foreign_files.abaqus.groups import Groups
from preprocessing.foreign_files.abaqus.numbers import number
from preprocessing.foreign_files.contents import Elements, PointMass


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
    carriers = dict(_carriers(deck, whole, groups))
    return [mass for each in blocks for mass in _masses(deck, whole, each, used, carriers)]


def _masses(
    deck: Deck, whole: Assembled, each: PlacedElements, used: np.ndarray, carriers: dict[int, tuple[np.ndarray, bool]]
) -> Iterator[PointMass]:
    keyword = "MASS" if each.of.type.name == "MASS" else "ROTARY INERTIA"
    for label, (node,) in zip(each.labels.tolist(), each.nodes.tolist(), strict=True):
        block = _property(deck, each, keyword, label)
        values = [number(text, place) for place, row in block.rows() for text in row]
        source = f"{keyword}, line {block.line}"
        nodes, rigid = carriers.get(node, (np.array([node]), True)) if node not in used else (np.array([node]), True)
        place = tuple(whole.points[node].tolist())
        if keyword == "MASS":
            yield PointMass(place, _isotropic(block, values), nodes, rigid=rigid, source=source)
        else:
            yield PointMass(place, 0.0, nodes, _turned(each.instance, [*values, *6 * [0.0]][:6]), rigid, source)


def _property(deck: Deck, each: PlacedElements, keyword: str, label: int) -> Block:
    """The block that says how heavy an element is, the last one of its set."""
    for found in reversed(deck.masses):
        own = found.part.element_sets.get(label_of(found.block.parameters.get("ELSET", "")))
        here = found.block.keyword == keyword and found.part in (each.part, each.part.made_of) and own
        if here and own and label in numbers_of(found.part, "ELSET", own.members):
            for name in ("ORIENTATION", "INPUT"):
                if name in found.block.parameters:
                    raise found.block.refuse(
                        f"*{keyword} with {name} is not read. Give it in the axes of the deck, in its own lines."
                    )
            return found.block
    raise each.of.block.refuse(
        f"element {label} of type {each.of.type.name} has no *{keyword} that says how heavy it is. Add it, or leave the element out: "
        f'leave_out = ["{each.of.type.name}"].'
    )


def _isotropic(block: Block, values: list[float]) -> float:
    if not values or len(set(values)) != 1 or values[0] < 0:
        raise block.refuse(
            "a concentrated mass is one number that is not negative, the same along all axes. Fix it, or leave it out."
        )
    return values[0]


def _turned(numbered: Numbered, values: list[float]) -> tuple[float, ...]:
    """The tensor J of an instance in the axes of the assembly; Abaqus gives J_12 itself, minus the integral of x_1 x_2."""
    xx, yy, zz, xy, xz, yz = values
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if numbered.instance.placement is not None:
        rotation = numbered.instance.placement.rotation
        tensor = rotation @ tensor @ rotation.T
    return tuple(float(tensor[a, b]) for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def _carriers(deck: Deck, whole: Assembled, groups: Groups) -> Iterator[tuple[int, tuple[np.ndarray, bool]]]:
    """Reference nodes of rigid bodies and couplings -> the nodes that they move with, and whether these are rigid."""
    for k, tie in enumerate(deck.ties):
        for each in whole.instances:
            if tie.part in (each.part, each.part.made_of):
                reference = groups.nodes(each, "NSET", tie.block.parameters.get("REF NODE", ""))
                following = deck.ties[k + 1].block.keyword if deck.ties[k + 1 :] else ""
                nodes = np.concatenate([np.zeros(0, np.int64), *(groups.nodes(each, *what) for what in _tied(tie.block))])
                if len(reference) == 1 and len(nodes):
                    yield int(reference[0]), (np.setdiff1d(nodes, reference), following != "DISTRIBUTING")


def _tied(block: Block) -> Iterator[tuple[str, str]]:
    """Kind and name of what a block ties to its reference node."""
    for name, kind in (("NSET", "NSET"), ("TIE NSET", "NSET"), ("PIN NSET", "NSET"), ("SURFACE", "SURFACE"), ("ELSET", "ELSET")):
        if text := block.parameters.get(name):
            yield kind, text
    if block.keyword == "KINEMATIC COUPLING":
        yield from (("NSET", row[0]) for _, row in block.rows() if row)
