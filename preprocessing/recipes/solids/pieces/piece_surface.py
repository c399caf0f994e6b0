"""The surface of a body in pieces: every point is told by the first piece that has it, its place and its stress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from preprocessing.mesh.faces import BoundaryFaces
from preprocessing.recipes.solids.pieces.piece_bodies import PieceBodies
from preprocessing.recipes.solids.pieces.piece_columns import columns_of_piece
from preprocessing.recipes.solids.pieces.placed_items import LEFT_OUT
from toolkit.reduced_model.elements import SPATIAL_LOCAL
from toolkit.reduced_model.model import StressPoints
from toolkit.reduced_model.parts.pieces import Pieces
from toolkit.reduced_model.spatial_model import Surface


class PieceSurface(NamedTuple):
    """Who tells what."""

    owner: np.ndarray  # (n_points,) number of the piece
    rows: list[np.ndarray]  # of every point of the surface of each piece its number among those of the body, or `LEFT_OUT`
    triangles: np.ndarray

    def fields(self, pieces: Sequence[Mapping[str, Any]], width: int, n_stress: int) -> dict[str, Any]:
        """Of the reduced model: surface, pieces, and the stress points, one to each point of the surface or none."""
        surface, own = np.zeros((len(self.owner), 3, width)), np.zeros((len(self.owner), 3, 1 + SPATIAL_LOCAL))
        for k, (piece, rows) in enumerate(zip(pieces, self.rows, strict=True)):
            here, columns = rows >= 0, columns_of_piece(k)
            moved, kept = piece["surface"].position[here], columns >= 0
            own[rows[here]] = moved
            surface[np.ix_(rows[here], np.arange(3), columns[kept])] = moved[:, :, kept]
        told = self.owner[:n_stress]
        return {
            "surface": Surface(surface, self.triangles, np.zeros((0, 2), int)),
            "pieces": Pieces(self.owner, own),
            "stress": StressPoints(told, np.zeros_like(told), np.ones_like(told)),
        }


def piece_surface(found: PieceBodies) -> PieceSurface:
    """The points of the surface of the uncut body, shared among the pieces."""
    cut, whole = found.cut, found.cut.named.boundary
    points = whole.points
    owner = np.full(len(points), LEFT_OUT)
    for k, piece in reversed([*enumerate(cut.pieces)]):
        owner[np.isin(points, piece.nodes)] = k
    rows = []
    for k, (piece, body) in enumerate(zip(cut.pieces, found.bodies, strict=True)):
        assert isinstance(body.boundary, BoundaryFaces)
        mine = piece.nodes[body.boundary.points]
        place = np.searchsorted(points, mine).clip(max=len(points) - 1)
        rows.append(np.where((points[place] == mine) & (owner[place] == k), place, LEFT_OUT))
    return PieceSurface(owner, rows, whole.triangles)
