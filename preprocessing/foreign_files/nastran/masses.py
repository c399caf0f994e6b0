"""Concentrated masses, and the rigid elements that carry them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import PointMass
from preprocessing.foreign_files.nastran.cards import Cards, CardTable
from preprocessing.foreign_files.nastran.grid import Grid
from preprocessing.foreign_files.nastran.lines import one_number
from toolkit.foundation.errors import InputError

NUMBER, WEIGHT = re.compile(r"\d+"), re.compile(r"[+-]?(\d+\.\d*|\.\d+)([ED]?[+-]?\d+)?")
ENDS = ("UM", "ALPHA", "THERM", "TREF")
"""Words behind which a card has no more nodes that it ties."""


class RigidTie(NamedTuple):
    """Rigid element."""

    name: str
    place: str  # of the card, in words
    nodes: tuple[int, ...]  # labels of all its nodes; RBE3: those that the reference node follows
    reference: int  # RBE3: the node that follows; RBE2: the one that leads
    holds: bool  # whether all translations are tied, and weights are equal


class RigidCarriers(NamedTuple):
    """Nodes of the body that a mass moves with."""

    nodes: np.ndarray  # places among the points
    rigid: bool  # see `PointMass`
    by: str  # name of the card that ties it to them; empty for its own node


def carriers_of(label: int, ties: Callable[[], Sequence[RigidTie]], grid: Grid, in_body: np.ndarray, place: str) -> RigidCarriers:
    """The nodes of the body that carry a mass on a node: itself, or those that one rigid element ties it to.

    Parameters
    ----------
    ties : gives all rigid elements, and is called only if the node is not one of the body

    Raises
    ------
    InputError
        There are none, or several elements tie it.
    """
    own = grid.places(np.array([label]))
    if own[0] < 0:
        raise InputError(f"{place}: the mass is on node {label}, and no GRID defines it. Add it.")
    if in_body[own[0]]:
        return RigidCarriers(own, True, "")
    found = [tie for tie in ties() if label == tie.reference or (tie.name != "RBE3" and label in tie.nodes)]
    if len(found) != 1 or not found[0].holds:
        several = f"{len(found)} rigid elements tie it to others"
        why = several if len(found) != 1 else f"{found[0].name} ties it, but leaves translations free or weighs its nodes"
        raise InputError(
            f"{place}: the mass is on node {label}, which has no element of the body, and {why}. Put it on a node of the body, tie it "
            'by one RBE2, or by one RBE3 with equal weights, or leave it out: leave_out = ["CONM2"] in [mesh].'
        )
    return _carriers(found[0], label, grid, in_body)


def _carriers(tie: RigidTie, label: int, grid: Grid, in_body: np.ndarray) -> RigidCarriers:
    places = grid.places(np.array([node for node in dict.fromkeys((*tie.nodes, tie.reference)) if node != label], np.int64))
    inside = (places >= 0) & in_body[places]
    if not inside.any() or (tie.name == "RBE3" and not inside.all()):
        raise InputError(
            f"{tie.place}: {tie.name} ties a mass to nodes that no element of the body has. Tie it to nodes of the body."
        )
    return RigidCarriers(places[inside], tie.name != "RBE3", tie.name)


def ties_of(cards: Cards) -> Iterator[RigidTie]:
    """All rigid elements that may carry a mass."""
    for name, read in (("RBE2", _rbe2), ("RBAR", _rbar), ("RBE3", _rbe3)):
        for card in cards.by_name.get(name, []):
            try:
                if card.excess:
                    raise ValueError
                yield read(name, cards.lines.place(card.line), card.words())
            except (ValueError, IndexError) as error:
                what = f"{name} is not read as it is written, and a mass may hang on it. Write its nodes one by one"
                raise cards.lines.error(card.line, f"{what}, as whole numbers.") from error


def _rbe2(name: str, place: str, words: list[str]) -> RigidTie:
    nodes = [each for each in words[3:] if each]
    if nodes and WEIGHT.fullmatch(nodes[-1]):  # coefficient of thermal expansion
        nodes = nodes[:-1]
    return RigidTie(name, place, tuple(map(_number, nodes)), _number(words[1]), _translations(words[2]))


def _rbar(name: str, place: str, words: list[str]) -> RigidTie:
    one, other = _number(words[1]), _number(words[2])
    free = words[3:5] + [""] * (2 - len(words[3:5]))
    return RigidTie(name, place, (one, other), one, any(set(each) >= set("123456") for each in free))


def _rbe3(name: str, place: str, words: list[str]) -> RigidTie:
    nodes: list[int] = []
    weights: set[float] = set()
    holds = _translations(words[3])
    left = [each for each in words[4:] if each]
    if not left or not WEIGHT.fullmatch(left[0]):
        raise ValueError("no weight")
    while left and left[0] not in ENDS:
        if WEIGHT.fullmatch(left[0]):
            weights.add(one_number(left[0]))
            holds = holds and _translations(left[1])
            left = left[2:]
        nodes.append(_number(left.pop(0)))
    return RigidTie(name, place, tuple(nodes), _number(words[2]), holds and len(weights) == 1)


def _number(text: str) -> int:
    if not NUMBER.fullmatch(text) or len(text) > 18:
        raise ValueError("no whole number")
    return int(text)


def _translations(components: str) -> bool:
    """Whether the three translations are among the components."""
    if not NUMBER.fullmatch(components):
        raise ValueError("no components")
    return set(components) >= set("123")


BASIC_PLACE = -1
"""The coordinate system of a CONM2 whose centre is given as a place in the basic system, and not as an offset."""
MASSES = ("CONM1", "CONM2")
LOWER = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
"""Rows and columns of a symmetric matrix in the order of the cards, which give its lower triangle."""


class Given(NamedTuple):
    """Mass as its card gives it, in its coordinate system."""

    table: CardTable
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
        CardTable(name, cards.by_name[name], 14 if name == "CONM2" else 24, cards.lines)
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


def _conm2(table: CardTable) -> Iterator[Given]:
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


def _conm1(table: CardTable) -> Iterator[Given]:
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
    ties: list[RigidTie] = []

    def all_ties() -> list[RigidTie]:
        if not ties:
            ties.extend(ties_of(cards))
        return ties

    return [_placed(each, all_ties, grid, in_body, factor) for each in masses if each.mass or each.inertia.any()]


def _placed(each: Given, ties: Callable[[], Sequence[RigidTie]], grid: Grid, in_body: np.ndarray, factor: float) -> PointMass:
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
