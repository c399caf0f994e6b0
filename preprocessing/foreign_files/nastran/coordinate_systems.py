"""Coordinate systems of nodes and masses: CORD1R, CORD1C, CORD1S by three nodes, CORD2R, CORD2C, CORD2S by three points.

Of the three A is the origin, B lies on the z axis, C in the half plane of x and z. Cylindrical coordinates are r, theta, z; spherical ones
are r, theta from the z axis, phi about it; angles are in degrees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.nastran.cards import Cards, Table
from preprocessing.foreign_files.nastran.vocabulary import SYSTEMS
from toolkit.foundation.errors import InputError

DEGENERATE = 1e-10
"""Sine of the angle between A-B and A-C below which they define no plane."""


class System(NamedTuple):
    """Coordinate system, given in the basic one."""

    kind: str  # R, C or S
    origin: np.ndarray  # (3,)
    axes: np.ndarray  # (3, 3), columns are the unit vectors of x, y and z

    def places(self, coordinates: np.ndarray) -> np.ndarray:
        """Places (..., 3) in the basic system, from coordinates in this one."""
        a, b, c = np.moveaxis(coordinates, -1, 0)
        if self.kind == "C":
            a, b = a * np.cos(np.radians(b)), a * np.sin(np.radians(b))
        elif self.kind == "S":
            polar, around = np.radians(b), np.radians(c)
            a, b, c = a * np.sin(polar) * np.cos(around), a * np.sin(polar) * np.sin(around), a * np.cos(polar)
        own = np.stack([a, b, c], axis=-1)
        return self.origin + (own[..., None, :] * self.axes).sum(axis=-1)


BASIC = System("R", np.zeros(3), np.eye(3))


class Definition(NamedTuple):
    """Definition of a coordinate system by a card."""

    number: int
    kind: str
    nodes: tuple[int, ...]  # A, B, C of CORD1; none of CORD2
    reference: int  # system of the points of CORD2
    points: np.ndarray  # (3, 3)
    place: str  # of the card, in words

    def same(self, other: Definition) -> bool:
        """Whether two definitions say the same."""
        return self[1:4] == other[1:4] and bool((self.points == other.points).all())


def by_number(cards: Cards) -> dict[int, Definition]:
    """All systems that cards define.

    Raises
    ------
    InputError
        Two cards define one number in different ways.
    """
    found: dict[int, Definition] = {}
    for each in (each for name in SYSTEMS if name in cards.by_name for each in _definitions(name, cards)):
        if each.number < 1 or not found.setdefault(each.number, each).same(each):
            raise InputError(
                f"{each.place}: coordinate system {each.number} is defined twice, or is below 1. Give it a number of its own."
            )
    return found


def _definitions(name: str, cards: Cards) -> Iterator[Definition]:
    if name.startswith("CORD2"):
        table = Table(name, cards.by_name[name], 11, cards.lines)
        numbers, reference, points = table.whole(0), table.whole(1, blank=0), table.real(2, 11, blank=0.0).reshape(-1, 3, 3)
        for k, number in enumerate(numbers.tolist()):
            yield Definition(number, name[-1], (), int(reference[k]), points[k], table.place(k))
        return
    table = Table(name, cards.by_name[name], 8, cards.lines)
    for row, (first, second) in enumerate(zip(table.whole(0, 4).tolist(), table.whole(4, 8, blank=0).tolist(), strict=True)):
        for number, *nodes in (first, second) if any(second) else (first,):
            yield Definition(number, name[-1], tuple(nodes), 0, np.zeros((3, 3)), table.place(row))


def in_order(given: Mapping[int, Definition], wanted: set[int], system_of_node: Callable[[int], int]) -> list[Definition]:
    """Wanted coordinate systems and those that they rest on, each behind what it rests on.

    Raises
    ------
    InputError
        One of them rests on itself, or on one that is not defined.
    """
    graph: dict[int, set[int]] = {}
    left = sorted(wanted & set(given))
    while left:
        each = given[left.pop()]
        on = {system_of_node(node) for node in each.nodes} if each.nodes else {each.reference}
        graph[each.number] = on - {0}
        for number in sorted(on - {0} - set(graph)):
            if number not in given:
                raise InputError(f"{each.place}: it rests on coordinate system {number}, which no CORD card defines. Add it.")
            left.append(number)
    try:
        return [given[number] for number in TopologicalSorter(graph).static_order()]
    except CycleError as error:
        numbers = ", ".join(map(str, error.args[1]))
        raise InputError(
            f"{given[error.args[1][0]].place}: coordinate systems {numbers} rest on each other. Define one without."
        ) from error


def system_of(each: Definition, known: Mapping[int, System], nodes: Sequence[np.ndarray | None]) -> System:
    """The system that a card defines by points in a known one, or by nodes whose places are these.

    Raises
    ------
    InputError
        The points lie on one line, or a node is missing.
    """
    if any(place is None for place in nodes):
        raise InputError(f"{each.place}: the coordinate system has a node that no GRID defines. Add it.")
    a, b, c = [np.asarray(place) for place in nodes] if each.nodes else known[each.reference].places(each.points)
    z, plane = b - a, c - a
    y = np.cross(z, plane)
    if not np.linalg.norm(y) > DEGENERATE * np.linalg.norm(z) * np.linalg.norm(plane):
        raise InputError(f"{each.place}: the three points of coordinate system {each.number} lie on one line. Move one of them.")
    z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
    return System(each.kind, a, np.column_stack([np.cross(y, z), y, z]))
