"""Rigid elements that carry a mass: RBE2 and RBAR, by which a node moves with others, and RBE3, by which it follows their mean."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.nastran.cards import Cards
from preprocessing.foreign_files.nastran.grid import Grid
from preprocessing.foreign_files.nastran.numbers import one_number
from toolkit.foundation.errors import InputError

NUMBER, WEIGHT = re.compile(r"\d+"), re.compile(r"[+-]?(\d+\.\d*|\.\d+)([ED]?[+-]?\d+)?")
ENDS = ("UM", "ALPHA", "THERM", "TREF")
"""Words behind which a card has no more nodes that it ties."""


class Tie(NamedTuple):
    """Rigid element."""

    name: str
    place: str  # of the card, in words
    nodes: tuple[int, ...]  # labels of all its nodes; RBE3: those that the reference node follows
    reference: int  # RBE3: the node that follows; RBE2: the one that leads
    holds: bool  # whether all translations are tied, and weights are equal


class Carriers(NamedTuple):
    """Nodes of the body that a mass moves with."""

    nodes: np.ndarray  # places among the points
    rigid: bool  # see `PointMass`
    by: str  # name of the card that ties it to them; empty for its own node


def carriers_of(label: int, ties: Callable[[], Sequence[Tie]], grid: Grid, in_body: np.ndarray, place: str) -> Carriers:
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
        return Carriers(own, True, "")
    found = [tie for tie in ties() if label == tie.reference or (tie.name != "RBE3" and label in tie.nodes)]
    if len(found) != 1 or not found[0].holds:
        several = f"{len(found)} rigid elements tie it to others"
        why = several if len(found) != 1 else f"{found[0].name} ties it, but leaves translations free or weighs its nodes"
        raise InputError(
            f"{place}: the mass is on node {label}, which has no element of the body, and {why}. Put it on a node of the body, tie it "
            'by one RBE2, or by one RBE3 with equal weights, or leave it out: leave_out = ["CONM2"] in [mesh].'
        )
    return _carriers(found[0], label, grid, in_body)


def _carriers(tie: Tie, label: int, grid: Grid, in_body: np.ndarray) -> Carriers:
    places = grid.places(np.array([node for node in dict.fromkeys((*tie.nodes, tie.reference)) if node != label], np.int64))
    inside = (places >= 0) & in_body[places]
    if not inside.any() or (tie.name == "RBE3" and not inside.all()):
        raise InputError(
            f"{tie.place}: {tie.name} ties a mass to nodes that no element of the body has. Tie it to nodes of the body."
        )
    return Carriers(places[inside], tie.name != "RBE3", tie.name)


def ties_of(cards: Cards) -> Iterator[Tie]:
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


def _rbe2(name: str, place: str, words: list[str]) -> Tie:
    nodes = [each for each in words[3:] if each]
    if nodes and WEIGHT.fullmatch(nodes[-1]):  # coefficient of thermal expansion
        nodes = nodes[:-1]
    return Tie(name, place, tuple(map(_number, nodes)), _number(words[1]), _translations(words[2]))


def _rbar(name: str, place: str, words: list[str]) -> Tie:
    one, other = _number(words[1]), _number(words[2])
    free = words[3:5] + [""] * (2 - len(words[3:5]))
    return Tie(name, place, (one, other), one, any(set(each) >= set("123456") for each in free))


def _rbe3(name: str, place: str, words: list[str]) -> Tie:
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
    return Tie(name, place, tuple(nodes), _number(words[2]), holds and len(weights) == 1)


def _number(text: str) -> int:
    if not NUMBER.fullmatch(text) or len(text) > 18:
        raise ValueError("no whole number")
    return int(text)


def _translations(components: str) -> bool:
    """Whether the three translations are among the components."""
    if not NUMBER.fullmatch(components):
        raise ValueError("no components")
    return set(components) >= set("123")
