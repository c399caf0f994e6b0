"""Nodes: the cards GRID with the defaults of GRDSET, and the coordinate systems that their places are given in."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import LeftOut
from preprocessing.foreign_files.nastran.cards import Cards, Table
from preprocessing.foreign_files.nastran.coordinate_systems import BASIC, System, by_number, in_order, system_of

FLUID = -1
"""The displacement system of nodes that belong to a fluid."""


@dataclass(frozen=True)
class Grid:
    """Nodes in the order of the file, and the wanted coordinate systems."""

    labels: np.ndarray  # (n,)
    points: np.ndarray  # (n, 3) in the basic system
    systems: dict[int, System]
    order: np.ndarray  # places of the labels in rising order
    held: int  # nodes with constraints of their own

    def places(self, labels: np.ndarray) -> np.ndarray:
        """Places of nodes among the points; -1 where there is no such node."""
        if not len(self.labels):
            return np.full(labels.shape, -1)
        rising = self.labels[self.order]
        at = np.minimum(np.searchsorted(rising, labels), len(rising) - 1)
        return np.where(rising[at] == labels, self.order[at], -1)

    def left_out(self) -> list[LeftOut]:
        """Constraints of the nodes, which are not taken."""
        why = "nodes that the file holds by themselves (field PS); constraints are the clamp of body.toml"
        return [LeftOut("GRID", self.held, why)] if self.held else []


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
    table = Table("GRID", cards.by_name.get("GRID", []), 8, cards.lines)
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


def _given(cards: Cards, table: Table) -> _Given:
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
    table = Table("GRDSET", cards.by_name.get("GRDSET", []), 8, cards.lines)
    if len(table) > 1:
        raise table.error(1, "there are two GRDSET, and defaults are given once. Take one out.")
    return (0, 0, 0) if not len(table) else tuple(int(table.whole(k, blank=0)[0]) for k in (1, 5, 6))  # type: ignore[return-value]


def _once(table: Table, given: _Given) -> _Given:
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


def refuse_missing(table: Table, labels: np.ndarray, places: np.ndarray) -> None:
    """Refuse cards with nodes that are not in the file."""
    if (places < 0).any():
        row, column = (int(k) for k in np.argwhere(places < 0)[0])
        raise table.error(
            row, f"{table.name} has node {labels[row, column]}, and no GRID defines it. Add it, or the file that has it."
        )
