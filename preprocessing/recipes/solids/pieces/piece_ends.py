"""Where the ends of the pieces are, and the interface points of the body, each of which is an end."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from preprocessing.recipes.solids.pieces.cut_mesh import CutMesh
from preprocessing.recipes.solids.pieces.piece_bodies import ENDS
from preprocessing.recipes.solids.pieces.piece_columns import CLAMPED, MOTIONS, columns_of_end
from preprocessing.recipes.solids.pieces.placed_items import LEFT_OUT, Placed, Placement, placed
from toolkit.reduced_model.dependence import Derivatives
from toolkit.reduced_model.model import InterfacePoint


def places_of_ends(pieces: Sequence[Mapping[str, Any]]) -> Placed:
    """The item `nodes`, (3 n_ends,): each end where the piece behind it has it, the last one where the last piece has it."""
    places, count = [], len(pieces) + 1
    for k, piece in enumerate(pieces):
        own = {}
        for number, name in zip((k, k + 1), ENDS, strict=True):
            to = np.full(piece["interfaces"][name].position.shape, LEFT_OUT)
            if number == k or number == count - 1:
                to[0, :, 0] = 3 * number + np.arange(3)
            own[f"interfaces.{name}.position"] = Placement(to.ravel(), 3 * count)
        places.append(own)
    found = placed(pieces, places)
    slopes = [each for each in found.derivatives.values() if len(each.entry)]
    nodes = np.sum([*found.arrays.values()], axis=0)
    return Placed({"nodes": nodes}, {"nodes": sum(slopes[1:], slopes[0])} if slopes else {}, {})


def numbers_of_points(cut: CutMesh) -> Iterator[tuple[str, int]]:
    """Interface points in the order of the file, and the numbers of their ends."""
    numbers = {end.point: k for k, end in enumerate(cut.ends) if end.point}
    yield from ((name, numbers[name]) for name in cut.named.file.interface_points)


def interfaces_of_ends(cut: CutMesh, nodes: np.ndarray, width: int) -> dict[str, InterfacePoint]:
    """Their motions are coordinates of the body, or none at the clamp."""
    found = {}
    for name, number in numbers_of_points(cut):
        z = np.zeros((MOTIONS, width))
        z[:3, 0] = nodes.reshape(-1, 3)[number]
        if number != CLAMPED:
            z[:, columns_of_end(number)] = np.eye(MOTIONS)
        found[name] = InterfacePoint(np.zeros(()), np.zeros(2), *z.reshape(2, 1, 3, width))
    return found


def derivatives_of_points(cut: CutMesh, nodes: Placed, width: int) -> dict[str, Derivatives]:
    """Of the places of interface points, by what moves the ends."""
    found = {}
    for name, number in numbers_of_points(cut):
        for slope in nodes.derivatives.values():
            here = slope.entry // 3 == number
            if np.any(here):
                entry = width * (slope.entry[here] % 3)
                found[f"interfaces.{name}.position"] = Derivatives(slope.parameter[here], entry, slope.value[here])
    return found
