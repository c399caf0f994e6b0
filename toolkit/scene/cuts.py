"""Cuts of a body into parts: as its `frames` say, and where its chains of elements meet."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from toolkit.bodies.model_body import refuse_unknown
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.cut.chain import breaks, chain_nodes, node_labels, place_of
from toolkit.reduced_model.model import ReducedModel


def cuts_of(name: str, body: Any, model: ReducedModel) -> list[int]:
    """First elements of all parts, and the number of all elements.

    Where chains of elements meet there is always a cut.
    """
    assert model.elements is not None
    count, forced, what = len(model.elements.connectivity), breaks(model.elements.connectivity), model.elements_called
    if isinstance(body.frames, int):
        if body.frames > count:
            raise InputError(
                f"bodies.{name}.frames = {body.frames}, but its reduced model {body.model!r} has {count} {what}, and a frame needs one "
                f"at least. Write at most {count}, or build the model with more {what}."
            )
        if body.frames <= len(forced):
            raise InputError(
                f"bodies.{name}.frames = {body.frames}, but the elements of its reduced model {body.model!r} branch, close or turn round: "
                f"they are {len(forced) + 1} chains, and each needs a frame. Write at least {len(forced) + 1}."
            )
        return _shared([0, *forced, count], body.frames)
    inner = sorted(_node(name, model, place) for place in body.frames)
    for one, other in pairwise([0, *inner, count]):
        if one == other:
            where = "an end of the body" if one in (0, count) else "another cut"
            raise InputError(
                f"bodies.{name}.frames cuts at node {one}, where {where} is already. Name every cut once, and no end."
            )
    return sorted({0, *inner, *forced, count})


def _shared(ends: list[int], frames: int) -> list[int]:
    """First elements of parts, a number of frames, shared among chains that begin and end at `ends`.

    The longest parts always get one more.
    """
    sizes = np.diff(ends)
    shares = np.ones(len(sizes), int)
    for _ in range(frames - len(sizes)):
        shares[np.argmax(sizes / shares)] += 1
    cuts = [
        first + round(k * size / share) for first, size, share in zip(ends, sizes, shares, strict=False) for k in range(share)
    ]
    return [*map(int, cuts), ends[-1]]


def _node(name: str, model: ReducedModel, place: int | str) -> int:
    """Number of the element that begins at a node, given by its number along a chain or by the name of an interface point."""
    assert model.elements is not None
    connectivity = model.elements.connectivity
    count = len(connectivity)
    if isinstance(place, int):
        if chain_nodes(connectivity) is None:
            raise InputError(
                f"bodies.{name}.frames cuts at node {place}, but the elements of reduced model {model.label} branch, close or turn round, "
                "so that nodes have no numbers along them. Name interface points, or write a number of frames."
            )
        if not 0 < place < count:
            raise InputError(
                f"bodies.{name}.frames cuts at node {place}, but the nodes between the ends of the body are 1 to {count - 1}."
            )
        return place
    refuse_unknown(model, place, name)
    point = (model.interfaces or {})[place]
    found = place_of(model.elements, point.here[0][:, 0], f"interface point {place!r}")
    if not found.at_node:
        raise InputError(
            f"bodies.{name}.frames cuts at interface point {place!r}, which lies inside element {found.element} and not at a node. "
            f"Cut at node {found.element} or {found.element + 1}, or put the point at a node in the file that the model is built from."
        )
    return _begun_at(name, connectivity, int(connectivity[found.element, int(found.ratio)]))


def _begun_at(name: str, connectivity: np.ndarray, node: int) -> int:
    """Number of the element that begins at a node and does not end the body there."""
    begun = np.flatnonzero(connectivity[:, 0] == node)
    if np.count_nonzero(connectivity == node) < 2:
        where = node_labels(connectivity)[node]
        raise InputError(
            f"bodies.{name}.frames cuts at node {where}, where an end of the body is already. Name every cut once, and no end."
        )
    return int(begun[begun > 0][0]) if np.any(begun > 0) else breaks(connectivity)[0]
