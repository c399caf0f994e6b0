"""The parts of a reduced model that a spatial body's surface gives: its points and triangles, and pressures on it."""

from __future__ import annotations

import numpy as np

from preprocessing.mesh.faces import BoundaryFaces
from toolkit.reduced_model.spatial_model import Surface, SurfaceLoad


def surface_of(faces: BoundaryFaces, z: np.ndarray) -> Surface:
    """Surface of a body for Z = [xi, Psi] (n, 1 + n_f): its nodes and triangles."""
    return Surface(z.reshape(-1, 3, z.shape[1])[faces.points], faces.triangles, np.zeros((0, 2), int))


def pressure_on(normals: np.ndarray, z: np.ndarray) -> SurfaceLoad:
    """Unit pressure on a surface: f_a = -sum_k w_ka and L[a, b] = -sum_k w_ka Z_kb for the nodes k.

    Parameters
    ----------
    normals : w (n_nodes, 3), int N_k n dA over the surface, see `BoundaryFaces.normals`; real or complex, as Z
    """
    return SurfaceLoad(-normals.sum(axis=0), -np.einsum("ka,kbj->abj", normals, z.reshape(-1, 3, z.shape[1])))
