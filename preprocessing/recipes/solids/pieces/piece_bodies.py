"""The pieces of a body as meshes of their own that nothing holds, ready for the choice of a basis."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from preprocessing.input.at_key import at_key
from preprocessing.mesh.faces import BoundaryFaces, faces_of
from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.recipes.solids.discrete_body import DiscreteBody, discretised
from preprocessing.recipes.solids.named_mesh import NamedMesh
from preprocessing.recipes.solids.pieces.cut_mesh import CutMesh, Piece, cut_mesh

ENDS = ("first", "second")
"""Names of the interface points at the ends of a piece, in the order of their coordinates."""


class PieceBodies(NamedTuple):
    """Uncut body, and the pieces in the order of the chain."""

    cut: CutMesh
    whole: DiscreteBody
    bodies: list[DiscreteBody]


def piece_bodies(named: NamedMesh) -> PieceBodies:
    """Uncut body and its pieces, cut from the mesh and assembled.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    with at_key(named.path, "pieces"):
        cut = cut_mesh(named)
    whole, bodies = discretised(named), []
    for piece in cut.pieces:
        with at_key(named.path, f"pieces, group {piece.group!r}"):
            bodies.append(discretised(_named(cut, piece)))
    return PieceBodies(cut, whole, bodies)


def _named(cut: CutMesh, piece: Piece) -> NamedMesh:
    """Piece as a mesh of its own."""
    whole, ends = cut.named, dict(zip(ENDS, (cut.ends[k] for k in piece.ends), strict=True))
    blocks = {kind: np.searchsorted(piece.nodes, each) for kind, each in piece.blocks.items()}
    mesh = SolidMesh(whole.mesh.nodes[piece.nodes], blocks, masses=piece.masses)
    regions = {name: end.region for name, end in ends.items()}
    return replace(
        whole,
        file=whole.file.model_copy(update={"clamp": None, "interface_points": regions, "pieces": None}),
        mesh=mesh,
        boundary=faces_of(mesh.nodes, blocks),
        clamped=np.zeros(0, int),
        tied={name: np.searchsorted(piece.nodes, end.nodes) for name, end in ends.items()},
        surfaces={name: _on_piece(faces, piece, mesh) for name, faces in whole.surfaces.items()},
        motions={name: motion[piece.nodes] for name, motion in whole.motions.items()},
    )


def _on_piece(faces: BoundaryFaces, piece: Piece, mesh: SolidMesh) -> BoundaryFaces:
    """Faces of a body's surface that belong to a piece, in the numbers of the piece's own mesh."""
    own = {kind: np.searchsorted(piece.nodes, each) for kind, each in faces.between(piece.nodes).faces.items()}
    return BoundaryFaces(mesh.nodes, own)
