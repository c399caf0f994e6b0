"""Nodes: the cards GRID with the defaults of GRDSET, and the coordinate systems that their places are given in.

Coordinate systems of nodes and masses: CORD1R, CORD1C, CORD1S by three nodes, CORD2R, CORD2C, CORD2S by three points.

Of the three A is the origin, B lies on the z axis, C in the half plane of x and z. Cylindrical coordinates are r, theta, z; spherical ones
are r, theta from the z axis, phi about it; angles are in degrees.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import LeftOutContent
from preprocessing.foreign_files.nastran.cards import Cards, CardTable
from preprocessing.foreign_files.nastran.lines import SYSTEMS
from toolkit.foundation.errors import InputError

DEGENERATE = 1e-10
"""Sine of the angle between A-B and A-C below which they define no plane."""


class CoordinateSystem(NamedTuple):
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


BASIC = CoordinateSystem("R", np.zeros(3), np.eye(3))


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
        table = CardTable(name, cards.by_name[name], 11, cards.lines)
        numbers, reference, points = table.whole(0), table.whole(1, blank=0), table.real(2, 11, blank=0.0).reshape(-1, 3, 3)
        for k, number in enumerate(numbers.tolist()):
            yield Definition(number, name[-1], (), int(reference[k]), points[k], table.place(k))
        return
    table = CardTable(name, cards.by_name[name], 8, cards.lines)
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


def system_of(each: Definition, known: Mapping[int, CoordinateSystem], nodes: Sequence[np.ndarray | None]) -> CoordinateSystem:
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
    return CoordinateSystem(each.kind, a, np.column_stack([np.cross(y, z), y, z]))


FLUID = -1
"""The displacement system of nodes that belong to a fluid."""


@dataclass(frozen=True)
class Grid:
    """Nodes in the order of the file, and the wanted coordinate systems."""

    labels: np.ndarray  # (n,)
    points: np.ndarray  # (n, 3) in the basic system
    systems: dict[int, CoordinateSystem]
    order: np.ndarray  # places of the labels in rising order
    held: int  # nodes with constraints of their own

    def places(self, labels: np.ndarray) -> np.ndarray:
        """Places of nodes among the points; -1 where there is no such node."""
        if not len(self.labels):
            return np.full(labels.shape, -1)
        rising = self.labels[self.order]
        at = np.minimum(np.searchsorted(rising, labels), len(rising) - 1)
        return np.where(rising[at] == labels, self.order[at], -1)

    def left_out(self) -> list[LeftOutContent]:
        """Constraints of the nodes, which are not taken."""
        why = "nodes that the file holds by themselves (field PS); constraints are the clamp of body.toml"
        return [LeftOutContent("GRID", self.held, why)] if self.held else []


class _Given(NamedTuple):
    """Nodes as their cards give them."""

    labels: np.ndarray
    system: np.ndarray
    coordinates: np.ndarray
    held: np.ndarray
    rows: np.ndarray  # of the table


def grid_of(cards: Cards, systems: Iterable[int]) -> Grid:
    """All nodes, and these coordinate systems besides those that nodes need.

    Raises
    ------
    InputError
        A node is there twice at two places, or in a fluid; a coordinate system is missing, degenerate or rests on itself.
    """
    table = CardTable("GRID", cards.by_name.get("GRID", []), 8, cards.lines)
    given = _once(table, _given(cards, table))
    order = np.argsort(given.labels, kind="stable")
    grid = Grid(given.labels, np.zeros((len(order), 3)), {0: BASIC}, order, int(given.held.sum()))
    definitions = by_number(cards)
    wanted = {int(k) for k in np.unique(given.system)}
    for number in wanted - {0} - set(definitions):
        row = int(given.rows[np.argmax(given.system == number)])
        raise table.error(
            row, f"GRID lies in coordinate system {number} (field 3, or GRDSET), and no CORD card defines it. Add it."
        )

    def node(label: int) -> int:
        return int(grid.places(np.array([label]))[0])

    for definition in in_order(
        definitions, wanted | set(systems), lambda label: int(given.system[k]) if (k := node(label)) >= 0 else 0
    ):
        places = [
            grid.systems[int(given.system[k])].places(given.coordinates[k]) if k >= 0 else None
            for k in map(node, definition.nodes)
        ]
        grid.systems[definition.number] = system_of(definition, grid.systems, places)
    for number in wanted:
        here = given.system == number
        grid.points[here] = grid.systems[number].places(given.coordinates[here])
    return grid


def _given(cards: Cards, table: CardTable) -> _Given:
    default_system, default_motion, default_held = _defaults(cards)
    system, motion = table.whole(1, blank=0), table.whole(5, blank=0)
    system = np.where(table.blank(1), default_system, system)
    motion = np.where(table.blank(5), default_motion, motion)
    held = np.where(table.blank(6), default_held, table.whole(6, blank=0)) != 0
    labels = table.whole(0)
    for wrong, what in (
        (labels < 1, "GRID has a number below 1. Number nodes from 1"),
        (motion == FLUID, "GRID is a node of a fluid"),
    ):
        if wrong.any():
            raise table.error(int(np.argmax(wrong)), f"{what}; solids and plane bodies are read.")
    return _Given(labels, system, table.real(2, 5, blank=0.0), held, np.arange(len(labels)))


def _defaults(cards: Cards) -> tuple[int, int, int]:
    """Coordinate system, system of displacements and constraints of nodes that give none."""
    table = CardTable("GRDSET", cards.by_name.get("GRDSET", []), 8, cards.lines)
    if len(table) > 1:
        raise table.error(1, "there are two GRDSET, and defaults are given once. Take one out.")
    return (0, 0, 0) if not len(table) else tuple(int(table.whole(k, blank=0)[0]) for k in (1, 5, 6))  # type: ignore[return-value]


def _once(table: CardTable, given: _Given) -> _Given:
    """Nodes without copies: a copy at the same place counts for nothing.

    Raises
    ------
    InputError
        A copy is at another place.
    """
    _, first, which = np.unique(given.labels, return_index=True, return_inverse=True)
    if len(first) == len(given.labels):
        return given
    same = (given.system == given.system[first][which]) & (given.coordinates == given.coordinates[first][which]).all(axis=1)
    if not same.all():
        row = int(np.argmin(same))
        place = table.place(int(first[which[row]]))
        raise table.error(row, f"GRID {given.labels[row]} is at another place than in {place}. Take one of them out.")
    keep = np.sort(first)
    return _Given(*(each[keep] for each in given))


def refuse_missing(table: CardTable, labels: np.ndarray, places: np.ndarray) -> None:
    """Refuse cards with nodes that are not in the file."""
    if (places < 0).any():
        row, column = (int(k) for k in np.argwhere(places < 0)[0])
        raise table.error(
            row, f"{table.name} has node {labels[row, column]}, and no GRID defines it. Add it, or the file that has it."
        )
