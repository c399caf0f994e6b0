"""What the uncut mesh tells of its pieces: how wrong the faces between these make it, and how exact the stress of the mesh is.

With the compliance C of the uncut body at its interface points and C_p of the pieces, both with the same clamp and the same points, forces
f have the energy f^T C f / 2. The extreme values of f^T C_p f / f^T C f - 1 over all forces and moments are eigenvalues.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.linalg import eigh

from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.basis.solids.basis import solid_shapes
from preprocessing.basis.solids.ties import freedom
from preprocessing.mesh.solid_mesh import rigid_motions
from preprocessing.recipes.solids.discrete_body import DiscreteBody
from preprocessing.recipes.solids.mesh_error import mesh_error
from toolkit.reduced_model.cut.part import symmetric
from toolkit.reduced_model.questions.face_questions import EXTREMES

ROUND_OFF = 1e-6
"""Error below which it is round-off of both compliances."""


def judged_by_uncut(body: DiscreteBody, ends: Mapping[str, int], stiffness: np.ndarray) -> dict[str, Any]:
    """Fields of the reduced model: `face_errors`, and those of the mesh.

    Parameters
    ----------
    body : uncut
    ends : interface point -> number of its end, the clamp's is zero
    stiffness : of the pieces, on the motions of all ends but the clamped one
    """
    free = freedom(body.mesh, body.clamped, body.ties)
    matrices = body.parts.at(body.values)
    nodal = map(matrices.coordinates.of_nodes, (matrices.mass, matrices.stiffness))
    mass, whole = ((free.map.T @ matrix @ free.map).tocsr() for matrix in nodal)
    motions = free.coordinates_of(rigid_motions(body.mesh.nodes), body.ties)
    places = free.places(body.mesh.nodes, body.ties)
    shapes = solid_shapes(BasisChoice("static"), mass, whole, motions, places, free, body.ties)
    m = body.mesh.motions
    here = np.concatenate([m * (ends[name] - 1) + np.arange(m) for name in shapes.points])
    in_pieces = symmetric(np.linalg.inv(stiffness)[np.ix_(here, here)])
    uncut = symmetric(np.linalg.inv(shapes.columns.T @ (whole @ shapes.columns)))
    extremes = eigh(in_pieces, uncut, eigvals_only=True)[[0, -1]] - 1
    loads = [f"{what} {axis} at {name}" for name in shapes.points for what in ("force", "moment") for axis in "xyz"]
    found = {
        **dict(zip(EXTREMES, extremes, strict=True)),
        **dict(zip(loads, np.diag(in_pieces) / np.diag(uncut) - 1, strict=True)),
    }
    errors = {name: float(error) if abs(error) > ROUND_OFF else 0.0 for name, error in found.items()}
    return {"face_errors": errors, **mesh_error(body.elastic, mass, whole, free, shapes)}
