"""Concentrated masses: CONM2, and CONM1 where its matrix is that of one mass with rotary inertia at the node."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import PointMass
from preprocessing.foreign_files.nastran.cards import Cards, Table
from preprocessing.foreign_files.nastran.grid import Grid
from preprocessing.foreign_files.nastran.ties import Tie, carriers_of, ties_of

BASIC_PLACE = -1
"""The coordinate system of a CONM2 whose centre is given as a place in the basic system, and not as an offset."""
MASSES = ("CONM1", "CONM2")
LOWER = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
"""Rows and columns of a symmetric matrix in the order of the cards, which give its lower triangle."""


class Given(NamedTuple):
    """Mass as its card gives it, in its coordinate system."""

    table: Table
    row: int
    label: int
    node: int
    system: int
    mass: float
    centre: np.ndarray  # (3,)
    inertia: np.ndarray  # (3, 3) tensor about the centre


def given_masses(cards: Cards, leave_out: frozenset[str]) -> list[Given]:
    """All masses but those that are to be left out.

    Raises
    ------
    InputError
        A mass is negative or there twice, or the matrix of a CONM1 is that of no single mass.
    """
    readers = {"CONM1": _conm1, "CONM2": _conm2}
    tables = [
        Table(name, cards.by_name[name], 14 if name == "CONM2" else 24, cards.lines)
        for name in MASSES
        if name in cards.by_name and name not in leave_out
    ]
    found = [each for table in tables for each in readers[table.name](table)]
    seen: dict[int, Given] = {}
    for each in found:
        if each.mass < 0 or (np.linalg.eigvalsh(each.inertia) < -1e-6 * np.abs(each.inertia).max(initial=0)).any():
            raise each.table.error(
                each.row, f"{each.table.name} has a negative mass or moment of inertia. Give a mass as it can be."
            )
        if seen.setdefault(each.label, each) is not each:
            raise each.table.error(each.row, f"mass {each.label} is there twice. Take one out, or give it another number.")
    return found


def _conm2(table: Table) -> Iterator[Given]:
    """Masses of CONM2 cards.

    A card's products of inertia count as integrals of x y, so that the tensor has them with the other sign.
    """
    label, node, system, mass = table.whole(0), table.whole(1), table.whole(2, blank=0), table.real(3, blank=0.0)
    centre, parts = table.real(4, 7, blank=0.0), table.real(8, 14, blank=0.0)
    for k in range(len(table)):
        inertia = _symmetric(parts[k])
        yield Given(
            table,
            k,
            int(label[k]),
            int(node[k]),
            int(system[k]),
            float(mass[k]),
            centre[k],
            2 * np.diag(np.diag(inertia)) - inertia,
        )


def _conm1(table: Table) -> Iterator[Given]:
    label, node, system, parts = table.whole(0), table.whole(1), table.whole(2, blank=0), table.real(3, 24, blank=0.0)
    for k in range(len(table)):
        matrix = np.zeros((6, 6))
        matrix[np.tril_indices(6)] = parts[k]
        mass = matrix[0, 0]
        if not (matrix[:3, :3] == mass * np.eye(3)).all() or matrix[3:, :3].any():
            raise table.error(
                k,
                "CONM1 has a mass that differs by direction, or is not at its node, and a mass is one number here, with a rotary inertia. "
                'Write it as CONM2, or leave it out: leave_out = ["CONM1"] in [mesh].',
            )
        turning = np.tril(matrix[3:, 3:])
        yield Given(
            table, k, int(label[k]), int(node[k]), int(system[k]), float(mass), np.zeros(3), turning + np.tril(turning, -1).T
        )


def _symmetric(parts: np.ndarray) -> np.ndarray:
    found = np.zeros((3, 3))
    for value, (row, column) in zip(parts, LOWER, strict=True):
        found[row, column] = found[column, row] = value
    return found


def systems_of(masses: list[Given]) -> set[int]:
    """Coordinate systems that masses are given in."""
    return {each.system for each in masses} - {BASIC_PLACE}


def point_masses(masses: list[Given], cards: Cards, grid: Grid, in_body: np.ndarray, factor: float) -> list[PointMass]:
    """Masses at their places in the basic system, times a factor, on the nodes of the body that carry them.

    Raises
    ------
    InputError
        A mass hangs on no node of the body, or its coordinate system is missing or has no directions of its own.
    """
    ties: list[Tie] = []

    def all_ties() -> list[Tie]:
        if not ties:
            ties.extend(ties_of(cards))
        return ties

    return [_placed(each, all_ties, grid, in_body, factor) for each in masses if each.mass or each.inertia.any()]


def _placed(each: Given, ties: Callable[[], Sequence[Tie]], grid: Grid, in_body: np.ndarray, factor: float) -> PointMass:
    name, place = each.table.name, each.table.place(each.row)
    carriers = carriers_of(each.node, ties, grid, in_body, place)
    node = grid.points[grid.places(np.array([each.node]))[0]]
    basic = each.system == BASIC_PLACE and name == "CONM2"
    if not basic and each.system not in grid.systems:
        raise each.table.error(
            each.row, f"{name} is given in coordinate system {each.system}, and no CORD card defines it. Add it."
        )
    system = grid.systems[0 if basic else each.system]
    isotropic = (each.inertia == each.inertia[0, 0] * np.eye(3)).all()
    if system.kind != "R" and (each.centre.any() or not isotropic):
        raise each.table.error(
            each.row, f"{name} has an offset or inertia in a cylindrical or spherical system. Give them in a rectangular one."
        )
    inertia = factor * (system.axes @ each.inertia @ system.axes.T if system.kind == "R" else each.inertia)
    centre = each.centre if basic else node + system.axes @ each.centre
    values = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    source = f"{name}, {place}" + (f", by {carriers.by}" if carriers.by else "")
    return PointMass(
        tuple(centre.tolist()), factor * each.mass, carriers.nodes, tuple(map(float, values)), carriers.rigid, source
    )
