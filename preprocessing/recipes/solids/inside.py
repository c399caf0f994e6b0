"""The inside of a plane meshed body for pictures: its nodes, triangles between them, and the stress there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from preprocessing.elements.solids.stress_error import Elastic
from preprocessing.mesh.solid_mesh import SolidMesh
from toolkit.reduced_model.parts.interior import Interior

TRIANGLES = {
    "triangle": ((0, 1, 2),),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad": ((0, 1, 2), (0, 2, 3)),
    "quad8": ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 7), (5, 6, 7)),
    "quad9": ((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)),
}
"""Places among the nodes of an element, in the order of mesh files."""
LARGEST = 3_000_000
"""Numbers of the stress beyond which there is none: bodies that keep all coordinates of a fine mesh would fill their file with it."""


def inside(body: Elastic | None, mesh: SolidMesh, z: np.ndarray, parameters: Sequence[str]) -> Interior | None:
    """The part `interior` of a reduced model; none without elements or where it is too large.

    Parameters
    ----------
    body : with Lame's constants in parts of the modulus
    z : Z = [xi, Psi] (n, 1 + n_f)
    parameters : names of all, among them the modulus
    """
    if body is None or mesh.dimension != 2 or 4 * len(mesh.nodes) * z.shape[1] > LARGEST:
        return None
    every = np.concatenate([block[:, TRIANGLES[kind]].reshape(-1, 3) for kind, block in mesh.blocks.items()])
    points, triangles = np.unique(every, return_inverse=True)
    stress = nodal_stress(body, z[:, 1:])[points]
    modulus = np.array(list(parameters).index("youngs_modulus"))
    return Interior(z.reshape(-1, 2, z.shape[1])[points], triangles.reshape(every.shape), stress, modulus)


def nodal_stress(body: Elastic, displacements: np.ndarray) -> np.ndarray:
    """Components xx, yy, zz, xy at all nodes, the mean of the elements that meet there, of displacements (n, k); (n_nodes, 4, k)."""
    moved = displacements.reshape(len(body.nodes), 2, -1)
    total, meeting = np.zeros((len(body.nodes), 2, 2, moved.shape[2])), np.zeros(len(body.nodes))
    for block in body.blocks:
        functions = block.functions_at(block.shapes.doflocs.T)
        np.add.at(total, block.connectivity, body.stress(block, functions, moved[block.connectivity]))
        np.add.at(meeting, block.connectivity, 1.0)
    mean = total / np.maximum(meeting, 1.0)[:, None, None, None]
    xx, yy, xy = mean[:, 0, 0], mean[:, 1, 1], mean[:, 0, 1]
    return np.stack([xx, yy, body.across * (xx + yy), xy], axis=1)
