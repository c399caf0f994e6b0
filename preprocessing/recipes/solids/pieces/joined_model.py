"""The reduced model of a body in pieces: each is an element with two nodes, from which scenes make parts with frames of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.basis.reduction import clamped_in_tangent_frame
from preprocessing.recipes.solids.pieces.cut_mesh import CutMesh
from preprocessing.recipes.solids.pieces.piece_bodies import PieceBodies
from preprocessing.recipes.solids.pieces.piece_columns import CLAMPED, MOTIONS, columns_of_piece
from preprocessing.recipes.solids.pieces.piece_ends import (
    derivatives_of_points,
    interfaces_of_ends,
    numbers_of_points,
    places_of_ends,
)
from preprocessing.recipes.solids.pieces.piece_pressures import pressed_body
from preprocessing.recipes.solids.pieces.piece_surface import piece_surface
from preprocessing.recipes.solids.pieces.placed_items import (
    LEFT_OUT,
    Placed,
    Placement,
    in_row,
    letters_of_items,
    placed,
    placement,
)
from preprocessing.recipes.solids.pieces.uncut_mesh import judged_by_uncut
from preprocessing.recipes.solids.reduced_body import reduced_body
from toolkit.reduced_model.elements import SPATIAL_LOCAL, SpatialElements
from toolkit.reduced_model.spatial_model import PAIRS, SpatialInvariants

COMPONENTS = 6
"""Of stress at a point."""


def joined_model(found: PieceBodies) -> dict[str, Any]:
    """Fields of the reduced model that follow from the pieces, each reduced to the motions of its ends by constraint modes."""
    cut, surface = found.cut, piece_surface(found)
    choice, units = BasisChoice("static"), cut.named.file.units
    pieces = [reduced_body(replace(body, elastic=None), choice, "", units) for body in found.bodies]  # the uncut mesh is judged
    n_stress = len(surface.owner) if len(pieces[0]["invariants"].stress_operator) else 0
    stress = [{"s": rows if n_stress else rows[:0]} for rows in surface.rows]  # where the stress points of every piece go
    whole, every = _in_body(pieces, stress, n_stress), _in_row(pieces, stress, n_stress)
    invariants, nodes = _invariants(whole, len(pieces), n_stress), places_of_ends(pieces)
    width, pressed = invariants.first_moment.shape[1], pressed_body(pieces)
    return {
        **{name: pieces[0][name] for name in ("dimension", "units", "nominal", "nominal_units", "writers")},
        "reference_condition": clamped_in_tangent_frame(f"the nodes of {cut.named.file.clamp and cut.named.file.clamp.words}"),
        "basis": _words(cut),
        "left_out": {
            "interface": min(piece["left_out"]["interface"] for piece in pieces)
        },  # what each leaves out moves none of its ends
        "invariants": invariants,
        "derivatives": whole.derivatives | derivatives_of_points(cut, nodes, width) | pressed.pop("derivatives"),
        "affine": whole.affine,
        "interfaces": interfaces_of_ends(cut, nodes.arrays["nodes"], width),
        "elements": _elements(every, nodes, len(pieces), n_stress),
        "element_derivatives": _of_elements({**every.derivatives, **nodes.derivatives}) | pressed.pop("element_derivatives"),
        "element_affine": _of_elements(every.affine),
        **pressed,
        **surface.fields(pieces, width, n_stress),
        **judged_by_uncut(found.whole, dict(numbers_of_points(cut)), invariants.stiffness),
    }


def _words(cut: CutMesh) -> str:
    groups, faces = ", ".join(piece.group for piece in cut.pieces), cut.named.file.pieces and cut.named.file.pieces.faces
    return f"differentiated: all motions of the ends of the pieces {groups}, {faces} faces between them"


Rows = Sequence[Mapping[str, np.ndarray]]
"""Of every piece."""


def _in_body(pieces: Sequence[Mapping[str, Any]], stress: Rows, n_stress: int) -> Placed:
    """The invariants of the body: sums of those of the pieces on its coordinates."""
    lengths, places = {"z": 1 + MOTIONS * len(pieces), "f": MOTIONS * len(pieces), "s": n_stress}, []
    for k, piece in enumerate(pieces):
        inv, columns = piece["invariants"], columns_of_piece(k)
        numbers = {"z": columns, "f": np.where(columns[1:] >= 0, columns[1:] - 1, LEFT_OUT), **stress[k]}
        letters = letters_of_items(inv)
        places.append({item: placement(getattr(inv, item), letters[item], numbers, lengths) for item in letters})
    return placed(pieces, places)


def _in_row(pieces: Sequence[Mapping[str, Any]], stress: Rows, n_stress: int) -> Placed:
    """The invariants of every piece one after the other; the stress of every point once."""
    places = []
    for k, piece in enumerate(pieces):
        inv, own = piece["invariants"], dict[str, Placement]()
        for item, letters in letters_of_items(inv).items():
            array = getattr(inv, item)
            own[item] = in_row(k, array.size, len(pieces))
            if item == "stress_operator":
                own[item] = placement(array, letters, stress[k], {"s": n_stress})
        places.append(own)
    return placed(pieces, places)


def _invariants(whole: Placed, count: int, n_stress: int) -> SpatialInvariants:
    n_f = MOTIONS * count
    shapes = {
        "mass": (),
        "first_moment": (3, 1 + n_f),
        "second_moment": (len(PAIRS), 1 + n_f, 1 + n_f),
        "stiffness": (n_f, n_f),
        "damping": (n_f, n_f),
        "stress_operator": (n_stress, COMPONENTS, n_f),
    }
    return SpatialInvariants(**{name: whole.arrays[name].reshape(shape) for name, shape in shapes.items()})


def _elements(every: Placed, nodes: Placed, count: int, n_stress: int) -> SpatialElements:
    width = 1 + SPATIAL_LOCAL
    shapes = {
        "mass": (count,),
        "first_moment": (count, 3, width),
        "second_moment": (count, len(PAIRS), width, width),
        "stiffness": (count, SPATIAL_LOCAL, SPATIAL_LOCAL),
        "damping": (count, SPATIAL_LOCAL, SPATIAL_LOCAL),
        "stress_operator": (n_stress * COMPONENTS, SPATIAL_LOCAL),
    }
    connectivity = np.column_stack([np.arange(count), np.arange(count) + 1])
    sums = {name: every.arrays[name].reshape(shape) for name, shape in shapes.items()}
    return SpatialElements(nodes.arrays["nodes"].reshape(-1, 3), connectivity, np.array([CLAMPED]), **sums)


def _of_elements(items: Mapping[str, Any]) -> dict[str, Any]:
    return {f"elements.{name}": each for name, each in items.items()}
