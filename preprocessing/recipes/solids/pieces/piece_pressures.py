"""Pressures on surfaces of a body in pieces: on the body as a whole, and piece by piece."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from preprocessing.recipes.solids.pieces.piece_columns import MOTIONS, columns_of_piece
from preprocessing.recipes.solids.pieces.placed_items import Placed, Placement, in_row, placed, placement
from toolkit.reduced_model.checks.shapes import SHAPES
from toolkit.reduced_model.elements import SPATIAL_LOCAL
from toolkit.reduced_model.parts.pieces import PieceLoads
from toolkit.reduced_model.spatial_model import SurfaceLoad

Pieces = Sequence[Mapping[str, Any]]
"""Fields of their reduced models."""


def pressed_body(pieces: Pieces) -> dict[str, Any]:
    """Fields of the reduced model, and derivatives that belong to those of the invariants and of the elements."""
    names, count = [*pieces[0]["surface_loads"]], len(pieces)
    whole, every = _in_body(pieces, names), _in_row(pieces, names)
    return {
        "surface_loads": {name: SurfaceLoad(*_arrays(whole, name, (), 1 + MOTIONS * count)) for name in names},
        "piece_loads": {name: PieceLoads(*_arrays(every, name, (count,), 1 + SPATIAL_LOCAL)) for name in names},
        "derivatives": whole.derivatives,
        "element_derivatives": {
            item.replace("surface_loads", "piece_loads", 1): each for item, each in every.derivatives.items()
        },
    }


def _arrays(found: Placed, name: str, first: tuple[int, ...], width: int) -> tuple[Any, Any]:
    force, moment = (found.arrays[f"surface_loads.{name}.{key}"] for key in ("force", "moment"))
    return force.reshape(*first, 3), moment.reshape(*first, 3, 3, width)


def _in_body(pieces: Pieces, names: list[str]) -> Placed:
    places, lengths = [], {"z": 1 + MOTIONS * len(pieces)}
    for k, piece in enumerate(pieces):
        own = dict[str, Placement]()
        for name in names:
            for key, letters in SHAPES[SurfaceLoad].items():
                array = getattr(piece["surface_loads"][name], key)
                own[f"surface_loads.{name}.{key}"] = placement(array, letters, {"z": columns_of_piece(k)}, lengths)
        places.append(own)
    return placed(pieces, places)


def _in_row(pieces: Pieces, names: list[str]) -> Placed:
    places = []
    for k, piece in enumerate(pieces):
        own = dict[str, Placement]()
        for name in names:
            for key in SHAPES[SurfaceLoad]:
                size = getattr(piece["surface_loads"][name], key).size
                own[f"surface_loads.{name}.{key}"] = in_row(k, size, len(pieces))
        places.append(own)
    return placed(pieces, places)
