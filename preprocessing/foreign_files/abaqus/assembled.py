"""Instances put together: one list of points, and the elements of all instances on them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.abaqus.deck import Deck, Instance
from preprocessing.foreign_files.abaqus.lookup import Lookup, last_of, rises
from preprocessing.foreign_files.abaqus.parts import Elements, Part
from toolkit.foundation.errors import InputError


class PlacedElements(NamedTuple):
    """Elements of one block in one instance."""

    of: Elements
    instance: Numbered
    labels: np.ndarray  # (n_e,)
    nodes: np.ndarray  # (n_e, n_nodes) places among the points

    @property
    def part(self) -> Part:
        """Part that the elements belong to."""
        return self.instance.part


@dataclass(eq=False)
class Numbered:
    """Instance with the places of its nodes among the points."""

    label: str
    part: Part
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


def _on_points(numbered: Numbered, each: Elements, labels: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Nodes of elements as places among the points."""
    found = numbered.places_of(nodes)
    if found.min() < 0:
        row = int(np.flatnonzero((found < 0).any(axis=1))[0])
        wrong = nodes[row][found[row] < 0][0]
        raise each.block.refuse(f"element {labels[row]} names node {wrong}, which the deck does not have. Export it again.")
    return found
